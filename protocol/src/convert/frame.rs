//! The state for the wire.

use sturz_engine::{BoundaryState, FloatType, ParticleColumn, Snapshot};

use super::vec3;
use crate::columns;
use crate::v1;

/// `None` for a type that floats cannot have; f64 where it was left out.
pub fn float_from_wire(dtype: i32) -> Option<FloatType> {
    match v1::DataType::try_from(dtype).ok()? {
        v1::DataType::Unspecified | v1::DataType::F64 => Some(FloatType::F64),
        v1::DataType::F32 => Some(FloatType::F32),
        v1::DataType::U64 | v1::DataType::U32 => None,
    }
}

/// The same type for the wire.
pub fn float_to_wire(float: FloatType) -> v1::DataType {
    match float {
        FloatType::F64 => v1::DataType::F64,
        FloatType::F32 => v1::DataType::F32,
    }
}

/// Floats of `components` per row.
pub(super) fn flat_floats(float: FloatType, name: &str, unit: &str, components: usize, numbers: &[f64]) -> v1::Column {
    match float {
        FloatType::F64 => columns::flat(name, unit, components, numbers),
        FloatType::F32 => {
            let rounded: Vec<f32> = numbers.iter().map(|&x| x as f32).collect();
            columns::flat(name, unit, components, &rounded)
        }
    }
}

/// Floats of `C` components per row.
pub(super) fn floats<const C: usize>(float: FloatType, name: &str, unit: &str, rows: &[[f64; C]]) -> v1::Column {
    flat_floats(float, name, unit, C, rows.as_flattened())
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
    let name = column.name();
    match column {
        ParticleColumn::Ids => columns::flat(name, "", 1, &snapshot.ids),
        ParticleColumn::Shapes => columns::flat(name, "", 1, &snapshot.shapes),
        ParticleColumn::Materials => columns::flat(name, "", 1, &snapshot.materials),
        ParticleColumn::Scales => flat_floats(float, name, "", 1, &snapshot.scales),
        ParticleColumn::Positions => floats(float, name, "m", &snapshot.positions),
        ParticleColumn::Orientations => floats(float, name, "", &snapshot.orientations),
        ParticleColumn::Velocities => floats(float, name, "m/s", &snapshot.velocities),
        ParticleColumn::AngularVelocities => floats(float, name, "rad/s", &snapshot.angular_velocities),
        ParticleColumn::Forces => floats(float, name, "N", &snapshot.forces),
        ParticleColumn::Torques => floats(float, name, "N m", &snapshot.torques),
        ParticleColumn::Frozen if snapshot.frozen.is_empty() => {
            columns::flat(name, "", 1, &vec![0u32; snapshot.ids.len()])
        }
        ParticleColumn::Frozen => columns::flat(name, "", 1, &snapshot.frozen),
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
