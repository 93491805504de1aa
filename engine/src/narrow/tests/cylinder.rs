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
                assert!(outside(part, &x) * scale < found + 1e-6 * size, "{label}: a point far outside");
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
