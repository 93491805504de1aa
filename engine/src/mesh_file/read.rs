//! Bytes of a mesh file to triangles.

use std::cell::Cell;
use std::collections::HashMap;
use std::io::{BufRead, BufReader, Cursor, Read};

use super::{MeshFileError, TriangleMesh};

/// Of a file, by the end of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ: each object or group is a mesh; polygons are fanned; all but `v`, `f`, `o` and `g` is skipped.
    Obj,
    /// STL, text or binary: one mesh; coordinates are single precision.
    Stl,
}

impl MeshFormat {
    /// From a file name.
    pub fn of(name: &str) -> Result<Self, MeshFileError> {
        let name_end = name.rsplit('.').next().unwrap_or("").to_ascii_lowercase();
        match name_end.as_str() {
            "obj" => Ok(Self::Obj),
            "stl" => Ok(Self::Stl),
            _ => Err(MeshFileError::UnknownFormat { name: name.into() }),
        }
    }
}

/// The meshes of a file; every coordinate times `scale`. Equal positions are one vertex; nothing else is changed.
pub fn read_mesh(bytes: &[u8], format: MeshFormat, scale: f64) -> Result<Vec<TriangleMesh>, MeshFileError> {
    let mut meshes = match format {
        MeshFormat::Obj => read_obj(bytes)?,
        MeshFormat::Stl => vec![read_stl(bytes)?],
    };
    meshes.retain(|mesh| !mesh.triangles.is_empty());
    if meshes.is_empty() {
        return Err(MeshFileError::Empty);
    }
    for mesh in &mut meshes {
        for (k, vertex) in mesh.vertices.iter_mut().enumerate() {
            *vertex = vertex.map(|x| x * scale);
            if !vertex.iter().all(|x| x.is_finite()) {
                return Err(MeshFileError::NotFinite { vertex: k, mesh: mesh.name.clone() });
            }
        }
    }
    Ok(meshes)
}

impl TriangleMesh {
    /// Several as one; equal positions are one vertex.
    pub fn joined(meshes: &[Self]) -> Self {
        let mut builder = Builder { name: "the mesh".into(), ..Builder::default() };
        for mesh in meshes {
            for triangle in &mesh.triangles {
                builder.push(triangle.map(|v| mesh.vertices[v as usize]));
            }
        }
        builder.mesh()
    }
}

/// Counts the lines that went through: the reader of OBJ files says what is wrong, but not where.
struct Lines<'a, R> {
    inner: R,
    count: &'a Cell<usize>,
}

impl<R: BufRead> Read for Lines<'_, R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        self.inner.read(out)
    }
}

impl<R: BufRead> BufRead for Lines<'_, R> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    fn consume(&mut self, n: usize) {
        let passed = self.inner.fill_buf().map_or(0, |buffer| buffer[..n].iter().filter(|&&b| b == b'\n').count());
        self.count.set(self.count.get() + passed);
        self.inner.consume(n);
    }
}

fn read_obj(bytes: &[u8]) -> Result<Vec<TriangleMesh>, MeshFileError> {
    let count = Cell::new(0);
    let mut reader = Lines { inner: BufReader::new(bytes), count: &count };
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let without_materials = |_: &std::path::Path| Ok((Vec::new(), Default::default()));
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, without_materials)
        .map_err(|error| MeshFileError::Syntax { at: format!("line {}", count.get()), reason: error.to_string() })?;
    let mut meshes = Vec::new();
    for (k, model) in models.into_iter().enumerate() {
        let name = if model.name.is_empty() { format!("object {k}") } else { format!("object '{}'", model.name) };
        let mut builder = Builder { name, ..Builder::default() };
        for corners in model.mesh.indices.chunks_exact(3) {
            let corner =
                |at: u32| -> [f64; 3] { std::array::from_fn(|axis| model.mesh.positions[3 * at as usize + axis]) };
            builder.push([corner(corners[0]), corner(corners[1]), corner(corners[2])]);
        }
        meshes.push(builder.mesh());
    }
    Ok(meshes)
}

fn read_stl(bytes: &[u8]) -> Result<TriangleMesh, MeshFileError> {
    let syntax = |at: usize, error: std::io::Error| MeshFileError::Syntax {
        at: if at == 0 { "start of the file".into() } else { format!("after triangle {at}") },
        reason: error.to_string(),
    };
    let mut cursor = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|error| syntax(0, error))?;
    let mut builder = Builder { name: "the mesh".into(), ..Builder::default() };
    for (k, triangle) in triangles.enumerate() {
        let triangle = triangle.map_err(|error| syntax(k, error))?;
        builder.push(triangle.vertices.map(|vertex| vertex.0.map(f64::from)));
    }
    Ok(builder.mesh())
}

/// Joins equal positions.
#[derive(Default)]
struct Builder {
    name: String,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    known: HashMap<[u64; 3], u32>,
}

impl Builder {
    fn push(&mut self, corners: [[f64; 3]; 3]) {
        let triangle = corners.map(|x| {
            // -0 is 0
            let bits = x.map(|c| (c + 0.0).to_bits());
            *self.known.entry(bits).or_insert_with(|| {
                self.vertices.push(x);
                self.vertices.len() as u32 - 1
            })
        });
        self.triangles.push(triangle);
    }

    fn mesh(self) -> TriangleMesh {
        TriangleMesh { name: self.name, vertices: self.vertices, triangles: self.triangles }
    }
}
