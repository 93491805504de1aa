//! What the physics hands out: latest-wins slots, one per stream, and a queue of notices.
//!
//! The physics thread never waits here. A slot holds one frame; a newer one replaces it, and the buffer of the older
//! one is filled again. Where the other side holds the lock at this very moment, the frame is dropped instead.
//! Nothing is copied or computed unless somebody listens.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use sturz_engine::fields::{FieldDefinition, FieldFrame, FieldQuantity};
use sturz_engine::scene::{OutputSection, Pace};
use sturz_engine::{ContactColumn, FloatType, ParticleColumn};
use sturz_protocol::v1;
use tokio::sync::{Notify, mpsc};

use crate::mailbox::ReportSample;
use crate::output::{Choice, ContactSample, Sample, StateSample, contacts_choice, state_choice};
use crate::ticket::Moment;

/// An unchanging state is handed out again after this time: the bus may drop the last frame of a window, and says
/// nothing of a second subscriber.
const REPEAT: Duration = Duration::from_secs(1);

/// One place for the latest frame of a stream, shared by the physics and the publisher.
pub struct Slot<T> {
    /// With its number.
    fresh: Mutex<Option<(u64, Box<T>)>>,
    spare: Mutex<Option<Box<T>>>,
    /// Somebody subscribes.
    wanted: AtomicBool,
    /// Somebody has begun to: the state of now is news to them, though it has not changed.
    newcomer: AtomicBool,
    offered: AtomicU64,
    published: AtomicU64,
    dropped: AtomicU64,
    filled: Notify,
}

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self {
            fresh: Mutex::new(None),
            spare: Mutex::new(None),
            wanted: AtomicBool::new(false),
            newcomer: AtomicBool::new(false),
            offered: AtomicU64::new(0),
            published: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
            filled: Notify::new(),
        }
    }
}

impl<T> Slot<T> {
    /// Publisher's side: whether anybody subscribes.
    pub fn set_wanted(&self, wanted: bool) {
        self.wanted.store(wanted, Relaxed);
        self.newcomer.store(wanted, Relaxed);
    }

    /// Publisher's side: the latest frame, once there is one, and how many were offered before it.
    pub async fn latest(&self) -> (u64, Box<T>) {
        loop {
            let fresh = self.fresh.lock().unwrap_or_else(PoisonError::into_inner).take();
            match fresh {
                Some(frame) => return frame,
                None => self.filled.notified().await,
            }
        }
    }

    /// Publisher's side: the frame is on the bus, its buffer free.
    pub fn published(&self, buffer: Box<T>) {
        self.published.fetch_add(1, Relaxed);
        *self.spare.lock().unwrap_or_else(PoisonError::into_inner) = Some(buffer);
    }

    /// Physics' side: replaces what is there. `fill` gets a used buffer, if there is one.
    pub fn offer(&self, fill: impl FnOnce(Option<Box<T>>) -> Box<T>) {
        let number = self.offered.fetch_add(1, Relaxed);
        let frame = (number, fill(self.take_spare()));
        let replaced = match self.fresh.try_lock() {
            Ok(mut fresh) => fresh.replace(frame),
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner().replace(frame),
            Err(TryLockError::WouldBlock) => Some(frame),
        };
        self.filled.notify_one();
        if let Some((_, unread)) = replaced {
            self.dropped.fetch_add(1, Relaxed);
            if let Ok(mut spare) = self.spare.try_lock() {
                *spare = Some(unread);
            }
        }
    }

    fn take_spare(&self) -> Option<Box<T>> {
        self.spare.try_lock().ok().and_then(|mut spare| spare.take())
    }

    fn counts(&self, name: String) -> v1::StreamCounts {
        v1::StreamCounts {
            name,
            offered: self.offered.load(Relaxed),
            published: self.published.load(Relaxed),
            dropped: self.dropped.load(Relaxed),
        }
    }
}

/// Which state of the simulation: another one after every step and every command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Steps done.
    pub step: u64,
    /// Simulated time, s.
    pub time_s: f64,
    /// Commands applied and changes of mode.
    pub revision: u64,
}

/// What a multiple of a simulated time may be missed by and still counts, in multiples.
const ROUNDING: f64 = 1e-9;

/// Physics' side of a stream: a slot, and when to fill it next.
pub struct Stream<T> {
    slot: Arc<Slot<T>>,
    pace: Pace,
    last: Option<(Instant, Mark)>,
}

impl<T> Stream<T> {
    /// A stream of this pace.
    pub fn new(pace: Pace) -> Self {
        Self { slot: Arc::default(), pace, last: None }
    }

    /// When it hands out frames.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// Changes that. Whoever subscribes gets the state of now in any case: what it holds may have changed too.
    pub fn set_pace(&mut self, pace: Pace) {
        self.pace = pace;
        self.last = None;
    }

    /// The publisher's side.
    pub fn slot(&self) -> Arc<Slot<T>> {
        Arc::clone(&self.slot)
    }

    /// When to offer the state of `mark`, if not at `now`; `None` when nobody wants it, or not before there is another.
    fn due(&self, now: Instant, mark: Mark) -> Option<Instant> {
        if !self.slot.wanted.load(Relaxed) {
            return None;
        }
        let Some((at, last)) = self.last else { return Some(now) };
        let newcomer = self.slot.newcomer.load(Relaxed);
        if let Pace::Wall { every_s } = self.pace {
            let period = Duration::try_from_secs_f64(every_s).unwrap_or(Duration::MAX);
            let is_known = last == mark && !newcomer;
            return at.checked_add(if is_known { period.max(REPEAT) } else { period });
        }
        if newcomer || self.multiples(mark) != self.multiples(last) {
            Some(now)
        } else if last == mark {
            at.checked_add(REPEAT)
        } else {
            None
        }
    }

    /// Multiples of the pace up to a state.
    fn multiples(&self, mark: Mark) -> u64 {
        match self.pace {
            Pace::Wall { .. } => 0,
            Pace::Steps { every } => mark.step / every,
            // `as` saturates
            Pace::Simulated { every_s } => (mark.time_s / every_s + ROUNDING).floor() as u64,
        }
    }

    /// Offers a frame if one is due.
    pub fn offer(&mut self, now: Instant, mark: Mark, fill: impl FnOnce(Option<Box<T>>) -> Box<T>) {
        if self.is_due(now, mark) {
            self.slot.newcomer.store(false, Relaxed);
            self.slot.offer(fill);
            self.last = Some((now, mark));
        }
    }

    /// Whether a frame is due.
    pub fn is_due(&self, now: Instant, mark: Mark) -> bool {
        self.due(now, mark).is_some_and(|due| due <= now)
    }
}

/// A sample of a field.
pub type FieldSample = Sample<FieldFrame, FieldQuantity>;

/// A defined field and its stream.
pub struct FieldStream {
    /// What is sampled.
    pub definition: FieldDefinition,
    /// What of it goes out.
    pub choice: Choice<FieldQuantity>,
    /// Where it goes.
    pub stream: Stream<FieldSample>,
}

/// What the I/O side must hear of, in order.
pub enum Notice {
    /// To publish.
    Event {
        /// Without a header.
        event: Box<v1::Event>,
        /// When.
        moment: Moment,
        /// Of the state then.
        topology_epoch: u64,
    },
    /// To be published from now on.
    FieldDefined(String, Arc<Slot<FieldSample>>),
    /// No longer.
    FieldDropped(String),
}

/// All that the physics hands out.
pub struct Outbox {
    /// Of the state.
    pub state: Stream<StateSample>,
    /// What of it goes out.
    pub state_choice: Choice<ParticleColumn>,
    /// Of the contact network.
    pub contacts: Stream<ContactSample>,
    /// What of it goes out.
    pub contacts_choice: Choice<ContactColumn>,
    /// Of reports.
    pub report: Stream<ReportSample>,
    /// Of fields, in the order of their definition.
    pub fields: Vec<FieldStream>,
    /// What is not defined otherwise.
    pub scene: OutputSection,
    notices: mpsc::Sender<Notice>,
}

impl Outbox {
    /// Streams as the scene has them.
    pub fn new(scene: &OutputSection, notices: mpsc::Sender<Notice>) -> Self {
        Self {
            state: Stream::new(scene.state_pace()),
            state_choice: state_choice(scene),
            contacts: Stream::new(scene.contacts_pace()),
            contacts_choice: contacts_choice(scene),
            report: Stream::new(scene.report_pace()),
            fields: Vec::new(),
            scene: scene.clone(),
            notices,
        }
    }

    /// Tells the I/O side; never waits. With a thousand unread notices, the next one is lost.
    pub fn notify(&self, notice: Notice) {
        if self.notices.try_send(notice).is_err() {
            tracing::warn!("an event is lost: the bus side is not keeping up");
        }
    }

    /// Adds a field, or replaces the one of the same name; all of its columns go out.
    pub fn define_field(&mut self, definition: FieldDefinition) {
        let choice = Choice { columns: Arc::from([]), float: FloatType::F64 };
        match self.fields.iter_mut().find(|field| field.definition.name == definition.name) {
            Some(field) => (field.definition, field.choice) = (definition, choice),
            None => {
                let stream = Stream::new(self.scene.field_pace());
                self.notify(Notice::FieldDefined(definition.name.clone(), stream.slot()));
                self.fields.push(FieldStream { definition, choice, stream });
            }
        }
    }

    /// Forgets a field; `false` when there is none of that name.
    pub fn drop_field(&mut self, name: &str) -> bool {
        let before = self.fields.len();
        self.fields.retain(|field| field.definition.name != name);
        let found = self.fields.len() < before;
        if found {
            self.notify(Notice::FieldDropped(name.into()));
        }
        found
    }

    /// The definition of that name.
    pub fn field(&self, name: &str) -> Option<&FieldDefinition> {
        self.fields.iter().map(|field| &field.definition).find(|definition| definition.name == name)
    }

    /// When the next frame of an unchanging state is due; `None` when nobody wants any.
    pub fn next_due(&self, now: Instant, mark: Mark) -> Option<Instant> {
        let fields = self.fields.iter().filter_map(|field| field.stream.due(now, mark));
        let others = [self.state.due(now, mark), self.contacts.due(now, mark), self.report.due(now, mark)];
        fields.chain(others.into_iter().flatten()).min()
    }

    /// Frames of each stream.
    pub fn counts(&self) -> Vec<v1::StreamCounts> {
        let fields =
            self.fields.iter().map(|field| field.stream.slot.counts(format!("field/{}", field.definition.name)));
        let others = [
            self.state.slot.counts("state".into()),
            self.contacts.slot.counts("contacts".into()),
            self.report.slot.counts("report".into()),
        ];
        others.into_iter().chain(fields).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARK: Mark = Mark { step: 1, time_s: 0.1, revision: 0 };

    fn wall(rate_hz: f64) -> Stream<u8> {
        Stream::new(Pace::Wall { every_s: 1.0 / rate_hz })
    }

    fn counts<T>(slot: &Slot<T>) -> [u64; 3] {
        let counts = slot.counts(String::new());
        [counts.offered, counts.published, counts.dropped]
    }

    #[tokio::test]
    async fn the_latest_frame_wins_and_buffers_return() {
        let slot = Slot::<Vec<u8>>::default();
        slot.offer(|_| Box::new(vec![1]));
        slot.offer(|spare| {
            assert!(spare.is_none());
            Box::new(vec![2])
        });
        let (number, latest) = slot.latest().await;
        assert_eq!((number, &*latest), (1, &vec![2]), "the one before is missed in the numbers");
        slot.published(latest);
        slot.offer(|spare| {
            assert_eq!(spare.as_deref(), Some(&vec![2]), "the published buffer comes back");
            Box::new(vec![3])
        });
        assert_eq!(counts(&slot), [3, 1, 1]);
    }

    #[test]
    fn a_held_lock_does_not_stop_the_physics() {
        let slot = Slot::<u8>::default();
        let held = slot.fresh.lock().unwrap();
        slot.offer(|_| Box::new(1));
        drop(held);
        assert_eq!(counts(&slot), [1, 0, 1]);
    }

    #[test]
    fn nothing_is_computed_for_nobody() {
        let mut stream = wall(1e9);
        stream.offer(Instant::now(), MARK, |_| panic!("nobody listens"));
        stream.slot.set_wanted(true);
        stream.offer(Instant::now(), MARK, |_| Box::new(1));
        assert_eq!(counts(&stream.slot), [1, 0, 0]);
    }

    #[test]
    fn an_unchanged_state_is_offered_to_newcomers_and_once_a_second() {
        let mut stream = wall(1e9);
        stream.slot.set_wanted(true);
        let later = Instant::now() + Duration::from_secs(1);
        for _ in 0..3 {
            stream.offer(later, MARK, |_| Box::new(1));
        }
        assert_eq!(counts(&stream.slot)[0], 1);
        assert_eq!(stream.due(later, MARK), Some(later + REPEAT));
        stream.slot.set_wanted(true);
        stream.offer(later + REPEAT / 2, MARK, |_| Box::new(1));
        assert_eq!(counts(&stream.slot)[0], 2);
        stream.offer(later + 2 * REPEAT, MARK, |_| Box::new(1));
        assert_eq!(counts(&stream.slot)[0], 3, "who came unnoticed, or lost the last frame, gets it at last");
    }

    #[test]
    fn the_rate_is_capped_and_zero_means_never_again() {
        let mut stream = wall(1.0);
        stream.slot.set_wanted(true);
        let start = Instant::now() + Duration::from_secs(1);
        for step in 0..100 {
            let now = start + Duration::from_millis(30) * step;
            stream.offer(now, Mark { step: u64::from(step), ..MARK }, |_| Box::new(1));
        }
        assert_eq!(counts(&stream.slot)[0], 3, "at 0, 1.02 and 2.04 s");
        let mut never = wall(0.0);
        never.slot.set_wanted(true);
        never.offer(start, MARK, |_| Box::new(1));
        assert!(!never.is_due(start + Duration::from_secs(1 << 40), Mark { step: 2, ..MARK }));
    }

    /// Steps at which a stream that somebody has subscribed to hands out its frames, of the first 40.
    fn steps_of(pace: Pace, time_step_s: f64) -> Vec<u64> {
        let mut stream = Stream::<u8>::new(pace);
        stream.slot.set_wanted(true);
        let (now, mut steps) = (Instant::now(), Vec::new());
        for step in 0..40 {
            let mark = Mark { step, time_s: step as f64 * time_step_s, revision: 0 };
            stream.offer(now, mark, |_| {
                steps.push(step);
                Box::new(1)
            });
        }
        steps
    }

    #[test]
    fn frames_come_at_multiples_of_steps_and_of_simulated_time() {
        assert_eq!(steps_of(Pace::Steps { every: 1 }, 0.1), (0..40).collect::<Vec<_>>());
        assert_eq!(steps_of(Pace::Steps { every: 13 }, 0.1), [0, 13, 26, 39]);
        // at 0.3 s, which is 2.9999999999999996 times 0.1 s, and so on
        assert_eq!(steps_of(Pace::Simulated { every_s: 0.1 }, 0.1), (0..40).collect::<Vec<_>>());
        assert_eq!(steps_of(Pace::Simulated { every_s: 1.05 }, 0.1), [0, 11, 21, 32]);
        assert_eq!(steps_of(Pace::Simulated { every_s: 0.03 }, 0.1), (0..40).collect::<Vec<_>>());
    }

    #[test]
    fn a_newcomer_gets_the_state_of_now_between_multiples() {
        let mut stream = Stream::<u8>::new(Pace::Steps { every: 10 });
        stream.slot.set_wanted(true);
        let (now, at) = (Instant::now(), |step| Mark { step, ..MARK });
        for (step, newcomer, offered) in
            [(0, false, 1), (3, false, 1), (4, true, 2), (5, false, 2), (10, false, 3), (9, false, 4), (9, false, 4)]
        {
            if newcomer {
                stream.slot.set_wanted(true);
            }
            stream.offer(now, at(step), |_| Box::new(1));
            assert_eq!(counts(&stream.slot)[0], offered, "{step}");
        }
        assert_eq!(stream.due(now, at(9)), Some(now + REPEAT), "the bus may have lost it");
        assert_eq!(stream.due(now, at(8)), None, "before the next multiple there is nothing to say");
    }
}
