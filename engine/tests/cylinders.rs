//! Cylinders in whole runs: bits, energy, stacks, what they are refused with.

mod common;

use common::{engine, header, particle, plane, shape, steps};
use sturz_engine::scene::{Scene, SceneDescription};

const CYLINDER: &str = "kind = \"cylinder\", radius_m = 1.5e-3, length_m = 3e-3";

/// Cylinders, composites of them, spheres, rods and cubes in a turning drum that is periodic along its axis.
fn drum() -> String {
    let arm = "shape = { kind = \"cylinder\", radius_m = 7e-4, length_m = 5e-3 }";
    let cross = format!(
        "kind = \"composite\", parts = [{{ {arm} }}, {{ {arm}, orientation_wxyz = [0.7071067811865476, 0.0, 0.0, 0.7071067811865476] }}]"
    );
    let shapes = [
        ("cylinder", CYLINDER.to_owned()),
        ("coin", "kind = \"cylinder\", radius_m = 2e-3, length_m = 8e-4".into()),
        ("cross", cross),
        ("ball", "kind = \"sphere\", radius_m = 2e-3".into()),
        ("rod", "kind = \"spherocylinder\", radius_m = 1e-3, total_length_m = 5e-3".into()),
        ("cube", "kind = \"cube\", edge_m = 3e-3".into()),
    ];
    let mut text = String::from(
        r#"
[scene]
name = "drum"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 1e-5
seed = 3
[domain]
min_m = [0.0, -0.012, 0.0]
max_m = [0.0, 0.012, 0.0]
periodic = [false, true, false]
[[material]]
name = "m"
density_kg_per_m3 = 2470.0
[[material_pair]]
materials = ["m", "m"]
stiffness_n_per_m = 2e3
restitution = 0.6
friction = 0.5
[[boundary]]
name = "drum"
material = "m"
geometry = { kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.03 }
motion = { kind = "rotation", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], angular_velocity = { kind = "constant", rad_per_s = 4.0 } }
"#,
    );
    for (k, (name, geometry)) in shapes.iter().enumerate() {
        let z = -0.022 + 0.0075 * k as f64;
        text += &format!(
            "[[shape]]\nname = \"{name}\"\ngeometry = {{ {geometry} }}\n[[insertion]]\nshape = \"{name}\"\nmaterial = \"m\"\n\
             placement = {{ method = \"random\", count = 10, region = {{ kind = \"box\", min_m = [-0.012, -0.012, {z:?}], max_m = [0.012, 0.012, {:?}] }} }}\n",
            z + 0.0072
        );
    }
    text
}

fn hashes(threads: usize, drop_caches_every: u64) -> Vec<u64> {
    let mut engine = engine(&drum());
    engine.set_threads(threads);
    let mut hashes = Vec::new();
    for _ in 0..4 {
        for _ in 0..5000 / drop_caches_every {
            steps(&mut engine, drop_caches_every);
            engine.drop_caches();
        }
        hashes.push(engine.state_hash());
    }
    let report = engine.report();
    assert!(report.contact_points > 40 && report.neighbour_rebuilds > 10, "{report:?}");
    assert!(report.largest_overlap_ratio_so_far < 0.2, "{report:?}");
    let energy = &report.energy;
    assert!(energy.residual_j.abs() < 0.02 * energy.dissipated_normal_j, "{energy:?}");
    hashes
}

#[test]
fn threads_and_caches_are_invisible_in_the_bits() {
    let reference = hashes(1, 5000);
    assert_eq!(hashes(2, 5000), reference);
    assert_eq!(hashes(4, 5), reference);
}

/// A tower of five, alternately upright cylinders and cubes: it stands, and carries its weight.
#[test]
fn a_tower_of_cylinders_and_cubes_stands() {
    let pair = "stiffness_n_per_m = 1e6\nrestitution = 0.3\nfriction = 0.5";
    let mut text = header([0.0, 0.0, -9.81], 1e-5, "", pair) + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    text += "[[shape]]\nname = \"c\"\ngeometry = { kind = \"cylinder\", radius_m = 0.05, length_m = 0.1 }\n";
    text += "[[shape]]\nname = \"b\"\ngeometry = { kind = \"cube\", edge_m = 0.1 }\n";
    let half = 0.5f64.sqrt();
    for k in 0..5 {
        let (name, q) = if k % 3 == 2 { ("b", [1.0, 0.0, 0.0, 0.0]) } else { ("c", [half, 0.0, half, 0.0]) };
        let z = 0.05 + 0.1 * f64::from(k);
        text += &format!(
            "[[insertion]]\nshape = \"{name}\"\nmaterial = \"m\"\nplacement = {{ method = \"poses\", \
             positions_m = [[{:?}, 0.0, {z:?}]], orientations_wxyz = [{q:?}] }}\n",
            1e-3 * f64::from(k % 2)
        );
    }
    let mut engine = engine(&text);
    steps(&mut engine, 250_000);
    let report = engine.report();
    let mass = engine.scene().particles().iter().map(|p| p.mass).sum::<f64>();
    let energy = &report.energy;
    let kinetic = energy.kinetic_translation_j + energy.kinetic_rotation_j;
    assert!(kinetic < 1e-9 * mass * 9.81 * 0.1, "{kinetic:e}");
    assert_eq!((report.touching_boundary_pairs, report.touching_pairs), (1, 4));
    assert!((report.largest_overlap_m / (mass * 9.81 / 1e6) - 1.0).abs() < 0.15, "{report:?}");
}

/// Three cylinders in a pile on the floor come to rest.
#[test]
fn a_pile_of_lying_cylinders_rests() {
    let pair = "stiffness_n_per_m = 1e6\nrestitution = 0.3\nfriction = 0.5";
    let mut text = header([0.0, 0.0, -9.81], 1e-5, "", pair)
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + &plane("left", [-0.1001, 0.0, 0.0], [1.0, 0.0, 0.0])
        + &plane("right", [0.1001, 0.0, 0.0], [-1.0, 0.0, 0.0])
        + &shape("kind = \"cylinder\", radius_m = 0.05, length_m = 0.2");
    let half = 0.5f64.sqrt();
    for x in [[-0.05, 0.0, 0.05], [0.05, 0.0, 0.05], [0.001, 0.0, 0.05 + 0.0867]] {
        text += &format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = {{ method = \"poses\", \
             positions_m = [{x:?}], orientations_wxyz = [[{half:?}, 0.0, 0.0, {half:?}]] }}\n"
        );
    }
    let mut engine = engine(&text);
    steps(&mut engine, 200_000);
    let energy = &engine.report().energy;
    assert!(energy.kinetic_translation_j + energy.kinetic_rotation_j < 1e-10, "{energy:?}");
    assert!(engine.report().touching_pairs >= 2, "the third lies on both");
}

fn refusal(text: &str) -> String {
    let description = SceneDescription::from_toml(text).expect("a readable scene");
    Scene::validate(description).expect_err("a refusal").to_string()
}

#[test]
fn what_does_not_go_with_cylinders_is_refused() {
    let pair = "stiffness_n_per_m = 1e6\nrestitution = 0.3";
    let text = header([0.0; 3], 1e-5, "", pair)
        + &shape(CYLINDER)
        + "[[shape]]\nname = \"r\"\ngeometry = { kind = \"rounded_polyhedron\", radius_m = 1e-4, vertices_m = \
           [[0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]] }\n"
        + &particle([0.0; 3], [0.0; 3], [0.0; 3]);
    let error = refusal(&text);
    assert!(error.contains("shape[0].geometry") && error.contains("cannot meet the rounded polyhedra"), "{error}");
    let hertz = "normal = \"hertz\"\ntangential = \"mindlin\"";
    let text = header([0.0; 3], 1e-5, hertz, "restitution = 0.3")
        .replace("name = \"m\"\n", "name = \"m\"\nyoungs_modulus_pa = 1e7\npoissons_ratio = 0.3\n")
        + &shape(CYLINDER)
        + &particle([0.0; 3], [0.0; 3], [0.0; 3]);
    let error = refusal(&text);
    assert!(error.contains("has a cylinder") && error.contains("hertz"), "{error}");
}
