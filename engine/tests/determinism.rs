//! Equal state hash on any number of threads, with caches dropped at random steps, across images and removals.

mod common;

use common::{drum, engine, header, shape, steps};
use sturz_engine::{Command, Effect};

/// Runs the drum under the linear law and returns the hash after each stretch; tests/generalized_overlap.rs has the
/// default one.
fn hashes(threads: usize, drop_caches_every: u64) -> Vec<u64> {
    let mut engine = engine(&drum(90).replacen("[domain]", "[contact]\nnormal = \"linear\"\n[domain]", 1));
    engine.set_threads(threads);
    let mut hashes = Vec::new();
    for stretch in 0..6 {
        for k in 0..1500 {
            if drop_caches_every > 0 && (stretch * 1500 + k) % drop_caches_every == 0 {
                engine.drop_caches();
            }
            steps(&mut engine, 1);
        }
        if stretch == 3 {
            assert_eq!(engine.apply(&Command::Remove(vec![7, 11])).unwrap(), Effect::Removed { count: 2 });
        }
        hashes.push(engine.state_hash());
    }
    let report = engine.report();
    assert!(report.contact_points > 20, "{report:?}");
    assert!(report.energy.dissipated_friction_j > 0.0);
    hashes
}

#[test]
fn threads_and_caches_are_invisible_in_the_bits() {
    let reference = hashes(1, 0);
    assert_eq!(hashes(2, 0), reference);
    assert_eq!(hashes(4, 0), reference);
    assert_eq!(hashes(2, 37), reference);
    assert_eq!(hashes(1, 1), reference);
}

/// A periodic lattice of spheres of many sizes, pressed together, and one six times as large on top: enough for every
/// stage to be shared among threads.
fn spheres() -> String {
    let side = 15;
    let places: Vec<[f64; 3]> = (0..14)
        .flat_map(|z| (0..side).flat_map(move |y| (0..side).map(move |x| [x, y, z].map(|k| f64::from(k) * 0.98e-3))))
        .collect();
    let extent = f64::from(side) * 0.98e-3;
    let pair = "stiffness_n_per_m = 2e2\nrestitution = 0.7\nfriction = 0.4";
    let insertion = |shape: &str, scale: &str, places: &[[f64; 3]]| {
        format!(
            "[[insertion]]\nshape = \"{shape}\"\nmaterial = \"m\"\nscale = {scale}\n\
             velocity_m_per_s = [0.3, 0.2, -0.1]\nplacement = {{ method = \"poses\", positions_m = {places:?} }}\n"
        )
    };
    header([0.0, 0.0, -9.81], 2e-6, "overlap_limit = 1.0", pair)
        + &format!(
            "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [{extent:?}, {extent:?}, 0.0]\nperiodic = [true, true, false]\n"
        )
        + &shape("kind = \"sphere\", radius_m = 0.5e-3")
        + &insertion("s", "{ min = 0.7, max = 1.1 }", &places)
        + &insertion("s", "{ min = 6.0, max = 6.0 }", &[[0.0, 0.0, 13.0 * 0.98e-3 + 3.4e-3]])
}

fn sphere_hashes(threads: usize, drop_caches_every: u64) -> Vec<u64> {
    let mut engine = engine(&spheres());
    engine.set_threads(threads);
    let mut hashes = Vec::new();
    for k in 0..240 {
        if drop_caches_every > 0 && k % drop_caches_every == 0 {
            engine.drop_caches();
        }
        steps(&mut engine, 1);
        if k == 120 {
            assert_eq!(engine.apply(&Command::Remove(vec![7, 1011])).unwrap(), Effect::Removed { count: 2 });
        }
        if k % 40 == 39 {
            hashes.push(engine.state_hash());
        }
    }
    let report = engine.report();
    assert!(report.touching_pairs > 500 && report.energy.dissipated_friction_j > 0.0, "{report:?}");
    hashes
}

#[test]
fn threads_and_rebuilds_are_invisible_in_the_bits_of_spheres() {
    let reference = sphere_hashes(1, 0);
    assert_eq!(sphere_hashes(2, 0), reference);
    assert_eq!(sphere_hashes(4, 17), reference);
    assert_eq!(sphere_hashes(1, 1), reference);
}

/// Images were kept where they were when the list was made, unless two spheres met by the sphere batch.
#[test]
fn images_of_spheres_under_laws_of_points_move_with_them() {
    let places: Vec<[f64; 3]> =
        (0..36).map(|k| [f64::from(k % 6), f64::from(k / 6), 0.5].map(|x| x * 0.98e-3)).collect();
    let extent = 6.0 * 0.98e-3;
    let laws = [
        ("", "stiffness_n_per_m = 2e2\nrestitution = 0.7\nfriction = 0.4\nrolling_friction = 0.1"),
        (
            "tangential = \"viscous\"",
            "stiffness_n_per_m = 2e2\nrestitution = 0.7\nfriction = 0.4\ntangential_damping_n_s_per_m = 1e-3",
        ),
    ];
    for (contact, pair) in laws {
        let text = header([0.0, 0.0, -9.81], 2e-6, &format!("overlap_limit = 1.0\n{contact}"), pair)
            + &format!(
                "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [{extent:?}, {extent:?}, 0.0]\nperiodic = [true, true, false]\n"
            )
            + &shape("kind = \"sphere\", radius_m = 0.5e-3")
            + &format!(
                "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nscale = {{ min = 0.8, max = 1.1 }}\nvelocity_m_per_s = [0.9, 0.7, -0.1]\n\
                 placement = {{ method = \"poses\", positions_m = {places:?} }}\n"
            );
        let (mut lazy, mut eager) = (engine(&text), engine(&text));
        for _ in 0..200 {
            eager.expire_neighbours();
            steps(&mut lazy, 1);
            steps(&mut eager, 1);
            assert_eq!(lazy.state_hash(), eager.state_hash(), "{contact} {pair}");
        }
        assert!(lazy.report().energy.dissipated_friction_j > 0.0);
        assert!(lazy.report().neighbour_rebuilds < eager.report().neighbour_rebuilds / 2);
    }
}

/// A refused command leaves no trace.
#[test]
fn refused_commands_change_nothing() {
    let mut engine = engine(&drum(10));
    steps(&mut engine, 100);
    let before = engine.state_hash();
    let insertion = engine.scene().description().insertions[0].clone();
    let refused = [
        Command::Remove(vec![3, 99]),
        Command::SetGravity([0.0, f64::NAN, 0.0]),
        Command::SetMotion { boundary: "lid".into(), motion: Default::default() },
        Command::Insert(sturz_engine::scene::InsertionDescription { shape: "x".into(), ..insertion }),
    ];
    for command in refused {
        let error = engine.apply(&command).unwrap_err();
        assert!(!error.path.is_empty());
        assert_eq!(engine.state_hash(), before, "{error}");
    }
}
