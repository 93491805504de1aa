//! The physics thread: owns the engine, and is the only one to touch it. Synchronous; knows no bus.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Instant;

use sturz_engine::{Engine, GuardReading, StepError};
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::advance::Window;
use crate::autosave::Autosave;
use crate::checkpoints::Checkpoints;
use crate::config::Limits;
use crate::guards::GuardWatch;
use crate::journal::Journal;
use crate::journal::record::Entry;
use crate::lease::{Clients, Lease};
use crate::mailbox::{Inbox, Letter};
use crate::memory::RequestMemory;
use crate::meter::Meter;
use crate::order::{RequestKey, error};
use crate::outbox::{Mark, Notice, Outbox};
use crate::output::{Sample, refilled};
use crate::schedule::Schedule;
use crate::stages::StageTotals;
use crate::ticket::{Logged, Moment};

/// Letters read between two steps; the rest waits for the next step, so that no flood stops the physics.
const LETTERS_PER_TICK: usize = 64;

/// Whether the engine steps when no window is under way.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// It does.
    Running,
    /// It waits for commands.
    Paused,
    /// It never will again.
    Failed(String),
    /// The daemon is going.
    Ended,
}

/// What the I/O side may know at any time without asking.
#[derive(Default)]
pub struct Shared {
    /// The daemon shall end.
    pub stop: AtomicBool,
    /// Who is there.
    pub clients: Clients,
    step: AtomicU64,
    time_bits: AtomicU64,
}

impl Shared {
    /// About where the physics is.
    pub fn moment(&self) -> Moment {
        Moment { step: self.step.load(Relaxed), time_s: f64::from_bits(self.time_bits.load(Relaxed)) }
    }

    pub(crate) fn set_moment(&self, moment: Moment) {
        self.step.store(moment.step, Relaxed);
        self.time_bits.store(moment.time_s.to_bits(), Relaxed);
    }
}

/// State of the physics thread.
pub struct Runner<'e> {
    pub(crate) engine: &'e mut Engine,
    pub(crate) inbox: Inbox,
    pub(crate) outbox: Outbox,
    pub(crate) limits: Limits,
    pub(crate) phase: Phase,
    /// The step command or window under way.
    pub(crate) window: Option<Window>,
    pub(crate) memory: RequestMemory,
    pub(crate) schedule: Schedule,
    pub(crate) checkpoints: Checkpoints,
    pub(crate) autosave: Option<Autosave>,
    pub(crate) lease: Option<Lease>,
    /// The last window that has led to where the engine is; none since a restore.
    pub(crate) last_window: Option<RequestKey>,
    pub(crate) meter: Meter,
    /// Counts commands applied and changes of phase.
    pub(crate) revision: u64,
    /// Where to pause, once.
    pub(crate) stop_time_s: Option<f64>,
    /// Which warnings were told.
    pub(crate) guards: GuardWatch,
    pub(crate) journal: Journal,
    /// Why the journal cannot be written: no step is done until it can.
    pub(crate) held: Option<String>,
    pub(crate) shared: Arc<Shared>,
}

impl<'e> Runner<'e> {
    /// A paused simulation without journal, lease or files.
    pub fn new(engine: &'e mut Engine, inbox: Inbox, outbox: Outbox, shared: Arc<Shared>, limits: Limits) -> Self {
        let guards = GuardWatch::new(engine.warnings());
        let mut runner = Self {
            engine,
            inbox,
            outbox,
            phase: Phase::Paused,
            window: None,
            memory: RequestMemory::new(limits.remembered_requests),
            schedule: Schedule::default(),
            checkpoints: Checkpoints::new(None),
            autosave: None,
            lease: None,
            last_window: None,
            meter: Meter::new(StageTotals::default()),
            revision: 0,
            stop_time_s: None,
            guards,
            journal: Journal::default(),
            held: None,
            shared,
            limits,
        };
        let description = runner.engine.scene().description();
        description.fields.iter().cloned().for_each(|field| runner.outbox.define_field(field));
        let now_s = runner.moment().time_s;
        runner.stop_time_s = description.stop.time_s.filter(|&stop| now_s == 0.0 || stop > now_s);
        runner.follow_averages();
        runner
    }
}

impl Runner<'_> {
    /// Runs until the daemon is to end.
    pub fn run(mut self) {
        self.announce(v1::EventKind::Started, v1::Severity::Info, "the simulation has started");
        while self.phase != Phase::Ended {
            self.tick();
        }
        self.end();
    }

    /// One tick: what clients ask, one step, what clients see.
    fn tick(&mut self) {
        // Commands take effect here, between two steps, and are answered with the step that they precede. First those whose
        // time has come: whoever asks for the state finds them applied, however fast the question is.
        self.apply_due_orders();
        self.read_mail();

        let stepped_s = if self.is_stepping() { self.step() } else { None };
        self.finish_window_if_complete();
        self.pause_at_stop_time();

        let now = Instant::now();
        if stepped_s.is_some() {
            self.watch_guards(now);
        }
        self.autosave(now);
        self.meter.tick(now, stepped_s);
        self.offer(now);

        if !self.is_stepping() && self.phase != Phase::Ended {
            self.sleep_until_needed();
        }
    }

    fn read_mail(&mut self) {
        for _ in 0..LETTERS_PER_TICK {
            match self.inbox.take() {
                Some(Letter::Command(order, reply)) => self.receive(*order, reply),
                Some(Letter::Read(question, reply)) => self.answer(question, reply),
                Some(Letter::Wake) => {}
                None => break,
            }
        }
        self.settle_files();
        self.watch_lease();
        self.watch_disk();
        if self.shared.stop.load(Relaxed) {
            self.phase = Phase::Ended;
        }
    }

    fn apply_due_orders(&mut self) {
        while self.held.is_none()
            && let Some((order, mut ticket)) = self.schedule.next_due(self.moment().time_s)
        {
            ticket.set_logged(Logged::Due);
            self.execute(order.body, ticket);
        }
    }

    pub(crate) fn is_stepping(&self) -> bool {
        match self.phase {
            _ if self.held.is_some() => false,
            Phase::Running => true,
            Phase::Paused => self.window.is_some(),
            Phase::Failed(_) | Phase::Ended => false,
        }
    }

    /// One step; its length, unless it failed.
    pub fn step(&mut self) -> Option<f64> {
        let before_s = self.moment().time_s;
        let result = self.engine.step();
        let now = self.moment();
        self.shared.set_moment(now);
        self.tell_happenings();
        if let Some(window) = &mut self.window {
            window.steps_done += 1;
        }
        match result {
            Ok(()) => Some(now.time_s - before_s),
            Err(failure) => {
                self.fail(&failure);
                None
            }
        }
    }

    fn fail(&mut self, failure: &StepError) {
        let text = failure.to_string();
        tracing::error!("{text}");
        self.phase = Phase::Failed(text.clone());
        self.revision += 1;
        self.announce(v1::EventKind::Failed, v1::Severity::Error, &text);
        if let Some(window) = self.window.take() {
            self.leave(&window);
            let error = error(v1::ErrorCode::RunFailed, "", text);
            self.settle(window.ticket, window.begun, Wire::Error(error), None);
        }
    }

    pub(crate) fn finish_window_if_complete(&mut self) {
        if self.window.as_ref().is_some_and(Window::is_complete) {
            self.finish_window(v1::StopReason::Complete);
        }
    }

    /// Ends the window under way, if there is one, and answers it.
    pub(crate) fn finish_window(&mut self, reason: v1::StopReason) {
        let Some(window) = self.window.take() else {
            return;
        };
        self.leave(&window);
        self.revision += 1;
        self.last_window = Some(window.ticket.key().clone());
        let result = window.result(self.moment(), reason);
        let capture = window.outputs.as_ref().and_then(|outputs| self.capture(outputs));
        self.settle(window.ticket, window.begun, result, capture);
    }

    fn leave(&mut self, window: &Window) {
        if window.has_own_time_step() {
            self.engine.end_window();
        }
    }

    pub(crate) fn pause_at_stop_time(&mut self) {
        if self.phase == Phase::Running && self.stop_time_s.is_some_and(|stop| self.moment().time_s >= stop) {
            self.stop_time_s = None;
            self.set_phase(Phase::Paused, "the simulation is paused at the scene's stop time");
        }
    }

    /// Changes between running and paused, and says so.
    pub(crate) fn set_phase(&mut self, phase: Phase, message: &str) {
        if self.phase == phase {
            return;
        }
        let kind = match phase {
            Phase::Running => v1::EventKind::Resumed,
            _ => v1::EventKind::Paused,
        };
        self.phase = phase;
        self.revision += 1;
        self.announce(kind, v1::Severity::Info, message);
    }

    /// Hands out what is due to those who listen.
    fn offer(&mut self, now: Instant) {
        let mark = self.mark();
        let engine = &mut *self.engine;
        let outbox = &mut self.outbox;
        outbox.state.offer(now, mark, |spare| {
            let mut sample = refilled(spare, &outbox.state_choice);
            engine.snapshot(&mut sample.data);
            if sample.choice.columns.iter().any(|column| column.is_force()) {
                engine.snapshot_forces(&mut sample.data);
            }
            sample
        });
        outbox.contacts.offer(now, mark, |spare| {
            let mut sample = refilled(spare, &outbox.contacts_choice);
            engine.contact_network(&mut sample.data);
            sample
        });
        for field in &mut outbox.fields {
            let (definition, choice) = (&field.definition, &field.choice);
            let fill = |_| Box::new(Sample { data: engine.compute_field(definition), choice: choice.clone() });
            field.stream.offer(now, mark, fill);
        }
        if self.outbox.report.is_due(now, mark) {
            let sample = self.report();
            let engine = &sample.engine;
            let (value, limit) = (engine.time_step_s, engine.present_critical_time_step_s);
            self.warn_of_step(now, GuardReading { particle: None, value, limit });
            self.outbox.report.offer(now, mark, |_| Box::new(sample));
        }
    }

    /// Sleeps until there is mail, or until a stream whose rate was capped may have the last state.
    fn sleep_until_needed(&mut self) {
        let deadline = self.outbox.next_due(Instant::now(), self.mark());
        if !self.inbox.wait(deadline) {
            self.phase = Phase::Ended;
        }
        self.meter.woke();
    }

    /// Answers whoever still waits: for steps by what was reached, for a later time by a refusal.
    fn end(mut self) {
        self.finish_window(v1::StopReason::Stopped);
        for ticket in self.schedule.drain() {
            self.refuse(ticket, error(v1::ErrorCode::Stopping, "", "the daemon is ending"));
        }
        self.checkpoints.finish();
        self.settle_files();
        if self.journal.is_writing() {
            self.post(Entry::End(self.journal_mark()));
            self.save_snapshot();
            self.journal.finish();
        }
        self.announce(v1::EventKind::Ended, v1::Severity::Info, "the simulation has ended");
    }

    /// Where the engine is.
    pub(crate) fn moment(&self) -> Moment {
        let clock = self.engine.clock();
        Moment { step: clock.step(), time_s: clock.time_s() }
    }

    fn mark(&self) -> Mark {
        let Moment { step, time_s } = self.moment();
        Mark { step, time_s, revision: self.revision }
    }

    /// Puts an event on its way.
    pub(crate) fn announce(&self, kind: v1::EventKind, severity: v1::Severity, message: &str) {
        self.announce_named(kind, severity, message, "");
    }

    /// Puts an event about something with a name on its way.
    pub(crate) fn announce_named(&self, kind: v1::EventKind, severity: v1::Severity, message: &str, name: &str) {
        self.announce_event(v1::Event {
            kind: kind.into(),
            severity: severity.into(),
            message: message.into(),
            name: name.into(),
            ..v1::Event::default()
        });
    }

    /// Puts an event on its way; its header is made where it is published.
    pub(crate) fn announce_event(&self, event: v1::Event) {
        if self.journal.is_replaying() {
            // It was news when it happened.
            return;
        }
        let (moment, topology_epoch) = (self.moment(), self.engine.topology_epoch());
        self.outbox.notify(Notice::Event { event: Box::new(event), moment, topology_epoch });
    }
}
