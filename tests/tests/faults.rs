//! The short form of every check of `faults`, as tests.

use sturz_tests::faults::{Size, registry};

fn holds(id: &str) {
    let fault = registry().into_iter().find(|fault| fault.id == id).expect("a check of that id");
    let rows = fault.rows(Size::Short);
    assert!(rows.iter().any(|row| row.is_judged()), "{id} judges nothing");
    let failed: Vec<String> =
        rows.iter().filter(|row| !row.pass).map(|row| format!("{}: {}", row.metric, row.value)).collect();
    assert!(failed.is_empty(), "{id}: {failed:#?}");
}

#[test]
fn a_run_survives_kills() {
    holds("KILL");
}

#[test]
fn damage_is_refused_or_recovered() {
    holds("DAMAGE");
}

#[test]
fn hostile_messages_change_nothing() {
    holds("HOSTILE");
}

#[test]
fn commands_act_once_and_between_two_steps() {
    holds("S22");
}

#[test]
fn listeners_are_not_noticed() {
    holds("CROWD");
}

#[test]
fn windows_over_the_bus_are_those_of_the_engine() {
    holds("LOCKSTEP");
}
