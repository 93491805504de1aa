//! Insertion: from a request to particles, all or none.

use std::collections::HashMap;

use crate::boundary::Boundary;
use crate::cell::Cell;
use crate::error::InvalidInput;
use crate::math::{Quat, Similarity, Vec3};
use crate::mesh::{Mesh, PartAtMesh};
use crate::narrow::{self, Manifold, PairCache};
use crate::particles::NewParticle;
use crate::random::{Draw, Purpose};
use crate::scene::{InsertionDescription, Placement, Region, Scene};
use crate::shape::Shape;

/// Most particles of one request: beyond it something is mistyped, and memory would go.
const MOST_PARTICLES: u64 = 10_000_000;

/// What the new particles must not overlap, and where they get their numbers from.
pub struct Surroundings<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Boundaries as they are now.
    pub boundaries: &'a [Boundary],
    /// Particles present.
    pub present: &'a [NewParticle],
    /// Id of the first new particle.
    pub first_id: u64,
}

/// Names and numbers of a request, resolved.
struct Request<'a> {
    description: &'a InsertionDescription,
    shape_index: u32,
    shape: &'a Shape,
    material: u32,
    density: f64,
    given_orientation: Quat,
    given_centre: Vec3,
    seed: u64,
}

/// The particles of a request, with ids from `first_id` on. `path` names the request in errors.
pub fn place(
    description: &InsertionDescription,
    surroundings: &Surroundings<'_>,
    path: &str,
) -> Result<Vec<NewParticle>, InvalidInput> {
    let request = Request::resolve(description, surroundings.scene, path)?;
    match &description.placement {
        Placement::Poses { positions_m, orientations_wxyz } => {
            request.poses(positions_m, orientations_wxyz, surroundings.first_id, path)
        }
        Placement::Lattice { origin_m, spacing_m, counts, random_orientation } => {
            request.lattice([origin_m, spacing_m], *counts, *random_orientation, surroundings.first_id, path)
        }
        Placement::Random { .. } => request.random(surroundings, path),
    }
}

fn finite(values: &[f64; 3], path: &str) -> Result<Vec3, InvalidInput> {
    if values.iter().all(|v| v.is_finite()) {
        Ok(Vec3::from(*values))
    } else {
        Err(InvalidInput::new(path, format!("is {values:?}; every component must be finite")))
    }
}

fn find<'a>(names: impl Iterator<Item = &'a str> + Clone, name: &str, path: String) -> Result<usize, InvalidInput> {
    names.clone().position(|known| known == name).ok_or_else(|| {
        let known: Vec<&str> = names.collect();
        InvalidInput::new(path, format!("'{name}' is not defined; the scene has {known:?}"))
    })
}

impl<'a> Request<'a> {
    fn resolve(description: &'a InsertionDescription, scene: &'a Scene, path: &str) -> Result<Self, InvalidInput> {
        let raw = scene.description();
        let shape_names = raw.shapes.iter().map(|shape| shape.name.as_str());
        let shape_index = find(shape_names, &description.shape, format!("{path}.shape"))?;
        let material_names = raw.materials.iter().map(|material| material.name.as_str());
        let material = find(material_names, &description.material, format!("{path}.material"))?;
        let density = raw.materials[material].density_kg_per_m3.ok_or_else(|| {
            let problem = format!("'{}' has no density_kg_per_m3, which particles need", description.material);
            InvalidInput::new(format!("{path}.material"), problem)
        })?;
        scene.check_pairs_of(material, path)?;
        finite(&description.velocity_m_per_s, &format!("{path}.velocity_m_per_s"))?;
        finite(&description.angular_velocity_rad_per_s, &format!("{path}.angular_velocity_rad_per_s"))?;
        let (min, max) = (description.scale.min, description.scale.max);
        if !(min > 0.0 && min <= max && max.is_finite()) {
            return Err(InvalidInput::new(format!("{path}.scale"), format!("is [{min}, {max}]; needs 0 < min <= max")));
        }
        let shape = &scene.shapes()[shape_index];
        let (given_orientation, given_centre) = shape.given_from_body();
        Ok(Self {
            description,
            shape_index: shape_index as u32,
            shape,
            material: material as u32,
            density,
            given_orientation,
            given_centre,
            seed: raw.scene.seed,
        })
    }

    /// A particle whose given frame has this pose.
    fn particle(&self, id: u64, given_position: Vec3, given_orientation: Quat) -> NewParticle {
        let range = self.description.scale;
        let scale = if range.min == range.max {
            range.min
        } else {
            Draw::new(self.seed, id, Purpose::Scale).between(range.min, range.max)
        };
        let mass_properties = self.shape.mass_properties();
        NewParticle {
            id,
            shape: self.shape_index,
            material: self.material,
            scale,
            mass: self.density * mass_properties.volume * scale.powi(3),
            inertia: mass_properties.principal_inertia * (self.density * scale.powi(5)),
            radius: self.shape.bounding_radius() * scale,
            position: given_position + given_orientation * (self.given_centre * scale),
            orientation: given_orientation * self.given_orientation,
            velocity: Vec3::from(self.description.velocity_m_per_s),
            angular_velocity: Vec3::from(self.description.angular_velocity_rad_per_s),
        }
    }

    fn poses(
        &self,
        positions: &[[f64; 3]],
        orientations: &[[f64; 4]],
        first_id: u64,
        path: &str,
    ) -> Result<Vec<NewParticle>, InvalidInput> {
        if !orientations.is_empty() && orientations.len() != positions.len() {
            let problem =
                format!("has {} entries for {} positions; give one each, or none", orientations.len(), positions.len());
            return Err(InvalidInput::new(format!("{path}.placement.orientations_wxyz"), problem));
        }
        let mut particles = Vec::with_capacity(positions.len());
        for (k, position) in positions.iter().enumerate() {
            let position = finite(position, &format!("{path}.placement.positions_m[{k}]"))?;
            let orientation = match orientations.get(k) {
                None => Quat::identity(),
                Some(wxyz) => unit_quaternion(wxyz).map_err(|problem| {
                    InvalidInput::new(format!("{path}.placement.orientations_wxyz[{k}]"), problem)
                })?,
            };
            particles.push(self.particle(first_id + k as u64, position, orientation));
        }
        Ok(particles)
    }

    fn lattice(
        &self,
        [origin, spacing]: [&[f64; 3]; 2],
        counts: [u32; 3],
        random_orientation: bool,
        first_id: u64,
        path: &str,
    ) -> Result<Vec<NewParticle>, InvalidInput> {
        let origin = finite(origin, &format!("{path}.placement.origin_m"))?;
        let spacing = finite(spacing, &format!("{path}.placement.spacing_m"))?;
        let total = counts.iter().map(|&c| u64::from(c)).try_fold(1u64, u64::checked_mul).unwrap_or(u64::MAX);
        if total > MOST_PARTICLES {
            let problem = format!("are {counts:?}, {total} nodes; at most {MOST_PARTICLES} are allowed");
            return Err(InvalidInput::new(format!("{path}.placement.counts"), problem));
        }
        let mut particles = Vec::with_capacity(total as usize);
        for x in 0..counts[0] {
            for y in 0..counts[1] {
                for z in 0..counts[2] {
                    let id = first_id + particles.len() as u64;
                    let node = Vec3::new(f64::from(x), f64::from(y), f64::from(z));
                    let orientation = self.orientation(id, random_orientation);
                    particles.push(self.particle(id, origin + spacing.component_mul(&node), orientation));
                }
            }
        }
        Ok(particles)
    }

    fn orientation(&self, id: u64, random: bool) -> Quat {
        if random { Draw::new(self.seed, id, Purpose::Orientation).orientation() } else { Quat::identity() }
    }

    fn random(&self, surroundings: &Surroundings<'_>, path: &str) -> Result<Vec<NewParticle>, InvalidInput> {
        let Placement::Random { region, count, solid_fraction, fixed_orientation, attempts } =
            &self.description.placement
        else {
            unreachable!("called for random placements only")
        };
        let volume = region_volume(region, path)?;
        let target = match (count, solid_fraction) {
            (Some(count), None) => Target::Count(u64::from(*count)),
            (None, Some(fraction)) if *fraction > 0.0 && *fraction < 1.0 => Target::Volume(fraction * volume),
            (None, Some(fraction)) => {
                let problem = format!("is {fraction}; must lie in (0, 1)");
                return Err(InvalidInput::new(format!("{path}.placement.solid_fraction"), problem));
            }
            _ => return Err(InvalidInput::new(format!("{path}.placement"), "give count or solid_fraction, not both")),
        };
        let mut space = Space::new(surroundings);
        let mut particles = Vec::new();
        let mut filled = 0.0;
        let mut first_of_id = 0;
        while !target.is_reached(particles.len() as u64, filled) {
            let id = surroundings.first_id + particles.len() as u64;
            let mut draw = Draw::new(self.seed, id, Purpose::Position);
            let orientation = self.orientation(id, !fixed_orientation);
            let placed = (0..*attempts).find_map(|_| {
                let candidate = self.particle(id, draw_point(region, &mut draw), orientation);
                (is_inside(region, &candidate) && space.is_free(&candidate)).then_some(candidate)
            });
            let Some(particle) = placed else {
                let problem = format!(
                    "no free place for particle {} of the request after {attempts} attempts; ask for fewer, or enlarge the region",
                    particles.len()
                );
                return Err(InvalidInput::new(format!("{path}.placement"), problem));
            };
            filled += particle.mass / self.density;
            space.add(particle);
            particles.push(particle);
            first_of_id += 1;
            if first_of_id > MOST_PARTICLES {
                return Err(InvalidInput::new(
                    format!("{path}.placement"),
                    format!("asks for more than {MOST_PARTICLES} particles"),
                ));
            }
        }
        Ok(particles)
    }
}

/// When random insertion is done.
enum Target {
    Count(u64),
    Volume(f64),
}

impl Target {
    fn is_reached(&self, count: u64, filled: f64) -> bool {
        match self {
            Target::Count(wanted) => count >= *wanted,
            Target::Volume(wanted) => filled >= *wanted,
        }
    }
}

/// Normalises (w, x, y, z), or says why it cannot.
pub fn unit_quaternion(wxyz: &[f64; 4]) -> Result<Quat, String> {
    let q = nalgebra::Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    let norm = q.norm();
    if norm.is_finite() && (norm - 1.0).abs() < 1e-3 {
        Ok(Quat::new_normalize(q))
    } else {
        Err(format!("is {wxyz:?} of norm {norm}; must be a unit quaternion (w, x, y, z) to 1e-3"))
    }
}

fn region_volume(region: &Region, path: &str) -> Result<f64, InvalidInput> {
    let volume = match region {
        Region::Box { min_m, max_m } => (Vec3::from(*max_m) - Vec3::from(*min_m)).map(|l| l.max(0.0)).product(),
        Region::Cylinder { axis, radius_m, length_m, .. } if Vec3::from(*axis).norm() > 0.0 => {
            std::f64::consts::PI * radius_m * radius_m.abs() * length_m
        }
        Region::Cylinder { .. } => 0.0,
    };
    if volume.is_finite() && volume > 0.0 {
        Ok(volume)
    } else {
        Err(InvalidInput::new(
            format!("{path}.placement.region"),
            format!("has volume {volume} m3; must be positive and finite"),
        ))
    }
}

fn draw_point(region: &Region, draw: &mut Draw) -> Vec3 {
    match region {
        Region::Box { min_m, max_m } => draw.in_box(&Vec3::from(*min_m), &Vec3::from(*max_m)),
        Region::Cylinder { point_m, axis, radius_m, length_m } => {
            let z = Vec3::from(*axis).normalize();
            let frame = nalgebra::Rotation3::rotation_between(&Vec3::z(), &z)
                .unwrap_or_else(|| nalgebra::Rotation3::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI));
            let (rho, angle) = (radius_m * draw.unit().sqrt(), std::f64::consts::TAU * draw.unit());
            let local = Vec3::new(rho * angle.cos(), rho * angle.sin(), length_m * draw.unit());
            Vec3::from(*point_m) + frame * local
        }
    }
}

/// Whether the bounding sphere lies in the region.
fn is_inside(region: &Region, particle: &NewParticle) -> bool {
    let (x, r) = (particle.position, particle.radius);
    match region {
        Region::Box { min_m, max_m } => (0..3).all(|axis| x[axis] - r >= min_m[axis] && x[axis] + r <= max_m[axis]),
        Region::Cylinder { point_m, axis, radius_m, length_m } => {
            let d = x - Vec3::from(*point_m);
            let z = Vec3::from(*axis).normalize();
            let along = d.dot(&z);
            along - r >= 0.0 && along + r <= *length_m && (d - z * along).norm() + r <= *radius_m
        }
    }
}

/// Particles by grid cell, for overlap tests.
struct Space<'a> {
    surroundings: &'a Surroundings<'a>,
    cell: &'a Cell,
    size: f64,
    by_cell: HashMap<[i64; 3], Vec<NewParticle>>,
    manifold: Manifold,
}

impl<'a> Space<'a> {
    fn new(surroundings: &'a Surroundings<'a>) -> Self {
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
    fn add(&mut self, mut particle: NewParticle) {
        self.cell.wrap(&mut particle.position);
        // A later, larger particle would reach beyond one grid cell: start over with larger ones.
        if 2.0 * particle.radius > self.size {
            self.size = 2.0 * particle.radius;
            let all: Vec<NewParticle> = self.by_cell.drain().flat_map(|(_, list)| list).collect();
            all.into_iter().for_each(|p| self.by_cell.entry(self.key(&p.position)).or_default().push(p));
        }
        self.by_cell.entry(self.key(&particle.position)).or_default().push(particle);
    }

    fn is_free(&mut self, candidate: &NewParticle) -> bool {
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
