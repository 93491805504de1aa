//! Saved states and the log.

use std::fs;
use std::path::Path;
use std::time::Duration;

use anyhow::Context as _;
use prost::bytes::Bytes;
use sturz_client::{FloatType, Insertion, Output, Pace, Placement, Window};
use sturz_engine::CheckpointError;
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_service::journal::log::{Next, Segment, SegmentReader};
use sturz_service::journal::order_of;
use sturz_service::journal::record::Entry;
use sturz_service::journal::snapshot::Snapshot;
use xxhash_rust::xxh3::xxh3_64;

use crate::decoders::world::{SCENE, engine_under_way, new_engine_of, with_engine, with_runner};
use crate::faults::daemon::{Daemon, Folder};

/// Where the state hash of a checkpoint is.
const STATE_HASH: std::ops::Range<usize> = 64..72;

/// Restores it as it is, with a fitting checksum, and with the state hash of what it holds.
pub fn read_checkpoint(bytes: &[u8]) {
    with_engine(|engine| {
        let before = engine.state_hash();
        if engine.restore(bytes).is_err() {
            assert_eq!(engine.state_hash(), before, "a refused checkpoint has changed the engine");
            let Some(mut forged) = forged_checkpoint(bytes) else { return };
            let mut restored = engine.restore(&forged);
            if let Err(CheckpointError::OtherState { found, .. }) = restored {
                forged[STATE_HASH].copy_from_slice(&found.to_le_bytes());
                forged = forged_checkpoint(&forged).unwrap_or_default();
                restored = engine.restore(&forged);
            }
            if restored.is_err() {
                assert_eq!(engine.state_hash(), before, "a refused checkpoint has changed the engine");
                return;
            }
        }
        for _ in 0..2 {
            // A forged state may end the run with a reason; it must be one.
            drop(engine.step());
        }
    });
}

/// With a length and a checksum that fit.
fn forged_checkpoint(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut forged = bytes.to_vec();
    let end = forged.len().checked_sub(8).filter(|&end| end >= STATE_HASH.end)?;
    let length = (forged.len() as u64).to_le_bytes();
    forged[12..20].copy_from_slice(&length);
    let checksum = xxh3_64(&forged[..end]).to_le_bytes();
    forged[end..].copy_from_slice(&checksum);
    Some(forged)
}

/// Of an engine with all that a checkpoint may hold.
pub fn checkpoints() -> anyhow::Result<Vec<Vec<u8>>> {
    let mut engine = engine_under_way()?;
    let within = engine.checkpoint()?;
    engine.end_window();
    Ok(vec![within, engine.checkpoint()?])
}

/// Starts another scene with it, as it is and with a fitting checksum, and does two steps.
pub fn read_bed(bytes: &[u8]) {
    for bytes in [Some(bytes.to_vec()), forged_checkpoint(bytes)].into_iter().flatten() {
        let text = format!("{SCENE}\n[start]\ncheckpoint = \"bed\"\n");
        let Ok(mut description) = SceneDescription::from_toml(&text) else { panic!("the world is no scene") };
        description.insertions.clear();
        if description.read_files(|_| Ok(bytes.clone())).is_ok()
            && let Ok(scene) = Scene::validate(description)
        {
            let mut engine = new_engine_of(scene);
            for _ in 0..2 {
                drop(engine.step());
            }
        }
    }
}

/// What `sturz prepare` writes.
pub fn beds() -> anyhow::Result<Vec<Vec<u8>>> {
    let mut engine = engine_under_way()?;
    engine.end_window();
    Ok(vec![engine.prepared()?])
}

/// Reads it as it is, and with fitting checksums; then the orders of its records.
pub fn read_log(bytes: &[u8]) {
    let first = bytes.get(12..20).map_or(0, |number| u64::from_le_bytes(std::array::from_fn(|k| number[k])));
    let segment = Segment { path: "fuzz.log".into(), first };
    for bytes in [bytes.to_vec(), forged_log(bytes)] {
        let Ok(mut reader) = SegmentReader::of(&segment, bytes) else { continue };
        while let Ok(Next::Record(record)) = reader.next_record() {
            if let Some(Entry::Command(accepted)) = &record.entry {
                drop(order_of(accepted));
            }
        }
    }
}

/// With checksums that fit, of the head and of all records whose length fits.
fn forged_log(bytes: &[u8]) -> Vec<u8> {
    const HEAD_BYTES: usize = 28;
    const FRAME_BYTES: usize = 16;
    let mut forged = bytes.to_vec();
    if forged.len() < HEAD_BYTES {
        return forged;
    }
    let checksum = xxh3_64(&forged[..20]).to_le_bytes();
    forged[20..28].copy_from_slice(&checksum);
    let mut at = HEAD_BYTES;
    while let Some(head) = forged.get(at..at + FRAME_BYTES) {
        let length = u32::from_le_bytes(std::array::from_fn(|k| head[k])) as usize;
        let content = at + FRAME_BYTES;
        let Some(of_content) = forged.get(content..content + length).map(xxh3_64) else { break };
        forged[at + 4..at + 12].copy_from_slice(&of_content.to_le_bytes());
        let of_head = xxh3_64(&forged[at..at + 12]) as u32;
        forged[at + 12..at + 16].copy_from_slice(&of_head.to_le_bytes());
        at = content + length;
    }
    forged
}

/// Loads it as it is, and with checksums that fit.
pub fn read_snapshot(bytes: &[u8]) {
    for bytes in [Some(bytes.to_vec()), forged_snapshot(bytes)].into_iter().flatten() {
        let Ok(snapshot) = Snapshot::from_bytes(&bytes.into()) else { continue };
        let engines = [Some(snapshot.engine.clone()), forged_checkpoint(&snapshot.engine).map(Bytes::from)];
        for engine in engines.into_iter().flatten() {
            let snapshot = Snapshot { engine, ..snapshot.clone() };
            with_runner(|runner| {
                if runner.load_snapshot(snapshot, |_, _| {}).is_ok() {
                    runner.step();
                }
            });
        }
    }
}

/// With a checksum that fits.
fn forged_snapshot(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut forged = bytes.to_vec();
    let end = forged.len().checked_sub(8)?;
    let checksum = xxh3_64(&forged[..end]).to_le_bytes();
    forged[end..].copy_from_slice(&checksum);
    Some(forged)
}

/// Of a real daemon.
pub fn logs() -> anyhow::Result<Vec<Vec<u8>>> {
    files("log", "logs")
}

/// Of a real daemon: the last ones, with a window under way in one.
pub fn snapshots() -> anyhow::Result<Vec<Vec<u8>>> {
    files("snapshots", "snapshots")
}

/// A folder of the journal of a short run.
fn files(folder: &str, name: &str) -> anyhow::Result<Vec<Vec<u8>>> {
    let here = Folder::new(&format!("decoders-{name}"))?;
    let scene = here.join("scene.toml");
    fs::write(&scene, SCENE)?;
    let journal = here.join("journal");
    let daemon = Daemon::serve([&*scene, "--paused", "--journal", &journal, "--checkpoint-every", "0.05"])?;
    let simulation = daemon.connect()?;
    let field = sturz_client::FieldDefinition {
        name: "velocity".into(),
        min_m: [-0.02; 3],
        max_m: [0.02; 3],
        cells: [2, 2, 2],
        quantities: vec![sturz_client::v1::FieldQuantity::Velocity],
        width_m: 4e-3,
        ..Default::default()
    };
    simulation.acquire_lease()?;
    simulation.define_field(field)?;
    simulation.define_output(Output::new("state").with_columns(["positions"]).at(Pace::EverySteps(100)))?;
    simulation.insert(Insertion::new("bead", "glass", Placement::poses(vec![[0.0, 0.01, 0.0]])))?;
    simulation.checkpoint("a")?;
    simulation.checkpoint_on_disk("b")?;
    simulation.advance(Window::new(2e-4).with_columns(["positions"]))?;
    simulation.restore("a")?;
    simulation.remove([0])?;
    let _waits = simulation.later(1e3).set_gravity([0.0, 0.0, -9.0])?;
    let snapshots = Path::new(&journal).join("snapshots");
    let newest = || -> anyhow::Result<u64> {
        let mut newest = 0;
        for entry in fs::read_dir(&snapshots)? {
            let name = entry?.path().file_stem().unwrap_or_default().to_string_lossy().into_owned();
            newest = newest.max(name.parse().unwrap_or(0));
        }
        Ok(newest)
    };
    // The next snapshot is in the midst of this window.
    let before = newest()?;
    std::thread::scope(|scope| -> anyhow::Result<()> {
        let window = scope.spawn(|| simulation.step(u64::MAX >> 20));
        let begin = std::time::Instant::now();
        while newest()? == before && begin.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(10));
        }
        simulation.pause()?;
        drop(window.join());
        Ok(())
    })?;
    simulation.state(&["all"], FloatType::F64)?;
    simulation.stop()?;
    let mut found = Vec::new();
    for entry in fs::read_dir(Path::new(&journal).join(folder))? {
        found.push(fs::read(entry?.path())?);
    }
    found.sort_by_key(Vec::len);
    found.first().with_context(|| format!("the run has left no {folder}"))?;
    Ok(found)
}
