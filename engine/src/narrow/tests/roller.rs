//! Rollers against brute force.

use super::*;
use crate::narrow::part_roller;

fn pose(random: &mut Random) -> Similarity {
    let scale = 10_f64.powf(random.between(-1.0, 1.0));
    Similarity { rotation: random.rotation(), translation: random.in_ball() * 2.5 * scale, scale }
}

/// Distance of the segment from z.
fn from_axis(p: &Vec3, q: &Vec3) -> f64 {
    let flat = |x: &Vec3| Vec3::new(x.x, x.y, 0.0);
    crate::narrow::closest_on_segment(&Vec3::zeros(), &flat(p), &flat(q)).0.norm()
}

/// How far a part reaches below the surface of the roller; `None` where its core holds the axis.
fn reach_below(part: &Part, pose: &Similarity, radius: f64) -> Option<f64> {
    let (core, rounding) = match &part.geometry {
        PartGeometry::Sphere { center, radius } => (vec![*center], *radius),
        PartGeometry::Spherocylinder { ends, radius } => (ends.to_vec(), *radius),
        PartGeometry::Polyhedron(p) => (p.vertices().to_vec(), 0.0),
        PartGeometry::Cylinder { .. } => unreachable!("cylinders have tests of their own"),
        PartGeometry::RoundedPolyhedron(p) => (p.skeleton.vertices().to_vec(), p.skeleton.radius),
    };
    let points: Vec<Vec3> = core.iter().map(|x| pose.point(x)).collect();
    // seen along z, the outline of a convex core is made of segments between its vertices
    let nearest = points.iter().flat_map(|p| points.iter().map(|q| from_axis(p, q))).fold(f64::MAX, f64::min);
    let middle = points.iter().sum::<Vec3>() / points.len() as f64;
    let toward = |x: &Vec3| x.x * middle.x + x.y * middle.y > 0.0;
    let outside = points.len() == 1 || points.iter().all(toward);
    outside.then_some(radius + rounding * pose.scale - nearest)
}

#[test]
fn rollers_agree_with_brute_force() {
    let mut random = Random(40);
    let capsule = ShapeDescription::Spherocylinder { radius_m: 0.3, total_length_m: 2.0 };
    let parts = [cube(), pinacoid(1.0), part(&ShapeDescription::Sphere { radius_m: 0.6 }), part(&capsule)];
    let mut touching = 0;
    for part in parts {
        for _ in 0..2000 {
            let pose = pose(&mut random);
            let radius = random.between(0.2, 2.0) * pose.scale;
            let Some(below) = reach_below(&part, &pose, radius) else { continue };
            let mut out = Manifold::default();
            part_roller(&part, &pose, radius, &mut out);
            // nearly parallel axes: the place of the closest point is known to 1e-5, its distance to the square of that
            assert!((depth(&out) - below.max(0.0)).abs() <= 1e-9 * (pose.scale + radius), "{} {below}", depth(&out));
            touching += usize::from(below > 0.0);
            for p in out.points() {
                let rho = p.position.xy().norm();
                assert!((p.normal.norm() - 1.0).abs() < 1e-13);
                assert!(rho < radius && p.overlap > 0.0);
            }
            for p in out.points().iter().filter(|p| p.overlap == depth(&out) && p.overlap < radius) {
                // the deepest point is halfway between the surfaces, the normal from there to the axis
                let rho = p.position.xy().norm();
                let off = rho - (radius - 0.5 * p.overlap);
                assert!(off.abs() < 1e-6 * (radius + pose.scale), "{off:e} {} {rho} {radius}", p.overlap);
                // up to the root of what the distance is known to
                assert!((p.normal.xy() + p.position.xy() / rho).norm() < 1e-4 && p.normal.z.abs() < 1e-4, "{p:?}");
            }
        }
    }
    assert!(touching > 1000, "{touching}");
}

#[test]
fn a_capsule_along_the_roller_rests_on_both_ends() {
    let capsule = part(&ShapeDescription::Spherocylinder { radius_m: 0.3, total_length_m: 2.0 });
    let PartGeometry::Spherocylinder { ends, .. } = &capsule.geometry else { panic!("not a spherocylinder") };
    let along = Quat::rotation_between(&(ends[1] - ends[0]), &Vec3::z()).unwrap_or_default();
    let pose = Similarity::rigid(*along.to_rotation_matrix().matrix(), Vec3::new(1.25, 0.0, 7.0));
    let mut out = Manifold::default();
    part_roller(&capsule, &pose, 1.0, &mut out);
    assert_eq!(out.len(), 2);
    for p in out.points() {
        assert!((p.overlap - 0.05).abs() < 1e-14 && (p.normal + Vec3::x()).norm() < 1e-14);
        assert!(((p.position.z - 7.0).abs() - 0.7).abs() < 1e-14);
    }
    assert!((out.points()[0].share - out.points()[1].share).abs() < 1e-12);
}
