//! S22: commands in the midst of a window, out of order, twice, and a hundred thousand particles in one message.

use std::thread;

use anyhow::{Context as _, anyhow, ensure};
use sturz_client::v1::{self, ErrorCode, RunState};
use sturz_client::{ClientError, Insertion, Placement, Request, Simulation, Start, Window};

use crate::cases::Checks;
use crate::faults::Size;
use crate::faults::daemon::{Daemon, Folder, SOON};
use crate::faults::lockstep::served;
use crate::faults::script::HEAP;

/// What a daemon takes in one insertion.
const MOST: usize = 100_000;

/// All of it, short or full.
pub fn check(checks: &mut Checks, _: Size) -> anyhow::Result<()> {
    many_in_one_message(checks)?;
    let folder = Folder::new("bus")?;
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, HEAP)?;
    let [one, two] = [0, 1].map(|_| Daemon::serve([&*scene, "--name", "bus", "--paused"]));
    let (daemon, twin) = (one?, two?);
    let (simulation, twin) = (daemon.connect()?, twin.connect()?);
    in_the_midst_of_a_window(checks, &simulation, &twin)?;
    twice(checks, &daemon, &simulation)?;
    out_of_order(checks, &simulation)
}

fn code<T>(answer: Result<T, ClientError>) -> anyhow::Result<ErrorCode> {
    let error = answer.err().context("it was not refused")?;
    Ok(error.refusal().ok_or_else(|| anyhow!("{error}"))?.code)
}

/// Beads on a lattice beside those that are there.
fn lattice(count: usize) -> Insertion {
    let place = |k: usize| [0.003 * (k % 50) as f64, 0.003 * (k / 50 % 50) as f64, 1.0 + 0.003 * (k / 2500) as f64];
    Insertion::new("bead", "glass", Placement::poses((0..count).map(place).collect()))
}

fn many_in_one_message(checks: &mut Checks) -> anyhow::Result<()> {
    let (_daemon, simulation, _folder) = served(8)?;
    let before = simulation.info()?;
    let refused = code(simulation.insert(lattice(MOST + 1)))?;
    let same = simulation.info()?.state_hash == before.state_hash;
    checks.holds(
        "one particle more than the limit: refused, and nothing is changed",
        refused == ErrorCode::TooLarge && same,
    );
    let inserted = simulation.insert(lattice(MOST))?;
    let now = simulation.info()?;
    let all_at_once =
        now.particles == before.particles + MOST as u64 && now.topology_epoch == before.topology_epoch + 1;
    checks.holds(
        "100,000 particles in one message: all of them at one step",
        inserted.ids.count() == MOST && all_at_once,
    );
    simulation.step(1).context("they move")?;
    Ok(())
}

/// Its outcome names the step; a twin that gives it there has the same state.
fn in_the_midst_of_a_window(checks: &mut Checks, simulation: &Simulation, twin: &Simulation) -> anyhow::Result<()> {
    const STEPS: u64 = 20_000;
    let gravity = [2.0, 0.0, -9.0];
    let steered = thread::scope(|scope| {
        let window = scope.spawn(|| simulation.step(STEPS));
        while simulation.info()?.state() == RunState::Paused && !window.is_finished() {}
        let steered = simulation.set_gravity(gravity)?;
        window.join().map_err(|_| anyhow!("the window's thread has failed"))??;
        anyhow::Ok(steered)
    })?;
    let at = steered.at.step;
    ensure!(at <= STEPS, "steered at step {at}");
    if at > 0 {
        twin.step(at)?;
    }
    twin.set_gravity(gravity)?;
    if at < STEPS {
        twin.step(STEPS - at)?;
    }
    let same = twin.info()?.state_hash == simulation.info()?.state_hash;
    checks.holds("a command during a window acts between two steps, and says which", same);
    Ok(())
}

/// The same request by ten clients at once.
fn twice(checks: &mut Checks, daemon: &Daemon, simulation: &Simulation) -> anyhow::Result<()> {
    let before = simulation.info()?.particles;
    let header = v1::CommandHeader { client_id: "c".into(), request_id: "same".into(), at_time_s: None };
    let far = Insertion::new("bead", "glass", Placement::poses(vec![[0.0, 1.0, 0.0]]));
    let request = Request::Insert(far.into()).with_header(header);
    let clients: Vec<Simulation> = (0..10).map(|_| daemon.connect()).collect::<anyhow::Result<_>>()?;
    let outcomes = thread::scope(|scope| {
        let request = &request;
        let ask = |client| scope.spawn(move || Simulation::command(client, request.clone(), Some(SOON)));
        let asked: Vec<_> = clients.iter().map(ask).collect();
        asked
            .into_iter()
            .map(|one| one.join().map_err(|_| anyhow!("a client has failed")))
            .collect::<anyhow::Result<Vec<_>>>()
    })?;
    let fresh = outcomes.iter().filter(|outcome| outcome.as_ref().is_ok_and(|outcome| !outcome.repeated)).count();
    checks.near("of ten equal requests at once, applied", fresh as f64, 1.0, 0.0, "-");
    checks.near("particles more", (simulation.info()?.particles - before) as f64, 1.0, 0.0, "-");
    Ok(())
}

fn out_of_order(checks: &mut Checks, simulation: &Simulation) -> anyhow::Result<()> {
    let before = simulation.info()?;
    let wrong = [Start::Step(before.step + 1), Start::Step(0), Start::Time(before.sim_time_s.next_up())];
    for start in wrong {
        let refused = code(simulation.advance(Window::new(1e-4).from(start)))?;
        checks.holds(format!("a window from {start:?} is refused"), refused == ErrorCode::WrongTime);
    }
    checks.holds("the state is as it was", simulation.info()?.state_hash == before.state_hash);
    Ok(())
}
