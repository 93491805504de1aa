//! Going on from a checkpoint: the bits of the run that was never stopped, at every later step, on any number of threads.

mod common;
#[path = "common/meshes.rs"]
mod meshes;

use common::{drum, engine, header, particle, plane, run_for, shape, steps};
use meshes::{mesh, sheet};
use sturz_engine::scene::{AngularVelocity, MotionDescription};
use sturz_engine::{CheckpointSummary, Command, Engine, Report, Snapshot};

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

/// Equal to the bit; forces on boundaries, which are sums in the order of rows, to rounding.
fn assert_same_snapshot(mut a: Snapshot, mut b: Snapshot, what: &str) {
    for (a, b) in a.boundaries.iter_mut().zip(&mut b.boundaries) {
        let [size, off] =
            [[0.0; 3], b.force_n].map(|from| (0..3).map(|k| (a.force_n[k] - from[k]).abs()).fold(0.0, f64::max));
        assert!(off <= 1e-12 * size, "{what}: {:?} and {:?} N on {}", a.force_n, b.force_n, a.name);
        (a.force_n, a.torque_n_m) = ([0.0; 3], [0.0; 3]);
        (b.force_n, b.torque_n_m) = ([0.0; 3], [0.0; 3]);
    }
    assert!(a == b, "{what}: the snapshots differ");
}

/// Both stand at the same point, to the bit, in all that can be seen of them.
fn assert_same(engine: &Engine, other: &Engine, what: &str) {
    assert_eq!(engine.state_hash(), other.state_hash(), "{what}");
    assert_same_snapshot(snapshot(engine), snapshot(other), what);
    let (a, b) = (engine.report(), other.report());
    assert_eq!(a.energy, b.energy, "{what}");
    assert_eq!((a.touching_pairs, a.touching_boundary_pairs), (b.touching_pairs, b.touching_boundary_pairs), "{what}");
    assert_eq!(a.contact_points_by_kind, b.contact_points_by_kind, "{what}");
    assert_eq!(
        (a.largest_overlap_m, a.largest_overlap_ratio_so_far, a.warnings),
        (b.largest_overlap_m, b.largest_overlap_ratio_so_far, b.warnings)
    );
    let critical = [a.present_critical_time_step_s, b.present_critical_time_step_s];
    assert!(critical[0] == critical[1] || (critical[0] / critical[1] - 1.0).abs() < 1e-12, "{what}: {critical:?}");
}

/// Takes a checkpoint after `before` steps, and follows the run and two that go on from it for `after` more: one of
/// another thread count, and the run itself once it is done. Returns what there was to save.
fn goes_on_bitwise(what: &str, text: &str, before: u64, after: u64) -> (Report, Snapshot) {
    let mut run = engine(text);
    steps(&mut run, before);
    let untouched = run.state_hash();
    let saved = run.checkpoint().unwrap();
    assert_eq!(run.state_hash(), untouched, "{what}: a checkpoint leaves the run alone");
    assert_eq!(run.checkpoint().unwrap(), saved, "{what}: the same state gives the same bytes");
    let summary = CheckpointSummary::read(&saved).unwrap();
    assert_eq!((summary.step, summary.particles, summary.state_hash), (before, run.len() as u64, untouched), "{what}");

    let mut other = engine(text);
    other.set_threads(3);
    other.restore(&saved).unwrap_or_else(|error| panic!("{what}: {error}"));
    assert_same(&run, &other, what);
    let then = (run.report(), snapshot(&run));
    let mut hashes = Vec::new();
    for step in 0..after {
        steps(&mut run, 1);
        steps(&mut other, 1);
        hashes.push(run.state_hash());
        assert_eq!(other.state_hash(), hashes[step as usize], "{what}: step {step} after the checkpoint");
    }
    // of large numbers of terms in another order
    let (a, b) = (run.report().energy, other.report().energy);
    let scale = a.dissipated_normal_j + a.dissipated_friction_j + a.kinetic_translation_j + a.elastic_j;
    assert!((a.residual_j - b.residual_j).abs() <= 1e-11 * scale.max(f64::MIN_POSITIVE), "{what}: {a:?} {b:?}");

    run.restore(&saved).unwrap();
    assert_same(
        &run,
        &{
            let mut third = engine(text);
            third.restore(&saved).unwrap();
            third
        },
        what,
    );
    for (step, &hash) in hashes.iter().enumerate() {
        steps(&mut run, 1);
        assert_eq!(run.state_hash(), hash, "{what}: step {step} after going back");
    }
    // commands meet the same state
    for engine in [&mut run, &mut other] {
        engine.apply(&Command::SetGravity([0.3, 0.2, -5.0])).unwrap();
        if engine.len() > 3 {
            engine.apply(&Command::Remove(vec![1, 3])).unwrap();
        }
        steps(engine, 20);
    }
    assert_eq!(run.state_hash(), other.state_hash(), "{what}: after commands");
    then
}

fn bundled(name: &str) -> String {
    let path = format!("{}/../service/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Steps until something touches.
fn first_touch(text: &str) -> u64 {
    let mut engine = engine(text);
    while engine.report().contact_points == 0 {
        steps(&mut engine, 20);
        assert!(engine.clock().step() < 100_000, "nothing ever touches");
    }
    engine.clock().step()
}

#[test]
fn bundled_scenes() {
    for (name, after_touch) in [
        ("bouncing-sphere", 0),
        ("cube-heap", 4000),
        ("cube-tower", 2000),
        ("drum-crosses", 8000),
        ("drum-lifters", 4000),
        ("drum-spheres", 3000),
        ("pinacoid-layer", 3000),
        ("spherocylinder-slope", 3000),
    ] {
        let mut text = bundled(name);
        if name == "drum-crosses" {
            // it waits for its particles
            text += "[[insertion]]\nshape = \"cross\"\nmaterial = \"particle\"\nplacement = { method = \"random\", count = 60, region = { kind = \"cylinder\", point_m = [0.0, -0.015, -0.02], axis = [0.0, 1.0, 0.0], radius_m = 0.03, length_m = 0.03 } }\n";
        }
        let (report, _) = goes_on_bitwise(name, &text, first_touch(&text) + after_touch, 60);
        assert!(report.contact_points > 0, "{name}: nothing touches");
    }
}

/// Long enough for springs of sliding and sticking contacts, rebuilds and crossings of the cell.
#[test]
fn crosses_in_a_periodic_drum_under_both_laws() {
    let generalized = drum(80).replacen("1e3", "4e3", 1).replacen("2e-5", "1e-5", 1);
    let linear = generalized.replacen("[domain]", "[contact]\nnormal = \"linear\"\n[domain]", 1);
    for (what, text) in [("generalized overlap", generalized), ("linear", linear)] {
        let (report, _) = goes_on_bitwise(what, &text, 12_000, 500);
        assert!(report.touching_pairs > 5 && report.energy.dissipated_friction_j > 0.0, "{what}: {report:?}");
    }
}

/// A lattice of touching spheres that drifts through its periodic cell.
#[test]
fn spheres_that_cross_their_cell() {
    let places: Vec<[f64; 3]> = (0..5)
        .flat_map(|z| (0..6).flat_map(move |y| (0..6).map(move |x| [x, y, z].map(|k| f64::from(k) * 0.98e-3))))
        .collect();
    let extent = 6.0 * 0.98e-3;
    let laws = [
        ("linear", "", "stiffness_n_per_m = 2e2\nrestitution = 0.7\nfriction = 0.4"),
        (
            "rolling",
            "",
            "stiffness_n_per_m = 2e2\nrestitution = 0.7\nfriction = 0.4\nrolling_friction = 0.1\ntwisting_friction = 0.1",
        ),
        ("smooth", "tangential = \"none\"", "stiffness_n_per_m = 2e2\nrestitution = 0.7"),
    ];
    for (what, contact, pair) in laws {
        let text = header([0.0, 0.0, -9.81], 2e-6, &format!("overlap_limit = 1.0\n{contact}"), pair)
            + &format!(
                "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [{extent:?}, {extent:?}, 0.0]\nperiodic = [true, true, false]\n"
            )
            + &shape("kind = \"sphere\", radius_m = 0.5e-3")
            + &plane("floor", [0.0, 0.0, -0.5e-3], [0.0, 0.0, 1.0])
            + &format!(
                "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nscale = {{ min = 0.8, max = 1.1 }}\nvelocity_m_per_s = [0.9, 0.7, -0.1]\n\
                 angular_velocity_rad_per_s = [100.0, 0.0, 300.0]\nplacement = {{ method = \"poses\", positions_m = {places:?} }}\n"
            );
        let (report, _) = goes_on_bitwise(what, &text, 300, 300);
        assert!(report.touching_pairs > 50, "{what}: {report:?}");
    }
}

#[test]
fn a_lid_that_presses_with_a_force() {
    let motion = "motion = { kind = \"servo\", direction = [0.0, 0.0, -2.0], force_n = 5.0, gain_m_per_s_per_n = 1e-3, max_velocity_m_per_s = 0.02 }\n";
    let mut flipped = sheet(4, [-0.02, 0.02, -0.02, 0.02], |_| 0.0402);
    flipped.1.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    for lid in [plane("lid", [0.0, 0.0, 0.0402], [0.0, 0.0, -1.0]) + motion, mesh("lid", &flipped, motion)] {
        for geometry in ["kind = \"sphere\", radius_m = 0.005", "kind = \"cube\", edge_m = 0.01"] {
            let pair = "stiffness_n_per_m = 1e5\nrestitution = 0.4\nfriction = 0.3";
            let mut text = header([0.1, 0.0, -9.81], 1e-5, "", pair)
                + &shape(geometry)
                + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
                + &lid;
            for k in 0..4 {
                text += &particle([1e-4 * f64::from(k), 0.0, 0.005 + 0.01 * f64::from(k)], [0.0; 3], [0.0; 3]);
            }
            let (_, snapshot) = goes_on_bitwise("servo", &text, 5000, 300);
            assert!(snapshot.boundaries[1].force_n[2] > 0.1, "the lid must press for the test to mean anything");
        }
    }
}

/// Boxes and rods on a wavy sheet of triangles that shakes, under point laws with history.
#[test]
fn laws_of_points_on_a_shaking_mesh() {
    let wave = sheet(6, [-0.04, 0.04, -0.04, 0.04], |x| 2e-3 * (150.0 * x).sin());
    let motion = "motion = { kind = \"oscillation\", amplitude_m = [1e-3, 0.0, 1e-5], frequency_hz = 10.0 }\n";
    let pair =
        "stiffness_n_per_m = 2e4\nrestitution = 0.2\nfriction = 0.5\nrolling_friction = 0.05\ntwisting_friction = 0.05";
    for geometry in [
        "kind = \"box\", size_m = [0.006, 0.008, 0.01]",
        "kind = \"spherocylinder\", radius_m = 0.003, total_length_m = 0.012",
        "kind = \"cylinder\", radius_m = 0.003, length_m = 0.008",
        "kind = \"sphere\", radius_m = 0.004",
    ] {
        let mut text = header([0.0, 0.0, -9.81], 1e-5, "normal = \"linear\"", pair)
            + &shape(geometry)
            + &mesh("bed", &wave, motion);
        for k in 0..9 {
            let (x, y) = (f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
            text += &particle([0.0135 * x, 0.0135 * y, 0.009 + 1e-4 * f64::from(k)], [0.0; 3], [3.0, 2.0, 1.0]);
        }
        let (report, _) = goes_on_bitwise(geometry, &text, 20_000, 200);
        assert!(report.touching_boundary_pairs > 3, "{geometry}: {report:?}");
    }
}

/// Hertz and Mindlin, whose spring depends on how the overlap changes; local damping, which is booked by halves.
#[test]
fn elastic_balls_with_local_damping() {
    let elastic = "youngs_modulus_pa = 1e6\npoissons_ratio = 0.3\n";
    let mut text = header(
        [0.5, 0.0, -9.81],
        1e-5,
        "normal = \"hertz\"\ntangential = \"mindlin\"",
        "restitution = 0.6\nfriction = 0.4",
    )
    .replace("density_kg_per_m3 = 2500.0", &format!("density_kg_per_m3 = 2500.0\n{elastic}"))
    .replace("name = \"w\"", &format!("name = \"w\"\n{elastic}"))
        + "[integrator]\nlocal_damping = 0.1\n"
        + &shape("kind = \"sphere\", radius_m = 0.005")
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    for k in 0..12 {
        let [x, y, z] = [f64::from(k % 2), f64::from(k / 2 % 2), f64::from(k / 4)];
        text += &particle([0.01 * x + 2e-3 * z, 0.0099 * y, 0.005 + 0.0098 * z], [0.1, 0.0, 0.0], [0.0, 20.0, 0.0]);
    }
    let (report, _) = goes_on_bitwise("Mindlin", &text, 2000, 500);
    assert!(report.touching_pairs > 2 && report.energy.dissipated_local_j > 0.0, "{report:?}");
}

/// Boxes with round edges, of which one pair has many contacts, on a heap of sharp ones and rods.
#[test]
fn rounded_boxes_by_pairs_of_features() {
    let corners: Vec<[f64; 3]> = (0..8)
        .map(|k| [0, 1, 2].map(|axis| [1.6e-3, 1.2e-3, 1e-3][axis] * if k >> axis & 1 == 1 { 1.0 } else { -1.0 }))
        .collect();
    let mut text = header([0.0, 0.2, -9.81], 1e-5, "", "stiffness_n_per_m = 2e3\nrestitution = 0.3\nfriction = 0.5")
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + &shape(&format!("kind = \"rounded_polyhedron\", radius_m = 3e-4, vertices_m = {corners:?}"));
    for k in 0..8 {
        text += &particle([1e-4 * f64::from(k), 0.0, 1.4e-3 + 2.65e-3 * f64::from(k)], [0.0; 3], [0.0, 0.0, 5.0]);
    }
    let (report, _) = goes_on_bitwise("rounded", &text, 6000, 300);
    assert!(report.touching_pairs > 3 && report.contact_points > 20, "{report:?}");
}

/// A checkpoint in the middle of a window meets the end of the window exactly.
#[test]
fn windows_and_motions_that_commands_have_set() {
    let mut run = engine(&drum(20));
    run_for(&mut run, 0.0123);
    let ramp = AngularVelocity::Ramp { rad_per_s: -3.0, duration_s: 0.01 };
    let motion = MotionDescription::Rotation { point_m: [0.0; 3], axis: [0.0, 1.0, 0.0], angular_velocity: ramp };
    run.apply(&Command::SetMotion { boundary: "drum".into(), motion }).unwrap();
    let duration_s = 0.0071;
    let end = run.clock().time_s() + duration_s;
    let n = run.begin_window(duration_s).unwrap();
    steps(&mut run, n / 3);
    let mut other = engine(&drum(20));
    other.restore(&run.checkpoint().unwrap()).unwrap();
    for engine in [&mut run, &mut other] {
        steps(engine, n - n / 3);
        assert_eq!(engine.clock().time_s().to_bits(), end.to_bits());
        engine.end_window();
        run_for(engine, 0.002);
        assert_eq!(engine.clock().time_s().to_bits(), (end + 0.002).to_bits());
    }
    assert_eq!(run.state_hash(), other.state_hash());
    assert_same_snapshot(snapshot(&run), snapshot(&other), "at the end");
}

/// Ids, and with them the random numbers of later insertions, go on where the checkpoint was.
#[test]
fn particles_inserted_after_going_back_are_the_same() {
    let mut run = engine(&drum(12));
    steps(&mut run, 500);
    let mut insertion = run.scene().description().insertions[0].clone();
    let sturz_engine::scene::Placement::Random { count, .. } = &mut insertion.placement else { unreachable!() };
    *count = Some(5);
    run.apply(&Command::Remove(vec![2, 9])).unwrap();
    let saved = run.checkpoint().unwrap();
    let mut other = engine(&drum(12));
    other.restore(&saved).unwrap();
    assert_eq!(other.topology_epoch(), 1);
    for engine in [&mut run, &mut other] {
        engine.apply(&Command::Insert(insertion.clone())).unwrap();
        steps(engine, 300);
    }
    assert_same_snapshot(snapshot(&run), snapshot(&other), "at the end");
    assert_eq!(snapshot(&run).ids, [0, 1, 3, 4, 5, 6, 7, 8, 10, 11, 12, 13, 14, 15, 16]);
}

#[test]
fn an_engine_without_particles() {
    let text = header([0.0; 3], 1e-5, "", "stiffness_n_per_m = 1e3\nrestitution = 0.5");
    let mut run = engine(&text);
    steps(&mut run, 3);
    let mut other = engine(&text);
    other.restore(&run.checkpoint().unwrap()).unwrap();
    assert_same(&run, &other, "empty");
}

/// A ball that has lifted off the wall hangs on by its bond alone: the bond is part of the state.
#[test]
fn bonds_beyond_the_touch() {
    let pair = "restitution = 0.3\nfriction = 0.3\ncohesion = { kind = \"jkr\", work_of_adhesion_j_per_m2 = 0.5 }";
    let balls: String = (0..3)
        .map(|k| {
            particle(
                [0.004 * f64::from(k), 0.0, 0.00099],
                [0.0, 0.0, 0.05 * f64::from(k)],
                [0.0, 3.0 * f64::from(k), 0.0],
            )
        })
        .collect();
    let text = format!(
        "[scene]\nname = \"jkr\"\ngravity_m_per_s2 = [0.0, 0.0, 0.0]\ntime_step_s = 1e-7\n\
         [contact]\nnormal = \"hertz\"\ntangential = \"mindlin\"\ncontact_end = \"tension\"\n\
         [contact.hertz]\nreference_overlap_fraction = 0.05\n\
         [[material]]\nname = \"m\"\ndensity_kg_per_m3 = 2500.0\nyoungs_modulus_pa = 1e7\n[[material]]\nname = \"w\"\n\
         [[material_pair]]\nmaterials = [\"m\", \"m\"]\n{pair}\n[[material_pair]]\nmaterials = [\"m\", \"w\"]\n{pair}\n"
    ) + &shape("kind = \"sphere\", radius_m = 1e-3")
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + &balls;
    let mut engine = engine(&text);
    // some ball is off the floor and still held
    let lifted = |engine: &Engine| {
        let held = engine.report().touching_boundary_pairs;
        held > snapshot(engine).positions.iter().filter(|x| x[2] < 1e-3).count() as u64
    };
    while !lifted(&engine) {
        steps(&mut engine, 10);
        assert!(engine.clock().step() < 100_000, "no ball ever hangs");
    }
    goes_on_bitwise("bonds", &text, engine.clock().step(), 200);
}
