//! `[contact] normal`: which law gives the normal force, and the parameters of `generalized_overlap`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SceneDescription;
use crate::contact::law::{Exponent, OverlapLaw};
use crate::error::InvalidInput;
use crate::narrow::generalized_overlap::{Core, EdgeFade, OverlapGeometry, PNorm};
use crate::shape::{PartGeometry, Polyhedron, Shape};

/// Law of the normal force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NormalLaw {
    /// Spring and dashpot in each contact point.
    Linear,
    /// Polyhedra are rounded a little and meet by a potential of the generalized overlap D; pairs with a part of
    /// another kind as with `linear`. The default: it is the only law here that keeps the energy of every kind of hit
    /// between polyhedra, gives the restitution asked for in all of them, and lets stacks come to rest.
    #[default]
    GeneralizedOverlap,
    /// Round parts after Hertz, from the elastic constants of the materials.
    Hertz,
}

/// `[contact.generalized_overlap]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GeneralizedOverlapSection {
    /// Exponent of the norm over the overlaps of features.
    pub p: f64,
    /// Rounding radius r of each convex part over its inner diameter, twice the distance of its centroid from the
    /// nearest face (the edge of a cube, the thickness of a plate). When absent 0.02, or less for a part that would
    /// lose a face.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounding_fraction: Option<f64>,
    /// c1: edge pairs have full weight from the sine c1 (r_a + r_b) / length of the shorter edge on.
    pub edge_angle_factor: f64,
    /// c2: edge pairs have no weight when their lines come closest c2 (r_a + r_b) beyond an end.
    pub edge_fade_factor: f64,
    /// beta: strength of the dashpots on the differences between points, over that of the normal dashpot.
    pub rocking_damping: f64,
    /// 1: F = k D. 1.5: F = k D sqrt(D / D0), which integrates 5 to 10 times more accurately at the same step.
    pub exponent: f64,
    /// D0 over the sum of the rounding radii of a pair (the one radius at a wall); to be near the deepest overlap of
    /// the scene, because the critical step holds up to there. Unused with exponent 1.
    pub reference_overlap_fraction: f64,
}

impl Default for GeneralizedOverlapSection {
    fn default() -> Self {
        Self {
            p: 8.0,
            rounding_fraction: None,
            edge_angle_factor: 2.0,
            edge_fade_factor: 0.5,
            rocking_damping: 1.0,
            exponent: 1.0,
            reference_overlap_fraction: 0.8,
        }
    }
}

/// What a scene with `normal = "generalized_overlap"` needs beyond a linear one.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundedShapes {
    /// By shape and part; `None` for round parts.
    pub cores: Vec<Vec<Option<Core>>>,
    /// Parameters of the overlap.
    pub geometry: OverlapGeometry,
    /// From overlap to force.
    pub law: OverlapLaw,
}

impl RoundedShapes {
    /// Whether all parts of a shape, some, or none are rounded.
    pub fn has_core(&self, shape: usize) -> bool {
        self.cores[shape].iter().any(Option::is_some)
    }

    /// Of a validated description; an error for each part that cannot be rounded so much.
    pub(super) fn build(
        description: &SceneDescription,
        shapes: &[Shape],
        errors: &mut Vec<InvalidInput>,
    ) -> Option<Self> {
        if description.normal_law() != NormalLaw::GeneralizedOverlap {
            return None;
        }
        let section = &description.contact.generalized_overlap;
        let mut core = |shape: usize, part: usize, geometry: &PartGeometry| {
            let PartGeometry::Polyhedron(solid) = geometry else { return None };
            section
                .core(solid)
                .map_err(|reason| {
                    let name = &description.shapes[shape].name;
                    let (path, problem) = match section.rounding_fraction {
                        Some(_) => (
                            "contact.generalized_overlap.rounding_fraction",
                            format!("is too large for part {part} of shape '{name}': {reason}"),
                        ),
                        None => (
                            "contact.normal",
                            format!(
                                "part {part} of shape '{name}' cannot be rounded: {reason}; give normal = \"linear\""
                            ),
                        ),
                    };
                    errors.push(InvalidInput::new(path, problem));
                })
                .ok()
        };
        let cores = shapes
            .iter()
            .enumerate()
            .map(|(s, shape)| shape.parts().iter().enumerate().map(|(k, part)| core(s, k, &part.geometry)).collect())
            .collect();
        let fade = EdgeFade { angle_factor: section.edge_angle_factor, reach_factor: section.edge_fade_factor };
        let geometry = OverlapGeometry { norm: PNorm::new(section.p), fade };
        let law = OverlapLaw {
            exponent: if section.exponent == 1.0 { Exponent::One } else { Exponent::ThreeHalves },
            reference_fraction: section.reference_overlap_fraction,
            rocking: section.rocking_damping,
        };
        Some(Self { cores, geometry, law })
    }
}

/// Rounding over the inner diameter where the scene names none: overlaps of 4 % of the thickness are within the law.
const DEFAULT_ROUNDING: f64 = 0.02;
/// The least that a part with tiny faces may be rounded by.
const LEAST_ROUNDING: f64 = 1e-4;

impl SceneDescription {
    /// The normal law in effect: without polyhedra that could meet by generalized overlap the linear one.
    pub fn normal_law(&self) -> NormalLaw {
        match self.contact.normal {
            NormalLaw::GeneralizedOverlap if !self.shapes.iter().any(|shape| shape.geometry.has_sharp_part()) => {
                NormalLaw::Linear
            }
            law => law,
        }
    }
}

impl GeneralizedOverlapSection {
    /// The core of a part, rounded as asked for; without a wish by as much as the part allows.
    fn core(&self, solid: &Polyhedron) -> Result<Core, String> {
        let Some(fraction) = self.rounding_fraction else {
            let mut fraction = DEFAULT_ROUNDING;
            loop {
                match Core::new(solid, fraction) {
                    Err(_) if fraction > LEAST_ROUNDING => fraction = LEAST_ROUNDING.max(0.5 * fraction),
                    outcome => return outcome,
                }
            }
        };
        Core::new(solid, fraction)
    }

    /// Rounding over the inner diameter, where no part stands against it.
    pub(super) fn rounding_wanted(&self) -> f64 {
        self.rounding_fraction.unwrap_or(DEFAULT_ROUNDING)
    }

    /// Whether it says what an absent section says.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Everything that is out of range.
    pub(super) fn check(&self) -> Vec<InvalidInput> {
        let within = |low: f64, x: f64, high: f64| (low..=high).contains(&x);
        let rounding = self.rounding_wanted();
        let exponent = self.exponent == 1.0 || self.exponent == 1.5;
        let checks = [
            ("p", self.p, "in [2, 64]", within(2.0, self.p, 64.0)),
            ("rounding_fraction", rounding, "in [1e-6, 0.25]", within(1e-6, rounding, 0.25)),
            ("edge_angle_factor", self.edge_angle_factor, "in [0.1, 100]", within(0.1, self.edge_angle_factor, 100.0)),
            ("edge_fade_factor", self.edge_fade_factor, "in [0.05, 100]", within(0.05, self.edge_fade_factor, 100.0)),
            ("rocking_damping", self.rocking_damping, "in [0, 10]", within(0.0, self.rocking_damping, 10.0)),
            ("exponent", self.exponent, "1 or 1.5", exponent),
            (
                "reference_overlap_fraction",
                self.reference_overlap_fraction,
                "in [1e-6, 1]",
                within(1e-6, self.reference_overlap_fraction, 1.0),
            ),
        ];
        let wrong = checks.into_iter().filter(|(_, _, _, ok)| !ok);
        wrong
            .map(|(key, value, allowed, _)| {
                InvalidInput::new(
                    format!("contact.generalized_overlap.{key}"),
                    format!("is {value}; must be {allowed}"),
                )
            })
            .collect()
    }
}
