//! Moments of overlapping composites: aligned boxes exactly, everything else on a refined lattice.

use super::mass::Moments;
use super::{Part, PartGeometry, Polyhedron};
use crate::math::{Mat3, Vec3};
use crate::narrow::Solid;

/// A cuboid in the frame of the composite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OrientedBox {
    pub half: Vec3,
    pub center: Vec3,
    pub rotation: Mat3,
}

/// Moments of the union of boxes whose axes are all parallel, or `None` if they are not.
///
/// The coordinates of all faces cut space into cells that are wholly inside or wholly outside each box. The sum of
/// the inner cells is what inclusion and exclusion gives, without its 2^n terms of both signs.
pub(crate) fn aligned_boxes(boxes: &[OrientedBox]) -> Option<Moments> {
    let frame = boxes.first()?.rotation;
    let mut bounds = Vec::with_capacity(boxes.len());
    for b in boxes {
        let relative = frame.transpose() * b.rotation;
        if relative.iter().any(|x| x.abs().min((x.abs() - 1.0).abs()) > 1e-12) {
            return None;
        }
        let half = relative.map(|x| x.abs().round()) * b.half;
        let center = frame.transpose() * b.center;
        bounds.push((center - half, center + half));
    }
    let cuts = [0, 1, 2].map(|axis| {
        let mut cuts: Vec<f64> = bounds.iter().flat_map(|(low, high)| [low[axis], high[axis]]).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        cuts
    });
    let mut sum = Moments::zero();
    for x in cuts[0].windows(2) {
        for y in cuts[1].windows(2) {
            for z in cuts[2].windows(2) {
                let (low, high) = (Vec3::new(x[0], y[0], z[0]), Vec3::new(x[1], y[1], z[1]));
                let middle = (low + high) * 0.5;
                let inside = |b: &(Vec3, Vec3)| (0..3).all(|i| b.0[i] < middle[i] && middle[i] < b.1[i]);
                if bounds.iter().any(inside) {
                    sum.add(&Moments::cuboid(&low, &high));
                }
            }
        }
    }
    Some(sum.rotated(&frame, &Vec3::zeros()))
}

/// Cells along the side of the lattice before refinement, and how often cells at the surface are halved.
const COARSE: usize = 16;
pub(crate) const HALVINGS: u32 = 5;

/// Moments of any union of parts, and an estimate of their relative error.
///
/// Cells that are wholly inside or outside of every part are summed exactly; those at the surface are halved, with
/// [`HALVINGS`] down to 1/512 of the side, and then filled in proportion to the depth of their middle (exact for a face along the
/// lattice; in or out alone would err by up to half a layer of cells there). Stated as the error: the larger of
/// twice the change by the last halving (volume and trace of the second moment) and the random-walk estimate, the
/// square root of the number of cells at the surface times their volume. An estimate, tested on known unions.
pub(crate) fn lattice(parts: &[Part], halvings: u32) -> (Moments, f64) {
    let (mut low, mut high) = (Vec3::repeat(f64::MAX), Vec3::repeat(f64::MIN));
    for p in parts {
        low = low.inf(&(p.center - Vec3::repeat(p.radius)));
        high = high.sup(&(p.center + Vec3::repeat(p.radius)));
    }
    let cell = (high - low).max() / COARSE as f64;
    // off the grid: symmetric shapes would otherwise have systematic errors instead of ones that average out
    let low = low - Vec3::new(0.5857, 0.2679, 0.3944) * cell;
    let mut sums = Sums { fine: Moments::zero(), coarse: Moments::zero(), partial: 0 };
    for i in 0..=COARSE {
        for j in 0..=COARSE {
            for k in 0..=COARSE {
                let middle = low + (Vec3::new(i as f64, j as f64, k as f64) + Vec3::repeat(0.5)) * cell;
                refine(parts, &middle, cell, halvings, &mut sums);
            }
        }
    }
    let finest = cell / f64::from(1 << halvings);
    let walk = (sums.partial as f64).sqrt() * finest.powi(3) / sums.fine.volume;
    let change = |a: f64, b: f64| 2.0 * (a - b).abs() / a;
    let volume = change(sums.fine.volume, sums.coarse.volume);
    let second = change(central_trace(&sums.fine), central_trace(&sums.coarse));
    (sums.fine, walk.max(volume).max(second))
}

fn central_trace(m: &Moments) -> f64 {
    m.second.trace() - m.first.norm_squared() / m.volume
}

struct Sums {
    fine: Moments,
    coarse: Moments,
    partial: usize,
}

fn refine(parts: &[Part], middle: &Vec3, side: f64, halvings: u32, sums: &mut Sums) {
    let half = Vec3::repeat(0.5 * side);
    let reach = half.norm();
    let depth = parts.iter().map(|p| depth_inside(p, middle)).fold(f64::MIN, f64::max);
    if depth <= -reach {
        return;
    }
    let whole = || Moments::cuboid(&(middle - half), &(middle + half));
    if depth >= reach {
        let whole = whole();
        sums.fine.add(&whole);
        // the finest cells are the children of cells that the coarse sum already has
        if halvings > 0 {
            sums.coarse.add(&whole);
        }
        return;
    }
    let filled = (0.5 + depth / side).clamp(0.0, 1.0);
    if halvings == 1 {
        sums.coarse.add_scaled(&whole(), filled);
    }
    if halvings == 0 {
        sums.partial += 1;
        sums.fine.add_scaled(&whole(), filled);
        return;
    }
    for corner in 0..8 {
        let sign = |bit: u32| if corner >> bit & 1 == 1 { 0.25 } else { -0.25 };
        refine(parts, &(middle + Vec3::new(sign(0), sign(1), sign(2)) * side), 0.5 * side, halvings - 1, sums);
    }
}

fn depth_in_core(solid: &Polyhedron, x: &Vec3) -> f64 {
    let depth = solid.faces().iter().map(|f| f.offset - f.normal.dot(x)).fold(f64::MAX, f64::min);
    if depth >= 0.0 { depth } else { -(x - crate::narrow::point_polyhedron(solid, x).0).norm() }
}

/// Distance to the surface when positive; when negative, at most the distance to the part with a minus sign.
pub(super) fn depth_inside(part: &Part, x: &Vec3) -> f64 {
    match &part.geometry {
        PartGeometry::Sphere { center, radius } => radius - (x - center).norm(),
        PartGeometry::Spherocylinder { ends, radius } => {
            radius - (x - crate::narrow::closest_on_segment(x, &ends[0], &ends[1]).0).norm()
        }
        PartGeometry::Cylinder { ends, radius } => -Solid::new(ends, *radius).distance(x).0,
        PartGeometry::Polyhedron(p) => p.faces().iter().map(|f| f.offset - f.normal.dot(x)).fold(f64::MAX, f64::min),
        PartGeometry::RoundedPolyhedron(p) => {
            p.solid.as_ref().map_or(f64::MIN, |solid| p.skeleton.radius + depth_in_core(solid, x))
        }
    }
}
