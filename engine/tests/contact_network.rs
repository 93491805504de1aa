//! The contact network against closed forms, all pairs, and the forces that particles and boundaries feel.

mod common;

use std::collections::BTreeMap;

use common::{drum, engine, header, particle, plane, shape, steps};
use sturz_engine::{Command, ContactKind, ContactNetwork, ContactRow, Engine, LoadDescription, Snapshot};

const PAIR: &str = "stiffness_n_per_m = 1e3\nrestitution = 0.7\nfriction = 0.4";

fn network(engine: &Engine) -> ContactNetwork {
    let mut network = ContactNetwork::default();
    engine.contact_network(&mut network);
    network
}

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    assert!(snapshot.forces.is_empty() && snapshot.torques.is_empty(), "nobody has asked");
    engine.snapshot_forces(&mut snapshot);
    snapshot
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn near(found: [f64; 3], wanted: [f64; 3], tolerance: f64) -> bool {
    (0..3).all(|c| (found[c] - wanted[c]).abs() <= tolerance)
}

/// Two balls of 1 mm that overlap by 0.1 mm press each other apart with k times that; at rest no dashpot acts.
#[test]
fn two_spheres_at_rest_press_by_stiffness_times_overlap() {
    let text = header([0.0; 3], 1e-6, "", PAIR)
        + &shape("kind = \"sphere\", radius_m = 1e-3")
        + &particle([0.0; 3], [0.0; 3], [0.0; 3])
        + &particle([0.0, 1.9e-3, 0.0], [0.0; 3], [0.0; 3]);
    let engine = engine(&text);
    let found = network(&engine);
    assert_eq!((found.step, found.topology_epoch, found.rows.len()), (0, 0, 1));
    let row = &found.rows[0];
    assert_eq!((row.id_a, row.id_b, row.boundary, row.parts), (0, Some(1), None, [0, 0]));
    assert_eq!((row.kind, row.points), (ContactKind::Smooth, 1));
    assert!(near(row.normal, [0.0, 1.0, 0.0], 2e-16), "{row:?}");
    // 1.9 mm and 2 mm are rounded to 2e-19 m
    assert!((row.overlap_m - 1e-4).abs() < 1e-18 && near(row.point_m, [0.0, 0.95e-3, 0.0], 1e-18), "{row:?}");
    assert!((row.normal_force_n - 0.1).abs() < 1e-15 && near(row.tangential_force_n, [0.0; 3], 1e-16), "{row:?}");
    assert_eq!(row.moment_n_m, [0.0; 3]);
    let forces = snapshot(&engine).forces;
    assert!(near(forces[0], row.force_on_a_n(), 1e-16) && forces[1] == forces[0].map(|f| -f), "{forces:?}");
}

/// A cube face down on a plane, pressed in by 10 um: under the law of points four vertices carry it, as one row.
#[test]
fn a_cube_on_a_plane_is_one_row_of_four_points() {
    let text = header([0.0; 3], 1e-6, "normal = \"linear\"", PAIR)
        + &shape("kind = \"cube\", edge_m = 2e-3")
        + &plane("lid", [0.0, 0.0, 1.0], [0.0, 0.0, -1.0])
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + &particle([0.0, 0.0, 0.99e-3], [0.0; 3], [0.0; 3]);
    let engine = engine(&text);
    let rows = network(&engine).rows;
    let row = &rows[0];
    assert_eq!((rows.len(), row.id_a, row.id_b, row.boundary), (1, 0, None, Some(1)));
    assert_eq!((row.kind, row.points), (ContactKind::Manifold, 4));
    assert!(near(row.normal, [0.0, 0.0, -1.0], 1e-15) && (row.overlap_m - 1e-5).abs() < 1e-17, "{row:?}");
    assert!((row.normal_force_n - 1e-2).abs() < 1e-14 && near(row.tangential_force_n, [0.0; 3], 1e-17), "{row:?}");
    assert!(near(row.point_m, [0.0, 0.0, -0.5e-5], 1e-17) && near(row.moment_n_m, [0.0; 3], 1e-17), "{row:?}");
    assert!(near(snapshot(&engine).boundaries[1].force_n, [0.0, 0.0, -1e-2], 1e-14));
}

/// What acts from outside is no contact; local damping is told with them.
#[test]
fn gravity_and_loads_are_left_out_of_the_forces() {
    let bead = |integrator: &str| {
        let text = header([0.0, 0.0, -9.81], 1e-5, "", PAIR)
            + integrator
            + &shape("kind = \"sphere\", radius_m = 1e-3")
            + &particle([0.0; 3], [0.0, 0.0, -0.1], [0.0; 3]);
        let mut engine = engine(&text);
        let loads = LoadDescription {
            ids: vec![0],
            force_n: vec![[1e-3, 0.0, 0.0]],
            torque_n_m: vec![[0.0, 1e-7, 0.0]],
            ..LoadDescription::default()
        };
        engine.apply(&Command::SetLoads(loads)).unwrap();
        steps(&mut engine, 3);
        snapshot(&engine)
    };
    let free = bead("");
    assert!(free.velocities[0][0] > 0.0 && free.angular_velocities[0][1] > 0.0);
    assert_eq!((&free.forces[..], &free.torques[..]), (&[[0.0; 3]][..], &[[0.0; 3]][..]));
    // local damping takes a tenth of the weight, against the motion
    let weight = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-9 * 9.81;
    let damped = bead("[integrator]\nlocal_damping = 0.1\n");
    assert!((damped.forces[0][2] - 0.1 * weight).abs() < 1e-12 * weight, "{:?}", damped.forces);
}

/// Which particle or boundary.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    Particle(u64),
    Boundary(u32),
}

/// Checks that the rows are in order, that their sums are the forces and torques of particles and boundaries, and returns
/// how many there are of particles and of boundaries.
fn check_sums(engine: &Engine, label: &str) -> [usize; 2] {
    let (state, rows) = (snapshot(engine), network(engine).rows);
    let domain = &engine.scene().description().domain;
    let apart = |x: [f64; 3], centre: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|c| {
            let (d, cell) = (x[c] - centre[c], domain.max_m[c] - domain.min_m[c]);
            if domain.periodic[c] { d - cell * (d / cell).round() } else { d }
        })
    };
    let centres: BTreeMap<u64, [f64; 3]> = state.ids.iter().copied().zip(state.positions.iter().copied()).collect();
    let mut sums: BTreeMap<Side, ([f64; 3], [f64; 3])> = BTreeMap::new();
    let mut largest: f64 = 0.0;
    for row in &rows {
        let force = row.force_on_a_n();
        largest = force.iter().fold(largest, |most, f| most.max(f.abs()));
        let norm: f64 = row.normal.iter().map(|n| n * n).sum();
        let along: f64 = (0..3).map(|c| row.normal[c] * row.tangential_force_n[c]).sum();
        assert!((norm - 1.0).abs() < 1e-14 && along.abs() <= 1e-14 * largest, "{label}: {row:?}");
        let mut add = |side: Side, sign: f64, arm: [f64; 3]| {
            let turning = cross(arm, force);
            let (f, t) = sums.entry(side).or_default();
            for c in 0..3 {
                f[c] += sign * force[c];
                t[c] += sign * (turning[c] + row.moment_n_m[c]);
            }
        };
        add(Side::Particle(row.id_a), 1.0, apart(row.point_m, centres[&row.id_a]));
        match (row.id_b, row.boundary) {
            (Some(b), None) => {
                assert!(row.id_a < b, "{label}: {row:?}");
                add(Side::Particle(b), -1.0, apart(row.point_m, centres[&b]));
            }
            (None, Some(boundary)) => {
                let centre = state.boundaries[boundary as usize].point_m;
                add(Side::Boundary(boundary), -1.0, std::array::from_fn(|c| row.point_m[c] - centre[c]));
            }
            _ => panic!("{label}: {row:?}"),
        }
    }
    let key = |row: &ContactRow| (row.id_a, row.id_b.unwrap_or(u64::MAX), row.boundary, row.parts);
    assert!(rows.is_sorted_by_key(key), "{label}");
    // a particle has some ten contacts, an arm is at most some tenths of a metre
    let tolerance = 1e-13 * largest;
    let zero = ([0.0; 3], [0.0; 3]);
    for (k, id) in state.ids.iter().enumerate() {
        let (force, torque) = sums.get(&Side::Particle(*id)).unwrap_or(&zero);
        assert!(near(*force, state.forces[k], tolerance), "{label}: {id}: {force:?} {:?}", state.forces[k]);
        assert!(near(*torque, state.torques[k], tolerance), "{label}: {id}: {torque:?} {:?}", state.torques[k]);
    }
    for (k, boundary) in state.boundaries.iter().enumerate() {
        let (force, torque) = sums.get(&Side::Boundary(k as u32)).unwrap_or(&zero);
        // these sums have as many terms as there are rows
        assert!(near(*force, boundary.force_n, 10.0 * tolerance), "{label}: {force:?} {boundary:?}");
        assert!(near(*torque, boundary.torque_n_m, 10.0 * tolerance), "{label}: {torque:?} {boundary:?}");
    }
    let report = engine.report();
    let points: u64 = rows.iter().map(|row| u64::from(row.points)).sum();
    assert_eq!(points, report.contact_points, "{label}");
    let at_walls = rows.iter().filter(|row| row.boundary.is_some()).count();
    [rows.len() - at_walls, at_walls]
}

/// Balls in a box, rolling friction and local sizes included, so that moments are not 0.
fn rolling_balls() -> String {
    let places: Vec<[f64; 3]> = (0..60).map(|k| [k % 4, k / 4 % 4, k / 16].map(|n| f64::from(n) * 0.98e-3)).collect();
    let pair = "stiffness_n_per_m = 2e2\nrestitution = 0.7\nfriction = 0.4\nrolling_friction = 0.1";
    header([0.5, 0.0, -9.81], 2e-6, "overlap_limit = 1.0", pair)
        + &plane("floor", [0.0, 0.0, -0.45e-3], [0.0, 0.0, 1.0])
        + &shape("kind = \"sphere\", radius_m = 0.5e-3")
        + &format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nscale = {{ min = 0.9, max = 1.1 }}\n\
             placement = {{ method = \"poses\", positions_m = {places:?} }}\n"
        )
}

/// The same under the plain law, which evaluates pairs of spheres in batches, in a periodic cell three of them wide.
fn periodic_balls() -> String {
    rolling_balls().replace("\nrolling_friction = 0.1", "")
        + &format!(
            "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [{0:?}, {0:?}, 0.0]\nperiodic = [true, true, false]\n",
            3.92e-3
        )
}

fn scenes() -> [(&'static str, String, u64); 4] {
    let linear = drum(90).replacen("[domain]", "[contact]\nnormal = \"linear\"\n[domain]", 1);
    let rounded = "[contact.generalized_overlap]\nrounding_fraction = 0.05\n[domain]";
    [
        ("crosses by generalized overlap", drum(90).replacen("[domain]", rounded, 1), 6000),
        ("crosses by points", linear, 6000),
        ("rolling balls", rolling_balls(), 300),
        ("balls in batches", periodic_balls(), 300),
    ]
}

#[test]
fn rows_add_up_to_what_particles_and_boundaries_feel() {
    for (label, text, count) in scenes() {
        let mut engine = engine(&text);
        let mut seen = [0; 2];
        for _ in 0..4 {
            steps(&mut engine, count / 4);
            let found = check_sums(&engine, label);
            seen = [seen[0].max(found[0]), seen[1].max(found[1])];
        }
        assert!(seen[0] > 4 && seen[1] > 4, "{label}: {seen:?}");
        engine.apply(&Command::Remove(vec![3, 17])).unwrap();
        check_sums(&engine, label);
    }
}

#[test]
fn threads_caches_and_a_restore_do_not_show() {
    for (label, text, count) in scenes() {
        let run = |threads: usize, drops: bool| {
            let mut engine = engine(&text);
            engine.set_threads(threads);
            for k in 0..count {
                if drops && k % 37 == 0 {
                    engine.drop_caches();
                }
                steps(&mut engine, 1);
            }
            engine
        };
        let mut one = run(1, false);
        let reference = network(&one);
        assert!(network(&run(2, true)) == reference && network(&run(4, false)) == reference, "{label}");
        let hash = one.state_hash();
        let saved = one.checkpoint().unwrap();
        steps(&mut one, 200);
        assert!(network(&one) != reference, "{label}");
        one.restore(&saved).unwrap();
        assert!(network(&one) == reference && one.state_hash() == hash, "{label}");
        check_sums(&one, label);
    }
}

/// Every pair of balls nearer than the sum of their radii has a row, and no other one.
#[test]
fn all_pairs_find_the_same_contacts() {
    let mut engine = engine(&periodic_balls());
    steps(&mut engine, 300);
    let (state, cell) = (snapshot(&engine), 3.92e-3);
    let mut wanted = Vec::new();
    for a in 0..state.ids.len() {
        for b in a + 1..state.ids.len() {
            let d: [f64; 3] = std::array::from_fn(|c| {
                let d = state.positions[b][c] - state.positions[a][c];
                if c < 2 { d - cell * (d / cell).round() } else { d }
            });
            let overlap = 0.5e-3 * (state.scales[a] + state.scales[b]) - d.iter().map(|x| x * x).sum::<f64>().sqrt();
            if overlap > 0.0 {
                wanted.push((state.ids[a], state.ids[b], overlap));
            }
        }
    }
    let rows: Vec<ContactRow> = network(&engine).rows.into_iter().filter(|row| row.id_b.is_some()).collect();
    assert_eq!(rows.len(), wanted.len());
    for (row, (a, b, overlap)) in rows.iter().zip(wanted) {
        assert_eq!((row.id_a, row.id_b), (a, Some(b)));
        // positions of millimetres are rounded to 1e-18 m
        assert!((row.overlap_m - overlap).abs() < 1e-17, "{row:?} {overlap}");
    }
}
