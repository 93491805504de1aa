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

#[test]
fn equal_volume_set() {
    // V = 4/3 pi 1.5^3; the oracle prints five decimals
    let volume = 4.0 / 3.0 * PI * 1.5_f64.powi(3);
    let edge = volume.cbrt();
    close(edge, 2.41799, 2e-6);
    let cube = shape(&format!("kind = 'cube'\nedge_m = {edge}"));
    close(cube.mass_properties().volume, volume, 1e-14);
    let per_mass = cube.mass_properties().principal_inertia / volume;
    assert!((per_mass - Vec3::repeat(edge * edge / 6.0)).amax() < 1e-14);
    let edge = (volume * 6.0 * 2.0_f64.sqrt()).cbrt();
    close(edge, 4.93185, 2e-6);
    let tetra = shape(&format!("kind = 'tetrahedron'\nedge_m = {edge}"));
    close(tetra.mass_properties().volume, volume, 1e-14);
    assert!((tetra.mass_properties().principal_inertia / volume - Vec3::repeat(edge * edge / 20.0)).amax() < 1e-13);
    let octa = shape("kind = 'octahedron'\nedge_m = 1.0");
    close(octa.mass_properties().volume, 2.0_f64.sqrt() / 3.0, 1e-14);
    close(octa.mass_properties().principal_inertia.x, 0.1 * 2.0_f64.sqrt() / 3.0, 1e-14);
}

#[test]
fn spherocylinders_of_the_field_paper() {
    // total length 1/8, rho = 2500: (aspect, mass, I_perp / (m l^2)), printed to six digits
    let cases = [
        (1.01, 2.518666, 0.099321),
        (1.3, 1.687356, 0.085799),
        (1.5, 1.325662, 0.080952),
        (2.0, 0.798948, 0.075625),
        (2.5, 0.531780, 0.074154),
        (3.0, 0.378761, 0.073958),
    ];
    let length = 0.125;
    for (aspect, mass, across) in cases {
        let radius = length / (2.0 * aspect);
        let s = shape(&format!("kind = 'spherocylinder'\nradius_m = {radius}\ntotal_length_m = {length}"));
        let m = s.mass_properties();
        close(2500.0 * m.volume, mass, 1e-6);
        close(m.principal_inertia.y / (m.volume * length * length), across, 1e-5);
        assert_eq!(m.principal_inertia.y, m.principal_inertia.z);
        close(s.bounding_radius(), 0.5 * length, 1e-15);
    }
    let s = shape("kind = 'sphere'\nradius_m = 2.0");
    close(s.mass_properties().principal_inertia.x, s.mass_properties().volume * 1.6, 1e-15);
}

#[test]
fn crosses_by_their_cells() {
    let volume = 4.0 / 3.0 * PI * 1.5_f64.powi(3);
    for (kind, parts, inertia) in [("cross_2d", 2, [1.72664, 1.72664, 3.22807]), ("cross_3d", 3, [1.80317; 3])] {
        let width = (volume / (f64::from(parts) * 5.0 - f64::from(parts - 1))).cbrt();
        let s = shape(&format!("kind = '{kind}'\nbeam_length_m = {}\nbeam_width_m = {width}", 5.0 * width));
        let m = s.mass_properties();
        close(m.volume, volume, 1e-14);
        for (i, expected) in inertia.into_iter().enumerate() {
            close(m.principal_inertia[i] / m.volume, expected, 3e-6);
        }
        assert_eq!((m.relative_error, s.parts().len()), (0.0, parts as usize));
        assert_eq!(s.given_from_body().1, Vec3::zeros());
    }
    // in closed form, with w = 1 and a = 5: V = 2a - 1, I_zz = 2 a (a^2 + 1) / 12 - 1/6
    let s = shape("kind = 'cross_2d'\nbeam_length_m = 5.0\nbeam_width_m = 1.0");
    close(s.mass_properties().volume, 9.0, 1e-14);
    close(s.mass_properties().principal_inertia.z, 10.0 * 26.0 / 12.0 - 1.0 / 6.0, 1e-14);
}

#[test]
fn glued_cubes_are_the_cube() {
    let mut text = String::from("kind = 'composite'\n");
    for i in 0..8 {
        let at = |bit: u32| if i >> bit & 1 == 1 { 0.25 } else { -0.25 };
        text += &format!(
            "[[parts]]\nshape = {{ kind = 'cube', edge_m = 0.5 }}\nposition_m = [{}, {}, {}]\n",
            at(0),
            at(1),
            at(2)
        );
    }
    let m = *shape(&text).mass_properties();
    close(m.volume, 1.0, 1e-14);
    assert!((m.principal_inertia - Vec3::repeat(1.0 / 6.0)).amax() < 1e-15 && m.relative_error == 0.0);
}

/// A disjoint composite in a skew frame: the body frame must find its principal axes, and the moments must not move.
#[test]
fn the_body_frame_is_principal() {
    let upright = shape(
        "kind = 'composite'\nparts = [{ shape = { kind = 'box', size_m = [3.0, 1.0, 0.5] } },
         { shape = { kind = 'sphere', radius_m = 0.4 }, position_m = [2.0, 0.0, 0.0] }]",
    );
    let turn = Quat::from_euler_angles(0.3, -0.7, 1.1);
    let at = turn * Vec3::new(2.0, 0.0, 0.0) + Vec3::new(5.0, 6.0, 7.0);
    let q = turn.quaternion();
    let wxyz = format!("orientation_wxyz = [{}, {}, {}, {}]", q.w, q.i, q.j, q.k);
    let skew = shape(&format!(
        "kind = 'composite'\nparts = [{{ shape = {{ kind = 'box', size_m = [3.0, 1.0, 0.5] }}, position_m = [5, 6, 7], {wxyz} }},
         {{ shape = {{ kind = 'sphere', radius_m = 0.4 }}, position_m = [{}, {}, {}] }}]",
        at.x, at.y, at.z
    ));
    let sorted = |s: &Shape| {
        let mut moments: Vec<f64> = s.mass_properties().principal_inertia.iter().copied().collect();
        moments.sort_by(f64::total_cmp);
        moments
    };
    for (a, b) in sorted(&upright).into_iter().zip(sorted(&skew)) {
        // 1e-12 of the largest moment may stay off the diagonal
        assert!((a - b).abs() < 1e-11 * a, "{a} {b}");
    }
    let mut moments = mass::Moments::zero();
    for p in skew.parts() {
        moments.add(&mass::Moments::of_part(p));
    }
    assert!((moments.first / moments.volume).norm() < 1e-14);
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        assert!(moments.second[(i, j)].abs() < 1e-11 * moments.second.trace());
    }
    // the given frame is found again
    let (rotation, translation) = skew.given_from_body();
    let PartGeometry::Sphere { center, .. } = skew.parts()[1].geometry else { panic!() };
    assert!((rotation * center + translation - at).norm() < 1e-13);
}

#[test]
fn equal_moments_keep_the_given_axes() {
    let turn = Quat::from_euler_angles(0.3, -0.7, 1.1);
    let q = turn.quaternion();
    let skew_cube = shape(&format!(
        "kind = 'composite'\nparts = [{{ shape = {{ kind = 'cube', edge_m = 1.0 }}, orientation_wxyz = [{}, {}, {}, {}] }}]",
        q.w, q.i, q.j, q.k
    ));
    assert_eq!(skew_cube.given_from_body(), (Quat::identity(), Vec3::zeros()));
    let a = shape(
        "kind = 'composite'\nparts = [{ shape = { kind = 'spherocylinder', radius_m = 0.5, total_length_m = 3.0 }, orientation_wxyz = [0.8, 0.0, 0.6, 0.0] }]",
    );
    let m = a.mass_properties().principal_inertia;
    assert!((m.x - m.z).abs() > 0.1 && a.given_from_body().0.angle() < 1.0, "turned about y only: {m}");
    assert!((a.given_from_body().0.axis().unwrap().y.abs() - 1.0).abs() < 1e-9);
}

/// Two overlapping balls have a lens in common: the lattice must be right within what it states.
#[test]
fn lattice_against_two_balls_and_a_turned_cross() {
    let s = shape(
        "kind = 'composite'\nparts = [{ shape = { kind = 'sphere', radius_m = 1.0 } },
         { shape = { kind = 'sphere', radius_m = 1.0 }, position_m = [1.0, 0.0, 0.0] }]",
    );
    let m = s.mass_properties();
    let exact = 8.0 / 3.0 * PI - PI * 5.0 / 12.0;
    assert!(m.relative_error > 0.0 && m.relative_error < 1e-3, "{}", m.relative_error);
    close(m.volume, exact, m.relative_error);
    let exact = shape("kind = 'cross_2d'\nbeam_length_m = 3.0\nbeam_width_m = 1.0");
    // 1e-6 rad off the common frame: not aligned any more, yet the same solid
    let turned = shape(
        "kind = 'composite'\nparts = [{ shape = { kind = 'box', size_m = [3.0, 1.0, 1.0] } },
         { shape = { kind = 'box', size_m = [1.0, 3.0, 1.0] }, orientation_wxyz = [0.9999999999995, 0.0, 0.000001, 0.0] }]",
    );
    let (e, t) = (exact.mass_properties(), turned.mass_properties());
    assert!(t.relative_error > 0.0 && t.relative_error < 1e-3, "{}", t.relative_error);
    close(t.volume, e.volume, t.relative_error);
    close(t.principal_inertia.sum(), e.principal_inertia.sum(), t.relative_error);
}

fn polyhedron(points: &[[f64; 3]]) -> Result<Shape, ShapeError> {
    Shape::build(&ShapeDescription::ConvexPolyhedron { vertices_m: points.to_vec() })
}

fn cube_points(edge: f64) -> Vec<[f64; 3]> {
    (0..8).map(|i| [0, 1, 2].map(|bit| if i >> bit & 1 == 1 { edge } else { 0.0 })).collect()
}

#[test]
fn hull_of_a_cube_with_points_to_be_dropped() {
    for edge in [1e-6, 1.0, 1e3] {
        let mut points = cube_points(edge);
        points.extend(cube_points(edge * (1.0 + 1e-15)));
        points.push([0.5 * edge, 0.5 * edge, 0.5 * edge]);
        points.push([0.5 * edge, 0.5 * edge, 0.0]);
        points.push([0.5 * edge, 0.0, 0.0]);
        let s = polyhedron(&points).expect("a cube");
        let PartGeometry::Polyhedron(p) = &s.parts()[0].geometry else { panic!() };
        assert_eq!((p.vertices().len(), p.edges().len(), p.faces().len()), (8, 12, 6));
        close(s.mass_properties().volume, edge.powi(3), 1e-14);
        assert_eq!(s.given_from_body().0, Quat::identity());
    }
}

#[test]
fn hulls_of_many_points_are_closed_and_convex() {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    for count in [12, 100, 1_000, 10_000] {
        let points: Vec<[f64; 3]> = (0..count)
            .map(|k| {
                let z: f64 = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
                let r = (1.0 - z * z).sqrt();
                let (sin, cos) = (golden * f64::from(k)).sin_cos();
                [r * cos, r * sin, z]
            })
            .collect();
        let s = polyhedron(&points).expect("a faceted ball");
        let PartGeometry::Polyhedron(p) = &s.parts()[0].geometry else { panic!() };
        assert_eq!(p.vertices().len(), count as usize);
        // the missing volume of a faceted ball falls as one over the number of points
        let missing = 1.0 - s.mass_properties().volume / (4.0 / 3.0 * PI);
        assert!(missing > 0.0 && missing < 8.0 / f64::from(count), "{missing}");
    }
}

#[test]
fn refusals_say_what_and_where() {
    let text = |result: Result<Shape, ShapeError>| result.expect_err("a refusal").to_string();
    let flat: Vec<[f64; 3]> = (0..10).map(|i| [f64::from(i), f64::from(i * i), 0.0]).collect();
    let line: Vec<[f64; 3]> = (0..10).map(|i| [f64::from(i), 2.0 * f64::from(i), 0.0]).collect();
    assert!(matches!(polyhedron(&flat), Err(ShapeError::Coplanar { .. })));
    assert!(matches!(polyhedron(&line), Err(ShapeError::Collinear { .. })));
    assert!(matches!(polyhedron(&[[0.0; 3]; 9]), Err(ShapeError::TooFewPoints { given: 9, distinct: 1, .. })));
    assert!(matches!(polyhedron(&flat[..3]), Err(ShapeError::TooFewPoints { distinct: 3, .. })));
    assert!(matches!(polyhedron(&[]), Err(ShapeError::TooFewPoints { distinct: 0, .. })));
    let thin: Vec<[f64; 3]> = cube_points(1.0).into_iter().map(|[x, y, z]| [x, y * 1e-6, z * 1e-9]).collect();
    assert!(matches!(polyhedron(&thin), Err(ShapeError::Coplanar { .. } | ShapeError::Collinear { .. })));
    assert!(polyhedron(&cube_points(1e-80)).is_err(), "its volume underflows");
    assert!(matches!(build("kind = 'cube'\nedge_m = 1e-70"), Err(ShapeError::Volume { .. })));
    let mut points = cube_points(1.0);
    points[3][1] = f64::NAN;
    assert_eq!(text(polyhedron(&points)), "vertices_m[3][1] is NaN: coordinates must be finite");
    assert_eq!(text(build("kind = 'cube'\nedge_m = -1.0")), "edge_m is -1: a length must be positive and finite");
    assert!(text(build("kind = 'sphere'\nradius_m = inf")).starts_with("radius_m is inf"));
    assert!(
        text(build("kind = 'spherocylinder'\nradius_m = 1.0\ntotal_length_m = 1.0"))
            .contains("at least 2 radius_m = 2")
    );
    let ridge = text(build("kind = 'pinacoid'\nlength_m = 1\nwidth_m = 1\nheight_m = 1.8\nalpha_deg = 60"));
    assert!(ridge.starts_with("height_m is 1.8") && ridge.contains("1.73"), "{ridge}");
    assert!(matches!(build("kind = 'composite'\nparts = []"), Err(ShapeError::NoParts { .. })));
    let parts = "kind = 'composite'\n[[parts]]\nshape = { kind = 'cube', edge_m = 1 }\n[[parts]]\n";
    assert!(
        text(build(&format!("{parts}shape = {{ kind = 'cube', edge_m = 0 }}")))
            .starts_with("parts[1].shape.edge_m is 0")
    );
    assert!(
        text(build(&format!("{parts}shape = {{ kind = 'composite', parts = [] }}"))).contains("parts must be convex")
    );
    let zero = format!("{parts}shape = {{ kind = 'cube', edge_m = 1 }}\norientation_wxyz = [0, 0, 0, 0]");
    assert!(text(build(&zero)).starts_with("parts[1].orientation_wxyz has norm 0"));
    assert!(text(build("kind = 'cross_2d'\nbeam_length_m = 1\nbeam_width_m = 1")).contains("longer than"));
}

#[test]
fn descriptions_refuse_unknown_keys_and_round_trip() {
    let parse = toml::from_str::<ShapeDescription>;
    assert!(parse("kind = 'cube'\nedge_m = 1.0\nedge_mm = 3").unwrap_err().to_string().contains("edge_mm"));
    assert!(parse("kind = 'cone'\nedge_m = 1.0").is_err());
    assert!(
        parse("kind = 'composite'\nparts = [{ shape = { kind = 'cube', edge_m = 1 }, positon_m = [0, 0, 0] }]")
            .is_err()
    );
    let cross = parse("kind = 'cross_3d'\nbeam_length_m = 5.0\nbeam_width_m = 1.0").unwrap();
    let text = toml::to_string(&cross).unwrap();
    assert_eq!(parse(&text).unwrap(), cross);
    let schema = schemars::schema_for!(ShapeDescription);
    assert!(serde_json_text(&schema).contains("total_length_m"));
}

fn serde_json_text(schema: &schemars::Schema) -> String {
    format!("{:?}", schema.as_value())
}

/// Faces with more corners than the manifold has room for must be refused, not clipped wrongly.
#[test]
fn faces_of_too_many_corners_are_refused() {
    let prism = |sides: u32| -> Vec<[f64; 3]> {
        (0..2 * sides)
            .map(|k| {
                let (sin, cos) = (2.0 * PI * f64::from(k / 2) / f64::from(sides)).sin_cos();
                [cos, sin, f64::from(k % 2)]
            })
            .collect()
    };
    assert!(polyhedron(&prism(32)).is_ok());
    assert!(matches!(polyhedron(&prism(33)), Err(ShapeError::TooMany { count: 33, most: 32, .. })));
}

/// Every edge of a drawn surface is used once in either sense, and the volume is that of the shape.
#[test]
fn surfaces_are_closed_and_look_outwards() {
    for text in [
        "kind = 'sphere'\nradius_m = 1.0",
        "kind = 'spherocylinder'\nradius_m = 0.5\ntotal_length_m = 3.0",
        "kind = 'pinacoid'\nlength_m = 1\nwidth_m = 1\nheight_m = 1\nalpha_deg = 60",
    ] {
        let s = shape(text);
        let mesh = s.surface();
        let mut volume = 0.0;
        let mut edges = std::collections::BTreeSet::new();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
            volume += a.dot(&b.cross(&c)) / 6.0;
            for k in 0..3 {
                assert!(edges.insert((t[k], t[(k + 1) % 3])), "{text}");
            }
        }
        assert!(edges.iter().all(|&(from, to)| edges.contains(&(to, from))), "{text}");
        // inscribed: 24 meridians and 12 parallels lose 3 % of a ball
        let lost = 1.0 - volume / s.mass_properties().volume;
        assert!((-1e-12..0.03).contains(&lost), "{text}: {lost}");
    }
}

/// P0.2: R = 4 mm, L = 5.3 mm, M = 3.1e-4 kg: V = 2.66407e-7, I = 2.48e-9 (axis), 1.96566e-9 (across).
#[test]
fn cylinder_of_the_glued_paper() {
    let (r, l, mass) = (4e-3, 5.3e-3, 3.1e-4);
    let s = shape(&format!("kind = 'cylinder'\nradius_m = {r}\nlength_m = {l}"));
    let m = s.mass_properties();
    close(m.volume, PI * r * r * l, 1e-14);
    close(m.volume, 2.66407e-7, 1e-6);
    let inertia = m.principal_inertia * (mass / m.volume);
    close(inertia.x, 0.5 * mass * r * r, 1e-14);
    close(inertia.y, mass * (3.0 * r * r + l * l) / 12.0, 1e-14);
    close(inertia.y, 1.96566e-9, 2e-6);
    assert_eq!(inertia.y, inertia.z);
    close(s.bounding_radius(), (0.5 * l).hypot(r), 1e-13);
    assert_eq!((s.half_thickness(), m.relative_error), (0.5 * l, 0.0));
    // M r^2 / I of the rim, and 0.5 % for the polygon about it
    let exact = mass * ((0.5 * l).powi(2) + r * r) / inertia.y;
    assert!(s.leverage().normal >= exact && s.leverage().normal < 1.01 * exact, "{}", s.leverage().normal);
    let mesh = s.surface();
    let signed = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
        a.dot(&b.cross(&c)) / 6.0
    };
    let prism = 0.5 * 24.0 * (PI / 12.0).sin() * r * r * l;
    close(mesh.triangles.iter().map(signed).sum(), prism, 1e-12);
    assert!(matches!(build("kind = 'cylinder'\nradius_m = 1.0\nlength_m = 0.0"), Err(ShapeError::NotPositive { .. })));
    assert!(matches!(build("kind = 'cylinder'\nradius_m = 1.0\nlength_m = 1e-13"), Err(ShapeError::Volume { .. })));
}

/// Cylinders glued end to end are one cylinder; in a skew frame the axes are found again.
#[test]
fn composites_of_cylinders() {
    let half = |x: f64| {
        format!("{{ shape = {{ kind = 'cylinder', radius_m = 0.5, length_m = 1.0 }}, position_m = [{x}, 0.0, 0.0] }}")
    };
    let glued = shape(&format!("kind = 'composite'\nparts = [{}, {}]", half(-0.5), half(0.5)));
    let (m, whole) = (glued.mass_properties(), shape("kind = 'cylinder'\nradius_m = 0.5\nlength_m = 2.0"));
    let w = whole.mass_properties();
    assert_eq!(m.relative_error, 0.0);
    close(m.volume, w.volume, 1e-14);
    assert!((m.principal_inertia - w.principal_inertia).amax() < 1e-14);
    // two orthogonal equal cylinders, PHYSICS.md P0.6: on the lattice
    let crossed = shape(
        "kind = 'composite'\nparts = [{ shape = { kind = 'cylinder', radius_m = 1.0, length_m = 3.0 } },
         { shape = { kind = 'cylinder', radius_m = 1.0, length_m = 3.0 }, orientation_wxyz = [0.7071067811865476, 0.0, 0.0, 0.7071067811865476] }]",
    );
    let m = crossed.mass_properties();
    let off = [m.volume / 13.516222588, m.principal_inertia.x / 11.648278052, m.principal_inertia.z / 16.005111477];
    println!("two crossed cylinders: V, Ixx, Izz off by {:?}, stated {:e}", off.map(|x| x - 1.0), m.relative_error);
    assert!(off.iter().all(|x| (x - 1.0).abs() <= m.relative_error), "{off:?} {}", m.relative_error);
}
