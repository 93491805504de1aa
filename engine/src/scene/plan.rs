//! What a scene needs, and what is left out of every step because it does not.

use super::{
    MaterialPairDescription, NormalLaw, PointLaws, RotationScheme, SceneDescription, Sharing, Tangential, point_laws,
    stages,
};
use crate::broad::ShapeReach;
use crate::contact::law::PairTable;
use crate::shape::Shape;

/// The stages that the scene needs; set once.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// One sentence each, for `sturz check` and the topic `plan`.
    pub lines: Vec<String>,
    /// Tangential springs are kept.
    pub history: bool,
    /// Every shape is a sphere.
    pub all_spheres: bool,
    /// The sphere batch has the laws of this scene.
    pub sphere_batch: bool,
    /// Rolling and twisting springs are kept.
    pub rolling: bool,
    /// Contacts may hold beyond the touch.
    pub bonds: bool,
    /// By shape: orientation is integrated.
    pub rotates: Vec<bool>,
    /// By shape: radius of the thinnest part at unit scale, m.
    pub half_thickness: Vec<f64>,
    /// By shape: what the broad phase needs.
    pub reaches: Vec<ShapeReach>,
    /// Neighbour skin over the harmonic mean of the bounding diameters.
    pub skin_fraction: f64,
}

/// Skin where the scene names none: rebuilds and superfluous pairs cost about the same there.
const DEFAULT_SKIN_FRACTION: f64 = 0.08;

impl Plan {
    /// Whether anything of a contact outlives a step.
    pub(crate) fn keeps_springs(&self) -> bool {
        self.history || self.rolling || self.bonds
    }

    /// `point_laws`: `None` where contacts follow the plain law, which the sphere batch has.
    pub(super) fn new(
        description: &SceneDescription,
        shapes: &[Shape],
        pairs: &PairTable,
        point_laws: Option<&PointLaws>,
    ) -> Self {
        let sphere_batch = point_laws.is_none();
        let bonds = point_laws.is_some_and(PointLaws::has_bonds);
        let reaches: Vec<ShapeReach> = shapes.iter().map(ShapeReach::of).collect();
        let half_thickness = shapes.iter().map(Shape::half_thickness).collect();
        let history = matches!(description.contact.tangential, Tangential::CoulombHistory | Tangential::Mindlin)
            && pairs.any_friction();
        let turns = |pair: &MaterialPairDescription| pair.rolling_friction > 0.0 || pair.twisting_friction > 0.0;
        let rolling = description.material_pairs.iter().any(turns);
        let rotates: Vec<bool> = reaches.iter().map(|reach| !reach.is_sphere).collect();
        let skin_fraction = description.contact.skin_fraction.unwrap_or(DEFAULT_SKIN_FRACTION);
        let all_spheres = reaches.iter().all(|reach| reach.is_sphere);
        let mut lines = vec![
            format!(
                "neighbours: hierarchical grid, skin {:.1} % of the harmonic mean of the bounding diameters",
                100.0 * skin_fraction
            ),
            if all_spheres {
                "contact geometry: spheres only; no polyhedron test".into()
            } else {
                "contact geometry: separating-axis test and clipping for polyhedra, analytic for round parts".into()
            },
            sharing(description.contact.sharing).into(),
            normal_law(description),
            friction(description.contact.tangential, history, pairs),
        ];
        lines.extend(point_laws::plan_lines(description));
        lines.push(if all_spheres {
            "rotation: angular velocity only; no orientation is integrated".into()
        } else {
            match description.integrator.rotation {
                RotationScheme::Omelyan => "rotation: Omelyan's leapfrog".into(),
                RotationScheme::Splitting => "rotation: symmetric splitting about the principal axes".to_string(),
            }
        });
        lines.push(if description.domain.periodic.contains(&true) {
            format!("periodic axes (x, y, z): {:?}", description.domain.periodic)
        } else {
            "periodic axes: none; no images".into()
        });
        lines.push(match description.boundaries.len() {
            0 => "boundaries: none".into(),
            n => format!("boundaries: {n}"),
        });
        lines.extend(stages::plan_lines(description));
        lines.extend(description.inflows.iter().enumerate().map(|(k, inflow)| inflow.line(k)));
        lines.push("fields: computed only while somebody subscribes or asks".into());
        Self {
            lines,
            history,
            rolling,
            bonds,
            all_spheres,
            sphere_batch,
            rotates,
            half_thickness,
            reaches,
            skin_fraction,
        }
    }
}

fn sharing(sharing: Sharing) -> &'static str {
    match sharing {
        Sharing::PerPoint => "sharing of points: per_point",
        Sharing::ModelB => "sharing of points: model_b",
        Sharing::ModelA => "sharing of points: model_a",
        Sharing::MaxOverlapShared => "sharing of points: max_overlap_shared",
    }
}

/// The tangential law in words.
fn friction(law: Tangential, history: bool, pairs: &PairTable) -> String {
    match law {
        Tangential::Mindlin if history => "friction: Mindlin without slip, with history per contact".into(),
        Tangential::Viscous if pairs.any_friction() => "friction: viscous; no tangential history is kept".into(),
        _ if history => "friction: Coulomb with history per contact feature".into(),
        _ => "friction: none; no tangential history is kept".into(),
    }
}

/// The normal law in words.
fn normal_law(description: &SceneDescription) -> String {
    let contact = &description.contact;
    let section = &contact.generalized_overlap;
    let end = format!("contact end {:?}", contact.contact_end).to_lowercase();
    if contact.normal == NormalLaw::FeaturePairs {
        return format!("normal law: polyhedra rounded, linear spring and dashpot for each pair of features, {end}");
    }
    match description.normal_law() {
        NormalLaw::Volume => format!(
            "normal law: polyhedra by their shared volume; linear spring and dashpot where a part is round; {end}"
        ),
        NormalLaw::Linear | NormalLaw::FeaturePairs => format!("normal law: linear spring and dashpot, {end}"),
        NormalLaw::Hertz => format!("normal law: Hertz, {end}"),
        NormalLaw::GeneralizedOverlap => format!(
            "normal law: polyhedra by generalized overlap (p {}, rounded by {:.2e} of the inner diameter{}, exponent {}); linear spring and dashpot where a part is round; {end}",
            section.p,
            section.rounding_wanted(),
            if section.rounding_fraction.is_none() { " at most" } else { "" },
            section.exponent
        ),
    }
}
