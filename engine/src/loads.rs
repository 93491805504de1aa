//! Loads from outside: a force and a torque per particle, and the linearised pair of a drag.
//!
//! On a particle of velocity v and angular velocity w act
//!
//! F = f + K (u - v) and T = t + L (q - w)
//!
//! f force (N), K drag (N s/m), u velocity of the fluid (m/s); t torque (N m), L rotational drag (N m s), q angular velocity
//! of the fluid (rad/s), world axes. Each half kick of velocity Verlet solves m v' = f_contact + m g + F exactly for a
//! frozen contact force, and likewise for the angular momentum about each principal axis:
//! v(h) = v e^-z + a h (1 - e^-z)/z with z = K h/m, a = (f_contact + m g + f + K u)/m. Hence stable for every K, exact
//! under constant forces, and second order with contacts. Loads at the start of the step act in its first half, those at
//! its end in the second.

use crate::checkpoint::codec::pack_fields;
use crate::engine::Engine;
use crate::error::InvalidInput;
use crate::math::Vec3;

/// What a client asks for; replaces all loads before. Columns are empty (0 for all) or have a row per id.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadDescription {
    /// Epoch of the particles that the ids are from.
    pub topology_epoch: u64,
    /// In any order, each once. None: no loads.
    pub ids: Vec<u64>,
    /// f
    pub force_n: Vec<[f64; 3]>,
    /// t, world axes.
    pub torque_n_m: Vec<[f64; 3]>,
    /// K, at least 0.
    pub drag_n_s_per_m: Vec<f64>,
    /// u
    pub fluid_velocity_m_per_s: Vec<[f64; 3]>,
    /// L, at least 0.
    pub rotational_drag_n_m_s: Vec<f64>,
    /// q, world axes.
    pub fluid_angular_velocity_rad_per_s: Vec<[f64; 3]>,
    /// The loads before change linearly into these over this time from now on, then these are held; 0: at once.
    pub ramp_s: f64,
    /// Simulated time until which they act; without end when absent.
    pub valid_until_s: Option<f64>,
}

/// F = `force` - `drag` v, T = `torque` - `rotational_drag` w: what is linear in time during a ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Load {
    pub force: Vec3,
    pub drag: f64,
    pub torque: Vec3,
    pub rotational_drag: f64,
}

pack_fields!(Load { force: Vec3, drag: f64, torque: Vec3, rotational_drag: f64 });

/// Loads in force.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Loads {
    /// Ascending.
    ids: Vec<u64>,
    /// By id: at the start of the ramp.
    from: Vec<Load>,
    /// By id: at its end, and after.
    to: Vec<Load>,
    start_s: f64,
    ramp_s: f64,
    until_s: Option<f64>,
}

pack_fields!(Loads { ids: Vec<u64>, from: Vec<Load>, to: Vec<Load>, start_s: f64, ramp_s: f64, until_s: Option<f64> });

impl Load {
    fn at(from: &Self, to: &Self, part: f64) -> Self {
        if part >= 1.0 {
            return *to;
        }
        Self {
            force: from.force + (to.force - from.force) * part,
            drag: from.drag + (to.drag - from.drag) * part,
            torque: from.torque + (to.torque - from.torque) * part,
            rotational_drag: from.rotational_drag + (to.rotational_drag - from.rotational_drag) * part,
        }
    }

    fn is_finite(&self) -> bool {
        let drags = [self.drag, self.rotational_drag];
        drags.iter().all(|&drag| drag.is_finite() && drag >= 0.0)
            && self.force.iter().chain(&self.torque).all(|number| number.is_finite())
    }
}

impl LoadDescription {
    /// Checks all but what only the running engine knows.
    fn check(&self) -> Result<(), InvalidInput> {
        let n = self.ids.len();
        let column = |name: &str, rows: usize, numbers: &[f64], width: usize| {
            if rows != 0 && rows != n {
                let problem = format!("has {rows} rows for {n} ids; give one each, or none");
                return Err(InvalidInput::new(format!("set_loads.{name}"), problem));
            }
            match numbers.iter().position(|number| !number.is_finite()) {
                Some(at) => {
                    let problem = format!("is {}; must be finite", numbers[at]);
                    Err(InvalidInput::new(format!("set_loads.{name}[{}]", at / width), problem))
                }
                None => Ok(()),
            }
        };
        for (name, vectors) in [
            ("force_n", &self.force_n),
            ("torque_n_m", &self.torque_n_m),
            ("fluid_velocity_m_per_s", &self.fluid_velocity_m_per_s),
            ("fluid_angular_velocity_rad_per_s", &self.fluid_angular_velocity_rad_per_s),
        ] {
            column(name, vectors.len(), vectors.as_flattened(), 3)?;
        }
        for (name, drags, of, fluid) in [
            ("drag_n_s_per_m", &self.drag_n_s_per_m, "fluid_velocity_m_per_s", &self.fluid_velocity_m_per_s),
            (
                "rotational_drag_n_m_s",
                &self.rotational_drag_n_m_s,
                "fluid_angular_velocity_rad_per_s",
                &self.fluid_angular_velocity_rad_per_s,
            ),
        ] {
            column(name, drags.len(), drags, 1)?;
            if let Some(at) = drags.iter().position(|&drag| drag < 0.0) {
                let problem = format!("is {}; must be 0 or more", drags[at]);
                return Err(InvalidInput::new(format!("set_loads.{name}[{at}]"), problem));
            }
            if drags.is_empty() && !fluid.is_empty() {
                let problem = format!("does nothing without {name}");
                return Err(InvalidInput::new(format!("set_loads.{of}"), problem));
            }
        }
        if !(self.ramp_s.is_finite() && self.ramp_s >= 0.0) {
            let problem = format!("is {}; must be finite and 0 or more", self.ramp_s);
            return Err(InvalidInput::new("set_loads.ramp_s", problem));
        }
        Ok(())
    }

    fn load(&self, k: usize) -> Load {
        let vector = |column: &[[f64; 3]]| column.get(k).map_or_else(Vec3::zeros, |row| Vec3::from(*row));
        let number = |column: &[f64]| column.get(k).copied().unwrap_or(0.0);
        let (drag, rotational_drag) = (number(&self.drag_n_s_per_m), number(&self.rotational_drag_n_m_s));
        Load {
            force: vector(&self.force_n) + vector(&self.fluid_velocity_m_per_s) * drag,
            drag,
            torque: vector(&self.torque_n_m) + vector(&self.fluid_angular_velocity_rad_per_s) * rotational_drag,
            rotational_drag,
        }
    }
}

impl Loads {
    /// The loads of a checked description from `now_s` on, out of those before.
    fn new(description: &LoadDescription, before: Option<&Loads>, now_s: f64) -> Option<Self> {
        let mut loads: Vec<(u64, Load, Load)> =
            description.ids.iter().enumerate().map(|(k, &id)| (id, Load::default(), description.load(k))).collect();
        loads.sort_unstable_by_key(|(id, ..)| *id);
        if let Some(before) = before.filter(|_| description.ramp_s > 0.0) {
            let part = before.part(now_s);
            let mut fading = Vec::new();
            for (k, id) in before.ids.iter().enumerate() {
                let present = Load::at(&before.from[k], &before.to[k], part);
                match loads.binary_search_by_key(id, |(id, ..)| *id) {
                    Ok(at) => loads[at].1 = present,
                    Err(_) => fading.push((*id, present, Load::default())),
                }
            }
            loads.extend(fading);
            loads.sort_unstable_by_key(|(id, ..)| *id);
        }
        let loads = Self {
            ids: loads.iter().map(|(id, ..)| *id).collect(),
            from: loads.iter().map(|(_, from, _)| *from).collect(),
            to: loads.iter().map(|(.., to)| *to).collect(),
            start_s: now_s,
            ramp_s: description.ramp_s,
            until_s: description.valid_until_s,
        };
        (!loads.ids.is_empty()).then_some(loads)
    }

    fn part(&self, time_s: f64) -> f64 {
        if self.ramp_s > 0.0 { ((time_s - self.start_s) / self.ramp_s).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Whether they no longer act in a step that starts then.
    pub(crate) fn are_over(&self, time_s: f64) -> bool {
        self.until_s.is_some_and(|until| time_s >= until)
    }

    /// Place of a particle among the loads.
    pub(crate) fn find(&self, id: u64) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }

    /// The load of a place at a time.
    pub(crate) fn load(&self, at: usize, time_s: f64) -> Load {
        Load::at(&self.from[at], &self.to[at], self.part(time_s))
    }

    /// Words for the state hash.
    pub(crate) fn words(&self, mut put: impl FnMut(&[f64])) {
        put(&[self.start_s, self.ramp_s, self.until_s.unwrap_or(f64::INFINITY)]);
        for (id, loads) in self.ids.iter().zip(self.from.iter().zip(&self.to)) {
            put(&[*id as f64]);
            for load in [loads.0, loads.1] {
                put(load.force.as_slice());
                put(load.torque.as_slice());
                put(&[load.drag, load.rotational_drag]);
            }
        }
    }

    /// Whether an engine may have them.
    pub(crate) fn check(&self) -> Result<(), InvalidInput> {
        let sorted = self.ids.is_sorted_by(|a, b| a < b) && !self.ids.is_empty();
        let whole = self.from.len() == self.ids.len() && self.to.len() == self.ids.len();
        let times = self.start_s.is_finite() && self.ramp_s.is_finite() && self.ramp_s >= 0.0;
        let finite = self.from.iter().chain(&self.to).all(Load::is_finite) && self.until_s.is_none_or(f64::is_finite);
        if sorted && whole && times && finite {
            Ok(())
        } else {
            Err(InvalidInput::new("loads", "are no loads of particles"))
        }
    }
}

impl Engine {
    /// Replaces the loads; checks everything before it changes anything.
    pub(crate) fn set_loads(&mut self, description: &LoadDescription) -> Result<(), InvalidInput> {
        self.check_loads(description)?;
        self.loads = Loads::new(description, self.loads.as_ref(), self.clock.time_s());
        self.external_changes += 1;
        Ok(())
    }

    /// The loads are over.
    pub(crate) fn set_no_loads(&mut self) {
        self.loads = None;
        self.external_changes += 1;
    }

    fn check_loads(&self, description: &LoadDescription) -> Result<(), InvalidInput> {
        description.check()?;
        let (epoch, present) = (description.topology_epoch, self.topology_epoch);
        if epoch != present {
            let problem = format!("is {epoch}, the particles are of epoch {present}: ask for their ids again");
            return Err(InvalidInput::new("set_loads.topology_epoch", problem));
        }
        let now_s = self.clock.time_s();
        if let Some(until) = description.valid_until_s.filter(|until| !(until.is_finite() && *until > now_s)) {
            let problem = format!("is {until} s; must be finite and later than now, {now_s} s");
            return Err(InvalidInput::new("set_loads.valid_until_s", problem));
        }
        let mut present = self.particles.ids.clone();
        present.sort_unstable();
        if let Some(k) = description.ids.iter().position(|id| present.binary_search(id).is_err()) {
            let problem = format!("particle {} does not exist", description.ids[k]);
            return Err(InvalidInput::new(format!("set_loads.ids[{k}]"), problem));
        }
        let mut order: Vec<usize> = (0..description.ids.len()).collect();
        order.sort_by_key(|&k| description.ids[k]);
        let twin = order.windows(2).find(|pair| description.ids[pair[0]] == description.ids[pair[1]]);
        if let Some(&[_, k]) = twin {
            let problem = format!("particle {} has a load already", description.ids[k]);
            return Err(InvalidInput::new(format!("set_loads.ids[{k}]"), problem));
        }
        Ok(())
    }
}
