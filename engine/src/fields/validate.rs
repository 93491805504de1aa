//! Whether a definition can be sampled.

use super::definition::{FieldDefinition, Grid, GridMotion};
use super::kernel::FieldKernel;
use super::layout::Layout;
use super::quantity::FieldQuantity;
use crate::error::InvalidInput;
use crate::math::Vec3;

/// Cells of a grid at most.
const MOST_CELLS: u64 = 4_000_000;
/// Numbers that a definition may keep: sums of all cells, widths and blocks (512 MB).
const MOST_NUMBERS: u64 = 1 << 26;
/// Widths in one pass.
const MOST_WIDTHS: usize = 16;

/// Path of the definition, to which keys are added.
struct At<'p>(&'p str);

impl At<'_> {
    fn error<T>(&self, key: &str, problem: impl Into<String>) -> Result<T, InvalidInput> {
        Err(InvalidInput::new(format!("{}.{key}", self.0), problem))
    }
}

impl FieldDefinition {
    /// Checks names and numbers; `path` names the definition in errors.
    pub fn validate(&self, path: &str) -> Result<(), InvalidInput> {
        let at = At(path);
        let legal = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if self.name.is_empty() || self.name.len() > 64 || !self.name.chars().all(legal) {
            return at.error("name", format!("'{}' must have 1 to 64 letters, digits, '_' or '-'", self.name));
        }
        if self.quantities.is_empty() {
            return at.error("quantities", "is empty; ask for at least one quantity");
        }
        if (1..self.quantities.len()).any(|k| self.quantities[..k].contains(&self.quantities[k])) {
            return at.error("quantities", "names a quantity twice");
        }
        self.validate_widths(&at)?;
        self.grid.validate(&at)?;
        self.validate_kernel(&at)?;
        if let Some(GridMotion::Translation { velocity_m_per_s }) = &self.motion
            && !velocity_m_per_s.iter().all(|v| v.is_finite())
        {
            return at.error("motion.velocity_m_per_s", format!("is {velocity_m_per_s:?}; must be finite"));
        }
        self.validate_size(&at)
    }

    fn validate_widths(&self, at: &At<'_>) -> Result<(), InvalidInput> {
        let good = |width: f64| width.is_finite() && width > 0.0;
        if !good(self.width_m) {
            return at.error("width_m", format!("is {}; must be finite and above 0", self.width_m));
        }
        if self.more_widths_m.len() >= MOST_WIDTHS {
            return at.error(
                "more_widths_m",
                format!("are {}; at most {MOST_WIDTHS} widths in all", self.more_widths_m.len()),
            );
        }
        if let Some(k) = self.more_widths_m.iter().position(|&width| !good(width)) {
            let problem = format!("is {}; must be finite and above 0", self.more_widths_m[k]);
            return at.error(&format!("more_widths_m[{k}]"), problem);
        }
        if !(1.0..=12.0).contains(&self.cutoff_widths) {
            return at.error("cutoff_widths", format!("is {}; must be in [1, 12]", self.cutoff_widths));
        }
        Ok(())
    }

    fn validate_kernel(&self, at: &At<'_>) -> Result<(), InvalidInput> {
        let gradient = self.quantities.iter().find(|quantity| quantity.needs_gradient());
        if let (FieldKernel::Heaviside, Some(quantity)) = (self.kernel, gradient) {
            let problem = format!("is heaviside, which has no gradient: {} needs gaussian or lucy", quantity.name());
            return at.error("kernel", problem);
        }
        if self.quantities.contains(&FieldQuantity::KineticStressAboutParticles) {
            let least = self.widths_m().fold(f64::INFINITY, f64::min);
            let coarse =
                (0..3).find(|&axis| !self.grid.is_homogeneous(axis) && self.grid.largest_spacing(axis) > least);
            if let Some(axis) = coarse {
                let problem = format!(
                    "puts cells {} m apart along axis {axis}: kinetic_stress_about_particles takes the velocity at the \
                     particles from the cells and needs them at most a width ({least} m) apart",
                    self.grid.largest_spacing(axis)
                );
                return at.error("grid.cells", problem);
            }
        }
        Ok(())
    }

    fn validate_size(&self, at: &At<'_>) -> Result<(), InvalidInput> {
        let mut copies = 1;
        if let Some(average) = &self.average {
            if average.every_steps == 0 || average.samples_per_block == 0 {
                let key = if average.every_steps == 0 { "every_steps" } else { "samples_per_block" };
                return at.error(&format!("average.{key}"), "is 0; must be at least 1");
            }
            if !(2..=1000).contains(&average.blocks) {
                return at.error("average.blocks", format!("is {}; must be in [2, 1000]", average.blocks));
            }
            if !(average.from_time_s.is_finite() && average.from_time_s >= 0.0) {
                return at.error(
                    "average.from_time_s",
                    format!("is {}; must be finite and at least 0", average.from_time_s),
                );
            }
            copies = 2 * u64::from(average.blocks) + 1;
        }
        let cells = self.grid.cells.iter().map(|&c| u64::from(c)).product::<u64>();
        let numbers = cells * Layout::of(&self.quantities).size as u64 * self.widths_m().count() as u64 * copies;
        if numbers > MOST_NUMBERS {
            let problem = format!(
                "takes {numbers} sums over all widths and blocks; at most {MOST_NUMBERS}: fewer cells, blocks or quantities"
            );
            return at.error("grid.cells", problem);
        }
        Ok(())
    }
}

impl Grid {
    fn validate(&self, at: &At<'_>) -> Result<(), InvalidInput> {
        for axis in 0..3 {
            let (min, max) = (self.min_m[axis], self.max_m[axis]);
            if !(min.is_finite() && max.is_finite() && min < max) {
                return at.error(
                    &format!("grid.max_m[{axis}]"),
                    format!("is {max} with min_m {min}; needs finite min < max"),
                );
            }
        }
        let cells = self.cells.iter().map(|&c| u64::from(c)).fold(1u64, u64::saturating_mul);
        if self.cells.contains(&0) || cells > MOST_CELLS {
            return at.error("grid.cells", format!("is {:?}; needs 1 to {MOST_CELLS} cells in all", self.cells));
        }
        let Some(cylinder) = &self.cylinder else { return Ok(()) };
        if self.min_m[0] < 0.0 {
            return at.error("grid.min_m[0]", format!("is {}; a radius must be at least 0", self.min_m[0]));
        }
        let turn = self.max_m[1] - self.min_m[1];
        if turn > std::f64::consts::TAU * (1.0 + 1e-9) {
            return at.error("grid.max_m[1]", format!("is {turn} rad from min_m[1]; at most a full turn, 2 pi"));
        }
        let finite = |v: &[f64; 3]| v.iter().all(|x| x.is_finite());
        if !finite(&cylinder.point_m) {
            return at.error("grid.cylinder.point_m", "must be finite");
        }
        let axis = Vec3::from(cylinder.axis);
        if !(finite(&cylinder.axis) && axis.norm() > 1e-150) {
            return at.error("grid.cylinder.axis", "must be finite and not 0");
        }
        let is_along = |zero: &[f64; 3]| {
            let zero = Vec3::from(*zero);
            zero.norm() <= 1e-150 || zero.normalize().cross(&axis.normalize()).norm() < 1e-6
        };
        if cylinder.zero.as_ref().is_some_and(|zero| !finite(zero) || is_along(zero)) {
            return at.error("grid.cylinder.zero", "must be finite, not 0 and not along the axis");
        }
        Ok(())
    }

    /// Distance of sample points along an axis, m; of the angle in rad.
    pub fn spacing(&self, axis: usize) -> f64 {
        (self.max_m[axis] - self.min_m[axis]) / f64::from(self.cells[axis])
    }

    /// The same in m everywhere: of the angle at the largest radius.
    fn largest_spacing(&self, axis: usize) -> f64 {
        let spacing = self.spacing(axis);
        if self.cylinder.is_some() && axis == 1 { spacing * self.max_m[0] } else { spacing }
    }

    /// Coordinate of a sample point, m; of the angle in rad.
    pub fn centre(&self, axis: usize, index: usize) -> f64 {
        self.min_m[axis] + (index as f64 + 0.5) * self.spacing(axis)
    }

    pub(super) fn is_homogeneous(&self, axis: usize) -> bool {
        self.cells[axis] == 1
    }
}
