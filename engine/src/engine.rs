//! The owner of all state. Synchronous, deterministic, without I/O.

use std::sync::{Arc, OnceLock};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::boundary::{Boundary, WallSide};
use crate::broad::{NeighbourInputs, Neighbours};
use crate::clock::Clock;
use crate::contact::{self, ContactTable, FindInputs, ForceInputs, SpringRecord, Sums};
use crate::coupling::Fluid;
use crate::energy::Ledger;
use crate::error::{InvalidInput, StepError};
use crate::external::ExternalRows;
use crate::fields::Average;
use crate::gather::gather;
use crate::happening::Happening;
use crate::inflow::InflowRun;
use crate::integrate::{self, LocalDamping};
use crate::loads::Loads;
use crate::math::Vec3;
use crate::particles::{ContactMotion, Particles};
use crate::report::WarningCounts;
use crate::scene::{Scene, SharingScope};
use crate::stages::StageRun;
use crate::timing::{Stage, StageTimer};

/// A running simulation.
pub struct Engine {
    /// With the laws that hold now: those of the stage under way.
    pub(crate) scene: Arc<Scene>,
    /// As the user wrote it.
    pub(crate) written: Arc<Scene>,
    /// Where it is in its stages, where it has any.
    pub(crate) stages: Option<StageRun>,
    /// By inflow of the scene.
    pub(crate) inflows: Vec<InflowRun>,
    /// Not taken yet.
    pub(crate) happenings: Vec<Happening>,
    pub(crate) clock: Clock,
    pub(crate) gravity: Vec3,
    pub(crate) particles: Particles,
    pub(crate) boundaries: Vec<Boundary>,
    pub(crate) neighbours: Neighbours,
    pub(crate) contacts: ContactTable,
    pub(crate) sums: Sums,
    /// Springs that outlive a change of the particles, until the next rebuild takes them.
    pub(crate) kept_springs: Vec<SpringRecord>,
    pub(crate) ledger: Ledger,
    /// From outside, where there are any.
    pub(crate) loads: Option<Loads>,
    /// Around the particles, where there is one.
    pub(crate) fluid: Option<Fluid>,
    /// Rows that loads and fluid push.
    pub(crate) external: ExternalRows,
    /// Of loads and fluid, so far: what `external` is made anew after.
    pub(crate) external_changes: u64,
    /// Of the last evaluation, where the scene damps locally.
    pub(crate) local_damping: LocalDamping,
    /// Of frozen particles that move on the others, at the last evaluation, W.
    pub(crate) frozen_power: f64,
    /// Means over time that are being taken; of fields that nobody averages there are none.
    pub(crate) averages: Vec<Average>,
    pub(crate) warnings: WarningCounts,
    pub(crate) largest_ratio_so_far: f64,
    pub(crate) next_id: u64,
    pub(crate) topology_epoch: u64,
    pub(crate) failure: Option<StepError>,
    most_pairs: usize,
    /// Before step 0: polyhedra meet by points, whatever their law, which may end before they are apart.
    pub(crate) relaxing: bool,
    /// Of the scene, once a checkpoint has asked for it.
    pub(crate) layout: OnceLock<[u64; 8]>,
    pool: Arc<ThreadPool>,
    timer: Option<Box<dyn StageTimer>>,
}

/// Overlap over the smaller bounding radius that counts as large.
pub(crate) const LARGE_OVERLAP: f64 = 0.1;
/// Generalized overlap over the mean rounding radius that counts as deep, and at which the law ends.
pub(crate) const DEEP_ROUNDING: f64 = 1.5;
const END_OF_ROUNDING: f64 = 2.0;
/// Displacement in one step over the bounding radius that counts as fast.
pub(crate) const FAST: f64 = 0.1;
/// Path in one step over the smallest half-thickness above which a contact could be missed: two particles that both keep
/// to it are not past each other's middle when they are first seen.
const MOST_PER_STEP: f64 = 1.0;

fn pool(threads: usize) -> Arc<ThreadPool> {
    let pool = ThreadPoolBuilder::new().num_threads(threads.max(1)).thread_name(|k| format!("physics-{k}")).build();
    Arc::new(pool.expect("the operating system can start the physics threads"))
}

impl Engine {
    /// Starts the scene at step 0, on one thread, after its `[relax]`: if that fails, the first step says so.
    pub fn new(scene: Scene) -> Self {
        let mut engine = Self::blank(Arc::new(scene), pool(1));
        let scene = Arc::clone(&engine.scene);
        scene.particles().iter().for_each(|particle| engine.particles.push(particle));
        engine.next_id = scene.particles().len() as u64;
        engine.begin_stages();
        engine.failure = engine.in_pool(Self::relax).err();
        if let Some(bed) = scene.bed().filter(|_| engine.scene.plan().keeps_springs()) {
            engine.kept_springs = bed.springs().to_vec();
        }
        engine.in_pool(Self::prepare);
        engine.ledger.initial = engine.mechanical_energy().total();
        engine.set_averages(&scene.description().fields);
        engine
    }

    /// The scene at step 0 without its particles, and without forces.
    fn blank(scene: Arc<Scene>, pool: Arc<ThreadPool>) -> Self {
        Self {
            clock: Clock::new(scene.time_step_s()),
            gravity: Vec3::from(scene.description().scene.gravity_m_per_s2),
            next_id: 0,
            boundaries: scene.boundaries().to_vec(),
            particles: Particles::default(),
            neighbours: Neighbours::default(),
            contacts: ContactTable { keeps_bonds: scene.plan().bonds, ..ContactTable::default() },
            sums: Sums::default(),
            kept_springs: Vec::new(),
            ledger: Ledger::default(),
            loads: None,
            fluid: None,
            external: ExternalRows::default(),
            external_changes: 0,
            local_damping: LocalDamping::default(),
            frozen_power: 0.0,
            averages: Vec::new(),
            warnings: WarningCounts::default(),
            largest_ratio_so_far: 0.0,
            topology_epoch: 0,
            failure: None,
            most_pairs: usize::MAX,
            relaxing: false,
            layout: OnceLock::new(),
            pool,
            timer: None,
            stages: None,
            inflows: vec![InflowRun::default(); scene.description().inflows.len()],
            happenings: Vec::new(),
            written: Arc::clone(&scene),
            scene,
        }
    }

    /// The same scene at step 0, without particles and without a timer, on the same threads.
    pub(crate) fn blank_twin(&self) -> Self {
        Self {
            layout: self.layout.clone(),
            most_pairs: self.most_pairs,
            ..Self::blank(Arc::clone(&self.written), Arc::clone(&self.pool))
        }
    }

    /// Takes over all but the timer.
    pub(crate) fn become_twin(&mut self, twin: Self) {
        *self = Self { timer: self.timer.take(), ..twin };
    }

    /// Threads of the physics; the results do not depend on it.
    pub fn set_threads(&mut self, threads: usize) {
        self.pool = pool(threads);
    }

    /// Runs `f` on the physics threads. A loop of steps inside saves the hand-over to the pool of each.
    pub fn in_pool<R: Send>(&mut self, f: impl FnOnce(&mut Self) -> R + Send) -> R {
        let pool = Arc::clone(&self.pool);
        if pool.current_thread_index().is_some() { f(self) } else { pool.install(|| f(self)) }
    }

    /// From now on a step that would list more than `most` candidate pairs of parts fails, before they take memory.
    pub fn set_most_pairs(&mut self, most: usize) {
        self.most_pairs = most;
    }

    /// Who counts the cost of the stages.
    pub fn set_timer(&mut self, timer: Option<Box<dyn StageTimer>>) {
        self.timer = timer;
    }

    /// Does one step. After an error the state is that of the failing step, and every further step is refused.
    pub fn step(&mut self) -> Result<(), StepError> {
        if let Some(failure) = &self.failure {
            if matches!(failure, StepError::NotRelaxed { .. }) {
                return Err(failure.clone());
            }
            return Err(StepError::Stopped { step: self.clock.step(), reason: failure.to_string() });
        }
        if !self.inflows.is_empty() {
            self.feed_inflows();
        }
        let outcome = self.in_pool(|engine| {
            engine.step_stages()?;
            engine.sample_averages();
            Ok(())
        });
        self.failure = outcome.as_ref().err().cloned();
        if self.stages.is_some() && outcome.is_ok() {
            self.follow_stages();
        }
        outcome
    }

    /// Cuts `duration_s` into equal steps not longer than the scene's and returns their number; after as many calls
    /// of [`Engine::step`] the time is the present one plus `duration_s`, to the bit.
    pub fn begin_window(&mut self, duration_s: f64) -> Result<u64, InvalidInput> {
        self.clock.begin_window(duration_s)
    }

    /// Steps that a window of this length would be cut into.
    pub fn window_steps(&self, duration_s: f64) -> Result<u64, InvalidInput> {
        self.clock.window_steps(duration_s)
    }

    /// Back to the scene's time step, wherever the window has got to.
    pub fn end_window(&mut self) {
        self.clock.end_window();
    }

    /// Time and step.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The scene that was started, whatever stage it is in.
    #[expect(clippy::misnamed_getters, reason = "the field of this name has the laws of the stage under way")]
    pub fn scene(&self) -> &Scene {
        &self.written
    }

    /// Particles present.
    pub fn len(&self) -> usize {
        self.particles.n_owned()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Counts insertions and removals.
    pub fn topology_epoch(&self) -> u64 {
        self.topology_epoch
    }

    /// Makes the next step rebuild the neighbour list. The results do not depend on it; tests show that.
    pub fn expire_neighbours(&mut self) {
        self.neighbours.invalidate();
    }

    /// Makes the next step rebuild the neighbour list and test all pairs in full. The results do not depend on it.
    pub fn drop_caches(&mut self) {
        self.expire_neighbours();
        self.contacts.drop_caches();
    }

    /// Forces at the present state without a step: at the start, and after the particles have changed.
    pub(crate) fn prepare(&mut self) {
        self.neighbours.invalidate();
        self.predict_present_motion();
        self.wrap_into_cell();
        self.rebuild_neighbours_if_stale(self.clock.time_s());
        self.find_contacts();
        self.evaluate_with(0.0);
        self.gather_forces();
        self.frozen_power = self.present_frozen_power();
        self.damp_locally(0.0);
        self.sums = self.contacts.sums();
        self.ledger.restart(&self.sums);
    }

    /// Velocities that the contact laws see, where there was no step before.
    pub(crate) fn predict_present_motion(&mut self) {
        for row in 0..self.particles.n_owned() {
            let velocity = self.particles.velocity[row];
            let angular_velocity = self.particles.angular_velocity(row);
            self.particles.motion[row] = ContactMotion {
                velocity,
                angular_velocity,
                mean_velocity: velocity,
                mean_angular_velocity: angular_velocity,
            };
        }
    }

    pub(crate) fn begin_timing(&mut self) {
        if let Some(timer) = &mut self.timer {
            timer.begin();
        }
    }

    pub(crate) fn lap(&mut self, stage: Stage) {
        if let Some(timer) = &mut self.timer {
            timer.lap(stage);
        }
    }

    pub(crate) fn half_kick_and_drift(&mut self) {
        let dt = self.clock.time_step_s();
        let rotation = self.scene.description().integrator.rotation;
        let plan = self.scene.plan();
        let shapes = (rotation, &plan.rotates[..], &plan.half_thickness[..]);
        let report = integrate::drift(&mut self.particles, &self.gravity, dt, shapes);
        self.warnings.rotation_not_converged += report.not_converged;
        self.warnings.fast_particle += u64::from(report.largest_displacement_squared > FAST * FAST);
        // rows may be sorted anew before the guard sees them
        self.failure = report.too_fast.filter(|_| self.may_collide()).map(|(row, ratio)| self.too_fast(row, ratio));
    }

    pub(crate) fn wrap_into_cell(&mut self) {
        if self.scene.cell().is_periodic() {
            self.scene.cell().wrap_all(&mut self.particles);
        }
    }

    /// Boundaries go to the end of the step.
    pub(crate) fn move_boundaries(&mut self) {
        let time_s = self.clock.time_after_s(1);
        self.boundaries.iter_mut().for_each(|boundary| boundary.move_to(time_s));
    }

    pub(crate) fn rebuild_neighbours_if_stale(&mut self, time_s: f64) {
        let scene = Arc::clone(&self.scene);
        let inputs = NeighbourInputs {
            shapes: scene.shapes(),
            reaches: &scene.plan().reaches,
            boundaries: &self.boundaries,
            rounded: scene.rounded().is_some() && !self.relaxing,
            sphere_batch: scene.plan().sphere_batch,
            cell: scene.cell(),
            skin_fraction: scene.plan().skin_fraction,
            most_pairs: self.most_pairs,
            bonds: scene.point_laws().filter(|_| scene.plan().bonds),
            time_s,
        };
        let Self { particles, contacts, neighbours, .. } = self;
        if !neighbours.is_stale(particles, &inputs) {
            // The sphere batch reads images by place only.
            if !(scene.plan().all_spheres && scene.plan().sphere_batch) {
                particles.update_ghosts();
            }
            return particles.update_places(!contacts.spheres.is_empty());
        }
        let kept = std::mem::take(&mut self.kept_springs);
        let springs = match (scene.plan().history || scene.plan().rolling || scene.plan().bonds) && kept.is_empty() {
            true => contacts.slot_springs(particles),
            false => Vec::new(),
        };
        contacts.spheres.keep(particles);
        contacts.take_caches(particles);
        if !neighbours.rebuild(particles, &inputs, &mut contacts.slots) {
            // the guard ends the run with it; until then there are no contacts
            self.failure.get_or_insert(StepError::TooManyPairs { most: self.most_pairs, step: self.clock.step() });
        }
        contacts.reset();
        contacts.give_caches(particles);
        contacts.restore_springs(if kept.is_empty() { &springs } else { &kept }, particles);
        contacts.spheres.rebuild(neighbours.sphere_pairs(), particles, scene.pairs(), neighbours.order());
        contacts.restore_sphere_springs(&kept, particles);
        particles.update_places(!contacts.spheres.is_empty());
    }

    pub(crate) fn find_contacts(&mut self) {
        let inputs = FindInputs {
            particles: &self.particles,
            shapes: self.scene.shapes(),
            reaches: &self.scene.plan().reaches,
            boundaries: &self.boundaries,
            rounded: self.scene.rounded().filter(|_| !self.relaxing),
            sharing: self.scene.description().contact.sharing,
            history: self.scene.plan().history,
            bonds: self.scene.point_laws().filter(|_| self.scene.plan().bonds),
        };
        contact::find_contacts(&mut self.contacts, &inputs);
        let section = &self.scene.description().contact;
        if section.sharing_scope == SharingScope::Bodies {
            contact::share_over_bodies(&mut self.contacts, section.sharing);
        }
    }

    pub(crate) fn evaluate_forces(&mut self) {
        self.evaluate_with(self.clock.time_step_s());
        self.sums = self.contacts.sums();
        self.ledger.add(&self.sums, self.clock.time_step_s());
    }

    pub(crate) fn evaluate_with(&mut self, stretch_time_s: f64) {
        let section = &self.scene.description().contact;
        let inputs = ForceInputs {
            particles: &self.particles,
            boundaries: &self.boundaries,
            pairs: self.scene.pairs(),
            contact_end: section.contact_end,
            tangential: section.tangential,
            point_laws: self.scene.point_laws(),
            rounded: self.scene.rounded().filter(|_| !self.relaxing),
            stretch_time_s,
        };
        contact::evaluate_forces(&mut self.contacts, &inputs);
    }

    pub(crate) fn gather_forces(&mut self) {
        gather(&mut self.particles, &self.contacts, &self.neighbours);
    }

    /// Of frozen particles on the others, W: they take part like boundaries.
    fn present_frozen_power(&self) -> f64 {
        let particles = &self.particles;
        let frozen = particles.frozen.iter().take(particles.n_owned()).enumerate().filter(|(_, frozen)| **frozen);
        frozen.map(|(row, _)| -particles.force[row].dot(&particles.velocity[row])).sum()
    }

    /// Books the work of frozen particles that move, where the scene has any.
    pub(crate) fn book_frozen_work(&mut self) {
        if self.particles.frozen.is_empty() {
            return;
        }
        let power = self.present_frozen_power();
        self.ledger.work_boundaries += 0.5 * self.clock.time_step_s() * (self.frozen_power + power);
        self.frozen_power = power;
    }

    /// Adds local damping to the gathered forces, where the scene has it, and books what it took over a time.
    pub(crate) fn damp_locally(&mut self, time_s: f64) {
        let alpha = self.scene.description().integrator.local_damping;
        if alpha > 0.0 {
            let before = self.local_damping.power;
            self.local_damping = integrate::damp_locally(&mut self.particles, &self.gravity, alpha);
            self.ledger.dissipated_local += 0.5 * time_s * (before + self.local_damping.power);
        }
    }

    pub(crate) fn half_kick(&mut self) {
        let dt = self.clock.time_step_s();
        if let Some(row) = integrate::kick(&mut self.particles, &self.gravity, dt) {
            self.failure = Some(self.non_finite(row));
        }
    }

    pub(crate) fn advance_clock(&mut self) {
        self.clock.advance();
    }

    /// Whether there is anything that a particle could pass through.
    fn may_collide(&self) -> bool {
        self.particles.n_owned() > 1 || !self.boundaries.is_empty()
    }

    fn too_fast(&self, row: usize, ratio: f64) -> StepError {
        StepError::TooFast { id: self.particles.ids[row], ratio, limit: MOST_PER_STEP, step: self.clock.step() + 1 }
    }

    fn non_finite(&self, row: usize) -> StepError {
        let particles = &self.particles;
        let broken = |v: &Vec3| !v.iter().all(|c| c.is_finite());
        let quantity = if broken(&particles.position[row]) {
            "position"
        } else if broken(&particles.velocity[row]) {
            "velocity"
        } else {
            "angular momentum"
        };
        StepError::NonFinite { id: particles.ids[row], quantity, step: self.clock.step() + 1 }
    }

    /// Non-finite numbers, tunnelling and excessive overlap end the run; lesser troubles are counted.
    pub(crate) fn guard(&mut self) -> Result<(), StepError> {
        if let Some(failure) = self.failure.take() {
            return Err(failure);
        }
        let ratio = self.sums.largest_ratio;
        self.largest_ratio_so_far = self.largest_ratio_so_far.max(ratio);
        self.warnings.large_overlap += u64::from(ratio > LARGE_OVERLAP);
        let limit = self.scene.description().contact.overlap_limit;
        let step = self.clock.step();
        if ratio > limit {
            let (a, b) = self.sides(self.sums.largest_slot);
            return Err(StepError::ExcessiveOverlap { a, b, ratio, limit, step });
        }
        let ratio = self.sums.largest_rounding;
        self.warnings.deep_rounding += u64::from(ratio > DEEP_ROUNDING);
        if ratio >= END_OF_ROUNDING {
            let (a, b) = self.sides(self.sums.rounding_slot);
            return Err(StepError::BeyondRounding { a, b, ratio, limit: END_OF_ROUNDING, step });
        }
        Ok(())
    }

    /// The two sides of a slot, for errors.
    pub(crate) fn sides(&self, slot: u32) -> (u64, String) {
        let particles = &self.particles;
        let slots = &self.contacts.slots;
        if slot as usize >= slots.len() {
            let pair = self.contacts.spheres.pair(slot as usize - slots.len());
            let [a, b] = pair.ids(particles);
            return (a, format!("particle {b}"));
        }
        let slot = slots[slot as usize];
        let b = if slot.kind.is_wall() {
            format!("boundary \"{}\"", WallSide::of(&self.boundaries, slot.b).boundary.name)
        } else {
            format!("particle {}", particles.ids[particles.owner(slot.b as usize)])
        };
        (particles.ids[particles.owner(slot.a as usize)], b)
    }
}
