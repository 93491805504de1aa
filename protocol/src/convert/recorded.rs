//! States and contacts as they were recorded, back into the engine's types.

use sturz_engine::{BoundaryState, ContactKind, ContactNetwork, ContactRow, InvalidInput, Snapshot};

use super::contacts::{NO_BOUNDARY, NO_PARTICLE};
use super::{need, vector};
use crate::columns::{self, ColumnError, Number};
use crate::v1;

/// A recorded state; forces, torques and who is frozen are left out.
///
/// # Errors
/// A column that fields need is missing, or is not what it should be.
pub fn snapshot_from_wire(frame: &v1::Frame) -> Result<Snapshot, InvalidInput> {
    let header = need(&frame.header, "frame.header")?;
    let table = Table { columns: &frame.columns, rows: frame.n as usize, of: "state" };
    Ok(Snapshot {
        step: header.step,
        time_s: header.sim_time_s,
        topology_epoch: header.topology_epoch,
        gravity_m_per_s2: vector(&frame.gravity_m_per_s2.unwrap_or_default(), "frame.gravity_m_per_s2")?,
        ids: table.whole::<u64, 1>("ids")?.into_flattened(),
        shapes: table.whole::<u32, 1>("shapes")?.into_flattened(),
        materials: table.whole::<u32, 1>("materials")?.into_flattened(),
        scales: table.floats::<1>("scales")?.into_flattened(),
        positions: table.floats("positions")?,
        orientations: table.floats("orientations")?,
        velocities: table.floats("velocities")?,
        angular_velocities: table.floats("angular_velocities")?,
        boundaries: frame.boundaries.iter().map(boundary_from_wire).collect::<Result<_, _>>()?,
        ..Snapshot::default()
    })
}

/// The recorded contacts of a state; moments, overlaps and parts are left out.
///
/// # Errors
/// A column that fields need is missing, or is not what it should be.
pub fn contacts_from_wire(frame: &v1::ContactFrame) -> Result<ContactNetwork, InvalidInput> {
    let header = need(&frame.header, "contacts.header")?;
    let table = Table { columns: &frame.columns, rows: frame.n as usize, of: "contacts" };
    let ids = table.whole::<u64, 2>("ids")?;
    let boundaries = table.whole::<u32, 1>("boundaries")?;
    let points = table.floats::<3>("points")?;
    let normals = table.floats::<3>("normals")?;
    let normal_forces = table.floats::<1>("normal_forces")?;
    let tangential_forces = table.floats::<3>("tangential_forces")?;
    let kinds = table.whole::<u32, 1>("kinds")?;
    let row = |k: usize| ContactRow {
        id_a: ids[k][0],
        id_b: (ids[k][1] != NO_PARTICLE).then_some(ids[k][1]),
        boundary: (boundaries[k][0] != NO_BOUNDARY).then_some(boundaries[k][0]),
        point_m: points[k],
        normal: normals[k],
        normal_force_n: normal_forces[k][0],
        tangential_force_n: tangential_forces[k],
        kind: kind_from_wire(kinds[k][0]),
        ..ContactRow::default()
    };
    Ok(ContactNetwork {
        step: header.step,
        time_s: header.sim_time_s,
        topology_epoch: header.topology_epoch,
        rows: (0..table.rows).map(row).collect(),
    })
}

/// Columns of so many rows.
struct Table<'a> {
    columns: &'a [v1::Column],
    rows: usize,
    of: &'static str,
}

impl Table<'_> {
    fn column<T, const C: usize>(
        &self,
        name: &str,
        read: impl Fn(&v1::Column) -> Result<Vec<[T; C]>, ColumnError>,
    ) -> Result<Vec<[T; C]>, InvalidInput> {
        let error = |problem: String| InvalidInput::new(format!("{}.{name}", self.of), problem);
        let column = self.columns.iter().find(|column| column.name == name);
        let column = column.ok_or_else(|| error("was not recorded".into()))?;
        let rows = read(column).map_err(|problem| error(problem.to_string()))?;
        if rows.len() == self.rows {
            Ok(rows)
        } else {
            Err(error(format!("has {} rows instead of {}", rows.len(), self.rows)))
        }
    }

    fn whole<T: Number, const C: usize>(&self, name: &str) -> Result<Vec<[T; C]>, InvalidInput> {
        self.column(name, columns::read::<T, C>)
    }

    fn floats<const C: usize>(&self, name: &str) -> Result<Vec<[f64; C]>, InvalidInput> {
        self.column(name, columns::read_floats::<C>)
    }
}

fn boundary_from_wire(state: &v1::BoundaryState) -> Result<BoundaryState, InvalidInput> {
    let given = |value: &Option<v1::Vec3>, key: &str| {
        vector(&value.unwrap_or_default(), &format!("boundaries.{}.{key}", state.name))
    };
    let q = state.orientation.unwrap_or(v1::Quaternion { w: 1.0, x: 0.0, y: 0.0, z: 0.0 });
    Ok(BoundaryState {
        name: state.name.clone(),
        point_m: given(&state.point_m, "point_m")?,
        direction: given(&state.direction, "direction")?,
        angle_rad: state.angle_rad,
        angular_velocity_rad_per_s: state.angular_velocity_rad_per_s,
        force_n: given(&state.force_n, "force_n")?,
        torque_n_m: given(&state.torque_n_m, "torque_n_m")?,
        orientation_wxyz: [q.w, q.x, q.y, q.z],
    })
}

fn kind_from_wire(kind: u32) -> ContactKind {
    match v1::ContactKind::try_from(kind as i32) {
        Ok(v1::ContactKind::VertexFace) => ContactKind::VertexFace,
        Ok(v1::ContactKind::EdgeEdge) => ContactKind::EdgeEdge,
        Ok(v1::ContactKind::Manifold) => ContactKind::Manifold,
        Ok(v1::ContactKind::Overlap) => ContactKind::Overlap,
        _ => ContactKind::Smooth,
    }
}
