//! The scene as a user writes it: raw, not yet proved usable. [`super::Scene::validate`] proves it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    CohesionDescription, DampingMass, FeaturePairsSection, GeneralizedOverlapSection, HertzSection, InflowDescription,
    NormalLaw, OutputSection, ScaleLaw, ScaleSection, SharingScope, StageDescription, StartSection,
};
use crate::fields::FieldDefinition;
use crate::shape::ShapeDescription;

/// A whole scene file. SI units, radians unless the key says otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneDescription {
    /// Name, gravity, time step, seed.
    pub scene: SceneSection,
    /// Extent and periodic axes.
    #[serde(default)]
    pub domain: DomainSection,
    /// How contacts are shared and ended.
    #[serde(default)]
    pub contact: ContactSection,
    /// How motion is integrated.
    #[serde(default)]
    pub integrator: IntegratorSection,
    /// Materials of particles and boundaries.
    #[serde(default, rename = "material")]
    pub materials: Vec<MaterialDescription>,
    /// Contact parameters of each pair of materials that may meet.
    #[serde(default, rename = "material_pair")]
    pub material_pairs: Vec<MaterialPairDescription>,
    /// Shapes that particles may have.
    #[serde(default, rename = "shape")]
    pub shapes: Vec<NamedShapeDescription>,
    /// Walls and drums.
    #[serde(default, rename = "boundary")]
    pub boundaries: Vec<BoundaryDescription>,
    /// Particles that are there from the start.
    #[serde(default, rename = "insertion")]
    pub insertions: Vec<InsertionDescription>,
    /// The bed of another scene, which this one goes on with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<StartSection>,
    /// Particles that come in over time.
    #[serde(default, rename = "inflow", skip_serializing_if = "Vec::is_empty")]
    pub inflows: Vec<InflowDescription>,
    /// Laws that change on the way.
    #[serde(default, rename = "stage", skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<StageDescription>,
    /// Takes the overlaps of the start apart; left as they are when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relax: Option<RelaxSection>,
    /// Coarse-grained fields that clients may ask for by name.
    #[serde(default, rename = "field")]
    pub fields: Vec<FieldDefinition>,
    /// What the daemon publishes, and how often.
    #[serde(default)]
    pub output: OutputSection,
    /// When `sturz run` ends.
    #[serde(default)]
    pub stop: StopSection,
}

/// `[scene]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneSection {
    /// Name shown to users.
    pub name: String,
    /// One sentence for `sturz scenes`.
    #[serde(default)]
    pub description: String,
    /// Acceleration of gravity.
    #[serde(default)]
    pub gravity_m_per_s2: [f64; 3],
    /// Time step. Give this, `time_step_fraction` or `time_step`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_step_s: Option<f64>,
    /// Time step as a fraction of the critical one, in (0, 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_step_fraction: Option<f64>,
    /// `"auto"`: the engine chooses the time step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_step: Option<TimeStepChoice>,
    /// Seed of everything random.
    #[serde(default)]
    pub seed: u64,
}

/// Who chooses the time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TimeStepChoice {
    /// The engine: a fiftieth of the shortest collision, at most what several contacts on a body leave of the critical
    /// step (1/sqrt(12) of it under `linear` and `hertz`; 0.8 under `generalized_overlap`).
    Auto,
}

/// `[domain]`
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DomainSection {
    /// Lower corner; needed along periodic axes.
    #[serde(default)]
    pub min_m: [f64; 3],
    /// Upper corner; needed along periodic axes.
    #[serde(default)]
    pub max_m: [f64; 3],
    /// Which of x, y, z are periodic.
    #[serde(default)]
    pub periodic: [bool; 3],
    /// Where the scene is in the user's own coordinates. Every position in the scene, in commands, frames and grids is
    /// relative to it: far from the origin of a map, overlaps keep all their digits.
    #[serde(default, skip_serializing_if = "is_origin")]
    pub origin_m: [f64; 3],
}

fn one() -> f64 {
    1.0
}

fn is_false(flag: &bool) -> bool {
    !flag
}

fn is_origin(origin_m: &[f64; 3]) -> bool {
    *origin_m == [0.0; 3]
}

/// How the points of one manifold share the stiffness of the pair (PHYSICS.md A.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sharing {
    /// f_i = w_i k d_i, weights continuous in the pose and of sum 1.
    #[default]
    PerPoint,
    /// f_i = k d_i / N, N the number of touching points (Rakotonirina et al. 2019, model B).
    ModelB,
    /// f_i = k d_i (the same, model A): the more points, the stiffer.
    ModelA,
    /// f_i = k d_max / N at every point (seed 000, eq. 3); to reproduce it only: energy is not conserved.
    MaxOverlapShared,
}

/// When a damped contact ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactEnd {
    /// The normal force never attracts; it is clipped at zero.
    #[default]
    Clip,
    /// The dashpot may attract until the overlap is zero.
    Tension,
}

/// Law of the tangential force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Tangential {
    /// Spring with history, kept in the Coulomb cone.
    #[default]
    CoulombHistory,
    /// Hertzian contacts without slip, kept in the Coulomb cone; needs `normal = "hertz"`.
    Mindlin,
    /// Dashpot with a Coulomb limit, without a spring and without static friction.
    Viscous,
    /// No tangential force, and no history.
    None,
}

/// `[contact]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ContactSection {
    /// Law of the normal force.
    pub normal: NormalLaw,
    /// Sharing over several points.
    pub sharing: Sharing,
    /// Whose points share.
    pub sharing_scope: SharingScope,
    /// End of contact.
    pub contact_end: ContactEnd,
    /// Mass that the damping is calibrated for.
    pub damping_mass: DampingMass,
    /// Tangential law.
    pub tangential: Tangential,
    /// Neighbour skin over the harmonic mean of the bounding diameters; chosen by the engine when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skin_fraction: Option<f64>,
    /// The run stops when an overlap exceeds this part of the smaller bounding radius.
    pub overlap_limit: f64,
    /// Parameters of `normal = "generalized_overlap"`.
    #[serde(skip_serializing_if = "GeneralizedOverlapSection::is_default")]
    pub generalized_overlap: GeneralizedOverlapSection,
    /// Parameters of `normal = "feature_pairs"`.
    #[serde(skip_serializing_if = "FeaturePairsSection::is_default")]
    pub feature_pairs: FeaturePairsSection,
    /// Parameters of `normal = "hertz"`.
    #[serde(skip_serializing_if = "HertzSection::is_default")]
    pub hertz: HertzSection,
}

impl Default for ContactSection {
    fn default() -> Self {
        Self {
            normal: NormalLaw::default(),
            generalized_overlap: GeneralizedOverlapSection::default(),
            feature_pairs: FeaturePairsSection::default(),
            hertz: HertzSection::default(),
            damping_mass: DampingMass::default(),
            sharing: Sharing::default(),
            sharing_scope: SharingScope::default(),
            contact_end: ContactEnd::default(),
            tangential: Tangential::default(),
            skin_fraction: None,
            overlap_limit: 0.3,
        }
    }
}

/// Scheme of the rotational motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RotationScheme {
    /// Omelyan's revised leapfrog in the angular momentum.
    #[default]
    Omelyan,
    /// Symmetric splitting into exact rotations about the principal axes: more accurate at small steps, worse at large.
    Splitting,
}

/// `[integrator]`
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct IntegratorSection {
    /// Scheme of the rotational motion.
    pub rotation: RotationScheme,
    /// Local damping: part of the unbalanced force that acts against the motion, in [0, 1).
    pub local_damping: f64,
}

/// `[[material]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialDescription {
    /// Name, used by insertions, boundaries and pairs.
    pub name: String,
    /// Needed by materials of particles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_kg_per_m3: Option<f64>,
    /// Young's modulus, for `normal = "hertz"`; a material without it is rigid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub youngs_modulus_pa: Option<f64>,
    /// Poisson's ratio, for `normal = "hertz"`; 0 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poissons_ratio: Option<f64>,
}

/// `[[material_pair]]`: linear spring, dashpot and Coulomb friction between two materials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialPairDescription {
    /// The two materials (may be the same).
    pub materials: [String; 2],
    /// Normal stiffness: of a single contact point, of a pair of parts under `generalized_overlap`; not with
    /// `normal = "hertz"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_n_per_m: Option<f64>,
    /// Coefficient of restitution in (0, 1]; give this or `damping_n_s_per_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Raw normal dashpot coefficient.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping_n_s_per_m: Option<f64>,
    /// Coulomb coefficient of sliding friction.
    #[serde(default)]
    pub friction: f64,
    /// Tangential over normal stiffness.
    #[serde(default = "default_tangential_stiffness_ratio")]
    pub tangential_stiffness_ratio: f64,
    /// Tangential over normal dashpot coefficient; the square root of the stiffness ratio when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential_damping_ratio: Option<f64>,
    /// Raw tangential dashpot coefficient, for `tangential = "viscous"`; from the ratio when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential_damping_n_s_per_m: Option<f64>,
    /// Largest rolling torque over effective radius times normal force.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rolling_friction: f64,
    /// Largest twisting torque over effective radius times normal force.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub twisting_friction: f64,
    /// Dashpot of rolling and twisting over the critical one.
    #[serde(default = "default_rolling_damping_ratio", skip_serializing_if = "is_default_rolling_damping_ratio")]
    pub rolling_damping_ratio: f64,
    /// Attraction while in touch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cohesion: Option<CohesionDescription>,
}

fn default_rolling_damping_ratio() -> f64 {
    0.3
}

fn is_default_rolling_damping_ratio(ratio: &f64) -> bool {
    *ratio == default_rolling_damping_ratio()
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

fn default_tangential_stiffness_ratio() -> f64 {
    2.0 / 7.0
}

/// `[[shape]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedShapeDescription {
    /// Name, used by insertions.
    pub name: String,
    /// The geometry.
    pub geometry: ShapeDescription,
}

/// `[[boundary]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundaryDescription {
    /// Name, used by `set_motion`.
    pub name: String,
    /// Material of its surface.
    pub material: String,
    /// What it is.
    pub geometry: BoundaryGeometry,
    /// How it moves; fixed when absent.
    #[serde(default)]
    pub motion: MotionDescription,
}

/// Geometry of a boundary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum BoundaryGeometry {
    /// Half-space; particles live on the side that `normal` points to. `half_space` is another name of it.
    #[serde(alias = "half_space")]
    Plane {
        /// A point of the plane.
        point_m: [f64; 3],
        /// Towards the particles; need not be of unit length.
        normal: [f64; 3],
    },
    /// Axis-aligned room that particles are inside of: one plane for each side that is not open, named as the boundary
    /// with the side behind it (`room/x-`). Motions set for the boundary's name go to all of them.
    Box {
        /// Lower corner.
        min_m: [f64; 3],
        /// Upper corner.
        max_m: [f64; 3],
        /// Sides without a plane.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        open: Vec<BoxSide>,
    },
    /// Triangles; particles live on the side that their normals point to (counter-clockwise seen from there). Surfaces
    /// that are to hang together share vertices by index. A particle whose centre is on the other side is not seen.
    Mesh {
        /// Vertices.
        vertices_m: Vec<[f64; 3]>,
        /// Three indices of vertices each.
        triangles: Vec<[u32; 3]>,
    },
    /// The same out of an `.obj` or `.stl` file; whoever reads the scene file puts the triangles here
    /// ([`SceneDescription::read_files`]).
    MeshFile {
        /// Relative to the scene file.
        path: String,
        /// Metres per unit of the file.
        #[serde(default = "one")]
        scale: f64,
    },
    /// Outside of an infinite circular cylinder (roller).
    CylinderOutside {
        /// A point of the axis.
        point_m: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
        /// Radius.
        radius_m: f64,
    },
    /// Inside of an infinite circular cylinder (drum).
    CylinderInside {
        /// A point of the axis.
        point_m: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
        /// Radius.
        radius_m: f64,
    },
}

/// Side of a box, by its axis and whether it is the lower or the upper one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum BoxSide {
    /// At the lower x.
    #[serde(rename = "x-")]
    LowerX,
    /// At the upper x.
    #[serde(rename = "x+")]
    UpperX,
    /// At the lower y.
    #[serde(rename = "y-")]
    LowerY,
    /// At the upper y.
    #[serde(rename = "y+")]
    UpperY,
    /// At the lower z.
    #[serde(rename = "z-")]
    LowerZ,
    /// At the upper z.
    #[serde(rename = "z+")]
    UpperZ,
}

/// Angular velocity as a function of time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum AngularVelocity {
    /// The same at all times.
    Constant {
        /// Value.
        rad_per_s: f64,
    },
    /// From the angular velocity at the time of the command, linearly to `rad_per_s`, then constant.
    Ramp {
        /// Final value.
        rad_per_s: f64,
        /// Duration of the ramp.
        duration_s: f64,
    },
    /// amplitude sin(2 pi frequency t + phase), t from the command on.
    Oscillation {
        /// Largest value.
        amplitude_rad_per_s: f64,
        /// Above 0.
        frequency_hz: f64,
        /// Phase at the start.
        #[serde(default)]
        phase_rad: f64,
    },
}

/// Prescribed motion of a boundary.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum MotionDescription {
    /// At rest.
    #[default]
    Fixed,
    /// Rotation about an axis through a point.
    Rotation {
        /// A point of the axis.
        point_m: [f64; 3],
        /// Direction of the axis (right-hand rule).
        axis: [f64; 3],
        /// Angular velocity as a function of time.
        angular_velocity: AngularVelocity,
    },
    /// Translation at constant velocity.
    Translation {
        /// Velocity.
        velocity_m_per_s: [f64; 3],
    },
    /// Displacement amplitude (sin(2 pi frequency t + phase) - sin(phase)) from where it is at the command, t from then
    /// on (vibrated bed).
    Oscillation {
        /// Along each axis.
        amplitude_m: [f64; 3],
        /// Above 0.
        frequency_hz: f64,
        /// Phase at the start.
        #[serde(default)]
        phase_rad: f64,
    },
    /// Moves along a direction until it presses on the particles with a force: velocity = gain (target - measured), cut at
    /// the largest velocity; measured is the force at the end of the step before. Stable where gain times the stiffness
    /// of what it presses on times the time step is well below 1.
    Servo {
        /// In which it presses; need not be of unit length.
        direction: [f64; 3],
        /// Target. Give this, or `pressure_pa` and `area_m2`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        force_n: Option<f64>,
        /// Target over `area_m2`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pressure_pa: Option<f64>,
        /// What the pressure acts on.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        area_m2: Option<f64>,
        /// Velocity per missing force, m/(s N); above 0.
        gain_m_per_s_per_n: f64,
        /// Above 0.
        max_velocity_m_per_s: f64,
    },
    /// Displacement over time, linear between the rows, from where it is at the command; at rest after the last row.
    Table {
        /// Since the command: 0 first, then ascending.
        times_s: Vec<f64>,
        /// From where it was, (0, 0, 0) first.
        displacements_m: Vec<[f64; 3]>,
    },
}

/// Where random insertion places particles: wholly inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Region {
    /// Axis-aligned box.
    Box {
        /// Lower corner.
        min_m: [f64; 3],
        /// Upper corner.
        max_m: [f64; 3],
    },
    /// Solid circular cylinder.
    Cylinder {
        /// Centre of one end.
        point_m: [f64; 3],
        /// Direction from that end to the other.
        axis: [f64; 3],
        /// Radius.
        radius_m: f64,
        /// Distance of the ends.
        length_m: f64,
    },
}

/// Where the inserted particles go.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "method", rename_all = "snake_case", deny_unknown_fields)]
pub enum Placement {
    /// Given poses (of the shape's given frame); overlap is not checked.
    Poses {
        /// Positions, one per particle.
        positions_m: Vec<[f64; 3]>,
        /// Orientations `world_from_body` (w, x, y, z), one per particle; unrotated when empty.
        #[serde(default)]
        orientations_wxyz: Vec<[f64; 4]>,
    },
    /// Nodes of a lattice.
    Lattice {
        /// First node.
        origin_m: [f64; 3],
        /// Distance of nodes along each axis.
        spacing_m: [f64; 3],
        /// Nodes along each axis.
        counts: [u32; 3],
        /// Random instead of unrotated orientations.
        #[serde(default)]
        random_orientation: bool,
    },
    /// Random positions and orientations without overlap with particles or boundaries.
    Random {
        /// Where.
        region: Region,
        /// How many. Give this or `solid_fraction`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        count: Option<u32>,
        /// Until the new particles fill this part of the region. Give this or `count`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        solid_fraction: Option<f64>,
        /// Unrotated instead of random orientations.
        #[serde(default)]
        fixed_orientation: bool,
        /// Attempts per particle before the insertion is refused.
        #[serde(default = "default_attempts")]
        attempts: u32,
    },
    /// Circumscribed spheres that drop one after the other into a box and roll to local minima of height; orientations are
    /// random. The box has a floor, and walls along x and y unless it spans a periodic cell; what is there already is as good
    /// a ground as the floor.
    Deposition {
        /// A box. An error where the heap grows above it.
        region: Region,
        /// How many.
        count: u32,
        /// Unrotated instead of random orientations.
        #[serde(default)]
        fixed_orientation: bool,
    },
}

fn default_attempts() -> u32 {
    2000
}

/// `[[insertion]]`, and the body of the command `insert`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InsertionDescription {
    /// Name of the shape.
    pub shape: String,
    /// Name of the material.
    pub material: String,
    /// Where.
    pub placement: Placement,
    /// Initial velocity of every particle.
    #[serde(default)]
    pub velocity_m_per_s: [f64; 3],
    /// Initial angular velocity of every particle, in world axes.
    #[serde(default)]
    pub angular_velocity_rad_per_s: [f64; 3],
    /// Sizes relative to the shape; 1 when absent.
    #[serde(default)]
    #[schemars(with = "ScaleSection")]
    pub scale: ScaleLaw,
    /// Moves with `velocity_m_per_s` for ever, whatever pushes: a rough base. Its contacts with others are those of any
    /// particle; with its like and with boundaries it has none.
    #[serde(default, skip_serializing_if = "is_false")]
    pub frozen: bool,
}

/// `[relax]`: before step 0 the particles of the scene move apart without inertia, until no overlap is above a limit.
///
/// Shapes, sizes and given velocities stay; positions and orientations change. What is left of an overlap d flies apart with
/// sqrt(k/m) d at most, k and m of the pair. Particles that are inserted later are not relaxed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RelaxSection {
    /// Largest overlap over the smaller bounding radius that may be left (of polyhedra: the depth of their deepest point).
    pub overlap_ratio: f64,
    /// Farthest way of any point in an iteration, over half the thickness of its particle.
    pub displacement_fraction: f64,
    /// Iterations after which the run is refused.
    pub max_iterations: u64,
}

impl Default for RelaxSection {
    fn default() -> Self {
        Self { overlap_ratio: 1e-3, displacement_fraction: 0.05, max_iterations: 20_000 }
    }
}

/// `[stop]`
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StopSection {
    /// Simulated time at which `sturz run` ends and `sturz serve` pauses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
}
