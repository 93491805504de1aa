//! The contact network as lines: between the centres of two particles, or from a centre to the point on a boundary.

use sturz_protocol::v1;

use super::exporter::ExportError;
use super::geometry::{Vector, add, difference, norm};
use super::particles::Particles;
use super::table::Table;
use super::vtk::{Array, CellKind, Cells, PolyData, Precision, Values};

/// Second id of a contact with a boundary.
const NO_PARTICLE: u64 = u64::MAX;

/// Lines of a message of contacts; particles are those of a frame of the same step or the last one before.
pub fn lines(
    contacts: &v1::Frame,
    particles: &Particles,
    domain: &v1::Domain,
    precision: Precision,
) -> Result<PolyData, ExportError> {
    let table = Table { what: "contact frame", rows: contacts.n as usize, columns: &contacts.columns };
    let ids = table.needed("ids", table.numbers::<u64, 2>("ids")?)?;
    let boundaries = table.needed("boundaries", table.numbers::<u32, 1>("boundaries")?)?;
    let touching = table.needed("points", table.floats::<3>("points")?)?;
    let mut points = Vec::with_capacity(2 * ids.len());
    let (mut rows, mut cells) = (Vec::new(), Cells::default());
    for (row, &[a, b]) in ids.iter().enumerate() {
        // Particles may have come or gone between the two messages.
        let Some(centre_a) = particles.row_of(a).map(|row| particles.positions[row]) else { continue };
        let end = if b == NO_PARTICLE {
            nearest(touching[row], centre_a, domain)
        } else {
            let Some(row_b) = particles.row_of(b) else { continue };
            nearest(particles.positions[row_b], centre_a, domain)
        };
        let first = points.len() as i32;
        points.extend([centre_a, end]);
        cells.push([first, first + 1]);
        rows.push(row);
    }
    let mut cell_data = vec![
        Array::scalar("id_a", Values::I64(rows.iter().map(|&row| ids[row][0] as i64).collect())),
        // -1 at a boundary, and the other way round.
        Array::scalar("id_b", Values::I64(rows.iter().map(|&row| ids[row][1] as i64).collect())),
        Array::scalar("boundary", Values::I32(rows.iter().map(|&row| boundaries[row][0] as i32).collect())),
    ];
    for (name, column) in [("overlap", "overlaps"), ("normal_force", "normal_forces")] {
        if let Some(numbers) = table.floats::<1>(column)? {
            cell_data.push(Array::scalar(name, precision.values(rows.iter().map(|&row| numbers[row][0]))));
        }
    }
    if let Some(forces) = table.floats::<3>("tangential_forces")? {
        let sizes = rows.iter().map(|&row| norm(forces[row]));
        cell_data.push(Array::scalar("tangential_force", precision.values(sizes)));
    }
    if let Some(normals) = table.floats::<3>("normals")? {
        cell_data.push(Array::vector("normal", precision.vectors(rows.iter().map(|&row| normals[row]))));
    }
    cell_data.push(Array::vector("point", precision.vectors(rows.iter().map(|&row| touching[row]))));
    let points = precision.vectors(points.into_iter());
    Ok(PolyData { points, kind: CellKind::Lines, cells, point_data: Vec::new(), cell_data })
}

/// The periodic image of `x` nearest to `to`.
fn nearest(x: Vector, to: Vector, domain: &v1::Domain) -> Vector {
    let periodic = [domain.periodic_x, domain.periodic_y, domain.periodic_z];
    let corner = |v: &Option<v1::Vec3>| v.as_ref().map_or([0.0; 3], |v| [v.x, v.y, v.z]);
    let extent = difference(corner(&domain.max_m), corner(&domain.min_m));
    let apart = difference(x, to);
    let shift: Vector = std::array::from_fn(|axis| {
        if periodic[axis] && extent[axis] > 0.0 { (apart[axis] / extent[axis]).round() * extent[axis] } else { 0.0 }
    });
    add(x, -1.0, shift)
}

#[cfg(test)]
mod tests {
    use sturz_protocol::columns;

    use super::*;
    use crate::export::particles::Surface;

    #[test]
    fn lines_join_nearest_images_and_points_on_boundaries() {
        let frame = v1::Frame {
            n: 2,
            columns: vec![
                columns::flat("ids", "", 1, &[3_u64, 8]),
                columns::flat("shapes", "", 1, &[0_u32, 0]),
                columns::rows("positions", "m", &[[0.1_f64, 0.0, 0.0], [0.9, 0.0, 0.0]]),
            ],
            ..Default::default()
        };
        let ball = Surface { vertices: Vec::new(), triangles: Vec::new(), bounding_radius: 0.1 };
        let particles = Particles::read(&frame, &[ball]).unwrap();
        let contacts = v1::Frame {
            n: 3,
            columns: vec![
                columns::rows("ids", "", &[[3, 8], [3, NO_PARTICLE], [8, 77]]),
                columns::flat("boundaries", "", 1, &[u32::MAX, 2, u32::MAX]),
                columns::rows("points", "m", &[[0.0_f64, 0.0, 0.0], [0.1, -0.1, 0.0], [0.9, 0.1, 0.0]]),
                columns::rows("tangential_forces", "N", &[[3.0_f64, 0.0, 4.0], [0.0; 3], [0.0; 3]]),
            ],
            ..Default::default()
        };
        let domain =
            v1::Domain { max_m: Some(v1::Vec3 { x: 1.0, y: 0.0, z: 0.0 }), periodic_x: true, ..Default::default() };
        let data = lines(&contacts, &particles, &domain, Precision::Double).unwrap();
        assert_eq!(data.cells.offsets, [2, 4], "of particle 77 nothing is known");
        let Values::F64(points) = &data.points else { panic!("doubles were asked for") };
        let expected = [0.1, 0.0, 0.0, -0.1, 0.0, 0.0, 0.1, 0.0, 0.0, 0.1, -0.1, 0.0];
        assert!(points.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{points:?}");
        assert_eq!(data.cell_data[1].values, Values::I64(vec![8, -1]));
        assert_eq!(data.cell_data[2].values, Values::I32(vec![-1, 2]));
        assert_eq!(data.cell_data[3].values, Values::F64(vec![5.0, 0.0]));
    }
}
