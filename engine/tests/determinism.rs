//! Equal state hash on any number of threads, with caches dropped at random steps, across images and removals.

mod common;

use common::{drum, engine, steps};
use sturz_engine::{Command, Effect};

/// Runs the drum and returns the hash after each stretch.
fn hashes(threads: usize, drop_caches_every: u64) -> Vec<u64> {
    let mut engine = engine(&drum(90));
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
