//! Weights in the points of an unstructured mesh, found through boxes of the kernel's size.

use rayon::prelude::*;

use crate::math::Vec3;

/// Points with volumes, sorted by the box that they are in.
#[derive(Clone, Debug)]
pub(super) struct PointBins {
    half_width: f64,
    low: Vec3,
    side: f64,
    counts: [usize; 3],
    /// By box, where its points start in `order`; one more at the end.
    start: Vec<u32>,
    /// Points by box, in ascending order of index.
    order: Vec<u32>,
    points: Vec<Vec3>,
    volumes: Vec<f64>,
    /// Volumes times factors that make an even crowd of particles even on the points.
    shares: Vec<f64>,
}

/// Rounds of balancing at most, and the largest part of a volume by which a point may then have too much or too little.
const ROUNDS: usize = 40;
const EVEN: f64 = 1e-3;
/// Boxes along an axis.
const MOST_BOXES: f64 = 128.0;

impl PointBins {
    pub fn new(points: &[[f64; 3]], volumes: &[f64], half_width: f64) -> Self {
        let points: Vec<Vec3> = points.iter().map(|x| Vec3::from(*x)).collect();
        let (mut low, mut high) = (points[0], points[0]);
        for x in &points {
            (low, high) = (low.inf(x), high.sup(x));
        }
        let side = half_width.max((high - low).max() / MOST_BOXES);
        let counts = [0, 1, 2].map(|axis| ((high[axis] - low[axis]) / side) as usize + 1);
        let mut bins = Self {
            half_width,
            low,
            side,
            counts,
            start: Vec::new(),
            order: Vec::new(),
            points,
            volumes: volumes.into(),
            shares: volumes.into(),
        };
        let boxes: Vec<usize> = bins.points.iter().map(|x| bins.index(bins.place(x))).collect();
        bins.order = (0..bins.points.len() as u32).collect();
        bins.order.sort_by_key(|&point| boxes[point as usize]);
        bins.start = vec![0; counts.iter().product::<usize>() + 1];
        boxes.iter().for_each(|&at| bins.start[at + 1] += 1);
        for at in 1..bins.start.len() {
            bins.start[at] += bins.start[at - 1];
        }
        bins.balance();
        bins
    }

    /// Near an edge of the mesh a point is reached from inside only, and would have less than its part of an even crowd.
    /// Finds factors for which each has its part, the points standing for the crowd: a symmetric scaling, as Sinkhorn's
    /// (Ann. Math. Stat. 35 (1964) 876), of which each round goes half the way.
    fn balance(&mut self) {
        for _ in 0..ROUNDS {
            let rows: Vec<Vec<(u32, f64)>> =
                self.points.par_iter().zip(&self.volumes).map(|(x, volume)| self.weights(x, *volume)).collect();
            let mut got = vec![0.0; self.points.len()];
            rows.iter().flatten().for_each(|&(point, weight)| got[point as usize] += weight);
            let uneven =
                got.iter().zip(&self.volumes).map(|(got, volume)| (got / volume - 1.0).abs()).fold(0.0, f64::max);
            let factors = self.volumes.iter().zip(&got).map(|(volume, got)| (volume / got).sqrt());
            self.shares.iter_mut().zip(factors).for_each(|(share, factor)| *share *= factor);
            if uneven < EVEN {
                break;
            }
        }
    }

    /// Of a part at `x`, summing to `sum`; none where no point is near.
    fn weights(&self, x: &Vec3, sum: f64) -> Vec<(u32, f64)> {
        let mut out = Vec::new();
        self.push_weights(x, sum, &mut out);
        out
    }

    fn push_weights(&self, x: &Vec3, wanted: f64, out: &mut Vec<(u32, f64)>) {
        let first = out.len();
        let mut sum = 0.0;
        self.near(x, |point, squared| {
            let t = 1.0 - squared;
            let weight = self.shares[point as usize] * t * t;
            sum += weight;
            out.push((point, weight));
        });
        // so near to the edge of the kernel that the weights underflow
        if sum <= 0.0 {
            out.truncate(first);
        }
        out[first..].iter_mut().for_each(|(_, weight)| *weight *= wanted / sum);
    }

    pub fn len(&self) -> usize {
        self.points.len()
    }

    pub fn volume(&self, point: usize) -> f64 {
        self.volumes[point]
    }

    /// The box of a point, or the one next to it where it is outside of all.
    fn place(&self, x: &Vec3) -> [usize; 3] {
        [0, 1, 2].map(|axis| {
            let at = (x[axis] - self.low[axis]) / self.side;
            // casts to integers saturate: what is far below is in the first box
            (at as usize).min(self.counts[axis] - 1)
        })
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.counts[0] * (j + self.counts[1] * k)
    }

    /// Weights a_j V_j (1 - (r/h)^2)^2 of each part, over their sum, a_j being the factors of the balance; none of a part that no point is near to.
    pub fn spread(&self, parts: &[Vec3], out: &mut Vec<(u32, f64)>) {
        let share = 1.0 / parts.len() as f64;
        let of_body = out.len();
        for x in parts {
            self.push_weights(x, share, out);
        }
        if parts.len() > 1 {
            merge(out, of_body);
        }
    }

    /// The points within the half-width, with the square of the distance over it.
    fn near(&self, x: &Vec3, mut tell: impl FnMut(u32, f64)) {
        let reach = Vec3::repeat(self.half_width);
        let (low, high) = (self.place(&(x - reach)), self.place(&(x + reach)));
        let scale = 1.0 / (self.half_width * self.half_width);
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                for i in low[0]..=high[0] {
                    let at = self.index([i, j, k]);
                    for &point in &self.order[self.start[at] as usize..self.start[at + 1] as usize] {
                        let squared = (self.points[point as usize] - x).norm_squared() * scale;
                        if squared < 1.0 {
                            tell(point, squared);
                        }
                    }
                }
            }
        }
    }
}

/// Adds up the weights of the same point from `first` on.
fn merge(pairs: &mut Vec<(u32, f64)>, first: usize) {
    pairs[first..].sort_by_key(|(point, _)| *point);
    let mut last = first;
    for at in first + 1..pairs.len() {
        if pairs[at].0 == pairs[last].0 {
            pairs[last].1 += pairs[at].1;
        } else {
            last += 1;
            pairs[last] = pairs[at];
        }
    }
    pairs.truncate(if pairs.len() > first { last + 1 } else { first });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> Vec<[f64; 3]> {
        let at = |k: u32, a: f64| (f64::from(k) * a).fract();
        (0..500).map(|k| [at(k, 0.618_034) * 3.0, at(k, 0.414_214), at(k, 0.732_051) * 2.0]).collect()
    }

    #[test]
    fn the_points_found_are_those_within_reach() {
        let points = cloud();
        let bins = PointBins::new(&points, &vec![1.0; 500], 0.31);
        for k in 0..300u32 {
            let x = Vec3::new((f64::from(k) * 0.37).fract() * 3.4 - 0.2, (f64::from(k) * 0.11).fract(), 1.3);
            let mut found = Vec::new();
            bins.near(&x, |point, _| found.push(point));
            found.sort_unstable();
            let wanted: Vec<u32> = (0..500).filter(|&j| (Vec3::from(points[j as usize]) - x).norm() < 0.31).collect();
            assert_eq!(found, wanted, "{x:?}");
        }
    }

    #[test]
    fn an_even_crowd_is_nearly_even_on_nodes_at_edges_and_corners_too() {
        let (n, step) = (7u32, 0.1);
        let nodes = (0..n * n * n).map(|k| [k % n, k / n % n, k / n / n]);
        let points: Vec<[f64; 3]> = nodes.clone().map(|at| at.map(|i| f64::from(i) * step)).collect();
        let part = |i: u32| if i == 0 || i == n - 1 { 0.5 } else { 1.0 };
        let volumes: Vec<f64> = nodes.map(|at| at.map(part).iter().product::<f64>() * step * step * step).collect();
        let bins = PointBins::new(&points, &volumes, 0.25);
        let mut got = vec![0.0; points.len()];
        let along = |i: u32| (f64::from(i) + 0.5) * 0.6 / 24.0;
        for k in 0..24u32.pow(3) {
            let x = Vec3::new(along(k % 24), along(k / 24 % 24), along(k / 576));
            bins.weights(&x, 1.0).iter().for_each(|&(point, weight)| got[point as usize] += weight);
        }
        let density = 24.0_f64.powi(3) / 0.216;
        for (point, (got, volume)) in got.iter().zip(&volumes).enumerate() {
            // without the balance a corner has 0.35 of its part
            assert!((got / volume / density - 1.0).abs() < 0.17, "{point}: {}", got / volume / density);
        }
    }

    #[test]
    fn weights_of_what_is_inside_sum_to_one_and_those_of_what_is_not_to_none() {
        let points = cloud();
        let volumes: Vec<f64> = (0..500).map(|k| 1.0 + (f64::from(k) * 0.3).fract()).collect();
        let bins = PointBins::new(&points, &volumes, 0.4);
        let mut out = Vec::new();
        bins.spread(&[Vec3::new(1.5, 0.5, 1.0)], &mut out);
        assert!(out.len() > 10 && (out.iter().map(|(_, w)| w).sum::<f64>() - 1.0).abs() < 1e-14);
        out.clear();
        bins.spread(&[Vec3::new(1.5, 0.5, 1.0), Vec3::new(1.5, 9.0, 1.0)], &mut out);
        assert!((out.iter().map(|(_, w)| w).sum::<f64>() - 0.5).abs() < 1e-14);
        // each point once
        let mut points: Vec<u32> = out.iter().map(|(point, _)| *point).collect();
        points.dedup();
        assert_eq!(points.len(), out.len());
        out.clear();
        bins.spread(&[Vec3::new(f64::MAX, -1e300, 0.0)], &mut out);
        assert!(out.is_empty());
    }
}
