//! Contacts of a part with one element, in the frame of the mesh.

use super::{Corner, Edge, Element, FLAT, Mesh, Patch, Side};
use crate::math::{Similarity, Vec3};
use crate::narrow::generalized_overlap::{Term, polyhedron_plane};
use crate::narrow::{Manifold, ManifoldPoint, PairCache, collide, part_plane};
use crate::shape::{Part, PartGeometry, Polyhedron};

/// Sine by which the push of a face of a polyhedron may leave the range of directions between the patches of an edge:
/// a box that leans inwards over a rim still rests on it, but is not pushed back by the rim it slides over.
const WIDE: f64 = 0.7;
/// Sine below which a spherocylinder counts as parallel to an edge.
const PARALLEL: f64 = 1e-6;
/// The same where both ends of an edge may carry it.
const ALONGSIDE: f64 = 0.5;

/// A part at a mesh.
#[derive(Clone, Copy)]
pub struct PartAtMesh<'p> {
    /// The part.
    pub part: &'p Part,
    /// Its pose in the frame of the mesh.
    pub mesh_from_body: &'p Similarity,
    /// Overlap from which on a point is on the other side, m: half the thickness of the particle's thinnest part.
    pub deepest: f64,
}

impl PartAtMesh<'_> {
    /// Radius of the balls that a round part touches with, m; 0 of a sharp one.
    fn ball_radius(&self) -> f64 {
        let scale = self.mesh_from_body.scale;
        if let PartGeometry::Sphere { radius, .. } | PartGeometry::Spherocylinder { radius, .. } = &self.part.geometry {
            radius * scale
        } else if let PartGeometry::RoundedPolyhedron(p) = &self.part.geometry {
            p.skeleton.radius * scale
        } else {
            0.0
        }
    }
}

impl Mesh {
    /// Appends the contacts with an element; normals point into the mesh.
    pub fn contacts(&self, element: u32, at: &PartAtMesh<'_>, out: &mut Manifold) {
        let first = out.len();
        match self.element(element) {
            Element::Patch(k) => {
                let patch = &self.patches[k];
                let Some(patch_from_body) = patch.body_in_patch(at) else { return };
                part_plane(at.part, &patch_from_body, out);
                out.retain_from(first, |p| self.passes_through(k, (at, &patch_from_body), &p.position, p.overlap));
                out.map_from(first, &Similarity::rigid(patch.rotation, patch.point));
            }
            Element::Edge(k) => {
                let edge = &self.edges[k];
                self.meet(&edge.part, at, out);
                out.retain_from(first, |p| edge.owns(at, p, self.tolerance()));
            }
            Element::Corner(k) => {
                let corner = &self.corners[k];
                self.meet(&corner.part, at, out);
                out.retain_from(first, |p| corner.owns(at, p, self.tolerance()));
            }
        }
    }

    /// The terms of a polyhedron that meets a patch by generalized overlap, in the frame of the patch, and its pose there.
    pub fn patch_terms(
        &self,
        element: u32,
        solid: &Polyhedron,
        at: &PartAtMesh<'_>,
        terms: &mut Vec<Term>,
    ) -> (Similarity, Similarity) {
        terms.clear();
        let k = element as usize;
        let patch = &self.patches[k];
        let mesh_from_patch = Similarity::rigid(patch.rotation, patch.point);
        let Some(patch_from_body) = patch.body_in_patch(at) else { return (mesh_from_patch, *at.mesh_from_body) };
        polyhedron_plane(solid, &patch_from_body, terms);
        terms.retain(|term| self.passes_through(k, (at, &patch_from_body), &term.position, term.overlap));
        (mesh_from_patch, patch_from_body)
    }

    fn meet(&self, feature: &Part, at: &PartAtMesh<'_>, out: &mut Manifold) {
        let first = out.len();
        collide(at.part, feature, &at.mesh_from_body.inverse(), &mut PairCache::default(), out);
        out.map_from(first, at.mesh_from_body);
    }

    /// Whether a point of a part that is behind the plane of a patch has come through the patch: not so deep that it
    /// cannot have, and with its foot inside; what is sharp, on the straight way from the centre of the part. (A corner of
    /// a box that lies over a rim is behind the plane below the rim as well.)
    fn passes_through(&self, patch: usize, (at, pose): (&PartAtMesh<'_>, &Similarity), x: &Vec3, overlap: f64) -> bool {
        if overlap >= at.deepest {
            return false;
        }
        let ball = Vec3::new(x.x, x.y, at.ball_radius() - overlap);
        if ball.z >= 0.0 {
            return self.holds(patch, &ball, at.deepest);
        }
        let centre = pose.point(&at.part.center);
        let way = centre.z / (centre.z - ball.z);
        self.holds(patch, &(centre + (ball - centre) * way), at.deepest)
    }

    /// Whether the foot of a point (in the frame of the patch) lies inside, or beyond a concave side by less than `beyond`.
    fn holds(&self, patch: usize, x: &Vec3, beyond: f64) -> bool {
        const FEW: usize = 4;
        let of = &self.patches[patch];
        let foot = of.point + of.rotation * Vec3::new(x.x, x.y, 0.0);
        let tolerance = self.tolerance();
        let beyond = if of.has_concave_side { beyond } else { tolerance };
        let inside = |triangle: u32| {
            self.sides[triangle as usize].iter().all(|side| {
                let reach = if side.is_concave { beyond } else { tolerance };
                side.inwards.dot(&foot) - side.offset >= -reach
            })
        };
        if of.triangles.len() <= FEW {
            return of.triangles.iter().any(|&t| inside(t));
        }
        let span = Vec3::repeat(beyond + tolerance + FLAT * self.size);
        self.tree.any(&(foot - span), &(foot + span), |leaf| {
            self.patch_of.get(leaf as usize).is_some_and(|&p| p as usize == patch) && inside(leaf)
        })
    }
}

impl Patch {
    /// The part in the frame of the patch; `None` where its centre is on the other side.
    fn body_in_patch(&self, at: &PartAtMesh<'_>) -> Option<Similarity> {
        let to_mesh = at.mesh_from_body;
        let is_above = self.height(&to_mesh.point(&at.part.center)) > 0.0;
        is_above.then(|| Similarity {
            rotation: self.rotation.tr_mul(&to_mesh.rotation),
            translation: self.rotation.tr_mul(&(to_mesh.translation - self.point)),
            scale: to_mesh.scale,
        })
    }
}

/// A contact with an edge or a corner: its point on the mesh, and which point of the part it belongs to.
struct Touch {
    on_mesh: Vec3,
    /// Unit, from the mesh to the part.
    outwards: Vec3,
    /// Centre of the ball of the part that touches; on the axis of a spherocylinder, of a rounded edge.
    ball: Vec3,
    kind: TouchKind,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum TouchKind {
    /// A ball: a sphere, an end of a spherocylinder, a rounded vertex.
    Ball,
    /// The middle of a rounded edge.
    Line,
    /// A face or an edge of a sharp part.
    Sharp,
}

impl Touch {
    fn new(at: &PartAtMesh<'_>, point: &ManifoldPoint) -> Self {
        let outwards = -point.normal;
        let on_mesh = point.position + outwards * (0.5 * point.overlap);
        let ball = on_mesh + outwards * (at.ball_radius() - point.overlap);
        let is_line = if let PartGeometry::Spherocylinder { ends, .. } = &at.part.geometry {
            let near = 1e-9 * at.part.radius * at.mesh_from_body.scale;
            !ends.iter().any(|end| (at.mesh_from_body.point(end) - ball).norm() <= near)
        } else {
            at.part.is_rounded_polyhedron() && point.feature.kind() == 3
        };
        let is_ball = at.part.is_rounded_polyhedron()
            || matches!(at.part.geometry, PartGeometry::Sphere { .. } | PartGeometry::Spherocylinder { .. });
        let kind = match (is_line, is_ball) {
            (true, _) => TouchKind::Line,
            (false, true) => TouchKind::Ball,
            (false, false) => TouchKind::Sharp,
        };
        Self { on_mesh, outwards, ball, kind }
    }

    /// Sine of the angle between a spherocylinder and a direction; 1 for other parts.
    fn sine(at: &PartAtMesh<'_>, direction: &Vec3) -> f64 {
        let PartGeometry::Spherocylinder { ends, .. } = &at.part.geometry else { return 1.0 };
        let axis = at.mesh_from_body.direction(&(ends[1] - ends[0]));
        axis.cross(direction).norm() / axis.norm().max(f64::MIN_POSITIVE)
    }
}

impl Edge {
    /// Whether a contact is the edge's own: not at an end (that is the corner's), and not a ball above a patch.
    fn owns(&self, at: &PartAtMesh<'_>, point: &ManifoldPoint, tolerance: f64) -> bool {
        let touch = Touch::new(at, point);
        let along = self.direction.dot(&(touch.on_mesh - self.ends[0]));
        if !(along > tolerance && along < self.length - tolerance) {
            return false;
        }
        let is_crossing = touch.kind == TouchKind::Line && Touch::sine(at, &self.direction) > PARALLEL;
        if touch.kind == TouchKind::Sharp || is_crossing {
            return self.sides.iter().all(|side| touch.outwards.dot(&side.inwards) <= WIDE);
        }
        let is_beyond = |side: &Side| side.inwards.dot(&touch.ball) - side.offset < -tolerance;
        self.sides.iter().all(is_beyond)
    }
}

impl Corner {
    /// Whether a contact is the corner's own: a ball that no edge and no patch is nearer to.
    fn owns(&self, at: &PartAtMesh<'_>, point: &ManifoldPoint, tolerance: f64) -> bool {
        let touch = Touch::new(at, point);
        let gap = touch.ball - self.point;
        match touch.kind {
            TouchKind::Ball => self.directions.iter().all(|u| u.dot(&gap) <= tolerance),
            TouchKind::Sharp => self.feature_directions.iter().all(|u| u.dot(&touch.outwards) <= WIDE),
            TouchKind::Line => self.feature_directions.iter().all(|u| {
                let alongside = Touch::sine(at, u) < ALONGSIDE && u.dot(&touch.outwards) <= ALONGSIDE;
                alongside || u.dot(&gap) <= tolerance
            }),
        }
    }
}
