//! The skeleton of a rounded polyhedron: vertices, edges and faces that a ball is swept over.

use super::error::ShapeError;
use super::polyhedron::{Polyhedron, extent};
use super::skeleton_topology::{Loops, edges_of_loops, faces_of_edges, is_convex_and_closed, outwards};
use crate::math::{Mat3, Vec3};

/// Most vertices, edges or faces of one skeleton: an index has 14 bits in a feature key.
pub const MAX_FEATURES: usize = 1 << 14;
/// How far a face's vertices may lie off its plane or inside its sides, over the size: other programs write rounded
/// numbers.
const FLAT: f64 = 1e-6;
/// Boundaries between the regions of a vertex, an edge and a face, over the size: features that lie exactly on one,
/// as in aligned stacks, stay on the side of the face.
const BOUNDARY: f64 = 1e-9;

/// A half-plane's edge: `inwards . x - offset` is positive on the side of the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Unit vector in the plane of the face, across its edge.
    pub inwards: Vec3,
    /// Of the edge.
    pub offset: f64,
}

/// A face plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkeletonFace {
    /// Unit; outwards where the skeleton is convex.
    pub normal: Vec3,
    /// Of the plane.
    pub offset: f64,
}

/// An edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkeletonEdge {
    /// One end.
    pub start: Vec3,
    /// From there to the other.
    pub along: Vec3,
    /// Squared length.
    pub length2: f64,
    /// Its ends, as vertices.
    pub vertices: [u32; 2],
}

/// Lists of one row each, in one array.
#[derive(Clone, Debug, PartialEq)]
struct Rows<T> {
    starts: Vec<u32>,
    values: Vec<T>,
}

impl<T: Clone> Rows<T> {
    fn new(rows: &[Vec<T>]) -> Self {
        let mut starts = vec![0];
        let mut values = Vec::new();
        for row in rows {
            values.extend_from_slice(row);
            starts.push(values.len() as u32);
        }
        Self { starts, values }
    }

    #[inline(always)]
    fn row(&self, k: usize) -> &[T] {
        &self.values[self.starts[k] as usize..self.starts[k + 1] as usize]
    }
}

/// Vertices, edges and faces with a Minkowski radius, and the regions of space that are nearest to each.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    /// Of the ball, in the unit of the body frame.
    pub radius: f64,
    /// Largest distance of a vertex from the origin.
    pub reach: f64,
    /// Mean of the vertices.
    pub middle: Vec3,
    /// How far behind its faces a vertex still belongs to them; 0 where faces have no outside.
    pub depth: f64,
    /// Width of the boundaries between regions.
    pub tolerance: f64,
    vertices: Vec<Vec3>,
    edges: Vec<SkeletonEdge>,
    faces: Vec<SkeletonFace>,
    face_sides: Rows<Side>,
    edge_sides: Rows<Side>,
    vertex_edges: Rows<Vec3>,
    vertex_faces: Rows<u32>,
    loops: Loops,
}

impl Skeleton {
    /// From vertices, edges (those of the faces, when empty) and face loops; errors name `path`.
    pub fn new(
        vertices: Vec<Vec3>,
        edges: &[[u32; 2]],
        loops: &[Vec<u32>],
        radius: f64,
        path: &str,
    ) -> Result<Self, ShapeError> {
        let edges = if edges.is_empty() { edges_of_loops(loops) } else { edges.to_vec() };
        for (what, count) in [("vertices", vertices.len()), ("edges", edges.len()), ("faces", loops.len())] {
            if count > MAX_FEATURES {
                return Err(ShapeError::TooMany { path: path.into(), what, count, most: MAX_FEATURES });
            }
        }
        let size = extent(&vertices);
        let convex = is_convex_and_closed(&vertices, loops, FLAT * size);
        let loops = if convex { outwards(&vertices, loops) } else { loops.to_vec() };
        let new = Self::assemble(vertices, &edges, loops, radius, convex);
        new.check_faces(size, path)?;
        Ok(new)
    }

    fn assemble(vertices: Vec<Vec3>, edges: &[[u32; 2]], loops: Loops, radius: f64, convex: bool) -> Self {
        let mut new = Self {
            radius,
            middle: mean(&vertices),
            reach: vertices.iter().map(|v| v.norm()).fold(0.0, f64::max),
            depth: 0.0,
            tolerance: BOUNDARY * extent(&vertices),
            edges: edges.iter().map(|e| edge(&vertices, *e)).collect(),
            faces: Vec::new(),
            face_sides: Rows::new(&[]),
            edge_sides: Rows::new(&[]),
            vertex_edges: Rows::new(&[]),
            vertex_faces: Rows::new(&[]),
            vertices,
            loops,
        };
        new.find_regions();
        if convex {
            new.depth = 0.25 * new.thickness();
        }
        new
    }

    /// A single vertex or edge: what a sphere and a spherocylinder are swept over.
    pub(crate) fn segment(ends: &[Vec3], radius: f64) -> Self {
        let edges: &[[u32; 2]] = if ends.len() == 2 { &[[0, 1]] } else { &[] };
        Self::assemble(ends.to_vec(), edges, Loops::new(), radius, false)
    }

    /// Of a convex polyhedron; `None` if it has too many features to name.
    pub(crate) fn of_polyhedron(solid: &Polyhedron, radius: f64) -> Option<Self> {
        let edges: Vec<[u32; 2]> = solid.edges().iter().map(|e| e.vertices).collect();
        let loops: Loops = (0..solid.faces().len()).map(|f| solid.face_vertices(f).to_vec()).collect();
        let few = edges.len().max(loops.len()) <= MAX_FEATURES;
        few.then(|| Self::assemble(solid.vertices().to_vec(), &edges, loops, radius, true))
    }

    /// The same skeleton in another frame.
    pub(crate) fn transformed(&self, rotation: &Mat3, translation: &Vec3) -> Self {
        if *rotation == Mat3::identity() && *translation == Vec3::zeros() {
            return self.clone();
        }
        let mut new = self.clone();
        new.vertices.iter_mut().for_each(|v| *v = rotation * *v + translation);
        new.reach = new.vertices.iter().map(|v| v.norm()).fold(0.0, f64::max);
        new.middle = mean(&new.vertices);
        new.edges = self.edges.iter().map(|e| edge(&new.vertices, e.vertices)).collect();
        new.find_regions();
        new
    }

    fn find_regions(&mut self) {
        let plane = |polygon: &Vec<u32>| {
            let normal = corner_normal(&self.vertices, polygon);
            SkeletonFace { normal, offset: normal.dot(&self.vertices[polygon[0] as usize]) }
        };
        self.faces = self.loops.iter().map(plane).collect();
        let side = |face: usize, from: u32, to: u32| {
            let (p, q) = (self.vertices[from as usize], self.vertices[to as usize]);
            let inwards = self.faces[face].normal.cross(&(q - p)).try_normalize(0.0).unwrap_or_else(Vec3::x);
            Side { inwards, offset: inwards.dot(&p) }
        };
        let of_face = |(f, polygon): (usize, &Vec<u32>)| -> Vec<Side> {
            (0..polygon.len()).map(|k| side(f, polygon[k], polygon[(k + 1) % polygon.len()])).collect()
        };
        self.face_sides = Rows::new(&self.loops.iter().enumerate().map(of_face).collect::<Vec<_>>());
        let ends: Vec<[u32; 2]> = self.edges.iter().map(|e| e.vertices).collect();
        let around: Vec<Vec<Side>> = faces_of_edges(&ends, &self.loops)
            .iter()
            .map(|faces| faces.iter().map(|&(f, from, to)| side(f, from, to)).collect())
            .collect();
        self.edge_sides = Rows::new(&around);
        let mut directions = vec![Vec::new(); self.vertices.len()];
        for e in &self.edges {
            let along = e.along.try_normalize(0.0).unwrap_or_else(Vec3::x);
            directions[e.vertices[0] as usize].push(along);
            directions[e.vertices[1] as usize].push(-along);
        }
        self.vertex_edges = Rows::new(&directions);
        let mut faces = vec![Vec::new(); self.vertices.len()];
        for (f, polygon) in self.loops.iter().enumerate() {
            polygon.iter().for_each(|&v| faces[v as usize].push(f as u32));
        }
        self.vertex_faces = Rows::new(&faces);
    }

    /// Faces must be flat and convex polygons: their sides say what lies above them.
    fn check_faces(&self, size: f64, path: &str) -> Result<(), ShapeError> {
        for (f, polygon) in self.loops.iter().enumerate() {
            let face = &self.faces[f];
            let bad = |v: &&u32| {
                let x = &self.vertices[**v as usize];
                let off = (face.normal.dot(x) - face.offset).abs();
                off > FLAT * size || self.sides(f).iter().any(|s| s.inwards.dot(x) - s.offset < -FLAT * size)
            };
            if let Some(v) = polygon.iter().find(bad) {
                let reason = format!("vertex {v} of face {f} is off its plane or makes it concave");
                return Err(ShapeError::Skeleton { path: path.into(), reason });
            }
        }
        Ok(())
    }

    /// Twice the distance of the vertices' mean from the nearest face: a lower bound of a convex skeleton's width.
    fn thickness(&self) -> f64 {
        let depth = |f: &SkeletonFace| f.offset - f.normal.dot(&self.middle);
        2.0 * self.faces.iter().map(depth).fold(f64::INFINITY, f64::min)
    }

    /// Whether faces have an outside: a closed convex surface.
    pub fn is_convex(&self) -> bool {
        self.depth > 0.0
    }

    /// Corner points.
    #[inline(always)]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Edges.
    #[inline(always)]
    pub fn edges(&self) -> &[SkeletonEdge] {
        &self.edges
    }

    /// Face planes.
    #[inline(always)]
    pub fn faces(&self) -> &[SkeletonFace] {
        &self.faces
    }

    /// Vertices of the faces, counter-clockwise about their normals.
    pub(crate) fn loops(&self) -> &[Vec<u32>] {
        &self.loops
    }

    /// Sides of a face.
    #[inline(always)]
    pub fn sides(&self, face: usize) -> &[Side] {
        self.face_sides.row(face)
    }

    /// Sides, at an edge, of the faces that meet there.
    #[inline(always)]
    pub fn sides_at_edge(&self, edge: usize) -> &[Side] {
        self.edge_sides.row(edge)
    }

    /// Unit vectors along the edges that leave a vertex.
    #[inline(always)]
    pub fn directions(&self, vertex: usize) -> &[Vec3] {
        self.vertex_edges.row(vertex)
    }

    /// Faces around a vertex.
    #[inline(always)]
    pub fn faces_at(&self, vertex: usize) -> &[u32] {
        self.vertex_faces.row(vertex)
    }
}

fn edge(vertices: &[Vec3], ends: [u32; 2]) -> SkeletonEdge {
    let [start, end] = ends.map(|v| vertices[v as usize]);
    let along = end - start;
    SkeletonEdge { start, along, length2: along.norm_squared(), vertices: ends }
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len() as f64
}

/// Of the plane of the first corner: faces that are flat to rounded numbers only are as in Rockable, where these come
/// from. Of the whole polygon where the corner is nearly straight.
fn corner_normal(vertices: &[Vec3], polygon: &[u32]) -> Vec3 {
    let at = |k: usize| vertices[polygon[k] as usize];
    let (u, v) = (at(1) - at(0), at(polygon.len() - 1) - at(0));
    let corner = u.cross(&v);
    let straight = corner.norm() < 0.1 * u.norm() * v.norm();
    let normal = if straight { area_vector(vertices, polygon) } else { corner };
    normal.try_normalize(0.0).unwrap_or_else(Vec3::z)
}

/// Twice the area of a polygon along its normal.
pub(super) fn area_vector(vertices: &[Vec3], polygon: &[u32]) -> Vec3 {
    let at = |k: usize| vertices[polygon[k] as usize];
    let mut area = Vec3::zeros();
    for k in 1..polygon.len().saturating_sub(1) {
        area += (at(k) - at(0)).cross(&(at(k + 1) - at(0)));
    }
    area
}
