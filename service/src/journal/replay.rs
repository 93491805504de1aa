//! Going through a log again: every command at its step, every outcome and every mark compared.

use std::fs::File;
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow, bail, ensure};
use serde::Serialize;
use sturz_engine::{CheckpointSummary, Engine};
use sturz_protocol::keys::Verb;
use sturz_protocol::v1::{self, outcome::Result as Wire};
use tokio::sync::{mpsc, oneshot};

use crate::checkpoints::Checkpoints;
use crate::config::Limits;
use crate::journal::record::{Accepted, Entry, Mark, Record, Start};
use crate::journal::state::order_of;
use crate::journal::{Folder, Journal, log, snapshot};
use crate::mailbox::{Answer, Mailbox, mailbox};
use crate::order::RequestKey;
use crate::outbox::Outbox;
use crate::runner::{Phase, Runner};
use crate::ticket::Logged;

/// How often a long replay says how far it is.
const SAY_EVERY: Duration = Duration::from_secs(10);

/// What a replay found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Replayed {
    /// The first record that was replayed.
    pub from_record: u64,
    /// Of the log.
    pub records: u64,
    /// Starts of daemons among them.
    pub starts: u64,
    /// Commands among them.
    pub commands: u64,
    /// Outcomes that were compared.
    pub outcomes: u64,
    /// State hashes that were compared.
    pub state_hashes: u64,
    /// Steps that were done.
    pub steps: u64,
    /// The last state.
    pub step: u64,
    /// Of the last state, s.
    pub time_s: f64,
    /// Of the last state, hexadecimal.
    pub state_hash: String,
    /// A last record that a crash cut off was left out.
    pub torn: bool,
}

/// State of a replay.
pub(crate) struct Replay {
    /// Where the outcomes of what is under way will come.
    waiting: Vec<(RequestKey, oneshot::Receiver<Answer>)>,
    found: Replayed,
    said: Instant,
}

impl Runner<'_> {
    /// Brings a runner whose journal is [`Journal::replaying`] to the end of the log, from the newest sound snapshot, or with
    /// `whole` from the first record that there is.
    pub(crate) fn replay(&mut self, folder: &Folder, whole: bool) -> anyhow::Result<(Replayed, log::Found)> {
        let mut replay = Replay { waiting: Vec::new(), found: Replayed::default(), said: Instant::now() };
        self.checkpoints.begin_replay();
        let oldest = log::segments(&folder.log())?.first().map_or(0, |segment| segment.first);
        let base = if !whole {
            snapshot::newest(&folder.snapshots())?
        } else if oldest > 0 {
            Some(snapshot::oldest_from(&folder.snapshots(), oldest)?)
        } else {
            None
        };
        let from = base.as_ref().map_or(0, |base| base.daemon.sequence);
        if let Some(base) = base {
            self.load_snapshot(base, |key, answer| replay.waiting.push((key, answer)))?;
        }
        replay.found.from_record = from;
        let found = log::read(&folder.log(), from, |record| {
            let sequence = record.sequence;
            self.replay_record(record, &mut replay).with_context(|| format!("record {sequence} of the journal"))
        })?;
        let now = self.moment();
        let state_hash = format!("{:016x}", self.engine.state_hash());
        let torn = found.torn.is_some();
        Ok((Replayed { step: now.step, time_s: now.time_s, state_hash, torn, ..replay.found }, found))
    }

    /// Begins to write a journal: of a new run, or behind what is there, which is replayed first.
    pub(crate) fn take_up(
        &mut self,
        folder: &Folder,
        resumes: bool,
        start: Start,
        mailbox: Mailbox,
    ) -> anyhow::Result<()> {
        let mut next = 0;
        if resumes {
            self.journal = Journal::replaying();
            // What was accepted under other limits is not refused now.
            let limits = std::mem::replace(&mut self.limits, Limits::none());
            self.memory.set_capacity(usize::MAX);
            let (replayed, found) = self.replay(folder, false).context("the journal cannot be taken up")?;
            self.memory.set_capacity(limits.remembered_requests);
            self.limits = limits;
            if let Some((path, at)) = &found.torn {
                tracing::info!("a record that was not written to its end, nor acknowledged, is cut off");
                File::options().write(true).open(path)?.set_len(*at)?;
            }
            self.checkpoints.end_replay();
            next = found.next;
            tracing::info!(
                "goes on at step {}, {:?} s: {} records replayed, {} steps",
                replayed.step,
                replayed.time_s,
                replayed.records,
                replayed.steps
            );
        }
        let begun = self.journal.begin(folder, next, mailbox);
        begun.with_context(|| format!("the journal {}", folder.path().display()))?;
        let start = Start { is_first: next == 0, ..start };
        self.begin_serving(&start);
        self.post(Entry::Start(start));
        Ok(())
    }

    fn replay_record(&mut self, record: Record, replay: &mut Replay) -> anyhow::Result<()> {
        self.replay_steps(record.step, replay)?;
        replay.found.records += 1;
        match record.entry.context("it is of a kind that this program does not know")? {
            Entry::Start(start) => {
                replay.found.starts += 1;
                self.begin_serving(&start);
            }
            Entry::Command(accepted) => self.replay_command(&accepted, replay)?,
            Entry::Settled(outcome) => self.replay_settled(&outcome, replay)?,
            Entry::Due(due) => {
                let next = self.schedule.next_due(self.moment().time_s);
                let (order, mut ticket) = next.context("no command is due here")?;
                let key = order.key.clone();
                ticket.set_logged(Logged::Due);
                self.execute(order.body, ticket);
                if let Some(outcome) = due.outcome {
                    replay.compare(&key, &outcome)?;
                }
            }
            Entry::LeaseLost(lost) => self.lose_lease(&lost.holder),
            Entry::Mark(mark) | Entry::End(mark) => self.compare_state(&mark, replay)?,
        }
        Ok(())
    }

    /// Steps as the run did until it was at `step`.
    fn replay_steps(&mut self, step: u64, replay: &mut Replay) -> anyhow::Result<()> {
        while self.moment().step != step {
            let now = self.moment();
            ensure!(
                now.step < step && self.is_stepping(),
                "the replay stands at step {} ({:?}), the run was at step {step}",
                now.step,
                self.phase
            );
            if self.shared.stop.load(std::sync::atomic::Ordering::Relaxed) {
                bail!("interrupted at step {}", now.step);
            }
            self.step();
            self.finish_window_if_complete();
            self.pause_at_stop_time();
            replay.found.steps += 1;
            if replay.said.elapsed() > SAY_EVERY {
                replay.said = Instant::now();
                tracing::info!("replaying: step {}, {:.6} s", now.step, now.time_s);
            }
        }
        Ok(())
    }

    fn replay_command(&mut self, accepted: &Accepted, replay: &mut Replay) -> anyhow::Result<()> {
        replay.found.commands += 1;
        let order = order_of(accepted)?;
        let key = order.key.clone();
        if let (Verb::Stop, Some(outcome)) = (order.verb, &accepted.outcome) {
            // The daemon went; the run is there.
            self.memory.remember(order.fingerprint, outcome.clone());
            return Ok(());
        }
        if let Some(Wire::Restored(v1::Restored { checkpoint: Some(then) })) =
            accepted.outcome.as_ref().and_then(|outcome| outcome.result.as_ref())
        {
            self.check_file_is_there(then)?;
        }
        let (reply, answer) = oneshot::channel();
        replay.waiting.push((key.clone(), answer));
        self.receive(order, reply);
        match &accepted.outcome {
            Some(outcome) => replay.compare(&key, outcome),
            None => Ok(()),
        }
    }

    /// Refuses to go back to another state than the run did: a log holds no copies of checkpoint files.
    fn check_file_is_there(&self, then: &v1::Checkpoint) -> anyhow::Result<()> {
        if !then.on_disk {
            return Ok(());
        }
        let (token, step) = (&then.token, then.step);
        let bytes = self.checkpoints.bytes(token);
        let bytes = bytes.map_err(|error| {
            anyhow!(
                "the run went back to step {step} by the checkpoint file {token:?}, which is no more there ({})",
                error.message
            )
        })?;
        let now =
            CheckpointSummary::read(&bytes).map_err(|failure| anyhow!("the checkpoint file {token:?} {failure}"))?;
        ensure!(
            now.state_hash == then.state_hash,
            "the run went back to step {step} by the checkpoint file {token:?}, which has been written over since: it holds \
             step {}; with the file of then (state hash {:016x}) there, the replay goes on",
            now.step,
            then.state_hash
        );
        Ok(())
    }

    fn replay_settled(&mut self, logged: &v1::Outcome, replay: &mut Replay) -> anyhow::Result<()> {
        let key = RequestKey { client_id: logged.client_id.clone(), request_id: logged.request_id.clone() };
        let is_window = self.window.as_ref().is_some_and(|window| *window.ticket.key() == key);
        match &logged.result {
            // The step that failed comes again.
            Some(Wire::Error(_)) if is_window => drop(self.step()),
            Some(Wire::Error(error)) => {
                if let Some(ticket) = self.schedule.remove(&key) {
                    self.refuse(ticket, error.clone());
                } else if error.code() == v1::ErrorCode::Disk {
                    return self.replay_disk_error(&key, logged, replay);
                }
            }
            Some(Wire::Stepped(v1::Stepped { stop_reason, .. }) | Wire::Advanced(v1::Advanced { stop_reason, .. }))
                if is_window =>
            {
                let reason = v1::StopReason::try_from(*stop_reason).unwrap_or_default();
                ensure!(reason != v1::StopReason::Complete, "the window is not complete here");
                self.finish_window(reason);
            }
            _ => {}
        }
        replay.compare(&key, logged)
    }

    /// A checkpoint that the disk did not take then.
    fn replay_disk_error(&mut self, key: &RequestKey, logged: &v1::Outcome, replay: &mut Replay) -> anyhow::Result<()> {
        if let Some(Wire::Checkpointed(v1::Checkpointed { checkpoint: Some(checkpoint) })) = replay.take(key)?.result {
            self.checkpoints.forget_replayed(&checkpoint.token);
        }
        self.memory.correct(key, logged);
        Ok(())
    }

    fn compare_state(&self, mark: &Mark, replay: &mut Replay) -> anyhow::Result<()> {
        let here = self.journal_mark();
        replay.found.state_hashes += 1;
        ensure!(
            here.state_hash == mark.state_hash && here.time_s.to_bits() == mark.time_s.to_bits(),
            "the state at step {} differs: hash {:016x} at {:?} s, the run had {:016x} at {:?} s",
            self.moment().step,
            here.state_hash,
            here.time_s,
            mark.state_hash,
            mark.time_s
        );
        Ok(())
    }

    /// What a start of a daemon does to a run: nobody holds the lease any more.
    pub(crate) fn begin_serving(&mut self, start: &Start) {
        if self.lease.take().is_some() || start.paused {
            self.set_paused();
        }
        if !start.paused && start.is_first {
            self.phase = Phase::Running;
        }
    }

    fn set_paused(&mut self) {
        if self.phase == Phase::Running {
            self.phase = Phase::Paused;
        }
    }
}

impl Replay {
    fn take(&mut self, key: &RequestKey) -> anyhow::Result<v1::Outcome> {
        // Requests without an id share one key: the one that is settled here is meant.
        for k in 0..self.waiting.len() {
            let (waits, answer) = &mut self.waiting[k];
            if waits == key
                && let Ok(answer) = answer.try_recv()
            {
                self.waiting.remove(k);
                return Ok(answer.outcome);
            }
        }
        bail!("the request {key:?} is not settled here")
    }

    fn compare(&mut self, key: &RequestKey, logged: &v1::Outcome) -> anyhow::Result<()> {
        let outcome = self.take(key)?;
        self.found.outcomes += 1;
        ensure!(outcome == *logged, "the outcome differs: {outcome:?}, the run had {logged:?}");
        Ok(())
    }
}

/// Replays a whole run on so many threads, and compares it. Nothing in the folder is touched.
pub fn replay(folder: &Folder, threads: usize) -> anyhow::Result<Replayed> {
    let scene = folder.scene()?;
    let (_letters, inbox) = mailbox(1);
    // Nobody reads them.
    let (notices, _heard) = mpsc::channel(1);
    let outbox = Outbox::new(&scene.description().output, notices);
    let mut engine = Engine::new(scene);
    engine.set_threads(threads);
    let checkpoints = Checkpoints::reading(&folder.checkpoints());
    engine.in_pool(|engine| {
        let mut runner = Runner::new(engine, inbox, outbox, std::sync::Arc::default(), Limits::none());
        runner.journal = Journal::replaying();
        runner.checkpoints = checkpoints;
        runner.replay(folder, true).map(|(found, _)| found)
    })
}
