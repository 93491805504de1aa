//! Triangle meshes as boundaries, in the frame that their vertices are given in.
//!
//! A mesh is taken apart into elements, each of which has its own contacts with a part (a slot of its own):
//!
//! | element | made of | contacts |
//! |---|---|---|
//! | patch | coplanar triangles that hang together | points of the part whose foot lies inside, as on a plane |
//! | edge | collinear edges between the same two patches, where the outside angle is above 180 degrees, and free edges | a spherocylinder of radius 0 and the part |
//! | corner | ends of such edges | a sphere of radius 0 and the part |
//!
//! Concave and flat edges carry nothing. Patches reach beyond their concave edges, as planes do. Each contact belongs
//! to one element: that of the round parts to the one that the centre of the ball is nearest to.

mod build;
mod contacts;
mod error;
mod features;
mod patches;
#[cfg(test)]
mod tests;

pub use contacts::PartAtMesh;
pub use error::MeshError;

use crate::math::parry::BoxTree;
use crate::math::{Mat3, Vec3};
use crate::narrow::closest_on_segment;
use crate::shape::Part;

/// How far the vertices of a patch may lie off its plane and those of an edge off its line, over the size of the mesh:
/// files with numbers of single precision are flat to 1e-7.
pub const FLAT: f64 = 1e-6;
/// Width of the boundaries between elements, over the size of the mesh.
const BOUNDARY: f64 = 1e-9;

/// The line of an edge in the plane of a patch: `inwards . x - offset` is positive on the side of the patch.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    inwards: Vec3,
    offset: f64,
    /// Whether the other side rises: the patch reaches beyond.
    is_concave: bool,
}

/// A plane with the triangles in it.
#[derive(Clone, Debug, PartialEq)]
struct Patch {
    /// Patch frame: the third column is the normal.
    rotation: Mat3,
    /// A point of the plane.
    point: Vec3,
    triangles: Vec<u32>,
    /// Whether some side is.
    has_concave_side: bool,
}

/// A convex or free edge.
#[derive(Clone, Debug, PartialEq)]
struct Edge {
    ends: [Vec3; 2],
    /// Unit, from the first to the second.
    direction: Vec3,
    length: f64,
    /// Of the patches that meet there.
    sides: Vec<Side>,
    /// What meets particles.
    part: Part,
}

/// An end of such edges.
#[derive(Clone, Debug, PartialEq)]
struct Corner {
    point: Vec3,
    /// Unit vectors along all edges of triangles there.
    directions: Vec<Vec3>,
    /// Those of convex and free edges.
    feature_directions: Vec<Vec3>,
    part: Part,
}

/// A checked mesh. Immutable; shared by the boundary's copies.
#[derive(Clone, Debug)]
pub struct Mesh {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// By triangle.
    patch_of: Vec<u32>,
    sides: Vec<[Side; 3]>,
    patches: Vec<Patch>,
    edges: Vec<Edge>,
    corners: Vec<Corner>,
    /// Largest extent, m.
    size: f64,
    /// Of triangles, edges and corners.
    tree: BoxTree,
}

/// What an element number means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Element {
    Patch(usize),
    Edge(usize),
    Corner(usize),
}

impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        self.vertices == other.vertices && self.triangles == other.triangles
    }
}

impl Mesh {
    /// Number of elements.
    pub fn n_elements(&self) -> u32 {
        (self.patches.len() + self.edges.len() + self.corners.len()) as u32
    }

    /// Numbers of patches, edges and corners.
    pub fn counts(&self) -> [usize; 3] {
        [self.patches.len(), self.edges.len(), self.corners.len()]
    }

    /// Whether the element is a patch.
    pub fn is_patch(&self, element: u32) -> bool {
        (element as usize) < self.patches.len()
    }

    #[inline]
    fn element(&self, element: u32) -> Element {
        let (k, patches, edges) = (element as usize, self.patches.len(), self.edges.len());
        if k < patches {
            Element::Patch(k)
        } else if k < patches + edges {
            Element::Edge(k - patches)
        } else {
            Element::Corner(k - patches - edges)
        }
    }

    fn tolerance(&self) -> f64 {
        BOUNDARY * self.size
    }

    /// Elements that something within `reach` of `x` may touch, in ascending order; patches only where `x` is not
    /// farther than `behind` on their other side.
    pub fn near(&self, x: &Vec3, reach: f64, behind: f64, elements: &mut Vec<u32>) {
        elements.clear();
        let span = Vec3::repeat(reach);
        self.tree.visit(&(x - span), &(x + span), |leaf| {
            if let Some(element) = self.leaf_within(leaf as usize, x, reach, behind) {
                elements.push(element);
            }
        });
        elements.sort_unstable();
        elements.dedup();
    }

    /// The same by looking at everything, for tests.
    pub fn near_by_brute_force(&self, x: &Vec3, reach: f64, behind: f64) -> Vec<u32> {
        let leaves = self.triangles.len() + self.edges.len() + self.corners.len();
        let mut elements: Vec<u32> = (0..leaves).filter_map(|leaf| self.leaf_within(leaf, x, reach, behind)).collect();
        elements.sort_unstable();
        elements.dedup();
        elements
    }

    fn leaf_within(&self, leaf: usize, x: &Vec3, reach: f64, behind: f64) -> Option<u32> {
        let n = self.triangles.len();
        if leaf < n {
            let patch = self.patch_of[leaf];
            let is_near = self.distance2_to_triangle(leaf, x) < reach * reach;
            return (is_near && self.patches[patch as usize].height(x) > -behind).then_some(patch);
        }
        let (k, patches) = (leaf - n, self.patches.len());
        let distance2 = match self.edges.get(k) {
            Some(edge) => (closest_on_segment(x, &edge.ends[0], &edge.ends[1]).0 - x).norm_squared(),
            None => (self.corners[k - self.edges.len()].point - x).norm_squared(),
        };
        (distance2 < reach * reach).then_some((patches + k) as u32)
    }

    /// Squared distance, or a little less.
    fn distance2_to_triangle(&self, triangle: usize, x: &Vec3) -> f64 {
        let patch = &self.patches[self.patch_of[triangle] as usize];
        let inside = self.sides[triangle].iter().all(|side| side.inwards.dot(x) - side.offset >= 0.0);
        if inside {
            let height = patch.height(x);
            // vertices may lie off the plane
            return (height.abs() - FLAT * self.size).max(0.0).powi(2);
        }
        let [p, q, r] = self.triangles[triangle].map(|v| &self.vertices[v as usize]);
        [(p, q), (q, r), (r, p)]
            .map(|(a, b)| (closest_on_segment(x, a, b).0 - x).norm_squared())
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }

    /// Height of a point above the plane of a patch; `None` of another element.
    pub fn height_above(&self, element: u32, x: &Vec3) -> Option<f64> {
        match self.element(element) {
            Element::Patch(k) => Some(self.patches[k].height(x)),
            _ => None,
        }
    }

    /// Vertices as given.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }
}

impl Patch {
    fn normal(&self) -> Vec3 {
        self.rotation.column(2).into_owned()
    }

    #[inline]
    fn height(&self, x: &Vec3) -> f64 {
        self.rotation.column(2).dot(&(x - self.point))
    }
}
