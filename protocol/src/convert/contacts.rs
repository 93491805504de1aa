//! The contact network for the wire.

use sturz_engine::{ContactColumn, ContactKind, ContactNetwork, ContactRow, FloatType};

use super::frame::floats;
use crate::columns;
use crate::v1;

/// In `ids`, where side b is a boundary.
pub const NO_PARTICLE: u64 = u64::MAX;
/// In `boundaries`, where side b is a particle.
pub const NO_BOUNDARY: u32 = u32::MAX;

/// Chosen columns of a contact network. The header's `step`, `sim_time_s` and `topology_epoch` are overwritten.
pub fn contacts_to_wire(
    network: &ContactNetwork,
    chosen: &[ContactColumn],
    float: FloatType,
    mut header: v1::Header,
) -> v1::ContactFrame {
    header.step = network.step;
    header.sim_time_s = network.time_s;
    header.topology_epoch = network.topology_epoch;
    v1::ContactFrame {
        header: Some(header),
        n: network.rows.len() as u64,
        columns: chosen.iter().map(|&column| column_to_wire(&network.rows, column, float)).collect(),
    }
}

fn column_to_wire(rows: &[ContactRow], column: ContactColumn, float: FloatType) -> v1::Column {
    let name = column.name();
    let number = |unit: &str, of: fn(&ContactRow) -> f64| {
        let numbers: Vec<[f64; 1]> = rows.iter().map(|row| [of(row)]).collect();
        floats(float, name, unit, &numbers)
    };
    let vector = |unit: &str, of: fn(&ContactRow) -> [f64; 3]| {
        let vectors: Vec<[f64; 3]> = rows.iter().map(of).collect();
        floats(float, name, unit, &vectors)
    };
    let whole = |of: fn(&ContactRow) -> u32| {
        let numbers: Vec<u32> = rows.iter().map(of).collect();
        columns::flat(name, "", 1, &numbers)
    };
    match column {
        ContactColumn::Ids => {
            let ids: Vec<[u64; 2]> = rows.iter().map(|row| [row.id_a, row.id_b.unwrap_or(NO_PARTICLE)]).collect();
            columns::rows(name, "", &ids)
        }
        ContactColumn::Boundaries => whole(|row| row.boundary.unwrap_or(NO_BOUNDARY)),
        ContactColumn::Parts => {
            let parts: Vec<[u32; 2]> = rows.iter().map(|row| row.parts).collect();
            columns::rows(name, "", &parts)
        }
        ContactColumn::Points => vector("m", |row| row.point_m),
        ContactColumn::Normals => vector("", |row| row.normal),
        ContactColumn::Overlaps => number("m", |row| row.overlap_m),
        ContactColumn::NormalForces => number("N", |row| row.normal_force_n),
        ContactColumn::TangentialForces => vector("N", |row| row.tangential_force_n),
        ContactColumn::Moments => vector("N m", |row| row.moment_n_m),
        ContactColumn::Kinds => whole(|row| kind_to_wire(row.kind) as u32),
        ContactColumn::PointCounts => whole(|row| row.points),
    }
}

fn kind_to_wire(kind: ContactKind) -> v1::ContactKind {
    match kind {
        ContactKind::Smooth => v1::ContactKind::Smooth,
        ContactKind::VertexFace => v1::ContactKind::VertexFace,
        ContactKind::EdgeEdge => v1::ContactKind::EdgeEdge,
        ContactKind::Manifold => v1::ContactKind::Manifold,
        ContactKind::Overlap => v1::ContactKind::Overlap,
    }
}
