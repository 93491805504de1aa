//! Areas and silhouettes against closed forms.

use super::*;
use crate::shape::ShapeDescription;

pub(in super::super) fn hydro(toml: &str) -> HydroShape {
    let description: ShapeDescription = toml::from_str(toml).expect("a valid description");
    HydroShape::of(&Shape::build(&description).expect("a valid shape"))
}

/// Directions that lie nowhere special.
fn directions() -> impl Iterator<Item = Vec3> {
    (0..200).map(|k| {
        let t = f64::from(k);
        Vec3::new((0.7 * t + 0.1).sin(), (1.3 * t).cos(), (2.1 * t + 0.3).sin()).normalize()
    })
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() <= relative, "{value} is not {expected} to {relative:e}");
}

#[test]
fn sphere() {
    let s = hydro("kind = 'sphere'\nradius_m = 0.3");
    close(s.equivalent_diameter_m(), 0.6, 1e-15);
    close(s.sphericity(), 1.0, 1e-15);
    assert_eq!(s.elongation(), 0.0);
    for d in directions() {
        close(s.projected_area_m2(&d), PI * 0.09, 1e-15);
        close(s.lengthwise_sphericity(&d), 1.0, 1e-14);
        close(s.crosswise_sphericity(&d), 1.0, 1e-14);
    }
}

#[test]
fn cube() {
    let s = hydro("kind = 'cube'\nedge_m = 2.0");
    close(s.surface_area_m2(), 24.0, 1e-15);
    close(s.sphericity(), (PI / 6.0).cbrt(), 1e-15);
    assert_eq!(s.elongation(), 0.0);
    close(s.projected_area_m2(&Vec3::z()), 4.0, 1e-15);
    close(s.projected_area_m2(&Vec3::new(1.0, 1.0, 1.0).normalize()), 4.0 * 3.0f64.sqrt(), 1e-15);
    // across a face: mean of 4 (|cos| + |sin|) = 16/pi
    close(s.mean_longitudinal_area_m2(&Vec3::x()), 16.0 / PI, 1e-14);
    let section = PI / 4.0 * s.equivalent_diameter_m().powi(2);
    close(s.lengthwise_sphericity(&Vec3::x()), section / (12.0 - 16.0 / PI), 1e-14);
}

#[test]
fn cylinder_and_spherocylinder() {
    let s = hydro("kind = 'cylinder'\nradius_m = 0.5\nlength_m = 3.0");
    close(s.surface_area_m2(), PI * (3.0 + 0.5), 1e-15);
    assert_eq!((s.axis(), s.length_m(), s.aspect()), (Vec3::x(), 3.0, 3.0));
    close(s.projected_area_m2(&Vec3::x()), PI / 4.0, 1e-15);
    close(s.projected_area_m2(&Vec3::y()), 3.0, 1e-15);
    let s = hydro("kind = 'spherocylinder'\nradius_m = 0.5\ntotal_length_m = 2.0");
    close(s.surface_area_m2(), 2.0 * PI, 1e-15);
    close(s.projected_area_m2(&Vec3::x()), PI / 4.0, 1e-15);
    close(s.projected_area_m2(&Vec3::z()), 1.0 + PI / 4.0, 1e-15);
    close(s.aspect(), 2.0, 1e-15);
}

/// Cauchy: the silhouette of a convex body is a quarter of its surface in the mean over all directions.
#[test]
fn mean_silhouettes_of_convex_bodies() {
    let rounded =
        "kind = 'rounded_polyhedron'\nradius_m = 0.1\nvertices_m = [[0,0,0],[1,0,0],[0,1.5,0],[0,0,0.5],[1,1,1]]";
    let bodies = [
        "kind = 'cylinder'\nradius_m = 0.5\nlength_m = 3.0",
        "kind = 'spherocylinder'\nradius_m = 0.5\ntotal_length_m = 2.0",
        "kind = 'pinacoid'\nlength_m = 1.0\nwidth_m = 0.8\nheight_m = 0.6\nalpha_deg = 60",
        "kind = 'tetrahedron'\nedge_m = 1.0",
        rounded,
    ];
    for body in bodies {
        let s = hydro(body);
        let (rings, around) = (100, 200);
        let (mut sum, mut long) = (0.0, 0.0);
        for i in 0..rings {
            let z = 2.0 * (f64::from(i) + 0.5) / f64::from(rings) - 1.0;
            for j in 0..around {
                let (sine, cosine) = (2.0 * PI * f64::from(j) / f64::from(around)).sin_cos();
                let d = Vec3::new(cosine * (1.0 - z * z).sqrt(), sine * (1.0 - z * z).sqrt(), z);
                sum += s.projected_area_m2(&d);
                long += s.mean_longitudinal_area_m2(&d);
            }
        }
        // midpoint sum over directions, kinks: second order in 1/100
        close(sum / f64::from(rings * around), 0.25 * s.surface_area_m2(), 2e-4);
        close(long / f64::from(rings * around), 0.25 * s.surface_area_m2(), 1e-3);
    }
}
