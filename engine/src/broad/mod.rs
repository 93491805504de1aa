//! Broad phase: which parts may touch before anything has moved by more than half the skin.

mod cell_list;
mod neighbours;

pub use cell_list::CellList;
pub use neighbours::{NeighbourInputs, Neighbours, ShapeReach};
