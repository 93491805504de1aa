//! Broad phase: which parts may touch before anything has moved by more than half the skin.

mod adjacency;
mod cell_list;
mod levels;
mod neighbours;
mod search;
#[cfg(test)]
mod tests;

pub use adjacency::Entry;
pub use cell_list::CellList;
pub use neighbours::{NeighbourInputs, Neighbours, ShapeReach};
