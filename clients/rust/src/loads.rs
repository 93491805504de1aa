//! Loads on particles from outside, as plain values; the daemon checks them.

use sturz_protocol::columns::{Number, flat, rows};
use sturz_protocol::v1;

/// Loads from outside. On a particle of velocity v and angular velocity w act the force f + K (u - v) and the torque
/// t + L (q - w). Columns have one row per id, or are empty (0 for all).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loads {
    /// Of the state that the ids are from ([`crate::State::topology_epoch`]); with another one than the present they are
    /// refused.
    pub topology_epoch: u64,
    /// Each once. None: no loads.
    pub ids: Vec<u64>,
    /// f
    pub force_n: Vec<[f64; 3]>,
    /// t, world axes.
    pub torque_n_m: Vec<[f64; 3]>,
    /// K, at least 0: stable however large.
    pub drag_n_s_per_m: Vec<f64>,
    /// u
    pub fluid_velocity_m_per_s: Vec<[f64; 3]>,
    /// L, at least 0.
    pub rotational_drag_n_m_s: Vec<f64>,
    /// q, world axes.
    pub fluid_angular_velocity_rad_per_s: Vec<[f64; 3]>,
    /// The loads before change linearly into these over this time; 0: at once.
    pub ramp_s: f64,
    /// Simulated time until which they act; without end when `None`.
    pub valid_until_s: Option<f64>,
}

impl From<Loads> for v1::Loads {
    fn from(loads: Loads) -> Self {
        Self {
            topology_epoch: loads.topology_epoch,
            ids: numbers("ids", "", &loads.ids),
            force_n: vectors("force_n", "N", &loads.force_n),
            torque_n_m: vectors("torque_n_m", "N m", &loads.torque_n_m),
            drag_n_s_per_m: numbers("drag_n_s_per_m", "N s/m", &loads.drag_n_s_per_m),
            fluid_velocity_m_per_s: vectors("fluid_velocity_m_per_s", "m/s", &loads.fluid_velocity_m_per_s),
            rotational_drag_n_m_s: numbers("rotational_drag_n_m_s", "N m s", &loads.rotational_drag_n_m_s),
            fluid_angular_velocity_rad_per_s: vectors(
                "fluid_angular_velocity_rad_per_s",
                "rad/s",
                &loads.fluid_angular_velocity_rad_per_s,
            ),
            ramp_s: loads.ramp_s,
            valid_until_s: loads.valid_until_s,
        }
    }
}

fn vectors(name: &str, unit: &str, values: &[[f64; 3]]) -> Option<v1::Column> {
    (!values.is_empty()).then(|| rows(name, unit, values))
}

fn numbers<T: Number>(name: &str, unit: &str, values: &[T]) -> Option<v1::Column> {
    (!values.is_empty()).then(|| flat(name, unit, 1, values))
}
