//! What each order does, on the physics thread, between two steps.

use sturz_engine::scene::{AngularVelocity, InsertionDescription, MotionDescription, Placement, Region, Scene};
use sturz_engine::{Command, FluidDescription, FluidFields, InvalidInput, LoadDescription, MeshDescription};
use sturz_protocol::keys::Verb;
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::advance::{Window, check_start};
use crate::events::particles_event;
use crate::mailbox::{Answer, ReplyTo};
use crate::memory::Admission;
use crate::order::{Body, Order, Outputs, RequestKey, error, invalid};
use crate::runner::{Phase, Runner};
use crate::ticket::{Ticket, effect_to_wire, outcome};

impl Runner<'_> {
    /// Takes a new order on, or answers a repeated one from memory.
    pub fn receive(&mut self, order: Order, reply: ReplyTo) {
        match self.memory.admit(&order.key, order.fingerprint, reply) {
            Admission::New(reply) => {
                let ticket = Ticket::new(&order, reply, self.moment().step);
                if let Some(error) = self.check_held(order.verb) {
                    return self.put_off(ticket, error);
                }
                match self.check_lease(&order.key, order.verb) {
                    Ok(()) => self.begin(order, ticket),
                    Err(error) => self.refuse(ticket, error),
                }
            }
            Admission::Waits => {}
            Admission::Known(outcome, reply) => self.repeat(&order, *outcome, reply),
            Admission::Reused(reply) => {
                let text = "this request id was used for another request: every request needs its own";
                let error = error(v1::ErrorCode::RequestIdReused, "header.request_id", text);
                self.refuse_unremembered(&order.key, order.verb, error, reply);
            }
        }
    }

    fn refuse_unremembered(&self, key: &RequestKey, verb: Verb, error: v1::Error, reply: ReplyTo) {
        let outcome = outcome(key, verb, self.moment(), Wire::Error(error));
        drop(reply.send(Answer { outcome, capture: None }));
    }

    /// The same outcome again; its data only while the state is still the one that it led to.
    fn repeat(&mut self, order: &Order, mut outcome: v1::Outcome, reply: ReplyTo) {
        outcome.repeated = true;
        let is_there = self.last_window.as_ref() == Some(&order.key);
        let capture = match (&order.body, &outcome.result) {
            (Body::Advance { outputs, .. }, Some(Wire::Advanced(advanced)))
                if is_there && advanced.step == self.moment().step =>
            {
                self.capture(outputs)
            }
            _ => None,
        };
        // Behind the record that it is the answer to.
        let step = self.moment().step;
        self.journal.post(step, None, vec![(reply, Answer { outcome, capture })]);
    }

    fn begin(&mut self, order: Order, mut ticket: Ticket) {
        let now_s = self.moment().time_s;
        match order.at_time_s {
            Some(time) if time < now_s => {
                let text = format!("is {time:?} s, but the simulation is at {now_s:?} s already");
                self.refuse(ticket, error(v1::ErrorCode::WrongTime, "header.at_time_s", text));
            }
            Some(time) if time > now_s => {
                if self.schedule.len() >= self.limits.open_requests {
                    let waiting = self.schedule.len();
                    let text = format!("{waiting} commands wait for their time already (limit `open_requests`)");
                    self.refuse(ticket, error(v1::ErrorCode::Busy, "header.at_time_s", text));
                } else {
                    self.accept(&mut ticket);
                    self.schedule.add(time, order, ticket);
                }
            }
            Some(_) | None => self.execute(order.body, ticket),
        }
    }

    /// Does what the order asks for, and settles it, unless it is work of many steps.
    pub(crate) fn execute(&mut self, body: Body, ticket: Ticket) {
        let done = match body {
            Body::Change(command) => self.change(&command),
            Body::Pause => self.pause(),
            Body::Resume => self.resume(),
            Body::DefineField(definition) => self.define_field(definition),
            Body::DropField { name } => self.drop_field(&name),
            Body::DefineOutput(output) => self.define_output(output),
            Body::Checkpoint { token, on_disk } => return self.checkpoint(token, on_disk, ticket),
            Body::Restore { token } => self.restore(&token),
            Body::ListCheckpoints => Ok(self.list_checkpoints()),
            Body::DropCheckpoint { token } => self.drop_checkpoint(&token),
            Body::AcquireLease { client } => self.acquire_lease(&client),
            Body::ReleaseLease { client } => self.release_lease(&client),
            Body::Stop => {
                self.phase = Phase::Ended;
                Ok(Wire::Applied(v1::Applied {}))
            }
            Body::Step { steps } => return self.begin_steps(steps, ticket),
            Body::Advance { start, window_s, outputs, loads, fluid } => {
                let ready = self.check_ready().and_then(|()| check_start(start, self.moment()));
                let ready = ready.and_then(|()| self.check_fields(&outputs));
                return match ready.and_then(|()| self.load_window(window_s, loads, fluid)) {
                    Ok(()) => self.begin_window(window_s, outputs, ticket),
                    Err(error) => self.refuse(ticket, error),
                };
            }
        };
        match done {
            Ok(result) => {
                let moment = self.moment();
                self.settle(ticket, moment, result, None);
            }
            Err(error) => self.refuse(ticket, error),
        }
    }

    fn change(&mut self, command: &Command) -> Result<Wire, v1::Error> {
        if let Command::Insert(insertion) = command {
            self.check_room(insertion)?;
        }
        let effect = self.engine.apply(command).map_err(|input| refused(command, input))?;
        self.revision += 1;
        if let Some(event) = particles_event(command, &effect) {
            self.announce_event(event);
        }
        Ok(effect_to_wire(&effect))
    }

    /// Refuses an insertion that would exceed the limits, before the engine makes room for it.
    fn check_room(&self, insertion: &InsertionDescription) -> Result<(), v1::Error> {
        let count = expected_count(self.engine.scene(), insertion);
        if count > self.limits.insertion_particles {
            let most = self.limits.insertion_particles;
            let text = format!("about {count} particles, at most {most} per command (limit `insertion_particles`)");
            return Err(error(v1::ErrorCode::TooLarge, "placement", text));
        }
        let present = self.engine.len() as u64;
        if present + count > self.limits.particles {
            let most = self.limits.particles;
            let text =
                format!("{count} more than the {present} present; at most {most} are allowed (limit `particles`)");
            return Err(error(v1::ErrorCode::TooLarge, "placement", text));
        }
        Ok(())
    }

    fn pause(&mut self) -> Result<Wire, v1::Error> {
        self.finish_window(v1::StopReason::Paused);
        if self.phase == Phase::Running {
            self.set_phase(Phase::Paused, "the simulation is paused");
        }
        Ok(Wire::Applied(v1::Applied {}))
    }

    fn resume(&mut self) -> Result<Wire, v1::Error> {
        self.check_can_step()?;
        self.set_phase(Phase::Running, "the simulation goes on");
        Ok(Wire::Applied(v1::Applied {}))
    }

    /// Refuses where the run has failed or another client's window is under way.
    fn check_can_step(&self) -> Result<(), v1::Error> {
        if let Phase::Failed(reason) = &self.phase {
            return Err(error(v1::ErrorCode::RunFailed, "", reason.clone()));
        }
        self.check_no_window()
    }

    /// Refuses where another client's window is under way.
    pub(crate) fn check_no_window(&self) -> Result<(), v1::Error> {
        if let Some(window) = &self.window {
            let text = format!(
                "another {} is under way: {} of {} steps are done",
                window.ticket.verb().name(),
                window.steps_done,
                window.steps_total
            );
            return Err(error(v1::ErrorCode::WindowInFlight, "", text));
        }
        Ok(())
    }

    fn check_ready(&self) -> Result<(), v1::Error> {
        self.check_can_step()?;
        if self.phase == Phase::Running {
            let text = "the simulation is running: pause it first";
            return Err(error(v1::ErrorCode::NotPaused, "", text));
        }
        Ok(())
    }

    fn check_fields(&self, outputs: &Outputs) -> Result<(), v1::Error> {
        match outputs.fields.iter().position(|name| self.outbox.field(name).is_none()) {
            Some(at) => {
                let text = format!("no field {:?} is defined", outputs.fields[at]);
                Err(error(v1::ErrorCode::NotFound, &format!("outputs.fields[{at}]"), text))
            }
            None => Ok(()),
        }
    }

    fn begin_steps(&mut self, steps: u64, mut ticket: Ticket) {
        if let Err(error) = self.check_ready() {
            return self.refuse(ticket, error);
        }
        let to_time_s = self.engine.clock().time_after_s(steps);
        self.accept(&mut ticket);
        self.set_window(Window {
            ticket,
            outputs: None,
            begun: self.moment(),
            to_time_s,
            steps_total: steps,
            steps_done: 0,
        });
    }

    fn begin_window(&mut self, window_s: f64, outputs: Outputs, mut ticket: Ticket) {
        let begun = self.moment();
        match self.engine.begin_window(window_s) {
            Ok(steps_total) => {
                self.accept(&mut ticket);
                self.set_window(Window {
                    ticket,
                    outputs: Some(outputs),
                    begun,
                    to_time_s: begun.time_s + window_s,
                    steps_total,
                    steps_done: 0,
                });
            }
            Err(input) => self.refuse(ticket, invalid(input)),
        }
    }

    /// Sets loads and fluid of a window that is sure to begin.
    fn load_window(
        &mut self,
        window_s: f64,
        loads: Option<Box<LoadDescription>>,
        fluid: Option<Box<FluidFields>>,
    ) -> Result<(), v1::Error> {
        self.engine.window_steps(window_s).map_err(invalid)?;
        self.engine
            .check_fluid_fields(fluid.as_deref())
            .map_err(|input| refused(&Command::SetFluidFields(None), input))?;
        loads.map_or(Ok(()), |loads| self.change(&Command::SetLoads(*loads)).map(drop))?;
        if fluid.is_none() && !self.engine.has_fluid() {
            return Ok(());
        }
        self.change(&Command::SetFluidFields(fluid)).map(drop)
    }

    fn set_window(&mut self, window: Window) {
        self.window = Some(window);
        self.revision += 1;
    }

    fn define_field(&mut self, definition: sturz_engine::fields::FieldDefinition) -> Result<Wire, v1::Error> {
        self.engine.validate_field(&definition).map_err(|mut input| {
            if let Some(rest) = input.path.strip_prefix("define_field") {
                input.path = format!("field{rest}").replace("motion.name", "motion.boundary");
            }
            invalid(input)
        })?;
        let name = definition.name.clone();
        if self.outbox.field(&name).is_none() && self.outbox.fields.len() >= self.limits.fields {
            let text =
                format!("{} fields are defined, more are not allowed (limit `fields`): drop one", self.limits.fields);
            return Err(error(v1::ErrorCode::TooLarge, "field", text));
        }
        self.outbox.define_field(definition);
        self.follow_averages();
        self.revision += 1;
        self.announce_named(v1::EventKind::Field, v1::Severity::Info, "a field was defined", &name);
        Ok(Wire::Applied(v1::Applied {}))
    }

    /// Means over time are taken of the fields that are defined, by the engine, whose checkpoints hold them: those that are
    /// under way go on.
    pub(crate) fn follow_averages(&mut self) {
        self.engine.set_averages(self.outbox.fields.iter().map(|field| &field.definition));
    }

    fn drop_field(&mut self, name: &str) -> Result<Wire, v1::Error> {
        if !self.outbox.drop_field(name) {
            return Err(error(v1::ErrorCode::NotFound, "name", format!("no field {name:?} is defined")));
        }
        self.follow_averages();
        self.revision += 1;
        self.announce_named(v1::EventKind::Field, v1::Severity::Info, "a field was dropped", name);
        Ok(Wire::Applied(v1::Applied {}))
    }
}

/// The engine's refusal of a command, with the path into the request rather than into the engine's own types.
fn refused(command: &Command, mut input: InvalidInput) -> v1::Error {
    let path = match command {
        Command::Insert(insertion) => insertion_path(&insertion.placement, tail(&input.path, "insert")),
        Command::SetMotion { motion, .. } => motion_path(motion, tail(&input.path, "set_motion")),
        Command::Remove(_) => tail(&input.path, "remove").into(),
        Command::SetGravity(_) => tail(&input.path, "set_gravity").into(),
        Command::SetLoads(_) => format!("loads.{}", tail(&input.path, "set_loads")),
        Command::SetFluid { .. } if input.path.starts_with("fluid_fields") => {
            input.path.replacen("fluid_fields", "fields", 1)
        }
        Command::SetFluid { fluid, .. } => fluid_path(fluid.as_deref(), &input.path),
        Command::SetFluidFields(_) => input.path.replacen("fluid_fields", "fluid", 1),
    };
    input.path = path;
    invalid(input)
}

/// Without the name of the command.
fn tail<'p>(path: &'p str, command: &str) -> &'p str {
    path.strip_prefix(command).and_then(|rest| rest.strip_prefix('.')).unwrap_or(path)
}

fn fluid_path(fluid: Option<&FluidDescription>, path: &str) -> String {
    let kind = match fluid.and_then(|fluid| fluid.mesh.as_ref()) {
        Some(MeshDescription::Points { .. }) => "points",
        _ => "structured",
    };
    let path = path.replacen("fluid.mesh", &format!("fluid.{kind}"), 1);
    path.replacen(".counts", ".count_x", 1)
        .replacen(".sides[0]", ".x_low", 1)
        .replacen(".sides[1]", ".y_low", 1)
        .replacen(".sides[2]", ".z_low", 1)
}

fn insertion_path(placement: &Placement, path: &str) -> String {
    let Some(rest) = path.strip_prefix("placement") else {
        return path.into();
    };
    match placement {
        Placement::Poses { .. } => format!("placement.poses{rest}"),
        Placement::Lattice { .. } => format!("placement.lattice{}", rest.replace(".counts", ".count_x")),
        Placement::Deposition { .. } => format!("placement.deposition{}", rest.replace(".region", ".box")),
        Placement::Random { region, .. } => {
            let shape = match region {
                Region::Box { .. } => ".box",
                Region::Cylinder { .. } => ".cylinder",
            };
            format!("placement.random{}", rest.replace(".region", shape))
        }
    }
}

fn motion_path(motion: &MotionDescription, path: &str) -> String {
    let Some(rest) = path.strip_prefix("motion.") else {
        return path.into();
    };
    match motion {
        MotionDescription::Fixed => path.into(),
        MotionDescription::Translation { .. } => format!("motion.translation.{rest}"),
        MotionDescription::Oscillation { .. } => format!("motion.oscillation.{rest}"),
        MotionDescription::Servo { .. } => format!("motion.servo.{rest}"),
        MotionDescription::Table { .. } => format!("motion.table.{rest}"),
        MotionDescription::Rotation { angular_velocity, .. } => {
            let law = match angular_velocity {
                AngularVelocity::Constant { .. } => "constant",
                AngularVelocity::Ramp { .. } => "ramp",
                AngularVelocity::Oscillation { .. } => "oscillation",
            };
            format!("motion.rotation.{}", rest.replace("angular_velocity", law))
        }
    }
}

/// Particles that an insertion will make; about, where it goes by solid fraction.
fn expected_count(scene: &Scene, insertion: &InsertionDescription) -> u64 {
    match &insertion.placement {
        Placement::Poses { positions_m, .. } => positions_m.len() as u64,
        Placement::Lattice { counts, .. } => counts.iter().map(|&count| u64::from(count)).fold(1, u64::saturating_mul),
        Placement::Random { count: Some(count), .. } | Placement::Deposition { count, .. } => u64::from(*count),
        Placement::Random { region, solid_fraction, .. } => {
            let names = scene.description().shapes.iter().map(|shape| &shape.name);
            let shape = names.zip(scene.shapes()).find(|(name, _)| **name == insertion.shape);
            let volume = shape.map_or(f64::INFINITY, |(_, shape)| shape.mass_properties().volume);
            let smallest = volume * insertion.scale.range()[0].powi(3);
            // `as` saturates: what is no number at all is the engine's to refuse
            (solid_fraction.unwrap_or(0.0) * region_volume(region) / smallest).ceil() as u64
        }
    }
}

fn region_volume(region: &Region) -> f64 {
    match region {
        Region::Box { min_m, max_m } => (0..3).map(|axis| max_m[axis] - min_m[axis]).product(),
        Region::Cylinder { radius_m, length_m, .. } => std::f64::consts::PI * radius_m * radius_m * length_m,
    }
}
