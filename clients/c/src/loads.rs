//! Forces on single particles.

use sturz_client::Loads;

use crate::border::{column, rows, shared};
use crate::code::sturz_code;
use crate::failure::{Failure, guard};
use crate::simulation::{connection, sturz_simulation};

/// Loads from outside. On a particle of velocity v and angular velocity w act the force f + K (u - v) and the torque
/// t + L (q - w), however large K and L are. Each array has a row per id, or is null: 0 for all.
#[repr(C)]
#[derive(Debug)]
pub struct sturz_loads {
    /// Of the state that the ids are from (`sturz_state`); with another one than the present they are refused.
    pub topology_epoch: u64,
    /// n, the ids; 0 for no loads.
    pub count: u64,
    /// (n): each once, in any order.
    pub ids: *const u64,
    /// f, (n, 3), N.
    pub force_n: *const f64,
    /// t, (n, 3), world axes, N m.
    pub torque_n_m: *const f64,
    /// K, (n), at least 0, N s/m.
    pub drag_n_s_per_m: *const f64,
    /// u, (n, 3), m/s.
    pub fluid_velocity_m_per_s: *const f64,
    /// L, (n), at least 0, N m s.
    pub rotational_drag_n_m_s: *const f64,
    /// q, (n, 3), world axes, rad/s.
    pub fluid_angular_velocity_rad_per_s: *const f64,
    /// The loads before change linearly into these over this time, s. 0: at once.
    pub ramp_s: f64,
    /// Simulated time until which they act, s. 0: without end.
    pub valid_until_s: f64,
}

impl sturz_loads {
    /// As the client has them.
    ///
    /// # Safety
    /// Each array is null or has `count` rows.
    pub(crate) unsafe fn read(&self) -> Result<Loads, Failure> {
        if self.count > 0 && self.ids.is_null() {
            return Err(Failure::argument("loads.ids", &format!("is null, and loads.count is {}", self.count)));
        }
        let count = self.count;
        // SAFETY: the caller's word.
        unsafe {
            Ok(Loads {
                topology_epoch: self.topology_epoch,
                ids: column("loads.ids", self.ids, count)?,
                force_n: rows("loads.force_n", self.force_n, count)?,
                torque_n_m: rows("loads.torque_n_m", self.torque_n_m, count)?,
                drag_n_s_per_m: column("loads.drag_n_s_per_m", self.drag_n_s_per_m, count)?,
                fluid_velocity_m_per_s: rows("loads.fluid_velocity_m_per_s", self.fluid_velocity_m_per_s, count)?,
                rotational_drag_n_m_s: column("loads.rotational_drag_n_m_s", self.rotational_drag_n_m_s, count)?,
                fluid_angular_velocity_rad_per_s: rows(
                    "loads.fluid_angular_velocity_rad_per_s",
                    self.fluid_angular_velocity_rad_per_s,
                    count,
                )?,
                ramp_s: self.ramp_s,
                valid_until_s: (self.valid_until_s != 0.0).then_some(self.valid_until_s),
            })
        }
    }
}

/// Replaces all loads from now on, until others come. `count` 0 takes them away.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_set_loads(simulation: *const sturz_simulation, loads: *const sturz_loads) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, loads) = unsafe { (connection(simulation)?, shared("loads", loads)?.read()?) };
        connection.set_loads(loads).map(drop).map_err(Failure::from)
    })
}
