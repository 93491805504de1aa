//! A convex polyhedron as flat arrays: vertices, merged faces, edges with their two faces.

use crate::math::{Mat3, Vec3};
use crate::narrow::MAX_POINTS;
use std::collections::BTreeMap;

/// Most vertices of one face: two such faces clip to at most [`MAX_POINTS`] points.
pub const MAX_FACE_VERTICES: usize = MAX_POINTS / 2;
/// Most edges of one polyhedron: an edge index has 15 bits in a feature key.
pub const MAX_EDGES: usize = 1 << 15;
/// How far a point may lie outside a face plane, over the size: rounding of the planes of 1:1000 slivers.
const CONVEXITY: f64 = 1e-9;

/// A face plane: `normal . x = offset`, normal outwards and of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Outward unit normal.
    pub normal: Vec3,
    /// Distance of the plane from the origin along the normal.
    pub offset: f64,
    first: u32,
    len: u32,
}

/// An edge, and the two faces that meet there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Its ends; counter-clockwise about `faces[0]`, clockwise about `faces[1]`.
    pub vertices: [u32; 2],
    /// The faces on its two sides.
    pub faces: [u32; 2],
    /// Unit vector from the first to the second end.
    pub direction: Vec3,
}

/// Directions that are equal up to their sense, bit for bit: most edges and faces of regular solids come in such sets.
///
/// Only a saving for the separating-axis test; a set of one is as good.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parallels {
    pub direction: Vec3,
    /// Which have this direction, as bits.
    pub along: u64,
    /// Which have the opposite direction.
    pub against: u64,
}

/// A convex polyhedron whose faces are convex polygons of any number of vertices up to [`MAX_FACE_VERTICES`].
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    vertices: Vec<Vec3>,
    faces: Vec<Face>,
    edges: Vec<Edge>,
    face_vertices: Vec<u32>,
    face_edges: Vec<u32>,
    vertex_faces_start: Vec<u32>,
    vertex_faces: Vec<u32>,
    parallel_edges: Vec<Parallels>,
    parallel_faces: Vec<Parallels>,
}

/// Why faces do not make a convex polyhedron.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TopologyError {
    /// Too many features.
    TooMany { what: &'static str, count: usize, most: usize },
    /// Not closed, not convex, not planar.
    Invalid(String),
}

impl Polyhedron {
    /// From vertices and face loops (either sense); refuses what is not closed, convex and planar.
    pub(crate) fn from_faces(vertices: Vec<Vec3>, mut loops: Vec<Vec<u32>>) -> Result<Self, TopologyError> {
        if let Some(l) = loops.iter().find(|l| l.len() > MAX_FACE_VERTICES) {
            return Err(TopologyError::TooMany {
                what: "vertices in one face",
                count: l.len(),
                most: MAX_FACE_VERTICES,
            });
        }
        let middle = vertices.iter().sum::<Vec3>() / vertices.len() as f64;
        let mut faces = Vec::with_capacity(loops.len());
        let mut face_vertices = Vec::new();
        for polygon in &mut loops {
            let (mut normal, offset) = plane(&vertices, polygon);
            if normal.dot(&middle) > offset {
                polygon.reverse();
                normal = -normal;
            }
            let offset = mean_offset(&vertices, polygon, &normal);
            faces.push(Face { normal, offset, first: face_vertices.len() as u32, len: polygon.len() as u32 });
            face_vertices.extend_from_slice(polygon);
        }
        let (edges, face_edges) = edges_of(&vertices, &loops)?;
        let (vertex_faces_start, vertex_faces) = faces_around_vertices(vertices.len(), &loops);
        let (parallel_edges, parallel_faces) = Default::default();
        let mut new = Self {
            vertices,
            faces,
            edges,
            face_vertices,
            face_edges,
            vertex_faces_start,
            vertex_faces,
            parallel_edges,
            parallel_faces,
        };
        new.find_parallels();
        new.check()?;
        Ok(new)
    }

    /// The same polyhedron in another frame; planes are recomputed, so they stay exact to rounding.
    pub(crate) fn transformed(&self, rotation: &Mat3, translation: &Vec3) -> Self {
        if *rotation == Mat3::identity() && *translation == Vec3::zeros() {
            return self.clone();
        }
        let mut new = self.clone();
        for v in &mut new.vertices {
            *v = rotation * *v + translation;
        }
        for (i, old) in self.faces.iter().enumerate() {
            let polygon = &self.face_vertices[old.first as usize..(old.first + old.len) as usize];
            let (normal, _) = plane(&new.vertices, polygon);
            new.faces[i].normal = normal;
            new.faces[i].offset = mean_offset(&new.vertices, polygon, &normal);
        }
        for e in &mut new.edges {
            e.direction = (new.vertices[e.vertices[1] as usize] - new.vertices[e.vertices[0] as usize]).normalize();
        }
        new.find_parallels();
        new
    }

    /// Area of a face.
    pub fn face_area(&self, face: usize) -> f64 {
        let corners = self.face_vertices(face);
        let at = |k: usize| self.vertices[corners[k % corners.len()] as usize];
        let fan = (1..corners.len() - 1).map(|k| (at(k) - at(0)).cross(&(at(k + 1) - at(0))));
        0.5 * fan.sum::<Vec3>().norm()
    }

    fn find_parallels(&mut self) {
        self.parallel_edges = parallels(self.edges.iter().map(|e| e.direction));
        self.parallel_faces = parallels(self.faces.iter().map(|f| f.normal));
    }

    /// Corner points.
    #[inline]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Face planes.
    #[inline]
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Edges.
    #[inline]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Sets of parallel edges; empty if there are more than 64 edges.
    #[inline]
    pub(crate) fn parallel_edges(&self) -> &[Parallels] {
        &self.parallel_edges
    }

    /// Sets of parallel faces; empty if there are more than 64 faces.
    #[inline]
    pub(crate) fn parallel_faces(&self) -> &[Parallels] {
        &self.parallel_faces
    }

    /// Vertices of a face, counter-clockwise seen from outside.
    #[inline]
    pub fn face_vertices(&self, face: usize) -> &[u32] {
        let f = &self.faces[face];
        &self.face_vertices[f.first as usize..(f.first + f.len) as usize]
    }

    /// Edges of a face: the k-th goes from its k-th vertex to the next.
    #[inline]
    pub fn face_edges(&self, face: usize) -> &[u32] {
        let f = &self.faces[face];
        &self.face_edges[f.first as usize..(f.first + f.len) as usize]
    }

    /// Faces around a vertex, in ascending order.
    #[inline]
    pub fn vertex_faces(&self, vertex: usize) -> &[u32] {
        &self.vertex_faces[self.vertex_faces_start[vertex] as usize..self.vertex_faces_start[vertex + 1] as usize]
    }

    /// Largest extent along a coordinate axis.
    pub(crate) fn size(&self) -> f64 {
        extent(&self.vertices)
    }

    fn check(&self) -> Result<(), TopologyError> {
        let invalid = |reason: String| Err(TopologyError::Invalid(reason));
        if self.edges.len() > MAX_EDGES {
            return Err(TopologyError::TooMany { what: "edges", count: self.edges.len(), most: MAX_EDGES });
        }
        let euler = self.vertices.len() as i64 - self.edges.len() as i64 + self.faces.len() as i64;
        if euler != 2 {
            return invalid(format!("V - E + F is {euler}, not 2"));
        }
        if (0..self.vertices.len()).any(|v| self.vertex_faces(v).len() < 3) {
            return invalid("a vertex with fewer than three faces".into());
        }
        let size = self.size();
        for (i, f) in self.faces.iter().enumerate() {
            if !(f.normal.norm() - 1.0).abs().le(&1e-9) {
                return invalid(format!("face {i} has no area"));
            }
            let out = self.vertices.iter().map(|v| f.normal.dot(v) - f.offset).fold(f64::MIN, f64::max);
            if !out.le(&(CONVEXITY * size)) {
                return invalid(format!("a vertex lies {:e} of the size outside face {i}", out / size));
            }
            let off =
                self.face_vertices(i).iter().map(|&v| (f.normal.dot(&self.vertices[v as usize]) - f.offset).abs());
            let off = off.fold(0.0, f64::max);
            if off > CONVEXITY * size {
                return invalid(format!("face {i} is off its plane by {:e} of the size", off / size));
            }
        }
        Ok(())
    }
}

/// Largest extent of points along a coordinate axis.
pub(crate) fn extent(points: &[Vec3]) -> f64 {
    let Some(first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((*first, *first), |(l, h), p| (l.inf(p), h.sup(p)));
    (high - low).max()
}

fn parallels(directions: impl ExactSizeIterator<Item = Vec3>) -> Vec<Parallels> {
    let mut sets: Vec<Parallels> = Vec::new();
    if directions.len() > 64 {
        return sets;
    }
    for (i, d) in directions.enumerate() {
        let bit = 1 << i;
        if let Some(set) = sets.iter_mut().find(|s| s.direction == d) {
            set.along |= bit;
        } else if let Some(set) = sets.iter_mut().find(|s| s.direction == -d) {
            set.against |= bit;
        } else {
            sets.push(Parallels { direction: d, along: bit, against: 0 });
        }
    }
    sets
}

/// Unit normal (right-handed about the loop) from the polygon's area vector, and the offset of its first vertex.
fn plane(vertices: &[Vec3], polygon: &[u32]) -> (Vec3, f64) {
    let at = |k: usize| vertices[polygon[k % polygon.len()] as usize];
    let origin = at(0);
    let mut area = Vec3::zeros();
    for k in 1..polygon.len() - 1 {
        area += (at(k) - origin).cross(&(at(k + 1) - origin));
    }
    let normal = area / area.norm();
    (normal, normal.dot(&origin))
}

fn mean_offset(vertices: &[Vec3], polygon: &[u32], normal: &Vec3) -> f64 {
    let first = normal.dot(&vertices[polygon[0] as usize]);
    // relative to the first, so that exactly planar faces keep an exact offset
    let rest: f64 = polygon.iter().map(|&v| normal.dot(&vertices[v as usize]) - first).sum();
    first + rest / polygon.len() as f64
}

type EdgeArrays = (Vec<Edge>, Vec<u32>);

fn edges_of(vertices: &[Vec3], loops: &[Vec<u32>]) -> Result<EdgeArrays, TopologyError> {
    let mut index = BTreeMap::new();
    let mut edges: Vec<Edge> = Vec::new();
    let mut face_edges = Vec::new();
    let mut uses: Vec<u8> = Vec::new();
    for (f, polygon) in loops.iter().enumerate() {
        for (k, &from) in polygon.iter().enumerate() {
            let to = polygon[(k + 1) % polygon.len()];
            let e = *index.entry((from.min(to), from.max(to))).or_insert(edges.len());
            if e == edges.len() {
                let direction = (vertices[to as usize] - vertices[from as usize]).normalize();
                edges.push(Edge { vertices: [from, to], faces: [f as u32; 2], direction });
                uses.push(1);
            } else {
                uses[e] = if edges[e].vertices == [to, from] { uses[e] + 1 } else { 99 };
                edges[e].faces[1] = f as u32;
            }
            face_edges.push(e as u32);
        }
    }
    if uses.iter().any(|&n| n != 2) {
        return Err(TopologyError::Invalid("an edge is not between exactly two faces".into()));
    }
    Ok((edges, face_edges))
}

fn faces_around_vertices(count: usize, loops: &[Vec<u32>]) -> (Vec<u32>, Vec<u32>) {
    let mut around = vec![Vec::new(); count];
    for (f, polygon) in loops.iter().enumerate() {
        for &v in polygon {
            around[v as usize].push(f as u32);
        }
    }
    let mut start = vec![0];
    let mut flat = Vec::new();
    for faces in around {
        flat.extend(faces);
        start.push(flat.len() as u32);
    }
    (start, flat)
}
