//! What the laws need of a shape: surface area, sphericity, silhouettes, longest axis.

mod area;
mod clipping;
mod samples;
mod shadow;
mod silhouette;
mod table;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(super) use tests::hydro as test_shape;

use super::drag::{Ganser, HaiderLevenspiel, HolzerSommerfeld};
use crate::math::Vec3;
use crate::shape::Shape;
use silhouette::Silhouette;
use std::f64::consts::{FRAC_PI_4, PI};

/// What the laws need of a shape at scale 1; lengths scale with the particle's size, ratios do not.
///
/// Volume and axes are those of the shape's mass properties. Surface area and silhouettes are exact for one sphere,
/// spherocylinder, cylinder, convex polyhedron or rounded convex polyhedron; the area also for composites of polyhedra
/// alone. Else they are numeric: the area by points on the surfaces of the parts (relative error below 2e-4, measured),
/// the silhouettes by scan lines, kept on a grid of directions and interpolated linearly (1e-3 in the mean over
/// directions; up to 2 % within 4 degrees of the axis of a chain of balls or cylinders, where the silhouette has a conical
/// point; measured). [`HydroShape::of`] then takes about 50 ms.
#[derive(Clone, Debug, PartialEq)]
pub struct HydroShape {
    volume: f64,
    surface_area: f64,
    diameter: f64,
    sphericity: f64,
    axis: Vec3,
    length: f64,
    aspect: f64,
    elongation: f64,
    silhouette: Silhouette,
    pub(super) haider_levenspiel: HaiderLevenspiel,
    pub(super) ganser: Ganser,
    pub(super) holzer_sommerfeld: HolzerSommerfeld,
}

impl HydroShape {
    /// Of a shape at scale 1.
    pub fn of(shape: &Shape) -> Self {
        let volume = shape.mass_properties().volume;
        let surface_area = area::surface_area(shape.parts());
        let diameter = (6.0 * volume / PI).cbrt();
        // a volume that was given need not be that of the surface: no body is rounder than a ball
        let sphericity = (PI * diameter * diameter / surface_area).min(1.0);
        let silhouette = Silhouette::of(shape.parts());
        let (axis, elongation) = longest_axis(&shape.mass_properties().principal_inertia);
        let extents = [0, 1, 2].map(|k| {
            let n = Vec3::ith(k, 1.0);
            let reach = |n: &Vec3| shape.parts().iter().map(|p| p.reach_along(n)).fold(f64::MIN, f64::max);
            reach(&n) + reach(&-n)
        });
        let across = (0..3).filter(|&k| k != axis).map(|k| extents[k]).fold(0.0, f64::max);
        Self {
            volume,
            surface_area,
            diameter,
            sphericity,
            axis: Vec3::ith(axis, 1.0),
            length: extents[axis],
            aspect: extents[axis] / across,
            elongation,
            silhouette,
            haider_levenspiel: HaiderLevenspiel::of(sphericity),
            ganser: Ganser::of(sphericity),
            holzer_sommerfeld: HolzerSommerfeld::of(sphericity),
        }
    }

    /// Volume, m3.
    pub fn volume_m3(&self) -> f64 {
        self.volume
    }

    /// Area of the surface of the union of the parts, m2.
    pub fn surface_area_m2(&self) -> f64 {
        self.surface_area
    }

    /// d, of the sphere of the same volume, m.
    pub fn equivalent_diameter_m(&self) -> f64 {
        self.diameter
    }

    /// psi = pi d^2 / A: surface of the sphere of the same volume over that of the body; at most 1.
    pub fn sphericity(&self) -> f64 {
        self.sphericity
    }

    /// The longest axis: the principal axis of the least moment of inertia; unit, in the body frame.
    pub fn axis(&self) -> Vec3 {
        self.axis
    }

    /// Extent along the longest axis, m.
    pub fn length_m(&self) -> f64 {
        self.length
    }

    /// Extent along the longest axis over the larger of those along the other two principal axes.
    pub fn aspect(&self) -> f64 {
        self.aspect
    }

    /// 1 - (s2/s1)^2 with s1 >= s2 the two largest second moments of the volume: 0 for balls, cubes, crosses and discs,
    /// whose longest axis is not distinguished, 1 for slender bodies (0.94 for a spherocylinder of aspect 2, 0.9986 for
    /// a cylinder of aspect 5). With it laws of elongated bodies go to zero continuously; it is our own, not published.
    pub fn elongation(&self) -> f64 {
        self.elongation
    }

    /// Area of the silhouette along a unit direction of the body frame, m2; the same along the opposite one.
    pub fn projected_area_m2(&self, direction_in_body: &Vec3) -> f64 {
        self.silhouette.area(direction_in_body)
    }

    /// Mean of the silhouettes over all directions across a unit direction of the body frame, m2.
    pub fn mean_longitudinal_area_m2(&self, direction_in_body: &Vec3) -> f64 {
        self.silhouette.mean_across(direction_in_body)
    }

    /// Cross-section of the sphere of the same volume over the silhouette along a unit direction of the body frame.
    ///
    /// Hölzer and Sommerfeld 2008, Powder Technol. 184, 361.
    pub fn crosswise_sphericity(&self, direction_in_body: &Vec3) -> f64 {
        FRAC_PI_4 * self.diameter * self.diameter / self.silhouette.area(direction_in_body)
    }

    /// Cross-section of the sphere of the same volume over the difference between half the surface area and the mean
    /// longitudinal projected area (the mean of the silhouettes across the flow), for a flow along a unit direction of
    /// the body frame.
    ///
    /// Hölzer and Sommerfeld 2008, Powder Technol. 184, 361; eq. 9. 1 for a sphere.
    pub fn lengthwise_sphericity(&self, direction_in_body: &Vec3) -> f64 {
        let rest = 0.5 * self.surface_area - self.silhouette.mean_across(direction_in_body);
        FRAC_PI_4 * self.diameter * self.diameter / rest
    }
}

/// Principal axis of the least moment of inertia, and the elongation.
fn longest_axis(inertia: &Vec3) -> (usize, f64) {
    let second = inertia.map(|i| 0.5 * inertia.sum() - i);
    let axis = second.imax();
    let next = (0..3).filter(|&k| k != axis).map(|k| second[k]).fold(0.0, f64::max);
    let ratio = next / second[axis];
    // equal moments are so to rounding only, or to the error of the lattice integral
    let elongation = 1.0 - ratio * ratio;
    (axis, if elongation < 1e-9 { 0.0 } else { elongation })
}
