//! The poses that settled packings are made of, exact and almost exact (PHYSICS E).

use super::oracle::check_pair;
use super::*;
use crate::narrow::FeatureKey;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

const TILTS: [f64; 9] = [0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2];

fn at(rotation: Mat3, x: f64, y: f64, z: f64) -> Similarity {
    Similarity::rigid(rotation, Vec3::new(x, y, z))
}

#[test]
fn aligned_cubes_give_four_equal_points() {
    let a = cube();
    for quarter in 0..4 {
        let turn = rotation(Vec3::z(), FRAC_PI_2 * f64::from(quarter));
        let manifold = contacts(&a, &a, &at(turn, 0.0, 0.0, 0.99));
        assert_eq!(manifold.len(), 4);
        for p in manifold.points() {
            // rounding of the pose
            assert!((p.overlap - 0.01).abs() < 1e-15);
            assert!((p.share - manifold.points()[0].share).abs() < 1e-14 && (p.share - 1.0).abs() < 1e-8);
            assert!((p.normal - Vec3::z()).norm() < 1e-15);
            assert_eq!(p.feature.kind(), 1, "a vertex of a goes first");
        }
    }
}

#[test]
fn aligned_and_tilted_cubes_in_every_offset() {
    let a = cube();
    for quarter in 0..4 {
        for tilt in TILTS {
            for (x, y) in [(0.0, 0.0), (0.5, 0.0), (0.3, 0.2), (1e-13, 0.0), (0.999, 0.0), (1.0 - 1e-9, 0.4)] {
                for depth in [1e-8, 1e-4, 1e-2] {
                    for axis in [Vec3::x(), Vec3::y(), Vec3::z(), Vec3::new(1.0, 0.3, 0.2)] {
                        let turn = rotation(axis, tilt) * rotation(Vec3::z(), FRAC_PI_2 * f64::from(quarter));
                        let label =
                            format!("quarter {quarter} tilt {tilt:e} about {axis:?} at {x} {y} depth {depth:e}");
                        let pose = at(turn, x, y, 1.0 - depth);
                        check_pair(&a, &a, &pose, &label);
                        if tilt < 1e-9 && tilt < 1e-3 * depth && x < 0.9 {
                            let manifold = contacts(&a, &a, &pose);
                            assert_eq!(manifold.len(), 4, "{label}");
                            assert!((manifold.points()[0].normal - Vec3::z()).norm() <= 2.0 * tilt + 1e-14, "{label}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn edges_on_faces_and_on_edges() {
    let a = cube();
    let half = 0.5 * 2.0_f64.sqrt();
    for tilt in TILTS {
        for depth in [1e-8, 1e-4, 1e-2] {
            let on_edge = rotation(Vec3::x(), FRAC_PI_4);
            for axis in [Vec3::y(), Vec3::z(), Vec3::new(0.2, 1.0, 0.4)] {
                let turn = rotation(axis, tilt) * on_edge;
                let label = format!("tilt {tilt:e} about {axis:?} depth {depth:e}");
                check_pair(&a, &a, &at(turn, 0.1, 0.0, 0.5 + half - depth), &format!("edge on face, {label}"));
                check_pair(&a, &a, &at(turn, 0.1, 0.5, 0.5 + half - depth), &format!("edge over rim, {label}"));
                let other = Part::new(PartGeometry::Polyhedron(solid(&a).transformed(&on_edge, &Vec3::zeros())));
                check_pair(&other, &a, &at(turn, 0.1, 0.0, 2.0 * half - depth), &format!("parallel edges, {label}"));
                check_pair(
                    &other,
                    &a,
                    &at(turn, 0.1, 0.01, 2.0 * half - depth),
                    &format!("parallel edges beside, {label}"),
                );
                let crossed = rotation(Vec3::z(), FRAC_PI_2) * turn;
                check_pair(&other, &a, &at(crossed, 0.1, 0.1, 2.0 * half - depth), &format!("crossed edges, {label}"));
            }
        }
    }
}

/// Nearly parallel edges off the coordinate axes: their cross product is rounding over |sin|, and must not be believed.
#[test]
fn nearly_parallel_edges_in_skew_frames() {
    let mut random = Random(50);
    let on_edge = rotation(Vec3::x(), FRAC_PI_4);
    let half = 0.5 * 2.0_f64.sqrt();
    for case in 0..4_000 {
        let skew = random.rotation();
        let a = Part::new(PartGeometry::Polyhedron(solid(&cube()).transformed(&(skew * on_edge), &Vec3::zeros())));
        let tilt = rotation(random.direction(), 10_f64.powf(random.between(-16.0, -3.0)));
        let depth = 10_f64.powf(random.between(-8.0, -1.0));
        let (x, y) = (random.between(-0.5, 0.5), random.between(-1e-3, 1e-3));
        let translation = skew * Vec3::new(x, y, 2.0 * half - depth);
        check_pair(&a, &cube(), &Similarity::rigid(skew * tilt * on_edge, translation), &format!("case {case}"));
    }
}

/// A wedge with a flat chamfer at the end of its ridge stands on the other end: the chamfer looks at the plate most
/// squarely of all faces, but does not hold the vertex that touches.
#[test]
fn the_squarest_face_need_not_hold_the_deepest_vertex() {
    let points = [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.3, 0.3], [2.0, -0.3, 0.3]];
    let top = [[2.0, 1.0, 1.0], [2.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0]];
    let vertices_m = points.into_iter().chain(top).collect();
    let shape = Shape::build(&ShapeDescription::ConvexPolyhedron { vertices_m }).unwrap();
    // back from the principal axes, so that the ridge lies along x
    let (rotation_to_given, center) = shape.given_from_body();
    let to_given = *rotation_to_given.to_rotation_matrix().matrix();
    let wedge = Part::new(PartGeometry::Polyhedron(solid(&shape.parts()[0]).transformed(&to_given, &center)));
    let plate = cuboid(20.0, 20.0, 1.0);
    let lowest = solid(&wedge).vertices().iter().map(|v| v.z).fold(f64::MAX, f64::min);
    for tilt in [1e-6, 1e-4, 1e-2] {
        for depth in [1e-7, 1e-5, 1e-3] {
            let pose = at(rotation(Vec3::y(), -tilt), 0.0, 0.0, 0.5 - lowest - depth);
            check_pair(&plate, &wedge, &pose, &format!("tilt {tilt:e} depth {depth:e}"));
            check_pair(&wedge, &plate, &pose.inverse(), &format!("swapped, tilt {tilt:e} depth {depth:e}"));
        }
    }
    for tilt in [0.0, 1e-14, -1e-14] {
        // the whole ridge lies on the plate: both its ends carry, whichever is the deeper one by rounding
        let pose = at(rotation(Vec3::y(), tilt), 0.0, 0.0, 0.5 - lowest - 1e-3);
        assert_eq!(contacts(&plate, &wedge, &pose).len(), 2, "tilt {tilt:e}");
    }
}

#[test]
fn vertices_on_everything() {
    let a = cube();
    let corner_down = rotation(Vec3::new(1.0, -1.0, 0.0), (1.0 / 3.0_f64.sqrt()).acos());
    let half = 0.5 * 3.0_f64.sqrt();
    let up = Part::new(PartGeometry::Polyhedron(solid(&a).transformed(&corner_down, &Vec3::zeros())));
    for depth in [1e-8, 1e-4, 1e-2] {
        for shift in [0.0, 1e-16, 1e-12, 1e-6] {
            check_pair(&up, &a, &at(corner_down, shift, 0.0, 2.0 * half - depth), "vertex on vertex");
            check_pair(&a, &a, &at(corner_down, shift, 0.2, 0.5 + half - depth), "vertex on face");
            check_pair(&a, &a, &at(corner_down, 0.5 + shift, 0.2, 0.5 + half - depth), "vertex on edge");
            check_pair(&a, &a, &at(corner_down, 0.5 + shift, 0.5, 0.5 + half - depth), "vertex on corner");
        }
    }
    check_pair(&a, &a, &at(Mat3::identity(), 1.0 - 1e-3, 1.0 - 1e-3, 1.0 - 1e-3), "corner in corner");
}

#[test]
fn identical_coincident_and_inside() {
    for shape in [cube(), pinacoid(1.0), prism(16, 0.5), cuboid(1.0, 1.0, 0.01)] {
        check_pair(&shape, &shape, &Similarity::identity(), "identical pose");
        for scale in [1e-3, 0.1, 0.5, 2.0, 1e3] {
            check_pair(&shape, &shape, &Similarity { scale, ..Similarity::identity() }, "concentric");
            let turn = rotation(Vec3::new(1.0, 2.0, 3.0), 0.7);
            let pose = Similarity { rotation: turn, translation: Vec3::new(0.01, 0.0, 0.0), scale };
            check_pair(&shape, &shape, &pose, "inside");
        }
    }
}

#[test]
fn faces_of_many_corners() {
    for sides in [5, 6, 16] {
        let a = prism(sides, 1.0);
        for (yaw, x) in [(0.0, 0.0), (0.1, 0.0), (0.0, 0.7), (0.2, 1.1)] {
            for tilt in TILTS {
                let turn = rotation(Vec3::new(1.0, 0.2, 0.0), tilt) * rotation(Vec3::z(), yaw);
                check_pair(&a, &a, &at(turn, x, 0.0, 0.99), &format!("{sides} sides, yaw {yaw}, tilt {tilt:e}"));
            }
        }
        let exact = contacts(&a, &a, &at(Mat3::identity(), 0.0, 0.0, 0.99));
        assert_eq!(exact.len(), sides);
        let turned = contacts(&a, &a, &at(rotation(Vec3::z(), std::f64::consts::PI / sides as f64), 0.0, 0.0, 0.99));
        assert_eq!(turned.len(), 2 * sides, "a star has a corner wherever two edges cross");
        assert!(turned.points().iter().all(|p| p.feature.kind() == 3));
    }
}

/// Depths of rounding size: no NaN, no wrong sign, and never more than the true depth plus rounding.
#[test]
fn grazing_contacts_are_finite() {
    let a = cube();
    for gap in [0.0, 1e-16, -1e-16, 2e-16, -2e-16, 1e-15, -1e-15] {
        for turn in [Mat3::identity(), rotation(Vec3::z(), 0.3)] {
            for p in contacts(&a, &a, &at(turn, 0.2, 0.1, 1.0 + gap)).points() {
                assert!(p.overlap > 0.0 && p.overlap < 1e-14 && (p.normal - Vec3::z()).norm() < 1e-14);
            }
        }
    }
}

/// Which part is the reference must not show: tilting across zero changes the reference, not the keys.
#[test]
fn keys_do_not_depend_on_the_reference() {
    let (a, b) = (cube(), cuboid(0.6, 1.4, 1.0));
    let keys = |tilt: f64, a: &Part, b: &Part| {
        let turn = rotation(Vec3::x(), tilt) * rotation(Vec3::z(), 0.1);
        let mut keys: Vec<FeatureKey> =
            contacts(a, b, &at(turn, 0.05, 0.02, 0.99)).points().iter().map(|p| p.feature).collect();
        keys.sort();
        keys
    };
    // 1e-7 rad decides which face is the least axis
    assert_eq!(keys(1e-7, &a, &b), keys(-1e-7, &a, &b));
    let direct = keys(0.0, &a, &b);
    let mut swapped: Vec<FeatureKey> = {
        let turn = rotation(Vec3::z(), 0.1);
        let pose = at(turn, 0.05, 0.02, 0.99).inverse();
        contacts(&b, &a, &pose).points().iter().map(|p| p.feature.swapped()).collect()
    };
    swapped.sort();
    assert_eq!(direct, swapped);
    assert!(direct.iter().any(|k| k.kind() == 3), "a yawed pair has crossing edges");
}

/// Shares are continuous where corners of the polygon meet: sliding a cube over the other by tiny steps.
#[test]
fn shares_and_overlaps_are_continuous_over_the_rim() {
    let a = cube();
    let turn = rotation(Vec3::x(), 1e-3) * rotation(Vec3::z(), 0.05);
    let moments = |x: f64| {
        let manifold = contacts(&a, &a, &at(turn, x, 0.0, 0.995));
        let total: f64 = manifold.points().iter().map(|p| p.share).sum();
        let mean = |f: &dyn Fn(&crate::narrow::ManifoldPoint) -> f64| {
            manifold.points().iter().map(|p| p.share * f(p)).sum::<f64>() / total
        };
        Vec3::new(mean(&|p| p.overlap), mean(&|p| p.position.x * p.overlap), mean(&|p| p.position.y * p.overlap))
    };
    let step = 1e-5;
    let mut last = moments(-0.5);
    for k in 1..100_000 {
        let now = moments(-0.5 + step * f64::from(k));
        // the slope is of order one, times the overlap of 5e-3
        assert!(
            (now - last).norm() < 20.0 * step * 5e-3,
            "jump of {:e} at {}",
            (now - last).norm(),
            step * f64::from(k)
        );
        last = now;
    }
}
