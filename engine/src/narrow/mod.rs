//! Contact geometry: which points of two parts touch, where, how deep, and along which normal.

mod manifold;

pub use manifold::{FeatureKey, MAX_POINTS, Manifold, ManifoldPoint};
