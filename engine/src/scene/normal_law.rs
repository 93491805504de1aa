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
    /// Polyhedra by the volume that they share, W = k/2 (V/A)^2, A the largest face of the smaller-faced part: a potential
    /// without any rounding, but soft where corners meet, and without a torque against tilting of a full face contact.
    Volume,
    /// Polyhedra rounded a little, as with `generalized_overlap`, and a linear spring for each pair of close features.
    FeaturePairs,
    /// Round parts after Hertz, from the elastic constants of the materials.
    Hertz,
}

impl NormalLaw {
    /// Whether the contact of two polyhedra is one number with a potential.
    pub fn is_by_overlap(self) -> bool {
        matches!(self, Self::GeneralizedOverlap | Self::Volume)
    }
}

/// What a polyhedron meets planes with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WallOverlap {
    /// The p-norm of the depths of its vertices.
    #[default]
    Vertices,
    /// A bed of springs under it (Winkler): W = k/(2 A) times the integral of the squared depth over the plane, A its
    /// largest face. Smoother still, and soft at corners. Drums are met with the vertices.
    Winkler,
}

/// `[contact.feature_pairs]`
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FeaturePairsSection {
    /// As that of `[contact.generalized_overlap]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounding_fraction: Option<f64>,
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
    /// What polyhedra meet planes with.
    pub walls: WallOverlap,
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
            walls: WallOverlap::Vertices,
        }
    }
}

/// What a scene with `normal = "generalized_overlap"` needs beyond a linear one.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundedShapes {
    /// By shape and part; `None` for round parts.
    pub cores: Vec<Vec<Option<Core>>>,
    /// What the overlap of two parts is; `None` for their shared volume.
    pub geometry: Option<OverlapGeometry>,
    /// What it is at planes, where it is not the volume.
    pub walls: WallOverlap,
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
        let normal = description.normal_law();
        if !normal.is_by_overlap() {
            return None;
        }
        let section = &description.contact.generalized_overlap;
        let mut core = |shape: usize, part: usize, geometry: &PartGeometry| {
            let PartGeometry::Polyhedron(solid) = geometry else { return None };
            if normal == NormalLaw::Volume {
                return Some(Core::sharp(solid));
            }
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
        let norm = OverlapGeometry { norm: PNorm::new(section.p), fade };
        let (geometry, law) = match normal {
            // several points of it are one face: nothing rocks between them
            NormalLaw::Volume => (None, OverlapLaw { exponent: Exponent::One, reference_fraction: 1.0, rocking: 0.0 }),
            _ => (
                Some(norm),
                OverlapLaw {
                    exponent: if section.exponent == 1.0 { Exponent::One } else { Exponent::ThreeHalves },
                    reference_fraction: section.reference_overlap_fraction,
                    rocking: section.rocking_damping,
                },
            ),
        };
        Some(Self { cores, geometry, walls: section.walls, law })
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
            law if law.is_by_overlap() && !self.shapes.iter().any(|shape| shape.geometry.has_sharp_part()) => {
                NormalLaw::Linear
            }
            // the law of its points; the rounding is the shapes'
            NormalLaw::FeaturePairs => NormalLaw::Linear,
            law => law,
        }
    }
}

/// The core of a part, rounded as asked for; without a wish by as much as the part allows.
pub(super) fn core(solid: &Polyhedron, rounding_fraction: Option<f64>) -> Result<Core, String> {
    let Some(fraction) = rounding_fraction else {
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

impl FeaturePairsSection {
    /// Whether it says what an absent section says.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The shapes with their sharp parts rounded, for contact; mass properties stay those of the sharp ones.
    pub(super) fn round(
        &self,
        description: &SceneDescription,
        shapes: Vec<Shape>,
        errors: &mut Vec<InvalidInput>,
    ) -> Vec<Shape> {
        if description.contact.normal != NormalLaw::FeaturePairs {
            return shapes;
        }
        let fraction = self.rounding_fraction;
        if let Some(fraction) = fraction.filter(|fraction| !(1e-6..=0.25).contains(fraction)) {
            let problem = format!("is {fraction}; must be in [1e-6, 0.25]");
            errors.push(InvalidInput::new("contact.feature_pairs.rounding_fraction", problem));
            return shapes;
        }
        let round = |(k, shape): (usize, Shape)| {
            shape
                .with_rounded_parts(|solid| core(solid, fraction).map(|core| (core.solid().clone(), core.radius)))
                .unwrap_or_else(|reason| {
                    let name = &description.shapes[k].name;
                    let problem = format!("cannot round shape '{name}': {reason}");
                    errors.push(InvalidInput::new("contact.feature_pairs", problem));
                    shape
                })
        };
        shapes.into_iter().enumerate().map(round).collect()
    }
}

impl GeneralizedOverlapSection {
    fn core(&self, solid: &Polyhedron) -> Result<Core, String> {
        core(solid, self.rounding_fraction)
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
