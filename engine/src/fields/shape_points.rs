//! The true volume of a shape as points of equal weight: those of a cubic lattice that lie inside.

use crate::math::Vec3;
use crate::shape::Shape;

/// Points of a shape, about: few where the kernel is wide, more where it resolves the shape.
const POINTS: [f64; 2] = [64.0, 4096.0];
/// Distance of points over the width of the kernel, where that takes no more points than allowed.
const SPACING: f64 = 0.7;
/// Lattices to choose from.
const LATTICES: u32 = 8;

/// For a kernel of that width: points in the body frame at unit scale, about their mean.
pub(super) fn shape_points(shape: &Shape, width: f64) -> Vec<Vec3> {
    points_at(shape, SPACING * width, POINTS)
}

/// Points about `step` apart, in the body frame at unit scale, about their mean; about so many, `[least, most]`.
pub(crate) fn points_at(shape: &Shape, step: f64, [least, most]: [f64; 2]) -> Vec<Vec3> {
    let volume = shape.mass_properties().volume;
    let spacing = |points: f64| (volume / points).cbrt();
    let mut step = step.clamp(spacing(most), spacing(least));
    for _ in 0..4 {
        // that of a few lattices whose cells fill the volume best: inside a shape the fraction is then 1
        let misfit = |points: &[Vec3], step: f64| (points.len() as f64 * step.powi(3) / volume - 1.0).abs();
        let tried = (0..LATTICES).map(|k| step * (1.0 - 0.03 * f64::from(k))).map(|step| (inside(shape, step), step));
        let best = tried.min_by(|(p, h), (q, k)| misfit(p, *h).total_cmp(&misfit(q, *k)));
        if let Some((points, _)) = best.filter(|(points, _)| points.len() >= 8) {
            let mean = points.iter().sum::<Vec3>() / points.len() as f64;
            return points.iter().map(|x| x - mean).collect();
        }
        // thin parts slip through the lattice
        step *= 0.5;
    }
    vec![Vec3::zeros()]
}

fn inside(shape: &Shape, step: f64) -> Vec<Vec3> {
    let n = (shape.bounding_radius() / step).ceil() as i64;
    let mut points = Vec::new();
    for i in -n..n {
        for j in -n..n {
            for k in -n..n {
                let x = Vec3::new(i as f64 + 0.5, j as f64 + 0.5, k as f64 + 0.5) * step;
                if shape.contains(&x) {
                    points.push(x);
                }
            }
        }
    }
    points
}
