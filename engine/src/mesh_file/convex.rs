//! From closed surfaces to convex parts.

use std::collections::BTreeMap;

use super::{MeshFileError, TriangleMesh};
use crate::math::Vec3;
use crate::shape::{PartDescription, ShapeDescription};

/// How far a vertex may lie off a plane that it should be in, over the size: single precision of rotated bodies.
const FLAT: f64 = 2e-6;
/// Area of a triangle over the squared size that counts as none.
const NO_AREA: f64 = 1e-14;
/// Rounds of straightening; each takes the deviation down by a half at least.
const ROUNDS: usize = 60;

/// A shape of the meshes: each connected closed surface is a convex part. Faces that are flat up to single precision
/// are made flat.
pub fn convex_parts(meshes: &[TriangleMesh]) -> Result<ShapeDescription, MeshFileError> {
    let mut parts = Vec::new();
    for mesh in meshes {
        for (triangles, vertices) in components(mesh)? {
            let piece = Piece::new(mesh, &triangles, &vertices)?;
            let vertices_m = piece.straightened().into_iter().map(<[f64; 3]>::from).collect();
            parts.push(ShapeDescription::ConvexPolyhedron { vertices_m });
        }
    }
    match parts.len() {
        0 => Err(MeshFileError::Empty),
        1 => Ok(parts.remove(0)),
        _ => Ok(ShapeDescription::Composite {
            parts: parts
                .into_iter()
                .map(|shape| PartDescription {
                    shape: Box::new(shape),
                    position_m: [0.0; 3],
                    orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
                })
                .collect(),
            mass_properties: None,
        }),
    }
}

type Component = (Vec<usize>, Vec<u32>);

/// Triangles and vertices of each connected surface, after its edges have been found closed and oriented.
fn components(mesh: &TriangleMesh) -> Result<Vec<Component>, MeshFileError> {
    let at = |v: u32| mesh.vertices[v as usize];
    let mut across: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (k, triangle) in mesh.triangles.iter().enumerate() {
        for side in 0..3 {
            let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
            if from == to {
                return Err(MeshFileError::Degenerate { triangle: k, mesh: mesh.name.clone() });
            }
            if across.insert((from, to), k).is_some() {
                return Err(MeshFileError::TurnedOver { mesh: mesh.name.clone(), from: at(from), to: at(to) });
            }
        }
    }
    if let Some((from, to)) = across.keys().find(|(from, to)| !across.contains_key(&(*to, *from))) {
        return Err(MeshFileError::Open { mesh: mesh.name.clone(), from: at(*from), to: at(*to) });
    }
    let mut taken = vec![false; mesh.triangles.len()];
    let mut found = Vec::new();
    for seed in 0..mesh.triangles.len() {
        if std::mem::replace(&mut taken[seed], true) {
            continue;
        }
        let (mut waiting, mut own) = (vec![seed], Vec::new());
        while let Some(k) = waiting.pop() {
            own.push(k);
            let triangle = mesh.triangles[k];
            for side in 0..3 {
                let other = across[&(triangle[(side + 1) % 3], triangle[side])];
                if !std::mem::replace(&mut taken[other], true) {
                    waiting.push(other);
                }
            }
        }
        own.sort_unstable();
        let mut vertices: Vec<u32> = own.iter().flat_map(|&k| mesh.triangles[k]).collect();
        vertices.sort_unstable();
        vertices.dedup();
        found.push((own, vertices));
    }
    Ok(found)
}

/// One closed convex surface, its triangles gathered into flat faces.
struct Piece {
    points: Vec<Vec3>,
    /// Triangles of each face.
    faces: Vec<Vec<[usize; 3]>>,
    size: f64,
}

impl Piece {
    fn new(mesh: &TriangleMesh, triangles: &[usize], vertices: &[u32]) -> Result<Self, MeshFileError> {
        let points: Vec<Vec3> = vertices.iter().map(|&v| Vec3::from(mesh.vertices[v as usize])).collect();
        let index = |v: u32| vertices.binary_search(&v).expect("a vertex of its own");
        let corners: Vec<[usize; 3]> = triangles.iter().map(|&k| mesh.triangles[k].map(index)).collect();
        let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.inf(p), h.sup(p)));
        let size = (high - low).norm();
        let name = || mesh.name.clone();
        let areas: Vec<Vec3> = corners.iter().map(|c| area(&points, c)).collect();
        if let Some(k) =
            areas.iter().position(|area| area.norm().partial_cmp(&(NO_AREA * size * size)).is_none_or(|o| o.is_le()))
        {
            return Err(MeshFileError::Degenerate { triangle: triangles[k], mesh: name() });
        }
        let cone = |(c, area): (&[usize; 3], &Vec3)| (points[c[0]] - points[0]).dot(area) / 3.0;
        if corners.iter().zip(&areas).map(cone).sum::<f64>() <= 0.0 {
            return Err(MeshFileError::Inverted { mesh: name() });
        }
        for (c, area) in corners.iter().zip(&areas) {
            let normal = area.normalize();
            let heights = points.iter().map(|p| normal.dot(&(p - points[c[0]])));
            let highest = heights.enumerate().fold((0, 0.0), |most, x| if x.1 > most.1 { x } else { most });
            // slivers have no plane to speak of
            let reliable = area.norm() > FLAT * size * size;
            if reliable && highest.1 > FLAT * size {
                let vertex = vertices[highest.0] as usize;
                return Err(MeshFileError::NotConvex { mesh: name(), vertex, relative: highest.1 / size });
            }
        }
        Ok(Self { faces: gather(&points, &corners, &areas, size), points, size })
    }

    /// Its corners, moved as little as makes every face flat. Faces take the plane of their triangles, corners go where
    /// their planes meet; a corner of more than three faces is what needs several rounds.
    fn straightened(mut self) -> Vec<Vec3> {
        let mut faces_of = vec![Vec::new(); self.points.len()];
        for (face, triangles) in self.faces.iter().enumerate() {
            for &v in triangles.iter().flatten() {
                if !faces_of[v].contains(&face) {
                    faces_of[v].push(face);
                }
            }
        }
        for _ in 0..ROUNDS {
            let planes: Vec<(Vec3, f64)> = self.faces.iter().map(|face| self.plane(face)).collect();
            let mut farthest = 0.0f64;
            for (point, own) in self.points.iter_mut().zip(&faces_of) {
                let rows = nalgebra::DMatrix::from_fn(own.len(), 3, |row, axis| planes[own[row]].0[axis]);
                let off =
                    nalgebra::DVector::from_fn(own.len(), |row, _| planes[own[row]].1 - planes[own[row]].0.dot(point));
                farthest = farthest.max(off.amax());
                if let Ok(step) = rows.svd(true, true).solve(&off, 1e-6) {
                    *point += Vec3::new(step[0], step[1], step[2]);
                }
            }
            if farthest <= 1e-16 * self.size {
                break;
            }
        }
        let is_corner = |(_, own): &(&Vec3, &Vec<usize>)| own.len() >= 3;
        self.points.iter().zip(&faces_of).filter(is_corner).map(|(point, _)| *point).collect()
    }

    fn plane(&self, face: &[[usize; 3]]) -> (Vec3, f64) {
        let normal = face.iter().map(|c| area(&self.points, c)).sum::<Vec3>().normalize();
        let corners = face.iter().flatten();
        let offset = corners.clone().map(|&v| normal.dot(&self.points[v])).sum::<f64>() / corners.count() as f64;
        (normal, offset)
    }
}

fn area(points: &[Vec3], c: &[usize; 3]) -> Vec3 {
    (points[c[1]] - points[c[0]]).cross(&(points[c[2]] - points[c[0]])) * 0.5
}

/// Neighbouring triangles that lie in the plane of the largest of them are one face.
fn gather(points: &[Vec3], corners: &[[usize; 3]], areas: &[Vec3], size: f64) -> Vec<Vec<[usize; 3]>> {
    let mut across = BTreeMap::new();
    for (k, c) in corners.iter().enumerate() {
        (0..3).for_each(|side| {
            across.insert((c[side], c[(side + 1) % 3]), k);
        });
    }
    let mut order: Vec<usize> = (0..corners.len()).collect();
    order.sort_by(|&i, &j| areas[j].norm().total_cmp(&areas[i].norm()).then(i.cmp(&j)));
    let mut taken = vec![false; corners.len()];
    let mut faces = Vec::new();
    for seed in order {
        if std::mem::replace(&mut taken[seed], true) {
            continue;
        }
        let normal = areas[seed].normalize();
        let in_plane = |k: usize| {
            corners[k].iter().all(|&v| normal.dot(&(points[v] - points[corners[seed][0]])).abs() <= FLAT * size)
        };
        let (mut waiting, mut face) = (vec![seed], Vec::new());
        while let Some(k) = waiting.pop() {
            face.push(corners[k]);
            for side in 0..3 {
                let other = across[&(corners[k][(side + 1) % 3], corners[k][side])];
                if !taken[other] && in_plane(other) {
                    taken[other] = true;
                    waiting.push(other);
                }
            }
        }
        faces.push(face);
    }
    faces
}
