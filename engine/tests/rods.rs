//! Spherocylinders and spheres among each other in whole runs: what their pairs know does not show in the bits.

mod common;

use common::{Filling, engine, hashes_of, mixed_drum};

/// Slender and stout rods with balls among them, in a turning drum that is periodic along its axis.
fn drum() -> String {
    let rod = |radius: f64, length: f64| {
        format!("kind = \"spherocylinder\", radius_m = {radius:?}, total_length_m = {length:?}")
    };
    let shapes =
        [("rod", rod(1e-3, 6e-3)), ("stout", rod(1.5e-3, 4e-3)), ("ball", "kind = \"sphere\", radius_m = 2e-3".into())];
    mixed_drum(
        2e-5,
        &shapes,
        &Filling {
            count: 40,
            lines: "scale = { min = 0.8, max = 1.2 }",
            half: [0.014, 0.015],
            heights: [0.012, 0.0115],
        },
    )
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
