//! Edges and corners that carry contacts of their own.

use super::build::MeshEdge;
use super::patches::area_vector;
use super::{Corner, Edge, FLAT, Patch, Side};
use crate::math::Vec3;
use crate::shape::{Part, PartGeometry};

/// What an edge between two triangles is, seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Within a patch.
    Flat,
    /// Carries nothing; patches reach beyond it.
    Concave,
    /// Convex, or free.
    Feature,
}

/// An edge of triangles that carries contacts, with what is needed to join it to others.
#[derive(Clone, Debug)]
struct Piece {
    vertices: [u32; 2],
    /// Ascending.
    patches: Vec<u32>,
    sides: Vec<Side>,
}

/// Pieces, and how they hang together.
pub(super) struct Features {
    pieces: Vec<Piece>,
    /// By vertex: pieces there.
    at_vertex: Vec<Vec<u32>>,
    /// By vertex: whether something other than two pieces in line meets there.
    is_corner: Vec<bool>,
    /// By vertex: unit vectors along all edges of triangles.
    directions: Vec<Vec<Vec3>>,
}

impl Features {
    /// Tells the edges apart and marks the concave sides.
    pub fn find(
        vertices: &[Vec3],
        triangles: &[[u32; 3]],
        edges: &[MeshEdge],
        (patches, patch_of, sides): (&mut [Patch], &[u32], &mut [[Side; 3]]),
        size: f64,
    ) -> Self {
        let n = vertices.len();
        let mut new = Self {
            pieces: Vec::new(),
            at_vertex: vec![Vec::new(); n],
            is_corner: vec![false; n],
            directions: vec![Vec::new(); n],
        };
        let mut has_concave = vec![false; n];
        for edge in edges {
            let [v, w] = edge.vertices;
            let along = (vertices[w as usize] - vertices[v as usize]).normalize();
            new.directions[v as usize].push(along);
            new.directions[w as usize].push(-along);
            match kind(vertices, triangles, edge, patch_of) {
                Kind::Flat => {}
                Kind::Concave => {
                    for (t, side) in edge.triangles.into_iter().flatten() {
                        sides[t as usize][side as usize].is_concave = true;
                        patches[patch_of[t as usize] as usize].has_concave_side = true;
                    }
                    has_concave[v as usize] = true;
                    has_concave[w as usize] = true;
                }
                Kind::Feature => new.push(edge, patch_of, sides),
            }
        }
        for (v, concave) in has_concave.iter().enumerate() {
            new.is_corner[v] = !new.at_vertex[v].is_empty() && (*concave || !new.is_in_line(v, vertices, size));
        }
        new
    }

    fn push(&mut self, edge: &MeshEdge, patch_of: &[u32], sides: &[[Side; 3]]) {
        let beside = || edge.triangles.into_iter().flatten();
        let mut patches: Vec<u32> = beside().map(|(t, _)| patch_of[t as usize]).collect();
        patches.sort_unstable();
        let sides = beside().map(|(t, side)| sides[t as usize][side as usize]).collect();
        for v in edge.vertices {
            self.at_vertex[v as usize].push(self.pieces.len() as u32);
        }
        self.pieces.push(Piece { vertices: edge.vertices, patches, sides });
    }

    /// Whether a vertex only cuts one straight edge between the same patches in two.
    fn is_in_line(&self, vertex: usize, vertices: &[Vec3], size: f64) -> bool {
        let [a, b] = self.at_vertex[vertex][..] else { return false };
        let (a, b) = (&self.pieces[a as usize], &self.pieces[b as usize]);
        let other = |piece: &Piece| vertices[piece.other_end(vertex as u32) as usize];
        let (x, p, q) = (vertices[vertex], other(a), other(b));
        let chord = q - p;
        let off = (x - p).cross(&chord).norm() / chord.norm();
        a.patches == b.patches && (p - x).dot(&(q - x)) < 0.0 && off <= FLAT * size
    }

    /// Joins pieces in line, and makes the parts that meet particles.
    pub fn into_elements(self, vertices: &[Vec3], skeletons: bool) -> (Vec<Edge>, Vec<Corner>) {
        let mut done = vec![false; self.pieces.len()];
        let mut edges = Vec::new();
        for start in 0..self.pieces.len() {
            if done[start] {
                continue;
            }
            let ends = [0, 1].map(|k| self.follow(start, k, &mut done));
            let [p, q] = ends.map(|v| vertices[v as usize]);
            let along = q - p;
            let length = along.norm();
            let part = part(PartGeometry::Spherocylinder { ends: [p, q], radius: 0.0 }, skeletons);
            let sides = self.pieces[start].sides.clone();
            edges.push(Edge { ends: [p, q], direction: along / length, length, sides, part });
        }
        let corner = |v: usize| {
            let point = vertices[v];
            let to = |&piece: &u32| vertices[self.pieces[piece as usize].other_end(v as u32) as usize] - point;
            Corner {
                point,
                directions: self.directions[v].clone(),
                feature_directions: self.at_vertex[v].iter().map(|piece| to(piece).normalize()).collect(),
                part: part(PartGeometry::Sphere { center: point, radius: 0.0 }, skeletons),
            }
        };
        let corners = (0..vertices.len()).filter(|&v| self.is_corner[v]).map(corner).collect();
        (edges, corners)
    }

    /// The last vertex in line from one end of a piece on; marks the pieces on the way.
    fn follow(&self, start: usize, end: usize, done: &mut [bool]) -> u32 {
        let (mut piece, mut vertex) = (start, self.pieces[start].vertices[end]);
        done[start] = true;
        while !self.is_corner[vertex as usize] {
            let next = self.at_vertex[vertex as usize].iter().find(|&&other| other as usize != piece);
            let Some(&next) = next.filter(|&&next| !done[next as usize]) else { break };
            piece = next as usize;
            done[piece] = true;
            vertex = self.pieces[piece].other_end(vertex);
        }
        vertex
    }
}

impl Piece {
    fn other_end(&self, vertex: u32) -> u32 {
        let [v, w] = self.vertices;
        if v == vertex { w } else { v }
    }
}

fn part(geometry: PartGeometry, skeletons: bool) -> Part {
    let part = Part::new(geometry);
    if skeletons { part } else { Part { skeleton: None, ..part } }
}

fn kind(vertices: &[Vec3], triangles: &[[u32; 3]], edge: &MeshEdge, patch_of: &[u32]) -> Kind {
    let [Some((a, _)), Some((b, side))] = edge.triangles else { return Kind::Feature };
    if patch_of[a as usize] == patch_of[b as usize] {
        return Kind::Flat;
    }
    let (of_a, of_b) = (&triangles[a as usize], &triangles[b as usize]);
    let normal = area_vector(vertices, of_a).normalize();
    let apex = vertices[of_b[(side as usize + 2) % 3] as usize];
    let rise = normal.dot(&(apex - vertices[edge.vertices[0] as usize]));
    // back to back, the sheet is a knife whatever rounding says
    let is_knife = normal.dot(&area_vector(vertices, of_b).normalize()) < -1.0 + 1e-9;
    if rise > 0.0 && !is_knife { Kind::Concave } else { Kind::Feature }
}
