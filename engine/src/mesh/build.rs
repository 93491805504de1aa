//! From vertices and triangles to elements.

use std::collections::BTreeMap;

use super::features::Features;
use super::patches::{Patches, find_patches};
use super::{Mesh, MeshError};
use crate::cell::Cell;
use crate::math::Vec3;
use crate::math::parry::BoxTree;

/// Below this height over the longest edge a triangle has no area.
const DEGENERATE: f64 = 1e-10;

/// An edge of triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshEdge {
    /// In the direction of the first triangle.
    pub vertices: [u32; 2],
    /// Triangle and which of its sides; the second is absent at a free edge.
    pub triangles: [Option<(u32, u8)>; 2],
}

impl Mesh {
    /// Checks the mesh and takes it apart; with `skeletons` it can meet rounded polyhedra.
    pub fn build(vertices: &[[f64; 3]], triangles: &[[u32; 3]], skeletons: bool) -> Result<Self, MeshError> {
        let vertices: Vec<Vec3> = vertices.iter().map(|v| Vec3::from(*v)).collect();
        check(&vertices, triangles)?;
        let first = vertices[triangles[0][0] as usize];
        let used = triangles.iter().flatten().map(|&v| vertices[v as usize]);
        let (low, high) = used.fold((first, first), |(low, high), v| (low.inf(&v), high.sup(&v)));
        let size = (high - low).max();
        let edges = edges_of(triangles)?;
        let Patches { mut patches, patch_of, mut sides } = find_patches(&vertices, triangles, &edges, size);
        let features = Features::find(&vertices, triangles, &edges, (&mut patches, &patch_of, &mut sides), size);
        let (edges, corners) = features.into_elements(&vertices, skeletons);
        let boxes = triangles
            .iter()
            .map(|t| t.map(|v| vertices[v as usize]))
            .map(|[p, q, r]| (p.inf(&q).inf(&r), p.sup(&q).sup(&r)))
            .chain(edges.iter().map(|e| (e.ends[0].inf(&e.ends[1]), e.ends[0].sup(&e.ends[1]))))
            .chain(corners.iter().map(|c| (c.point, c.point)));
        let tree = BoxTree::new(boxes);
        let mesh =
            Self { vertices, triangles: triangles.to_vec(), patch_of, sides, patches, edges, corners, size, tree };
        if mesh.counts().iter().sum::<usize>() >= 1 << 28 { Err(MeshError::TooLarge) } else { Ok(mesh) }
    }

    /// Whether the mesh is the same wherever a particle of a cell is along an axis: its patches and edges run along the
    /// axis, or are out of reach. No particle reaches farther out of the cell than a quarter of it.
    pub fn is_invariant_along(&self, axis: usize, cell: &Cell) -> bool {
        const ALONG: f64 = 1e-9;
        let is_far = |points: &mut dyn Iterator<Item = &Vec3>| is_far_from_cell(points, axis, cell);
        let patches = self.patches.iter().all(|patch| {
            let mut points = patch
                .triangles
                .iter()
                .flat_map(|&t| self.triangles[t as usize].iter().map(|&v| &self.vertices[v as usize]));
            patch.normal()[axis].abs() < ALONG || is_far(&mut points)
        });
        // the sides of patches that carry nothing are concave: they end what they are a side of all the same
        let sides = self.patch_sides().all(|[p, q]| {
            let along = (q - p).normalize()[axis].abs();
            along > 1.0 - ALONG || is_far(&mut [p, q].into_iter())
        });
        patches && sides
    }

    /// Ends of the sides of triangles that are sides of their patch as well.
    fn patch_sides(&self) -> impl Iterator<Item = [&Vec3; 2]> {
        let edges = edges_of(&self.triangles).unwrap_or_default();
        edges.into_iter().filter_map(|edge| {
            let [first, second] = edge.triangles.map(|t| t.map(|(t, _)| self.patch_of[t as usize]));
            (first != second).then(|| edge.vertices.map(|v| &self.vertices[v as usize]))
        })
    }
}

/// Whether points are so far out of a periodic cell, all on one side, that no particle comes there.
fn is_far_from_cell(points: &mut dyn Iterator<Item = &Vec3>, axis: usize, cell: &Cell) -> bool {
    let margin = 0.25 * cell.extent[axis];
    let (low, high) = (cell.min[axis] - margin, cell.min[axis] + cell.extent[axis] + margin);
    let (mut below, mut above) = (true, true);
    for point in points {
        below &= point[axis] <= low;
        above &= point[axis] >= high;
    }
    below || above
}

fn check(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    if triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    if let Some(vertex) = vertices.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
        return Err(MeshError::NonFinite { vertex });
    }
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices.len()) {
            return Err(MeshError::NoSuchVertex { triangle, vertex, vertices: vertices.len() });
        }
        let [p, q, r] = corners.map(|v| vertices[v as usize]);
        let longest2 = [q - p, r - q, p - r].iter().map(Vec3::norm_squared).fold(0.0, f64::max);
        if (q - p).cross(&(r - p)).norm() <= DEGENERATE * longest2 {
            return Err(MeshError::Degenerate { triangle });
        }
    }
    Ok(())
}

/// All edges, in the order in which triangles name them.
pub(super) fn edges_of(triangles: &[[u32; 3]]) -> Result<Vec<MeshEdge>, MeshError> {
    let mut index: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    let mut edges: Vec<MeshEdge> = Vec::new();
    for (triangle, corners) in triangles.iter().enumerate() {
        for side in 0..3 {
            let (from, to) = (corners[side], corners[(side + 1) % 3]);
            let here = Some((triangle as u32, side as u8));
            let Some(&known) = index.get(&[from.min(to), from.max(to)]) else {
                index.insert([from.min(to), from.max(to)], edges.len());
                edges.push(MeshEdge { vertices: [from, to], triangles: [here, None] });
                continue;
            };
            let edge = &mut edges[known];
            let first = edge.triangles[0].map_or(0, |(t, _)| t as usize);
            if let Some((second, _)) = edge.triangles[1] {
                let second = second as usize;
                return Err(MeshError::NotASurface { from, to, first, second, third: triangle });
            }
            if edge.vertices == [from, to] {
                return Err(MeshError::InconsistentOrientation { first, second: triangle, from, to });
            }
            edge.triangles[1] = here;
        }
    }
    Ok(edges)
}
