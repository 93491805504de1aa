//! Contacts of rounded polyhedra, one for each pair of features of their skeletons that is close enough.
//!
//! A pair of features at distance d < R = r_a + r_b touches with the overlap R - d:
//!
//! | pair | where |
//! |---|---|
//! | vertex, face | the foot of the vertex lies inside the face |
//! | edge, edge | the feet of the common perpendicular lie strictly inside both edges |
//! | vertex, edge | the foot lies strictly inside the edge, outside the faces that meet there, and in the region of space that is nearest to the vertex among its own edges |
//! | vertex, vertex | each lies in the region that is nearest to the other among its own edges and faces |
//!
//! Source: Richefeu's Rockable. That leaves out the vertex's own region in the third row, so that a vertex and an edge
//! beside it are both active where only one of them will be dropped: up to 11 % of the energy of an impact.
//! A sphere is a skeleton of one vertex, a spherocylinder one of one edge, a sharp polyhedron one of radius 0.

mod list;
mod pair;
mod separation;
#[cfg(test)]
mod tests;

pub use list::{FeatureList, FeatureScratch};
pub use pair::{FeatureContact, FeaturePair};
