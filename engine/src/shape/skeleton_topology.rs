//! How the edges and faces of a skeleton hang together.

use super::skeleton::area_vector;
use crate::math::Vec3;
use std::collections::BTreeMap;

/// Faces as loops of vertices.
pub(super) type Loops = Vec<Vec<u32>>;

/// A face and the ends of one of its edges, in the sense of its loop.
pub(super) type EdgeOfFace = (usize, u32, u32);

/// The directed edges of a loop.
fn directed(polygon: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    (0..polygon.len()).map(|k| (polygon[k], polygon[(k + 1) % polygon.len()]))
}

fn undirected((from, to): (u32, u32)) -> (u32, u32) {
    (from.min(to), from.max(to))
}

/// All edges of face loops, each once, in the order of their first appearance.
pub(super) fn edges_of_loops(loops: &[Vec<u32>]) -> Vec<[u32; 2]> {
    let mut known = BTreeMap::new();
    let mut edges = Vec::new();
    for (from, to) in loops.iter().flat_map(|polygon| directed(polygon)) {
        known.entry(undirected((from, to))).or_insert_with(|| edges.push([from, to]));
    }
    edges
}

/// For each edge, the faces around it, with the sense in which their loops run along it.
pub(super) fn faces_of_edges(edges: &[[u32; 2]], loops: &[Vec<u32>]) -> Vec<Vec<EdgeOfFace>> {
    let mut around: BTreeMap<(u32, u32), Vec<EdgeOfFace>> = BTreeMap::new();
    for (f, polygon) in loops.iter().enumerate() {
        for (from, to) in directed(polygon) {
            around.entry(undirected((from, to))).or_default().push((f, from, to));
        }
    }
    edges.iter().map(|&[from, to]| around.get(&undirected((from, to))).cloned().unwrap_or_default()).collect()
}

/// Whether the faces close a volume that lies behind all their planes (to `flat`).
pub(super) fn is_convex_and_closed(vertices: &[Vec3], loops: &[Vec<u32>], flat: f64) -> bool {
    let edges = edges_of_loops(loops);
    let closed = loops.len() >= 4 && faces_of_edges(&edges, loops).iter().all(|faces| faces.len() == 2);
    closed
        && outwards(vertices, loops).iter().all(|polygon| {
            let normal = area_vector(vertices, polygon).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            let offset = normal.dot(&vertices[polygon[0] as usize]);
            vertices.iter().all(|v| normal.dot(v) - offset <= flat)
        })
}

/// The loops with the same first vertices, turned so that their normals point away from the mean of the vertices.
pub(super) fn outwards(vertices: &[Vec3], loops: &[Vec<u32>]) -> Loops {
    let middle = vertices.iter().sum::<Vec3>() / vertices.len() as f64;
    let turned = |polygon: &Vec<u32>| {
        let inwards = area_vector(vertices, polygon).dot(&(middle - vertices[polygon[0] as usize])) > 0.0;
        let mut polygon = polygon.clone();
        if inwards {
            polygon[1..].reverse();
        }
        polygon
    };
    loops.iter().map(turned).collect()
}
