//! Contact laws, one file each: how strong a contact of given geometry and velocity is.

mod cohesion;
mod generalized_overlap;
mod hertz;
mod jkr;
mod linear;
mod material;
mod mindlin;
mod restitution;
mod rolling;
mod sharing;
mod tangential;
mod viscous;

pub use cohesion::CohesionLaw;
pub use generalized_overlap::{Exponent, OverlapLaw, OverlapSpring, rocking_force};
pub use hertz::{Elastic, HertzPair};
pub use jkr::Jkr;
pub use linear::{NormalForce, normal_force};
pub use material::{PairLaw, PairTable};
pub use mindlin::{mindlin, mindlin_stiffness};
pub use restitution::{damping_ratio, least_restitution, restitution};
pub use rolling::{Resistance, RollingLaw, RollingSpring, resist_rolling, resist_twisting};
pub use sharing::share_stiffness;
pub use tangential::{Slide, TangentialForce, TorsionForce, coulomb_history, torsion_history};
pub use viscous::viscous;
