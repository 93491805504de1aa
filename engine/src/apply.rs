//! Commands: applied wholly between two steps, or refused without a trace.

use crate::command::{Command, Effect};
use crate::engine::Engine;
use crate::error::InvalidInput;
use crate::insertion::{self, Surroundings};
use crate::math::Vec3;
use crate::particles::NewParticle;
use crate::scene::{InsertionDescription, MotionDescription, check_motion};

impl Engine {
    /// Applies a command before the next step. An error names the part of the command that cannot be used, and the
    /// state is as it was.
    pub fn apply(&mut self, command: &Command) -> Result<Effect, InvalidInput> {
        match command {
            Command::Insert(description) => self.insert(description),
            Command::Remove(ids) => self.remove(ids),
            Command::SetGravity(gravity) => self.set_gravity(gravity),
            Command::SetMotion { boundary, motion } => self.set_motion(boundary, motion),
            Command::SetLoads(loads) => self.set_loads(loads).map(|()| Effect::LoadsSet),
            Command::SetFluid { fluid, fields } => {
                self.set_fluid(fluid.as_deref(), fields.as_deref()).map(|()| Effect::FluidSet)
            }
            Command::SetFluidFields(fields) => self.set_fluid_fields(fields.as_deref()).map(|()| Effect::FluidSet),
        }
    }

    fn insert(&mut self, description: &InsertionDescription) -> Result<Effect, InvalidInput> {
        let present = self.present();
        let surroundings = Surroundings {
            scene: &self.scene,
            boundaries: &self.boundaries,
            present: &present,
            first_id: self.next_id,
        };
        let new = insertion::place(description, &surroundings, "insert")?;
        self.scene.check_sizes(&new, "insert")?;
        let mut materials: Vec<usize> = present.iter().chain(&new).map(|p| p.material as usize).collect();
        materials.sort_unstable();
        materials.dedup();
        self.scene.check_pairs_among(&materials, "insert.material")?;
        self.written.check_time_step(self.clock.nominal_time_step_s(), &new, "insert")?;
        let effect = Effect::Inserted { first_id: self.next_id, count: new.len() as u64 };
        if !new.is_empty() {
            self.add_particles(&new);
        }
        Ok(effect)
    }

    /// Takes particles of the next ids in.
    pub(crate) fn add_particles(&mut self, new: &[NewParticle]) {
        self.change_particles(|engine| {
            engine.next_id += new.len() as u64;
            new.iter().for_each(|particle| engine.particles.push(particle));
        });
    }

    fn remove(&mut self, ids: &[u64]) -> Result<Effect, InvalidInput> {
        let mut wanted = ids.to_vec();
        wanted.sort_unstable();
        wanted.dedup();
        let keep: Vec<u32> = (0..self.particles.n_owned() as u32)
            .filter(|&row| wanted.binary_search(&self.particles.ids[row as usize]).is_err())
            .collect();
        let removed = self.particles.n_owned() - keep.len();
        if removed != wanted.len() {
            let present = |id: &u64| self.particles.ids.contains(id);
            let k = ids.iter().position(|id| !present(id)).unwrap_or(0);
            return Err(InvalidInput::new(format!("remove.ids[{k}]"), format!("particle {} does not exist", ids[k])));
        }
        if removed > 0 {
            self.change_particles(|engine| engine.particles.select(&keep));
        }
        Ok(Effect::Removed { count: removed as u64 })
    }

    /// Changes the owned rows, keeps the springs of pairs that stay, and books the energy that came or went.
    fn change_particles(&mut self, change: impl FnOnce(&mut Self) + Send) {
        self.change_state(change);
        self.topology_epoch += 1;
    }

    /// Changes rows or laws between two steps, keeps the springs of pairs that stay, and books the energy that came or went.
    pub(crate) fn change_state(&mut self, change: impl FnOnce(&mut Self) + Send) {
        let before = self.mechanical_energy().total();
        self.in_pool(|engine| {
            let springs = engine.contacts.springs(&engine.particles);
            engine.particles.drop_ghosts();
            change(engine);
            engine.contacts.clear();
            engine.kept_springs = if engine.scene.plan().keeps_springs() { springs } else { Vec::new() };
            engine.prepare();
        });
        self.ledger.work_commands += self.mechanical_energy().total() - before;
    }

    fn set_gravity(&mut self, gravity: &[f64; 3]) -> Result<Effect, InvalidInput> {
        if gravity.iter().any(|g| !g.is_finite()) {
            let problem = format!("is {gravity:?}; every component must be finite");
            return Err(InvalidInput::new("set_gravity.gravity_m_per_s2", problem));
        }
        let before = self.mechanical_energy().potential;
        self.gravity = Vec3::from(*gravity);
        if let Some(run) = &mut self.stages {
            run.gravity = self.gravity;
            self.take_laws_of_stage();
        }
        self.ledger.work_commands += self.mechanical_energy().potential - before;
        Ok(Effect::GravitySet)
    }

    fn set_motion(&mut self, name: &str, motion: &MotionDescription) -> Result<Effect, InvalidInput> {
        check_motion(motion, "set_motion.motion")?;
        if !self.boundaries.iter().any(|boundary| boundary.answers_to(name)) {
            let known: Vec<&str> = self.boundaries.iter().map(|boundary| boundary.name.as_str()).collect();
            let problem = format!("'{name}' is not a boundary; the scene has {known:?}");
            return Err(InvalidInput::new("set_motion.boundary", problem));
        }
        let several = self.boundaries.iter().filter(|boundary| boundary.answers_to(name)).count() > 1;
        if several && matches!(motion, MotionDescription::Servo { .. }) {
            let problem = format!("'{name}' is a box; a servo moves one of its sides, such as '{name}/z+'");
            return Err(InvalidInput::new("set_motion.boundary", problem));
        }
        let time_s = self.clock.time_s();
        for boundary in self.boundaries.iter_mut().filter(|boundary| boundary.answers_to(name)) {
            boundary.set_motion(motion.clone(), time_s);
        }
        // The bound on how far walls have come since the list was built holds for the old motion only.
        self.neighbours.invalidate();
        Ok(Effect::MotionSet)
    }

    /// Particles as the insertion sees them, in the order of ids.
    pub(crate) fn present(&self) -> Vec<NewParticle> {
        let particles = &self.particles;
        particles
            .rows_by_id()
            .into_iter()
            .map(|row| {
                let row = row as usize;
                NewParticle {
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
                    angular_velocity: particles.angular_velocity(row),
                    frozen: particles.is_frozen(row),
                }
            })
            .collect()
    }
}
