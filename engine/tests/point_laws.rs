//! Laws of point contacts: what is refused and where, what a plain scene leaves out, the same bits on any threads.

mod common;

use common::{header, particle, plane, shape};
use sturz_engine::Engine;
use sturz_engine::scene::{Scene, SceneDescription};

const BALL: &str = "kind = \"sphere\", radius_m = 0.01";
const PAIR: &str = "stiffness_n_per_m = 1e5\nrestitution = 0.5\nfriction = 0.5";

fn refusal(text: &str) -> String {
    let outcome = SceneDescription::from_toml(text).map(Scene::validate);
    match outcome {
        Ok(Ok(_)) => String::new(),
        Ok(Err(error)) => error.to_string(),
        Err(error) => error.to_string(),
    }
}

fn scene(contact: &str, pair: &str, geometry: &str) -> String {
    header([0.0, 0.0, -9.81], 1e-6, contact, pair) + &shape(geometry) + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
}

#[test]
fn what_does_not_go_together_is_refused_with_its_path() {
    let elastic = "restitution = 0.5";
    for (contact, pair, geometry, path) in [
        ("tangential = \"mindlin\"", PAIR, BALL, "contact.tangential"),
        ("normal = \"hertz\"", elastic, BALL, "contact.tangential"),
        ("normal = \"hertz\"\ntangential = \"none\"", elastic, BALL, "material_pair[0].materials"),
        ("normal = \"hertz\"\ntangential = \"none\"", PAIR, BALL, "material_pair[0].stiffness_n_per_m"),
        (
            "normal = \"hertz\"\ntangential = \"none\"",
            elastic,
            "kind = \"cube\", edge_m = 0.01",
            "material_pair[0].materials",
        ),
        ("", elastic, BALL, "material_pair[0].stiffness_n_per_m"),
        (
            "",
            "stiffness_n_per_m = 1e5\nrestitution = 0.5\nrolling_friction = -0.1",
            BALL,
            "material_pair[0].rolling_friction",
        ),
        (
            "",
            "stiffness_n_per_m = 1e5\nrestitution = 0.5\ncohesion = { kind = \"constant\", force_n = -1.0 }",
            BALL,
            "material_pair[0].cohesion.force_n",
        ),
        (
            "",
            "stiffness_n_per_m = 1e5\nrestitution = 0.5\ntangential_damping_n_s_per_m = 1.0",
            BALL,
            "material_pair[0].tangential_damping_n_s_per_m",
        ),
        ("sharing_scope = \"bodies\"", PAIR, BALL, "contact.sharing_scope"),
        ("hertz = { reference_overlap_fraction = 0.0 }", PAIR, BALL, "contact.hertz.reference_overlap_fraction"),
        (
            "normal = \"generalized_overlap\"\ntangential = \"viscous\"",
            PAIR,
            "kind = \"cube\", edge_m = 0.01",
            "contact.tangential",
        ),
    ] {
        let text = refusal(&scene(contact, pair, geometry));
        assert!(text.contains(path), "{contact} {pair}: no {path} in '{text}'");
    }
    let cube = scene("normal = \"hertz\"\ntangential = \"none\"", elastic, "kind = \"cube\", edge_m = 0.01");
    let cube = cube.replace("density_kg_per_m3 = 2500.0", "density_kg_per_m3 = 2500.0\nyoungs_modulus_pa = 1e9");
    assert!(refusal(&cube).contains("shape[0].geometry"), "{}", refusal(&cube));
    let damped = scene("", PAIR, BALL) + "[integrator]\nlocal_damping = 1.0\n";
    assert!(refusal(&damped).contains("integrator.local_damping"));
}

#[test]
fn a_plain_scene_has_none_of_these_laws() {
    let description = SceneDescription::from_toml(&scene("", PAIR, BALL)).unwrap();
    let written = description.to_toml().unwrap();
    assert!(Scene::validate(description).unwrap().point_laws().is_none());
    for key in ["rolling", "cohesion", "youngs_modulus_pa"] {
        assert!(!written.contains(key), "{key} in {written}");
    }
}

/// Springs that add need a smaller step: a cube face on a wall has 4 points, two faces up to 8.
#[test]
fn the_critical_step_counts_springs_that_add() {
    let critical = |sharing: &str| {
        let contact = format!("normal = \"linear\"\nsharing = \"{sharing}\"");
        let text = scene(&contact, PAIR, "kind = \"cube\", edge_m = 0.01");
        Scene::validate(SceneDescription::from_toml(&text).unwrap()).unwrap().check().critical_time_step_s
    };
    let (one, many) = (critical("model_b"), critical("model_a"));
    // the pair limits: half the mass of a wall contact, twice the springs
    assert!((one / many - 8f64.sqrt()).abs() < 1e-6, "{one} {many}");
}

/// 1, 2 and 4 threads, with every spring that these laws keep.
#[test]
fn equal_bits_on_any_number_of_threads() {
    let viscous = "normal = \"linear\"\nsharing = \"model_a\"\ndamping_mass = \"contact\"\ntangential = \"viscous\"";
    let turning = "stiffness_n_per_m = 1e5\nrestitution = 0.5\nfriction = 0.5\nrolling_friction = 0.1\n\
                   twisting_friction = 0.1\ncohesion = { kind = \"sjkr\", energy_density_j_per_m3 = 1e4 }";
    for (contact, pair, spacing, geometry) in [
        (viscous, turning, 0.0102, "kind = \"cube\", edge_m = 0.01"),
        (
            "normal = \"linear\"\nsharing = \"model_b\"\nsharing_scope = \"bodies\"",
            turning,
            0.0202,
            "kind = \"cross_3d\", beam_length_m = 0.02, beam_width_m = 0.005",
        ),
        (
            "damping_mass = \"contact\"",
            turning,
            0.0201,
            "kind = \"spherocylinder\", radius_m = 0.004, total_length_m = 0.02",
        ),
    ] {
        let mut text = scene(contact, pair, geometry);
        for k in 0..40u32 {
            let [x, y, z] = [k % 4, k / 4 % 4, k / 16].map(|n| spacing * (f64::from(n) + 0.51));
            text += &particle(
                [x, y + 1e-4 * f64::from(k), z],
                [0.3 - 0.1 * f64::from(k % 5), 0.1, -0.5],
                [f64::from(k % 7), 2.0, 1.0],
            );
        }
        text += "[integrator]\nlocal_damping = 0.2\n";
        let hashes: Vec<u64> = [1, 2, 4]
            .into_iter()
            .map(|threads| {
                let scene = Scene::validate(SceneDescription::from_toml(&text).unwrap()).unwrap();
                let mut engine = Engine::new(scene);
                engine.set_threads(threads);
                for step in 0..3000 {
                    engine.step().unwrap();
                    if threads == 4 && step % 97 == 0 {
                        engine.drop_caches();
                    }
                }
                assert!(engine.report().largest_overlap_ratio_so_far > 0.0, "{geometry}: nothing touches");
                engine.state_hash()
            })
            .collect();
        assert!(hashes.iter().all(|&hash| hash == hashes[0]), "{geometry}: {hashes:?}");
    }
}
