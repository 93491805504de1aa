//! From what a user wrote to what the engine can run.

mod auto_step;
mod boundaries;
mod check;
mod description;
mod files;
mod inflow;
mod normal_law;
mod output;
mod plan;
mod point_laws;
mod resolution;
mod scale;
mod stages;
mod start;
mod validate;
pub(crate) use boundaries::check_motion;

pub use check::SceneCheck;
pub use description::*;
pub use inflow::InflowDescription;
pub use normal_law::{FeaturePairsSection, GeneralizedOverlapSection, NormalLaw, RoundedShapes, WallOverlap};
pub use output::{OutputSection, Pace};
pub use plan::Plan;
pub use point_laws::{
    CohesionDescription, DampingMass, HertzSection, PairExtras, PointLaws, PointNormal, SharingScope,
};
pub(crate) use scale::ScaleSampler;
pub use scale::{ScaleLaw, ScaleLawName, ScaleSection};
pub use stages::StageDescription;
pub use start::{FileBytes, StartSection};
pub use validate::Scene;
