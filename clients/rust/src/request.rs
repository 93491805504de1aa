//! What commands ask for, as plain values; the daemon checks them.

use sturz_protocol::columns::rows;
use sturz_protocol::v1;

use crate::fluid::FluidFields;
use crate::loads::Loads;

/// On the wire.
pub(crate) fn vec3([x, y, z]: [f64; 3]) -> v1::Vec3 {
    v1::Vec3 { x, y, z }
}

/// Particles to insert.
#[derive(Clone, Debug, PartialEq)]
pub struct Insertion {
    /// Name in the scene.
    pub shape: String,
    /// Name in the scene.
    pub material: String,
    /// Where.
    pub placement: Placement,
    /// Of each, m/s.
    pub velocity_m_per_s: [f64; 3],
    /// Of each, in world axes, rad/s.
    pub angular_velocity_rad_per_s: [f64; 3],
    /// Smallest and largest size relative to the shape; uniformly random between them.
    pub scale: [f64; 2],
    /// They keep their velocity whatever pushes them: a rough base.
    pub frozen: bool,
}

/// Where particles are inserted.
#[derive(Clone, Debug, PartialEq)]
pub enum Placement {
    /// At given poses of the shape's given frame. Overlap is not checked.
    Poses {
        /// m.
        positions_m: Vec<[f64; 3]>,
        /// Unit quaternions; unrotated when `None`.
        orientations_wxyz: Option<Vec<[f64; 4]>>,
    },
    /// On the nodes of a lattice.
    Lattice {
        /// First node, m.
        origin_m: [f64; 3],
        /// Distance of nodes along each axis, m.
        spacing_m: [f64; 3],
        /// Nodes along each axis.
        counts: [u32; 3],
        /// Instead of unrotated.
        random_orientation: bool,
    },
    /// At random places without overlap with particles or boundaries.
    Random {
        /// Particles lie wholly inside.
        region: Region,
        /// How many.
        amount: Amount,
        /// Unrotated instead of random.
        fixed_orientation: bool,
        /// Per particle before the insertion is refused; the daemon's default when `None`.
        attempts: Option<u32>,
    },
    /// By circumscribed spheres that drop one after the other into a box and roll to local minima of height.
    Deposition {
        /// Lower corner of the box, m.
        min_m: [f64; 3],
        /// Upper corner, m.
        max_m: [f64; 3],
        /// How many.
        count: u32,
        /// Unrotated instead of random.
        fixed_orientation: bool,
    },
}

/// A part of space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// Axis-aligned.
    Box {
        /// Lower corner, m.
        min_m: [f64; 3],
        /// Upper corner, m.
        max_m: [f64; 3],
    },
    /// Solid and circular.
    Cylinder {
        /// Centre of one end, m.
        point_m: [f64; 3],
        /// Direction from that end to the other.
        axis: [f64; 3],
        /// m.
        radius_m: f64,
        /// Distance of the ends, m.
        length_m: f64,
    },
}

/// How many particles a random insertion adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// So many.
    Count(u32),
    /// Until they fill this part of the region.
    SolidFraction(f64),
}

impl Insertion {
    /// At rest, of the shape's own size.
    pub fn new(shape: impl Into<String>, material: impl Into<String>, placement: Placement) -> Self {
        Self {
            shape: shape.into(),
            material: material.into(),
            placement,
            velocity_m_per_s: [0.0; 3],
            angular_velocity_rad_per_s: [0.0; 3],
            scale: [1.0; 2],
            frozen: false,
        }
    }
}

impl Placement {
    /// Unrotated at these positions, m.
    pub fn poses(positions_m: Vec<[f64; 3]>) -> Self {
        Placement::Poses { positions_m, orientations_wxyz: None }
    }

    /// Randomly placed and oriented.
    pub fn random(region: Region, amount: Amount) -> Self {
        Placement::Random { region, amount, fixed_orientation: false, attempts: None }
    }
}

impl From<Insertion> for v1::InsertRequest {
    fn from(insertion: Insertion) -> Self {
        let [min, max] = insertion.scale;
        Self {
            header: None,
            shape: insertion.shape,
            material: insertion.material,
            placement: Some(insertion.placement.into()),
            velocity_m_per_s: Some(vec3(insertion.velocity_m_per_s)),
            angular_velocity_rad_per_s: Some(vec3(insertion.angular_velocity_rad_per_s)),
            scale: Some(v1::ScaleRange { min, max }),
            scale_law: None,
            frozen: insertion.frozen,
        }
    }
}

impl From<Placement> for v1::insert_request::Placement {
    fn from(placement: Placement) -> Self {
        match placement {
            Placement::Poses { positions_m, orientations_wxyz } => Self::Poses(v1::PosesPlacement {
                positions_m: Some(rows("positions_m", "m", &positions_m)),
                orientations_wxyz: orientations_wxyz.map(|wxyz| rows("orientations_wxyz", "", &wxyz)),
            }),
            Placement::Lattice { origin_m, spacing_m, counts, random_orientation } => {
                let [count_x, count_y, count_z] = counts;
                let (origin_m, spacing_m) = (Some(vec3(origin_m)), Some(vec3(spacing_m)));
                Self::Lattice(v1::LatticePlacement {
                    origin_m,
                    spacing_m,
                    count_x,
                    count_y,
                    count_z,
                    random_orientation,
                })
            }
            Placement::Random { region, amount, fixed_orientation, attempts } => Self::Random(v1::RandomPlacement {
                region: Some(region.into()),
                amount: Some(match amount {
                    Amount::Count(count) => v1::random_placement::Amount::Count(count),
                    Amount::SolidFraction(part) => v1::random_placement::Amount::SolidFraction(part),
                }),
                fixed_orientation,
                attempts,
            }),
            Placement::Deposition { min_m, max_m, count, fixed_orientation } => {
                let region = v1::BoxRegion { min_m: Some(vec3(min_m)), max_m: Some(vec3(max_m)) };
                Self::Deposition(v1::DepositionPlacement { r#box: Some(region), count, fixed_orientation })
            }
        }
    }
}

impl From<Region> for v1::random_placement::Region {
    fn from(region: Region) -> Self {
        match region {
            Region::Box { min_m, max_m } => {
                Self::Box(v1::BoxRegion { min_m: Some(vec3(min_m)), max_m: Some(vec3(max_m)) })
            }
            Region::Cylinder { point_m, axis, radius_m, length_m } => {
                let (point_m, axis) = (Some(vec3(point_m)), Some(vec3(axis)));
                Self::Cylinder(v1::CylinderRegion { point_m, axis, radius_m, length_m })
            }
        }
    }
}

/// Prescribed motion of a boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// At rest.
    Fixed,
    /// About an axis, by the right-hand rule.
    Rotation {
        /// A point of the axis, m.
        point_m: [f64; 3],
        /// Direction of the axis.
        axis: [f64; 3],
        /// At the end of the ramp.
        angular_velocity_rad_per_s: f64,
        /// Duration of the linear change from the present angular velocity, s; at once when `None`.
        ramp_s: Option<f64>,
    },
    /// At constant velocity.
    Translation {
        /// m/s.
        velocity_m_per_s: [f64; 3],
    },
    /// To and fro from where it is: amplitude (sin(2 pi frequency t + phase) - sin(phase)).
    Oscillation {
        /// Along each axis, m.
        amplitude_m: [f64; 3],
        /// Above 0, Hz.
        frequency_hz: f64,
        /// At the start, rad.
        phase_rad: f64,
    },
    /// Until it presses on the particles with a force: velocity = gain (target - measured), cut at the largest one.
    Servo {
        /// In which it presses.
        direction: [f64; 3],
        /// Target, N.
        force_n: f64,
        /// Above 0, m/(s N).
        gain_m_per_s_per_n: f64,
        /// Above 0, m/s.
        max_velocity_m_per_s: f64,
    },
    /// Displacements from where it is over time, linear between the rows.
    Table {
        /// Since the command, s: 0 first, then ascending.
        times_s: Vec<f64>,
        /// One per time, m: (0, 0, 0) first.
        displacements_m: Vec<[f64; 3]>,
    },
}

impl From<Motion> for v1::Motion {
    fn from(motion: Motion) -> Self {
        use v1::motion::Kind;
        use v1::rotation_motion::AngularVelocity;
        let kind = match motion {
            Motion::Fixed => Kind::Fixed(v1::FixedMotion {}),
            Motion::Rotation { point_m, axis, angular_velocity_rad_per_s: rad_per_s, ramp_s } => {
                Kind::Rotation(v1::RotationMotion {
                    point_m: Some(vec3(point_m)),
                    axis: Some(vec3(axis)),
                    angular_velocity: Some(match ramp_s {
                        None => AngularVelocity::Constant(v1::ConstantAngularVelocity { rad_per_s }),
                        Some(duration_s) => AngularVelocity::Ramp(v1::RampAngularVelocity { rad_per_s, duration_s }),
                    }),
                })
            }
            Motion::Translation { velocity_m_per_s } => {
                Kind::Translation(v1::TranslationMotion { velocity_m_per_s: Some(vec3(velocity_m_per_s)) })
            }
            Motion::Oscillation { amplitude_m, frequency_hz, phase_rad } => Kind::Oscillation(v1::OscillationMotion {
                amplitude_m: Some(vec3(amplitude_m)),
                frequency_hz,
                phase_rad,
            }),
            Motion::Servo { direction, force_n, gain_m_per_s_per_n, max_velocity_m_per_s } => {
                let direction = Some(vec3(direction));
                Kind::Servo(v1::ServoMotion { direction, force_n, gain_m_per_s_per_n, max_velocity_m_per_s })
            }
            Motion::Table { times_s, displacements_m } => Kind::Table(v1::TableMotion {
                times_s,
                displacements_m: Some(rows("displacements_m", "m", &displacements_m)),
            }),
        };
        Self { kind: Some(kind) }
    }
}

/// Of the floating-point columns of a state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloatType {
    /// As the engine has them.
    #[default]
    F64,
    /// Half the bytes, rounded to nearest.
    F32,
}

impl FloatType {
    /// As in `state/latest?float=f32`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            FloatType::F64 => "f64",
            FloatType::F32 => "f32",
        }
    }

    pub(crate) fn to_wire(self) -> v1::DataType {
        match self {
            FloatType::F64 => v1::DataType::F64,
            FloatType::F32 => v1::DataType::F32,
        }
    }
}

/// Where a window starts. Another place than the engine's is refused: that catches lost and doubled windows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Start {
    /// At the time that this client heard of last.
    #[default]
    LastKnown,
    /// At this time, s: bit for bit the last `time_reached_s`.
    Time(f64),
    /// After so many steps.
    Step(u64),
}

/// A window to advance by, and what its reply carries.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Window {
    /// Length, s: cut into equal steps, none longer than the nominal time step.
    pub length_s: f64,
    /// Where it starts.
    pub start: Start,
    /// Of the state to return; `all` for every one, none for no state.
    pub columns: Vec<String>,
    /// Names of defined fields to return.
    pub fields: Vec<String>,
    /// Return the contact network.
    pub contacts: bool,
    /// Of the state and the contacts.
    pub float_type: FloatType,
    /// Instead of those before, from its start on.
    pub loads: Option<Loads>,
    /// Of the fluid, instead of those before, from its start on.
    pub fluid: Option<FluidFields>,
    /// Return what the fluid gets from the particles.
    pub exchange: bool,
}

impl Window {
    /// Of this length, s, without data in the reply.
    pub fn new(length_s: f64) -> Self {
        Self { length_s, ..Self::default() }
    }

    /// Starting there.
    pub fn from(self, start: Start) -> Self {
        Self { start, ..self }
    }

    /// With these columns of the state in the reply.
    pub fn with_columns<S: Into<String>>(mut self, columns: impl IntoIterator<Item = S>) -> Self {
        self.columns = columns.into_iter().map(Into::into).collect();
        self
    }

    /// With samples of these fields in the reply.
    pub fn with_fields<S: Into<String>>(mut self, fields: impl IntoIterator<Item = S>) -> Self {
        self.fields = fields.into_iter().map(Into::into).collect();
        self
    }

    /// With the contact network in the reply.
    pub fn with_contacts(self) -> Self {
        Self { contacts: true, ..self }
    }

    /// With these loads from its start on, instead of those before.
    pub fn with_loads(self, loads: Loads) -> Self {
        Self { loads: Some(loads), ..self }
    }

    /// With these fields of the fluid from its start on, and what it gets from the particles in the reply.
    pub fn with_fluid(self, fields: FluidFields) -> Self {
        Self { fluid: Some(fields), exchange: true, ..self }
    }

    /// On the wire; `last_known_s` for [`Start::LastKnown`].
    pub(crate) fn into_wire(self, last_known_s: f64) -> v1::AdvanceRequest {
        use v1::advance_request::From;
        let float_type = self.float_type.to_wire().into();
        v1::AdvanceRequest {
            header: None,
            window_s: self.length_s,
            loads: self.loads.map(Into::into),
            outputs: Some(v1::Outputs {
                columns: self.columns,
                fields: self.fields,
                float_type,
                contacts: self.contacts,
                exchange: self.exchange,
            }),
            fluid: self.fluid.map(Into::into),
            from: Some(match self.start {
                Start::LastKnown => From::FromTimeS(last_known_s),
                Start::Time(time_s) => From::FromTimeS(time_s),
                Start::Step(step) => From::FromStep(step),
            }),
        }
    }
}
