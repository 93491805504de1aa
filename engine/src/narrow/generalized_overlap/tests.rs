//! The overlap against finite differences, against itself swapped, and its list of terms against all terms.

use super::{ActiveTerms, Core, EdgeFade, Overlap, OverlapGeometry, PNorm, RoundedPair, Scratch, aggregate};
use crate::math::{Mat3, Similarity, Vec3};
use crate::narrow::segment_segment;
use crate::narrow::tests::{Random, cube, part, pinacoid, rotation, solid};
use crate::shape::ShapeDescription;

fn geometry(p: f64) -> OverlapGeometry {
    OverlapGeometry { norm: PNorm::new(p), fade: EdgeFade { angle_factor: 2.0, reach_factor: 0.5 } }
}

/// Cores of cube, pinacoid and tetrahedron of size 1 with the rounding radius `r`.
fn cores(r: f64) -> Vec<Core> {
    let tetrahedron = part(&ShapeDescription::Tetrahedron { edge_m: 2f64.sqrt() });
    [cube(), pinacoid(1.0), tetrahedron]
        .iter()
        .map(|part| {
            let size = solid(part).inside().inner_diameter;
            Core::new(solid(part), r / size).expect("a core")
        })
        .collect()
}

/// D and its gradient, without a list.
fn overlap(a: &Core, b: &Core, b_to_a: &Similarity, geometry: &OverlapGeometry) -> Overlap {
    let mut terms = Vec::new();
    RoundedPair { a, b, b_to_a, geometry }.all_terms(&mut terms);
    if terms.is_empty() { Overlap::default() } else { aggregate(&terms, &geometry.norm, &mut Vec::new()) }
}

/// Deepest overlap of the rounded bodies: R less the distance of the cores, all features counted in full.
fn deepest(a: &Core, b: &Core, b_to_a: &Similarity) -> f64 {
    let vertices_b = b.solid().vertices().iter().map(|v| a.project(&b_to_a.point(v)).1);
    let vertices_a = a.solid().vertices().iter().map(|v| b.project(&b_to_a.inverse_point(v)).1 * b_to_a.scale);
    let mut least = vertices_b.chain(vertices_a).fold(f64::MAX, f64::min);
    for e in 0..a.solid().edges().len() {
        for f in 0..b.solid().edges().len() {
            let (x, y) = segment_segment(&a.edge(e), &b.edge(f).map(|x| b_to_a.point(&x)));
            least = least.min((y - x).norm());
        }
    }
    a.radius + b.radius * b_to_a.scale - least
}

/// Orientations of all kinds of contact along z: aligned, yawed, tilted, edges and corners up, anything.
fn turn(kind: usize, random: &mut Random) -> Mat3 {
    use std::f64::consts::FRAC_PI_4;
    let (x, y, z) = (Vec3::x(), Vec3::y(), Vec3::z());
    match kind % 8 {
        0 => Mat3::identity(),
        1 => rotation(z, random.between(0.01, 1.5)),
        2 => rotation(random.direction(), 10f64.powf(random.between(-4.0, -1.0))),
        3 => rotation(x, FRAC_PI_4),
        4 => rotation(y, FRAC_PI_4) * rotation(z, random.between(0.0, 3.0)),
        5 => rotation(Vec3::new(1.0, -1.0, 0.0), (1.0 / 3f64.sqrt()).acos()),
        6 => rotation(z, random.between(0.0, 3.0)) * rotation(x, FRAC_PI_4),
        _ => random.rotation(),
    }
}

/// A pose in which the deepest overlap is `depth`, approached along z from random sideways offsets.
fn touching(a: &Core, b: &Core, kinds: [usize; 2], depth: f64, random: &mut Random) -> Similarity {
    let first = turn(kinds[0], random).transpose();
    let relative = first * turn(kinds[1], random);
    let sideways = if kinds[0] == 0 && kinds[1] == 0 && random.unit() < 0.3 { 0.0 } else { random.between(0.0, 0.5) };
    let angle = random.between(0.0, 6.3);
    let at = |height: f64| {
        let x = Vec3::new(sideways * angle.cos(), sideways * angle.sin(), height);
        Similarity::rigid(relative, first * x)
    };
    let (mut low, mut high) = (0.5, 3.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if deepest(a, b, &at(middle)) > depth { low = middle } else { high = middle }
    }
    at(high)
}

/// Two edges that cross at a small or large angle, near their ends or not, their faces facing each other.
fn crossing(a: &Core, b: &Core, depth: f64, random: &mut Random) -> Similarity {
    let outwards = |core: &Core, e: usize| {
        let [f, g] = core.solid().edges()[e].faces.map(|f| core.solid().faces()[f as usize].normal);
        (f + g).normalize()
    };
    let (e, f) = (random.below(a.solid().edges().len()), random.below(b.solid().edges().len()));
    let (up, down) = (outwards(a, e), outwards(b, f));
    let frame = |up: Vec3, along: Vec3| Mat3::from_columns(&[along, up.cross(&along), up]);
    let angle = if random.unit() < 0.6 { 10f64.powf(random.between(-4.0, -1.0)) } else { random.between(0.0, 3.1) };
    let direction = rotation(up, angle) * a.solid().edges()[e].direction;
    let relative = frame(up, direction) * frame(-down, b.solid().edges()[f].direction).transpose();
    let mut on_edge = |core: &Core, e: usize| {
        let [p, q] = core.edge(e);
        let s = if random.unit() < 0.5 { random.below(2) as f64 + random.between(-4e-3, 4e-3) } else { random.unit() };
        p + (q - p) * s
    };
    let (x, y) = (on_edge(a, e), on_edge(b, f));
    let gap = a.radius + b.radius - depth;
    Similarity::rigid(relative, x + up * gap - relative * y)
}

/// The pose after a small motion of `b`: translation along, or rotation about the centre of `b` and, an axis of `a`.
fn moved(pose: &Similarity, direction: usize, by: f64) -> Similarity {
    let axis = Vec3::ith(direction % 3, 1.0);
    if direction < 3 {
        return Similarity { translation: pose.translation + axis * by, ..*pose };
    }
    Similarity { rotation: rotation(axis, by) * pose.rotation, ..*pose }
}

/// Differences of fourth order, at the best of three steps: truncation is (h/angle)^4 where edges cross at a small
/// angle (down to 1e-4), rounding 1e-16/(h angle). Where a line's foot is at the end of its edge as well, the gradient
/// bends within 1e-9 rad, which no difference resolves: one component in 200 may be off by more than 2e-5.
#[test]
fn force_and_torque_are_the_gradient() {
    let mut random = Random(11);
    for (r, p) in [(5e-3, 8.0), (2e-2, 8.0), (5e-3, 2.0), (1e-2, 5.5)] {
        let (cores, geometry) = (cores(r), geometry(p));
        let (mut worst, mut bad, mut edges) = (0.0f64, 0, 0);
        for case in 0..1000 {
            let (a, b) = (&cores[case % 3], &cores[case / 3 % 3]);
            let depth = 2.0 * r * random.between(0.02, 0.95);
            let pose = if case % 2 == 0 {
                touching(a, b, [random.below(8), random.below(8)], depth, &mut random)
            } else {
                crossing(a, b, depth, &mut random)
            };
            let at = overlap(a, b, &pose, &geometry);
            if at.value == 0.0 {
                continue;
            }
            let mut terms = Vec::new();
            RoundedPair { a, b, b_to_a: &pose, geometry: &geometry }.all_terms(&mut terms);
            edges += usize::from(terms.iter().any(|term| term.weight_gradient.is_some()));
            let torque = at.moment - pose.translation.cross(&at.force);
            for direction in 0..6 {
                let d = |by: f64| overlap(a, b, &moved(&pose, direction, by), &geometry).value;
                let slope = |h: f64| (8.0 * (d(h) - d(-h)) - (d(2.0 * h) - d(-2.0 * h))) / (12.0 * h);
                let analytic = if direction < 3 { at.force[direction] } else { torque[direction - 3] };
                let error =
                    [2e-8, 1e-7, 5e-7].map(|h| (slope(h) + analytic).abs()).into_iter().fold(f64::MAX, f64::min);
                let error = error / at.force.norm();
                bad += usize::from(error > 2e-5);
                worst = worst.max(error);
            }
        }
        assert!(edges > 80, "{edges} poses with a varying weight");
        assert!(bad <= 30 && worst < 1e-3, "r {r} p {p}: {worst:e}, {bad} of 6000");
    }
}

/// The other side sees the opposite force on the same line.
#[test]
fn swapping_the_bodies_swaps_the_wrench() {
    let (mut random, cores, geometry) = (Random(5), cores(5e-3), geometry(8.0));
    let mut worst = 0.0f64;
    for case in 0..2000 {
        let (a, b) = (&cores[case % 3], &cores[case / 3 % 3]);
        let depth = 1e-2 * random.between(0.02, 0.95);
        let pose = if case % 2 == 0 {
            touching(a, b, [random.below(8), random.below(8)], depth, &mut random)
        } else {
            crossing(a, b, depth, &mut random)
        };
        let (one, other) = (overlap(a, b, &pose, &geometry), overlap(b, a, &pose.inverse(), &geometry));
        if one.value == 0.0 {
            continue;
        }
        let force = pose.direction(&other.force);
        let moment = pose.direction(&other.moment) + pose.translation.cross(&force);
        let scale = one.force.norm();
        worst = worst.max((one.value - other.value).abs() / one.value);
        worst = worst.max((one.force + force).norm() / scale).max((one.moment + moment).norm() / scale);
    }
    assert!(worst < 1e-9, "{worst:e}");
}

/// Exactly aligned, the force has no moment about either centre, and D is (terms)^(1/p) d.
#[test]
fn aligned_faces_do_not_turn() {
    let geometry = geometry(8.0);
    for core in cores(5e-3).iter().take(1) {
        let pose = Similarity::rigid(Mat3::identity(), Vec3::z() * 0.998);
        let at = overlap(core, core, &pose, &geometry);
        assert!(at.moment.norm() < 1e-15 && at.force.xy().norm() < 1e-15, "{at:?}");
        // eight vertices; the edge pairs at the corners carry half a weight each
        assert!(at.value > 2e-3 * 8f64.powf(0.125) && at.value < 2e-3 * 1.45, "{}", at.value / 2e-3);
    }
}

/// Small jitter about every kind of contact: D stays above 0.4 of the true deepest overlap.
#[test]
fn overlap_is_never_far_below_the_true_one() {
    let (mut random, cores, geometry) = (Random(17), cores(5e-3), geometry(8.0));
    let (mut least, mut most) = (f64::MAX, 0.0f64);
    for case in 0..12_000 {
        let (a, b) = (&cores[case % 3], &cores[case / 3 % 3]);
        let depth = 1e-2 * random.between(0.01, 0.9);
        let pose = if case % 2 == 0 {
            touching(a, b, [random.below(7), random.below(7)], depth, &mut random)
        } else {
            crossing(a, b, depth, &mut random)
        };
        let jitter = rotation(random.direction(), 10f64.powf(random.between(-6.0, -1.5)));
        let pose = Similarity { rotation: jitter * pose.rotation, ..pose };
        let truth = deepest(a, b, &pose);
        if !(1e-5..=1e-2).contains(&truth) {
            continue;
        }
        let ratio = overlap(a, b, &pose, &geometry).value / truth;
        (least, most) = (least.min(ratio), most.max(ratio));
    }
    assert!(least > 0.4 && most < 1.5, "{least} {most}");
}

/// A body that wanders about another: with the list, without it, and with the list dropped at random, to the bit.
#[test]
fn list_of_terms_leaves_no_trace() {
    let (mut random, cores, geometry) = (Random(23), cores(5e-3), geometry(8.0));
    let (mut touching_steps, mut listed) = (0, 0);
    for walk in 0..60 {
        let (a, b) = (&cores[walk % 3], &cores[walk / 3 % 3]);
        let start = touching(a, b, [random.below(8), random.below(8)], 3e-3, &mut random);
        let mut pose = start;
        let (mut kept, mut dropped, mut scratch) = (ActiveTerms::default(), ActiveTerms::default(), Scratch::default());
        let (mut with, mut without) = (Vec::new(), Vec::new());
        let (mut velocity, mut spin) = (random.direction() * 2e-4, random.direction() * 3e-4);
        for _ in 0..400 {
            pose.translation += velocity;
            pose.rotation = rotation(spin, spin.norm()) * pose.rotation;
            // drawn back to where it touched
            velocity += (start.translation - pose.translation) * 0.01 + random.direction() * 3e-5;
            spin += random.direction() * 3e-5;
            let pair = RoundedPair { a, b, b_to_a: &pose, geometry: &geometry };
            pair.all_terms(&mut without);
            kept.evaluate(&pair, &mut scratch, &mut with);
            assert_eq!(with, without);
            if random.unit() < 0.1 {
                dropped.forget();
            }
            dropped.evaluate(&pair, &mut scratch, &mut with);
            assert_eq!(with, without);
            touching_steps += usize::from(!with.is_empty());
            listed += kept.len();
        }
    }
    assert!(touching_steps > 5000 && listed > 0, "{touching_steps} {listed}");
}

/// A cube slides over the rim of another at depth 1e-3 (face, corner, edge, yawed, tilted): the change of the force per
/// step is proportional to the step.
#[test]
fn sliding_over_a_rim_has_no_jump() {
    let (cores, geometry) = (cores(5e-3), geometry(8.0));
    let core = &cores[0];
    let mut random = Random(2);
    let poses = [
        Mat3::identity(),
        rotation(Vec3::z(), 0.3),
        rotation(Vec3::x(), 1e-3),
        rotation(Vec3::y(), std::f64::consts::FRAC_PI_4),
        turn(5, &mut random),
    ];
    for turn in poses {
        let lowest = core.solid().vertices().iter().map(|v| (turn * v).z).fold(f64::MAX, f64::min);
        let height = core.solid().faces().iter().map(|f| f.offset).fold(0.0, f64::max) + 1e-2 - 1e-3 - lowest;
        let largest = |step: f64| {
            let (mut last, mut change, mut most) = (None::<Vec3>, 0.0f64, 0.0f64);
            for k in 0..(0.95 / step) as usize {
                let x = Vec3::new(0.3 + k as f64 * step, 0.013, height);
                let at = overlap(core, core, &Similarity::rigid(turn, x), &geometry);
                let force = at.force * at.value;
                most = most.max(force.norm());
                change = change.max(last.map_or(0.0, |last| (force - last).norm()));
                last = Some(force);
            }
            change / most
        };
        let (coarse, fine) = (largest(1e-4), largest(1e-5));
        assert!(coarse > 1e-3 && coarse < 8e-2 && fine < 0.15 * coarse, "{turn} {coarse:e} {fine:e}");
    }
}
