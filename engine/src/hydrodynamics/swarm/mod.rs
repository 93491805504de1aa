//! How the drag of one particle changes among others.
//!
//! **Convention.** Every law here gives K of model A (Gidaspow 1994, set A; Zhou et al. 2010, J. Fluid Mech. 661, 482,
//! set II): the force on a particle of volume V is K (u - v) - V grad p + ..., u is the interstitial velocity, and the
//! drag leaves the mean pressure gradient out. The momentum balance of the fluid at rest in a bed at rest is then
//! eps (-dp/dx) = n K u, with n = (1 - eps)/V particles per volume. A law that gives the *whole* force F_t = K u - V
//! dp/dx of that balance has, with n V = 1 - eps, K u = eps F_t.
//!
//! Symbols: eps void fraction, phi = 1 - eps, w = u - v, Re = eps rho |w| d / mu (of the superficial velocity eps w; all
//! five laws have this one), d diameter of the sphere of the same volume, psi sphericity, f(Re) the one-particle law over
//! Stokes' drag 3 pi mu d.

mod beetstra;
mod di_felice;
mod gidaspow;
mod tenneti;

use super::drag::DragLaw;
use super::{HydroShape, STOKES};
use crate::math::Vec3;

/// Below this void fraction the laws are taken at it: no packing of grains is denser, and they go to infinity at 0.
pub const LEAST_VOID_FRACTION: f64 = 0.2;

/// Law of the drag in a swarm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VoidageLaw {
    /// The drag of one particle, whatever the void fraction; Re is then rho |w| d / mu.
    None,
    /// A power of the void fraction times the one-particle law.
    #[default]
    DiFelice,
    /// Ergun's law in dense beds, Wen and Yu's power of the void fraction in dilute ones.
    Gidaspow,
    /// Fit to particle-resolved simulations, about the one-particle law.
    Tenneti,
    /// Fit to lattice-Boltzmann simulations of spheres; has no one-particle law in it.
    Beetstra,
}

/// What a law of the swarm asks for.
pub(crate) struct Swarm<'a> {
    pub drag: DragLaw,
    pub shape: &'a HydroShape,
    /// Unit, of the relative velocity, in the body frame.
    pub direction: &'a Vec3,
    /// From [`LEAST_VOID_FRACTION`] to 1.
    pub void_fraction: f64,
    /// Of the superficial velocity.
    pub reynolds: f64,
}

impl Swarm<'_> {
    /// f(Re).
    #[inline]
    fn alone(&self) -> f64 {
        self.drag.factor(self.shape, self.direction, self.reynolds)
    }
}

impl VoidageLaw {
    /// Where the law has been measured.
    pub fn range(self) -> &'static str {
        match self {
            Self::None => "dilute: void fraction above about 0.99",
            Self::DiFelice => di_felice::RANGE,
            Self::Gidaspow => gidaspow::RANGE,
            Self::Tenneti => tenneti::RANGE,
            Self::Beetstra => beetstra::RANGE,
        }
    }

    /// Author, year, journal and equation.
    pub fn source(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::DiFelice => di_felice::SOURCE,
            Self::Gidaspow => gidaspow::SOURCE,
            Self::Tenneti => tenneti::SOURCE,
            Self::Beetstra => beetstra::SOURCE,
        }
    }

    /// Whether the one-particle law matters: not for Beetstra's law.
    pub fn uses_drag_law(self) -> bool {
        self != Self::Beetstra
    }

    /// K over Stokes' 3 pi mu d. `reynolds_alone` is rho |w| d / mu.
    #[inline]
    pub(crate) fn factor(
        self,
        drag: DragLaw,
        shape: &HydroShape,
        direction: &Vec3,
        void_fraction: f64,
        reynolds_alone: f64,
    ) -> f64 {
        if self == Self::None || drag == DragLaw::None {
            return drag.factor(shape, direction, reynolds_alone);
        }
        let void_fraction = void_fraction.clamp(LEAST_VOID_FRACTION, 1.0);
        let swarm = Swarm { drag, shape, direction, void_fraction, reynolds: void_fraction * reynolds_alone };
        match self {
            Self::None => swarm.alone(),
            Self::DiFelice => di_felice::factor(&swarm),
            Self::Gidaspow => gidaspow::factor(&swarm),
            Self::Tenneti => tenneti::factor(&swarm),
            Self::Beetstra => beetstra::factor(&swarm),
        }
    }
}

/// pi d^3/6 over 3 pi d d^2: the volume of the sphere over Stokes' drag, both without their d.
const VOLUME_OVER_STOKES: f64 = std::f64::consts::PI / 6.0 / STOKES;
