//! Fields as images.

use sturz_protocol::columns;
use sturz_protocol::v1;

use super::exporter::ExportError;
use super::vtk::{Array, ImageData, Precision};

/// Why a field cannot be an image, whose axes are straight and those of the world.
pub fn obstacle(field: &v1::FieldFrame) -> Option<&'static str> {
    if field.grid.as_ref().is_some_and(|grid| grid.cylinder.is_some()) {
        return Some("its grid is cylindrical");
    }
    let is_turned = field.grid_orientation.is_some_and(|q| [q.x, q.y, q.z] != [0.0; 3]);
    is_turned.then_some("its grid turns with a boundary")
}

/// The grid of a field, its columns at the cells; those of standard errors end in `_standard_error`.
pub fn image(field: &v1::FieldFrame, precision: Precision) -> Result<ImageData, ExportError> {
    let bad = |what: &str| ExportError::Message(format!("field {:?}: {what}", field.name));
    let grid = field.grid.as_ref().ok_or_else(|| bad("has no grid"))?;
    let (Some(min), Some(max)) = (&grid.min_m, &grid.max_m) else { return Err(bad("its grid has no extent")) };
    let cells = [grid.cells_x, grid.cells_y, grid.cells_z];
    if cells.contains(&0) {
        return Err(bad("its grid has no cells"));
    }
    let moved = field.grid_origin_m.unwrap_or_default();
    let (min, max) = ([min.x, min.y, min.z], [max.x, max.y, max.z]);
    let spacing = std::array::from_fn(|axis| (max[axis] - min[axis]) / f64::from(cells[axis]));
    let mut cell_data = Vec::new();
    let columns = field.columns.iter().map(|column| (column, ""));
    for (column, suffix) in columns.chain(field.standard_errors.iter().map(|column| (column, "_standard_error"))) {
        // Components are read one by one: quantities to come may have any number of them.
        let flat = v1::Column { components: 1, ..column.clone() };
        let numbers = columns::read_floats::<1>(&flat).map(|rows| rows.into_flattened());
        let numbers = numbers.map_err(|error| bad(&format!("column {:?} {error}", column.name)))?;
        let components = column.components as usize;
        if numbers.len() != cells.iter().map(|&n| n as usize).product::<usize>() * components {
            return Err(bad(&format!("column {:?} has another length than the grid", column.name)));
        }
        let values = precision.values(x_fastest(&numbers, cells, components));
        cell_data.push(Array { name: format!("{}{suffix}", column.name).into(), components, values });
    }
    let origin = [min[0] + moved.x, min[1] + moved.y, min[2] + moved.z];
    Ok(ImageData { origin, spacing, cells, cell_data })
}

/// On the wire x is slowest.
fn x_fastest(numbers: &[f64], cells: [u32; 3], components: usize) -> impl Iterator<Item = f64> {
    let [nx, ny, nz] = cells.map(|n| n as usize);
    let of_cell = move |x, y, z| {
        let at = ((x * ny + y) * nz + z) * components;
        numbers[at..at + components].iter().copied()
    };
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).flat_map(move |x| of_cell(x, y, z))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::vtk::Values;

    #[test]
    fn cells_are_written_with_x_fastest() {
        let mut velocities = Vec::new();
        for x in 0..2 {
            for y in 0..3 {
                for z in 0..4 {
                    velocities.push([f64::from(x), f64::from(y), f64::from(z)]);
                }
            }
        }
        let field = v1::FieldFrame {
            grid: Some(v1::Grid {
                min_m: Some(v1::Vec3 { x: 1.0, y: 2.0, z: 3.0 }),
                max_m: Some(v1::Vec3 { x: 2.0, y: 5.0, z: 5.0 }),
                cells_x: 2,
                cells_y: 3,
                cells_z: 4,
                cylinder: None,
            }),
            columns: vec![columns::rows("velocity", "m/s", &velocities)],
            ..Default::default()
        };
        let image = image(&field, Precision::Double).unwrap();
        assert_eq!((image.origin, image.spacing, image.cells), ([1.0, 2.0, 3.0], [0.5, 1.0, 0.5], [2, 3, 4]));
        let Values::F64(values) = &image.cell_data[0].values else { panic!("doubles were asked for") };
        let expected: Vec<f64> = (0..24).flat_map(|k| [k % 2, k / 2 % 3, k / 6].map(f64::from)).collect();
        assert_eq!(*values, expected);
    }

    #[test]
    fn a_column_of_another_length_is_refused() {
        let corner = Some(v1::Vec3 { x: 0.0, y: 0.0, z: 0.0 });
        let field = v1::FieldFrame {
            name: "slice".into(),
            grid: Some(v1::Grid { min_m: corner, max_m: corner, cells_x: 2, cells_y: 1, cells_z: 1, cylinder: None }),
            columns: vec![columns::rows("density", "kg/m3", &[[1.0_f64]])],
            ..Default::default()
        };
        let refusal = image(&field, Precision::Double).unwrap_err().to_string();
        assert!(refusal.contains("slice") && refusal.contains("density"), "{refusal}");
    }
}
