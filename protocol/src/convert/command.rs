//! Requests to and from the engine's commands.

use sturz_engine::InvalidInput;
use sturz_engine::scene::{AngularVelocity, InsertionDescription, MotionDescription, Placement, Region, ScaleLaw};

use super::{finite, need, needed_vector, optional_vector, vec3};
use crate::columns::{self, Number};
use crate::v1;

const DEFAULT_ATTEMPTS: u32 = 2000;

/// The body of `insert`.
pub fn insertion_from_wire(request: &v1::InsertRequest) -> Result<InsertionDescription, InvalidInput> {
    use v1::insert_request::Placement as Wire;
    let placement = match need(&request.placement, "placement")? {
        Wire::Poses(poses) => poses_from_wire(poses)?,
        Wire::Lattice(lattice) => lattice_from_wire(lattice)?,
        Wire::Random(random) => random_from_wire(random)?,
        Wire::Deposition(deposition) => deposition_from_wire(deposition)?,
    };
    Ok(InsertionDescription {
        shape: request.shape.clone(),
        material: request.material.clone(),
        placement,
        velocity_m_per_s: optional_vector(&request.velocity_m_per_s, "velocity_m_per_s")?,
        angular_velocity_rad_per_s: optional_vector(&request.angular_velocity_rad_per_s, "angular_velocity_rad_per_s")?,
        scale: scale_from_wire(request)?,
        frozen: request.frozen,
    })
}

fn scale_from_wire(request: &v1::InsertRequest) -> Result<ScaleLaw, InvalidInput> {
    use v1::insert_request::ScaleLaw as Wire;
    match (&request.scale, &request.scale_law) {
        (None, None) => Ok(ScaleLaw::default()),
        (Some(range), None) => {
            Ok(ScaleLaw::Uniform { min: finite(range.min, "scale.min")?, max: finite(range.max, "scale.max")? })
        }
        (Some(_), Some(_)) => Err(InvalidInput::new("scale", "is there besides a law of sizes; give one of them")),
        (None, Some(Wire::NormalScale(law))) => Ok(ScaleLaw::Normal {
            mean: finite(law.mean, "normal_scale.mean")?,
            standard_deviation: finite(law.standard_deviation, "normal_scale.standard_deviation")?,
            min: finite(law.min, "normal_scale.min")?,
            max: finite(law.max, "normal_scale.max")?,
        }),
        (None, Some(Wire::LognormalScale(law))) => Ok(ScaleLaw::Lognormal {
            median: finite(law.median, "lognormal_scale.median")?,
            log_standard_deviation: finite(law.log_standard_deviation, "lognormal_scale.log_standard_deviation")?,
            min: finite(law.min, "lognormal_scale.min")?,
            max: finite(law.max, "lognormal_scale.max")?,
        }),
        (None, Some(Wire::ScaleTable(table))) => {
            let (scales, weights) = (&table.scales, &table.weights);
            if scales.len() != weights.len() {
                let problem = format!("has {} weights for {} scales", weights.len(), scales.len());
                return Err(InvalidInput::new("scale_table.weights", problem));
            }
            Ok(ScaleLaw::Table { rows: scales.iter().zip(weights).map(|(&scale, &weight)| [scale, weight]).collect() })
        }
    }
}

type WireScale = (Option<v1::ScaleRange>, Option<v1::insert_request::ScaleLaw>);

fn scale_to_wire(law: &ScaleLaw) -> WireScale {
    use v1::insert_request::ScaleLaw as Wire;
    match *law {
        ScaleLaw::Uniform { min, max } => (Some(v1::ScaleRange { min, max }), None),
        ScaleLaw::Normal { mean, standard_deviation, min, max } => {
            (None, Some(Wire::NormalScale(v1::NormalScale { mean, standard_deviation, min, max })))
        }
        ScaleLaw::Lognormal { median, log_standard_deviation, min, max } => {
            (None, Some(Wire::LognormalScale(v1::LognormalScale { median, log_standard_deviation, min, max })))
        }
        ScaleLaw::Table { ref rows } => {
            let (scales, weights) = rows.iter().map(|&[scale, weight]| (scale, weight)).unzip();
            (None, Some(Wire::ScaleTable(v1::ScaleTable { scales, weights })))
        }
    }
}

fn poses_from_wire(poses: &v1::PosesPlacement) -> Result<Placement, InvalidInput> {
    let path = "placement.poses.positions_m";
    let positions_m = finite_rows(need(&poses.positions_m, path)?, path)?;
    let path = "placement.poses.orientations_wxyz";
    let orientations_wxyz: Vec<[f64; 4]> = match &poses.orientations_wxyz {
        Some(column) => finite_rows(column, path)?,
        None => Vec::new(),
    };
    if !orientations_wxyz.is_empty() && orientations_wxyz.len() != positions_m.len() {
        let problem = format!("has {} rows for {} positions", orientations_wxyz.len(), positions_m.len());
        return Err(InvalidInput::new(path, problem));
    }
    Ok(Placement::Poses { positions_m, orientations_wxyz })
}

/// Rows of a column, all finite.
fn finite_rows<const C: usize>(column: &v1::Column, path: &str) -> Result<Vec<[f64; C]>, InvalidInput>
where
    f64: Number,
{
    let rows = columns::read::<f64, C>(column).map_err(|error| InvalidInput::new(path, error.to_string()))?;
    match rows.as_flattened().iter().position(|number| !number.is_finite()) {
        Some(at) => {
            let problem = format!("is {}, must be finite", rows.as_flattened()[at]);
            Err(InvalidInput::new(format!("{path}[{}][{}]", at / C, at % C), problem))
        }
        None => Ok(rows),
    }
}

fn lattice_from_wire(lattice: &v1::LatticePlacement) -> Result<Placement, InvalidInput> {
    Ok(Placement::Lattice {
        origin_m: needed_vector(&lattice.origin_m, "placement.lattice.origin_m")?,
        spacing_m: needed_vector(&lattice.spacing_m, "placement.lattice.spacing_m")?,
        counts: [lattice.count_x, lattice.count_y, lattice.count_z],
        random_orientation: lattice.random_orientation,
    })
}

fn random_from_wire(random: &v1::RandomPlacement) -> Result<Placement, InvalidInput> {
    use v1::random_placement::{Amount, Region as WireRegion};
    let region = match need(&random.region, "placement.random.region")? {
        WireRegion::Box(region) => Region::Box {
            min_m: needed_vector(&region.min_m, "placement.random.box.min_m")?,
            max_m: needed_vector(&region.max_m, "placement.random.box.max_m")?,
        },
        WireRegion::Cylinder(region) => Region::Cylinder {
            point_m: needed_vector(&region.point_m, "placement.random.cylinder.point_m")?,
            axis: needed_vector(&region.axis, "placement.random.cylinder.axis")?,
            radius_m: finite(region.radius_m, "placement.random.cylinder.radius_m")?,
            length_m: finite(region.length_m, "placement.random.cylinder.length_m")?,
        },
    };
    let (count, solid_fraction) = match need(&random.amount, "placement.random.amount")? {
        Amount::Count(count) => (Some(*count), None),
        Amount::SolidFraction(fraction) => (None, Some(finite(*fraction, "placement.random.solid_fraction")?)),
    };
    Ok(Placement::Random {
        region,
        count,
        solid_fraction,
        fixed_orientation: random.fixed_orientation,
        attempts: random.attempts.unwrap_or(DEFAULT_ATTEMPTS),
    })
}

fn deposition_from_wire(deposition: &v1::DepositionPlacement) -> Result<Placement, InvalidInput> {
    let region = need(&deposition.r#box, "placement.deposition.box")?;
    Ok(Placement::Deposition {
        region: Region::Box {
            min_m: needed_vector(&region.min_m, "placement.deposition.box.min_m")?,
            max_m: needed_vector(&region.max_m, "placement.deposition.box.max_m")?,
        },
        count: deposition.count,
        fixed_orientation: deposition.fixed_orientation,
    })
}

/// The same insertion as a request without a header; a deposition into anything but a box, which is none, has no box.
pub fn insertion_to_wire(insertion: &InsertionDescription) -> v1::InsertRequest {
    use v1::insert_request::Placement as Wire;
    let placement = match &insertion.placement {
        Placement::Poses { positions_m, orientations_wxyz } => Wire::Poses(v1::PosesPlacement {
            positions_m: Some(columns::rows("positions_m", "m", positions_m)),
            orientations_wxyz: Some(columns::rows("orientations_wxyz", "", orientations_wxyz)),
        }),
        Placement::Lattice { origin_m, spacing_m, counts, random_orientation } => Wire::Lattice(v1::LatticePlacement {
            origin_m: Some(vec3(*origin_m)),
            spacing_m: Some(vec3(*spacing_m)),
            count_x: counts[0],
            count_y: counts[1],
            count_z: counts[2],
            random_orientation: *random_orientation,
        }),
        Placement::Random { region, count, solid_fraction, fixed_orientation, attempts } => {
            use v1::random_placement::Amount;
            Wire::Random(v1::RandomPlacement {
                region: Some(region_to_wire(region)),
                amount: count.map(Amount::Count).or(solid_fraction.map(Amount::SolidFraction)),
                fixed_orientation: *fixed_orientation,
                attempts: Some(*attempts),
            })
        }
        Placement::Deposition { region, count, fixed_orientation } => Wire::Deposition(v1::DepositionPlacement {
            r#box: match region_to_wire(region) {
                v1::random_placement::Region::Box(region) => Some(region),
                v1::random_placement::Region::Cylinder(_) => None,
            },
            count: *count,
            fixed_orientation: *fixed_orientation,
        }),
    };
    let (scale, scale_law) = scale_to_wire(&insertion.scale);
    v1::InsertRequest {
        header: None,
        shape: insertion.shape.clone(),
        material: insertion.material.clone(),
        placement: Some(placement),
        velocity_m_per_s: Some(vec3(insertion.velocity_m_per_s)),
        angular_velocity_rad_per_s: Some(vec3(insertion.angular_velocity_rad_per_s)),
        scale,
        scale_law,
        frozen: insertion.frozen,
    }
}

fn region_to_wire(region: &Region) -> v1::random_placement::Region {
    use v1::random_placement::Region as Wire;
    match region {
        Region::Box { min_m, max_m } => {
            Wire::Box(v1::BoxRegion { min_m: Some(vec3(*min_m)), max_m: Some(vec3(*max_m)) })
        }
        Region::Cylinder { point_m, axis, radius_m, length_m } => Wire::Cylinder(v1::CylinderRegion {
            point_m: Some(vec3(*point_m)),
            axis: Some(vec3(*axis)),
            radius_m: *radius_m,
            length_m: *length_m,
        }),
    }
}

/// The body of `set_gravity`.
pub fn gravity_from_wire(request: &v1::SetGravityRequest) -> Result<[f64; 3], InvalidInput> {
    needed_vector(&request.gravity_m_per_s2, "gravity_m_per_s2")
}

/// The motion of `set_motion`.
pub fn motion_from_wire(request: &v1::SetMotionRequest) -> Result<MotionDescription, InvalidInput> {
    use v1::motion::Kind;
    match need(&need(&request.motion, "motion")?.kind, "motion.kind")? {
        Kind::Fixed(_) => Ok(MotionDescription::Fixed),
        Kind::Rotation(rotation) => Ok(MotionDescription::Rotation {
            point_m: needed_vector(&rotation.point_m, "motion.rotation.point_m")?,
            axis: needed_vector(&rotation.axis, "motion.rotation.axis")?,
            angular_velocity: angular_velocity_from_wire(rotation)?,
        }),
        Kind::Translation(translation) => Ok(MotionDescription::Translation {
            velocity_m_per_s: needed_vector(&translation.velocity_m_per_s, "motion.translation.velocity_m_per_s")?,
        }),
        Kind::Oscillation(wave) => Ok(MotionDescription::Oscillation {
            amplitude_m: needed_vector(&wave.amplitude_m, "motion.oscillation.amplitude_m")?,
            frequency_hz: finite(wave.frequency_hz, "motion.oscillation.frequency_hz")?,
            phase_rad: finite(wave.phase_rad, "motion.oscillation.phase_rad")?,
        }),
        Kind::Servo(servo) => Ok(MotionDescription::Servo {
            direction: needed_vector(&servo.direction, "motion.servo.direction")?,
            force_n: Some(finite(servo.force_n, "motion.servo.force_n")?),
            pressure_pa: None,
            area_m2: None,
            gain_m_per_s_per_n: finite(servo.gain_m_per_s_per_n, "motion.servo.gain_m_per_s_per_n")?,
            max_velocity_m_per_s: finite(servo.max_velocity_m_per_s, "motion.servo.max_velocity_m_per_s")?,
        }),
        Kind::Table(table) => {
            let path = "motion.table.displacements_m";
            for (k, &time) in table.times_s.iter().enumerate() {
                finite(time, &format!("motion.table.times_s[{k}]"))?;
            }
            Ok(MotionDescription::Table {
                times_s: table.times_s.clone(),
                displacements_m: finite_rows(need(&table.displacements_m, path)?, path)?,
            })
        }
    }
}

fn angular_velocity_from_wire(rotation: &v1::RotationMotion) -> Result<AngularVelocity, InvalidInput> {
    use v1::rotation_motion::AngularVelocity as Wire;
    match need(&rotation.angular_velocity, "motion.rotation.angular_velocity")? {
        Wire::Constant(constant) => Ok(AngularVelocity::Constant {
            rad_per_s: finite(constant.rad_per_s, "motion.rotation.constant.rad_per_s")?,
        }),
        Wire::Ramp(ramp) => Ok(AngularVelocity::Ramp {
            rad_per_s: finite(ramp.rad_per_s, "motion.rotation.ramp.rad_per_s")?,
            duration_s: finite(ramp.duration_s, "motion.rotation.ramp.duration_s")?,
        }),
        Wire::Oscillation(wave) => {
            let path = "motion.rotation.oscillation";
            Ok(AngularVelocity::Oscillation {
                amplitude_rad_per_s: finite(wave.amplitude_rad_per_s, &format!("{path}.amplitude_rad_per_s"))?,
                frequency_hz: finite(wave.frequency_hz, &format!("{path}.frequency_hz"))?,
                phase_rad: finite(wave.phase_rad, &format!("{path}.phase_rad"))?,
            })
        }
    }
}

fn angular_velocity_to_wire(angular_velocity: &AngularVelocity) -> v1::rotation_motion::AngularVelocity {
    use v1::rotation_motion::AngularVelocity as Wire;
    match *angular_velocity {
        AngularVelocity::Constant { rad_per_s } => Wire::Constant(v1::ConstantAngularVelocity { rad_per_s }),
        AngularVelocity::Ramp { rad_per_s, duration_s } => {
            Wire::Ramp(v1::RampAngularVelocity { rad_per_s, duration_s })
        }
        AngularVelocity::Oscillation { amplitude_rad_per_s, frequency_hz, phase_rad } => {
            Wire::Oscillation(v1::OscillationAngularVelocity { amplitude_rad_per_s, frequency_hz, phase_rad })
        }
    }
}

/// The same motion for the wire.
pub fn motion_to_wire(motion: &MotionDescription) -> v1::Motion {
    use v1::motion::Kind;
    let kind = match motion {
        MotionDescription::Fixed => Kind::Fixed(v1::FixedMotion {}),
        MotionDescription::Rotation { point_m, axis, angular_velocity } => Kind::Rotation(v1::RotationMotion {
            point_m: Some(vec3(*point_m)),
            axis: Some(vec3(*axis)),
            angular_velocity: Some(angular_velocity_to_wire(angular_velocity)),
        }),
        MotionDescription::Oscillation { amplitude_m, frequency_hz, phase_rad } => {
            let amplitude_m = Some(vec3(*amplitude_m));
            Kind::Oscillation(v1::OscillationMotion { amplitude_m, frequency_hz: *frequency_hz, phase_rad: *phase_rad })
        }
        MotionDescription::Servo {
            direction,
            force_n,
            pressure_pa,
            area_m2,
            gain_m_per_s_per_n,
            max_velocity_m_per_s,
        } => Kind::Servo(v1::ServoMotion {
            direction: Some(vec3(*direction)),
            force_n: force_n.unwrap_or(pressure_pa.unwrap_or(0.0) * area_m2.unwrap_or(0.0)),
            gain_m_per_s_per_n: *gain_m_per_s_per_n,
            max_velocity_m_per_s: *max_velocity_m_per_s,
        }),
        MotionDescription::Table { times_s, displacements_m } => Kind::Table(v1::TableMotion {
            times_s: times_s.clone(),
            displacements_m: Some(columns::rows("displacements_m", "m", displacements_m)),
        }),
        MotionDescription::Translation { velocity_m_per_s } => {
            Kind::Translation(v1::TranslationMotion { velocity_m_per_s: Some(vec3(*velocity_m_per_s)) })
        }
    };
    v1::Motion { kind: Some(kind) }
}

/// Where an `advance` believes the engine to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// At this time, bit for bit.
    Time(f64),
    /// After this step.
    Step(u64),
}

/// The start of `advance`.
pub fn advance_start(request: &v1::AdvanceRequest) -> Result<Start, InvalidInput> {
    use v1::advance_request::From;
    match need(&request.from, "from_time_s")? {
        From::FromTimeS(time) => Ok(Start::Time(finite(*time, "from_time_s")?)),
        From::FromStep(step) => Ok(Start::Step(*step)),
    }
}
