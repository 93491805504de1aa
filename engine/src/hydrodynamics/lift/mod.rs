//! Lift: the force across the relative velocity.

mod cross_flow;
mod saffman_mei;

pub(crate) use cross_flow::cross_flow;
pub(crate) use saffman_mei::saffman_mei;

/// Law of the lift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LiftLaw {
    /// No lift.
    #[default]
    None,
    /// Of a sphere in a shear flow; needs the vorticity.
    SaffmanMei,
    /// Of an inclined elongated body, from its drag; zero for bodies without a longest axis.
    CrossFlow,
}

impl LiftLaw {
    /// Where the law has been measured.
    pub fn range(self) -> &'static str {
        match self {
            Self::None => "any",
            Self::SaffmanMei => saffman_mei::RANGE,
            Self::CrossFlow => cross_flow::RANGE,
        }
    }

    /// Author, year, journal and equation.
    pub fn source(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::SaffmanMei => saffman_mei::SOURCE,
            Self::CrossFlow => cross_flow::SOURCE,
        }
    }
}
