//! Runs that are killed at random moments and taken up again, against the same run undisturbed.

use std::thread;
use std::time::Duration;

use anyhow::{Context as _, ensure};
use sturz_client::{ClientError, Request, Simulation};

use crate::cases::Checks;
use crate::faults::Size;
use crate::faults::chance::Chance;
use crate::faults::daemon::{Daemon, Folder, replay};
use crate::faults::script::{self, Action, HEAP, Reached};

/// Requests of one run.
const LENGTH: usize = 40;
/// The longest life of a daemon.
const LIFE: Duration = Duration::from_millis(60);

/// Kills until there were enough; every run is compared with its undisturbed twin.
pub fn check(checks: &mut Checks, size: Size) -> anyhow::Result<()> {
    let wanted = size.of(6, 200);
    let mut total = Totals::default();
    let mut seed = 0;
    while total.kills < wanted {
        seed += 1;
        one_run(seed, &mut total).with_context(|| format!("run {seed}"))?;
    }
    checks.shows("kills", f64::from(total.kills), "-");
    checks.shows("requests that were sent again", f64::from(total.again), "-");
    checks.shows("of these, answered from memory", f64::from(total.remembered), "-");
    checks.near("replies and states that differ", total.differences.len() as f64, 0.0, 0.0, "-");
    total.differences.iter().take(3).for_each(|difference| eprintln!("{difference}"));
    checks.shows("journals replayed whole, on 1 and on 2 threads", f64::from(total.replays), "-");
    Ok(())
}

#[derive(Default)]
struct Totals {
    kills: u32,
    again: u32,
    remembered: u32,
    replays: u32,
    differences: Vec<String>,
}

fn one_run(seed: u64, total: &mut Totals) -> anyhow::Result<()> {
    let folder = Folder::new(&format!("kills-{seed}"))?;
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, HEAP)?;
    let actions = script::script(seed, LENGTH);
    let files = folder.join("files");
    let undisturbed = Daemon::serve([&*scene, "--name", "undisturbed", "--paused", "--checkpoints", &files])?;
    let expected = script::run(&undisturbed.connect()?, &actions)?;
    script::check_worth(&expected)?;
    drop(undisturbed);

    let journal = folder.join("journal");
    // Snapshots come all the time, so that some are killed in the midst; the log is kept whole for the replay.
    let kept = ["--checkpoint-every", "0.02", "--journal-keep", "all"];
    let begin = [&*scene, "--name", "killed", "--paused", "--journal", &journal];
    let mut daemon = Daemon::serve(begin.iter().chain(&kept))?;
    let mut chance = Chance::new(seed);
    let mut driver = Driver { next: 0, sent: None, unconfirmed: Vec::new() };
    while driver.next < actions.len() {
        driver.drive(daemon, &actions, &expected, LIFE.mul_f64(chance.unit()), total)?;
        let threads = if chance.below(2) == 0 { "1" } else { "2" };
        daemon = Daemon::serve(["--resume", &*journal, "--threads", threads].iter().chain(&kept))?;
    }
    let state_hash = daemon.connect()?.info()?.state_hash;
    if Some(state_hash) != expected.last().map(|last| last.state_hash) {
        total.differences.push(format!("run {seed} ends with another state"));
    }
    daemon.kill()?;
    for threads in [1, 2] {
        let replayed = replay(folder.path().join("journal").as_path(), threads)?;
        ensure!(replayed["commands"].as_u64().is_some_and(|commands| commands > 10), "{replayed}");
        total.replays += 1;
    }
    Ok(())
}

/// Goes through a run, over as many daemons as it takes.
struct Driver {
    next: usize,
    /// The request that may have been sent.
    sent: Option<Request>,
    /// For later, and not known to be in the journal: nothing behind them has been answered yet.
    unconfirmed: Vec<Request>,
}

impl Driver {
    /// Until the run is at its end, or the daemon's life is.
    fn drive(
        &mut self,
        mut daemon: Daemon,
        actions: &[Action],
        expected: &[Reached],
        life: Duration,
        total: &mut Totals,
    ) -> anyhow::Result<()> {
        let simulation = daemon.connect()?;
        let killer = thread::spawn(move || {
            thread::sleep(life);
            daemon.kill()
        });
        let ended = self.send_all(&simulation, actions, expected, total);
        killer.join().map_err(|_| anyhow::anyhow!("the killer has failed"))??;
        total.kills += 1;
        match ended {
            // A daemon that is killed does not refuse.
            Err(error) if error.refusal().is_some() => Err(error.into()),
            Err(_) | Ok(()) => Ok(()),
        }
    }

    fn send_all(
        &mut self,
        simulation: &Simulation,
        actions: &[Action],
        expected: &[Reached],
        total: &mut Totals,
    ) -> Result<(), ClientError> {
        for request in &self.unconfirmed {
            script::send(simulation, request)?;
        }
        while let Some(action) = actions.get(self.next) {
            let request = match self.sent.take() {
                Some(request) => {
                    total.again += 1;
                    request
                }
                None => script::build(simulation, self.next, action)?,
            };
            self.sent = Some(request.clone());
            let reached = script::send(simulation, &request)?;
            self.sent = None;
            total.remembered += u32::from(reached.repeated);
            if let Some(difference) = script::difference(&expected[self.next], &reached) {
                total.differences.push(format!("request {}, {action:?}: {difference}", self.next));
            }
            if script::is_for_later(&request) {
                self.unconfirmed.push(request);
            } else {
                self.unconfirmed.clear();
            }
            self.next += 1;
        }
        Ok(())
    }
}
