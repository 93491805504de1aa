//! Persistent contacts: which pairs may touch, where they do, with what force.

mod body_sharing;
mod bonds;
mod carry;
mod effective_mass;
mod evaluate;
mod evaluate_overlap;
mod evaluate_points;
mod features;
mod find;
mod history;
pub mod law;
mod overlap;
mod rods;
mod saved;
mod sphere_batch;
mod sphere_lanes;
mod spheres;
mod table;

pub use body_sharing::{BodyPoints, share_over_bodies};
pub use evaluate::{ForceInputs, evaluate_forces};
pub use features::FeatureChunk;
pub use find::{FindInputs, find_contacts};
pub use history::SpringRecord;
pub use overlap::{OverlapChunk, OverlapContact};
pub use rods::RodChunk;
pub(crate) use saved::{SavedSlot, SavedSphere};
pub use spheres::{SpherePair, SpherePairs};
pub use table::{CHUNK, Contact, ContactChunk, ContactTable, Slot, SlotKind, Sums, Wrench};
