//! How good the run is, in numbers: energy balance, overlap, step against its limits, counted troubles.

use serde::Serialize;

/// Energies and works since the start of the run, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EnergyBalance {
    /// Kinetic energy of translation.
    pub kinetic_translation_j: f64,
    /// Kinetic energy of rotation.
    pub kinetic_rotation_j: f64,
    /// Potential energy in gravity (of unwrapped positions).
    pub potential_j: f64,
    /// In normal and tangential springs.
    pub elastic_j: f64,
    /// Taken by normal dashpots, and lost when bonds (cohesion `jkr`) are made and break.
    pub dissipated_normal_j: f64,
    /// Taken by sliding and by tangential dashpots.
    pub dissipated_friction_j: f64,
    /// Taken by local damping.
    pub dissipated_local_j: f64,
    /// Done by moving boundaries on particles.
    pub work_boundaries_j: f64,
    /// Brought in by commands: insertion, removal, change of gravity.
    pub work_commands_j: f64,
    /// Done by loads from outside.
    pub work_loads_j: f64,
    /// Kinetic + potential + elastic + dissipated - work, less its value at the start: 0 when the balance closes.
    pub residual_j: f64,
}

/// Events that do not stop a run, counted since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct WarningCounts {
    /// Rotation steps whose implicit equation did not converge to the last bits: reduce the time step.
    pub rotation_not_converged: u64,
    /// Steps with an overlap above a tenth of the smaller bounding radius: raise the stiffness.
    pub large_overlap: u64,
    /// Steps with a generalized overlap above 1.5 rounding radii: raise the stiffness or the rounding fraction.
    pub deep_rounding: u64,
    /// Steps in which a particle moved by more than a tenth of its bounding radius: reduce the time step.
    pub fast_particle: u64,
}

/// Report on the state after the last step.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Steps done.
    pub step: u64,
    /// Simulated time.
    pub time_s: f64,
    /// Particles present.
    pub particles: u64,
    /// Pairs of particles that touch.
    pub touching_pairs: u64,
    /// Pairs of a particle and a boundary that touch.
    pub touching_boundary_pairs: u64,
    /// Contact points of all of these.
    pub contact_points: u64,
    /// Contact points by kind of feature: smooth, vertex-face, edge-edge.
    pub contact_points_by_kind: [u64; 3],
    /// Rebuilds of the neighbour list since the start.
    pub neighbour_rebuilds: u64,
    /// Energy balance.
    pub energy: EnergyBalance,
    /// Total momentum, kg m/s.
    pub momentum_kg_m_per_s: [f64; 3],
    /// Sum of contact forces between particles, N: 0 to rounding.
    pub internal_force_residual_n: f64,
    /// Largest overlap now, m.
    pub largest_overlap_m: f64,
    /// Largest overlap over the smaller bounding radius, now.
    pub largest_overlap_ratio: f64,
    /// Largest generalized overlap over the mean rounding radius of the pair, now; 0 with another normal law.
    pub largest_overlap_over_rounding: f64,
    /// Largest overlap over the smaller bounding radius, since the start.
    pub largest_overlap_ratio_so_far: f64,
    /// Time step in use.
    pub time_step_s: f64,
    /// Largest stable time step of a single contact.
    pub critical_time_step_s: f64,
    /// Largest stable time step of the contacts that are there now, all of a body's together: an estimate from below,
    /// infinite without contacts and under Hertz.
    pub present_critical_time_step_s: f64,
    /// Shortest duration of a collision of two particles present.
    pub contact_duration_s: f64,
    /// Counted troubles.
    pub warnings: WarningCounts,
}
