//! The fluid in an engine: what acts on each particle, and what that adds up to.

use rayon::prelude::*;

use super::description::{FluidDescription, FluidFields};
use super::mesh::Mesh;
use super::operator::{Operator, Pose};
use super::seen::{Seen, Values, look};
use crate::checkpoint::codec::{Malformed, Pack, Reader, pack_fields};
use crate::engine::Engine;
use crate::error::InvalidInput;
use crate::fields::points_at;
use crate::hydrodynamics::{Flow, HydroShape, response};
use crate::math::{Mat3, Vec3};
use crate::particles::Particles;
use crate::scene::Scene;
use crate::shape::Shape;

mod given;

/// Part of the smoothing length that a particle may go before it is looked for again.
const FAR: f64 = 0.1;
/// Distance of the points that fill a shape over the smoothing length, at most.
const SUB_POINT_SPACING: f64 = 0.35;
/// Points of a shape, about: one is enough for what is small against the smoothing length.
const SUB_POINTS: [f64; 2] = [8.0, 512.0];
/// Bounding radius over the smoothing length below which it is.
const SMALL: f64 = 0.1;

/// What pushes a particle, linear in its motion: F = `force` - `drag` v - `added_mass` dv/dt, T = `torque` -
/// `rotational_drag` w.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Acting {
    /// With that of the pressure gradient and buoyancy, N.
    pub force: Vec3,
    /// N s/m
    pub drag: f64,
    /// N m
    pub torque: Vec3,
    /// N m s
    pub rotational_drag: f64,
    /// kg
    pub added_mass: f64,
    /// Of the force, by the pressure gradient, N.
    pub pressure: Vec3,
    /// Of the force, by buoyancy, N.
    pub buoyancy: Vec3,
}

/// What a half step did to a particle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    /// By the fluid.
    pub acting: Acting,
    /// Over the half step, m/s.
    pub mean_velocity: Vec3,
    /// Of the velocity, m/s.
    pub change: Vec3,
}

/// Impulses on a particle since the operator was made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Pending {
    /// By drag, lift and added mass, N s.
    interaction: Vec3,
    /// By the pressure gradient, N s.
    pressure: Vec3,
    /// By buoyancy, N s.
    buoyancy: Vec3,
    /// K times time, N s2/m.
    drag: f64,
}

/// Impulses on a cell since the fields came: interaction, pressure, K times time.
type CellSum = [f64; 7];

/// All that decides the future.
#[derive(Clone, Debug, PartialEq)]
struct State {
    description: FluidDescription,
    from: FluidFields,
    to: FluidFields,
    /// Of the ramp, s.
    start_s: f64,
    /// Since when impulses are counted, s.
    counted_from_s: f64,
    epoch: u64,
    /// Particles of the operator, ascending, where they were, and what acts on them.
    ids: Vec<u64>,
    poses: Vec<Pose>,
    acting: Vec<Acting>,
    pending: Vec<Pending>,
    /// By cell; empty without a mesh.
    sums: Vec<CellSum>,
    totals: Pending,
    /// Bound on how far a particle has come since the operator was made, m.
    path: f64,
    steps: u64,
    refreshes: u64,
}

pack_fields!(Acting {
    force: Vec3,
    drag: f64,
    torque: Vec3,
    rotational_drag: f64,
    added_mass: f64,
    pressure: Vec3,
    buoyancy: Vec3,
});
pack_fields!(Pending { interaction: Vec3, pressure: Vec3, buoyancy: Vec3, drag: f64 });
pack_fields!(Pose { position: Vec3, orientation: crate::math::Quat, shape: u32, scale: f64 });
pack_fields!(State {
    description: FluidDescription,
    from: FluidFields,
    to: FluidFields,
    start_s: f64,
    counted_from_s: f64,
    epoch: u64,
    ids: Vec<u64>,
    poses: Vec<Pose>,
    acting: Vec<Acting>,
    pending: Vec<Pending>,
    sums: Vec<CellSum>,
    totals: Pending,
    path: f64,
    steps: u64,
    refreshes: u64,
});

/// What the state makes of the mesh and the shapes; made anew where it is missing.
#[derive(Clone, Debug)]
struct Derived {
    mesh: Option<Mesh>,
    /// By shape of the scene.
    shapes: Vec<HydroShape>,
    sub_points: Vec<Vec<Vec3>>,
    operator: Operator,
    void_fraction: Vec<f64>,
    seen: Vec<Seen>,
}

/// A look ahead that a reader paid for: the operator of the state after a step.
#[derive(Clone, Debug)]
struct Ahead {
    step: u64,
    epoch: u64,
    operator: Operator,
    void_fraction: Vec<f64>,
}

/// A fluid around the particles.
#[derive(Clone, Debug)]
pub(crate) struct Fluid {
    state: State,
    /// `None` after a restore.
    derived: Option<Derived>,
    ahead: Option<Ahead>,
}

impl Pack for Fluid {
    const LEAST_BYTES: usize = State::LEAST_BYTES;
    fn put(&self, out: &mut Vec<u8>) {
        self.state.put(out);
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        Ok(Self { state: from.get()?, derived: None, ahead: None })
    }
}

impl std::ops::Add for Pending {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            interaction: self.interaction + other.interaction,
            pressure: self.pressure + other.pressure,
            buoyancy: self.buoyancy + other.buoyancy,
            drag: self.drag + other.drag,
        }
    }
}

impl Derived {
    fn new(state: &State, scene: &Scene) -> Self {
        let description = &state.description;
        let mesh = description.mesh.as_ref().zip(description.smoothing_length_m);
        let largest = state.poses.iter().map(|pose| pose.scale).fold(0.0, f64::max);
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let sub_points = match mesh {
            Some((_, length)) => {
                let length = length / scale;
                let points = |shape: &Shape| match shape.bounding_radius() < SMALL * length {
                    true => vec![Vec3::zeros()],
                    false => points_at(shape, SUB_POINT_SPACING * length, SUB_POINTS),
                };
                scene.shapes().iter().map(points).collect()
            }
            None => Vec::new(),
        };
        let mut derived = Self {
            mesh: mesh.map(|(mesh, length)| Mesh::new(mesh, length)),
            shapes: scene.shapes().iter().map(HydroShape::of).collect(),
            sub_points,
            operator: Operator::default(),
            void_fraction: Vec::new(),
            seen: Vec::new(),
        };
        (derived.operator, derived.void_fraction) = derived.operator_at(&state.poses);
        derived.look(state);
        derived
    }

    /// The operator of particles that are there, and the void fraction that they leave.
    fn operator_at(&self, poses: &[Pose]) -> (Operator, Vec<f64>) {
        let Some(mesh) = &self.mesh else { return Default::default() };
        let operator = Operator::new(mesh, &self.sub_points, poses);
        let mut volumes = vec![[0.0]; self.cells()];
        operator.scatter(|particle| [self.volume(&poses[particle])], &mut volumes);
        let void = volumes.iter().enumerate().map(|(cell, [solid])| 1.0 - solid / mesh.volume(cell)).collect();
        (operator, void)
    }

    fn cells(&self) -> usize {
        self.mesh.as_ref().map_or(0, Mesh::len)
    }

    fn volume(&self, pose: &Pose) -> f64 {
        self.shapes[pose.shape as usize].volume_m3() * pose.scale.powi(3)
    }

    /// What all particles find, with the operator at hand.
    fn look(&mut self, state: &State) {
        let description = &state.description;
        self.seen = if self.mesh.is_some() {
            look(&self.operator, [&state.from, &state.to], &self.void_fraction)
        } else {
            let values = Values::uniform(Vec3::from(description.velocity_m_per_s));
            let void_fraction = description.void_fraction;
            vec![Seen { immersed: 1.0, void_fraction, from: values, to: values }; state.poses.len()]
        };
    }
}

/// One particle, as the laws see it.
pub(crate) struct Body<'a> {
    pub shape: u32,
    pub scale: f64,
    pub rotation: &'a Mat3,
    pub velocity: Vec3,
    pub angular_velocity: Vec3,
}

impl State {
    fn new(description: FluidDescription, now_s: f64) -> Self {
        let cells = description.mesh.as_ref().map_or(0, |mesh| mesh.len());
        let fields =
            FluidFields { velocity_m_per_s: vec![description.velocity_m_per_s; cells], ..FluidFields::default() };
        Self {
            description,
            from: fields.clone(),
            to: fields,
            start_s: now_s,
            counted_from_s: now_s,
            // of no state, so that the first step looks where the particles are
            epoch: u64::MAX,
            ids: Vec::new(),
            poses: Vec::new(),
            acting: Vec::new(),
            pending: Vec::new(),
            sums: vec![CellSum::default(); cells],
            totals: Pending::default(),
            path: 0.0,
            steps: 0,
            refreshes: 0,
        }
    }

    fn part(&self, time_s: f64) -> f64 {
        if self.to.ramp_s > 0.0 { ((time_s - self.start_s) / self.to.ramp_s).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// The fields at a time.
    fn fields_at(&self, time_s: f64) -> FluidFields {
        let part = self.part(time_s);
        if part >= 1.0 {
            return FluidFields { ramp_s: 0.0, ..self.to.clone() };
        }
        let n = self.sums.len();
        let mix = |from: &[[f64; 3]], to: &[[f64; 3]]| -> Vec<[f64; 3]> {
            if from.is_empty() && to.is_empty() {
                return Vec::new();
            }
            let row = |column: &[[f64; 3]], k: usize| column.get(k).copied().unwrap_or_default();
            let mixed = |k: usize| {
                let (a, b) = (row(from, k), row(to, k));
                [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * part)
            };
            (0..n).map(mixed).collect()
        };
        let (from, to) = (&self.from, &self.to);
        FluidFields {
            velocity_m_per_s: mix(&from.velocity_m_per_s, &to.velocity_m_per_s),
            vorticity_rad_per_s: mix(&from.vorticity_rad_per_s, &to.vorticity_rad_per_s),
            ramp_s: 0.0,
            ..to.clone()
        }
    }
}

impl Fluid {
    fn new(description: FluidDescription, scene: &Scene, now_s: f64) -> Self {
        let state = State::new(description, now_s);
        let derived = Some(Derived::new(&state, scene));
        Self { state, derived, ahead: None }
    }

    /// What a checkpoint keeps.
    pub fn saved(&self) -> Self {
        Self { state: self.state.clone(), derived: None, ahead: None }
    }

    fn derived(&self) -> &Derived {
        self.derived.as_ref().expect("a look at the particles has made it")
    }

    /// Puts the impulses so far where the operator says; with that, the operator may be replaced.
    fn flush(&mut self) {
        let derived = self.derived.as_ref().expect("a look at the particles has made it");
        let State { pending, sums, totals, .. } = &mut self.state;
        *totals = pending.iter().fold(*totals, |sum, more| sum + *more);
        scatter_pending(derived, pending, sums);
        pending.fill(Pending::default());
    }

    /// Looks where the particles are now.
    fn refresh(&mut self, particles: &Particles, (epoch, step): (u64, u64), scene: &Scene) {
        if self.derived.is_none() {
            self.derived = Some(Derived::new(&self.state, scene));
        }
        self.flush();
        let largest = |poses: &[Pose]| poses.iter().map(|pose| pose.scale).fold(0.0, f64::max);
        let before = largest(&self.state.poses);
        let rows = particles.rows_by_id();
        self.state.ids = rows.iter().map(|&row| particles.ids[row as usize]).collect();
        self.state.poses = poses(particles, &rows);
        self.state.pending = vec![Pending::default(); rows.len()];
        self.state.acting.resize(rows.len(), Acting::default());
        (self.state.epoch, self.state.path, self.state.steps) = (epoch, 0.0, 0);
        self.state.refreshes += 1;
        if largest(&self.state.poses) == before {
            let derived = self.derived.as_mut().expect("made above");
            let ahead = self.ahead.take().filter(|ahead| (ahead.step, ahead.epoch) == (step, epoch));
            (derived.operator, derived.void_fraction) = match ahead {
                Some(ahead) => (ahead.operator, ahead.void_fraction),
                None => derived.operator_at(&self.state.poses),
            };
            derived.look(&self.state);
        } else {
            // points fill the largest of each shape finely enough
            self.derived = Some(Derived::new(&self.state, scene));
        }
        self.ahead = None;
    }

    /// Whether a step that starts now must look first.
    fn must_look(&self, particles: &Particles, epoch: u64) -> bool {
        let State { description, ids, path, steps, .. } = &self.state;
        let far = description.smoothing_length_m.is_some_and(|length| *path > FAR * length);
        let due = match description.refresh_steps {
            0 => far,
            most => *steps >= most,
        };
        due || self.state.epoch != epoch || ids.len() != particles.n_owned()
    }

    /// Place of a particle among those of the operator.
    pub fn slot(&self, id: u64) -> usize {
        self.state.ids.binary_search(&id).expect("the operator has all particles that are there")
    }

    /// On the particle of a slot, by the last evaluation.
    pub fn acting(&self, slot: usize) -> &Acting {
        &self.state.acting[slot]
    }

    /// On the particle of a slot, moving like that, at a time.
    pub fn act(&self, slot: usize, body: &Body<'_>, gravity: &Vec3, time_s: f64) -> Acting {
        let (description, derived) = (&self.state.description, self.derived());
        let (laws, shape) = (&description.laws, &derived.shapes[body.shape as usize]);
        let seen = &derived.seen[slot];
        let values = Values::mix(&seen.from, &seen.to, self.state.part(time_s));
        let flow = Flow {
            relative_velocity: values.velocity - body.velocity,
            relative_angular_velocity: values.vorticity * 0.5 - body.angular_velocity,
            vorticity: values.vorticity,
            void_fraction: seen.void_fraction.clamp(description.least_void_fraction, 1.0),
            density: description.density_kg_per_m3,
            viscosity: description.viscosity_pa_s,
        };
        let found = response(laws, shape, body.scale, body.rotation, &flow);
        let immersed = seen.immersed;
        let volume = immersed * shape.volume_m3() * body.scale.powi(3);
        let (drag, turning) = (immersed * found.drag_n_s_per_m, immersed * found.rotational_drag_n_m_s);
        let added_mass = laws.added_mass_coefficient * flow.density * volume;
        let pressure = values.pressure_gradient * -volume;
        let buoyancy = if description.buoyancy { gravity * (-flow.density * volume) } else { Vec3::zeros() };
        Acting {
            force: values.velocity * drag
                + found.force_n * immersed
                + values.acceleration * added_mass
                + pressure
                + buoyancy,
            drag,
            torque: found.torque_n_m * immersed + values.vorticity * (0.5 * turning),
            rotational_drag: turning,
            added_mass,
            pressure,
            buoyancy,
        }
    }

    /// Adds what a half step of `h` seconds did: `outcome` by slot; `fastest` is the largest speed, m/s.
    pub fn book(&mut self, outcome: impl Fn(usize) -> Outcome + Sync, h: f64, fastest: f64) {
        let State { acting, pending, .. } = &mut self.state;
        (acting.par_iter_mut(), pending.par_iter_mut()).into_par_iter().enumerate().with_min_len(512).for_each(
            |(slot, (acting, pending))| {
                let Outcome { acting: now, mean_velocity, change } = outcome(slot);
                *acting = now;
                let push = now.force - now.pressure - now.buoyancy - mean_velocity * now.drag;
                pending.interaction += push * h - change * now.added_mass;
                pending.pressure += now.pressure * h;
                pending.buoyancy += now.buoyancy * h;
                pending.drag += now.drag * h;
            },
        );
        self.state.path += fastest * h;
    }

    /// A step is over.
    pub fn count_step(&mut self) {
        self.state.steps += 1;
    }

    /// Words for the state hash.
    pub fn words(&self, mut put: impl FnMut(&[f64])) {
        let state = &self.state;
        put(&[state.start_s, state.counted_from_s, state.path, state.steps as f64, state.to.ramp_s]);
        for fields in [&state.from, &state.to] {
            for column in [
                &fields.velocity_m_per_s,
                &fields.pressure_gradient_pa_per_m,
                &fields.acceleration_m_per_s2,
                &fields.vorticity_rad_per_s,
            ] {
                put(column.as_flattened());
            }
        }
        for (acting, pending) in state.acting.iter().zip(&state.pending) {
            put(acting.force.as_slice());
            put(acting.torque.as_slice());
            put(&[acting.drag, acting.rotational_drag, acting.added_mass, pending.drag]);
            put(pending.interaction.as_slice());
            put(pending.pressure.as_slice());
        }
        put(state.sums.as_flattened());
    }

    /// Whether an engine of a scene with so many shapes may have it, after a restore.
    pub fn check(&self, shapes: usize) -> Result<(), InvalidInput> {
        let state = &self.state;
        state.description.check()?;
        let cells = state.description.mesh.as_ref().map_or(0, |mesh| mesh.len());
        state.from.check(cells)?;
        state.to.check(cells)?;
        let n = state.ids.len();
        let whole = [state.poses.len(), state.acting.len(), state.pending.len()] == [n; 3];
        let poses_sound = state.poses.iter().all(|pose| {
            (pose.shape as usize) < shapes
                && pose.scale.is_finite()
                && pose.scale > 0.0
                && pose.position.iter().chain(pose.orientation.coords.iter()).all(|x| x.is_finite())
                && (pose.orientation.coords.norm() - 1.0).abs() < 1e-6
        });
        let times = state.start_s.is_finite() && state.counted_from_s.is_finite() && state.path >= 0.0;
        let sorted = state.ids.is_sorted_by(|a, b| a < b);
        let drags = state.acting.iter().all(|acting| {
            [acting.drag, acting.rotational_drag, acting.added_mass].iter().all(|x| x.is_finite() && *x >= 0.0)
        });
        if whole && poses_sound && times && sorted && drags && state.sums.len() == cells {
            Ok(())
        } else {
            Err(InvalidInput::new("fluid", "is no fluid of these particles"))
        }
    }
}

/// Adds impulses to the cells. At open sides a particle felt only the part of it that is inside, which is what its weights
/// sum to.
fn scatter_pending(derived: &Derived, pending: &[Pending], sums: &mut [CellSum]) {
    if sums.is_empty() {
        return;
    }
    let value = |particle: usize| {
        let Pending { interaction, pressure, drag, .. } = pending[particle];
        let immersed = derived.seen[particle].immersed;
        let scale = if immersed > 0.0 { 1.0 / immersed } else { 0.0 };
        let [[a, b, c], [d, e, f]] = [interaction, pressure].map(|v| (v * scale).into());
        [a, b, c, d, e, f, drag * scale]
    };
    derived.operator.scatter(value, sums);
}

fn poses(particles: &Particles, rows: &[u32]) -> Vec<Pose> {
    let pose = |&row: &u32| {
        let row = row as usize;
        Pose {
            position: particles.position[row],
            orientation: particles.orientation[row],
            shape: particles.shape[row],
            scale: particles.scale[row],
        }
    };
    rows.iter().map(pose).collect()
}

impl Engine {
    /// Puts a fluid around the particles, or takes it away.
    pub(crate) fn set_fluid(
        &mut self,
        description: Option<&FluidDescription>,
        fields: Option<&FluidFields>,
    ) -> Result<(), InvalidInput> {
        let Some(description) = description else {
            return match fields {
                None => {
                    self.fluid = None;
                    Ok(())
                }
                Some(_) => Err(InvalidInput::new("fluid_fields", "is there, but no fluid to be that of")),
            };
        };
        description.check()?;
        if let Some(fields) = fields {
            let no_mesh = || InvalidInput::new("fluid_fields", "is there, but the fluid has no mesh");
            fields.check(description.mesh.as_ref().ok_or_else(no_mesh)?.len())?;
        }
        if let Some((mesh, length)) = description.mesh.as_ref().zip(description.smoothing_length_m) {
            mesh.check_weights(length, &self.particles.radius[..self.particles.n_owned()])?;
        }
        let scene = std::sync::Arc::clone(&self.written);
        let now_s = self.clock.time_s();
        self.fluid = Some(self.in_pool(|_| Fluid::new(description.clone(), &scene, now_s)));
        let at_once = fields.map(|fields| FluidFields { ramp_s: 0.0, ..fields.clone() });
        self.set_fluid_fields(at_once.as_ref())
    }

    /// Gives the fluid new fields, or none: then those that there are go on. Impulses are counted anew from now.
    pub(crate) fn set_fluid_fields(&mut self, fields: Option<&FluidFields>) -> Result<(), InvalidInput> {
        self.check_fluid_fields(fields)?;
        let now_s = self.clock.time_s();
        if let (Some(fields), Some(fluid)) = (fields, &mut self.fluid) {
            // pressure gradient and acceleration are means over the window, and have no start of it
            let from = match fields.ramp_s > 0.0 {
                true => FluidFields {
                    pressure_gradient_pa_per_m: fields.pressure_gradient_pa_per_m.clone(),
                    acceleration_m_per_s2: fields.acceleration_m_per_s2.clone(),
                    ..fluid.state.fields_at(now_s)
                },
                false => fields.clone(),
            };
            fluid.state.from = from;
            fluid.state.to = fields.clone();
            fluid.state.start_s = now_s;
        }
        self.in_pool(Self::look_at_fluid);
        if let Some(fluid) = &mut self.fluid {
            fluid.state.counted_from_s = now_s;
            fluid.state.totals = Pending::default();
            fluid.state.sums.fill(CellSum::default());
        }
        Ok(())
    }

    /// Whether these fields may be given to the fluid; none need no fluid.
    pub fn check_fluid_fields(&self, fields: Option<&FluidFields>) -> Result<(), InvalidInput> {
        let Some(fields) = fields else { return Ok(()) };
        let Some(fluid) = &self.fluid else {
            return Err(InvalidInput::new("fluid_fields", "is there, but no fluid: define it by set_fluid"));
        };
        match &fluid.state.description.mesh {
            Some(mesh) => fields.check(mesh.len()),
            None => Err(InvalidInput::new("fluid_fields", "is there, but the fluid has no mesh")),
        }
    }

    /// Whether there is a fluid.
    pub fn has_fluid(&self) -> bool {
        self.fluid.is_some()
    }

    /// Before the first half kick: looks where the particles are, if need be.
    pub(crate) fn look_at_fluid_if_due(&mut self) {
        let epoch = self.topology_epoch;
        match &mut self.fluid {
            Some(fluid) if fluid.must_look(&self.particles, epoch) => self.look_at_fluid(),
            Some(fluid) if fluid.derived.is_none() => {
                fluid.derived = Some(Derived::new(&fluid.state, &self.written));
            }
            _ => {}
        }
    }

    /// Looks where the particles are, and finds what acts on them as they move now.
    fn look_at_fluid(&mut self) {
        let Some(mut fluid) = self.fluid.take() else { return };
        fluid.refresh(&self.particles, (self.topology_epoch, self.clock.step()), &self.written);
        let (particles, time_s) = (&self.particles, self.clock.time_s());
        let rows = particles.rows_by_id();
        let acting: Vec<Acting> = rows
            .par_iter()
            .enumerate()
            .with_min_len(128)
            .map(|(slot, &row)| {
                let row = row as usize;
                let body = Body {
                    shape: particles.shape[row],
                    scale: particles.scale[row],
                    rotation: &particles.rotation[row],
                    velocity: particles.velocity[row],
                    angular_velocity: particles.angular_velocity(row),
                };
                fluid.act(slot, &body, &self.gravity, time_s)
            })
            .collect();
        fluid.state.acting = acting;
        self.fluid = Some(fluid);
        // its slots are those of other particles now
        self.external_changes += 1;
    }
}
