//! What the fluid gets back.

/// Of the particles, on the mesh of the fluid. Sources are means over the time from `from_time_s` on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Since when impulses are counted: the last time that fields came, s.
    pub from_time_s: f64,
    /// Now, s.
    pub time_s: f64,
    /// Steps done.
    pub step: u64,
    /// Counts insertions and removals.
    pub topology_epoch: u64,
    /// 1 less the volume of the particles over that of the cell, now; below 0 where a cell smaller than a particle is
    /// overfilled.
    pub void_fraction: Vec<f64>,
    /// Mean over the solid in the cell, now, m/s; 0 where there is none.
    pub solid_velocity_m_per_s: Vec<[f64; 3]>,
    /// Force on the fluid by drag, lift and added mass over the volume of the cell, N/m3.
    pub interaction_n_per_m3: Vec<[f64; 3]>,
    /// Force on the particles by the given pressure gradient over the volume of the cell, N/m3.
    pub pressure_force_n_per_m3: Vec<[f64; 3]>,
    /// Sum of K over the volume of the cell, kg/(m3 s): by how much the interaction opposes a change of u.
    pub drag_kg_per_m3_s: Vec<f64>,
    /// What it adds up to.
    pub totals: ExchangeTotals,
}

/// Sums over particles, for a client to check conservation against.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExchangeTotals {
    /// Volume of all particles, m3.
    pub solid_volume_m3: f64,
    /// Of it, in the mesh.
    pub immersed_volume_m3: f64,
    /// Particles that are wholly outside.
    pub outside: u64,
    /// Impulse on the fluid by drag, lift and added mass since `from_time_s`, N s.
    pub impulse_on_fluid_n_s: [f64; 3],
    /// Impulse on the particles by the given pressure gradient, N s.
    pub pressure_impulse_n_s: [f64; 3],
    /// Impulse on the particles by buoyancy, N s.
    pub buoyancy_impulse_n_s: [f64; 3],
    /// Of the particles that move freely, now, kg m/s.
    pub momentum_kg_m_per_s: [f64; 3],
    /// Looks at where the particles are since the fluid was defined.
    pub refreshes: u64,
}
