//! A fluid around the particles, and what it gets from them.

use sturz_protocol::columns::{self, ColumnError};
use sturz_protocol::v1;

use crate::error::ClientError;
use crate::state::read_named;

/// The fluid on its mesh, a row per cell or point; an empty column is 0. See `docs/coupling.md`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FluidFields {
    /// Interstitial, m/s.
    pub velocity_m_per_s: Vec<[f64; 3]>,
    /// Pa/m
    pub pressure_gradient_pa_per_m: Vec<[f64; 3]>,
    /// Material derivative of the velocity, m/s2: for the added mass.
    pub acceleration_m_per_s2: Vec<[f64; 3]>,
    /// Curl of the velocity, rad/s: for lift and rotation.
    pub vorticity_rad_per_s: Vec<[f64; 3]>,
    /// Velocity and vorticity change linearly from those before into these over this time, s; 0: at once.
    pub ramp_s: f64,
}

impl From<FluidFields> for v1::FluidFields {
    fn from(fields: FluidFields) -> Self {
        let column =
            |name: &str, unit: &str, rows: &[[f64; 3]]| (!rows.is_empty()).then(|| columns::rows(name, unit, rows));
        Self {
            velocity_m_per_s: column("velocity_m_per_s", "m/s", &fields.velocity_m_per_s),
            pressure_gradient_pa_per_m: column(
                "pressure_gradient_pa_per_m",
                "Pa/m",
                &fields.pressure_gradient_pa_per_m,
            ),
            acceleration_m_per_s2: column("acceleration_m_per_s2", "m/s2", &fields.acceleration_m_per_s2),
            vorticity_rad_per_s: column("vorticity_rad_per_s", "rad/s", &fields.vorticity_rad_per_s),
            ramp_s: fields.ramp_s,
        }
    }
}

/// What a fluid gets from the particles, a row per cell or point of its mesh. Sources are means since `from_time_s`.
#[derive(Clone, Debug, PartialEq)]
pub struct Exchange {
    frame: v1::ExchangeFrame,
}

impl Exchange {
    /// From the wire.
    pub(crate) fn new(frame: v1::ExchangeFrame) -> Self {
        Self { frame }
    }

    /// As it came, with all totals.
    pub fn frame(&self) -> &v1::ExchangeFrame {
        &self.frame
    }

    /// Since when impulses are counted, s.
    pub fn from_time_s(&self) -> f64 {
        self.frame.from_time_s
    }

    /// Simulated time, s.
    pub fn time_s(&self) -> f64 {
        self.frame.header.as_ref().map_or(0.0, |header| header.sim_time_s)
    }

    /// 1 less the part of the cell that particles fill, now.
    pub fn void_fraction(&self) -> Result<Vec<f64>, ClientError> {
        self.numbers("void_fraction")
    }

    /// Mean over the solid in the cell, now, m/s; 0 where there is none.
    pub fn solid_velocity_m_per_s(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.vectors("solid_velocity")
    }

    /// Force on the fluid by drag, lift and added mass, N/m3.
    pub fn interaction_n_per_m3(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.vectors("interaction")
    }

    /// Force on the particles by the given pressure gradient, N/m3.
    pub fn pressure_force_n_per_m3(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.vectors("pressure_force")
    }

    /// By how much the interaction opposes a change of the fluid's velocity, kg/(m3 s).
    pub fn drag_kg_per_m3_s(&self) -> Result<Vec<f64>, ClientError> {
        self.numbers("drag")
    }

    fn numbers(&self, name: &str) -> Result<Vec<f64>, ClientError> {
        let read = |column: &v1::Column| -> Result<Vec<[f64; 1]>, ColumnError> { columns::read(column) };
        Ok(read_named(&self.frame.columns, name, read)?.into_flattened())
    }

    fn vectors(&self, name: &str) -> Result<Vec<[f64; 3]>, ClientError> {
        read_named(&self.frame.columns, name, columns::read)
    }
}
