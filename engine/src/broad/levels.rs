//! The hierarchical grid: one cell list per octave of sizes.
//!
//! A row is in the level of its bounding radius: level k holds the radii in (R / 2^(k+1), R / 2^k], R the largest, in
//! cells of the size of its largest row. A pair is found from its smaller side, which looks through the few cells around
//! it on its own level and on every coarser one. So a row's cost does not depend on how large others are: no large row
//! ever visits its many small neighbours. Source: V. Ogarko and S. Luding, Comput. Phys. Commun. 183 (2012) 931.

use super::cell_list::CellList;
use crate::math::Vec3;

/// Octaves told apart; smaller rows than R / 2^23 are in the last level, which is correct, only slower.
const MOST_LEVELS: usize = 24;

/// Rows of one octave.
#[derive(Clone, Debug, Default)]
struct Level {
    /// Largest bounding radius, m.
    largest: f64,
    cells: CellList,
    rows: Vec<u32>,
}

/// All levels, the coarsest first; many are empty.
#[derive(Clone, Debug, Default)]
pub struct Levels {
    levels: Vec<Level>,
    /// Largest bounding radius of all.
    top: f64,
    skin: f64,
    /// Those that are not empty, coarsest first.
    used: Vec<usize>,
}

impl Levels {
    /// Sorts `n` rows into levels and cells.
    pub fn build(&mut self, radius: &[f64], skin: f64, position: impl Fn(usize) -> Vec3) {
        self.levels.resize_with(MOST_LEVELS, Level::default);
        self.top = radius.iter().copied().fold(0.0, f64::max);
        self.skin = skin;
        for level in &mut self.levels {
            level.rows.clear();
            level.largest = 0.0;
        }
        for (row, &radius) in radius.iter().enumerate() {
            let level = self.level(radius);
            let level = &mut self.levels[level];
            level.rows.push(row as u32);
            level.largest = level.largest.max(radius);
        }
        self.used.clear();
        for (index, level) in self.levels.iter_mut().enumerate().filter(|(_, level)| !level.rows.is_empty()) {
            self.used.push(index);
            level.cells.build(&level.rows, 2.0 * level.largest + skin, &position);
        }
    }

    /// Level of a bounding radius.
    #[inline]
    fn level(&self, radius: f64) -> usize {
        // The exponent of a quotient of at least 1; a cast of NaN or infinity is in range as well.
        let octaves = ((self.top / radius).to_bits() >> 52) as usize;
        octaves.saturating_sub(1023).min(MOST_LEVELS - 1)
    }

    /// Rows in the order of levels and blocks of cells: neighbours in space are near in memory.
    pub fn order(&self, rows: &mut Vec<u32>) {
        rows.clear();
        self.used.iter().for_each(|&level| self.levels[level].cells.append_in_blocks(rows));
    }

    /// Largest bounding radius in the level of `radius`.
    pub fn largest_beside(&self, radius: f64) -> f64 {
        self.levels[self.level(radius)].largest
    }

    /// Largest bounding radius of all, m.
    pub fn largest(&self) -> f64 {
        self.top
    }

    /// Visits the rows that a row of this place and radius may be near, on its own level and on the coarser ones; tells
    /// whether they are of the same level.
    #[inline]
    pub fn visit(&self, x: &Vec3, radius: f64, mut visit: impl FnMut(&[u32], bool)) {
        let own = self.level(radius);
        for &index in self.used.iter().take_while(|&&index| index <= own) {
            let level = &self.levels[index];
            for run in level.cells.around(x, radius + level.largest + self.skin) {
                visit(run, index == own);
            }
        }
    }
}
