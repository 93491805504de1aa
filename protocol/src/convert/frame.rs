//! State and fields for the wire.

use sturz_engine::fields::{FieldColumn, FieldFrame, FieldQuantity};
use sturz_engine::{BoundaryState, Snapshot};

use super::command::grid_to_wire;
use super::vec3;
use crate::columns;
use crate::v1;

/// A column of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParticleColumn {
    /// Stable ids.
    Ids,
    /// Indices into the scene's shapes.
    Shapes,
    /// Indices into the scene's materials.
    Materials,
    /// Sizes relative to the shape.
    Scales,
    /// Centres of mass, m.
    Positions,
    /// `world_from_body`.
    Orientations,
    /// m/s.
    Velocities,
    /// rad/s.
    AngularVelocities,
}

/// Names of the columns on the wire.
pub const COLUMN_NAMES: [(ParticleColumn, &str); 8] = [
    (ParticleColumn::Ids, "ids"),
    (ParticleColumn::Shapes, "shapes"),
    (ParticleColumn::Materials, "materials"),
    (ParticleColumn::Scales, "scales"),
    (ParticleColumn::Positions, "positions"),
    (ParticleColumn::Orientations, "orientations"),
    (ParticleColumn::Velocities, "velocities"),
    (ParticleColumn::AngularVelocities, "angular_velocities"),
];

impl ParticleColumn {
    /// All columns, `ids` first.
    pub fn all() -> Vec<Self> {
        COLUMN_NAMES.map(|(column, _)| column).to_vec()
    }

    /// The columns of these names, `ids` first, each once; `"all"` stands for every one. `Err` is the index of a
    /// name that is none.
    pub fn select<S: AsRef<str>>(names: &[S]) -> Result<Vec<Self>, usize> {
        let mut selected = vec![Self::Ids];
        for (at, name) in names.iter().map(AsRef::as_ref).enumerate() {
            if name == "all" {
                return Ok(Self::all());
            }
            let known = COLUMN_NAMES.iter().find(|(_, known)| *known == name);
            let (column, _) = known.ok_or(at)?;
            if !selected.contains(column) {
                selected.push(*column);
            }
        }
        Ok(selected)
    }
}

/// Of the floating-point columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloatType {
    /// As the engine has them.
    #[default]
    F64,
    /// Half the bytes, rounded to nearest.
    F32,
}

impl FloatType {
    /// `None` for a type that floats cannot have.
    pub fn from_wire(dtype: i32) -> Option<Self> {
        match v1::DataType::try_from(dtype).ok()? {
            v1::DataType::Unspecified | v1::DataType::F64 => Some(Self::F64),
            v1::DataType::F32 => Some(Self::F32),
            v1::DataType::U64 | v1::DataType::U32 => None,
        }
    }

    fn column<const C: usize>(self, name: &str, unit: &str, rows: &[[f64; C]]) -> v1::Column {
        match self {
            Self::F64 => columns::rows(name, unit, rows),
            Self::F32 => {
                let rounded: Vec<f32> = rows.as_flattened().iter().map(|&x| x as f32).collect();
                columns::flat(name, unit, C, &rounded)
            }
        }
    }
}

/// Chosen columns of a snapshot. The header's `step`, `sim_time_s` and `topology_epoch` are overwritten.
pub fn frame_to_wire(
    snapshot: &Snapshot,
    chosen: &[ParticleColumn],
    float: FloatType,
    mut header: v1::Header,
) -> v1::Frame {
    header.step = snapshot.step;
    header.sim_time_s = snapshot.time_s;
    header.topology_epoch = snapshot.topology_epoch;
    v1::Frame {
        header: Some(header),
        n: snapshot.ids.len() as u64,
        columns: chosen.iter().map(|&column| column_to_wire(snapshot, column, float)).collect(),
        boundaries: snapshot.boundaries.iter().map(boundary_state).collect(),
        gravity_m_per_s2: Some(vec3(snapshot.gravity_m_per_s2)),
    }
}

fn column_to_wire(snapshot: &Snapshot, column: ParticleColumn, float: FloatType) -> v1::Column {
    match column {
        ParticleColumn::Ids => columns::flat("ids", "", 1, &snapshot.ids),
        ParticleColumn::Shapes => columns::flat("shapes", "", 1, &snapshot.shapes),
        ParticleColumn::Materials => columns::flat("materials", "", 1, &snapshot.materials),
        ParticleColumn::Scales => {
            let scales: Vec<[f64; 1]> = snapshot.scales.iter().map(|&scale| [scale]).collect();
            float.column("scales", "", &scales)
        }
        ParticleColumn::Positions => float.column("positions", "m", &snapshot.positions),
        ParticleColumn::Orientations => float.column("orientations", "", &snapshot.orientations),
        ParticleColumn::Velocities => float.column("velocities", "m/s", &snapshot.velocities),
        ParticleColumn::AngularVelocities => float.column("angular_velocities", "rad/s", &snapshot.angular_velocities),
    }
}

fn boundary_state(boundary: &BoundaryState) -> v1::BoundaryState {
    v1::BoundaryState {
        name: boundary.name.clone(),
        point_m: Some(vec3(boundary.point_m)),
        direction: Some(vec3(boundary.direction)),
        angle_rad: boundary.angle_rad,
        angular_velocity_rad_per_s: boundary.angular_velocity_rad_per_s,
        force_n: Some(vec3(boundary.force_n)),
        torque_n_m: Some(vec3(boundary.torque_n_m)),
        orientation: Some(quaternion(boundary.orientation_wxyz)),
    }
}

fn quaternion([w, x, y, z]: [f64; 4]) -> v1::Quaternion {
    v1::Quaternion { w, x, y, z }
}

/// Name of a quantity's column, and its unit.
pub fn quantity_name(quantity: FieldQuantity) -> (&'static str, &'static str) {
    match quantity {
        FieldQuantity::SolidFraction => ("solid_fraction", ""),
        FieldQuantity::Density => ("density", "kg/m3"),
        FieldQuantity::Momentum => ("momentum", "kg/(m2 s)"),
        FieldQuantity::Velocity => ("velocity", "m/s"),
        FieldQuantity::GranularTemperature => ("granular_temperature", "m2/s2"),
    }
}

/// A field for the wire. The header's `step` and `sim_time_s` are overwritten.
pub fn field_to_wire(field: &FieldFrame, mut header: v1::Header) -> v1::FieldFrame {
    header.step = field.step;
    header.sim_time_s = field.time_s;
    let column = |column: &FieldColumn| {
        let (name, unit) = quantity_name(column.quantity);
        columns::flat(name, unit, column.components, &column.data)
    };
    v1::FieldFrame {
        header: Some(header),
        name: field.name.clone(),
        grid: Some(grid_to_wire(&field.grid)),
        kernel: "truncated_gaussian".into(),
        width_m: field.width_m,
        cutoff_widths: field.cutoff_widths,
        columns: field.columns.iter().map(column).collect(),
        total_mass_kg: field.total_mass_kg,
        total_momentum_kg_m_per_s: Some(vec3(field.total_momentum_kg_m_per_s)),
    }
}
