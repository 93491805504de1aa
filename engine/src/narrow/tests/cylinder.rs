//! Cylinders against everything, checked by a search over directions.
//!
//! The separation along any direction is a lower bound of the signed distance, so an answer is right if the separation
//! along its own normal is minus its depth, and no direction of a search separates more.

use super::*;

fn cylinder(radius: f64, length: f64) -> Part {
    part(&ShapeDescription::Cylinder { radius_m: radius, length_m: length })
}

fn ball(radius: f64) -> Part {
    part(&ShapeDescription::Sphere { radius_m: radius })
}

fn capsule(radius: f64, total: f64) -> Part {
    part(&ShapeDescription::Spherocylinder { radius_m: radius, total_length_m: total })
}

/// Largest height of a part along a unit vector, from the definitions of the shapes.
fn highest(part: &Part, n: &Vec3) -> f64 {
    let of = |points: &[Vec3]| points.iter().map(|x| n.dot(x)).fold(f64::MIN, f64::max);
    match &part.geometry {
        PartGeometry::Sphere { center, radius } => n.dot(center) + radius,
        PartGeometry::Spherocylinder { ends, radius } => of(ends) + radius,
        PartGeometry::Cylinder { ends, radius } => of(ends) + radius * (ends[1] - ends[0]).normalize().cross(n).norm(),
        PartGeometry::Polyhedron(p) => of(p.vertices()),
        PartGeometry::RoundedPolyhedron(p) => of(p.skeleton.vertices()) + p.skeleton.radius,
    }
}

fn separation(a: &Part, b: &Part, pose: &Similarity, n: &Vec3) -> f64 {
    let in_b = pose.inverse_direction(&-n);
    pose.translation.dot(n) - highest(a, n) - pose.scale * highest(b, &in_b)
}

/// Directions that features suggest, in the frame of the part.
fn natural(part: &Part) -> Vec<Vec3> {
    match &part.geometry {
        PartGeometry::Sphere { .. } | PartGeometry::RoundedPolyhedron(_) => Vec::new(),
        PartGeometry::Spherocylinder { ends, .. } | PartGeometry::Cylinder { ends, .. } => {
            vec![(ends[1] - ends[0]).normalize()]
        }
        PartGeometry::Polyhedron(p) => {
            p.faces().iter().map(|f| f.normal).chain(p.edges().iter().map(|e| e.direction)).collect()
        }
    }
}

/// The largest separation that a search finds: coarse samples, natural directions, and random steps from the best.
fn search(a: &Part, b: &Part, pose: &Similarity, random: &mut Random, effort: usize) -> f64 {
    let (of_a, of_b) = (natural(a), natural(b).iter().map(|n| pose.direction(n)).collect::<Vec<_>>());
    let mut starts: Vec<Vec3> = (0..effort).map(|_| random.direction()).collect();
    for x in of_a.iter().chain(&of_b) {
        starts.extend([*x, -x]);
    }
    for x in &of_a {
        for y in &of_b {
            if let Some(n) = x.cross(y).try_normalize(1e-12) {
                starts.extend([n, -n]);
            }
        }
    }
    let mut found: Vec<(f64, Vec3)> = starts.into_iter().map(|n| (separation(a, b, pose, &n), n)).collect();
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    let mut best = f64::MIN;
    for (mut value, mut n) in found.into_iter().take(6) {
        let mut step = 0.3;
        while step > 1e-9 {
            let mut better = false;
            for _ in 0..16 {
                let trial = (n + random.direction() * step).normalize();
                let separation = separation(a, b, pose, &trial);
                if separation > value {
                    (value, n, better) = (separation, trial, true);
                }
            }
            step *= if better { 1.2 } else { 0.4 };
        }
        best = best.max(value);
    }
    best
}

struct Tally {
    touching: usize,
    worst: f64,
}

/// Checks one pair in both orders. `size` is that of the pair; returns the depth.
fn check(a: &Part, b: &Part, pose: &Similarity, random: &mut Random, tally: &mut Tally, label: &str) {
    let size = a.radius + b.radius * pose.scale;
    let manifold = contacts(a, b, pose);
    let found = depth(&manifold);
    let separated = search(a, b, pose, random, 60);
    let missed = if manifold.is_empty() { -separated } else { found + separated };
    if !manifold.is_empty() {
        tally.touching += 1;
        let deepest = manifold.points().iter().max_by(|p, q| p.overlap.total_cmp(&q.overlap)).unwrap();
        let own = -separation(a, b, pose, &deepest.normal);
        // 4e-9: what is outside a face by 1e-9 of the smaller part counts as inside. Ends beside each other have normals of
        // their own; a deepest point that is as deep as they are carries nothing and is left out.
        let ends = matches!(a.geometry, PartGeometry::Spherocylinder { .. }) && manifold.len() > 1;
        let several = ends || manifold.points().iter().any(|p| p.normal != deepest.normal);
        let tolerance = if several { 1e-2 } else { 4e-9 };
        assert!((own - found).abs() < tolerance * size, "{label}: depth {found:e}, along its normal {own:e}");
        assert!(missed < 1e-7 * size, "{label}: depth {found:e}, a direction has {:e}", -separated);
        tally.worst = tally.worst.max(missed / size);
        for p in manifold.points() {
            assert!((p.normal.norm() - 1.0).abs() < 1e-12, "{label}: {}", p.normal);
            assert!(p.overlap > 0.0 && p.share >= 0.0 && p.share.is_finite() && p.position.norm() < 1e9, "{label}");
            for (part, x, scale) in [(a, p.position, 1.0), (b, pose.inverse_point(&p.position), pose.scale)] {
                // a tilt of rounding times the length of a spherocylinder moves its point along
                let slack = found + 1e-5 * size;
                assert!(
                    outside(part, &x) * scale < slack,
                    "{label}: {:e} outside, {:?}",
                    outside(part, &x) * scale,
                    manifold.points()
                );
            }
        }
        oracle::check_keys(&manifold, label);
    } else {
        // a separation that is positive proves itself; the search stays below it where it is a ridge
        assert!(missed < 1e-2 * size, "{label}: nothing found, overlap {missed:e}");
    }
    let swapped = depth(&contacts(b, a, &pose.inverse())) * pose.scale;
    assert!((found - swapped).abs() < 4e-9 * size, "{label}: {found:e}, swapped {swapped:e}");
}

/// How far a point is outside of a part, at least.
fn outside(part: &Part, x: &Vec3) -> f64 {
    let toward = (x - part.center).try_normalize(0.0).unwrap_or_else(Vec3::x);
    let faces = natural(part).into_iter().chain([toward]);
    faces.flat_map(|n| [n, -n]).map(|n| n.dot(x) - highest(part, &n)).fold(f64::MIN, f64::max)
}

/// Generic poses, and poses within 1e-16 to 1e-1 of an alignment by quarter turns.
fn some_pose(random: &mut Random, case: usize, reach: f64) -> Similarity {
    let turn = match case % 3 {
        0 => random.rotation(),
        _ => {
            let quarter = |random: &mut Random| std::f64::consts::FRAC_PI_2 * random.below(4) as f64;
            let aligned = rotation(Vec3::x(), quarter(random)) * rotation(Vec3::y(), quarter(random));
            let off = if case % 3 == 1 { 10_f64.powf(random.between(-16.0, -1.0)) } else { 0.0 };
            rotation(random.direction(), off) * aligned
        }
    };
    let mut translation = random.in_ball() * reach;
    if case.is_multiple_of(5) {
        translation = translation.map(|x| if x.abs() < 0.3 * reach { 0.0 } else { x });
    }
    Similarity { rotation: turn, translation, scale: 10_f64.powf(random.between(-0.3, 0.3)) }
}

fn sweep(others: &[Part], seed: u64, cases: usize) -> Tally {
    let cylinders =
        [cylinder(0.5, 1.0), cylinder(0.2, 2.0), cylinder(1.0, 0.1), cylinder(0.05, 5.0), cylinder(0.5, 0.5)];
    let mut random = Random(seed);
    let mut tally = Tally { touching: 0, worst: 0.0 };
    for case in 0..cases {
        let (a, b) = (&others[case % others.len()], &cylinders[random.below(cylinders.len())]);
        let pose = some_pose(&mut random, case / 7, a.radius + b.radius);
        // half of the pairs a little in contact: slid apart along the deepest direction
        let shallow = contacts(a, b, &pose).points().first().copied().filter(|_| case % 2 == 0).map(|p| {
            let overlap = 10_f64.powf(random.between(-9.0, -1.0)) * p.overlap;
            Similarity { translation: pose.translation + p.normal * (p.overlap - overlap), ..pose }
        });
        check(a, b, &shallow.unwrap_or(pose), &mut random, &mut tally, &format!("case {case}"));
    }
    println!("{} touching of {cases}, worst {:e}", tally.touching, tally.worst);
    tally
}

#[test]
fn balls_and_spherocylinders() {
    let tally = sweep(&[ball(0.3), ball(1.0), capsule(0.2, 1.5), capsule(0.5, 1.2), capsule(0.05, 3.0)], 40, 4_000);
    assert!(tally.touching > 900, "{}", tally.touching);
}

#[test]
fn polyhedra() {
    let mut random = Random(41);
    let hull = random_hull(&mut random);
    let tally = sweep(&[cube(), pinacoid(1.0), prism(6, 0.5), cuboid(2.0, 1.0, 0.02), hull], 42, 4_000);
    assert!(tally.touching > 900, "{}", tally.touching);
}

#[test]
fn other_cylinders() {
    let tally = sweep(&[cylinder(0.5, 1.0), cylinder(0.2, 2.0), cylinder(1.0, 0.1), cylinder(0.05, 5.0)], 43, 4_000);
    assert!(tally.touching > 900, "{}", tally.touching);
}

fn at(rotation: Mat3, x: f64, y: f64, z: f64) -> Similarity {
    Similarity::rigid(rotation, Vec3::new(x, y, z))
}

const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

/// Number of points, and that each is as deep and looks as it should.
fn expect(m: &Manifold, count: usize, normal: Vec3, overlap: f64, slack: f64, label: &str) {
    assert_eq!(m.len(), count, "{label}: {:?}", m.points());
    for p in m.points() {
        assert!((p.normal - normal).norm() < 1e-12 + slack, "{label}: {}", p.normal);
        assert!((p.overlap - overlap).abs() < 1e-12 + slack, "{label}: {:e}", p.overlap);
    }
}

#[test]
fn aligned_contacts_have_their_points() {
    let (c, block) = (cylinder(0.4, 1.0), cuboid(1.0, 1.0, 1.0));
    let upright = rotation(Vec3::y(), QUARTER);
    for tilt in [0.0, 1e-16, 1e-13, 1e-10, 1e-7] {
        let label = format!("tilt {tilt:e}");
        let off = |turn: Mat3| rotation(Vec3::new(0.3, 0.7, -0.2), tilt) * turn;
        let slack = 10.0 * tilt;
        let stacked = contacts(&c, &c, &at(off(Mat3::identity()), 0.999, 0.0, 0.0));
        assert!(stacked.len() >= 4 && stacked.len() <= 8 + 3, "{label}: {}", stacked.len());
        expect(&stacked, stacked.len(), Vec3::x(), 1e-3, slack, &label);
        let beside = contacts(&c, &c, &at(off(Mat3::identity()), 0.999, 0.3, 0.0));
        expect(&beside, beside.len(), Vec3::x(), 1e-3, slack, &label);
        assert!(
            beside.points().iter().any(|p| p.position.z > 0.3) && beside.points().iter().any(|p| p.position.z < -0.3)
        );
        // a cap on a face, wholly and half over the rim
        expect(&contacts(&block, &c, &at(off(upright), 0.0, 0.0, 0.999)), 4, Vec3::z(), 1e-3, slack, &label);
        let half = contacts(&block, &c, &at(off(upright), 0.5, 0.0, 0.999));
        expect(&half, half.len(), Vec3::z(), 1e-3, slack, &label);
        for y in [-0.4, 0.4] {
            let corner = Vec3::new(0.5, y, 0.4995);
            assert!(
                half.points().iter().any(|p| (p.position - corner).norm() < 1e-3),
                "{label}: the rim leaves the face"
            );
        }
        assert!(half.points().iter().all(|p| p.position.x < 0.5 + 1e-6));
        // the side on a face, and over its rim
        let side = contacts(&block, &c, &at(off(Mat3::identity()), 0.2, 0.0, 0.899));
        expect(&side, 2, Vec3::z(), 1e-3, slack, &label);
        let mut reach: Vec<f64> = side.points().iter().map(|p| p.position.x).collect();
        reach.sort_by(f64::total_cmp);
        assert!((reach[0] + 0.3).abs() < 1e-6 && (reach[1] - 0.5).abs() < 1e-6, "{label}: {reach:?}");
        // sides: parallel, crossed, and on a cap
        let parallel = contacts(&c, &c, &at(off(Mat3::identity()), 0.5, 0.799, 0.0));
        let carrying = parallel.points().iter().filter(|p| p.share > 1e-3).count();
        assert_eq!(carrying, 2, "{label}: {:?}", parallel.points());
        expect(&parallel, parallel.len(), Vec3::y(), 1e-3, slack, &label);
        expect(&contacts(&c, &c, &at(off(upright), 0.0, 0.799, 0.1)), 1, Vec3::y(), 1e-3, slack, &label);
        let lying = contacts(&c, &c, &at(off(rotation(Vec3::z(), QUARTER)), 0.899, 0.0, 0.0));
        expect(&lying, 2, Vec3::x(), 1e-3, slack, &label);
    }
}

#[test]
fn corners_and_rims_touch_at_one_point() {
    let (c, block) = (cylinder(0.4, 1.0), cuboid(1.0, 1.0, 1.0));
    let corner_up = rotation(Vec3::new(1.0, -1.0, 0.0), (2.0_f64.sqrt()).atan());
    let reach = 0.75_f64.sqrt() - 1e-3;
    // a vertex on a cap, off its middle, and on the side
    let on_cap = contacts(&c, &block, &at(rotation(Vec3::y(), -QUARTER) * corner_up, 0.5 + reach, 0.1, 0.0));
    let on_side = contacts(&c, &block, &at(corner_up, 0.1, 0.0, 0.4 + reach));
    for (m, normal) in [(&on_cap, Vec3::x()), (&on_side, Vec3::z())] {
        expect(m, 1, normal, 1e-3, 1e-12, "a vertex");
    }
    // an edge across the side, along it, and on a cap
    let edge_up = rotation(Vec3::x(), 0.5 * QUARTER);
    let reach = 0.5_f64.sqrt() - 1e-3;
    expect(&contacts(&c, &block, &at(edge_up, 0.0, 0.0, 0.4 + reach)), 2, Vec3::z(), 1e-3, 1e-12, "an edge along");
    let across = at(rotation(Vec3::z(), QUARTER) * edge_up, 0.0, 0.0, 0.4 + reach);
    expect(&contacts(&c, &block, &across), 1, Vec3::z(), 1e-3, 1e-12, "an edge across");
    let on_cap = at(rotation(Vec3::y(), -QUARTER) * edge_up, 0.5 + reach, 0.0, 0.0);
    expect(&contacts(&c, &block, &on_cap), 2, Vec3::x(), 1e-3, 1e-12, "an edge on a cap");
    // a rim tilted onto a face
    let tilted = rotation(Vec3::y(), 0.5 * QUARTER);
    let low = (0.5 + 0.4) * 0.5_f64.sqrt();
    expect(&contacts(&block, &c, &at(tilted, 0.0, 0.0, 0.499 + low)), 1, Vec3::z(), 1e-3, 1e-12, "a rim on a face");
}

#[test]
fn nothing_is_ever_not_finite() {
    let c = cylinder(0.5, 1.0);
    let others = [ball(0.3), capsule(0.2, 1.0), cylinder(0.5, 1.0), cube(), cylinder(0.1, 3.0)];
    for other in &others {
        for turn in
            [Mat3::identity(), rotation(Vec3::y(), QUARTER), rotation(Vec3::z(), QUARTER), rotation(Vec3::x(), 1.0)]
        {
            let (x, y) = (highest(&c, &Vec3::x()), highest(&c, &Vec3::y()));
            let pose = at(turn, 0.0, 0.0, 0.0);
            let reach = |n: Vec3| highest(other, &pose.inverse_direction(&-n));
            let (touching_x, touching_y) = (x + reach(Vec3::x()), y + reach(Vec3::y()));
            for (dx, dy) in
                [(0.0, 0.0), (touching_x, 0.0), (0.0, touching_y), (0.25, 0.0), (0.0, 0.25), (touching_x, touching_y)]
            {
                for off in [0.0, 1e-16, -1e-16, 1e-13, -1e-13] {
                    let pose = at(turn, dx * (1.0 + off), dy * (1.0 + off), 0.0);
                    for (a, b, pose) in [(&c, other, pose), (other, &c, pose.inverse())] {
                        for p in contacts(a, b, &pose).points() {
                            assert!((p.normal.norm() - 1.0).abs() < 1e-12 && p.overlap > 0.0 && p.share.is_finite());
                            assert!(p.position.iter().all(|x| x.is_finite()));
                        }
                    }
                }
            }
        }
    }
}

/// Force and torque of the law f = k w d with w = share d / sum(share d): no jump while a cylinder turns over a block,
/// but for the few places where another direction becomes the nearest way out.
#[test]
fn the_force_of_a_cylinder_is_continuous() {
    let (c, block) = (cylinder(0.4, 1.0), cuboid(1.0, 1.0, 1.0));
    let resultant = |b: &Part, pose: &Similarity| {
        let m = contacts(&c, b, pose);
        let total: f64 = m.points().iter().map(|p| p.share * p.overlap).sum();
        let force = |p: &crate::narrow::ManifoldPoint| p.normal * (p.share * p.overlap * p.overlap / total.max(1e-300));
        let forces = m.points().iter().map(force).sum::<Vec3>();
        (forces, m.points().iter().map(|p| p.position.cross(&force(p))).sum::<Vec3>())
    };
    for (other, label) in [(&block, "block"), (&c, "cylinder")] {
        for (shift, axis) in [(0.2, Vec3::y()), (0.1, Vec3::new(0.3, 1.0, 0.2))] {
            let mut before: Option<(Vec3, Vec3)> = None;
            let mut turns = 0;
            // from flat on its cap to its side, pressed in by 2e-3
            for step in 0..20_000 {
                let angle = f64::from(step) * (QUARTER / 20_000.0);
                let turn = rotation(axis, angle);
                let low = |n: &Vec3| highest(other, &turn.tr_mul(n));
                let pose = at(turn, 0.5 + low(&-Vec3::x()) - 2e-3, shift, 0.05);
                let now = resultant(other, &pose);
                if let Some((force, torque)) = before {
                    let jump = (now.0 - force).norm().max((now.1 - torque).norm());
                    let turned = (now.0.normalize() - force.normalize()).norm();
                    turns += usize::from(turned > 0.02);
                    assert!(jump < 2e-4 || turned > 0.02, "{label} at {angle}: {jump:e} of {:e}", force.norm());
                }
                before = Some(now);
            }
            assert!(turns <= 3, "{label}: {turns}");
        }
    }
}

/// What is known of a pair may only save work: the same contacts, to the bit, with and without, on walks that press parts
/// together, part them and turn them, by little and by much, generic and aligned.
#[test]
fn what_is_known_of_a_pair_is_invisible() {
    let cylinders = [cylinder(0.5, 1.0), cylinder(0.2, 2.0), cylinder(1.0, 0.1), cylinder(0.5, 0.5)];
    let mut random = Random(44);
    let hull = random_hull(&mut random);
    let others =
        [cube(), pinacoid(1.0), prism(6, 0.5), cuboid(2.0, 1.0, 0.02), hull, cylinder(0.5, 1.0), cylinder(0.3, 0.4)];
    let (mut touching, mut apart) = (0, 0);
    for walk in 0..300 {
        let (a, b) = (&others[walk % others.len()], &cylinders[random.below(cylinders.len())]);
        let start = some_pose(&mut random, walk, 0.9 * (a.radius + b.radius));
        // as deep as contacts of a run are, or a little apart
        let shallow = contacts(a, b, &start).points().first().copied().map(|p| {
            let overlap = 10_f64.powf(random.between(-6.0, -2.0)) * p.overlap * if walk % 3 == 0 { -1.0 } else { 1.0 };
            Similarity { translation: start.translation + p.normal * (p.overlap - overlap), ..start }
        });
        let mut pose = shallow.unwrap_or(start);
        let mut cache = PairCache::default();
        for step in 0..60 {
            let mut known = Manifold::default();
            collide(a, b, &pose, &mut cache, &mut known);
            let fresh = contacts(a, b, &pose);
            assert_eq!(known.points(), fresh.points(), "walk {walk}, step {step}: {pose:?}");
            if fresh.is_empty() {
                apart += 1
            } else {
                touching += 1
            }
            let size = 10_f64.powf(random.between(-7.0, if step % 20 == 19 { -0.5 } else { -3.0 }));
            pose.translation += random.in_ball() * size;
            pose.rotation = rotation(random.direction(), size) * pose.rotation;
        }
    }
    assert!(touching > 5_000 && apart > 1_500, "{touching} {apart}");
}
