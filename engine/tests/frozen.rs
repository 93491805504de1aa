//! Frozen particles: in the state and in contacts, and moved by nothing.

mod common;

use common::{engine, header, plane, shape, steps};
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Command, Engine, LoadDescription, Snapshot};

const PAIR: &str = "stiffness_n_per_m = 1e4\nrestitution = 0.6\nfriction = 0.4";
const SPHERE: &str = r#"kind = "sphere", radius_m = 5e-3"#;
const CUBE: &str = r#"kind = "box", size_m = [0.01, 0.01, 0.01]"#;

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    engine.snapshot_forces(&mut snapshot);
    snapshot
}

fn frozen(positions: &[[f64; 3]], velocity: [f64; 3]) -> String {
    format!(
        "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nfrozen = true\nvelocity_m_per_s = {velocity:?}\nplacement = {{ method = \"poses\", positions_m = {positions:?} }}\n"
    )
}

fn free(position: [f64; 3], velocity: [f64; 3]) -> String {
    common::particle(position, velocity, [0.0; 3])
}

/// A periodic base of frozen particles and a few layers that rain on it.
fn bed(geometry: &str, contact: &str, velocity: [f64; 3]) -> String {
    let mut text = header([0.0, 0.0, -9.81], 1e-5, contact, PAIR);
    text += "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [0.06, 0.06, 0.0]\nperiodic = [true, true, false]\n";
    text += &shape(geometry);
    // cubes of the base overlap with their neighbours, which nobody looks for
    text += &format!(
        "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nfrozen = true\nvelocity_m_per_s = {velocity:?}\n[insertion.placement]\nmethod = \"lattice\"\norigin_m = [0.0, 0.0, 0.0]\nspacing_m = [0.0075, 0.0075, 0.0]\ncounts = [8, 8, 1]\nrandom_orientation = true\n"
    );
    text += "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\n[insertion.placement]\nmethod = \"lattice\"\norigin_m = [0.006, 0.006, 0.02]\nspacing_m = [0.02, 0.02, 0.018]\ncounts = [3, 3, 3]\nrandom_orientation = true\n";
    text
}

/// A central hit on a frozen sphere is one on a wall: the same stiffness, and the damping of an infinite partner.
#[test]
fn central_hit_is_that_on_a_plane() {
    for contact in ["", "damping_mass = \"contact\"", "normal = \"linear\""] {
        let head = header([0.0; 3], 2e-6, contact, PAIR) + &shape(SPHERE);
        let mut on_plane = engine(
            &(head.clone() + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]) + &free([0.0, 0.0, 5.1e-3], [0.0, 0.0, -0.3])),
        );
        let mut on_frozen =
            engine(&(head + &frozen(&[[0.0, 0.0, -5e-3]], [0.0; 3]) + &free([0.0, 0.0, 5.1e-3], [0.0, 0.0, -0.3])));
        steps(&mut on_plane, 2000);
        steps(&mut on_frozen, 2000);
        let [plane, frozen] = [&on_plane, &on_frozen].map(|engine| snapshot(engine).velocities.last().unwrap()[2]);
        // the positions round differently
        assert!((plane / frozen - 1.0).abs() < 1e-9, "{contact}: {plane} {frozen}");
        assert!((frozen / 0.3 - 0.6).abs() < 1e-3, "{contact}: {frozen}");
        let [plane, frozen] = [&on_plane, &on_frozen].map(|engine| engine.report().energy);
        assert!(
            (plane.residual_j - frozen.residual_j).abs() < 1e-9 * frozen.dissipated_normal_j,
            "{plane:?} {frozen:?}"
        );
        assert_eq!(frozen.work_boundaries_j, 0.0);
    }
}

/// In the frame of a frozen sphere that moves, the hit is the same; its work is booked as that of a boundary.
#[test]
fn moving_set_does_the_work_of_a_boundary() {
    let (speed, piston) = (0.3, 0.2);
    let text = header([0.0; 3], 2e-6, "", PAIR)
        + &shape(SPHERE)
        + &frozen(&[[0.0, 0.0, -5e-3]], [0.0, 0.0, piston])
        + &free([0.0, 0.0, 5.1e-3], [0.0, 0.0, -speed]);
    let mut engine = engine(&text);
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 5e-3f64.powi(3);
    steps(&mut engine, 2000);
    let after = snapshot(&engine);
    let expected = piston + 0.6 * (speed + piston);
    assert!((after.velocities[1][2] / expected - 1.0).abs() < 1e-3);
    assert_eq!(after.velocities[0], [0.0, 0.0, piston]);
    assert!((after.positions[0][2] - (-5e-3 + piston * engine.clock().time_s())).abs() < 1e-15);
    let energy = engine.report().energy;
    // impulse times the speed of the set; the trapezoidal rule and the sudden end of the contact: 1e-3
    let work = mass * (after.velocities[1][2] + speed) * piston;
    assert!((energy.work_boundaries_j / work - 1.0).abs() < 1e-3, "{} {work}", energy.work_boundaries_j);
    assert!(energy.residual_j.abs() < 1e-3 * work);
    assert!((engine.report().momentum_kg_m_per_s[2] / (mass * after.velocities[1][2]) - 1.0).abs() < 1e-14);
}

#[test]
fn base_bears_the_weight_and_stays() {
    for (geometry, contact) in [(SPHERE, ""), (CUBE, ""), (CUBE, "normal = \"linear\"")] {
        let mut engine = engine(&bed(geometry, contact, [0.0; 3]));
        let before = snapshot(&engine);
        assert_eq!(engine.report().touching_pairs, 0, "{geometry}: the base does not meet itself");
        let mut smallest = f64::INFINITY;
        for _ in 0..60 {
            steps(&mut engine, 2000);
            let energy = engine.report().energy;
            smallest = energy.kinetic_translation_j + energy.kinetic_rotation_j;
            if smallest < 1e-9 {
                break;
            }
        }
        assert!(smallest < 1e-7, "{geometry} {contact}: {smallest}");
        let after = snapshot(&engine);
        assert_eq!(after.frozen.iter().sum::<u32>(), 64);
        assert_eq!(before.positions[..64], after.positions[..64], "{geometry} {contact}");
        assert_eq!(before.orientations[..64], after.orientations[..64]);
        assert!(after.velocities[..64].iter().all(|v| *v == [0.0; 3]));
        let report = engine.report();
        assert!(report.touching_pairs > 0);
        let (volume, n) = (if geometry == SPHERE { 4.0 / 3.0 * std::f64::consts::PI * 1.25e-7 } else { 1e-6 }, 27.0);
        let weight = 2500.0 * volume * n * 9.81;
        let borne: f64 = after.forces[..64].iter().map(|force| force[2]).sum();
        // what still shakes: 1 %
        assert!((borne / -weight - 1.0).abs() < 0.01, "{geometry} {contact}: {borne} of {weight}");
        let energy = report.energy;
        let lost = energy.dissipated_normal_j + energy.dissipated_friction_j;
        assert!(energy.residual_j.abs() < 0.01 * lost, "{geometry} {contact}: {} of {lost}", energy.residual_j);
        assert!(report.internal_force_residual_n < 1e-9 * weight);
    }
}

/// Removal, a checkpoint and other thread counts leave the bits alone, at rest and in motion.
#[test]
fn bits_are_those_of_any_run() {
    for velocity in [[0.0; 3], [0.05, 0.0, 0.0]] {
        let text = bed(CUBE, "", velocity);
        let mut run = engine(&text);
        run.apply(&Command::Remove(vec![5, 70])).unwrap();
        steps(&mut run, 6000);
        let saved = run.checkpoint().unwrap();
        let mut other = engine(&text);
        other.set_threads(3);
        other.restore(&saved).unwrap();
        assert_eq!(other.state_hash(), run.state_hash());
        assert_eq!(other.checkpoint().unwrap(), saved);
        assert_eq!(snapshot(&other).frozen, snapshot(&run).frozen);
        assert!(run.report().contact_points > 0);
        steps(&mut run, 300);
        steps(&mut other, 300);
        assert_eq!(other.state_hash(), run.state_hash());
        let (a, b) = (run.report().energy, other.report().energy);
        assert!((a.work_boundaries_j - b.work_boundaries_j).abs() <= 1e-12 * a.work_boundaries_j.abs());
        assert_eq!(velocity == [0.0; 3], a.work_boundaries_j == 0.0);
    }
}

/// Nothing that pushes a particle moves a frozen one: weight, loads, local damping, [relax].
#[test]
fn nothing_moves_them() {
    let damped = bed(SPHERE, "", [0.0; 3]) + "[integrator]\nlocal_damping = 0.5\n";
    let overlapping =
        damped.replace("origin_m = [0.006, 0.006, 0.02]", "origin_m = [0.006, 0.006, 0.008]") + "[relax]\n";
    let mut engine = engine(&overlapping);
    let start = snapshot(&engine);
    assert!(start.positions[0] == [0.0; 3] && start.positions[63][..2] == [0.0525; 2], "{:?}", &start.positions[..64]);
    let loads = LoadDescription {
        topology_epoch: engine.topology_epoch(),
        ids: (0..91).collect(),
        force_n: vec![[1e-3, 0.0, 0.0]; 91],
        ..LoadDescription::default()
    };
    engine.apply(&Command::SetLoads(loads)).unwrap();
    steps(&mut engine, 3000);
    let after = snapshot(&engine);
    assert_eq!(start.positions[..64], after.positions[..64]);
    assert!(after.positions[64..].iter().zip(&start.positions[64..]).all(|(a, b)| a[0] != b[0]));
}

/// Frozen particles that are removed leave no trace of the column, and the others their bits.
#[test]
fn scene_without_them_is_as_it_was() {
    let text = bed(SPHERE, "", [0.0; 3]);
    let mut with = engine(&text);
    with.apply(&Command::Remove((0..64).collect())).unwrap();
    assert!(snapshot(&with).frozen.is_empty());
    let never = text.replace("frozen = true\n", "");
    let mut without = engine(&never);
    without.apply(&Command::Remove((0..64).collect())).unwrap();
    steps(&mut with, 500);
    steps(&mut without, 500);
    assert_eq!(with.state_hash(), without.state_hash());
    assert_eq!(with.checkpoint().unwrap().len(), without.checkpoint().unwrap().len());
}

#[test]
fn turning_is_refused() {
    let text = bed(SPHERE, "", [0.0; 3]).replacen(
        "frozen = true\n",
        "frozen = true\nangular_velocity_rad_per_s = [0.0, 1.0, 0.0]\n",
        1,
    );
    let error = Scene::validate(SceneDescription::from_toml(&text).unwrap()).unwrap_err();
    assert_eq!(error.0[0].path, "insertion[0].angular_velocity_rad_per_s");
}
