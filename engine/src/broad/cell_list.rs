//! Rows sorted into the cells of a grid over their bounding box.

use crate::math::Vec3;

/// Rows by grid cell (counting sort: rows of a cell are contiguous and ascending).
#[derive(Clone, Debug, Default)]
pub struct CellList {
    min: Vec3,
    inverse_size: f64,
    counts: [usize; 3],
    starts: Vec<u32>,
    rows: Vec<u32>,
}

/// Cells per row at most; a sparse cloud gets larger cells instead of more.
const CELLS_PER_ROW: f64 = 4.0;

impl CellList {
    /// Sorts `n` rows at `position(row)` into cells of at least `size`.
    pub fn build(&mut self, n: usize, size: f64, position: impl Fn(usize) -> Vec3) {
        let (mut min, mut max) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for row in 0..n {
            let x = position(row);
            min = min.inf(&x);
            max = max.sup(&x);
        }
        if n == 0 {
            (min, max) = (Vec3::zeros(), Vec3::zeros());
        }
        let extent = max - min;
        let most = CELLS_PER_ROW * n as f64 + 64.0;
        let mut size = size;
        let cells = |size: f64| extent.map(|length| (length / size).floor() + 1.0);
        while cells(size).product() > most {
            size *= 1.3;
        }
        let counts = cells(size);
        self.min = min;
        self.inverse_size = 1.0 / size;
        self.counts = [counts.x as usize, counts.y as usize, counts.z as usize];
        self.sort(n, position);
    }

    fn sort(&mut self, n: usize, position: impl Fn(usize) -> Vec3) {
        let total = self.counts.iter().product::<usize>();
        self.starts.clear();
        self.starts.resize(total + 1, 0);
        let keys: Vec<u32> = (0..n).map(|row| self.key(self.cell(&position(row))) as u32).collect();
        for &key in &keys {
            self.starts[key as usize + 1] += 1;
        }
        for key in 0..total {
            self.starts[key + 1] += self.starts[key];
        }
        self.rows.clear();
        self.rows.resize(n, 0);
        let mut next = self.starts.clone();
        for (row, &key) in keys.iter().enumerate() {
            self.rows[next[key as usize] as usize] = row as u32;
            next[key as usize] += 1;
        }
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

    /// Rows in the order of cells.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// Runs of rows in the cells around `x` (a run is three cells along x at most).
    pub fn around(&self, x: &Vec3) -> impl Iterator<Item = &[u32]> {
        let [cx, cy, cz] = self.cell(x);
        let range = |c: usize, axis: usize| c.saturating_sub(1)..=(c + 1).min(self.counts[axis] - 1);
        range(cz, 2).flat_map(move |z| {
            range(cy, 1).map(move |y| {
                let first = self.key([cx.saturating_sub(1), y, z]);
                let last = self.key([(cx + 1).min(self.counts[0] - 1), y, z]);
                &self.rows[self.starts[first] as usize..self.starts[last + 1] as usize]
            })
        })
    }
}
