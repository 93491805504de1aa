//! Contact geometry: which points of two parts touch, where, how deep, and along which normal.
//!
//! Everything happens in the frame and the length unit of `a`; `b_to_a` maps the body frame of `b` there. Normals
//! point from `a` to `b`, positions lie halfway between the surfaces, and only points that touch are reported.

mod active_set;
mod apart;
mod clipping;
mod closest;
mod cylinder;
mod cylinder_cylinder;
mod cylinder_facets;
mod cylinder_polyhedron;
mod cylinder_rounded;
mod cylinder_wall;
mod ellipse;
mod face_contact;
pub mod features;
pub mod generalized_overlap;
mod manifold;
mod outline;
pub mod overlap_volume;
mod polyhedron_polyhedron;
mod rims;
mod roller;
mod round;
mod segments;
mod separating_axis;
mod sphere_cylinder;
mod sphere_polyhedron;
mod sphere_sphere;
mod sphere_spherocylinder;
mod spherocylinder_cylinder;
mod spherocylinder_polyhedron;
mod spherocylinder_spherocylinder;
#[cfg(test)]
mod tests;
mod wall;

pub use active_set::PairCache;
pub use apart::apart_by;
pub use closest::{Nearest, above_face, closest_on_segment, farthest_face, point_polyhedron, segment_segment};
pub(crate) use cylinder::{RING_POINTS, Solid};
pub use cylinder_cylinder::cylinder_cylinder;
pub use cylinder_polyhedron::cylinder_polyhedron;
pub use cylinder_rounded::cylinder_rounded;
pub use manifold::{FeatureKey, MAX_POINTS, Manifold, ManifoldPoint};
pub use polyhedron_polyhedron::polyhedron_polyhedron;
pub use roller::part_roller;
pub(crate) use segments::SegmentPair;
pub use sphere_cylinder::sphere_cylinder;
pub use sphere_polyhedron::sphere_polyhedron;
pub use sphere_sphere::sphere_sphere;
pub use sphere_spherocylinder::sphere_spherocylinder;
pub use spherocylinder_cylinder::spherocylinder_cylinder;
pub use spherocylinder_polyhedron::spherocylinder_polyhedron;
pub(crate) use spherocylinder_spherocylinder::round_rods;
pub use spherocylinder_spherocylinder::spherocylinder_spherocylinder;
pub use wall::{part_cylinder, part_plane};

use crate::math::{Similarity, Vec3};
use crate::shape::{Part, PartGeometry};
use features::{FeatureList, FeaturePair};

/// A ball, as the functions of this module take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its centre.
    pub center: Vec3,
    /// Its radius.
    pub radius: f64,
}

/// All points within `radius` of a segment, as the functions of this module take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spherocylinder {
    /// Ends of the segment.
    pub ends: [Vec3; 2],
    /// Radius of cylinder and caps.
    pub radius: f64,
}

/// A solid cylinder with flat caps, as the functions of this module take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Centres of the caps.
    pub ends: [Vec3; 2],
    /// Its radius.
    pub radius: f64,
}

/// Which function answers for a pair of parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PairKind {
    /// [`sphere_sphere`].
    SphereSphere,
    /// [`sphere_spherocylinder`].
    SphereSpherocylinder,
    /// [`spherocylinder_spherocylinder`].
    SpherocylinderSpherocylinder,
    /// [`sphere_cylinder`].
    SphereCylinder,
    /// [`spherocylinder_cylinder`].
    SpherocylinderCylinder,
    /// [`cylinder_cylinder`].
    CylinderCylinder,
    /// [`cylinder_polyhedron`].
    CylinderPolyhedron,
    /// [`cylinder_rounded`].
    CylinderRounded,
    /// [`sphere_polyhedron`].
    SpherePolyhedron,
    /// [`spherocylinder_polyhedron`].
    SpherocylinderPolyhedron,
    /// [`polyhedron_polyhedron`].
    PolyhedronPolyhedron,
    /// [`FeaturePair`]: one or both are rounded polyhedra, none a cylinder.
    Features,
}

/// The kind of a pair, for batches, and whether its function takes the parts in the other order.
pub fn pair_kind(a: &PartGeometry, b: &PartGeometry) -> (PairKind, bool) {
    use PairKind as K;
    use PartGeometry as P;
    match (a, b) {
        (P::Sphere { .. }, P::Sphere { .. }) => (K::SphereSphere, false),
        (P::Sphere { .. }, P::Spherocylinder { .. }) => (K::SphereSpherocylinder, false),
        (P::Sphere { .. }, P::Polyhedron(_)) => (K::SpherePolyhedron, false),
        (P::Spherocylinder { .. }, P::Sphere { .. }) => (K::SphereSpherocylinder, true),
        (P::Spherocylinder { .. }, P::Spherocylinder { .. }) => (K::SpherocylinderSpherocylinder, false),
        (P::Spherocylinder { .. }, P::Polyhedron(_)) => (K::SpherocylinderPolyhedron, false),
        (P::Sphere { .. }, P::Cylinder { .. }) => (K::SphereCylinder, false),
        (P::Spherocylinder { .. }, P::Cylinder { .. }) => (K::SpherocylinderCylinder, false),
        (P::Cylinder { .. }, P::Sphere { .. }) => (K::SphereCylinder, true),
        (P::Cylinder { .. }, P::Spherocylinder { .. }) => (K::SpherocylinderCylinder, true),
        (P::Polyhedron(_), P::Sphere { .. }) => (K::SpherePolyhedron, true),
        (P::Polyhedron(_), P::Spherocylinder { .. }) => (K::SpherocylinderPolyhedron, true),
        (P::Polyhedron(_), P::Polyhedron(_)) => (K::PolyhedronPolyhedron, false),
        (P::Cylinder { .. }, P::Cylinder { .. }) => (K::CylinderCylinder, false),
        (P::Cylinder { .. }, P::Polyhedron(_)) => (K::CylinderPolyhedron, false),
        (P::Polyhedron(_), P::Cylinder { .. }) => (K::CylinderPolyhedron, true),
        (P::Cylinder { .. }, P::RoundedPolyhedron(_)) => (K::CylinderRounded, false),
        (P::RoundedPolyhedron(_), P::Cylinder { .. }) => (K::CylinderRounded, true),
        (P::RoundedPolyhedron(_), _) | (_, P::RoundedPolyhedron(_)) => (K::Features, false),
    }
}

/// Appends the contact points of two parts to `out`. `cache` is kept per pair from step to step.
pub fn collide(a: &Part, b: &Part, b_to_a: &Similarity, cache: &mut PairCache, out: &mut Manifold) {
    let reach = a.radius + b.radius * b_to_a.scale;
    if (b_to_a.point(&b.center) - a.center).norm_squared() > reach * reach {
        return;
    }
    if pair_kind(&a.geometry, &b.geometry).1 {
        let first = out.len();
        collide_in_order(b, a, &b_to_a.inverse(), cache, out);
        out.map_from(first, b_to_a);
        out.flip_from(first);
    } else {
        collide_in_order(a, b, b_to_a, cache, out);
    }
}

/// All pairs of features, without a list: for single questions, not for the step.
fn feature_points(a: &Part, b: &Part, b_to_a: &Similarity, out: &mut Manifold) {
    let (Some(a), Some(b)) = (&a.skeleton, &b.skeleton) else { return };
    let pair = FeaturePair { a, b, b_to_a };
    let mut list = FeatureList::default();
    pair.all_candidates(&mut list);
    for (feature, contact) in list.contacts(&pair) {
        let features::FeatureContact { overlap, normal, position } = contact;
        out.push_deepest(ManifoldPoint { position, normal, overlap, share: 1.0, feature });
    }
}

/// Runs a test that answers with a gap or minus a depth, unless the gap of an earlier one cannot have closed yet. It is told
/// how far the parts are apart at most.
fn unless_apart(cache: &mut PairCache, parts: (&Part, &Part), b_to_a: &Similarity, test: impl FnOnce(f64) -> f64) {
    if cache.are_apart(b_to_a) {
        return;
    }
    let separation = test(cache.apart_at_most(b_to_a));
    cache.learn(separation, parts, b_to_a);
}

/// The table of pairs; the other orders come here swapped.
fn collide_in_order(a: &Part, b: &Part, b_to_a: &Similarity, cache: &mut PairCache, out: &mut Manifold) {
    use PartGeometry as P;
    let sphere = |center: &Vec3, radius: f64| Sphere { center: *center, radius };
    let capsule = |ends: &[Vec3; 2], radius: f64| Spherocylinder { ends: *ends, radius };
    let cylinder = |ends: &[Vec3; 2], radius: f64| Cylinder { ends: *ends, radius };
    match (&a.geometry, &b.geometry) {
        (P::Sphere { center: c, radius: r }, P::Sphere { center: d, radius: s }) => {
            sphere_sphere(&sphere(c, *r), &sphere(d, *s), b_to_a, out);
        }
        (P::Sphere { center, radius: r }, P::Spherocylinder { ends, radius: s }) => {
            sphere_spherocylinder(&sphere(center, *r), &capsule(ends, *s), b_to_a, out);
        }
        (P::Spherocylinder { ends: d, radius: r }, P::Spherocylinder { ends: e, radius: s }) => {
            spherocylinder_spherocylinder(&capsule(d, *r), &capsule(e, *s), b_to_a, out);
        }
        (P::Sphere { center, radius: r }, P::Cylinder { ends, radius: s }) => {
            sphere_cylinder(&sphere(center, *r), &cylinder(ends, *s), b_to_a, out);
        }
        (P::Spherocylinder { ends: d, radius: r }, P::Cylinder { ends: e, radius: s }) => {
            spherocylinder_cylinder(&capsule(d, *r), &cylinder(e, *s), b_to_a, out);
        }
        (P::Cylinder { ends: d, radius: r }, P::Cylinder { ends: e, radius: s }) => {
            unless_apart(cache, (a, b), b_to_a, |apart| {
                cylinder_cylinder((&cylinder(d, *r), &cylinder(e, *s)), b_to_a, apart, out)
            });
        }
        (P::Cylinder { ends, radius }, P::Polyhedron(q)) => {
            unless_apart(cache, (a, b), b_to_a, |apart| {
                cylinder_polyhedron((a, &cylinder(ends, *radius)), (b, q), (b_to_a, apart), out)
            });
        }
        (P::Cylinder { ends, radius }, P::RoundedPolyhedron(q)) => {
            unless_apart(cache, (a, b), b_to_a, |_| {
                cylinder_rounded((a, &cylinder(ends, *radius)), (b, q), b_to_a, out)
            });
        }
        (P::Sphere { center, radius }, P::Polyhedron(q)) => {
            sphere_polyhedron(&sphere(center, *radius), q, b_to_a, out);
        }
        (P::Spherocylinder { ends, radius }, P::Polyhedron(q)) => {
            spherocylinder_polyhedron(&capsule(ends, *radius), q, b_to_a, out);
        }
        (P::Polyhedron(p), P::Polyhedron(q)) => polyhedron_polyhedron((a, p), (b, q), b_to_a, cache, out),
        (P::RoundedPolyhedron(_), _) | (_, P::RoundedPolyhedron(_)) => feature_points(a, b, b_to_a, out),
        _ => unreachable!("collide swaps the other orders"),
    }
}
