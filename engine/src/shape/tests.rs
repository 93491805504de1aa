//! Mass properties and refusals. Reference numbers: PHYSICS B.1, computed by `oracles/mass_properties.py`.

use super::*;
use std::f64::consts::PI;

pub(crate) fn build(toml: &str) -> Result<Shape, ShapeError> {
    Shape::build(&toml::from_str(toml).expect("a valid description"))
}

fn shape(toml: &str) -> Shape {
    build(toml).expect("a valid shape")
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() <= relative, "{value} is not {expected} to {relative:e}");
}

#[test]
fn pinacoid_of_the_packing_case() {
    let l = 0.5_f64.sqrt();
    let s = shape(&format!("kind = 'pinacoid'\nlength_m = {l}\nwidth_m = {l}\nheight_m = {l}\nalpha_deg = 60"));
    let PartGeometry::Polyhedron(p) = &s.parts()[0].geometry else { panic!() };
    assert_eq!((p.vertices().len(), p.edges().len(), p.faces().len()), (8, 14, 8));
    let m = s.mass_properties();
    // V = L G H / 6 (3 - H / (L tan alpha)); tolerance: rounding of the vertices
    close(m.volume, l.powi(3) / 6.0 * (3.0 - 1.0 / 60.0_f64.to_radians().tan()), 1e-14);
    close(m.volume, 0.142756004, 5e-9);
    for (i, expected) in [0.005664661093760438, 0.0066060442502683505, 0.007456561522068065].into_iter().enumerate() {
        close(m.principal_inertia[i], expected, 1e-13);
    }
    close((6.0 * m.volume / PI).cbrt(), 0.648433, 1e-6);
    close(s.bounding_radius(), 0.5, 1e-15);
    assert_eq!(m.relative_error, 0.0);
    assert_eq!(s.given_from_body(), (Quat::identity(), Vec3::zeros()));
}
