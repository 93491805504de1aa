//! Rows sorted into the cells of a grid over their bounding box.

use crate::math::Vec3;

/// Rows by grid cell (counting sort: rows of a cell are contiguous and in the order given).
#[derive(Clone, Debug, Default)]
pub struct CellList {
    min: Vec3,
    inverse_size: f64,
    counts: [usize; 3],
    starts: Vec<u32>,
    rows: Vec<u32>,
    keys: Vec<u32>,
}

/// Cells per row at most; a sparse cloud gets larger cells instead of more.
const CELLS_PER_ROW: f64 = 4.0;

/// Cells along the edge of a block.
const BLOCK: usize = 4;

/// By how much a search reaches farther than asked, in cells: far above the rounding of a cell's index.
const SLACK: f64 = 1e-6;

impl CellList {
    /// Sorts `rows` at `position(row)` into cells of at least `size`.
    pub fn build(&mut self, rows: &[u32], size: f64, position: impl Fn(usize) -> Vec3) {
        let (mut min, mut max) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for &row in rows {
            let x = position(row as usize);
            min = min.inf(&x);
            max = max.sup(&x);
        }
        if rows.is_empty() {
            (min, max) = (Vec3::zeros(), Vec3::zeros());
        }
        // Two particles may be farther apart than there are numbers.
        let extent = (max - min).map(|length| length.min(f64::MAX));
        let most = CELLS_PER_ROW * rows.len() as f64 + 64.0;
        let mut size = size;
        let cells = |size: f64| extent.map(|length| (length / size).floor() + 1.0);
        while cells(size).product() > most {
            size *= 1.3;
        }
        let counts = cells(size);
        self.min = min;
        self.inverse_size = 1.0 / size;
        self.counts = [counts.x as usize, counts.y as usize, counts.z as usize];
        self.sort(rows, position);
    }

    fn sort(&mut self, rows: &[u32], position: impl Fn(usize) -> Vec3) {
        let total = self.counts.iter().product::<usize>();
        let mut keys = std::mem::take(&mut self.keys);
        keys.clear();
        keys.extend(rows.iter().map(|&row| self.key(self.cell(&position(row as usize))) as u32));
        // One place further: while rows are put in, each start moves to its end, which is the next one's start.
        self.starts.clear();
        self.starts.resize(total + 2, 0);
        for &key in &keys {
            self.starts[key as usize + 2] += 1;
        }
        for key in 0..total {
            self.starts[key + 2] += self.starts[key + 1];
        }
        self.rows.clear();
        self.rows.resize(rows.len(), 0);
        for (&row, &key) in rows.iter().zip(&keys) {
            let at = &mut self.starts[key as usize + 1];
            self.rows[*at as usize] = row;
            *at += 1;
        }
        self.keys = keys;
    }

    fn cell(&self, x: &Vec3) -> [usize; 3] {
        std::array::from_fn(|axis| {
            let index = ((x[axis] - self.min[axis]) * self.inverse_size).max(0.0) as usize;
            index.min(self.counts[axis] - 1)
        })
    }

    fn key(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// Appends the rows block by block of cells, the blocks along a Z-order curve. What a block reads of its neighbours
    /// stays in the first-level cache, and most blocks around it have been visited not long ago: in plain order they are
    /// a layer of the grid apart, which no cache holds in a large bed.
    pub fn append_in_blocks(&self, to: &mut Vec<u32>) {
        let blocks = self.counts.map(|cells| cells.div_ceil(BLOCK));
        let mut places: Vec<(u64, [usize; 3])> = (0..blocks.iter().product())
            .map(|k: usize| [k % blocks[0], k / blocks[0] % blocks[1], k / (blocks[0] * blocks[1])])
            .map(|place| (z_order(place), place))
            .collect();
        places.sort_unstable_by_key(|(code, _)| *code);
        let inside = |block: usize, axis: usize| block * BLOCK..((block + 1) * BLOCK).min(self.counts[axis]);
        for (_, [bx, by, bz]) in places {
            let along_x = inside(bx, 0);
            for (z, y) in inside(bz, 2).flat_map(|z| inside(by, 1).map(move |y| (z, y))) {
                let (first, last) = (self.key([along_x.start, y, z]), self.key([along_x.end - 1, y, z]));
                to.extend_from_slice(&self.rows[self.starts[first] as usize..self.starts[last + 1] as usize]);
            }
        }
    }

    /// Runs of rows in the cells within `reach` of `x`; a run is a row of cells along x.
    pub fn around(&self, x: &Vec3, reach: f64) -> impl Iterator<Item = &[u32]> {
        let cells: [std::ops::Range<usize>; 3] = std::array::from_fn(|axis| {
            let middle = (x[axis] - self.min[axis]) * self.inverse_size;
            let cells = reach * self.inverse_size + SLACK;
            let (low, high) = (middle - cells, middle + cells);
            if high < 0.0 || low >= self.counts[axis] as f64 {
                return 0..0;
            }
            low.max(0.0) as usize..(high as usize).saturating_add(1).min(self.counts[axis])
        });
        let [along_x, along_y, along_z] = cells;
        let along_z = if along_x.is_empty() { 0..0 } else { along_z };
        along_z.flat_map(move |z| {
            let along_x = along_x.clone();
            along_y.clone().map(move |y| {
                let first = self.key([along_x.start, y, z]);
                let last = self.key([along_x.end - 1, y, z]);
                &self.rows[self.starts[first] as usize..self.starts[last + 1] as usize]
            })
        })
    }
}

/// The bits of three coordinates (below 2^21) in turns.
fn z_order(place: [usize; 3]) -> u64 {
    let spread = |x: usize| (0..21).fold(0u64, |code, bit| code | ((x as u64 >> bit) & 1) << (3 * bit));
    spread(place[0]) | spread(place[1]) << 1 | spread(place[2]) << 2
}
