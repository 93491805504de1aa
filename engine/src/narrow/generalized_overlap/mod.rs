//! The overlap of two rounded polyhedra as one number that is a smooth function of their pose.
//!
//! A rounded polyhedron is a core, the solid with every face moved inwards by r, and a ball of radius r swept over it:
//! faces stay where they were, edges and corners recede. Every pair of close features (vertex and core, edge and
//! edge) has an overlap d_i = r_a + r_b - distance and a weight w_i in [0, 1]; the generalized overlap is their p-norm
//!
//! D = (sum w_i d_i^p)^(1/p),
//!
//! and a potential W(D) gives forces and torques as its gradient: conservative, several points where faces meet,
//! stiff at corners, and without a jump where a contact slides over a rim. Which terms may matter is remembered from
//! step to step ([`ActiveTerms`]) by a bound on the relative motion that the bits cannot see.

mod active;
mod core;
mod edges;
mod norm;
mod pair;
#[cfg(test)]
mod tests;
mod wall;

pub use active::{ActiveTerms, Scratch};
pub use core::Core;
pub use edges::EdgeFade;
pub use norm::{Overlap, OverlapPoint, PNorm, aggregate};
pub use pair::{RoundedPair, Term, TermCode};
pub use wall::{polyhedron_cylinder, polyhedron_plane};

/// Parameters of the overlap: the exponent of the norm, and how edge pairs fade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapGeometry {
    /// The p-norm.
    pub norm: PNorm,
    /// The weight of edge pairs.
    pub fade: EdgeFade,
}
