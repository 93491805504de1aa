//! Laws of point contacts beyond the plain one: what a scene may name, and what the engine reads.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{BoundaryGeometry, MaterialPairDescription, NormalLaw, SceneDescription, Sharing, Tangential};
use crate::contact::law::{CohesionLaw, Elastic, HertzPair, PairLaw, RollingLaw};
use crate::error::InvalidInput;
use crate::particles::Particles;
use crate::shape::{Part, PartGeometry, Shape};

/// Mass that the damping is calibrated for, where it is given as restitution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DampingMass {
    /// Of a central hit: the reduced mass of the pair.
    #[default]
    Central,
    /// Of the contact as it is, rotation included: off-centre hits restitute as asked too.
    Contact,
}

/// Whose points share the stiffness of a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SharingScope {
    /// Those of two convex parts.
    #[default]
    Parts,
    /// All of two bodies, as the sources of `model_b` and `max_overlap_shared` have it; for these two only.
    Bodies,
}

/// Attraction between two materials that touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum CohesionDescription {
    /// The same force at any overlap.
    Constant {
        /// Per pair of convex parts.
        force_n: f64,
    },
    /// Energy density times the area of contact 2 pi R d.
    Sjkr {
        /// Energy density.
        energy_density_j_per_m3: f64,
    },
    /// Johnson, Kendall and Roberts, with `normal = "hertz"`: made at the touch, held beyond it until it breaks.
    Jkr {
        /// Twice the surface energy of equal materials.
        work_of_adhesion_j_per_m2: f64,
    },
}

impl CohesionDescription {
    /// What attracts nothing costs nothing: it is left out as if it had not been named.
    fn attracts(&self) -> bool {
        let (Self::Constant { force_n: strength }
        | Self::Sjkr { energy_density_j_per_m3: strength }
        | Self::Jkr { work_of_adhesion_j_per_m2: strength }) = self;
        *strength != 0.0
    }
}

/// `[contact.hertz]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HertzSection {
    /// Overlap over the effective radius up to which the critical time step holds (the contact stiffens with load),
    /// and at which rolling resistance takes its stiffness.
    pub reference_overlap_fraction: f64,
}

impl Default for HertzSection {
    fn default() -> Self {
        Self { reference_overlap_fraction: 0.01 }
    }
}

impl HertzSection {
    /// Whether it says what an absent section says.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Least neighbour skin over the widest gap that a bond holds over.
const BEYOND_BONDS: f64 = 1.01;

/// Normal law of point contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointNormal {
    /// Linear.
    Linear,
    /// Hertz.
    Hertz,
}

/// What a pair of materials has beyond its [`PairLaw`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairExtras {
    /// Moduli; unused with a linear law.
    pub hertz: HertzPair,
    /// Raw tangential dashpot, N s/m.
    pub tangential_damping: Option<f64>,
    /// Rolling and twisting resistance.
    pub rolling: RollingLaw,
    /// Cohesion.
    pub cohesion: CohesionLaw,
}

/// Laws of a scene that names more than the plain law.
#[derive(Clone, Debug, PartialEq)]
pub struct PointLaws {
    /// Normal law.
    pub normal: PointNormal,
    /// What damping is calibrated for.
    pub damping_mass: DampingMass,
    /// The springs of several points add.
    pub springs_add: bool,
    /// Overlap over the effective radius that bounds hold for, with Hertz.
    pub reference_fraction: f64,
    /// Some law reads the radius of the parts.
    pub reads_radius: bool,
    /// Some pair resists rolling or twisting.
    pub rolling: bool,
    /// By shape and part, at unit scale: radius of a round part or a cylinder, bounding radius of a polyhedron, m.
    pub part_radius: Vec<Vec<f64>>,
    materials: usize,
    pairs: Vec<PairExtras>,
}

impl PointLaws {
    /// Of a checked description; `None` where the plain law does.
    pub(super) fn build(description: &SceneDescription, shapes: &[Shape]) -> Option<Self> {
        let contact = &description.contact;
        let named = description.normal_law() == NormalLaw::Hertz
            || contact.damping_mass != DampingMass::Central && shapes.iter().any(|shape| !is_ball(shape))
            || contact.sharing == Sharing::ModelA
            || contact.tangential == Tangential::Viscous
            || description.material_pairs.iter().any(has_extras);
        if !named {
            return None;
        }
        let materials = description.materials.len();
        let mut pairs = vec![PairExtras::default(); materials * materials];
        for pair in &description.material_pairs {
            let index = |name: &String| description.materials.iter().position(|material| material.name == *name);
            let [Some(a), Some(b)] = pair.materials.each_ref().map(index) else { continue };
            let extras = pair_extras(pair, description, [a, b]);
            (pairs[a * materials + b], pairs[b * materials + a]) = (extras, extras);
        }
        Some(Self {
            normal: if description.normal_law() == NormalLaw::Hertz { PointNormal::Hertz } else { PointNormal::Linear },
            damping_mass: contact.damping_mass,
            springs_add: contact.sharing == Sharing::ModelA,
            reference_fraction: contact.hertz.reference_overlap_fraction,
            reads_radius: description.normal_law() == NormalLaw::Hertz
                || description.material_pairs.iter().any(has_extras),
            rolling: pairs.iter().any(|pair| pair.rolling.is_active()),
            part_radius: shapes.iter().map(|shape| shape.parts().iter().map(Part::contact_radius).collect()).collect(),
            materials,
            pairs,
        })
    }

    /// What `a` with `b` has beyond its law.
    #[inline(always)]
    pub fn extras(&self, a: u32, b: u32) -> &PairExtras {
        &self.pairs[a as usize * self.materials + b as usize]
    }

    /// R, 1/R = 1/r_a + 1/r_b, of two parts (row, part), or of one at a boundary, m.
    #[inline(always)]
    pub(crate) fn effective_radius(&self, particles: &Particles, a: (usize, u16), b: Option<(usize, u16)>) -> f64 {
        let round = |(row, part): (usize, u16)| {
            self.part_radius[particles.shape[row] as usize][part as usize] * particles.scale[row]
        };
        b.map_or_else(|| round(a), |b| 1.0 / (1.0 / round(a) + 1.0 / round(b)))
    }

    /// Whether contacts may hold beyond the touch.
    pub fn has_bonds(&self) -> bool {
        self.pairs.iter().any(|pair| pair.cohesion.bond(1.0).is_some())
    }

    /// Least neighbour skin, m: a list drops the pairs that are farther apart than its skin, and no bond may be among them.
    /// For parts of effective radii up to `radius` (m); 0 without bonds.
    pub(crate) fn least_skin(&self, radius: f64) -> f64 {
        let gaps = self.pairs.iter().filter_map(|pair| Some(-pair.cohesion.bond(radius)?.overlap_at_breaking()));
        BEYOND_BONDS * gaps.fold(0.0, f64::max)
    }

    /// Normal stiffness of one point, N/m: with Hertz the one at the reference overlap.
    #[inline]
    pub fn reference_stiffness(&self, law: &PairLaw, extras: &PairExtras, radius: f64) -> f64 {
        match self.normal {
            PointNormal::Linear => law.stiffness,
            PointNormal::Hertz => {
                let hertz = extras.hertz.stiffness_at(self.reference_fraction, radius);
                let held = extras.cohesion.bond(radius);
                held.map_or(hertz, |bond| hertz.max(bond.stiffness_at(self.reference_fraction * radius)))
            }
        }
    }
}

/// A force on a ball passes through its centre: its contacts are central.
fn is_ball(shape: &Shape) -> bool {
    matches!(shape.parts(), [Part { geometry: PartGeometry::Sphere { .. }, .. }])
}

fn cohesion_of(pair: &MaterialPairDescription) -> Option<CohesionDescription> {
    pair.cohesion.filter(CohesionDescription::attracts)
}

fn has_extras(pair: &MaterialPairDescription) -> bool {
    cohesion_of(pair).is_some() || pair.rolling_friction > 0.0 || pair.twisting_friction > 0.0
}

fn pair_extras(pair: &MaterialPairDescription, description: &SceneDescription, of: [usize; 2]) -> PairExtras {
    let elastic = of.iter().filter_map(|&m| {
        let material = &description.materials[m];
        let youngs_modulus_pa = material.youngs_modulus_pa?;
        Some(Elastic { youngs_modulus_pa, poissons_ratio: material.poissons_ratio.unwrap_or(0.0) })
    });
    let hertz = HertzPair::of(elastic);
    PairExtras {
        hertz,
        tangential_damping: pair.tangential_damping_n_s_per_m,
        rolling: RollingLaw {
            rolling: pair.rolling_friction,
            twisting: pair.twisting_friction,
            damping_ratio: pair.rolling_damping_ratio,
        },
        cohesion: match cohesion_of(pair) {
            None => CohesionLaw::None,
            Some(CohesionDescription::Constant { force_n }) => CohesionLaw::Constant(force_n),
            Some(CohesionDescription::Sjkr { energy_density_j_per_m3 }) => CohesionLaw::Sjkr(energy_density_j_per_m3),
            Some(CohesionDescription::Jkr { work_of_adhesion_j_per_m2 }) => {
                CohesionLaw::Jkr { work_of_adhesion: work_of_adhesion_j_per_m2, modulus: hertz.modulus }
            }
        },
    }
}

/// Everything about these laws that is wrong or does not go together.
pub(super) fn check(description: &SceneDescription) -> Vec<InvalidInput> {
    let mut errors = Vec::new();
    check_contact(description, &mut errors);
    for (k, material) in description.materials.iter().enumerate() {
        let moduli = [
            ("youngs_modulus_pa", material.youngs_modulus_pa, "finite and above 0", f64::MIN_POSITIVE, f64::MAX),
            ("poissons_ratio", material.poissons_ratio, "in [0, 0.5]", 0.0, 0.5),
        ];
        for (key, value, allowed, low, high) in moduli {
            if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
                errors.push(out_of_range(format!("material[{k}].{key}"), value, allowed));
            }
        }
    }
    for (k, pair) in description.material_pairs.iter().enumerate() {
        check_pair(pair, description, &format!("material_pair[{k}]"), &mut errors);
    }
    errors
}

fn out_of_range(path: String, value: f64, allowed: &str) -> InvalidInput {
    InvalidInput::new(path, format!("is {value}; must be {allowed}"))
}

fn check_contact(description: &SceneDescription, errors: &mut Vec<InvalidInput>) {
    let contact = &description.contact;
    let fraction = contact.hertz.reference_overlap_fraction;
    if !(1e-8..=1.0).contains(&fraction) {
        errors.push(out_of_range("contact.hertz.reference_overlap_fraction".into(), fraction, "in [1e-8, 1]"));
    }
    let damping = description.integrator.local_damping;
    if !(0.0..1.0).contains(&damping) {
        errors.push(out_of_range("integrator.local_damping".into(), damping, "in [0, 1)"));
    }
    let shares = matches!(contact.sharing, Sharing::ModelB | Sharing::MaxOverlapShared);
    if contact.sharing_scope == SharingScope::Bodies && !(shares && description.normal_law() == NormalLaw::Linear) {
        let problem = "\"bodies\" is for normal = \"linear\" with sharing = \"model_b\" or \"max_overlap_shared\"";
        errors.push(InvalidInput::new("contact.sharing_scope", problem));
    }
    let overlaps = description.normal_law().is_by_overlap();
    if overlaps && contact.sharing != Sharing::PerPoint {
        let problem = "is for points, which generalized_overlap (the default of polyhedra) and volume have none of: give normal = \"linear\"";
        errors.push(InvalidInput::new("contact.sharing", problem));
    }
    let fits = match description.normal_law() {
        NormalLaw::Linear | NormalLaw::FeaturePairs => contact.tangential != Tangential::Mindlin,
        NormalLaw::Hertz => contact.tangential != Tangential::CoulombHistory,
        NormalLaw::GeneralizedOverlap | NormalLaw::Volume => {
            matches!(contact.tangential, Tangential::CoulombHistory | Tangential::None)
        }
    };
    if !fits {
        let allowed = "linear takes coulomb_history, viscous or none; hertz takes mindlin, viscous or none; generalized_overlap (the default of polyhedra) and volume take coulomb_history or none";
        errors.push(InvalidInput::new("contact.tangential", format!("does not go with this normal law: {allowed}")));
    }
}

fn check_pair(
    pair: &MaterialPairDescription,
    description: &SceneDescription,
    path: &str,
    errors: &mut Vec<InvalidInput>,
) {
    let mut not_negative = |key: &str, value: f64| {
        if !(value.is_finite() && value >= 0.0) {
            errors.push(out_of_range(format!("{path}.{key}"), value, "finite and at least 0"));
        }
    };
    not_negative("rolling_friction", pair.rolling_friction);
    not_negative("twisting_friction", pair.twisting_friction);
    not_negative("rolling_damping_ratio", pair.rolling_damping_ratio);
    not_negative("tangential_damping_n_s_per_m", pair.tangential_damping_n_s_per_m.unwrap_or(0.0));
    match pair.cohesion {
        None => {}
        Some(CohesionDescription::Constant { force_n }) => not_negative("cohesion.force_n", force_n),
        Some(CohesionDescription::Sjkr { energy_density_j_per_m3 }) => {
            not_negative("cohesion.energy_density_j_per_m3", energy_density_j_per_m3);
        }
        Some(CohesionDescription::Jkr { work_of_adhesion_j_per_m2 }) => {
            not_negative("cohesion.work_of_adhesion_j_per_m2", work_of_adhesion_j_per_m2);
        }
    }
    let contact = &description.contact;
    let mut refuse = |key: &str, problem: &str| errors.push(InvalidInput::new(format!("{path}.{key}"), problem));
    if pair.tangential_damping_n_s_per_m.is_some() && contact.tangential != Tangential::Viscous {
        refuse(
            "tangential_damping_n_s_per_m",
            "is read by tangential = \"viscous\" only; give tangential_damping_ratio",
        );
    }
    if description.normal_law().is_by_overlap() && has_extras(pair) {
        refuse(
            "rolling_friction",
            "and cohesion do not go with generalized_overlap, the default of polyhedra, or volume: give normal = \"linear\"",
        );
    }
    let hertz = description.normal_law() == NormalLaw::Hertz;
    if matches!(pair.cohesion, Some(CohesionDescription::Jkr { .. })) && !hertz {
        refuse("cohesion", "jkr stands on Hertz's contact: give normal = \"hertz\", or sjkr with a linear law");
    }
    match pair.stiffness_n_per_m {
        Some(_) if hertz => {
            refuse("stiffness_n_per_m", "is not read by hertz: give youngs_modulus_pa of the materials")
        }
        None if !hertz => refuse("stiffness_n_per_m", "is needed with this normal law"),
        _ => {}
    }
    let soft = |name: &String| {
        description.materials.iter().any(|material| material.name == *name && material.youngs_modulus_pa.is_some())
    };
    if hertz && !pair.materials.iter().any(soft) {
        refuse("materials", "one of the two needs youngs_modulus_pa with hertz (a material without it is rigid)");
    }
}

/// Hertz knows round parts without edges only, the shared volume polyhedra and planes.
pub(super) fn check_shapes(description: &SceneDescription, shapes: &[Shape]) -> Vec<InvalidInput> {
    match description.normal_law() {
        NormalLaw::Hertz => {}
        NormalLaw::Volume => return check_boundaries_of_volume(description),
        _ => return Vec::new(),
    }
    if description.material_pairs.iter().any(|pair| matches!(pair.cohesion, Some(CohesionDescription::Jkr { .. }))) {
        return check_bonds(description, shapes);
    }
    let flat = |part: &Part| match part.geometry {
        PartGeometry::Polyhedron(_) => Some("polyhedron"),
        PartGeometry::Cylinder { .. } => Some("cylinder"),
        _ => None,
    };
    let flat = shapes.iter().enumerate().filter_map(|(k, shape)| Some((k, shape.parts().iter().find_map(flat)?)));
    flat.map(|(k, kind)| {
        let problem = format!("has a {kind}; normal = \"hertz\" is for round parts");
        InvalidInput::new(format!("shape[{k}].geometry"), problem)
    })
    .collect()
}

/// Bonds are for balls and for boundaries without edges.
fn check_bonds(description: &SceneDescription, shapes: &[Shape]) -> Vec<InvalidInput> {
    let mut errors = Vec::new();
    let other = |part: &Part| !matches!(part.geometry, PartGeometry::Sphere { .. });
    for (k, _) in shapes.iter().enumerate().filter(|(_, shape)| shape.parts().iter().any(other)) {
        let problem = "is no sphere or composite of spheres; cohesion jkr is for these";
        errors.push(InvalidInput::new(format!("shape[{k}].geometry"), problem));
    }
    let mesh = |geometry: &BoundaryGeometry| matches!(geometry, BoundaryGeometry::Mesh { .. });
    for (k, _) in description.boundaries.iter().enumerate().filter(|(_, boundary)| mesh(&boundary.geometry)) {
        let problem = "is a mesh; cohesion jkr knows planes, boxes and cylinders";
        errors.push(InvalidInput::new(format!("boundary[{k}].geometry"), problem));
    }
    errors
}

fn check_boundaries_of_volume(description: &SceneDescription) -> Vec<InvalidInput> {
    let other = |geometry: &BoundaryGeometry| {
        matches!(geometry, BoundaryGeometry::CylinderInside { .. } | BoundaryGeometry::Mesh { .. })
    };
    let other = description.boundaries.iter().enumerate().filter(|(_, boundary)| other(&boundary.geometry));
    other
        .map(|(k, _)| {
            let problem = "is no plane; normal = \"volume\" meets planes only: give another law or planes";
            InvalidInput::new(format!("boundary[{k}].geometry"), problem)
        })
        .collect()
}

/// One sentence for each of these laws that the scene names.
pub(super) fn plan_lines(description: &SceneDescription) -> Vec<String> {
    let mut lines = Vec::new();
    let contact = &description.contact;
    if contact.damping_mass == DampingMass::Contact {
        lines.push("damping: calibrated for each contact's effective mass, rotation included".into());
    }
    if contact.sharing_scope == SharingScope::Bodies {
        lines.push("sharing of points: over all points of two bodies".into());
    }
    if description.normal_law() == NormalLaw::Hertz {
        let percent = 100.0 * contact.hertz.reference_overlap_fraction;
        lines.push(format!("critical step: holds up to an overlap of {percent} % of the effective radius"));
    }
    let any = |named: fn(&MaterialPairDescription) -> bool| description.material_pairs.iter().any(named);
    if any(|pair| pair.rolling_friction > 0.0 || pair.twisting_friction > 0.0) {
        lines.push("rolling and twisting resistance: spring, dashpot and limit, with history per pair of parts".into());
    }
    let is_jkr = |pair: &MaterialPairDescription| matches!(cohesion_of(pair), Some(CohesionDescription::Jkr { .. }));
    if description.material_pairs.iter().any(is_jkr) {
        lines.push("cohesion: jkr; contacts hold beyond the touch, within the neighbour skin".into());
    }
    if any(|pair| cohesion_of(pair).is_some_and(|law| !matches!(law, CohesionDescription::Jkr { .. }))) {
        lines.push("cohesion: between parts that touch".into());
    }
    if description.integrator.local_damping > 0.0 {
        lines.push(format!("local damping: {} of the unbalanced force", description.integrator.local_damping));
    }
    lines
}
