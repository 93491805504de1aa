//! What decides the future of a run, apart from its scene, as plain records keyed by ids.
//!
//! Left out is what a rebuild of the neighbour list gives anew without a trace in the bits: the order of rows, images,
//! the list itself, what the narrow phase has learned, and odometers. Random numbers have no state: they are functions
//! of (seed, id, purpose).

use super::codec::{Malformed, Pack, Reader, pack_fields};
use super::error::CheckpointError;
use super::layout::{course_layout, course_layout_of_none};
use crate::boundary::{Boundary, BoundaryMotion};
use crate::clock::Clock;
use crate::contact::{SavedSlot, SavedSphere, SpringRecord, Sums, Wrench};
use crate::coupling::Fluid;
use crate::energy::Ledger;
use crate::engine::Engine;
use crate::error::InvalidInput;
use crate::fields::{Average, SavedAverage};
use crate::inflow::InflowRun;
use crate::integrate::LocalDamping;
use crate::loads::Loads;
use crate::math::{Mat3, Quat, Vec3};
use crate::narrow::FeatureKey;
use crate::particles::{NewParticle, Particles};
use crate::report::WarningCounts;
use crate::scene::{Scene, check_motion};
use crate::stages::StageRun;

/// All of it.
pub(super) struct State {
    pub clock: Clock,
    pub totals: Totals,
    /// In the order of the scene.
    pub boundaries: Vec<BoundaryMotion>,
    /// In ascending order of id.
    pub particles: Vec<Row>,
    /// Sorted by key.
    pub springs: Vec<SpringRecord>,
    pub touching: Touching,
    pub loads: Option<Loads>,
    /// `None` where nobody is.
    pub frozen: Option<Frozen>,
    /// `None` where the scene has neither stages nor inflows.
    pub course: Option<Course>,
    /// Means over time that are being taken.
    pub averages: Vec<SavedAverage>,
    pub fluid: Option<Fluid>,
}

/// What the scene has done of its own accord.
pub(super) struct Course {
    /// Of the sections of the scene.
    layout: [u64; 2],
    pub stages: Option<StageRun>,
    pub inflows: Vec<InflowRun>,
}

/// Who keeps its velocity, and what they do to the others.
pub(super) struct Frozen {
    /// Ascending.
    ids: Vec<u64>,
    /// W
    pub power: f64,
}

/// Single numbers.
pub(super) struct Totals {
    pub gravity: Vec3,
    pub next_id: u64,
    pub topology_epoch: u64,
    pub ledger: Ledger,
    pub sums: Sums,
    pub local_damping: LocalDamping,
    pub warnings: WarningCounts,
    pub largest_ratio_so_far: f64,
    pub rebuilds: u64,
}

/// One particle. The force at the present step is kept and not computed anew: it was found with velocities predicted in
/// the step before, which are gone.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub id: u64,
    pub shape: u32,
    pub material: u32,
    pub scale: f64,
    pub mass: f64,
    pub inertia: Vec3,
    pub radius: f64,
    pub position: Vec3,
    pub orientation: Quat,
    pub velocity: Vec3,
    pub angular_momentum: Vec3,
    pub force: Vec3,
    pub torque: Vec3,
    pub image: [i32; 3],
}

/// What contacts do now: the next step of a servo reads it, and so do reports before that.
pub(super) struct Touching {
    /// Sorted by key.
    pub slots: Vec<SavedSlot>,
    /// Sorted by key.
    pub spheres: Vec<SavedSphere>,
}

pack_fields!(Totals {
    gravity: Vec3,
    next_id: u64,
    topology_epoch: u64,
    ledger: Ledger,
    sums: Sums,
    local_damping: LocalDamping,
    warnings: WarningCounts,
    largest_ratio_so_far: f64,
    rebuilds: u64,
});
pack_fields!(Row {
    id: u64,
    shape: u32,
    material: u32,
    scale: f64,
    mass: f64,
    inertia: Vec3,
    radius: f64,
    position: Vec3,
    orientation: Quat,
    velocity: Vec3,
    angular_momentum: Vec3,
    force: Vec3,
    torque: Vec3,
    image: [i32; 3],
});
pack_fields!(Course { layout: [u64; 2], stages: Option<StageRun>, inflows: Vec<InflowRun> });
pack_fields!(Frozen { ids: Vec<u64>, power: f64 });
pack_fields!(Touching { slots: Vec<SavedSlot>, spheres: Vec<SavedSphere> });
pack_fields!(SavedSlot { ids: [u64; 2], parts: [u16; 2], wrench: Wrench });
pack_fields!(SavedSphere { ids: [u64; 2], force: Vec3, torque: Vec3 });
pack_fields!(Wrench { force: Vec3, torque_a: Vec3, torque_b: Vec3, points: u32 });
pack_fields!(LocalDamping { power: f64, force: Vec3 });
pack_fields!(WarningCounts { rotation_not_converged: u64, large_overlap: u64, deep_rounding: u64, fast_particle: u64 });
pack_fields!(Sums {
    elastic_normal: f64,
    elastic_tangential: f64,
    power_normal: f64,
    power_tangential: f64,
    power_boundaries: f64,
    lost_bonds: f64,
    largest_overlap: f64,
    largest_ratio: f64,
    largest_slot: u32,
    largest_rounding: f64,
    rounding_slot: u32,
    points_by_kind: [u64; 3],
});

impl Pack for SpringRecord {
    const LEAST_BYTES: usize = 48;
    fn put(&self, out: &mut Vec<u8>) {
        let (a, b, part_a, part_b, feature) = self.key;
        [a, b].put(out);
        [part_a, part_b].put(out);
        feature.0.put(out);
        self.spring.put(out);
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        let ([a, b], [part_a, part_b]) = (from.get()?, from.get()?);
        Ok(Self { key: (a, b, part_a, part_b, FeatureKey(from.get()?)), spring: from.get()? })
    }
}

impl State {
    /// Of an engine between two steps.
    pub fn of(engine: &Engine) -> Self {
        debug_assert!(engine.kept_springs.is_empty(), "the rebuild after a change of the particles has taken them");
        let particles = &engine.particles;
        // slots are numbered by rows, which a restored engine has in another order
        let sums = Sums { largest_slot: 0, rounding_slot: 0, ..engine.sums };
        Self {
            clock: engine.clock,
            totals: Totals {
                gravity: engine.gravity,
                next_id: engine.next_id,
                topology_epoch: engine.topology_epoch,
                ledger: engine.ledger,
                sums,
                local_damping: engine.local_damping,
                warnings: engine.warnings,
                largest_ratio_so_far: engine.largest_ratio_so_far,
                rebuilds: engine.neighbours.rebuilds,
            },
            boundaries: engine.boundaries.iter().map(Boundary::present_motion).collect(),
            particles: particles.rows_by_id().into_iter().map(|row| Row::of(particles, row as usize)).collect(),
            springs: engine.contacts.springs(particles),
            touching: Touching {
                slots: engine.contacts.saved_slots(particles),
                spheres: engine.contacts.spheres.saved(particles),
            },
            loads: engine.loads.clone(),
            frozen: Frozen::of(engine),
            course: Course::of(engine),
            averages: engine.averages.iter().map(Average::saved).collect(),
            fluid: engine.fluid.as_ref().map(Fluid::saved),
        }
    }

    /// Whether an engine of this scene may have it. What passes cannot make the engine panic.
    pub fn check(&self, scene: &Scene) -> Result<(), CheckpointError> {
        self.clock.check(scene.time_step_s())?;
        self.check_boundaries(scene)?;
        self.loads.as_ref().map_or(Ok(()), Loads::check)?;
        self.fluid.as_ref().map_or(Ok(()), |fluid| fluid.check(scene.shapes().len()))?;
        Course::check(self.course.as_ref(), scene, self.clock.step())?;
        let mut last = None;
        for (k, row) in self.particles.iter().enumerate() {
            let problem = |problem: &str| InvalidInput::new(format!("particles[{k}]"), problem);
            if row.id >= self.totals.next_id || last.replace(row.id).is_some_and(|last| last >= row.id) {
                return Err(problem("has an id that is not above the one before and below the next new one").into());
            }
            row.check(scene).map_err(problem)?;
        }
        if let Some(frozen) = &self.frozen {
            frozen.check(&self.particles)?;
        }
        if self.totals.next_id > 1 << 63 {
            return Err(InvalidInput::new("next_id", "is above the largest id of a particle").into());
        }
        let new: Vec<NewParticle> = self.particles.iter().map(|row| row.new_particle(false)).collect();
        scene.check_sizes(&new, "particles")?;
        let mut materials: Vec<usize> = new.iter().map(|particle| particle.material as usize).collect();
        materials.sort_unstable();
        materials.dedup();
        scene.check_pairs_among(&materials, "particles")?;
        Ok(())
    }

    fn check_boundaries(&self, scene: &Scene) -> Result<(), InvalidInput> {
        let (found, wanted) = (self.boundaries.len(), scene.boundaries().len());
        if found != wanted {
            return Err(InvalidInput::new("boundaries", format!("are {found}, the scene has {wanted}")));
        }
        for (k, boundary) in self.boundaries.iter().enumerate() {
            check_motion(boundary.description(), &format!("boundaries[{k}].motion"))?;
            boundary.check().map_err(|problem| InvalidInput::new(format!("boundaries[{k}]"), problem))?;
        }
        Ok(())
    }
}

impl Row {
    fn of(particles: &Particles, row: usize) -> Self {
        Self {
            id: particles.ids[row],
            shape: particles.shape[row],
            material: particles.material[row],
            scale: particles.scale[row],
            mass: particles.mass[row],
            inertia: particles.inertia[row],
            radius: particles.radius[row],
            position: particles.position[row],
            orientation: particles.orientation[row],
            velocity: particles.velocity[row],
            angular_momentum: particles.angular_momentum[row],
            force: particles.force[row],
            torque: particles.torque[row],
            image: particles.image[row],
        }
    }

    fn check(&self, scene: &Scene) -> Result<(), &'static str> {
        if self.shape as usize >= scene.shapes().len() {
            Err("has a shape that the scene does not have")
        } else if self.material as usize >= scene.description().materials.len() {
            Err("has a material that the scene does not have")
        } else if scene.cell().wrap(&mut self.position.clone()) != [0; 3] {
            Err("is outside of the periodic cell")
        } else {
            self.check_numbers()
        }
    }

    /// Whether its numbers are those of a particle.
    pub fn check_numbers(&self) -> Result<(), &'static str> {
        let finite = |vectors: &[&Vec3]| vectors.iter().all(|v| v.iter().all(|x| x.is_finite()));
        let positive = |numbers: &[f64]| numbers.iter().all(|&x| x.is_finite() && x > 0.0);
        if !positive(&[self.scale, self.mass, self.radius]) || !positive(self.inertia.as_slice()) {
            Err("has a scale, mass, radius or moment of inertia that is not finite and above 0")
        } else if !finite(&[&self.position, &self.velocity, &self.angular_momentum, &self.force, &self.torque]) {
            Err("has a number that is not finite")
        } else if (self.orientation.coords.norm() - 1.0).abs().partial_cmp(&1e-6) != Some(std::cmp::Ordering::Less) {
            Err("has an orientation that is no unit quaternion")
        } else {
            Ok(())
        }
    }

    fn new_particle(&self, frozen: bool) -> NewParticle {
        NewParticle {
            id: self.id,
            shape: self.shape,
            material: self.material,
            scale: self.scale,
            mass: self.mass,
            inertia: self.inertia,
            radius: self.radius,
            position: self.position,
            orientation: self.orientation,
            velocity: self.velocity,
            angular_velocity: Vec3::zeros(),
            frozen,
        }
    }

    /// Appends it as an owned row.
    pub fn push(&self, particles: &mut Particles, frozen: Option<&Frozen>) {
        let is_frozen = frozen.is_some_and(|frozen| frozen.has(self.id));
        particles.push(&self.new_particle(is_frozen));
        let row = particles.n_owned() - 1;
        particles.angular_momentum[row] = self.angular_momentum;
        particles.force[row] = self.force;
        particles.torque[row] = self.torque;
        particles.image[row] = self.image;
    }
}

impl Course {
    fn of(engine: &Engine) -> Option<Self> {
        let layout = course_layout(engine.scene().description());
        (engine.stages.is_some() || !engine.inflows.is_empty()).then(|| Self {
            layout,
            stages: engine.stages,
            inflows: engine.inflows.clone(),
        })
    }

    /// Of a state at `step`, for an engine of the scene.
    fn check(course: Option<&Self>, scene: &Scene, step: u64) -> Result<(), CheckpointError> {
        let wanted = course_layout(scene.description());
        let found = course.map_or(course_layout_of_none(), |course| course.layout);
        let differing: Vec<&'static str> = ["stage", "inflow"]
            .into_iter()
            .zip(0..)
            .filter(|&(_, k)| found[k] != wanted[k])
            .map(|(name, _)| name)
            .collect();
        if !differing.is_empty() {
            return Err(CheckpointError::OtherScene { differing });
        }
        let Some(Self { stages, inflows, .. }) = course else { return Ok(()) };
        let (has_stages, wanted) = (!scene.stages().is_empty(), scene.description().inflows.len());
        if stages.is_some() != has_stages || inflows.len() != wanted {
            return Err(InvalidInput::new("stage", "and inflow are not those of the scene").into());
        }
        stages.map_or(Ok(()), |run| run.check(scene.stages().len(), step))?;
        inflows.iter().try_for_each(InflowRun::check)?;
        Ok(())
    }
}

impl Frozen {
    /// Whether a particle is.
    pub fn has(&self, id: u64) -> bool {
        self.ids.binary_search(&id).is_ok()
    }

    fn of(engine: &Engine) -> Option<Self> {
        let particles = &engine.particles;
        if particles.frozen.is_empty() {
            return None;
        }
        let rows = particles.rows_by_id().into_iter().map(|row| row as usize);
        let ids = rows.filter(|&row| particles.frozen[row]).map(|row| particles.ids[row]).collect();
        Some(Self { ids, power: engine.frozen_power })
    }

    fn check(&self, particles: &[Row]) -> Result<(), InvalidInput> {
        let problem = |problem: &str| Err(InvalidInput::new("frozen", problem));
        if self.ids.is_empty() || !self.ids.is_sorted_by(|a, b| a < b) || !self.power.is_finite() {
            return problem("is no list of ascending ids with a power");
        }
        let all_there = self.ids.iter().all(|id| particles.binary_search_by_key(id, |row| row.id).is_ok());
        if all_there { Ok(()) } else { problem("names a particle that does not exist") }
    }
}

impl BoundaryMotion {
    /// What is wrong with it, apart from its description.
    fn check(&self) -> Result<(), &'static str> {
        if !self.is_finite() {
            return Err("has a number that is not finite");
        }
        let off = (self.rotation.tr_mul(&self.rotation) - Mat3::identity()).abs().max();
        if off < 1e-6 { Ok(()) } else { Err("has a frame that is no rotation") }
    }
}
