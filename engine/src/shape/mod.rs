//! Shapes: unions of convex parts in the body frame (centre of mass at the origin, principal axes).

mod build;
mod description;
mod error;
mod hull;
mod import;
mod inset;
mod leverage;
mod mass;
mod polyhedron;
mod rounded_build;
mod rounded_mass;
mod skeleton;
mod skeleton_topology;
mod solids;
mod spine;
mod surface;
mod union;

pub use description::{MassDescription, PartDescription, ShapeDescription};
pub use error::ShapeError;
pub use import::{ImportError, ImportedShape, rockable_shapes};
pub use leverage::Leverage;
pub use mass::MassProperties;
pub(crate) use polyhedron::Parallels;
pub use polyhedron::{Edge, Face, MAX_EDGES, MAX_FACE_VERTICES, Polyhedron};
pub use skeleton::{MAX_FEATURES, Side, Skeleton, SkeletonEdge, SkeletonFace};
pub use spine::Spine;
pub use surface::SurfaceMesh;

#[cfg(test)]
mod tests;

use crate::math::{Mat3, Quat, Vec3};
use crate::narrow::{RING_POINTS, Solid};

/// A checked shape. Immutable; shared by all particles of its kind, which scale it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    parts: Vec<Part>,
    mass_properties: MassProperties,
    bounding_radius: f64,
    leverage: Leverage,
    half_thickness: f64,
    given_from_body: (Quat, Vec3),
}

/// A convex part, in the body frame of its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Centre of the bounding sphere.
    pub center: Vec3,
    /// Radius of the bounding sphere.
    pub radius: f64,
    /// A bounding spherocylinder, where the ball is mostly empty.
    pub spine: Option<Spine>,
    /// The surface.
    pub geometry: PartGeometry,
    /// What meets a rounded polyhedron: the part as a skeleton swept by a ball. `None` if it has too many features, or
    /// is a cylinder, whose rims are no edges and which meets it by a function of its own.
    pub skeleton: Option<Box<Skeleton>>,
}

/// A skeleton swept by a ball.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundedPolyhedron {
    /// Vertices, edges, faces and the radius.
    pub skeleton: Skeleton,
    /// The skeleton as a convex polyhedron, where it is one.
    pub solid: Option<Polyhedron>,
}

/// The convex geometries that the narrow phase knows.
#[derive(Clone, Debug, PartialEq)]
pub enum PartGeometry {
    /// A ball.
    Sphere {
        /// Its centre.
        center: Vec3,
        /// Its radius.
        radius: f64,
    },
    /// All points within `radius` of a segment.
    Spherocylinder {
        /// Ends of the segment.
        ends: [Vec3; 2],
        /// Radius of cylinder and caps.
        radius: f64,
    },
    /// A solid cylinder with flat caps.
    Cylinder {
        /// Centres of the caps.
        ends: [Vec3; 2],
        /// Its radius.
        radius: f64,
    },
    /// A convex polyhedron.
    Polyhedron(Polyhedron),
    /// A polyhedron, convex or not, swept by a ball.
    RoundedPolyhedron(Box<RoundedPolyhedron>),
}

impl Shape {
    /// Checks a description and computes all that does not depend on the particle.
    pub fn build(description: &ShapeDescription) -> Result<Self, ShapeError> {
        let assembly = build::assemble(description)?;
        let size = assembly.parts.iter().map(|p| p.center.norm() + p.radius).fold(0.0, f64::max);
        let (center, axes, mass_properties) = mass::principal(&assembly.moments, size, assembly.relative_error);
        let (turn, shift) = (axes.transpose(), -(axes.transpose() * center));
        let parts: Vec<Part> = assembly.parts.iter().map(|p| p.transformed(&turn, &shift)).collect();
        let bounding_radius = parts.iter().map(Part::reach).fold(0.0, f64::max);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let given_from_body = (Quat::from_rotation_matrix(&rotation), center);
        let leverage = Leverage::of(&parts, &mass_properties);
        let half_thickness = parts.iter().map(Part::half_thickness).fold(f64::INFINITY, f64::min);
        Ok(Self { parts, mass_properties, bounding_radius, leverage, half_thickness, given_from_body })
    }

    /// Mass properties by the lattice integral alone, also where [`Shape::build`] knows the exact ones.
    ///
    /// Cells at the surface are halved `halvings` times (1 to 7), to 1/(16 x 2^halvings) of the longest side of the bounds;
    /// `build` takes 5 where it has no exact integral (parts that overlap and are not aligned boxes). To measure the
    /// stated error and the cost, which grows by 4 with each halving.
    pub fn integrate_on_lattice(description: &ShapeDescription, halvings: u32) -> Result<MassProperties, ShapeError> {
        let (parts, _) = build::placed_parts(description)?;
        let size = parts.iter().map(|p| p.center.norm() + p.radius).fold(0.0, f64::max);
        let (moments, relative_error) = union::lattice(&parts, halvings.clamp(1, 7));
        Ok(mass::principal(&moments, size, relative_error).2)
    }

    /// The same body with its polyhedra rounded: `round` gives the core of each and the radius of the ball swept over
    /// it. Mass properties stay.
    pub(crate) fn with_rounded_parts(
        &self,
        mut round: impl FnMut(&Polyhedron) -> Result<(Polyhedron, f64), String>,
    ) -> Result<Self, String> {
        let mut new = self.clone();
        for part in &mut new.parts {
            let PartGeometry::Polyhedron(solid) = &part.geometry else { continue };
            let (core, radius) = round(solid)?;
            let skeleton = Skeleton::of_polyhedron(&core, radius)
                .ok_or_else(|| format!("it has more than {MAX_FEATURES} features"))?;
            let rounded = RoundedPolyhedron { skeleton, solid: Some(core) };
            *part = Part::new(PartGeometry::RoundedPolyhedron(Box::new(rounded)));
        }
        new.leverage = Leverage::of(&new.parts, &new.mass_properties);
        Ok(new)
    }

    /// Convex parts, in the body frame.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Volume and inertia per unit density.
    pub fn mass_properties(&self) -> &MassProperties {
        &self.mass_properties
    }

    /// Of the sphere about the centre of mass that holds the shape.
    pub fn bounding_radius(&self) -> f64 {
        self.bounding_radius
    }

    /// What rotation adds to the give of a contact, at its worst place.
    pub fn leverage(&self) -> Leverage {
        self.leverage
    }

    /// Of the thinnest part, m at unit scale: what moves by less in a step cannot pass through without being seen.
    pub fn half_thickness(&self) -> f64 {
        self.half_thickness
    }

    /// Rotation and translation from the body frame to the frame of the description: `x = rotation * x_body + translation`.
    pub fn given_from_body(&self) -> (Quat, Vec3) {
        self.given_from_body
    }

    /// Whether a point of the body frame lies in any of the parts.
    pub fn contains(&self, x: &Vec3) -> bool {
        self.parts.iter().any(|part| union::depth_inside(part, x) >= 0.0)
    }

    /// A triangulated surface for drawing, in the body frame.
    pub fn surface(&self) -> SurfaceMesh {
        SurfaceMesh::of_parts(&self.parts)
    }
}

impl Part {
    /// With the bounding sphere about the middle of the bounding box.
    pub(crate) fn new(geometry: PartGeometry) -> Self {
        let (center, radius) = match &geometry {
            PartGeometry::Sphere { center, radius } => (*center, *radius),
            PartGeometry::Spherocylinder { ends, radius } => {
                ((ends[0] + ends[1]) * 0.5, 0.5 * (ends[1] - ends[0]).norm() + radius)
            }
            PartGeometry::Cylinder { ends, radius } => {
                ((ends[0] + ends[1]) * 0.5, (0.5 * (ends[1] - ends[0]).norm()).hypot(*radius))
            }
            PartGeometry::Polyhedron(p) => ball_around(p.vertices()),
            PartGeometry::RoundedPolyhedron(p) => {
                let (center, radius) = ball_around(p.skeleton.vertices());
                (center, radius + p.skeleton.radius)
            }
        };
        let skeleton = match &geometry {
            PartGeometry::Sphere { center, radius } => Some(Skeleton::segment(&[*center], *radius)),
            PartGeometry::Spherocylinder { ends, radius } => Some(Skeleton::segment(ends, *radius)),
            PartGeometry::Cylinder { .. } => None,
            PartGeometry::Polyhedron(p) => Skeleton::of_polyhedron(p, 0.0),
            PartGeometry::RoundedPolyhedron(p) => Some(p.skeleton.clone()),
        };
        // a little more than measured, so that rounding cannot leave a corner outside
        let radius = radius * (1.0 + 1e-14);
        Self { center, radius, spine: Spine::of(&geometry, radius), geometry, skeleton: skeleton.map(Box::new) }
    }

    fn transformed(&self, rotation: &Mat3, translation: &Vec3) -> Self {
        let to_body = |x: &Vec3| rotation * x + translation;
        Self::new(match &self.geometry {
            PartGeometry::Sphere { center, radius } => {
                PartGeometry::Sphere { center: to_body(center), radius: *radius }
            }
            PartGeometry::Spherocylinder { ends, radius } => {
                PartGeometry::Spherocylinder { ends: [to_body(&ends[0]), to_body(&ends[1])], radius: *radius }
            }
            PartGeometry::Cylinder { ends, radius } => {
                PartGeometry::Cylinder { ends: [to_body(&ends[0]), to_body(&ends[1])], radius: *radius }
            }
            PartGeometry::Polyhedron(p) => PartGeometry::Polyhedron(p.transformed(rotation, translation)),
            PartGeometry::RoundedPolyhedron(p) => {
                PartGeometry::RoundedPolyhedron(Box::new(p.transformed(rotation, translation)))
            }
        })
    }

    /// Radius of a round part (of a cylinder: about its axis), of the bounding sphere of a polyhedron.
    pub(crate) fn contact_radius(&self) -> f64 {
        match &self.geometry {
            PartGeometry::Sphere { radius, .. }
            | PartGeometry::Spherocylinder { radius, .. }
            | PartGeometry::Cylinder { radius, .. } => *radius,
            PartGeometry::Polyhedron(_) | PartGeometry::RoundedPolyhedron(_) => self.radius,
        }
    }

    /// Radius of a round part, of the largest ball in a cylinder, of the ball about the centroid that a polyhedron holds,
    /// of both together where rounded.
    fn half_thickness(&self) -> f64 {
        match &self.geometry {
            PartGeometry::Sphere { radius, .. } | PartGeometry::Spherocylinder { radius, .. } => *radius,
            PartGeometry::Cylinder { ends, radius } => radius.min(0.5 * (ends[1] - ends[0]).norm()),
            PartGeometry::Polyhedron(p) => 0.5 * p.inside().inner_diameter,
            PartGeometry::RoundedPolyhedron(p) => {
                let inside = p.solid.as_ref().map_or(0.0, |solid| 0.5 * solid.inside().inner_diameter);
                p.skeleton.radius + inside
            }
        }
    }

    /// Most points of a contact with a plane, of a cylinder with another flat part.
    pub(crate) fn most_points(&self) -> u32 {
        match &self.geometry {
            PartGeometry::Sphere { .. } => 1,
            PartGeometry::Spherocylinder { .. } => 2,
            PartGeometry::Cylinder { .. } => RING_POINTS,
            PartGeometry::Polyhedron(p) => {
                (0..p.faces().len()).map(|face| p.face_vertices(face).len()).max().unwrap_or(1) as u32
            }
            PartGeometry::RoundedPolyhedron(p) => {
                (0..p.skeleton.faces().len()).map(|face| p.skeleton.sides(face).len()).max().unwrap_or(1) as u32
            }
        }
    }

    /// Largest height of a point of the part along a unit vector, from the origin.
    pub(crate) fn reach_along(&self, n: &Vec3) -> f64 {
        let highest = |points: &[Vec3]| points.iter().map(|x| n.dot(x)).fold(f64::MIN, f64::max);
        match &self.geometry {
            PartGeometry::Sphere { center, radius } => n.dot(center) + radius,
            PartGeometry::Spherocylinder { ends, radius } => highest(ends) + radius,
            PartGeometry::Cylinder { ends, radius } => {
                let solid = Solid::new(ends, *radius);
                n.dot(&solid.center) + solid.reach_along(n)
            }
            PartGeometry::Polyhedron(p) => highest(p.vertices()),
            PartGeometry::RoundedPolyhedron(p) => highest(p.skeleton.vertices()) + p.skeleton.radius,
        }
    }

    /// Distance to the surface when positive; when negative, at most the distance to the part with a minus sign.
    pub(crate) fn depth_inside(&self, x: &Vec3) -> f64 {
        union::depth_inside(self, x)
    }

    /// Whether contacts of the part are those of its features.
    pub fn is_rounded_polyhedron(&self) -> bool {
        matches!(self.geometry, PartGeometry::RoundedPolyhedron(_))
    }

    /// Largest distance of a point of the part from the origin.
    fn reach(&self) -> f64 {
        match &self.geometry {
            PartGeometry::Sphere { center, radius } => center.norm() + radius,
            PartGeometry::Spherocylinder { ends, radius } => ends[0].norm().max(ends[1].norm()) + radius,
            PartGeometry::Cylinder { ends, radius } => {
                let axis = (ends[1] - ends[0]).normalize();
                // the farthest point of a rim lies on the far side of its centre
                ends.iter().map(|c| c.dot(&axis).hypot(c.cross(&axis).norm() + radius)).fold(0.0, f64::max)
            }
            PartGeometry::Polyhedron(p) => p.vertices().iter().map(|v| v.norm()).fold(0.0, f64::max),
            PartGeometry::RoundedPolyhedron(p) => p.skeleton.reach + p.skeleton.radius,
        }
    }
}

impl RoundedPolyhedron {
    /// The same body in another frame.
    pub(crate) fn transformed(&self, rotation: &Mat3, translation: &Vec3) -> Self {
        Self {
            skeleton: self.skeleton.transformed(rotation, translation),
            solid: self.solid.as_ref().map(|solid| solid.transformed(rotation, translation)),
        }
    }
}

/// Middle of the bounding box, and the distance of the farthest point from it.
fn ball_around(points: &[Vec3]) -> (Vec3, f64) {
    let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), v| (l.inf(v), h.sup(v)));
    let center = (low + high) * 0.5;
    (center, points.iter().map(|v| (v - center).norm()).fold(0.0, f64::max))
}
