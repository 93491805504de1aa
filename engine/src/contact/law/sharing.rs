//! How the points of one manifold share the stiffness of the pair.

use crate::narrow::ManifoldPoint;
use crate::scene::Sharing;

/// Writes each point's weight w_i (its part of the pair's stiffness and damping) over its `share`.
///
/// `PerPoint`: w_i = l_i d_i / sum(l_j d_j), l the tributary length. Continuous in the pose: a point that comes into
/// contact starts with weight 0; a vertex that touches alone carries all of k; sum 1 (PHYSICS.md A.2).
/// `ModelB`: w_i = 1 / N (Rakotonirina et al. 2019, section 2.3). `ModelA`: w_i = 1 (the same section): the springs add.
/// `MaxOverlapShared`: w_i = 1 / N and d_i = max(d_j) at every point (seed 000, eq. 3). The last three are not
/// conservative where the number of points changes, the last nowhere (PHYSICS.md A.2).
#[inline]
pub fn share_stiffness(points: &mut [ManifoldPoint], sharing: Sharing) {
    if let [only] = points {
        only.share = 1.0;
        return;
    }
    match sharing {
        Sharing::PerPoint => {
            let sum: f64 = points.iter().map(|point| point.share * point.overlap).sum();
            let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            points.iter_mut().for_each(|point| point.share *= point.overlap * scale);
        }
        Sharing::ModelB => {
            let share = 1.0 / points.len() as f64;
            points.iter_mut().for_each(|point| point.share = share);
        }
        Sharing::ModelA => points.iter_mut().for_each(|point| point.share = 1.0),
        Sharing::MaxOverlapShared => {
            let share = 1.0 / points.len() as f64;
            let overlap = points.iter().map(|point| point.overlap).fold(0.0, f64::max);
            points.iter_mut().for_each(|point| (point.share, point.overlap) = (share, overlap));
        }
    }
}
