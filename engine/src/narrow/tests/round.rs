//! Balls and spherocylinders against closed forms and dense sampling.

use super::oracle::vertices_in_a;
use super::*;
use crate::narrow::ManifoldPoint;

fn ball(radius: f64) -> Part {
    part(&ShapeDescription::Sphere { radius_m: radius })
}

fn capsule(radius: f64, total: f64) -> Part {
    part(&ShapeDescription::Spherocylinder { radius_m: radius, total_length_m: total })
}

fn at(rotation: Mat3, x: f64, y: f64, z: f64) -> Similarity {
    Similarity::rigid(rotation, Vec3::new(x, y, z))
}

#[test]
fn two_balls() {
    let (a, b) = (ball(1.0), ball(0.5));
    let manifold = contacts(&a, &b, &Similarity { scale: 2.0, ..at(Mat3::identity(), 0.0, 1.9, 0.0) });
    let p = manifold.points()[0];
    assert!((p.overlap - 0.1).abs() < 1e-15 && (p.normal - Vec3::y()).norm() < 1e-15);
    assert!((p.position - Vec3::y() * 0.95).norm() < 1e-15);
    assert!(contacts(&a, &b, &at(Mat3::identity(), 0.0, 1.6, 0.0)).is_empty());
    let coincident = contacts(&a, &b, &Similarity::identity());
    assert_eq!((coincident.points()[0].normal, coincident.points()[0].overlap), (Vec3::x(), 1.5));
}

/// Squared distance of two segments over a fine grid and then exactly in one variable.
fn sampled_distance(p: &[Vec3; 2], q: &[Vec3; 2]) -> f64 {
    let to_q = |x: &Vec3| {
        let d = q[1] - q[0];
        let t = (d.dot(&(x - q[0])) / d.norm_squared()).clamp(0.0, 1.0);
        (x - q[0] - d * t).norm()
    };
    minimum(|s| to_q(&(p[0] + (p[1] - p[0]) * s)))
}

/// Minimum of a convex function on [0, 1] by ternary search: 1e-9 or better for smooth and kinked ones.
fn minimum(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..120 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if f(a) <= f(b) { high = b } else { low = a }
    }
    f(0.5 * (low + high)).min(f(0.0)).min(f(1.0))
}

fn ends(part: &Part) -> ([Vec3; 2], f64) {
    let PartGeometry::Spherocylinder { ends, radius } = part.geometry else { panic!() };
    (ends, radius)
}

#[test]
fn spherocylinders_agree_with_sampling() {
    let mut random = Random(30);
    let (a, b) = (capsule(0.3, 2.0), capsule(0.2, 1.5));
    let mut touching = 0;
    for case in 0..5_000 {
        let turn = if case % 3 == 0 {
            rotation(random.direction(), 10_f64.powf(random.between(-16.0, -1.0)))
        } else {
            random.rotation()
        };
        let pose = Similarity { rotation: turn, translation: random.in_ball() * 1.5, scale: random.between(0.5, 2.0) };
        let ((p, r), (q, s)) = (ends(&a), ends(&b));
        let expected = r + s * pose.scale - sampled_distance(&p, &q.map(|e| pose.point(&e)));
        let manifold = contacts(&a, &b, &pose);
        assert!((depth(&manifold) - expected.max(0.0)).abs() < 1e-8, "case {case}: {} {expected}", depth(&manifold));
        touching += usize::from(!manifold.is_empty());
        check_swap(&a, &b, &pose, &manifold, case);
    }
    assert!(touching > 1_000);
}

fn check_swap(a: &Part, b: &Part, pose: &Similarity, direct: &Manifold, case: usize) {
    let mut swapped = contacts(b, a, &pose.inverse());
    swapped.map_from(0, pose);
    swapped.flip_from(0);
    let resultant = |m: &Manifold| {
        let total: f64 = m.points().iter().map(|p| p.share).sum();
        m.points().iter().map(|p| p.normal * (p.overlap * p.share / total)).sum::<Vec3>()
    };
    let off = (resultant(direct) - resultant(&swapped)).norm();
    assert!(direct.is_empty() == swapped.is_empty() && (direct.is_empty() || off < 1e-6), "case {case}: {off:e}");
}

#[test]
fn parallel_spherocylinders_touch_at_both_ends_of_the_stretch() {
    let a = capsule(0.5, 3.0);
    for tilt in [0.0, 1e-15, 1e-12, 1e-9, 1e-6] {
        let manifold = contacts(&a, &a, &at(rotation(Vec3::z(), tilt), 0.5, 0.99, 0.0));
        let carrying: Vec<&ManifoldPoint> = manifold.points().iter().filter(|p| p.share > 1e-3).collect();
        assert_eq!(carrying.len(), 2, "tilt {tilt:e}");
        for (p, x) in carrying.iter().zip([-0.5, 1.0]) {
            assert!((p.overlap - 0.01).abs() < 2.0 * tilt + 1e-14 && (p.share - 0.75).abs() < 400.0 * tilt + 1e-14);
            assert!((p.position - Vec3::new(x, 0.495, 0.0)).norm() < 3.0 * tilt + 1e-14);
        }
    }
    assert_eq!(contacts(&a, &a, &at(rotation(Vec3::y(), 1.0), 0.0, 0.99, 0.0)).len(), 1, "crossing");
    assert_eq!(contacts(&a, &a, &at(Mat3::identity(), 2.99, 0.0, 0.0)).len(), 1, "end to end");
    let identical = contacts(&a, &a, &Similarity::identity());
    assert!(identical.points().iter().all(|p| (p.normal.norm() - 1.0).abs() < 1e-15 && p.overlap == 1.0));
}

/// The force of a law f = k share d / sum(share): no jump while one capsule turns over the other.
#[test]
fn the_force_between_spherocylinders_is_continuous() {
    let a = capsule(0.5, 3.0);
    let force = |angle: f64| {
        let manifold = contacts(&a, &a, &at(rotation(Vec3::new(0.1, 1.0, 0.0), angle), 0.2, 0.98, 0.1));
        let total: f64 = manifold.points().iter().map(|p| p.share).sum();
        let f = |p: &ManifoldPoint| p.normal * (p.share * p.overlap / total);
        let torque: Vec3 = manifold.points().iter().map(|p| p.position.cross(&f(p))).sum();
        (manifold.points().iter().map(f).sum::<Vec3>(), torque)
    };
    let step = 1e-4;
    let mut last = force(-1.0);
    for k in 1..20_000 {
        let now = force(-1.0 + step * f64::from(k));
        let jump = (now.0 - last.0).norm() + (now.1 - last.1).norm();
        assert!(jump < 20.0 * step * 0.5, "{jump:e} at {}", -1.0 + step * f64::from(k));
        last = now;
    }
}

/// Distance of a point from a closed surface of triangles.
fn distance_to_surface(x: &Vec3, p: &Polyhedron, vertices: &[Vec3]) -> f64 {
    let mut least = f64::MAX;
    for f in 0..p.faces().len() {
        let loop_ = p.face_vertices(f);
        for k in 1..loop_.len() - 1 {
            let t = [loop_[0], loop_[k], loop_[k + 1]].map(|v| vertices[v as usize]);
            least = least.min(distance_to_triangle(x, &t));
        }
    }
    least
}

fn distance_to_triangle(x: &Vec3, t: &[Vec3; 3]) -> f64 {
    let normal = (t[1] - t[0]).cross(&(t[2] - t[0])).normalize();
    let inside = (0..3).all(|k| (t[(k + 1) % 3] - t[k]).cross(&(x - t[k])).dot(&normal) >= 0.0);
    if inside {
        return normal.dot(&(x - t[0])).abs();
    }
    (0..3)
        .map(|k| {
            let d = t[(k + 1) % 3] - t[k];
            let s = (d.dot(&(x - t[k])) / d.norm_squared()).clamp(0.0, 1.0);
            (x - t[k] - d * s).norm()
        })
        .fold(f64::MAX, f64::min)
}

fn signed_distance(x: &Vec3, p: &Polyhedron, to_a: &Similarity) -> f64 {
    let vertices = vertices_in_a(p, to_a);
    let distance = distance_to_surface(x, p, &vertices);
    if crate::narrow::farthest_face(p, &to_a.inverse_point(x)).1 < 0.0 { -distance } else { distance }
}

#[test]
fn balls_and_polyhedra_agree_with_brute_force() {
    let mut random = Random(31);
    let solids = [cube(), pinacoid(1.0), prism(16, 0.5), cuboid(1.0, 1.0, 0.01), random_hull(&mut random)];
    for case in 0..5_000 {
        let b = &solids[case % solids.len()];
        let a = ball(10_f64.powf(random.between(-3.0, 1.0)));
        let scale = 10_f64.powf(random.between(-1.0, 1.0));
        let translation = random.direction() * (a.radius + scale) * random.between(0.0, 1.0);
        let pose = Similarity { rotation: random.rotation(), translation, scale };
        let expected = a.radius - signed_distance(&Vec3::zeros(), solid(b), &pose);
        let size = a.radius + scale;
        let direct = contacts(&a, b, &pose);
        assert!(
            (depth(&direct) - expected.max(0.0)).abs() < 1e-12 * size,
            "case {case}: {} {expected}",
            depth(&direct)
        );
        let swapped = contacts(b, &a, &pose.inverse());
        assert!((depth(&direct) - depth(&swapped) * scale).abs() < 1e-12 * size, "case {case}");
        if let (Some(p), Some(q)) = (direct.points().first(), swapped.points().first()) {
            assert!((p.normal + pose.direction(&q.normal)).norm() < 1e-6, "case {case}");
            assert!((p.position - p.normal * (a.radius - 0.5 * p.overlap)).norm() < 1e-12 * size, "case {case}");
        }
    }
}

/// A ball sunk into a face comes out through it: normal and depth are continuous where the centre passes the surface.
#[test]
fn a_ball_through_a_face_is_continuous() {
    let (a, b) = (ball(0.1), cube());
    for (x, y) in [(0.0, 0.0), (0.3, 0.1), (0.5 - 1e-9, 0.0)] {
        for k in -40..=40 {
            let z = 0.5 + f64::from(k) * 1e-3;
            let manifold = contacts(&a, &b, &at(Mat3::identity(), -x, -y, -z));
            let p = manifold.points()[0];
            if x < 0.4 {
                assert!((p.overlap - (0.1 - (z - 0.5))).abs() < 1e-15 && (p.normal + Vec3::z()).norm() < 1e-15);
            }
            assert!((p.normal.norm() - 1.0).abs() < 1e-14);
        }
    }
}

#[test]
fn spherocylinders_and_polyhedra_agree_with_brute_force() {
    let mut random = Random(32);
    let solids = [cube(), pinacoid(1.0), prism(6, 0.5), cuboid(1.0, 1.0, 0.01), random_hull(&mut random)];
    let (mut shallow, mut deep) = (0, 0);
    for case in 0..5_000 {
        let b = &solids[case % solids.len()];
        let a = capsule(0.1, random.between(0.2, 2.0));
        let turn = if case % 4 == 0 {
            rotation(random.direction(), 10_f64.powf(random.between(-16.0, -1.0)))
        } else {
            random.rotation()
        };
        let scale = 10_f64.powf(random.between(-0.5, 0.5));
        let pose = Similarity { rotation: turn, translation: random.in_ball() * (a.radius + scale), scale };
        let (axis, radius) = ends(&a);
        let outside = minimum(|s| signed_distance(&(axis[0] + (axis[1] - axis[0]) * s), solid(b), &pose).max(0.0));
        let manifold = contacts(&a, b, &pose);
        let size = a.radius + scale;
        if outside > 1e-9 {
            let expected = (radius - outside).max(0.0);
            assert!((depth(&manifold) - expected).abs() < 1e-8 * size, "case {case}: {} {expected}", depth(&manifold));
            shallow += usize::from(expected > 0.0);
        } else {
            let expected = radius - segment_separation(&axis, solid(b), &pose);
            assert!((depth(&manifold) - expected).abs() < 1e-11 * size, "case {case}: {} {expected}", depth(&manifold));
            deep += 1;
        }
        assert!(manifold.points().iter().all(|p| (p.normal.norm() - 1.0).abs() < 1e-12 && p.share >= 0.0));
        let swapped = contacts(b, &a, &pose.inverse());
        assert!((depth(&manifold) - depth(&swapped) * scale).abs() < 1e-11 * size, "case {case}");
    }
    assert!(shallow > 300 && deep > 300, "{shallow} {deep}");
}

/// Brute-force separating-axis test of a segment that cuts a polyhedron.
fn segment_separation(axis: &[Vec3; 2], p: &Polyhedron, to_a: &Similarity) -> f64 {
    let v = vertices_in_a(p, to_a);
    let mut axes: Vec<Vec3> = p.faces().iter().map(|f| to_a.rotation * f.normal).collect();
    for e in p.edges() {
        let cross =
            (v[e.vertices[1] as usize] - v[e.vertices[0] as usize]).normalize().cross(&(axis[1] - axis[0]).normalize());
        if cross.norm() > 1e-15 {
            axes.extend([cross.normalize(), -cross.normalize()]);
        }
    }
    let separation = |n: &Vec3| {
        let top = v.iter().map(|x| n.dot(x)).fold(f64::MIN, f64::max);
        axis.iter().map(|x| n.dot(x)).fold(f64::MAX, f64::min) - top
    };
    axes.iter().map(separation).fold(f64::MIN, f64::max)
}

#[test]
fn a_spherocylinder_lying_on_a_face_touches_at_two_points() {
    let (a, b) = (capsule(0.1, 0.8), cuboid(1.0, 1.0, 1.0));
    for tilt in [0.0, 1e-15, 1e-12, 1e-9, 1e-5] {
        for (x, reach) in [(0.0, [-0.3, 0.3]), (0.4, [-0.1, 0.3])] {
            // the face z = 0.5 below, its rim at x = 0.5 seen from b
            let pose = at(rotation(Vec3::y(), tilt), -x, 0.0, -0.599);
            let manifold = contacts(&a, &b, &pose);
            let mut carrying: Vec<&ManifoldPoint> = manifold.points().iter().filter(|p| p.share > 1e-2).collect();
            carrying.sort_by(|p, q| p.position.x.total_cmp(&q.position.x));
            assert_eq!(carrying.len(), 2, "tilt {tilt:e} at {x}");
            let expected = if x == 0.0 { reach } else { [-0.3, 0.1] };
            for (p, x) in carrying.iter().zip(expected) {
                assert!((p.position.x - x).abs() < 2.0 * tilt + 1e-12, "{}", p.position);
                assert!(
                    (p.overlap - 1e-3).abs() < 2.0 * tilt + 1e-14 && (p.normal + Vec3::z()).norm() < 2.0 * tilt + 1e-14
                );
            }
        }
    }
}
