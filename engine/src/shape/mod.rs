//! Shapes of particles. (Placeholder until the branch `geometry` lands.)

/// Placeholder.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeDescription {
    /// Ball.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
}
