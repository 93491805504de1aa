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
        PartGeometry::Cylinder { ends, radius } => {
            let mut random = Random(9);
            let axis = (ends[1] - ends[0]).normalize();
            let mut rim = || axis.cross(&random.direction()).normalize() * *radius;
            ends.iter().flat_map(|c| (0..20_000).map(|_| c + rim()).collect::<Vec<_>>()).collect()
        }
        PartGeometry::RoundedPolyhedron(p) => sample(p.skeleton.vertices(), p.skeleton.radius),
    }
}

fn sample(centers: &[Vec3], radius: f64) -> Vec<Vec3> {
    let mut random = Random(9);
    centers.iter().flat_map(|c| (0..20_000).map(|_| c + random.direction() * radius).collect::<Vec<_>>()).collect()
}

fn parts() -> [Part; 6] {
    let capsule = ShapeDescription::Spherocylinder { radius_m: 0.3, total_length_m: 2.0 };
    let cylinder = |radius_m: f64, length_m: f64| part(&ShapeDescription::Cylinder { radius_m, length_m });
    let ball = part(&ShapeDescription::Sphere { radius_m: 0.6 });
    [cube(), pinacoid(1.0), ball, part(&capsule), cylinder(0.4, 0.8), cylinder(0.8, 0.2)]
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

fn at_plane(tilt: f64, spin: f64, height: f64) -> Manifold {
    let part = part(&ShapeDescription::Cylinder { radius_m: 0.5, length_m: 2.0 });
    let upright = rotation(Vec3::y(), -std::f64::consts::FRAC_PI_2);
    let turn = rotation(Vec3::y(), tilt) * upright * rotation(Vec3::x(), spin);
    let mut out = Manifold::default();
    part_plane(&part, &Similarity::rigid(turn, Vec3::z() * height), &mut out);
    out
}

/// Upright: four points that turn with the cylinder; tilted less than it sinks: the same names; more: from the deepest.
#[test]
fn a_cylinder_keeps_the_names_of_its_points() {
    let keys = |m: &Manifold| m.points().iter().map(|p| p.feature.0 & 0xff).collect::<Vec<_>>();
    for spin in [0.0, 0.3, 0.7] {
        for tilt in [0.0, 1e-17, 1e-12, 1e-6] {
            let flat = at_plane(tilt, spin, 1.0 - 1e-5);
            assert_eq!(flat.len(), 4);
            let mut names = keys(&flat);
            names.sort_unstable();
            assert_eq!(names, if names[0] < 4 { [0, 1, 2, 3] } else { [4, 5, 6, 7] });
            let sum: f64 = flat.points().iter().map(|p| p.overlap).sum();
            assert!((sum - 4e-5).abs() < 1e-14 + 4.0 * tilt * tilt, "the sum does not depend on the phase");
        }
        let rocking = at_plane(1e-3, spin, 1.0 - 1e-5);
        assert_eq!(keys(&rocking)[0] % 4, 0, "the deepest point is the first of its rim");
        let lying = at_plane(std::f64::consts::FRAC_PI_2, spin, 0.5 - 1e-5);
        assert_eq!(keys(&lying), [0, 4]);
        assert!((lying.points()[0].overlap - lying.points()[1].overlap).abs() < 1e-15);
    }
}

/// Rims in a drum: every local maximum of the distance from the axis, by dense samples.
#[test]
fn a_cylinder_in_a_drum_touches_where_its_rims_are_farthest() {
    let mut random = Random(22);
    let part = part(&ShapeDescription::Cylinder { radius_m: 1.0, length_m: 0.8 });
    let PartGeometry::Cylinder { ends, .. } = part.geometry else { panic!() };
    let (mut singles, mut doubles) = (0, 0);
    for case in 0..400 {
        let aligned = [Mat3::identity(), rotation(Vec3::y(), std::f64::consts::FRAC_PI_2), rotation(Vec3::z(), 0.7)];
        let turn = if case % 4 == 0 { aligned[case / 4 % 3] } else { random.rotation() };
        let pose = Similarity::rigid(turn, random.in_ball() * 0.5);
        let radius = 0.3;
        let mut out = Manifold::default();
        part_cylinder(&part, &pose, radius, &mut out);
        let (y, z) = (pose.direction(&Vec3::y()), pose.direction(&Vec3::z()));
        for (rim, end) in ends.iter().enumerate() {
            let rho = |phi: f64| (pose.point(end) + y * phi.cos() + z * phi.sin()).xy().norm();
            let n = 3600;
            let samples: Vec<f64> = (0..n).map(|k| rho(f64::from(k) * std::f64::consts::TAU / f64::from(n))).collect();
            let n = n as usize;
            let maxima = (0..n).filter(|&k| {
                samples[k] > samples[(k + 1) % n] && samples[k] >= samples[(k + n - 1) % n] && samples[k] > radius
            });
            let mut maxima: Vec<f64> = maxima.map(|k| samples[k] - radius).collect();
            let mut found: Vec<f64> =
                out.points().iter().filter(|p| (p.feature.0 & 0xff) / 4 == rim as u32).map(|p| p.overlap).collect();
            maxima.sort_by(f64::total_cmp);
            found.sort_by(f64::total_cmp);
            if maxima.len() == found.len() {
                (singles, doubles) = (singles + usize::from(found.len() == 1), doubles + usize::from(found.len() == 2));
                assert!(maxima.iter().zip(&found).all(|(x, y)| (x - y).abs() < 2e-6), "{maxima:?} {found:?}");
            } else {
                // the second of two that are about to merge, or all equally far
                let shallow = out.points().iter().map(|p| p.share).fold(1.0, f64::min);
                assert!(
                    shallow < 0.05 || samples.iter().all(|x| (x - samples[0]).abs() < 1e-9),
                    "{case} {maxima:?} {found:?}"
                );
            }
        }
    }
    assert!(singles > 200 && doubles > 100, "{singles} {doubles}");
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
