//! Torques: the pitching torque of a body in a flow, and the drag of its rotation.

mod dennis;
mod rosendahl;

pub(crate) use rosendahl::pitching_torque;

/// Law of the torque about the centre of mass that a uniform flow exerts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PitchingLaw {
    /// No torque.
    #[default]
    None,
    /// Drag and lift act at a centre of pressure on the longest axis; zero for bodies without a longest axis.
    Rosendahl,
}

/// Law of the drag of rotation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RotationalDragLaw {
    /// No torque.
    #[default]
    None,
    /// Creeping flow about the sphere of the same volume.
    Stokes,
    /// Spheres at finite Reynolds numbers of their rotation; of the same volume, where the body is none.
    Dennis,
}

impl PitchingLaw {
    /// Where the law has been measured.
    pub fn range(self) -> &'static str {
        match self {
            Self::None => "any",
            Self::Rosendahl => rosendahl::RANGE,
        }
    }

    /// Author, year, journal and equation.
    pub fn source(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rosendahl => rosendahl::SOURCE,
        }
    }
}

impl RotationalDragLaw {
    /// Where the law has been measured.
    pub fn range(self) -> &'static str {
        match self {
            Self::None => "any",
            Self::Stokes => dennis::STOKES_RANGE,
            Self::Dennis => dennis::RANGE,
        }
    }

    /// Author, year, journal and equation.
    pub fn source(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Stokes => "Lamb 1932, Hydrodynamics, art. 334",
            Self::Dennis => dennis::SOURCE,
        }
    }

    /// Torque over the relative angular velocity, N m s: 0 or pi mu d^3 times a factor of at least 1.
    #[inline]
    pub(crate) fn coefficient(self, diameter: f64, density: f64, viscosity: f64, spin: f64) -> f64 {
        let stokes = std::f64::consts::PI * viscosity * diameter * diameter * diameter;
        match self {
            Self::None => 0.0,
            Self::Stokes => stokes,
            Self::Dennis => stokes * dennis::factor(density * spin * diameter * diameter / viscosity),
        }
    }
}
