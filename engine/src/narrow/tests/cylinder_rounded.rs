//! Cylinders against rounded polyhedra: closed forms, and the least distance of cylinder and skeleton by brute force.

use super::*;
use crate::narrow::ManifoldPoint;
use crate::shape::{MassDescription, Skeleton};

const QUARTER: f64 = std::f64::consts::FRAC_PI_2;

fn cylinder(radius: f64, length: f64) -> Part {
    part(&ShapeDescription::Cylinder { radius_m: radius, length_m: length })
}

fn rounded(points: &[Vec3], radius: f64) -> Part {
    part(&ShapeDescription::RoundedPolyhedron {
        radius_m: radius,
        vertices_m: points.iter().map(|p| [p.x, p.y, p.z]).collect(),
        edges: Vec::new(),
        faces: Vec::new(),
        mass_properties: None,
    })
}

fn rounded_box(half: [f64; 3], radius: f64) -> Part {
    let corner = |k: usize| Vec3::from_fn(|axis, _| if k >> axis & 1 == 1 { half[axis] } else { -half[axis] });
    rounded(&(0..8).map(corner).collect::<Vec<_>>(), radius)
}

fn skeleton_of(radius: f64, vertices_m: Vec<[f64; 3]>, edges: Vec<[u32; 2]>, faces: Vec<Vec<u32>>) -> Part {
    let mass = MassDescription { volume_m3: 1.0, inertia_over_mass_m2: [1.0; 3] };
    part(&ShapeDescription::RoundedPolyhedron {
        radius_m: radius,
        vertices_m,
        edges,
        faces,
        mass_properties: Some(mass),
    })
}

/// Two faces like an open book, and three crossing edges without faces.
fn open_ones() -> [Part; 2] {
    let book =
        vec![[0.0, -0.7, 0.0], [0.0, 0.7, 0.0], [0.8, -0.7, 0.5], [0.8, 0.7, 0.5], [-0.6, -0.7, 0.7], [-0.6, 0.7, 0.7]];
    let star = [0.9, 0.7, 0.5];
    let ends =
        (0..6).map(|k| std::array::from_fn(|axis| if axis == k / 2 { star[axis] * [1.0, -1.0][k % 2] } else { 0.0 }));
    [
        skeleton_of(0.15, book, Vec::new(), vec![vec![0, 1, 3, 2], vec![1, 0, 4, 5]]),
        skeleton_of(0.2, ends.collect(), vec![[0, 1], [2, 3], [4, 5]], Vec::new()),
    ]
}

fn skeleton(part: &Part) -> &Skeleton {
    let PartGeometry::RoundedPolyhedron(p) = &part.geometry else { panic!("not rounded") };
    &p.skeleton
}

/// Distance of a point from a solid cylinder, 0 inside, from its definition.
fn distance_to(part: &Part, x: &Vec3) -> f64 {
    let PartGeometry::Cylinder { ends: [p, q], radius } = &part.geometry else { panic!("not a cylinder") };
    let axis = (q - p).normalize();
    let along = axis.dot(&(x - p));
    let beyond = (-along).max(along - (q - p).norm()).max(0.0);
    let beside = ((x - p) - axis * along).norm() - radius;
    beyond.hypot(beside.max(0.0))
}

/// Least value of a convex function on [0, 1], by golden sections.
fn least(f: impl Fn(f64) -> f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (0.0, 1.0);
    let (mut x, mut y) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut of_x, mut of_y) = (f(x), f(y));
    let mut best = f(0.0).min(f(1.0)).min(of_x).min(of_y);
    for _ in 0..44 {
        if of_x < of_y {
            (high, y, of_y) = (y, x, of_x);
            x = high - ratio * (high - low);
            of_x = f(x);
        } else {
            (low, x, of_x) = (x, y, of_y);
            y = low + ratio * (high - low);
            of_y = f(y);
        }
        best = best.min(of_x).min(of_y);
    }
    best
}

/// Distance of cylinder and skeleton, 0 where they meet: over faces, cut into triangles, and edges.
fn brute_force(cylinder: &Part, body: &Part, pose: &Similarity) -> f64 {
    let skeleton = skeleton(body);
    let at = |v: u32| pose.point(&skeleton.vertices()[v as usize]);
    let of_edge = |[v, w]: [u32; 2]| least(|s| distance_to(cylinder, &(at(v) + (at(w) - at(v)) * s)));
    let of_triangle = |[u, v, w]: [u32; 3]| {
        let (p, q, r) = (at(u), at(v), at(w));
        least(|s| least(|t| distance_to(cylinder, &(p + ((q - p) * (1.0 - t) + (r - p) * t) * s))))
    };
    let edges = skeleton.edges().iter().map(|e| of_edge(e.vertices)).fold(f64::MAX, f64::min);
    let triangles = skeleton.loops().iter().flat_map(|f| (2..f.len()).map(|k| [f[0], f[k - 1], f[k]]));
    triangles.map(of_triangle).fold(edges, f64::min)
}

/// Whether the middle of the cylinder lies within a convex skeleton: the distance of its surface means nothing then.
fn swallowed(body: &Part, pose: &Similarity) -> bool {
    let (middle, skeleton) = (pose.inverse_point(&Vec3::zeros()), skeleton(body));
    skeleton.is_convex() && skeleton.faces().iter().all(|f| f.normal.dot(&middle) < f.offset)
}

fn at(rotation: Mat3, x: f64, y: f64, z: f64) -> Similarity {
    Similarity::rigid(rotation, Vec3::new(x, y, z))
}

/// Number of points, and that each is as deep and looks as it should.
fn expect(m: &Manifold, count: usize, normal: Vec3, overlap: f64, label: &str) {
    assert_eq!(m.len(), count, "{label}: {:?}", m.points());
    for p in m.points() {
        assert!((p.normal - normal).norm() < 1e-12, "{label}: {}", p.normal);
        assert!((p.overlap - overlap).abs() < 1e-12, "{label}: {:e}", p.overlap);
        assert!((p.share / m.points()[0].share - 1.0).abs() < 1e-9, "{label}: {}", p.share);
    }
    oracle::check_keys(m, label);
}

fn has_point(m: &Manifold, x: Vec3) -> bool {
    m.points().iter().any(|p| (p.position - x).norm() < 1e-6)
}

/// The block is `a`: normals point up to the cylinder. Its flat faces are at 1.
#[test]
fn closed_forms() {
    let (block, c) = (rounded_box([0.9; 3], 0.1), cylinder(0.4, 1.0));
    let upright = rotation(Vec3::y(), QUARTER);
    let standing = contacts(&block, &c, &at(upright, 0.1, 0.2, 1.499));
    expect(&standing, 4, Vec3::z(), 1e-3, "standing");
    assert!(standing.points().iter().all(|p| (p.position.z - 0.9995).abs() < 1e-12));
    let lying = contacts(&block, &c, &at(rotation(Vec3::z(), 0.3), 0.1, 0.2, 1.399));
    expect(&lying, 2, Vec3::z(), 1e-3, "lying");
    let (sin, cos) = 0.3_f64.sin_cos();
    assert!(has_point(&lying, Vec3::new(0.1 + 0.5 * cos, 0.2 + 0.5 * sin, 0.9995)));
    // beyond the edge: the line of the side ends above it
    let over = contacts(&block, &c, &at(Mat3::identity(), 0.7, 0.2, 1.399));
    expect(&over, 2, Vec3::z(), 1e-3, "over the edge");
    assert!(has_point(&over, Vec3::new(0.9, 0.2, 0.9995)) && has_point(&over, Vec3::new(0.2, 0.2, 0.9995)));
    // half of the cap beyond the edge: the rim crosses it twice
    let half = contacts(&block, &c, &at(upright, 0.9, 0.0, 1.499));
    assert!(half.points().iter().all(|p| (p.normal - Vec3::z()).norm() < 1e-12 && p.position.x < 0.9 + 1e-9));
    assert!(has_point(&half, Vec3::new(0.9, 0.4, 0.9995)) && has_point(&half, Vec3::new(0.9, -0.4, 0.9995)));
    // a wide cap on a small block: its four vertices
    expect(&contacts(&block, &cylinder(3.0, 1.0), &at(upright, 0.3, 0.2, 1.499)), 4, Vec3::z(), 1e-3, "a table");
    // the side leans on an edge, across it and along it
    let diagonal = Vec3::new(0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt());
    let beside = Vec3::new(0.9, 0.0, 0.9) + diagonal * (0.4 + 0.1 - 1e-3);
    let leaning = |turn: Mat3| contacts(&block, &c, &Similarity::rigid(turn, beside));
    expect(&leaning(rotation(Vec3::y(), 0.5 * QUARTER)), 1, diagonal, 1e-3, "across an edge");
    expect(&leaning(rotation(Vec3::z(), QUARTER)), 2, diagonal, 1e-3, "along an edge");
    // a rim tilted onto the face
    let low = (0.5 + 0.4) * 0.5_f64.sqrt();
    expect(
        &contacts(&block, &c, &at(rotation(Vec3::y(), 0.5 * QUARTER), 0.0, 0.0, 0.999 + low)),
        1,
        Vec3::z(),
        1e-3,
        "a rim",
    );
    // a cap and the side on a vertex: r - distance
    let out = Vec3::new(1.0, 1.0, 1.0).normalize();
    let onto = |n: Vec3| *crate::math::Quat::rotation_between(&Vec3::x(), &n).unwrap().to_rotation_matrix().matrix();
    let corner = Vec3::from_element(0.9);
    let cap = contacts(&block, &c, &Similarity::rigid(onto(out), corner + out * (0.5 + 0.07)));
    expect(&cap, 1, out, 0.03, "a cap on a vertex");
    let across = Vec3::new(1.0, -1.0, 0.0).normalize();
    let side = contacts(&block, &c, &Similarity::rigid(onto(across), corner + out * (0.4 + 0.07)));
    expect(&side, 1, out, 0.03, "the side on a vertex");
}

/// Generic poses, and poses within 1e-16 to 1e-1 of an alignment by quarter turns, half of them slid to a gap of up to twice r.
fn some_pose(random: &mut Random, case: usize, cylinder: &Part, body: &Part) -> Similarity {
    let turn = match case % 3 {
        0 => random.rotation(),
        _ => {
            let quarter = |random: &mut Random| QUARTER * random.below(4) as f64;
            let aligned = rotation(Vec3::x(), quarter(random)) * rotation(Vec3::y(), quarter(random));
            let off = if case % 3 == 1 { 10_f64.powf(random.between(-16.0, -1.0)) } else { 0.0 };
            rotation(random.direction(), off) * aligned
        }
    };
    let reach = cylinder.radius + body.radius;
    let scale = 2.0_f64.powi(random.below(3) as i32 - 1);
    let mut pose = Similarity { rotation: turn, translation: random.in_ball() * reach, scale };
    let way = pose.translation.normalize();
    let wanted = random.between(0.0, 1.2) * skeleton(body).radius * scale;
    // towards each other along the line of the middles; the distance changes by at most the way
    for _ in 0..8 {
        let off = brute_force(cylinder, body, &pose) - wanted;
        if off.abs() < 1e-4 || pose.translation.norm() > 3.0 * reach {
            break;
        }
        pose.translation -= way * (if off <= -wanted { -0.1 * reach } else { off });
    }
    pose
}

struct Tally {
    touching: usize,
    apart: usize,
    inside: usize,
    worst: f64,
}

fn sweep(bodies: &[Part], seed: u64, cases: usize) -> Tally {
    let cylinders =
        [cylinder(0.5, 1.0), cylinder(0.2, 2.0), cylinder(1.0, 0.1), cylinder(0.05, 3.0), cylinder(2.0, 1.0)];
    let mut random = Random(seed);
    let mut tally = Tally { touching: 0, apart: 0, inside: 0, worst: 0.0 };
    for case in 0..cases {
        let (c, body) = (&cylinders[random.below(cylinders.len())], &bodies[case % bodies.len()]);
        let pose = some_pose(&mut random, case / bodies.len(), c, body);
        let distance = brute_force(c, body, &pose);
        let radius = skeleton(body).radius * pose.scale;
        let manifold = contacts(c, body, &pose);
        let label = format!("case {case}, distance {distance:e}, r {radius}: {:?} of {c:?}", manifold.points());
        let found = depth(&manifold);
        if distance > 0.0 && !swallowed(body, &pose) {
            // sections to 6e-10 of the lengths, and the distance is smooth: its square; measured 1.4e-15
            let off = (found - (radius - distance).max(0.0)).abs();
            assert!(off < 1e-12, "{label}: off {off:e}");
            tally.worst = tally.worst.max(off);
            tally.touching += usize::from(found > 0.0);
            tally.apart += usize::from(found == 0.0);
        } else if skeleton(body).is_convex() {
            assert!(found >= radius, "{label}");
            tally.inside += 1;
        }
        for p in manifold.points() {
            assert!((p.normal.norm() - 1.0).abs() < 1e-12 && p.overlap > 0.0 && p.share > 0.0, "{label}");
            assert!(p.share.is_finite() && p.position.iter().all(|x| x.is_finite()), "{label}");
        }
        oracle::check_keys(&manifold, &label);
        check_swapped((c, body), &pose, &manifold, &label);
    }
    println!("{} touch, {} apart, {} inside, worst {:e}", tally.touching, tally.apart, tally.inside, tally.worst);
    tally
}

/// Swapping the two gives the opposite; twice or half the size gives the same in that unit, to the bit.
fn check_swapped((c, body): (&Part, &Part), pose: &Similarity, direct: &Manifold, label: &str) {
    let mut swapped = contacts(body, c, &pose.inverse());
    swapped.map_from(0, pose);
    swapped.flip_from(0);
    let deepest = |m: &Manifold| m.points().iter().copied().max_by(|p, q| p.overlap.total_cmp(&q.overlap));
    let off = (depth(direct) - depth(&swapped)).abs();
    assert!(off < 1e-10, "{label}: swapped {off:e}");
    if let (Some(p), Some(q)) = (deepest(direct), deepest(&swapped)) {
        let same = |p: &ManifoldPoint, q: &ManifoldPoint| (p.normal - q.normal).norm() < 1e-6;
        assert!(
            same(&p, &q) || swapped.points().iter().any(|x| same(x, &p) && (x.overlap - p.overlap).abs() < 1e-10),
            "{label}"
        );
    }
}

#[test]
fn touch_where_the_distance_is_less_than_r() {
    let mut random = Random(50);
    let points: Vec<Vec3> = (0..12).map(|_| random.direction()).collect();
    let bodies = [
        rounded_box([0.45; 3], 0.05),
        rounded_box([0.9, 0.5, 0.1], 0.2),
        rounded(&[Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()], 0.1),
        rounded(&points, 0.02),
    ];
    let tally = sweep(&bodies, 51, 2_000);
    assert!(tally.touching > 700 && tally.apart > 100, "{} {}", tally.touching, tally.apart);
}

#[test]
fn skeletons_that_are_not_convex() {
    let tally = sweep(&open_ones(), 52, 1_000);
    assert!(tally.touching > 300 && tally.apart > 60, "{} {}", tally.touching, tally.apart);
}

/// Lengths in another unit, by a power of two: the same to the bit.
#[test]
fn powers_of_two_are_exact() {
    let (c, body) = (cylinder(0.5, 1.0), rounded_box([0.45, 0.4, 0.3], 0.05));
    let (c4, body4) = (cylinder(2.0, 4.0), rounded_box([1.8, 1.6, 1.2], 0.2));
    let mut random = Random(53);
    for case in 0..300 {
        let pose = some_pose(&mut random, case, &c, &body);
        let four = Similarity { translation: pose.translation * 4.0, ..pose };
        let (one, other) = (contacts(&c, &body, &pose), contacts(&c4, &body4, &four));
        assert_eq!(one.len(), other.len());
        for (p, q) in one.points().iter().zip(other.points()) {
            assert_eq!((p.overlap * 4.0, p.normal, p.feature), (q.overlap, q.normal, q.feature));
            assert_eq!(
                (p.position * 4.0, p.share / one.points()[0].share),
                (q.position, q.share / other.points()[0].share)
            );
        }
    }
}

/// Force and torque of the law f = k w d with w = share d / sum(share d): no jump while a cylinder turns over a block whose
/// rounding is much larger than the overlap.
#[test]
fn the_force_is_continuous() {
    let (c, block) = (cylinder(0.4, 1.0), rounded_box([0.35; 3], 0.1));
    let resultant = |pose: &Similarity| {
        let m = contacts(&c, &block, pose);
        let total: f64 = m.points().iter().map(|p| p.share * p.overlap).sum();
        let force = |p: &ManifoldPoint| p.normal * (p.share * p.overlap * p.overlap / total.max(1e-300));
        let forces = m.points().iter().map(force).sum::<Vec3>();
        (forces, m.points().iter().map(|p| p.position.cross(&force(p))).sum::<Vec3>())
    };
    let overlap = 2e-3;
    for (shift, axis) in [(0.2, Vec3::y()), (0.1, Vec3::new(0.3, 1.0, 0.2)), (0.3, Vec3::new(0.1, 0.2, 1.0))] {
        let mut before: Option<(Vec3, Vec3)> = None;
        for step in 0..20_000 {
            let turn = rotation(axis, f64::from(step) * (QUARTER / 20_000.0));
            let low = skeleton(&block).vertices().iter().map(|v| -(turn * v).x).fold(f64::MIN, f64::max) + 0.1;
            let now = resultant(&at(turn, 0.5 + low - overlap, shift, 0.05));
            if let Some((force, torque)) = before {
                let jump = (now.0 - force).norm().max((now.1 - torque).norm());
                // a step turns by 8e-5, which moves a point by up to 5e-5, and the shares with it
                assert!(jump < 2e-4, "step {step} about {axis}: {jump:e} of {:e}", force.norm());
            }
            before = Some(now);
        }
    }
}

/// What is known of a pair may only save work: the same contacts, to the bit, with and without.
#[test]
fn what_is_known_of_a_pair_is_invisible() {
    let [book, star] = open_ones();
    let bodies = [rounded_box([0.45; 3], 0.05), rounded_box([0.9, 0.5, 0.1], 0.2), book, star];
    let cylinders = [cylinder(0.5, 1.0), cylinder(0.2, 2.0), cylinder(1.0, 0.1)];
    let mut random = Random(54);
    let (mut touching, mut apart) = (0, 0);
    for walk in 0..120 {
        let (c, body) = (&cylinders[random.below(cylinders.len())], &bodies[walk % bodies.len()]);
        let mut pose = some_pose(&mut random, walk, c, body);
        let mut cache = PairCache::default();
        for step in 0..60 {
            let mut known = Manifold::default();
            collide(c, body, &pose, &mut cache, &mut known);
            let fresh = contacts(c, body, &pose);
            assert_eq!(known.points(), fresh.points(), "walk {walk}, step {step}: {pose:?}");
            touching += usize::from(!fresh.is_empty());
            apart += usize::from(fresh.is_empty());
            let size = 10_f64.powf(random.between(-7.0, if step % 20 == 19 { -0.5 } else { -2.0 }));
            pose.translation += random.in_ball() * size;
            pose.rotation = rotation(random.direction(), size) * pose.rotation;
        }
    }
    assert!(touching > 1_500 && apart > 500, "{touching} {apart}");
}
