//! Walls against brute force.

use super::*;
use crate::narrow::{part_cylinder, part_plane};

fn pose(random: &mut Random, reach: f64) -> Similarity {
    let scale = 10_f64.powf(random.between(-1.0, 1.0));
    Similarity { rotation: random.rotation(), translation: random.in_ball() * reach * scale, scale }
}

/// Points of the surface, dense enough for 1e-3 of the radius on round parts.
fn surface_points(part: &Part) -> Vec<Vec3> {
    match &part.geometry {
        PartGeometry::Polyhedron(p) => p.vertices().to_vec(),
        PartGeometry::Sphere { center, radius } => sample(&[*center], *radius),
        PartGeometry::Spherocylinder { ends, radius } => sample(ends, *radius),
        PartGeometry::RoundedPolyhedron(p) => sample(p.skeleton.vertices(), p.skeleton.radius),
    }
}

fn sample(centers: &[Vec3], radius: f64) -> Vec<Vec3> {
    let mut random = Random(9);
    centers.iter().flat_map(|c| (0..20_000).map(|_| c + random.direction() * radius).collect::<Vec<_>>()).collect()
}

fn parts() -> [Part; 4] {
    let capsule = ShapeDescription::Spherocylinder { radius_m: 0.3, total_length_m: 2.0 };
    [cube(), pinacoid(1.0), part(&ShapeDescription::Sphere { radius_m: 0.6 }), part(&capsule)]
}

#[test]
fn planes_agree_with_brute_force() {
    let mut random = Random(20);
    for part in parts() {
        let points = surface_points(&part);
        let round = !matches!(part.geometry, PartGeometry::Polyhedron(_));
        for _ in 0..100 {
            let pose = pose(&mut random, 1.2);
            let mut out = Manifold::default();
            part_plane(&part, &pose, &mut out);
            let lowest = points.iter().map(|x| pose.point(x).z).fold(f64::MAX, f64::min);
            // 2e4 random points miss the lowest one by about 1e-3 of the radius
            let tolerance = pose.scale * if round { 2e-3 } else { 1e-13 };
            assert!((depth(&out) + lowest.min(0.0)).abs() <= tolerance, "{} {lowest}", depth(&out));
            if !round {
                let below = points.iter().filter(|x| pose.point(x).z < 0.0).count();
                assert_eq!(out.len(), below);
            }
            for p in out.points() {
                assert_eq!((p.normal, p.share), (-Vec3::z(), 1.0));
                assert!((p.position.z + 0.5 * p.overlap).abs() <= 1e-14 * pose.scale);
            }
        }
    }
}

#[test]
fn cylinders_agree_with_brute_force() {
    let mut random = Random(21);
    for part in parts() {
        let points = surface_points(&part);
        let round = !matches!(part.geometry, PartGeometry::Polyhedron(_));
        for _ in 0..100 {
            let pose = pose(&mut random, 1.5);
            let radius = random.between(0.8, 2.0) * pose.scale;
            let mut out = Manifold::default();
            part_cylinder(&part, &pose, radius, &mut out);
            let rho = |x: &Vec3| pose.point(x).xy().norm();
            let farthest = points.iter().map(rho).fold(0.0, f64::max);
            let tolerance = pose.scale * if round { 3e-3 } else { 1e-13 };
            assert!((depth(&out) - (farthest - radius).max(0.0)).abs() <= tolerance);
            if !round {
                assert_eq!(out.len(), points.iter().filter(|x| rho(x) > radius).count());
            }
            for p in out.points() {
                assert!((p.normal.norm() - 1.0).abs() < 1e-14 && p.normal.z == 0.0);
                assert!((p.position.xy().norm() - radius - 0.5 * p.overlap).abs() < 1e-13 * pose.scale);
                assert!(p.normal.xy().perp(&p.position.xy()).abs() < 1e-13 * pose.scale);
            }
        }
    }
}

#[test]
fn a_ball_as_wide_as_the_drum_on_its_axis() {
    let ball = part(&ShapeDescription::Sphere { radius_m: 1.0 });
    let mut out = Manifold::default();
    part_cylinder(&ball, &Similarity::identity(), 0.5, &mut out);
    assert_eq!(out.len(), 1);
    assert_eq!((out.points()[0].normal, out.points()[0].overlap), (Vec3::x(), 0.5));
}

#[test]
fn more_vertices_than_the_buffer_keep_the_deepest() {
    let sides = 16;
    let rings: Vec<Vec3> = (0..8)
        .flat_map(|ring| {
            (0..sides).map(move |k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
                let (s, c) = (f64::from(ring) * 0.4 - 1.4).sin_cos();
                Vec3::new(cos * c, sin * c, s)
            })
        })
        .collect();
    let ball = hull(&rings);
    assert!(solid(&ball).vertices().len() > 100);
    let mut out = Manifold::default();
    part_plane(&ball, &Similarity::rigid(Mat3::identity(), Vec3::new(0.0, 0.0, -3.0)), &mut out);
    let lowest = solid(&ball).vertices().iter().map(|v| v.z).fold(f64::MAX, f64::min);
    assert_eq!(out.len(), crate::narrow::MAX_POINTS);
    assert_eq!(depth(&out), 3.0 - lowest);
}
