//! The narrow phase against closed forms and independent brute force.

mod cylinder;
mod cylinder_rounded;
mod degenerate;
mod generic;
mod oracle;
mod roller;
mod round;
mod walls;

use crate::math::{Mat3, Quat, Similarity, Vec3};
use crate::narrow::{Manifold, PairCache, collide};
use crate::shape::{Part, PartGeometry, Polyhedron, Shape, ShapeDescription};

/// A small deterministic generator (SplitMix64): the same cases on every machine.
pub(super) struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    pub fn in_ball(&mut self) -> Vec3 {
        loop {
            let v = Vec3::from_fn(|_, _| self.between(-1.0, 1.0));
            if v.norm() <= 1.0 && v.norm() > 1e-3 {
                return v;
            }
        }
    }

    pub fn direction(&mut self) -> Vec3 {
        self.in_ball().normalize()
    }

    pub fn rotation(&mut self) -> Mat3 {
        let (axis, angle) = (self.direction(), self.between(0.0, std::f64::consts::PI));
        rotation(axis, angle)
    }
}

pub(super) fn rotation(axis: Vec3, angle: f64) -> Mat3 {
    *Quat::from_scaled_axis(axis.normalize() * angle).to_rotation_matrix().matrix()
}

pub(super) fn part(description: &ShapeDescription) -> Part {
    let shape = Shape::build(description).expect("a valid shape");
    assert_eq!(shape.parts().len(), 1);
    shape.parts()[0].clone()
}

pub(super) fn cuboid(x: f64, y: f64, z: f64) -> Part {
    part(&ShapeDescription::Box { size_m: [x, y, z] })
}

pub(super) fn cube() -> Part {
    part(&ShapeDescription::Cube { edge_m: 1.0 })
}

pub(super) fn pinacoid(size: f64) -> Part {
    part(&ShapeDescription::Pinacoid { length_m: size, width_m: size, height_m: size, alpha_deg: 60.0 })
}

pub(super) fn hull(points: &[Vec3]) -> Part {
    part(&ShapeDescription::ConvexPolyhedron { vertices_m: points.iter().map(|p| [p.x, p.y, p.z]).collect() })
}

/// A regular prism about z, of unit radius.
pub(super) fn prism(sides: usize, height: f64) -> Part {
    let at = |k: usize, z: f64| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / sides as f64).sin_cos();
        Vec3::new(cos, sin, z)
    };
    let points: Vec<Vec3> = (0..sides).flat_map(|k| [at(k, -0.5 * height), at(k, 0.5 * height)]).collect();
    hull(&points)
}

pub(super) fn random_hull(random: &mut Random) -> Part {
    let count = 6 + random.below(12);
    let stretch = Vec3::from_fn(|_, _| random.between(0.5, 1.0));
    let points: Vec<Vec3> = (0..count).map(|_| random.direction().component_mul(&stretch)).collect();
    hull(&points)
}

pub(super) fn solid(part: &Part) -> &Polyhedron {
    let PartGeometry::Polyhedron(p) = &part.geometry else { panic!("not a polyhedron") };
    p
}

pub(super) fn contacts(a: &Part, b: &Part, b_to_a: &Similarity) -> Manifold {
    let mut out = Manifold::default();
    collide(a, b, b_to_a, &mut PairCache::default(), &mut out);
    out
}

pub(super) fn depth(manifold: &Manifold) -> f64 {
    manifold.points().iter().map(|p| p.overlap).fold(0.0, f64::max)
}
