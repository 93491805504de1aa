//! What new particles must not overlap, by grid cell.

use std::collections::HashMap;

use super::Surroundings;
use crate::boundary::Boundary;
use crate::cell::Cell;
use crate::math::{Similarity, Vec3};
use crate::mesh::{Mesh, PartAtMesh};
use crate::narrow::{self, Manifold, PairCache};
use crate::particles::NewParticle;
use crate::scene::Scene;
use crate::shape::Shape;

/// Particles by grid cell, for overlap tests.
pub(super) struct Space<'a> {
    surroundings: &'a Surroundings<'a>,
    cell: &'a Cell,
    size: f64,
    by_cell: HashMap<[i64; 3], Vec<NewParticle>>,
    manifold: Manifold,
}

impl<'a> Space<'a> {
    pub fn new(surroundings: &'a Surroundings<'a>) -> Self {
        let scene = surroundings.scene;
        let largest_shape = scene.shapes().iter().map(Shape::bounding_radius).fold(0.0, f64::max);
        let largest = surroundings.present.iter().map(|p| p.radius).fold(largest_shape, f64::max);
        let mut space = Self {
            surroundings,
            cell: scene.cell(),
            size: 2.0 * largest,
            by_cell: HashMap::new(),
            manifold: Manifold::default(),
        };
        surroundings.present.iter().for_each(|particle| space.add(*particle));
        space
    }

    fn key(&self, x: &Vec3) -> [i64; 3] {
        std::array::from_fn(|axis| (x[axis] / self.size).floor() as i64)
    }

    /// Adds the particle and its images near the faces of the periodic cell.
    pub fn add(&mut self, mut particle: NewParticle) {
        self.cell.wrap(&mut particle.position);
        // A later, larger particle would reach beyond one grid cell: start over with larger ones.
        if 2.0 * particle.radius > self.size {
            self.size = 2.0 * particle.radius;
            let all: Vec<NewParticle> = self.by_cell.drain().flat_map(|(_, list)| list).collect();
            all.into_iter().for_each(|p| self.by_cell.entry(self.key(&p.position)).or_default().push(p));
        }
        self.by_cell.entry(self.key(&particle.position)).or_default().push(particle);
    }

    pub fn is_free(&mut self, candidate: &NewParticle) -> bool {
        let mut candidate = *candidate;
        self.cell.wrap(&mut candidate.position);
        self.surroundings
            .boundaries
            .iter()
            .all(|boundary| !touches_boundary(&candidate, boundary, self.surroundings.scene, &mut self.manifold))
            && self.is_free_of_particles(&candidate)
    }

    fn is_free_of_particles(&mut self, candidate: &NewParticle) -> bool {
        let reach = (candidate.radius + 0.5 * self.size) / self.size;
        let span = reach.ceil() as i64;
        let mut images = vec![Vec3::zeros()];
        for axis in (0..3).filter(|&axis| self.cell.periodic[axis]) {
            let length = self.cell.extent[axis];
            let with = |sign: f64| {
                let mut step = Vec3::zeros();
                step[axis] = sign * length;
                step
            };
            images = images.iter().flat_map(|x| [*x, x + with(1.0), x + with(-1.0)]).collect();
        }
        for image in images {
            let x = candidate.position + image;
            let centre = self.key(&x);
            for dx in -span..=span {
                for dy in -span..=span {
                    for dz in -span..=span {
                        let key = [centre[0] + dx, centre[1] + dy, centre[2] + dz];
                        let Some(list) = self.by_cell.get(&key) else { continue };
                        let scene = self.surroundings.scene;
                        if list
                            .iter()
                            .any(|other| overlaps(candidate, &(other.position - x), other, scene, &mut self.manifold))
                        {
                            return false;
                        }
                    }
                }
            }
        }
        true
    }
}

/// Whether two particles, `d` apart, touch.
fn overlaps(a: &NewParticle, d: &Vec3, b: &NewParticle, scene: &Scene, manifold: &mut Manifold) -> bool {
    let reach = a.radius + b.radius;
    if d.norm_squared() >= reach * reach {
        return false;
    }
    let rotation = a.orientation.to_rotation_matrix().into_inner();
    let a_from_b = Similarity {
        rotation: rotation.tr_mul(b.orientation.to_rotation_matrix().matrix()),
        translation: rotation.tr_mul(d) / a.scale,
        scale: b.scale / a.scale,
    };
    let (parts_a, parts_b) = (scene.shapes()[a.shape as usize].parts(), scene.shapes()[b.shape as usize].parts());
    parts_a.iter().any(|part_a| {
        parts_b.iter().any(|part_b| {
            manifold.clear();
            narrow::collide(part_a, part_b, &a_from_b, &mut PairCache::default(), manifold);
            !manifold.points().is_empty()
        })
    })
}

fn touches_boundary(a: &NewParticle, boundary: &Boundary, scene: &Scene, manifold: &mut Manifold) -> bool {
    if boundary.distance(&a.position) >= a.radius {
        return false;
    }
    let rotation = a.orientation.to_rotation_matrix().into_inner();
    let wall_from_body = boundary.wall_from_body(&a.position, &rotation, a.scale);
    if let Some(mesh) = boundary.mesh() {
        return touches_mesh(a, mesh, &wall_from_body, scene, manifold);
    }
    scene.shapes()[a.shape as usize].parts().iter().any(|part| {
        manifold.clear();
        boundary.shape.contacts(part, &wall_from_body, manifold);
        !manifold.points().is_empty()
    })
}

/// Size of a particle beside that of one that lies exactly at a boundary, and does not count as touching it.
const SHY_OF: f64 = 1.0 - 1e-6;

/// Name of a boundary that a particle reaches into by more than rounding.
pub(super) fn boundary_touched_by<'a>(particle: &NewParticle, surroundings: &Surroundings<'a>) -> Option<&'a str> {
    let (scale, radius) = (particle.scale * SHY_OF, particle.radius * SHY_OF);
    let mut shy = NewParticle { scale, radius, ..*particle };
    surroundings.scene.cell().wrap(&mut shy.position);
    let mut manifold = Manifold::default();
    let touches = |boundary: &&Boundary| touches_boundary(&shy, boundary, surroundings.scene, &mut manifold);
    surroundings.boundaries.iter().find(touches).map(|boundary| boundary.name.as_str())
}

/// A part that touches a patch with its centre on the other side touches as well.
fn touches_mesh(
    a: &NewParticle,
    mesh: &Mesh,
    mesh_from_body: &Similarity,
    scene: &Scene,
    manifold: &mut Manifold,
) -> bool {
    let shape = &scene.shapes()[a.shape as usize];
    let mut near = Vec::new();
    shape.parts().iter().any(|part| {
        let centre = mesh_from_body.point(&part.center);
        mesh.near(&centre, part.radius * a.scale, f64::INFINITY, &mut near);
        let at = PartAtMesh { part, mesh_from_body, deepest: 2.0 * part.radius * a.scale };
        near.iter().any(|&element| {
            manifold.clear();
            mesh.contacts(element, &at, manifold);
            !manifold.is_empty() || mesh.height_above(element, &centre).is_some_and(|height| height <= 0.0)
        })
    })
}
