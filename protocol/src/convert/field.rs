//! Fields: what is asked for, and what was sampled.

use sturz_engine::InvalidInput;
use sturz_engine::fields::{
    AverageWindow, BodyAxis, DEFAULT_CUTOFF_WIDTHS, FieldAverage, FieldColumn, FieldDefinition, FieldFrame,
    FieldKernel, FieldQuantity, Grid, GridCylinder, GridMotion,
};

use super::frame::flat_floats;
use super::{finite, need, needed_vector, vec3, vector};
use crate::v1;

/// Blocks of a mean where nothing is said.
const DEFAULT_BLOCKS: u32 = 20;

/// The definition in `define_field`.
pub fn field_definition_from_wire(field: &v1::FieldDefinition) -> Result<FieldDefinition, InvalidInput> {
    let quantities = field.quantities.iter().enumerate().map(|(at, &quantity)| {
        quantity_from_wire(quantity).ok_or_else(|| {
            InvalidInput::new(format!("field.quantities[{at}]"), format!("is {quantity}: no such quantity"))
        })
    });
    let more_widths = field.more_widths_m.iter().enumerate();
    let unknown = |key: &str, value: i32| InvalidInput::new(format!("field.{key}"), format!("is {value}: unknown"));
    Ok(FieldDefinition {
        name: field.name.clone(),
        grid: grid_from_wire(need(&field.grid, "field.grid")?)?,
        quantities: quantities.collect::<Result<_, _>>()?,
        width_m: finite(field.width_m, "field.width_m")?,
        cutoff_widths: finite(field.cutoff_widths.unwrap_or(DEFAULT_CUTOFF_WIDTHS), "field.cutoff_widths")?,
        more_widths_m: more_widths
            .map(|(at, &width)| finite(width, &format!("field.more_widths_m[{at}]")))
            .collect::<Result<_, _>>()?,
        kernel: kernel_from_wire(field.kernel).ok_or_else(|| unknown("kernel", field.kernel))?,
        wall_correction: field.wall_correction,
        body_axis: body_axis_from_wire(field.body_axis).ok_or_else(|| unknown("body_axis", field.body_axis))?,
        average: field.average.as_ref().map(average_from_wire).transpose()?,
        motion: field.motion.as_ref().map(motion_from_wire).transpose()?,
    })
}

/// The same definition for the wire.
pub fn field_definition_to_wire(field: &FieldDefinition) -> v1::FieldDefinition {
    v1::FieldDefinition {
        name: field.name.clone(),
        grid: Some(grid_to_wire(&field.grid)),
        quantities: field.quantities.iter().map(|&quantity| quantity_to_wire(quantity).into()).collect(),
        width_m: field.width_m,
        cutoff_widths: Some(field.cutoff_widths),
        kernel: kernel_to_wire(field.kernel).into(),
        more_widths_m: field.more_widths_m.clone(),
        wall_correction: field.wall_correction,
        body_axis: body_axis_to_wire(field.body_axis).into(),
        average: field.average.as_ref().map(average_to_wire),
        motion: field.motion.as_ref().map(motion_to_wire),
    }
}

fn grid_from_wire(grid: &v1::Grid) -> Result<Grid, InvalidInput> {
    let path = |key: &str| format!("field.grid.cylinder.{key}");
    let cylinder = |wire: &v1::GridCylinder| {
        Ok(GridCylinder {
            point_m: needed_vector(&wire.point_m, &path("point_m"))?,
            axis: needed_vector(&wire.axis, &path("axis"))?,
            zero: wire.zero.as_ref().map(|zero| vector(zero, &path("zero"))).transpose()?,
        })
    };
    Ok(Grid {
        min_m: needed_vector(&grid.min_m, "field.grid.min_m")?,
        max_m: needed_vector(&grid.max_m, "field.grid.max_m")?,
        cells: [grid.cells_x, grid.cells_y, grid.cells_z],
        cylinder: grid.cylinder.as_ref().map(cylinder).transpose()?,
    })
}

fn grid_to_wire(grid: &Grid) -> v1::Grid {
    let cylinder = |cylinder: &GridCylinder| v1::GridCylinder {
        point_m: Some(vec3(cylinder.point_m)),
        axis: Some(vec3(cylinder.axis)),
        zero: cylinder.zero.map(vec3),
    };
    v1::Grid {
        min_m: Some(vec3(grid.min_m)),
        max_m: Some(vec3(grid.max_m)),
        cells_x: grid.cells[0],
        cells_y: grid.cells[1],
        cells_z: grid.cells[2],
        cylinder: grid.cylinder.as_ref().map(cylinder),
    }
}

fn average_from_wire(average: &v1::FieldAverage) -> Result<FieldAverage, InvalidInput> {
    let window = match v1::AverageWindow::try_from(average.window) {
        Ok(v1::AverageWindow::Unspecified | v1::AverageWindow::Growing) => AverageWindow::Growing,
        Ok(v1::AverageWindow::Sliding) => AverageWindow::Sliding,
        Err(_) => return Err(InvalidInput::new("field.average.window", format!("is {}: unknown", average.window))),
    };
    Ok(FieldAverage {
        every_steps: average.every_steps,
        samples_per_block: average.samples_per_block,
        blocks: average.blocks.unwrap_or(DEFAULT_BLOCKS),
        window,
        from_time_s: finite(average.from_time_s, "field.average.from_time_s")?,
    })
}

fn average_to_wire(average: &FieldAverage) -> v1::FieldAverage {
    let window = match average.window {
        AverageWindow::Growing => v1::AverageWindow::Growing,
        AverageWindow::Sliding => v1::AverageWindow::Sliding,
    };
    v1::FieldAverage {
        every_steps: average.every_steps,
        samples_per_block: average.samples_per_block,
        blocks: Some(average.blocks),
        window: window.into(),
        from_time_s: average.from_time_s,
    }
}

fn motion_from_wire(motion: &v1::GridMotion) -> Result<GridMotion, InvalidInput> {
    use v1::grid_motion::Motion as Wire;
    Ok(match need(&motion.motion, "field.motion")? {
        Wire::TranslationMPerS(velocity) => {
            GridMotion::Translation { velocity_m_per_s: vector(velocity, "field.motion.translation_m_per_s")? }
        }
        Wire::Boundary(name) => GridMotion::Boundary { name: name.clone() },
    })
}

fn motion_to_wire(motion: &GridMotion) -> v1::GridMotion {
    use v1::grid_motion::Motion as Wire;
    let motion = match motion {
        GridMotion::Translation { velocity_m_per_s } => Wire::TranslationMPerS(vec3(*velocity_m_per_s)),
        GridMotion::Boundary { name } => Wire::Boundary(name.clone()),
    };
    v1::GridMotion { motion: Some(motion) }
}

fn kernel_from_wire(kernel: i32) -> Option<FieldKernel> {
    Some(match v1::FieldKernel::try_from(kernel).ok()? {
        v1::FieldKernel::Unspecified | v1::FieldKernel::Gaussian => FieldKernel::Gaussian,
        v1::FieldKernel::Lucy => FieldKernel::Lucy,
        v1::FieldKernel::Heaviside => FieldKernel::Heaviside,
    })
}

fn kernel_to_wire(kernel: FieldKernel) -> v1::FieldKernel {
    match kernel {
        FieldKernel::Gaussian => v1::FieldKernel::Gaussian,
        FieldKernel::Lucy => v1::FieldKernel::Lucy,
        FieldKernel::Heaviside => v1::FieldKernel::Heaviside,
    }
}

fn kernel_name(kernel: FieldKernel) -> &'static str {
    match kernel {
        FieldKernel::Gaussian => "truncated_gaussian",
        FieldKernel::Lucy | FieldKernel::Heaviside => kernel.name(),
    }
}

fn body_axis_from_wire(axis: i32) -> Option<BodyAxis> {
    Some(match v1::BodyAxis::try_from(axis).ok()? {
        v1::BodyAxis::Unspecified | v1::BodyAxis::Longest => BodyAxis::Longest,
        v1::BodyAxis::Shortest => BodyAxis::Shortest,
        v1::BodyAxis::X => BodyAxis::X,
        v1::BodyAxis::Y => BodyAxis::Y,
        v1::BodyAxis::Z => BodyAxis::Z,
    })
}

fn body_axis_to_wire(axis: BodyAxis) -> v1::BodyAxis {
    match axis {
        BodyAxis::Longest => v1::BodyAxis::Longest,
        BodyAxis::Shortest => v1::BodyAxis::Shortest,
        BodyAxis::X => v1::BodyAxis::X,
        BodyAxis::Y => v1::BodyAxis::Y,
        BodyAxis::Z => v1::BodyAxis::Z,
    }
}

/// What precedes the name of a quantity in capitals.
const PREFIX: &str = "FIELD_QUANTITY_";

fn quantity_from_wire(quantity: i32) -> Option<FieldQuantity> {
    let name = v1::FieldQuantity::try_from(quantity).ok()?.as_str_name().strip_prefix(PREFIX)?.to_lowercase();
    FieldQuantity::named(&name)
}

/// Of every quantity, which a test sees to; else unspecified.
fn quantity_to_wire(quantity: FieldQuantity) -> v1::FieldQuantity {
    let name = format!("{PREFIX}{}", quantity.name().to_uppercase());
    v1::FieldQuantity::from_str_name(&name).unwrap_or_default()
}

/// Name of a quantity's column, and its unit.
pub fn quantity_name(quantity: FieldQuantity) -> (&'static str, &'static str) {
    (quantity.name(), quantity.unit())
}

/// Chosen columns of a field for the wire; all when none is chosen. The header's `step` and `sim_time_s` are overwritten.
pub fn field_to_wire(
    field: &FieldFrame,
    chosen: &[FieldQuantity],
    float: sturz_engine::FloatType,
    mut header: v1::Header,
) -> v1::FieldFrame {
    header.step = field.step;
    header.sim_time_s = field.time_s;
    let is_chosen = |column: &&FieldColumn| chosen.is_empty() || chosen.contains(&column.quantity);
    let encode = |column: &FieldColumn, data: &[f64]| {
        let (name, unit) = quantity_name(column.quantity);
        flat_floats(float, name, unit, column.components, data)
    };
    let means = |columns: &[FieldColumn]| -> Vec<v1::Column> {
        columns.iter().filter(is_chosen).map(|column| encode(column, &column.data)).collect()
    };
    let errors = |columns: &[FieldColumn]| -> Vec<v1::Column> {
        let with_errors =
            columns.iter().filter(is_chosen).filter_map(|column| Some((column, column.standard_error.as_ref()?)));
        with_errors.map(|(column, error)| encode(column, error)).collect()
    };
    let more = field.more_widths.iter().map(|width| v1::FieldWidth {
        width_m: width.width_m,
        columns: means(&width.columns),
        standard_errors: errors(&width.columns),
    });
    let [w, x, y, z] = field.grid_orientation_wxyz;
    let is_moved = field.grid_origin_m != [0.0; 3] || [x, y, z] != [0.0; 3];
    v1::FieldFrame {
        header: Some(header),
        name: field.name.clone(),
        grid: Some(grid_to_wire(&field.grid)),
        kernel: kernel_name(field.kernel).into(),
        width_m: field.width_m,
        cutoff_widths: field.cutoff_widths,
        columns: means(&field.columns),
        total_mass_kg: field.total_mass_kg,
        total_momentum_kg_m_per_s: Some(vec3(field.total_momentum_kg_m_per_s)),
        standard_errors: errors(&field.columns),
        more_widths: more.collect(),
        samples: field.samples,
        blocks: field.blocks,
        from_time_s: field.from_time_s,
        grid_origin_m: is_moved.then(|| vec3(field.grid_origin_m)),
        grid_orientation: is_moved.then_some(v1::Quaternion { w, x, y, z }),
    }
}
