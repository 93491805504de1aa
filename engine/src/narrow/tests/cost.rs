//! Cost of a call. Ignored: a figure to print, not to gate on.

use super::*;
use std::hint::black_box;
use std::time::Instant;

fn print_cost(name: &str, a: &Part, b: &Part, poses: &[Similarity]) {
    let mut hints = vec![0; poses.len()];
    let mut out = Manifold::default();
    let (mut best, mut points) = (f64::MAX, 0);
    for _ in 0..20 {
        let start = Instant::now();
        points = 0;
        for (pose, hint) in poses.iter().zip(&mut hints) {
            out.clear();
            collide(black_box(a), black_box(b), black_box(pose), hint, &mut out);
            points += out.len();
        }
        best = best.min(start.elapsed().as_secs_f64() / poses.len() as f64);
    }
    println!("{name}: {:.0} ns, {:.2} points", best * 1e9, points as f64 / poses.len() as f64);
}

#[test]
#[ignore = "prints timings"]
fn cost_of_a_call() {
    let mut random = Random(40);
    for (name, shape, top) in [("cube", cube(), 0.5), ("pinacoid", pinacoid(1.0), 0.5)] {
        let face: Vec<Similarity> = (0..2_000)
            .map(|_| {
                let turn = rotation(random.direction(), 1e-6) * rotation(Vec3::z(), random.between(0.0, 6.0));
                Similarity::rigid(
                    turn,
                    Vec3::new(random.between(-0.3, 0.3), random.between(-0.3, 0.3), 2.0 * top - 1e-3),
                )
            })
            .collect();
        let any: Vec<Similarity> = (0..2_000)
            .map(|_| Similarity::rigid(random.rotation(), random.direction() * random.between(0.9, 1.2)))
            .collect();
        let (touching, apart): (Vec<Similarity>, Vec<Similarity>) =
            any.into_iter().partition(|pose| !contacts(&shape, &shape, pose).is_empty());
        print_cost(&format!("{name}, face on face"), &shape, &shape, &face);
        print_cost(&format!("{name}, touching in any pose"), &shape, &shape, &touching);
        print_cost(&format!("{name}, apart, with hint"), &shape, &shape, &apart);
    }
}
