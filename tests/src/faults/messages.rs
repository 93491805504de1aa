//! Messages that cannot be used, on every key: each is answered or ignored as documented, and the state stays as it is.

use anyhow::{Context as _, anyhow, ensure};
use prost::Message as _;
use sturz_client::v1::{self, outcome::Result as Wire};
use sturz_protocol::Request;
use sturz_protocol::keys::{Keys, Verb};
use zenoh::{Session, Wait as _};

use crate::cases::Checks;
use crate::faults::Size;
use crate::faults::chance::Chance;
use crate::faults::daemon::{Daemon, Folder, SOON};
use crate::faults::script::HEAP;

/// Queries that wait for their replies at a time; the daemon takes that many.
const AT_A_TIME: usize = 128;
/// The largest request that the daemon takes here.
const MESSAGE_BYTES: usize = 100_000;
/// Memory that a flood may cost, whatever its length.
const MEMORY_BYTES: u64 = 256 << 20;

/// What came back.
#[derive(Default)]
struct Answers {
    sent: u64,
    /// Outcomes and errors that say no.
    refused: u64,
    /// Of those that are sound: duplicates, pauses of a paused run, lists.
    done: u64,
    /// Queries without a reply.
    unanswered: u64,
    /// Replies that are no message.
    unreadable: u64,
}

/// Sends them in rounds; in between, the daemon must still answer.
pub fn check(checks: &mut Checks, size: Size) -> anyhow::Result<()> {
    let folder = Folder::new("messages")?;
    let (scene, limits) = (folder.join("scene.toml"), folder.join("limits.toml"));
    std::fs::write(&scene, HEAP)?;
    std::fs::write(&limits, format!("message_bytes = {MESSAGE_BYTES}\nfields = 8\n"))?;
    let journal = folder.join("journal");
    let daemon =
        Daemon::serve([&*scene, "--name", "messages", "--paused", "--limits", &limits, "--journal", &journal])?;
    let simulation = daemon.connect()?;
    // Who holds the lease may let time go on: nobody here.
    simulation.acquire_lease()?;
    let before = simulation.info()?;
    let memory_before = daemon.peak_bytes()?;
    let session = session(&daemon.endpoint)?;
    let keys = Keys::new(&daemon.instance)?;

    let mut chance = Chance::new(3);
    let mut answers = Answers::default();
    let wanted = u64::from(size.of(3_000, 100_000));
    while answers.sent < wanted {
        round(&session, &keys, &mut chance, &mut answers)?;
    }
    let after = simulation.info().context("the daemon still answers")?;
    checks.shows("messages", answers.sent as f64, "-");
    checks.shows("of these refused with a reason", answers.refused as f64, "-");
    checks.shows("of these done, and harmless", answers.done as f64, "-");
    checks.near("queries without any reply", answers.unanswered as f64, 0.0, 0.0, "-");
    checks.near("replies that cannot be read", answers.unreadable as f64, 0.0, 0.0, "-");
    checks.holds("the state hash is the same", after.state_hash == before.state_hash && after.step == before.step);
    let grown = daemon.peak_bytes()?.saturating_sub(memory_before);
    checks.near("growth of the daemon's memory", grown as f64, 0.0, MEMORY_BYTES as f64, "byte");
    simulation.step(1).context("the daemon still steps")?;
    Ok(())
}

fn session(endpoint: &str) -> anyhow::Result<Session> {
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"client\"".into()),
        ("connect/endpoints", format!("[{endpoint:?}]")),
        ("scouting/multicast/enabled", "false".into()),
    ] {
        config.insert_json5(key, &value).map_err(|error| anyhow!("{key}: {error}"))?;
    }
    zenoh::open(config).wait().map_err(|error| anyhow!("{error}"))
}

/// Some messages, answered before the next ones are sent.
fn round(session: &Session, keys: &Keys, chance: &mut Chance, answers: &mut Answers) -> anyhow::Result<()> {
    let mut waiting = Vec::new();
    for _ in 0..AT_A_TIME {
        let (key, payload) = message(keys, chance);
        answers.sent += 1;
        // A put has no reply: where it is a command, its outcome is an event.
        if chance.below(5) == 0 {
            let key = key.split('?').next().unwrap_or_default();
            session.put(key, payload).wait().map_err(|error| anyhow!("{key}: {error}"))?;
            continue;
        }
        let replies = session.get(&key).payload(payload).timeout(SOON).wait();
        waiting.push((key, replies.map_err(|error| anyhow!("{error}"))?));
    }
    for (key, replies) in waiting {
        let mut count = 0;
        // The channel closes behind the last reply.
        while let Ok(reply) = replies.recv() {
            count += 1;
            count_reply(&key, reply, answers);
        }
        ensure!(count <= 1, "{count} replies at {key}");
        answers.unanswered += u64::from(count == 0);
    }
    Ok(())
}

fn count_reply(key: &str, reply: zenoh::query::Reply, answers: &mut Answers) {
    match reply.into_result() {
        Ok(sample) if key.contains("/cmd/") => match v1::Outcome::decode(&*sample.payload().to_bytes()) {
            Ok(v1::Outcome { result: Some(Wire::Error(error)), .. }) if error.code() != v1::ErrorCode::Unspecified => {
                answers.refused += 1;
            }
            Ok(v1::Outcome { result: Some(_), .. }) => answers.done += 1,
            other => answers.unreadable(key, &format!("{other:?}")),
        },
        Ok(_) => answers.done += 1,
        Err(error) => match v1::Error::decode(&*error.payload().to_bytes()) {
            Ok(error) if !error.message.is_empty() => answers.refused += 1,
            _ => answers.unreadable(key, &String::from_utf8_lossy(&error.payload().to_bytes())),
        },
    }
}

impl Answers {
    fn unreadable(&mut self, key: &str, what: &str) {
        self.unreadable += 1;
        eprintln!("{key}: {what}");
    }
}

/// One that cannot change the state, if the daemon is right.
fn message(keys: &Keys, chance: &mut Chance) -> (String, Vec<u8>) {
    if chance.below(8) == 0 {
        return question(keys, chance);
    }
    let verb = Verb::ALL[chance.below(Verb::ALL.len() as u64) as usize];
    let mut key = keys.command(verb);
    loop {
        let mut payload = match chance.below(6) {
            0 => noise(chance),
            1 => vec![chance.bits() as u8; MESSAGE_BYTES + 1 + chance.below(1000) as usize],
            _ => request(verb, chance).encode(),
        };
        match chance.below(4) {
            0 => payload.truncate(chance.below(payload.len() as u64 + 1) as usize),
            1 | 2 if !payload.is_empty() => {
                let at = chance.below(payload.len() as u64) as usize;
                payload[at] ^= 1 << chance.below(8);
            }
            _ => {}
        }
        if chance.below(40) == 0 {
            key += "_all";
        }
        if is_harmless(verb, &payload) {
            return (key, payload);
        }
    }
}

fn question(keys: &Keys, chance: &mut Chance) -> (String, Vec<u8>) {
    let key = match chance.below(9) {
        0 => keys.info(),
        1 => keys.features(),
        2 => keys.plan(),
        3 => keys.report_latest(),
        4 => format!("{}?columns=colour|positions", keys.state_latest()),
        5 => format!("{}?float=f{}", keys.state_latest(), chance.below(70)),
        6 => keys.shapes(chance.below(5)),
        7 => keys.shapes_latest(),
        _ => keys.field_latest(&format!("no-such-{}", chance.below(9))),
    };
    (key, noise(chance))
}

fn noise(chance: &mut Chance) -> Vec<u8> {
    (0..chance.below(200)).map(|_| chance.bits() as u8).collect()
}

/// Out of range, out of order, or sound and harmless; some with an id that others have.
fn request(verb: Verb, chance: &mut Chance) -> Request {
    let strange =
        |chance: &mut Chance| [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e308, -0.0, 5e-324][chance.below(7) as usize];
    let header = Some(v1::CommandHeader {
        client_id: "x".repeat(chance.below(80) as usize),
        request_id: format!("{}", chance.below(50)),
        at_time_s: (chance.below(4) == 0).then(|| -1.0 - chance.unit()),
    });
    let vector = Some(v1::Vec3 { x: f64::NAN, y: strange(chance), z: strange(chance) });
    let name = ["", "no-such", "a/b", "*", "drum\0"][chance.below(5) as usize].to_string();
    match verb {
        Verb::Insert => Request::Insert(v1::InsertRequest { header, shape: name, ..Default::default() }),
        Verb::Remove => Request::Remove(v1::RemoveRequest { header, ids: vec![1 << 40, chance.bits() | 1 << 41] }),
        Verb::SetGravity => Request::SetGravity(v1::SetGravityRequest { header, gravity_m_per_s2: vector }),
        Verb::SetMotion => Request::SetMotion(v1::SetMotionRequest { header, boundary: name, motion: None }),
        Verb::SetLoads => Request::SetLoads(v1::SetLoadsRequest {
            header,
            loads: Some(v1::Loads { topology_epoch: chance.bits(), ramp_s: strange(chance), ..Default::default() }),
        }),
        Verb::SetFluid => Request::SetFluid(v1::SetFluidRequest {
            header,
            fluid: Some(v1::FluidDefinition { density_kg_per_m3: strange(chance), ..Default::default() }),
            fields: None,
        }),
        Verb::Pause => Request::Pause(v1::PauseRequest { header }),
        Verb::Resume => Request::Resume(v1::ResumeRequest { header }),
        Verb::Step => Request::Step(v1::StepRequest { header, steps: chance.below(2) * chance.bits() }),
        Verb::Advance => {
            Request::Advance(v1::AdvanceRequest { header, window_s: strange(chance), ..Default::default() })
        }
        Verb::DefineField => Request::DefineField(v1::DefineFieldRequest {
            header,
            field: Some(v1::FieldDefinition { name, width_m: strange(chance), ..Default::default() }),
        }),
        Verb::DropField => Request::DropField(v1::DropFieldRequest { header, name }),
        Verb::Checkpoint => {
            Request::Checkpoint(v1::CheckpointRequest { header, token: name, on_disk: chance.below(2) == 0 })
        }
        Verb::Restore => Request::Restore(v1::RestoreRequest { header, token: name }),
        Verb::ListCheckpoints => Request::ListCheckpoints(v1::ListCheckpointsRequest { header }),
        Verb::DropCheckpoint => Request::DropCheckpoint(v1::DropCheckpointRequest { header, token: name }),
        Verb::AcquireLease => Request::AcquireLease(v1::AcquireLeaseRequest { header }),
        Verb::ReleaseLease => Request::ReleaseLease(v1::ReleaseLeaseRequest { header }),
        Verb::Stop => Request::Stop(v1::StopRequest { header }),
        #[allow(unreachable_patterns)]
        _ => Request::ListCheckpoints(v1::ListCheckpointsRequest { header }),
    }
}

/// Whether it may be sent to a daemon that shall stay as it is: nothing that decodes to a change that is sound.
fn is_harmless(verb: Verb, payload: &[u8]) -> bool {
    match Request::decode(verb, payload) {
        Err(_) => true,
        Ok(Request::Stop(_)) => false,
        Ok(Request::SetGravity(request)) => {
            request.gravity_m_per_s2.is_none_or(|g| !(g.x.is_finite() && g.y.is_finite() && g.z.is_finite()))
        }
        Ok(Request::Insert(request)) => !["bead", "cube"].contains(&&*request.shape),
        Ok(Request::Remove(request)) => request.ids.iter().any(|&id| id > 1000),
        Ok(Request::SetMotion(request)) => request.boundary != "drum",
        Ok(Request::SetFluid(request)) => {
            request.fluid.is_none_or(|fluid| !(fluid.density_kg_per_m3 > 0.0 && fluid.viscosity_pa_s > 0.0))
        }
        Ok(_) => true,
    }
}
