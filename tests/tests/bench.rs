//! The benchmark program on a few dozen particles: every workload settles, is measured, and says how good it was.

use sturz_tests::bench::{NormalLaw, Plan, Size, Workload, left_out, measure, settled};

#[test]
fn every_workload_runs_small() {
    let plan = Plan { threads: 2, steps: 20, blocks: 5, normal: NormalLaw::GeneralizedOverlap, warm_up: 20, tiles: 1 };
    for name in Workload::NAMES {
        let workload = Workload::named(name, Size::Small).unwrap();
        let bed = settled(&workload, 2, &mut |_| {}).unwrap();
        let result = measure(&workload, &bed, &plan).unwrap();
        assert_eq!(result.particles, u64::from(workload.count), "{name}");
        assert!(
            result.touching_pairs + result.touching_boundary_pairs > 0 && result.particle_steps_per_s > 0.0,
            "{name}: {result:?}"
        );
        assert!(result.largest_overlap_ratio < 0.3, "{name}: {result:?}");
    }
}

#[test]
fn what_is_left_out_is_timed_small() {
    for name in ["W1", "W2-cubes"] {
        let workload = Workload::named(name, Size::Small).unwrap();
        let bed = settled(&workload, 2, &mut |_| {}).unwrap();
        let rows = left_out(&workload, &bed, 2, 50).unwrap();
        assert_eq!(rows.len(), 6, "{name}: {rows:?}");
        assert!(
            rows.iter().all(|row| [row.off, row.on, row.noise].iter().flatten().all(|x| x.is_finite() && *x > 0.0))
        );
    }
}
