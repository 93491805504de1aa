//! Contact laws, one file each: how strong a contact of given geometry and velocity is.

mod generalized_overlap;
mod linear;
mod material;
mod restitution;
mod sharing;
mod tangential;

pub use generalized_overlap::{Exponent, OverlapLaw, OverlapSpring, rocking_force};
pub use linear::{NormalForce, normal_force};
pub use material::{PairLaw, PairTable};
pub use restitution::{damping_ratio, least_restitution, restitution};
pub use sharing::share_stiffness;
pub use tangential::{TangentialForce, TorsionForce, coulomb_history, torsion_history};
