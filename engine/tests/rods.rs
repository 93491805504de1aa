//! Spherocylinders and spheres among each other in whole runs: what their pairs know does not show in the bits.

mod common;

use common::{engine, hashes_of};

/// Slender and stout rods with balls among them, in a turning drum that is periodic along its axis.
fn drum() -> String {
    let mut text = String::from(
        r#"
[scene]
name = "drum"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 2e-5
seed = 5
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
    let rod = |radius: f64, length: f64| {
        format!("kind = \"spherocylinder\", radius_m = {radius:?}, total_length_m = {length:?}")
    };
    let shapes =
        [("rod", rod(1e-3, 6e-3)), ("stout", rod(1.5e-3, 4e-3)), ("ball", "kind = \"sphere\", radius_m = 2e-3".into())];
    for (k, (name, geometry)) in shapes.iter().enumerate() {
        let z = -0.022 + 0.012 * k as f64;
        text += &format!(
            "[[shape]]\nname = \"{name}\"\ngeometry = {{ {geometry} }}\n[[insertion]]\nshape = \"{name}\"\nmaterial = \"m\"\nscale = {{ min = 0.8, max = 1.2 }}\n\
             placement = {{ method = \"random\", count = 40, region = {{ kind = \"box\", min_m = [-0.014, -0.015, {z:?}], max_m = [0.014, 0.015, {:?}] }} }}\n",
            z + 0.0115
        );
    }
    text
}

fn hashes(threads: usize, drop_caches_every: u64) -> Vec<u64> {
    let mut engine = engine(&drum());
    let hashes = hashes_of(&mut engine, (4, 1500), threads, drop_caches_every);
    let report = engine.report();
    assert!(report.contact_points > 100 && report.neighbour_rebuilds > 10, "{report:?}");
    // rods side by side touch at the ends of the stretch that they share
    assert!(report.contact_points_by_kind[0] > 0 && report.contact_points_by_kind[1] > 0, "{report:?}");
    hashes
}

#[test]
fn threads_and_what_pairs_know_are_invisible_in_the_bits() {
    let reference = hashes(1, 0);
    assert_eq!(hashes(2, 0), reference);
    assert_eq!(hashes(2, 37), reference);
    assert_eq!(hashes(1, 1), reference);
}
