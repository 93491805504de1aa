//! The benchmark program on a few dozen particles: every workload settles, is measured, and says how good it was.

use sturz_tests::bench::{NormalLaw, Plan, Size, Workload, measure, settled};

#[test]
fn every_workload_runs_small() {
    let plan = Plan { threads: 2, steps: 20, blocks: 5, normal: NormalLaw::GeneralizedOverlap, warm_up: 20 };
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
