//! Coarse-grained fields: their definition, and their samples as arrays.

use sturz_protocol::columns::read_floats;
use sturz_protocol::v1;

use crate::error::ClientError;
use crate::request::vec3;
use crate::state::read_named;

/// A field that the daemon samples when somebody asks or subscribes, or of which it takes a mean over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldDefinition {
    /// Letters, digits, `_` and `-`.
    pub name: String,
    /// Lower corner of the grid, m; with `cylinder` radius (m), angle (rad), height (m).
    pub min_m: [f64; 3],
    /// Upper corner, m.
    pub max_m: [f64; 3],
    /// Along each axis; 1 averages over the whole extent.
    pub cells: [u32; 3],
    /// At least one, each once.
    pub quantities: Vec<v1::FieldQuantity>,
    /// Makes the grid cylindrical, and the axes of vectors the local ones.
    pub cylinder: Option<v1::GridCylinder>,
    /// Coarse-graining width w of the kernel, m.
    pub width_m: f64,
    /// Further widths in the same pass, m.
    pub more_widths_m: Vec<f64>,
    /// Gaussian when unspecified.
    pub kernel: v1::FieldKernel,
    /// Gives what plane walls cut off a kernel back to its part in front of them.
    pub wall_correction: bool,
    /// Whose orientation is sampled; the longest when unspecified.
    pub body_axis: v1::BodyAxis,
    /// Mean over time; the state of now when `None`.
    pub average: Option<v1::FieldAverage>,
    /// What the grid moves with.
    pub motion: Option<v1::GridMotion>,
    /// Support of the kernel over its width; the daemon's default (4) when `None`.
    pub cutoff_widths: Option<f64>,
}

impl From<FieldDefinition> for v1::FieldDefinition {
    fn from(definition: FieldDefinition) -> Self {
        let [cells_x, cells_y, cells_z] = definition.cells;
        let (min_m, max_m) = (Some(vec3(definition.min_m)), Some(vec3(definition.max_m)));
        Self {
            name: definition.name,
            grid: Some(v1::Grid { min_m, max_m, cells_x, cells_y, cells_z, cylinder: definition.cylinder }),
            quantities: definition.quantities.into_iter().map(Into::into).collect(),
            width_m: definition.width_m,
            cutoff_widths: definition.cutoff_widths,
            kernel: definition.kernel.into(),
            more_widths_m: definition.more_widths_m,
            wall_correction: definition.wall_correction,
            body_axis: definition.body_axis.into(),
            average: definition.average,
            motion: definition.motion,
        }
    }
}

/// A sampled field. Arrays hold one row per cell, x slowest: row `(i * cells_y + j) * cells_z + k`.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    frame: v1::FieldFrame,
}

impl Field {
    /// From the wire.
    pub(crate) fn new(frame: v1::FieldFrame) -> Self {
        Self { frame }
    }

    /// As it came: kernel, totals of mass and momentum, header.
    pub fn frame(&self) -> &v1::FieldFrame {
        &self.frame
    }

    /// Of its definition.
    pub fn name(&self) -> &str {
        &self.frame.name
    }

    /// Simulated time of the sample, s.
    pub fn time_s(&self) -> f64 {
        self.frame.header.as_ref().map_or(0.0, |header| header.sim_time_s)
    }

    /// Along each axis.
    pub fn cells(&self) -> [usize; 3] {
        let grid = self.frame.grid.unwrap_or_default();
        [grid.cells_x as usize, grid.cells_y as usize, grid.cells_z as usize]
    }

    /// Centre of each cell, m; of a cylindrical grid radius (m), angle (rad), height (m).
    pub fn centres_m(&self) -> Vec<[f64; 3]> {
        let grid = self.frame.grid.unwrap_or_default();
        let (min, max) = (grid.min_m.unwrap_or_default(), grid.max_m.unwrap_or_default());
        let [nx, ny, nz] = self.cells();
        let centre = |min: f64, max: f64, i: usize, n: usize| min + (i as f64 + 0.5) * (max - min) / n as f64;
        let mut centres = Vec::with_capacity(nx * ny * nz);
        for i in 0..nx {
            for j in 0..ny {
                let (x, y) = (centre(min.x, max.x, i, nx), centre(min.y, max.y, j, ny));
                centres.extend((0..nz).map(|k| [x, y, centre(min.z, max.z, k, nz)]));
            }
        }
        centres
    }

    /// Of a quantity of one component, such as `solid_fraction`, `density` or `granular_temperature`.
    pub fn scalars(&self, quantity: &str) -> Result<Vec<f64>, ClientError> {
        self.rows::<1>(quantity).map(Vec::into_flattened)
    }

    /// Of a quantity of three components, such as `momentum` or `velocity`.
    pub fn vectors(&self, quantity: &str) -> Result<Vec<[f64; 3]>, ClientError> {
        self.rows::<3>(quantity)
    }

    /// Of a quantity of nine components, such as `contact_stress`: row-major.
    pub fn tensors(&self, quantity: &str) -> Result<Vec<[f64; 9]>, ClientError> {
        self.rows::<9>(quantity)
    }

    /// Of a quantity of any `C` components, such as the 8 of `coordination`.
    pub fn rows<const C: usize>(&self, quantity: &str) -> Result<Vec<[f64; C]>, ClientError> {
        self.read(&self.frame.columns, quantity)
    }

    /// Standard error of the mean over time, as [`Field::rows`]; an error where there are fewer than two blocks.
    pub fn standard_errors<const C: usize>(&self, quantity: &str) -> Result<Vec<[f64; C]>, ClientError> {
        self.read(&self.frame.standard_errors, quantity)
    }

    /// The same field smeared with another of its widths: the first is 0.
    pub fn at_width(&self, index: usize) -> Option<Self> {
        let Some(index) = index.checked_sub(1) else { return Some(self.clone()) };
        let width = self.frame.more_widths.get(index)?.clone();
        let mut frame = self.frame.clone();
        frame.more_widths.clear();
        (frame.width_m, frame.columns, frame.standard_errors) = (width.width_m, width.columns, width.standard_errors);
        Some(Self { frame })
    }

    fn read<const C: usize>(&self, columns: &[v1::Column], quantity: &str) -> Result<Vec<[f64; C]>, ClientError> {
        let rows = read_named(columns, quantity, read_floats::<C>)?;
        let needed = self.cells().iter().product();
        if rows.len() == needed {
            Ok(rows)
        } else {
            Err(ClientError::ColumnRows { name: quantity.into(), rows: rows.len(), needed })
        }
    }
}

#[cfg(test)]
mod tests {
    use sturz_protocol::columns::flat;

    use super::*;

    #[test]
    fn samples_belong_to_cell_centres_x_slowest() {
        let definition = FieldDefinition {
            name: "f".into(),
            min_m: [0.0, 0.0, 1.0],
            max_m: [2.0, 1.0, 3.0],
            cells: [2, 1, 2],
            quantities: vec![v1::FieldQuantity::Density],
            width_m: 0.1,
            ..Default::default()
        };
        let definition = v1::FieldDefinition::from(definition);
        let columns = vec![flat("density", "kg/m3", 1, &[1.0, 2.0, 3.0, 4.0]), flat("velocity", "m/s", 3, &[0.0; 9])];
        let wide = v1::FieldWidth {
            width_m: 0.3,
            columns: vec![flat("stress", "Pa", 9, &[1.5; 36])],
            standard_errors: vec![flat("stress", "Pa", 9, &[0.5; 36])],
        };
        let grid = definition.grid;
        let field = Field::new(v1::FieldFrame { grid, columns, more_widths: vec![wide], ..Default::default() });
        let wider = field.at_width(1).unwrap();
        assert_eq!((wider.frame().width_m, wider.tensors("stress").unwrap()), (0.3, vec![[1.5; 9]; 4]));
        assert_eq!(wider.standard_errors::<9>("stress").unwrap(), [[0.5; 9]; 4]);
        assert!(field.standard_errors::<1>("density").is_err() && field.at_width(2).is_none());
        assert_eq!(field.centres_m(), [[0.5, 0.5, 1.5], [0.5, 0.5, 2.5], [1.5, 0.5, 1.5], [1.5, 0.5, 2.5]]);
        assert_eq!(field.scalars("density").unwrap(), [1.0, 2.0, 3.0, 4.0]);
        assert!(matches!(field.vectors("velocity"), Err(ClientError::ColumnRows { rows: 3, needed: 4, .. })));
        assert!(matches!(field.vectors("density"), Err(ClientError::Column { .. })));
    }
}
