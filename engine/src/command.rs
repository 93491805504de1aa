//! The closed set of changes that a client may ask of a running engine.

use crate::coupling::{FluidDescription, FluidFields};
use crate::loads::LoadDescription;
use crate::scene::{InsertionDescription, MotionDescription};

/// A change, applied between two steps: wholly or not at all.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Adds particles.
    Insert(InsertionDescription),
    /// Removes particles by id.
    Remove(Vec<u64>),
    /// Sets the acceleration of gravity, m/s2.
    SetGravity([f64; 3]),
    /// Gives a boundary another motion, from the present time on.
    SetMotion {
        /// Name of the boundary; that of a box for all its sides.
        boundary: String,
        /// Its motion.
        motion: MotionDescription,
    },
    /// Replaces the loads from outside, from the present time on.
    SetLoads(LoadDescription),
    /// Puts a fluid around the particles, or takes it away.
    SetFluid {
        /// None: away with it.
        fluid: Option<Box<FluidDescription>>,
        /// At once, on its mesh; its own velocity everywhere without them.
        fields: Option<Box<FluidFields>>,
    },
    /// Gives the fluid new fields, or none; impulses on it are counted anew from now on.
    SetFluidFields(Option<Box<FluidFields>>),
}

/// What an applied command did.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Particles with consecutive ids were added.
    Inserted {
        /// Lowest new id (the next unused one when `count` is 0).
        first_id: u64,
        /// How many.
        count: u64,
    },
    /// Particles were removed.
    Removed {
        /// How many.
        count: u64,
    },
    /// Gravity was set.
    GravitySet,
    /// The motion was set.
    MotionSet,
    /// The loads were set.
    LoadsSet,
    /// The fluid, or its fields, were set.
    FluidSet,
}
