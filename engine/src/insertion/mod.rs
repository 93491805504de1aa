//! Insertion: from a request to particles, all or none.

mod deposition;
mod descent;
mod random;
mod region;
mod space;

use crate::boundary::Boundary;
use crate::error::InvalidInput;
use crate::math::{Quat, Vec3};
use crate::particles::NewParticle;
use crate::random::{Draw, Purpose};
use crate::scene::{InsertionDescription, Placement, ScaleSampler, Scene};
use crate::shape::Shape;

pub(crate) use random::{Amount, place_what_fits};
pub(crate) use region::check_room;

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
    scale: ScaleSampler,
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
        Placement::Deposition { .. } => request.deposit(surroundings, path),
    }
}

/// The smallest and the largest particle that a request may make, at the origin.
pub(crate) fn smallest_and_largest(
    description: &InsertionDescription,
    scene: &Scene,
    path: &str,
) -> Result<[NewParticle; 2], InvalidInput> {
    let request = Request::resolve(description, scene, path)?;
    let at_origin = (Vec3::zeros(), Quat::identity());
    Ok(description.scale.range().map(|scale| request.particle_of_scale(0, scale, at_origin)))
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
        let scale = description.scale.sampler(&format!("{path}.scale"))?;
        if description.frozen && description.angular_velocity_rad_per_s != [0.0; 3] {
            let problem = "is not 0: frozen particles do not turn";
            return Err(InvalidInput::new(format!("{path}.angular_velocity_rad_per_s"), problem));
        }
        let shape = &scene.shapes()[shape_index];
        let (given_orientation, given_centre) = shape.given_from_body();
        Ok(Self {
            description,
            shape_index: shape_index as u32,
            shape,
            material: material as u32,
            density,
            scale,
            given_orientation,
            given_centre,
            seed: raw.scene.seed,
        })
    }

    /// A particle whose given frame has this pose, of a random size.
    fn particle(&self, id: u64, given_position: Vec3, given_orientation: Quat) -> NewParticle {
        self.particle_of_scale(id, self.draw_scale(id), (given_position, given_orientation))
    }

    /// Its size: some laws take long over it, and random placements try many places for one.
    fn draw_scale(&self, id: u64) -> f64 {
        self.scale.draw(&mut Draw::new(self.seed, id, Purpose::Scale))
    }

    fn particle_of_scale(&self, id: u64, scale: f64, (given_position, given_orientation): (Vec3, Quat)) -> NewParticle {
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
            frozen: self.description.frozen,
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
