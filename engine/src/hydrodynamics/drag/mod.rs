//! Drag of one particle in an unbounded flow.
//!
//! All laws are held as the factor over Stokes' drag of the sphere of the same volume,
//! f(Re) = C_D Re / 24 with C_D based on that sphere's cross-section pi d^2 / 4, so that
//! K = 3 pi mu d f is finite at rest.

mod ganser;
mod haider_levenspiel;
mod holzer_sommerfeld;
mod schiller_naumann;
mod stokes;

pub(crate) use ganser::Ganser;
pub(crate) use haider_levenspiel::HaiderLevenspiel;
pub(crate) use holzer_sommerfeld::HolzerSommerfeld;

use super::HydroShape;
use crate::math::Vec3;

/// Law of the drag of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DragLaw {
    /// No drag, whatever the swarm.
    None,
    /// Creeping flow past the sphere of the same volume.
    Stokes,
    /// Spheres; of the same volume, where the body is none.
    SchillerNaumann,
    /// By sphericity; any orientation.
    #[default]
    HaiderLevenspiel,
    /// By sphericity; any orientation.
    Ganser,
    /// By sphericity and the areas that the body shows to the flow: depends on the orientation.
    HolzerSommerfeld,
}

impl DragLaw {
    /// Where the law has been measured.
    pub fn range(self) -> &'static str {
        match self {
            Self::None => "any",
            Self::Stokes => stokes::RANGE,
            Self::SchillerNaumann => schiller_naumann::RANGE,
            Self::HaiderLevenspiel => haider_levenspiel::RANGE,
            Self::Ganser => ganser::RANGE,
            Self::HolzerSommerfeld => holzer_sommerfeld::RANGE,
        }
    }

    /// Author, year, journal and equation.
    pub fn source(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Stokes => stokes::SOURCE,
            Self::SchillerNaumann => schiller_naumann::SOURCE,
            Self::HaiderLevenspiel => haider_levenspiel::SOURCE,
            Self::Ganser => ganser::SOURCE,
            Self::HolzerSommerfeld => holzer_sommerfeld::SOURCE,
        }
    }

    /// Whether the drag depends on how the body lies to the flow.
    pub fn depends_on_orientation(self) -> bool {
        self == Self::HolzerSommerfeld
    }

    /// f = C_D Re / 24: the drag over 3 pi mu d |w|, at the Reynolds number Re = rho |w| d / mu with d the diameter of
    /// the sphere of the same volume. `direction_in_body` is the unit direction of the relative velocity; only laws that
    /// depend on the orientation read it.
    #[inline]
    pub fn factor(self, shape: &HydroShape, direction_in_body: &Vec3, reynolds: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Stokes => 1.0,
            Self::SchillerNaumann => schiller_naumann::factor(reynolds),
            Self::HaiderLevenspiel => shape.haider_levenspiel.factor(reynolds),
            Self::Ganser => shape.ganser.factor(reynolds),
            Self::HolzerSommerfeld => {
                let lengthwise = shape.lengthwise_sphericity(direction_in_body);
                let crosswise = shape.crosswise_sphericity(direction_in_body);
                shape.holzer_sommerfeld.factor(reynolds, lengthwise, crosswise)
            }
        }
    }
}
