//! What may be sampled: names, units, shapes, and which sums each quantity needs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::layout::Group;

/// A coarse-grained quantity. phi is the kernel at the distance of a point from a particle; sums run over particles or
/// contacts. Tensors have 9 components, row-major; stresses are positive in compression. What is divided by a density is
/// 0 where that is 0. `docs/fields.md` has all formulas and sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldQuantity {
    /// Sum of V phi, the volume of each particle at its centre; 1 component.
    SolidFraction,
    /// Volume of the particles, spread over their true shapes, per volume; 1 component.
    SolidFractionOfShapes,
    /// Sum of m phi, kg/m3, 1 component.
    Density,
    /// Sum of phi, 1/m3, 1 component.
    NumberDensity,
    /// Sum of m v phi, kg/(m2 s), 3 components.
    Momentum,
    /// Momentum over density, m/s, 3 components.
    Velocity,
    /// Mean of the angular velocities weighted by mass, rad/s, 3 components.
    AngularVelocity,
    /// dV_a/dx_b, 1/s, 9 components.
    VelocityGradient,
    /// sqrt(2 S:S) with S the deviatoric symmetric part of the velocity gradient, 1/s, 1 component.
    ShearRate,
    /// Sum of f b times the integral of phi along the branch b, between particles and at boundaries, Pa, 9 components.
    ContactStress,
    /// Its part between particles, Pa, 9 components.
    ContactStressPairs,
    /// Its part at boundaries, Pa, 9 components.
    ContactStressBoundaries,
    /// Sum of m v' v' phi with v' = v - V(r), Pa, 9 components.
    KineticStress,
    /// The same with v' = v - V(r_i), the field at the particle, Pa, 9 components.
    KineticStressAboutParticles,
    /// T^gamma_ab = rho D_kl dV_a/dx_k dV_b/dx_l: what shear within the kernel's reach adds, Pa, 9 components.
    KineticStressOfGradient,
    /// T^k = kinetic stress - T^gamma, Pa, 9 components.
    KineticStressScaleFree,
    /// Sum over particles of the flux of momentum by their rotation, Pa, 9 components.
    KineticStressOfRotation,
    /// Contact and kinetic stress together, Pa, 9 components.
    Stress,
    /// A third of the trace of that, Pa, 1 component.
    Pressure,
    /// D_kl: mean of (r - r_i)_k (r - r_i)_l weighted by m phi, m2, 9 components.
    SecondMoment,
    /// tr(kinetic stress) / (3 density), m2/s2, 1 component.
    GranularTemperature,
    /// Mean of (3 n n - 1) / 2 over the particles' axes n, 9 components.
    Orientation,
    /// Mean number of touching neighbours, 8 components: all, particles, boundaries; and of all by kind: smooth,
    /// vertex on face, edge on edge, manifold, overlap.
    Coordination,
    /// Shear rate times mean diameter times sqrt(density of the particles / pressure), 1 component.
    InertialNumber,
    /// Force of the particles on boundaries per volume, N/m3, 3 components.
    WallForceDensity,
}

impl FieldQuantity {
    /// All of them.
    pub const ALL: [Self; 25] = [
        Self::SolidFraction,
        Self::SolidFractionOfShapes,
        Self::Density,
        Self::NumberDensity,
        Self::Momentum,
        Self::Velocity,
        Self::AngularVelocity,
        Self::VelocityGradient,
        Self::ShearRate,
        Self::ContactStress,
        Self::ContactStressPairs,
        Self::ContactStressBoundaries,
        Self::KineticStress,
        Self::KineticStressAboutParticles,
        Self::KineticStressOfGradient,
        Self::KineticStressScaleFree,
        Self::KineticStressOfRotation,
        Self::Stress,
        Self::Pressure,
        Self::SecondMoment,
        Self::GranularTemperature,
        Self::Orientation,
        Self::Coordination,
        Self::InertialNumber,
        Self::WallForceDensity,
    ];

    /// As in scene files and of columns.
    pub fn name(self) -> &'static str {
        self.described().0
    }

    /// Empty for pure numbers.
    pub fn unit(self) -> &'static str {
        self.described().1
    }

    /// Numbers per cell.
    pub fn components(self) -> usize {
        self.described().2
    }

    fn described(self) -> (&'static str, &'static str, usize) {
        match self {
            Self::SolidFraction => ("solid_fraction", "", 1),
            Self::SolidFractionOfShapes => ("solid_fraction_of_shapes", "", 1),
            Self::Density => ("density", "kg/m3", 1),
            Self::NumberDensity => ("number_density", "1/m3", 1),
            Self::Momentum => ("momentum", "kg/(m2 s)", 3),
            Self::Velocity => ("velocity", "m/s", 3),
            Self::AngularVelocity => ("angular_velocity", "rad/s", 3),
            Self::VelocityGradient => ("velocity_gradient", "1/s", 9),
            Self::ShearRate => ("shear_rate", "1/s", 1),
            Self::ContactStress => ("contact_stress", "Pa", 9),
            Self::ContactStressPairs => ("contact_stress_pairs", "Pa", 9),
            Self::ContactStressBoundaries => ("contact_stress_boundaries", "Pa", 9),
            Self::KineticStress => ("kinetic_stress", "Pa", 9),
            Self::KineticStressAboutParticles => ("kinetic_stress_about_particles", "Pa", 9),
            Self::KineticStressOfGradient => ("kinetic_stress_of_gradient", "Pa", 9),
            Self::KineticStressScaleFree => ("kinetic_stress_scale_free", "Pa", 9),
            Self::KineticStressOfRotation => ("kinetic_stress_of_rotation", "Pa", 9),
            Self::Stress => ("stress", "Pa", 9),
            Self::Pressure => ("pressure", "Pa", 1),
            Self::SecondMoment => ("second_moment", "m2", 9),
            Self::GranularTemperature => ("granular_temperature", "m2/s2", 1),
            Self::Orientation => ("orientation", "", 9),
            Self::Coordination => ("coordination", "", 8),
            Self::InertialNumber => ("inertial_number", "", 1),
            Self::WallForceDensity => ("wall_force_density", "N/m3", 3),
        }
    }

    /// The quantity of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.name() == name)
    }

    /// Sums that it is made of.
    pub(super) fn groups(self) -> &'static [Group] {
        use Group::{
            Axes, BoundaryStress, Coordination, Diameter, Kinetic, Mass, MassGradient, Momentum, MomentumGradient,
            Number, PairStress, Peculiar, Rotational, SecondMoment, ShapeVolume, Spin, Volume, WallForce,
        };
        match self {
            Self::SolidFraction => &[Volume],
            Self::SolidFractionOfShapes => &[ShapeVolume],
            Self::Density => &[Mass],
            Self::NumberDensity => &[Number],
            Self::Momentum | Self::Velocity => &[Mass, Momentum],
            Self::AngularVelocity => &[Mass, Spin],
            Self::VelocityGradient | Self::ShearRate => &[Mass, Momentum, MassGradient, MomentumGradient],
            Self::ContactStress => &[PairStress, BoundaryStress],
            Self::ContactStressPairs => &[PairStress],
            Self::ContactStressBoundaries => &[BoundaryStress],
            Self::KineticStress | Self::GranularTemperature => &[Mass, Momentum, Kinetic],
            Self::KineticStressAboutParticles => &[Peculiar],
            Self::KineticStressOfGradient => &[Mass, Momentum, MassGradient, MomentumGradient, SecondMoment],
            Self::KineticStressScaleFree => &[Mass, Momentum, Kinetic, MassGradient, MomentumGradient, SecondMoment],
            Self::KineticStressOfRotation => &[Rotational],
            Self::Stress | Self::Pressure => &[Mass, Momentum, Kinetic, PairStress, BoundaryStress],
            Self::SecondMoment => &[Mass, SecondMoment],
            Self::Orientation => &[Number, Axes],
            Self::Coordination => &[Number, Coordination],
            Self::InertialNumber => &[
                Mass,
                Volume,
                Number,
                Diameter,
                Momentum,
                Kinetic,
                MassGradient,
                MomentumGradient,
                PairStress,
                BoundaryStress,
            ],
            Self::WallForceDensity => &[WallForce],
        }
    }

    /// Whether it takes contacts.
    pub fn needs_contacts(self) -> bool {
        self.groups().iter().any(|group| group.is_of_contacts())
    }

    /// Whether it takes the gradient of the kernel.
    pub(super) fn needs_gradient(self) -> bool {
        self.groups().contains(&Group::MassGradient)
    }
}
