//! Contacts, forces, outputs and events against the real daemon; and a gap among events that a made-up one leaves.

mod common;

use std::thread;
use std::time::{Duration, Instant};

use common::{Daemon, SOON};
use prost::Message as _;
use sturz_client::v1::{self, ContactKind, ErrorCode, EventKind, LeaseChange, WarningKind};
use sturz_client::{
    ClientError, FloatType, Insertion, NO_BOUNDARY, Output, Pace, Placement, Simulation, Stream, Window,
};
use zenoh::Wait;
use zenoh::sample::SourceInfo;

/// N/m, of the daemon's scene.
const STIFFNESS: f64 = 1e4;

/// Two beads of 1 mm at rest, apart by `distance` (m) along x.
fn two_beads(simulation: &Simulation, distance: f64) {
    let poses = Placement::poses(vec![[0.0; 3], [distance, 0.0, 0.0]]);
    simulation.insert(Insertion::new("bead", "glass", poses)).unwrap();
}

fn next_of(events: &mut Stream<v1::Event>, kind: EventKind) -> v1::Event {
    loop {
        let event = events.next_within(SOON).unwrap();
        if event.kind() == kind {
            return event;
        }
    }
}

#[test]
fn two_beads_press_by_stiffness_times_overlap() {
    let daemon = Daemon::start("contacts");
    let simulation = daemon.connect();
    two_beads(&simulation, 1.9e-3);
    let contacts = simulation.contacts(&["all"], FloatType::F64).unwrap();
    assert_eq!((contacts.len(), contacts.is_empty(), contacts.step(), contacts.time_s()), (1, false, 0, 0.0));
    assert_eq!((contacts.ids().unwrap(), contacts.boundaries().unwrap()), (vec![[0, 1]], vec![NO_BOUNDARY]));
    assert_eq!((contacts.parts().unwrap(), contacts.point_counts().unwrap()), (vec![[0, 0]], vec![1]));
    assert_eq!(contacts.kinds().unwrap(), [ContactKind::Smooth]);
    let near = |found: [f64; 3], wanted: [f64; 3], tolerance: f64| {
        assert!(found.iter().zip(wanted).all(|(f, w)| (f - w).abs() <= tolerance), "{found:?} {wanted:?}");
    };
    // 1.9 mm and 2 mm are rounded to 2e-19 m
    near(contacts.points_m().unwrap()[0], [0.95e-3, 0.0, 0.0], 1e-18);
    near(contacts.normals().unwrap()[0], [1.0, 0.0, 0.0], 1e-15);
    assert!((contacts.overlaps_m().unwrap()[0] - 1e-4).abs() < 1e-18);
    let force = contacts.normal_forces_n().unwrap()[0];
    assert!((force - STIFFNESS * 1e-4).abs() < 1e-14, "{force}");
    near(contacts.tangential_forces_n().unwrap()[0], [0.0; 3], 1e-15);
    near(contacts.moments_n_m().unwrap()[0], [0.0; 3], 0.0);

    let state = simulation.state(&["forces", "torques"], FloatType::F64).unwrap();
    near(state.forces_n().unwrap()[0], [-force, 0.0, 0.0], 1e-15);
    near(state.forces_n().unwrap()[1], [force, 0.0, 0.0], 1e-15);
    assert_eq!(state.torques_n_m().unwrap(), [[0.0; 3]; 2]);

    let narrow = simulation.contacts(&["points"], FloatType::F32).unwrap();
    assert!(matches!(narrow.normals(), Err(ClientError::ColumnMissing { .. })));
    assert_eq!(narrow.points_m().unwrap(), [contacts.points_m().unwrap()[0].map(|x| f64::from(x as f32))]);
    let advanced = simulation.advance(Window::new(1e-5).with_contacts()).unwrap();
    assert_eq!(advanced.contacts.unwrap().step(), 1);
    assert!(simulation.advance(Window::new(1e-5)).unwrap().contacts.is_none());
}

#[test]
fn an_output_has_the_columns_and_the_steps_that_were_asked_for() {
    let daemon = Daemon::start("outputs");
    let simulation = daemon.connect();
    two_beads(&simulation, 1.99e-3);
    let output = Output::new("contacts").with_columns(["points"]).with_floats(FloatType::F32).at(Pace::EverySteps(10));
    simulation.define_output(output.clone()).unwrap();
    simulation.define_output(Output { stream: "state".into(), columns: vec!["forces".into()], ..output }).unwrap();
    let told = simulation.info().unwrap().outputs;
    let told = told.iter().find(|output| output.stream == "contacts").unwrap();
    assert_eq!(told.columns, ["ids", "boundaries", "points"]);
    assert_eq!(told.pace, Some(v1::output_definition::Pace::EverySteps(10)));

    let (mut networks, mut states) = (simulation.contact_networks().unwrap(), simulation.states().unwrap());
    // The daemon hears of a subscriber some time after it is one, and gives it the state of then, whatever its step.
    let deadline = Instant::now() + SOON;
    let (mut network, mut state) = (None, None);
    let mut others = [0, 0];
    while network.is_none() || state.is_none() {
        assert!(Instant::now() < deadline, "no frames");
        simulation.step(10).unwrap();
        if let Some(frame) = networks.latest().map(Result::unwrap) {
            others[0] += u32::from(frame.step() % 10 != 0);
            network = Some(frame).filter(|frame| frame.step() % 10 == 0);
        }
        if let Some(frame) = states.latest().map(Result::unwrap) {
            others[1] += u32::from(frame.step() % 10 != 0);
            state = Some(frame).filter(|frame| frame.step() % 10 == 0);
        }
        assert!(others.iter().all(|&count| count <= 1), "{others:?}");
    }
    let (network, state) = (network.unwrap(), state.unwrap());
    assert_eq!((network.frame().columns.len(), state.frame().columns.len()), (3, 2));
    assert_eq!(state.forces_n().unwrap().len(), 2);
    let refused = simulation.define_output(Output::new("contacts").with_columns(["colour"])).unwrap_err();
    let refused = refused.refusal().unwrap();
    assert_eq!((refused.code, refused.path.as_str()), (ErrorCode::NotFound, "output.columns[0]"));
}

#[test]
fn events_carry_what_happened() {
    let daemon = Daemon::start("told");
    let simulation = daemon.connect();
    let mut events = simulation.events().unwrap();
    two_beads(&simulation, 1.85e-3);
    let inserted = next_of(&mut events, EventKind::Particles).inserted.unwrap();
    assert_eq!((inserted.first_id, inserted.count), (0, 2));
    simulation.step(1).unwrap();
    let warning = next_of(&mut events, EventKind::Warning).warning.unwrap();
    assert_eq!((warning.kind(), warning.particle_id), (WarningKind::LargeOverlap, Some(0)));
    simulation.remove([1, 0]).unwrap();
    let removed = next_of(&mut events, EventKind::Particles).removed;
    assert_eq!(removed, [v1::IdRange { first_id: 0, count: 2 }]);
    simulation.acquire_lease().unwrap();
    assert_eq!(next_of(&mut events, EventKind::Lease).lease(), LeaseChange::Acquired);
    let saved = simulation.checkpoint("a").unwrap().checkpoint;
    assert_eq!(next_of(&mut events, EventKind::Checkpoint).checkpoint, Some(saved));
    simulation.set_gravity([0.0; 3]).unwrap();
    loop {
        let outcome = next_of(&mut events, EventKind::Command).outcome.unwrap();
        if outcome.command == "set_gravity" {
            assert_eq!((outcome.step, outcome.repeated), (1, false));
            break;
        }
    }
    assert_eq!(events.counts().missed, 0);
    // the last hundred of a topic are there for who comes late, in order
    for k in 0..120 {
        simulation.set_gravity([0.0, 0.0, f64::from(-k)]).unwrap();
    }
    let mut late = daemon.connect().events().unwrap();
    let seqs: Vec<u64> = (0..100).map(|_| next_of(&mut late, EventKind::Command).header.unwrap().seq).collect();
    assert!(seqs.iter().zip(&seqs[1..]).all(|(a, b)| a + 1 == *b), "{seqs:?}");
}

/// Events 3 to 5 and 8 are never published, nor kept anywhere.
#[test]
fn a_gap_among_events_is_counted() {
    let mut config = zenoh::Config::default();
    for (key, json5) in [
        ("mode", r#""peer""#),
        ("listen/endpoints", r#"["tcp/127.0.0.1:0"]"#),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
    ] {
        config.insert_json5(key, json5).unwrap();
    }
    let session = zenoh::open(config).wait().unwrap();
    let endpoint = session.info().locators().wait()[0].to_string();
    let _alive = session.liveliness().declare_token("sturz/v1/gappy/alive").wait().unwrap();
    let publisher = session.declare_publisher("sturz/v1/gappy/event/run").wait().unwrap();
    let publish = |number: u32| {
        let header = Some(v1::Header { seq: number.into(), ..Default::default() });
        let event = v1::Event { header, kind: EventKind::Paused.into(), ..Default::default() };
        publisher.put(event.encode_to_vec()).source_info(SourceInfo::new(publisher.id(), number)).wait().unwrap();
    };

    let simulation = Simulation::connect("gappy", &endpoint, SOON).unwrap();
    let mut events = simulation.events().unwrap();
    let deadline = Instant::now() + SOON;
    // until the subscription has arrived, nothing does; a number that came before is dropped
    while events.counts().received == 0 {
        assert!(Instant::now() < deadline, "nothing arrives");
        publish(0);
        thread::sleep(Duration::from_millis(5));
    }
    [1, 2, 6, 7, 9].into_iter().for_each(publish);
    let seqs: Vec<u64> = (0..6).map(|_| events.next_within(SOON).unwrap().header.unwrap().seq).collect();
    assert_eq!(seqs, [0, 1, 2, 6, 7, 9]);
    assert_eq!((events.counts().missed, events.counts().lost_on_the_way), (4, 0));
}
