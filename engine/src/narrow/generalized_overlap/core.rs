//! The core of a rounded polyhedron, and the signed distance of a point from it.

use crate::math::Vec3;
use crate::narrow::{above_face, closest_on_segment, farthest_face};
use crate::shape::Polyhedron;

/// A core with its rounding radius, in the body frame of its shape at unit scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Core {
    solid: Polyhedron,
    /// r: how far the faces were moved inwards, m.
    pub radius: f64,
    /// Inner diameter of the part, m: twice the distance of its centroid from the nearest face. `radius` is the
    /// scene's `rounding_fraction` of it.
    pub size: f64,
    /// Largest distance of a vertex of the core from the origin of the body frame, m.
    pub reach: f64,
    /// Area of the largest face of the part, m2.
    pub face_area: f64,
    edge_lengths: Vec<f64>,
}

impl Core {
    /// The core of a part; `rounding_fraction` is r over the part's inner diameter.
    pub fn new(part: &Polyhedron, rounding_fraction: f64) -> Result<Self, String> {
        let radius = rounding_fraction * part.inside().inner_diameter;
        Ok(Self::of(part, part.inset(radius)?, radius))
    }

    /// The part as it is, for laws that round nothing.
    pub fn sharp(part: &Polyhedron) -> Self {
        Self::of(part, part.clone(), 0.0)
    }

    fn of(part: &Polyhedron, solid: Polyhedron, radius: f64) -> Self {
        let size = part.inside().inner_diameter;
        let reach = solid.vertices().iter().map(|v| v.norm()).fold(0.0, f64::max);
        let length = |[v, w]: [u32; 2]| (solid.vertices()[v as usize] - solid.vertices()[w as usize]).norm();
        let edge_lengths = solid.edges().iter().map(|e| length(e.vertices)).collect();
        let face_area = (0..part.faces().len()).map(|face| part.face_area(face)).fold(0.0, f64::max);
        Self { solid, radius, size, reach, face_area, edge_lengths }
    }

    /// The polyhedron.
    #[inline]
    pub fn solid(&self) -> &Polyhedron {
        &self.solid
    }

    /// Ends of an edge.
    #[inline]
    pub fn edge(&self, edge: usize) -> [Vec3; 2] {
        self.solid.edges()[edge].vertices.map(|v| self.solid.vertices()[v as usize])
    }

    /// Length of an edge.
    #[inline]
    pub fn edge_length(&self, edge: usize) -> f64 {
        self.edge_lengths[edge]
    }

    /// Outward unit normal and signed distance of a point: `x - normal * distance` is the closest point of the
    /// surface. Inside, the distance is that of the nearest face plane, negative.
    ///
    /// Outside, the distance of a convex body is differentiable. Whichever face x lies above is the one whose plane is
    /// farthest; else the closest point is on an edge of a face that sees x.
    #[inline]
    pub fn project(&self, x: &Vec3) -> (Vec3, f64) {
        let (face, height) = farthest_face(&self.solid, x);
        let normal = self.solid.faces()[face].normal;
        if height <= 0.0 || above_face(&self.solid, face, x) {
            return (normal, height);
        }
        let (mut closest, mut least) = (*x, f64::MAX);
        for (f, plane) in self.solid.faces().iter().enumerate() {
            if plane.normal.dot(x) <= plane.offset {
                continue;
            }
            for &e in self.solid.face_edges(f) {
                let [p, q] = self.edge(e as usize);
                let y = closest_on_segment(x, &p, &q).0;
                let distance2 = (x - y).norm_squared();
                if distance2 < least {
                    (closest, least) = (y, distance2);
                }
            }
        }
        let distance = least.sqrt();
        // less than the plane's distance is rounding
        if distance > 0.0 && distance < f64::MAX { ((x - closest) / distance, distance) } else { (normal, height) }
    }
}
