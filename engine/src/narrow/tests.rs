//! The narrow phase against closed forms and independent brute force.

use super::*;
use crate::math::{Mat3, Similarity};
use crate::shape::{Shape, ShapeDescription};

fn cube() -> Shape {
    Shape::build(&ShapeDescription::Cube { edge_m: 1.0 }).unwrap()
}

#[test]
fn aligned_cubes_give_four_equal_points() {
    let shape = cube();
    let part = &shape.parts()[0];
    let mut out = Manifold::default();
    let pose = Similarity::rigid(Mat3::identity(), Vec3::new(0.0, 0.0, 0.99));
    collide(part, part, &pose, &mut 0, &mut out);
    assert_eq!(out.len(), 4);
    for p in out.points() {
        assert!((p.overlap - 0.01).abs() < 1e-15 && (p.share - out.points()[0].share).abs() < 1e-15);
        assert_eq!(p.normal, Vec3::z());
        assert_eq!(p.feature.kind(), 1);
    }
}
