//! What is measured at the end of a run, or averaged over its last part.

use std::fmt;

use nalgebra::{Quaternion, UnitQuaternion};
use sturz_engine::fields::{FieldDefinition, FieldQuantity};
use sturz_engine::scene::SceneDescription;
use sturz_engine::{EnergyBalance, Engine, Snapshot};

use crate::commands::Failure;

/// A quantity of the state, one or more numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// `position[ID]`, m.
    Position(u64),
    /// `velocity[ID]`, m/s.
    Velocity(u64),
    /// `angular_velocity[ID]`, rad/s.
    AngularVelocity(u64),
    /// `orientation[ID]`: quaternion (w, x, y, z); its error is the angle between two orientations, rad.
    Orientation(u64),
    /// `centre_of_mass`, m, of positions wrapped into the periodic cell.
    CentreOfMass,
    /// `mean_height`: centre of mass against gravity, m.
    MeanHeight,
    /// `kinetic_energy`, J, with rotation.
    KineticEnergy,
    /// `potential_energy`, J.
    PotentialEnergy,
    /// `elastic_energy`, J.
    ElasticEnergy,
    /// `dissipated_energy`, J: dashpots, friction, local damping.
    DissipatedEnergy,
    /// `energy_residual`: what the balance does not account for, over its largest term. Exactly 0.
    EnergyResidual,
    /// `force_residual`: sum of the forces between particles over the largest, 0 exactly.
    ForceResidual,
    /// `largest_overlap` over the smaller bounding radius.
    LargestOverlap,
    /// `coordination_number`: touching neighbours per particle, without boundaries.
    CoordinationNumber,
    /// `force_on[BOUNDARY]`, N.
    ForceOn(String),
    /// `torque_on[BOUNDARY]` about its point, N m.
    TorqueOn(String),
    /// `field[NAME.QUANTITY]`: every cell of a field of the scene.
    Field(Box<FieldDefinition>, FieldQuantity),
}

/// Names of all measures, for messages.
pub const MEASURES: &str = "position[ID], velocity[ID], angular_velocity[ID], orientation[ID], centre_of_mass, mean_height, \
    kinetic_energy, potential_energy, elastic_energy, dissipated_energy, energy_residual, force_residual, largest_overlap, \
    coordination_number, force_on[BOUNDARY], torque_on[BOUNDARY], field[NAME.QUANTITY]";

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Measure::Position(id) => write!(f, "position[{id}]"),
            Measure::Velocity(id) => write!(f, "velocity[{id}]"),
            Measure::AngularVelocity(id) => write!(f, "angular_velocity[{id}]"),
            Measure::Orientation(id) => write!(f, "orientation[{id}]"),
            Measure::CentreOfMass => f.write_str("centre_of_mass"),
            Measure::MeanHeight => f.write_str("mean_height"),
            Measure::KineticEnergy => f.write_str("kinetic_energy"),
            Measure::PotentialEnergy => f.write_str("potential_energy"),
            Measure::ElasticEnergy => f.write_str("elastic_energy"),
            Measure::DissipatedEnergy => f.write_str("dissipated_energy"),
            Measure::EnergyResidual => f.write_str("energy_residual"),
            Measure::ForceResidual => f.write_str("force_residual"),
            Measure::LargestOverlap => f.write_str("largest_overlap"),
            Measure::CoordinationNumber => f.write_str("coordination_number"),
            Measure::ForceOn(name) => write!(f, "force_on[{name}]"),
            Measure::TorqueOn(name) => write!(f, "torque_on[{name}]"),
            Measure::Field(field, quantity) => write!(f, "field[{}.{}]", field.name, quantity_name(*quantity)),
        }
    }
}

/// As in scene files.
fn quantity_name(quantity: FieldQuantity) -> String {
    serde_json::to_value(quantity).ok().and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

impl Measure {
    /// Reads a measure; names of boundaries and fields must be those of the scene.
    pub fn parse(text: &str, scene: &SceneDescription) -> Result<Self, Failure> {
        let (name, argument) = match text.split_once('[') {
            Some((name, rest)) => (name, rest.strip_suffix(']').ok_or_else(|| unknown(text))?),
            None => (text, ""),
        };
        let id = || argument.parse::<u64>().map_err(|_| unknown(text));
        Ok(match (name, argument.is_empty()) {
            ("position", false) => Measure::Position(id()?),
            ("velocity", false) => Measure::Velocity(id()?),
            ("angular_velocity", false) => Measure::AngularVelocity(id()?),
            ("orientation", false) => Measure::Orientation(id()?),
            ("centre_of_mass", true) => Measure::CentreOfMass,
            ("mean_height", true) => Measure::MeanHeight,
            ("kinetic_energy", true) => Measure::KineticEnergy,
            ("potential_energy", true) => Measure::PotentialEnergy,
            ("elastic_energy", true) => Measure::ElasticEnergy,
            ("dissipated_energy", true) => Measure::DissipatedEnergy,
            ("energy_residual", true) => Measure::EnergyResidual,
            ("force_residual", true) => Measure::ForceResidual,
            ("largest_overlap", true) => Measure::LargestOverlap,
            ("coordination_number", true) => Measure::CoordinationNumber,
            ("force_on", false) => Measure::ForceOn(boundary(argument, scene)?),
            ("torque_on", false) => Measure::TorqueOn(boundary(argument, scene)?),
            ("field", false) => field(argument, scene)?,
            _ => return Err(unknown(text)),
        })
    }

    /// Value that holds for every scene, where there is one.
    pub fn exact(&self) -> Option<f64> {
        matches!(self, Measure::EnergyResidual | Measure::ForceResidual).then_some(0.0)
    }

    /// Whether its own unit is kept: it is relative, or an angle, by itself.
    pub fn is_relative(&self) -> bool {
        matches!(self, Measure::EnergyResidual | Measure::ForceResidual | Measure::Orientation(_))
    }

    /// Distance of two values, in the unit of the measure.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        match self {
            Measure::Orientation(_) if a.len() == 4 && b.len() == 4 => angle(a, b),
            Measure::Field(..) => (squared(a, b) / a.len().max(1) as f64).sqrt(),
            _ => squared(a, b).sqrt(),
        }
    }

    /// Reads it off a state. `snapshot` is a buffer.
    pub fn read(&self, engine: &mut Engine, snapshot: &mut Snapshot) -> Result<Vec<f64>, String> {
        match self {
            Measure::Position(id) | Measure::Velocity(id) | Measure::AngularVelocity(id) | Measure::Orientation(id) => {
                engine.snapshot(snapshot);
                let place = snapshot.ids.binary_search(id).map_err(|_| format!("there is no particle {id}"))?;
                Ok(match self {
                    Measure::Position(_) => snapshot.positions[place].to_vec(),
                    Measure::Velocity(_) => snapshot.velocities[place].to_vec(),
                    Measure::AngularVelocity(_) => snapshot.angular_velocities[place].to_vec(),
                    _ => snapshot.orientations[place].to_vec(),
                })
            }
            Measure::ForceOn(name) | Measure::TorqueOn(name) => {
                engine.snapshot(snapshot);
                let state = snapshot.boundaries.iter().find(|state| state.name == *name);
                let state = state.ok_or_else(|| format!("there is no boundary '{name}'"))?;
                Ok(if matches!(self, Measure::ForceOn(_)) { state.force_n } else { state.torque_n_m }.to_vec())
            }
            Measure::CentreOfMass => Ok(centre_of_mass(engine, snapshot)?.to_vec()),
            Measure::MeanHeight => {
                let (centre, g) = (centre_of_mass(engine, snapshot)?, snapshot.gravity_m_per_s2);
                let norm = g.iter().map(|g| g * g).sum::<f64>().sqrt();
                if norm == 0.0 {
                    return Err("mean_height needs gravity".into());
                }
                Ok(vec![-(0..3).map(|k| centre[k] * g[k]).sum::<f64>() / norm])
            }
            Measure::Field(definition, quantity) => {
                let frame = engine.compute_field(definition);
                let column = frame.columns.into_iter().find(|column| column.quantity == *quantity);
                Ok(column.map(|column| column.data).unwrap_or_default())
            }
            _ => Ok(vec![self.of_the_report(engine)]),
        }
    }

    fn of_the_report(&self, engine: &Engine) -> f64 {
        let report = engine.report();
        let energy = &report.energy;
        let dissipated = energy.dissipated_normal_j + energy.dissipated_friction_j + energy.dissipated_local_j;
        match self {
            Measure::KineticEnergy => energy.kinetic_translation_j + energy.kinetic_rotation_j,
            Measure::PotentialEnergy => energy.potential_j,
            Measure::ElasticEnergy => energy.elastic_j,
            Measure::DissipatedEnergy => dissipated,
            Measure::EnergyResidual => over(energy.residual_j, largest_term(energy)),
            Measure::ForceResidual => {
                let mut snapshot = Snapshot::default();
                engine.snapshot_forces(&mut snapshot);
                let norm2 = |f: &[f64; 3]| f.iter().map(|f| f * f).sum::<f64>();
                over(report.internal_force_residual_n, snapshot.forces.iter().map(norm2).fold(0.0, f64::max).sqrt())
            }
            Measure::LargestOverlap => report.largest_overlap_ratio_so_far,
            _ => over(2.0 * report.touching_pairs as f64, report.particles as f64),
        }
    }
}

fn unknown(text: &str) -> Failure {
    Failure::Usage(format!("--measure: '{text}' is not known; there are {MEASURES}"))
}

fn boundary(name: &str, scene: &SceneDescription) -> Result<String, Failure> {
    let names: Vec<&str> = scene.boundaries.iter().map(|boundary| boundary.name.as_str()).collect();
    if names.iter().any(|known| name == *known || name.split('/').next() == Some(*known)) {
        return Ok(name.into());
    }
    Err(Failure::Usage(format!("--measure: no boundary '{name}'; the scene has {names:?}")))
}

fn field(argument: &str, scene: &SceneDescription) -> Result<Measure, Failure> {
    let names: Vec<&str> = scene.fields.iter().map(|field| field.name.as_str()).collect();
    let problem = |what: String| Failure::Usage(format!("--measure: field[{argument}]: {what}"));
    let (name, quantity) = argument.rsplit_once('.').ok_or_else(|| problem("give field[NAME.QUANTITY]".into()))?;
    let quantity: FieldQuantity = serde_json::from_value(serde_json::Value::String(quantity.into()))
        .map_err(|error| problem(error.to_string()))?;
    let field = scene.fields.iter().find(|field| field.name == name);
    let mut field = field.cloned().ok_or_else(|| problem(format!("the scene has the fields {names:?}")))?;
    field.quantities = vec![quantity];
    Ok(Measure::Field(Box::new(field), quantity))
}

fn squared(a: &[f64], b: &[f64]) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

fn angle(a: &[f64], b: &[f64]) -> f64 {
    let unit = |q: &[f64]| UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3]));
    unit(a).angle_to(&unit(b))
}

fn over(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 { numerator / denominator } else { 0.0 }
}

/// Of the balance, by amount, J.
fn largest_term(energy: &EnergyBalance) -> f64 {
    [
        energy.kinetic_translation_j,
        energy.kinetic_rotation_j,
        energy.potential_j,
        energy.elastic_j,
        energy.dissipated_normal_j,
        energy.dissipated_friction_j,
        energy.dissipated_local_j,
        energy.work_boundaries_j,
        energy.work_commands_j,
        energy.work_loads_j,
    ]
    .into_iter()
    .fold(0.0, |largest, joule| largest.max(joule.abs()))
}

/// Leaves the snapshot filled.
fn centre_of_mass(engine: &Engine, snapshot: &mut Snapshot) -> Result<[f64; 3], String> {
    engine.snapshot(snapshot);
    let scene = engine.scene();
    let mut sum = [0.0; 3];
    let mut total = 0.0;
    for row in 0..snapshot.ids.len() {
        let volume = scene.shapes()[snapshot.shapes[row] as usize].mass_properties().volume;
        let material = &scene.description().materials[snapshot.materials[row] as usize];
        let mass = material.density_kg_per_m3.unwrap_or(0.0) * volume * snapshot.scales[row].powi(3);
        total += mass;
        for (sum, x) in sum.iter_mut().zip(snapshot.positions[row]) {
            *sum += mass * x;
        }
    }
    if total > 0.0 { Ok(sum.map(|s| s / total)) } else { Err("there are no particles".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;

    #[test]
    fn measures_are_read_as_they_are_written_and_unknown_ones_are_refused() {
        let scene = scenes::read("drum-spheres").unwrap_or_else(|failure| panic!("{failure}"));
        let boundary = &scene.boundaries[0].name;
        let force = format!("force_on[{boundary}]");
        for text in ["position[3]", "orientation[0]", "mean_height", "energy_residual", &force] {
            assert_eq!(Measure::parse(text, &scene).unwrap().to_string(), text);
        }
        for text in
            ["speed", "position", "position[x]", "mean_height[1]", "force_on[nowhere]", "field[a]", "field[a.b]"]
        {
            assert_eq!(Measure::parse(text, &scene).unwrap_err().exit_code(), 2, "{text}");
        }
    }

    #[test]
    fn orientations_differ_by_their_angle_whatever_the_sign() {
        let (half, measure) = (0.05f64, Measure::Orientation(0));
        let turned = [half.cos(), 0.0, half.sin(), 0.0];
        let opposite = turned.map(|c| -c);
        for q in [turned, opposite] {
            assert!((measure.distance(&[1.0, 0.0, 0.0, 0.0], &q) - 0.1).abs() < 1e-12);
        }
    }
}
