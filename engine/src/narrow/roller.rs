//! Parts against the outside of a cylinder: a spherocylinder that is longer than the part can see.
//!
//! The part is `a` and the roller is `b`, as in the other walls; the functions for pairs answer.

use super::{Manifold, PairCache, collide};
use crate::math::{Similarity, Vec3};
use crate::shape::{Part, PartGeometry};

/// Half of the segment over the bounding radius of the part: no contact is near an end.
const BEYOND: f64 = 2.0;

/// Contacts with the cylinder of this radius about z, free where the distance from z is above it.
pub fn part_roller(part: &Part, body_to_wall: &Similarity, roller_radius: f64, out: &mut Manifold) {
    let center = body_to_wall.point(&part.center);
    let reach = part.radius * body_to_wall.scale;
    if (center.x * center.x + center.y * center.y).sqrt() >= roller_radius + reach {
        return;
    }
    let end = |sign: f64| Vec3::new(0.0, 0.0, center.z + sign * BEYOND * reach);
    let segment = PartGeometry::Spherocylinder { ends: [end(-1.0), end(1.0)], radius: roller_radius };
    let roller = if part.is_rounded_polyhedron() {
        Part::new(segment)
    } else {
        // features are for rounded polyhedra only, and cost allocations
        let (center, radius) = (Vec3::new(0.0, 0.0, center.z), roller_radius + BEYOND * reach);
        Part { center, radius, spine: None, geometry: segment, skeleton: None }
    };
    let first = out.len();
    collide(part, &roller, &body_to_wall.inverse(), &mut PairCache::default(), out);
    out.map_from(first, body_to_wall);
}
