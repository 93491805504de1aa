//! Areas and silhouettes against closed forms.

use super::*;
use crate::shape::ShapeDescription;

pub(in super::super) fn hydro(toml: &str) -> HydroShape {
    let description: ShapeDescription = toml::from_str(toml).expect("a valid description");
    HydroShape::of(&Shape::build(&description).expect("a valid shape"))
}

/// Directions that lie nowhere special, and some in the middle of the grid cells beside the axes.
fn directions() -> impl Iterator<Item = Vec3> {
    let anywhere = (0..200).map(|k| {
        let t = f64::from(k);
        Vec3::new((0.7 * t + 0.1).sin(), (1.3 * t).cos(), (2.1 * t + 0.3).sin()).normalize()
    });
    let beside = (0..3).map(|axis| {
        let mut d = Vec3::repeat(0.031);
        d[axis] = 1.0;
        d.normalize()
    });
    anywhere.chain(beside)
}

/// Largest and mean relative deviation over the directions.
fn deviation(value: impl Fn(&Vec3) -> f64, expected: impl Fn(&Vec3) -> f64) -> (f64, f64) {
    let off: Vec<f64> = directions().map(|d| (value(&d) / expected(&d) - 1.0).abs()).collect();
    (off.iter().copied().fold(0.0, f64::max), off.iter().sum::<f64>() / off.len() as f64)
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

#[test]
fn cross_of_three_boxes() {
    let s = hydro("kind = 'cross_3d'\nbeam_length_m = 3.0\nbeam_width_m = 1.0");
    close(s.volume_m3(), 7.0, 1e-14);
    // six arms of four sides and an end
    close(s.surface_area_m2(), 30.0, 1e-14);
    assert_eq!(s.elongation(), 0.0);
    for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
        // scan lines meet the ends of edges: 1/160 squared
        close(s.projected_area_m2(&axis), 5.0, 1e-4);
    }
    // along a diagonal: 14 sides of one sign each show 1/3^1/2, less what other arms hide
    let diagonal = s.projected_area_m2(&Vec3::new(1.0, 1.0, 1.0).normalize());
    assert!(diagonal < 15.0 / 3.0f64.sqrt() && diagonal > 3.0 * 3.0f64.sqrt(), "{diagonal}");
}

/// Silhouette: two discs s apart, less their lens; surface: less two caps.
#[test]
fn two_balls() {
    let (r, c) = (1.0f64, 1.2f64);
    let s = hydro(&format!(
        "kind = 'composite'\nparts = [{{ shape = {{ kind = 'sphere', radius_m = {r:?} }}, position_m = [0.0, 0.0, 0.0] }}, \
         {{ shape = {{ kind = 'sphere', radius_m = {r:?} }}, position_m = [{c:?}, 0.0, 0.0] }}]"
    ));
    close(s.surface_area_m2(), 8.0 * PI * r * r - 4.0 * PI * r * (r - 0.5 * c), 2e-4);
    // the centre of mass is that of a lattice
    close(s.aspect(), 1.6, 1e-5);
    let exact = |d: &Vec3| {
        let apart = c * (1.0 - d.dot(&s.axis()).powi(2)).sqrt();
        let half = 0.5 * apart;
        let lens = 2.0 * r * r * (half / r).acos() - half * (4.0 * r * r - apart * apart).sqrt();
        2.0 * PI * r * r - lens
    };
    let (worst, mean) = deviation(|d| s.projected_area_m2(d), exact);
    assert!(worst < 1e-2 && mean < 1e-3, "{worst} {mean}");
}

#[test]
fn composites_that_are_one_body() {
    let cases = [
        (
            "kind = 'composite'\nparts = [{ shape = { kind = 'cube', edge_m = 1.0 }, position_m = [0.0, 0.0, 0.0] }, \
             { shape = { kind = 'cube', edge_m = 1.0 }, position_m = [1.0, 0.0, 0.0] }, \
             { shape = { kind = 'box', size_m = [1.5, 1.0, 1.0] }, position_m = [0.25, 0.0, 0.0] }]",
            "kind = 'box'\nsize_m = [2.0, 1.0, 1.0]",
            1e-13,
        ),
        (
            "kind = 'composite'\nparts = [{ shape = { kind = 'cylinder', radius_m = 0.5, length_m = 1.0 }, position_m = [0.0, 0.0, 0.0] }, \
             { shape = { kind = 'cylinder', radius_m = 0.5, length_m = 1.0 }, position_m = [1.0, 0.0, 0.0] }]",
            "kind = 'cylinder'\nradius_m = 0.5\nlength_m = 2.0",
            1e-12,
        ),
        (
            "kind = 'composite'\nparts = [{ shape = { kind = 'cylinder', radius_m = 0.5, length_m = 1.0 }, position_m = [0.0, 0.0, 0.0] }, \
             { shape = { kind = 'sphere', radius_m = 0.5 }, position_m = [0.5, 0.0, 0.0] }, \
             { shape = { kind = 'sphere', radius_m = 0.5 }, position_m = [-0.5, 0.0, 0.0] }]",
            "kind = 'spherocylinder'\nradius_m = 0.5\ntotal_length_m = 2.0",
            1e-4,
        ),
    ];
    for (union, one, tolerance) in cases {
        let (union, one) = (hydro(union), hydro(one));
        close(union.surface_area_m2(), one.surface_area_m2(), tolerance);
        let across = deviation(|d| union.projected_area_m2(d), |d| one.projected_area_m2(d));
        let along = deviation(|d| union.mean_longitudinal_area_m2(d), |d| one.mean_longitudinal_area_m2(d));
        assert!(across.0 < 2.2e-2 && across.1 < 1e-3, "{across:?}");
        assert!(along.0 < 2e-2 && along.1 < 1e-3, "{along:?}");
    }
}

/// The samples of a part add up to its area.
#[test]
fn samples_add_up() {
    for (body, tolerance) in [
        ("kind = 'sphere'\nradius_m = 0.3", 1e-12),
        ("kind = 'spherocylinder'\nradius_m = 0.5\ntotal_length_m = 2.0", 1e-12),
        ("kind = 'cylinder'\nradius_m = 0.5\nlength_m = 3.0", 1e-12),
        ("kind = 'pinacoid'\nlength_m = 1.0\nwidth_m = 0.8\nheight_m = 0.6\nalpha_deg = 60", 1e-12),
        // corners are pieces of balls, by points: to a fraction of a ring of them
        (
            "kind = 'rounded_polyhedron'\nradius_m = 0.1\nvertices_m = [[0,0,0],[1,0,0],[0,1.5,0],[0,0,0.5],[1,1,1]]",
            1e-3,
        ),
    ] {
        let description: ShapeDescription = toml::from_str(body).expect("a valid description");
        let shape = Shape::build(&description).expect("a valid shape");
        let sum: f64 = super::samples::samples_of(&shape.parts()[0]).iter().map(|s| s.area).sum();
        close(sum, HydroShape::of(&shape).surface_area_m2(), tolerance);
    }
}

#[test]
fn rounded_bodies() {
    let (a, r) = (1.0, 0.2);
    let corners: Vec<String> = (0..8).map(|i| format!("[{}, {}, {}]", i & 1, i >> 1 & 1, i >> 2)).collect();
    let s = hydro(&format!("kind = 'rounded_polyhedron'\nradius_m = {r:?}\nvertices_m = [{}]", corners.join(", ")));
    close(s.surface_area_m2(), 6.0 * a * a + 6.0 * PI * a * r + 4.0 * PI * r * r, 1e-13);
    close(s.projected_area_m2(&Vec3::y()), a * a + 4.0 * a * r + PI * r * r, 1e-13);
    // a square plate: a skeleton that is no solid
    let s = hydro(
        "kind = 'rounded_polyhedron'\nradius_m = 0.2\nvertices_m = [[-0.5,-0.5,0],[0.5,-0.5,0],[0.5,0.5,0],[-0.5,0.5,0]]\n\
         faces = [[0,1,2,3]]\nmass_properties = { volume_m3 = 0.7, inertia_over_mass_m2 = [0.1, 0.1, 0.2] }",
    );
    close(s.surface_area_m2(), 2.0 * a * a + 4.0 * PI * a * r + 4.0 * PI * r * r, 3e-3);
    close(s.projected_area_m2(&Vec3::z()), a * a + 4.0 * a * r + PI * r * r, 1e-3);
    close(s.projected_area_m2(&Vec3::x()), 2.0 * a * r + PI * r * r, 1e-3);
}

#[test]
fn elongations() {
    let of = |toml: &str| hydro(toml).elongation();
    close(of("kind = 'spherocylinder'\nradius_m = 0.5\ntotal_length_m = 2.0"), 0.9449, 1e-3);
    assert_eq!(of("kind = 'cylinder'\nradius_m = 1.0\nlength_m = 0.2"), 0.0);
    assert!(of("kind = 'cylinder'\nradius_m = 0.1\nlength_m = 1.0") > 0.998);
    assert!(of("kind = 'box'\nsize_m = [1.001, 1.0, 1.0]") < 0.005);
}
