//! Particles of a checkpoint for another scene.

use super::codec::pack_fields;
use super::container::Sections;
use super::error::CheckpointError;
use super::state::{Row, State};
use super::{CheckpointSummary, SCENE, SUMMARY, read_state};
use crate::boundary::Boundary;
use crate::contact::SpringRecord;
use crate::engine::Engine;
use crate::math::Vec3;
use crate::particles::NewParticle;
use crate::scene::{BoundaryDescription, MotionDescription, Scene, SceneDescription};

/// The scene that a checkpoint was taken from, as a part of it.
pub(super) struct WrittenScene {
    toml: Vec<u8>,
}

pack_fields!(WrittenScene { toml: Vec<u8> });

impl WrittenScene {
    pub fn of(scene: &Scene) -> Result<Self, CheckpointError> {
        Ok(Self { toml: scene.description().to_toml()?.into_bytes() })
    }

    fn description(&self) -> Result<SceneDescription, String> {
        let text = std::str::from_utf8(&self.toml).map_err(|error| error.to_string())?;
        SceneDescription::from_toml(text).map_err(|error| error.problem)
    }
}

/// What another scene starts with.
#[derive(Clone, Debug)]
pub(crate) struct Bed {
    particles: Vec<NewParticle>,
    springs: Vec<SpringRecord>,
    from: String,
    time_s: f64,
    history: String,
}

/// First key of a spring at a boundary.
const BOUNDARY: u64 = 1 << 63;

impl Engine {
    /// A checkpoint that other scenes can start with, too: one with the scene in it.
    ///
    /// # Errors
    /// [`CheckpointError::RunFailed`]: nothing could go on from there.
    pub fn prepared(&self) -> Result<Vec<u8>, CheckpointError> {
        self.checkpoint_with(Some(WrittenScene::of(&self.written)?))
    }
}

impl Bed {
    /// Of a checkpoint for a scene whose shapes, materials and boundaries are there; the error goes on behind the name of
    /// the file.
    pub fn read(bytes: &[u8], scene: &Scene) -> Result<Self, String> {
        let (state, from) = read(bytes).map_err(|error| error.to_string())?;
        let from = from.ok_or("has no scene in it: only what `sturz prepare` has written can start another scene")?;
        let from = from.description().map_err(|problem| format!("has a scene that cannot be read: {problem}"))?;
        check_domain(&from, scene.description())?;
        let to = scene.description();
        let shapes: Vec<Option<usize>> =
            from.shapes.iter().map(|shape| to.shapes.iter().position(|other| other == shape)).collect();
        let materials: Vec<Option<usize>> = from
            .materials
            .iter()
            .map(|material| to.materials.iter().position(|other| other.name == material.name))
            .collect();
        let mut particles = Vec::with_capacity(state.particles.len());
        for (k, row) in state.particles.iter().enumerate() {
            let names = |index: u32, all: &[String]| all.get(index as usize).cloned().unwrap_or_default();
            let shape = shapes.get(row.shape as usize).copied().flatten().ok_or_else(|| {
                let name = names(row.shape, &from.shapes.iter().map(|shape| shape.name.clone()).collect::<Vec<_>>());
                format!("has particles of the shape '{name}', which the scene does not have with the same geometry")
            })?;
            let material = materials.get(row.material as usize).copied().flatten();
            let density = material.and_then(|material| Some((material, to.materials[material].density_kg_per_m3?)));
            let (material, density) = density.ok_or_else(|| {
                let all = from.materials.iter().map(|material| material.name.clone()).collect::<Vec<_>>();
                format!(
                    "has particles of the material '{}', which the scene does not have with a density_kg_per_m3",
                    names(row.material, &all)
                )
            })?;
            let frozen = state.frozen.as_ref().is_some_and(|frozen| frozen.has(row.id));
            particles.push(particle(row, (k as u64, frozen), (shape, material, density), scene)?);
        }
        let (springs, history) = springs(&state, (&from, to), scene.boundaries());
        let time_s = state.clock.time_s();
        Ok(Self { particles, springs, from: from.scene.name, time_s, history })
    }

    /// In ascending order of id, from 0 on.
    pub fn particles(&self) -> &[NewParticle] {
        &self.particles
    }

    /// Of their contacts, sorted by key.
    pub fn springs(&self) -> &[SpringRecord] {
        &self.springs
    }

    /// What the scene starts with, for `sturz check`.
    pub fn line(&self, file: &str) -> String {
        let Self { particles, from, time_s, history, .. } = self;
        format!("start: {} particles of '{from}' at {time_s} s, from {file}; {history}", particles.len())
    }
}

fn read(bytes: &[u8]) -> Result<(State, Option<WrittenScene>), CheckpointError> {
    let mut sections = Sections::open(bytes)?;
    sections.section::<CheckpointSummary>(SUMMARY)?;
    let state = read_state(&mut sections)?;
    let scene = sections.optional(SCENE)?;
    sections.end()?;
    Ok((state, scene))
}

fn check_domain(from: &SceneDescription, to: &SceneDescription) -> Result<(), String> {
    let (a, b) = (&from.domain, &to.domain);
    let same = |axis: usize| {
        let ends = a.min_m[axis] == b.min_m[axis] && a.max_m[axis] == b.max_m[axis];
        a.periodic[axis] == b.periodic[axis] && (ends || !a.periodic[axis])
    };
    match (0..3).find(|&axis| !same(axis)) {
        Some(axis) => Err(format!(
            "is of a scene that is periodic along {:?} in [{:?}, {:?}]; this one is along {:?} in [{:?}, {:?}], and differs along {}",
            a.periodic,
            a.min_m,
            a.max_m,
            b.periodic,
            b.min_m,
            b.max_m,
            ["x", "y", "z"][axis]
        )),
        None if a.origin_m != b.origin_m => {
            Err(format!("is of a scene with origin_m = {:?}; this one has {:?}", a.origin_m, b.origin_m))
        }
        None => Ok(()),
    }
}

/// The same particle under another id, with the mass that the scene gives it.
fn particle(
    row: &Row,
    (id, frozen): (u64, bool),
    (shape, material, density): (usize, usize, f64),
    scene: &Scene,
) -> Result<NewParticle, String> {
    row.check_numbers().map_err(|problem| format!("holds a particle {} that {problem}", row.id))?;
    let body = &scene.shapes()[shape];
    let properties = body.mass_properties();
    let rotation = row.orientation.to_rotation_matrix().into_inner();
    let rate: Vec3 = rotation.tr_mul(&row.angular_momentum).component_div(&row.inertia);
    let mut position = row.position;
    scene.cell().wrap(&mut position);
    Ok(NewParticle {
        id,
        shape: shape as u32,
        material: material as u32,
        scale: row.scale,
        mass: density * properties.volume * row.scale.powi(3),
        inertia: properties.principal_inertia * (density * row.scale.powi(5)),
        radius: body.bounding_radius() * row.scale,
        position,
        orientation: row.orientation,
        velocity: row.velocity,
        angular_velocity: rotation * rate,
        frozen,
    })
}

/// Springs that mean the same in the new scene, under the new ids, and what to say of the others.
fn springs(
    state: &State,
    (from, to): (&SceneDescription, &SceneDescription),
    boundaries: &[Boundary],
) -> (Vec<SpringRecord>, String) {
    if from.contact != to.contact || from.material_pairs != to.material_pairs {
        let what = if from.contact != to.contact { "[contact]" } else { "[[material_pair]]" };
        return (Vec::new(), format!("contact history dropped: {what} differs"));
    }
    if to.relax.is_some() {
        return (Vec::new(), "contact history dropped: [relax] moves the particles".into());
    }
    let at_rest =
        |boundary: &BoundaryDescription| BoundaryDescription { motion: MotionDescription::Fixed, ..boundary.clone() };
    let walls = from.boundaries.len() == boundaries.len()
        && from.boundaries.iter().map(at_rest).eq(to.boundaries.iter().map(at_rest));
    let rank = |id: u64| state.particles.binary_search_by_key(&id, |row| row.id).ok().map(|rank| rank as u64);
    let renamed = |record: &SpringRecord| {
        let (a, b, part_a, part_b, feature) = record.key;
        let b = if b >= BOUNDARY { walls.then_some(b) } else { rank(b) };
        Some(SpringRecord { key: (rank(a)?, b?, part_a, part_b, feature), ..*record })
    };
    let springs = state.springs.iter().filter_map(renamed).collect();
    let history = if walls {
        "contact history kept"
    } else {
        "contact history kept, but for that at boundaries: [[boundary]] differs"
    };
    (springs, history.into())
}
