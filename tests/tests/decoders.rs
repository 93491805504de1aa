//! Everything that reads bytes from outside, fed with sound inputs and with changed ones. `make fuzz` does it for longer, and
//! is guided by what the code does with them.

use std::time::Duration;

use peak_alloc::PeakAlloc;
use sturz_client::{Insertion, Placement};
use sturz_protocol::Request;
use sturz_protocol::keys::Verb;
use sturz_tests::decoders::{self, mutate, registry};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Memory for one input of 64 kB at most and what it may ask for under the limits of the tests.
const MOST_BYTES: usize = 512 << 20;

#[test]
fn decoders_survive_changed_inputs_in_bounded_memory() {
    for target in registry() {
        MEMORY.reset_peak_usage();
        let before = MEMORY.current_usage();
        let tried = mutate(&target, 1, 4_000, Duration::from_secs(3)).unwrap_or_else(|problem| panic!("{problem:#}"));
        let grown = MEMORY.peak_usage().saturating_sub(before);
        assert!(tried.seeds > 0 && tried.changed > 0, "{}: {tried:?}", target.name);
        assert!(grown < MOST_BYTES, "{}: {} MiB for one input", target.name, grown >> 20);
        println!("{}: {tried:?}, {} MiB", target.name, grown >> 20);
    }
}

/// Found by the target `request`: the grid had no cells for them.
#[test]
fn particles_farther_apart_than_there_are_numbers_do_not_end_the_daemon() {
    let places = vec![[1.7e308, 0.0, 0.0], [-1.7e308, 0.0, 0.0], [0.0, 0.01, 1.7e308]];
    let request = Request::Insert(Insertion::new("bead", "glass", Placement::poses(places)).into());
    let number = Verb::ALL.iter().position(|&verb| verb == Verb::Insert).expect("a verb");
    decoders::read("request", &[vec![number as u8], request.encode()].concat());
}
