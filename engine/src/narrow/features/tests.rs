//! Pairs of features against the distance of the bodies, and lists against the search over everything.

use super::{FeatureContact, FeatureList, FeaturePair, FeatureScratch};
use crate::math::{Mat3, Similarity, Vec3};
use crate::narrow::tests::Random;
use crate::narrow::{FeatureKey, closest_on_segment, segment_segment};
use crate::shape::{Part, PartGeometry, Shape, ShapeDescription, Skeleton};
use nalgebra::Rotation3;

fn part(description: &ShapeDescription) -> Part {
    Shape::build(description).expect("a valid shape").parts()[0].clone()
}

fn cuboid(half: [f64; 3], radius: f64) -> Part {
    let corner = |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 1 { half[i] } else { -half[i] });
    part(&ShapeDescription::rounded_hull((0..8).map(corner).collect(), radius))
}

fn octahedron(radius: f64) -> Part {
    let (a, h) = (0.2310789, 0.3267949);
    let points = vec![[a, a, 0.0], [a, -a, 0.0], [-a, a, 0.0], [-a, -a, 0.0], [0.0, 0.0, h], [0.0, 0.0, -h]];
    part(&ShapeDescription::rounded_hull(points, radius))
}

/// An open box: four walls and a bottom without thickness.
fn cup() -> Skeleton {
    let corner = |k: usize| Vec3::new([-0.5, 0.5][k & 1], [-0.4, 0.4][k >> 1 & 1], [0.0, 0.6][k >> 2]);
    let faces = [[0, 1, 3, 2], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let faces: Vec<Vec<u32>> = faces.iter().map(|f| f.to_vec()).collect();
    Skeleton::new((0..8).map(corner).collect(), &[], &faces, 0.05, "cup").expect("a skeleton")
}

fn skeleton(part: &Part) -> &Skeleton {
    part.skeleton.as_deref().expect("few features")
}

fn all(pair: &FeaturePair<'_>) -> Vec<(FeatureKey, FeatureContact)> {
    let mut list = FeatureList::default();
    pair.all_candidates(&mut list);
    let mut found: Vec<_> = list.contacts(pair).collect();
    found.sort_by_key(|(feature, _)| *feature);
    found
}

fn turn(random: &mut Random, angle: f64) -> Mat3 {
    let axis = random.direction();
    Rotation3::from_scaled_axis(axis * angle).into_inner()
}

fn bodies() -> Vec<Skeleton> {
    let mut bodies = vec![cup()];
    let ball = part(&ShapeDescription::Sphere { radius_m: 0.3 });
    let rod = part(&ShapeDescription::Spherocylinder { radius_m: 0.1, total_length_m: 1.2 });
    let sharp = part(&ShapeDescription::Tetrahedron { edge_m: 1.0 });
    let parts = [cuboid([0.45; 3], 0.05), cuboid([0.48, 0.08, 0.08], 0.02), octahedron(0.1), ball, rod, sharp];
    bodies.extend(parts.iter().map(|part| skeleton(part).clone()));
    bodies
}

/// Distance of two convex skeletons that do not overlap, by all closed features.
fn distance(pair: &FeaturePair<'_>) -> f64 {
    let place = |x: &Vec3| pair.b_to_a.point(x);
    let mut least = f64::MAX;
    let above = |s: &Skeleton, f: usize, x: &Vec3| s.sides(f).iter().all(|s| s.inwards.dot(x) >= s.offset);
    for y in pair.b.vertices().iter().map(place) {
        for (_, face) in pair.a.faces().iter().enumerate().filter(|(f, _)| above(pair.a, *f, &y)) {
            let height = face.normal.dot(&y) - face.offset;
            least = least.min(if height > 0.0 { height } else { f64::MAX });
        }
        for e in pair.a.edges() {
            least = least.min((y - closest_on_segment(&y, &e.start, &(e.start + e.along)).0).norm());
        }
        pair.a.vertices().iter().for_each(|x| least = least.min((y - x).norm()));
    }
    for x in pair.a.vertices() {
        let x = pair.b_to_a.inverse_point(x);
        for (_, face) in pair.b.faces().iter().enumerate().filter(|(f, _)| above(pair.b, *f, &x)) {
            let height = (face.normal.dot(&x) - face.offset) * pair.b_to_a.scale;
            least = least.min(if height > 0.0 { height } else { f64::MAX });
        }
        for e in pair.b.edges() {
            let foot = closest_on_segment(&x, &e.start, &(e.start + e.along)).0;
            least = least.min((x - foot).norm() * pair.b_to_a.scale);
        }
    }
    for e in pair.a.edges() {
        for f in pair.b.edges() {
            let ends = [f.start, f.start + f.along].map(|x| place(&x));
            let (x, y) = segment_segment(&[e.start, e.start + e.along], &ends);
            least = least.min((y - x).norm());
        }
    }
    least
}

/// Whether all vertices of each lie outside the other by the faces, so that the cores may be apart.
fn are_apart(pair: &FeaturePair<'_>) -> bool {
    let by_faces = pair.most_separating().distance;
    let by_edges = pair.a.edges().iter().flat_map(|e| pair.b.edges().iter().map(move |f| (e, f))).any(|(e, f)| {
        let cross = e.along.cross(&pair.b_to_a.direction(&f.along));
        let Some(axis) = cross.try_normalize(1e-9) else { return false };
        [axis, -axis].iter().any(|axis| {
            let of_b = pair.b.vertices().iter().map(|y| axis.dot(&pair.b_to_a.point(y))).fold(f64::MAX, f64::min);
            let of_a = pair.a.vertices().iter().map(|x| axis.dot(x)).fold(f64::MIN, f64::max);
            of_b > of_a
        })
    });
    by_faces > 0.0 || by_edges
}

/// Convex bodies touch if and only if their cores are nearer than R, and the deepest contact is that distance.
#[test]
fn deepest_contact_is_the_distance_of_the_cores() {
    let mut random = Random(5);
    let bodies = bodies();
    let (mut touching, mut kinds) = (0, [0; 4]);
    for round in 0..60_000 {
        let (a, b) = (&bodies[1 + round % 5], &bodies[1 + round / 5 % 5]);
        let at = random.direction() * (1.4 * (a.reach + b.reach + 0.2) * random.unit());
        let scale = if round % 3 == 0 { 0.5 + random.unit() } else { 1.0 };
        let b_to_a = Similarity { rotation: turn(&mut random, 3.0), translation: at, scale };
        let pair = FeaturePair { a, b, b_to_a: &b_to_a };
        if !are_apart(&pair) {
            continue;
        }
        let found = all(&pair);
        let overlap = pair.radius() - distance(&pair);
        let deepest = found.iter().map(|(_, c)| c.overlap).fold(f64::MIN, f64::max);
        if overlap <= 0.0 {
            assert!(deepest <= 1e-12, "round {round}: nothing touches, but {found:?}");
        } else if overlap > 1e-9 {
            touching += 1;
            assert!((deepest - overlap).abs() < 1e-9, "round {round}: {overlap}, found {found:?}");
            let best = found.iter().find(|(_, c)| c.overlap == deepest).expect("the deepest");
            kinds[best.0.kind() as usize] += 1;
        }
    }
    assert!(touching > 3000 && kinds.iter().all(|&n| n > 100), "{touching} {kinds:?}");
}

/// Along random walks with jumps and aligned poses the list gives the bits of the search over all features.
#[test]
fn lists_change_no_bit() {
    let mut random = Random(7);
    let bodies = bodies();
    let mut scratch = FeatureScratch::default();
    let mut seen = 0;
    for walk in 0..600 {
        let (a, b) = (&bodies[walk % bodies.len()], &bodies[walk / bodies.len() % bodies.len()]);
        let scale = if walk % 2 == 0 { 1.0 } else { 0.7 };
        let aligned = walk % 3 == 0;
        let mut rotation = if aligned { Mat3::identity() } else { turn(&mut random, 3.0) };
        let mut at = random.direction() * (a.reach + b.reach * scale);
        if aligned {
            at = Vec3::z() * (a.reach.min(0.45) + b.reach.min(0.45) * scale + 0.05);
        }
        let mut list = FeatureList::default();
        let step = 10f64.powi(-(walk as i32 % 5) - 1);
        for k in 0..60 {
            let b_to_a = Similarity { rotation, translation: at, scale };
            let pair = FeaturePair { a, b, b_to_a: &b_to_a };
            list.update(&pair, &mut scratch);
            let found: Vec<_> = list.contacts(&pair).collect();
            assert_eq!(found, all(&pair), "walk {walk} step {k}");
            seen += found.len();
            at += random.direction() * step - at * (0.05 * step);
            rotation = turn(&mut random, step) * rotation;
        }
    }
    assert!(seen > 10_000, "{seen}");
}

/// Exactly aligned cubes: the corners above the face and no other, whatever rounding says of their borders.
#[test]
fn aligned_faces_have_their_corners() {
    let cube = cuboid([0.45; 3], 0.05);
    let cube = skeleton(&cube);
    for (shift, count) in [([0.0, 0.0], 8), ([0.2, 0.0], 4), ([0.2, 0.1], 4)] {
        for tilt in [0.0, 1e-15, 1e-13, 1e-12] {
            let rotation = Rotation3::from_scaled_axis(Vec3::new(0.3, -0.7, 0.2) * tilt).into_inner();
            let b_to_a = Similarity::rigid(rotation, Vec3::new(shift[0], shift[1], 0.9999));
            let found = all(&FeaturePair { a: cube, b: cube, b_to_a: &b_to_a });
            let on_faces = found.iter().filter(|(f, _)| matches!(f.kind(), 1 | 2)).count();
            let crossing = found.iter().filter(|(f, _)| f.kind() == 3).count();
            let both = shift[0] != 0.0 && shift[1] != 0.0;
            assert_eq!(
                (on_faces, crossing),
                (if both { 2 } else { count }, if both { 2 } else { 0 }),
                "{shift:?} {tilt}"
            );
            assert_eq!(found.len(), on_faces + crossing);
            assert!(
                found.iter().all(|(_, c)| (c.normal - Vec3::z()).norm() < 1e-11 && (c.overlap - 1e-4).abs() < 1e-11)
            );
        }
    }
}

/// Parallel edges meet at their ends, at any small angle; the sum of forces stays that of one to four contacts.
#[test]
fn parallel_edges_are_never_missed() {
    let half_turn = Rotation3::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_4).into_inner();
    let rod = cuboid([0.45, 0.1, 0.1], 0.05);
    let rod = skeleton(&rod);
    let edge = 2.0 * 0.1 * 2f64.sqrt();
    for shift in [0.0, 0.3] {
        for angle in [0.0, 1e-16, 1e-12, 1e-9, 1e-7, 9e-7, 1.1e-6, 1e-5, 1e-3] {
            let skew = Rotation3::from_axis_angle(&Vec3::z_axis(), angle).into_inner();
            let a_turned = rod.transformed(&half_turn, &Vec3::zeros());
            let b_to_a = Similarity::rigid(skew * half_turn, Vec3::new(shift, 0.0, edge + 0.0999));
            let found = all(&FeaturePair { a: &a_turned, b: rod, b_to_a: &b_to_a });
            assert!((1..=4).contains(&found.len()), "{shift} {angle}: {found:?}");
            assert!(found.iter().all(|(_, c)| c.normal.z > 0.99 && c.overlap > 0.0), "{shift} {angle}: {found:?}");
        }
    }
}

/// Swapped bodies: the opposite normals and the same overlaps.
#[test]
fn swapping_is_symmetric() {
    let mut random = Random(11);
    let bodies = bodies();
    for round in 0..5000 {
        let (a, b) = (&bodies[round % 7], &bodies[round / 7 % 7]);
        let at = random.direction() * (a.reach + a.radius + b.reach + b.radius) * 0.9;
        let scale = 0.6 + random.unit();
        let b_to_a = Similarity { rotation: turn(&mut random, 3.0), translation: at, scale };
        let a_to_b = b_to_a.inverse();
        let one = all(&FeaturePair { a, b, b_to_a: &b_to_a });
        let other = all(&FeaturePair { a: b, b: a, b_to_a: &a_to_b });
        let sum = |contacts: &[(FeatureKey, FeatureContact)]| -> Vec3 {
            contacts.iter().map(|(_, c)| c.normal * c.overlap).sum()
        };
        let difference = sum(&one) + b_to_a.direction(&sum(&other)) * scale;
        assert!(one.len() == other.len() && difference.norm() < 1e-10, "round {round}: {difference}");
    }
}

/// A corner that slides over the rim of a face and down its side, and an edge that slides over a corner: the force
/// has no jump.
#[test]
fn force_is_continuous_over_rims() {
    let cube = cuboid([0.45; 3], 0.05);
    let cube = skeleton(&cube);
    let corner_down = Rotation3::rotation_between(&Vec3::new(1.0, 1.0, 1.0), &-Vec3::z()).expect("not opposite");
    let edge_down = Rotation3::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_4);
    let corner_height = 0.45 * 3f64.sqrt();
    let edge_height = 0.45 * 2f64.sqrt();
    let n = 40_000;
    for (rotation, height, along) in [
        (corner_down.into_inner(), corner_height, Vec3::new(1.0, 0.13, 0.0)),
        (corner_down.into_inner(), corner_height, Vec3::new(1.0, 1.0, 0.0)),
        (
            Rotation3::from_axis_angle(&Vec3::z_axis(), 0.4).into_inner() * edge_down.into_inner(),
            edge_height,
            Vec3::x(),
        ),
    ] {
        let mut last: Option<Vec3> = None;
        for k in 0..n {
            let s = 0.3 + 0.4 * f64::from(k) / f64::from(n);
            let at = along * s + Vec3::z() * (0.45 + height + 0.09 - 0.02 * s);
            let b_to_a = Similarity::rigid(rotation, at);
            let found = all(&FeaturePair { a: cube, b: cube, b_to_a: &b_to_a });
            let force: Vec3 = found.iter().map(|(_, c)| c.normal * c.overlap).sum();
            if let Some(last) = last {
                let jump = (force - last).norm();
                assert!(jump < 40.0 * 0.4 / f64::from(n), "{along:?} at {s}: {jump:e}, {found:?}");
            }
            last = Some(force);
        }
    }
}

/// What a sharp polyhedron, a sphere and a rod look like as parts.
#[test]
fn every_part_has_a_skeleton() {
    let sphere = part(&ShapeDescription::Sphere { radius_m: 0.3 });
    assert!(matches!(sphere.geometry, PartGeometry::Sphere { .. }));
    assert_eq!((skeleton(&sphere).vertices().len(), skeleton(&sphere).radius), (1, 0.3));
    let cube = part(&ShapeDescription::Cube { edge_m: 1.0 });
    assert_eq!((skeleton(&cube).edges().len(), skeleton(&cube).radius), (12, 0.0));
    assert!(skeleton(&cube).is_convex() && !cup().is_convex());
}
