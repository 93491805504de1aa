//! The particles in a fluid that another program computes (a CFD code), or in one that is the same everywhere.
//!
//! **What goes both ways.** The fluid is given on a mesh: velocity u and, if wanted, pressure gradient, material
//! acceleration and vorticity. Each particle feels what it finds where it is; the mesh gets back void fraction, velocity of
//! the solid, the momentum that the particles gave, and how it would change with u.
//!
//! **One operator, both ways.** The weight w(c, p) of a particle p in a cell c is the part of its volume, spread by a smooth
//! kernel of half-width h (`smoothing_length_m`, whatever the size of the cells), that lies in the cell: of points that fill
//! the true shape, each along each axis the integral over the cell of 15/16 (1 - (x/h)^2)^2 / h. The void fraction of a cell
//! is 1 - sum_p w(c, p) V_p / V_c; the fluid at a particle is sum_c w(c, p) u_c, the transpose. Hence
//! - the weights of a particle sum to 1 (at `open` sides to the part of it that is inside), so volume and momentum are
//!   conserved to rounding, on any mesh;
//! - they change three times differentiably when a particle crosses into a cell, for any ratio of h to the cell.
//!
//! **When.** The operator is made anew when the fluid's fields come, after every `refresh_steps` steps, or when a particle
//! may have come further than a tenth of h. In between it stands, and impulses are added up per particle, exactly as the
//! particles got them.
//!
//! **Forces** (`crate::hydrodynamics`), in each step: drag K (u - v), lift and torques by the laws of the definition; -V grad p;
//! optionally -rho V g for a fluid whose pressure leaves the hydrostatic part out; added mass C rho V (Du/Dt - dv/dt), as
//! inertia. They enter both half kicks like loads (`crate::loads`), which are exact for a frozen contact force, so no K
//! limits the step. K is found once per step, with the velocity predicted there.

mod description;
mod exchange;
mod fluid;
mod mesh;
mod operator;
mod points;
mod seen;
#[cfg(test)]
mod tests;

pub use description::{AxisSides, FluidDescription, FluidFields, MeshDescription, Side};
pub use exchange::{Exchange, ExchangeTotals};
pub(crate) use fluid::{Acting, Body, Fluid, Outcome};
