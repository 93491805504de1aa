//! A polyhedron with every face moved inwards: the core of a rounded polyhedron.

use super::hull::convex_hull;
use super::mass::Moments;
use super::polyhedron::{Polyhedron, TopologyError};
use super::{Part, PartGeometry};
use crate::math::{Mat3, Vec3};

/// Least quotient of the smallest and the largest eigenvalue of the normals' second moment at a vertex: below it the
/// planes do not fix the vertex.
const LEAST_CONDITION: f64 = 1e-12;

/// A polyhedron's inside: its centroid, and twice the distance of that from the nearest face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Inside {
    pub centroid: Vec3,
    pub inner_diameter: f64,
}

impl Polyhedron {
    /// Centroid and inner diameter.
    pub(crate) fn inside(&self) -> Inside {
        let moments = Moments::of_part(&Part::new(PartGeometry::Polyhedron(self.clone())));
        let centroid = moments.first / moments.volume;
        let depth = self.faces().iter().map(|f| f.offset - f.normal.dot(&centroid)).fold(f64::INFINITY, f64::min);
        Inside { centroid, inner_diameter: 2.0 * depth }
    }

    /// The intersection of the half-spaces of all faces, each moved inwards by `by`; face k stays face k.
    ///
    /// Duality: about an inner point c the planes are the points n / (offset - n . c), the vertices wanted are the
    /// planes of their convex hull. Fails where the intersection is empty, does not hold the centroid, or where a
    /// face has no part in it any more. A vertex of more than three faces may become several.
    pub(crate) fn inset(&self, by: f64) -> Result<Self, String> {
        let inside = self.inside();
        if 0.5 * inside.inner_diameter <= by {
            return Err(format!("moving the faces inwards by {by:e} leaves nothing around the centroid"));
        }
        let heights: Vec<f64> = self.faces().iter().map(|f| f.offset - by - f.normal.dot(&inside.centroid)).collect();
        if let Some(simple) = self.inset_of_simple(&inside, &heights) {
            return Ok(simple);
        }
        let poles: Vec<Vec3> = self.faces().iter().zip(&heights).map(|(f, h)| f.normal / *h).collect();
        let dual = convex_hull(&poles, "core").map_err(|error| error.to_string())?;
        if dual.vertices() != poles {
            return Err(format!("moving the faces inwards by {by:e} loses a face"));
        }
        let vertices: Vec<Vec3> = (0..dual.faces().len())
            .map(|j| meeting_point(self, &heights, dual.face_vertices(j)).map(|x| x + inside.centroid))
            .collect::<Result<_, _>>()?;
        let loops =
            (0..self.faces().len()).map(|f| around(&self.faces()[f].normal, dual.vertex_faces(f), &vertices)).collect();
        Self::from_faces(vertices, loops).map_err(|error| match error {
            TopologyError::TooMany { what, count, most } => format!("its core has {count} {what}, at most {most}"),
            TopologyError::Invalid(reason) => format!("its core is no polyhedron: {reason}"),
        })
    }

    /// The same where three faces meet at each vertex and none of them is lost: each vertex goes where its three
    /// planes meet. Works at any proportions, which a hull of nearly coplanar poles does not.
    fn inset_of_simple(&self, inside: &Inside, heights: &[f64]) -> Option<Self> {
        let vertices: Option<Vec<Vec3>> = (0..self.vertices().len())
            .map(|v| {
                let faces = self.vertex_faces(v);
                let meeting = (faces.len() == 3).then(|| meeting_point(self, heights, faces))?;
                meeting.ok().map(|x| x + inside.centroid)
            })
            .collect();
        let vertices = vertices?;
        // an edge that would turn round belongs to a face that is lost
        let keeps_its_sense = |[v, w]: [u32; 2]| {
            let edge = |of: &[Vec3]| of[w as usize] - of[v as usize];
            edge(&vertices).dot(&edge(self.vertices())) > 0.0
        };
        if !self.edges().iter().all(|edge| keeps_its_sense(edge.vertices)) {
            return None;
        }
        let loops = (0..self.faces().len()).map(|f| self.face_vertices(f).to_vec()).collect();
        Self::from_faces(vertices, loops).ok()
    }
}

/// Point where the planes n . x = height of some faces meet, in the sense of least squares if there are more than three.
fn meeting_point(solid: &Polyhedron, heights: &[f64], faces: &[u32]) -> Result<Vec3, String> {
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    for &f in faces {
        let normal = &solid.faces()[f as usize].normal;
        matrix += normal * normal.transpose();
        right += normal * heights[f as usize];
    }
    let scale = matrix.trace();
    matrix
        .cholesky()
        .filter(|c| c.l().diagonal().iter().all(|x| x * x > LEAST_CONDITION * scale))
        .map(|c| c.solve(&right))
        .ok_or_else(|| "the faces of a vertex of its core are too nearly parallel".to_string())
}

/// The vertices of a face, in their order about its normal.
fn around(normal: &Vec3, members: &[u32], vertices: &[Vec3]) -> Vec<u32> {
    let middle = members.iter().map(|&v| vertices[v as usize]).sum::<Vec3>() / members.len().max(1) as f64;
    let first = vertices[members[0] as usize] - middle;
    let second = normal.cross(&first);
    let angle = |v: u32| {
        let x = vertices[v as usize] - middle;
        x.dot(&second).atan2(x.dot(&first))
    };
    let mut order = members.to_vec();
    order.sort_by(|&v, &w| angle(v).total_cmp(&angle(w)));
    order
}

#[cfg(test)]
mod tests {
    use crate::math::Vec3;
    use crate::shape::{PartGeometry, Polyhedron, Shape, ShapeDescription};

    fn solid(description: &ShapeDescription) -> Polyhedron {
        let shape = Shape::build(description).expect("a valid shape");
        let PartGeometry::Polyhedron(p) = &shape.parts()[0].geometry else { panic!("not a polyhedron") };
        p.clone()
    }

    /// Faces keep their number and directions and move by exactly the inset; the inner diameter shrinks by twice that.
    #[test]
    fn faces_move_inwards_and_none_is_lost() {
        use ShapeDescription as D;
        let shapes = [
            D::Cube { edge_m: 1.0 },
            D::Box { size_m: [1.0, 0.2, 0.02] },
            D::Tetrahedron { edge_m: 2f64.sqrt() },
            D::Octahedron { edge_m: 1.0 },
            D::Pinacoid { length_m: 1.0, width_m: 1.0, height_m: 1.0, alpha_deg: 60.0 },
        ];
        for shape in shapes {
            let full = solid(&shape);
            let by = 0.02 * full.inside().inner_diameter;
            let core = full.inset(by).expect("a core");
            assert_eq!(core.faces().len(), full.faces().len());
            assert_eq!(core.vertices().len(), full.vertices().len(), "{shape:?}");
            for (f, g) in full.faces().iter().zip(core.faces()) {
                assert!((f.normal - g.normal).norm() < 1e-12 && (f.offset - g.offset - by).abs() < 1e-13, "{shape:?}");
            }
        }
    }

    /// A cube with a corner cut off by 1e-3: moved inwards by 1e-2, the cut is gone.
    #[test]
    fn lost_faces_and_empty_cores_are_refused() {
        let mut points: Vec<Vec3> = (0..7).map(|k| Vec3::from_fn(|i, _| f64::from(k >> i & 1) - 0.5)).collect();
        points.extend((0..3).map(|i| Vec3::from_fn(|j, _| if i == j { 0.499 } else { 0.5 })));
        let cut =
            solid(&ShapeDescription::ConvexPolyhedron { vertices_m: points.iter().map(|p| (*p).into()).collect() });
        assert_eq!(cut.faces().len(), 7);
        assert!(cut.inset(1e-4).is_ok());
        assert!(cut.inset(1e-2).is_err_and(|e| e.contains("loses a face")));
        assert!(cut.inset(0.5).is_err());
    }
}
