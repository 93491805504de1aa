//! The zenoh session with one daemon: questions that get an answer or a reason why not, and subscriptions. Callbacks
//! of zenoh only enqueue: a call to the bus from inside one can hang.

use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use prost::Message as _;
use prost::bytes::Bytes;
use sturz_protocol::keys::{ALL_ALIVE, Keys};
use sturz_protocol::v1;
use tokio::runtime::{Handle, RuntimeFlavor};
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::qos::CongestionControl;
use zenoh::query::{ConsolidationMode, Reply};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};
use zenoh_ext::{AdvancedSubscriber, AdvancedSubscriberBuilderExt, HistoryConfig, Miss, RecoveryConfig};

use crate::error::{ClientError, Refusal};
use crate::loss::{Loss, diagnose};
use crate::queue::{End, Popped, Queue};
use crate::target::Target;
use crate::watch::Watch;

/// Longer than any run; zenoh wants a number.
const NO_LIMIT: Duration = Duration::from_secs(10_000_000);
/// Zenoh's clock runs out after ours, which says more.
const GRACE: Duration = Duration::from_secs(5);
/// A daemon that goes ends its queries some moments before its liveliness is lost.
const LAST_MOMENTS: Duration = Duration::from_secs(1);
/// For the liveliness token of a daemon that is there, when connecting has taken all the time.
const LAST_LOOK: Duration = Duration::from_millis(50);
/// How long to look for other instances.
const SEARCH: Duration = Duration::from_secs(2);

/// One session with one daemon.
pub(crate) struct Bus {
    /// Where everything is.
    pub(crate) keys: Keys,
    /// Where the daemon is.
    pub(crate) target: Target,
    /// Whether it lives.
    pub(crate) watch: Arc<Watch>,
    /// Why it is gone, once somebody wanted to know.
    loss: OnceLock<Loss>,
    _liveliness: Subscriber<()>,
    session: Session,
    // Last: behind it, the session is that of the thread alone.
    _closing: Closing,
}

/// A question on its way, and its answer.
pub(crate) struct Question {
    /// Such as `cmd/pause`.
    pub(crate) what: String,
    /// One of them.
    pub(crate) answers: Arc<Queue<Payload>>,
}

/// Of an answer (`Ok`), or of an error reply.
pub(crate) type Payload = Result<Bytes, Bytes>;

/// A declared subscription; dropping it ends it.
pub(crate) enum Subscription {
    /// From now on.
    Live(#[allow(dead_code)] Subscriber<()>),
    /// Recent past first.
    WithHistory(#[allow(dead_code)] AdvancedSubscriber<()>),
}

impl Bus {
    /// Connects, and waits for the instance's liveliness token.
    pub(crate) fn open(instance: &str, target: &Target, patience: Duration) -> Result<Self, ClientError> {
        let keys = Keys::new(instance)?;
        let deadline = Instant::now() + patience;
        let session = target.open(deadline)?;
        let watch = Arc::new(Watch::default());
        let heard = {
            let watch = Arc::clone(&watch);
            move |sample: Sample| match sample.kind() {
                SampleKind::Put => watch.appeared(),
                SampleKind::Delete => watch.vanished(),
            }
        };
        let liveliness = session.liveliness().declare_subscriber(keys.alive()).history(true).callback(heard).wait();
        let liveliness = liveliness.map_err(|error| ClientError::bus("liveliness", error))?;
        if !watch.wait_until_seen(deadline.saturating_duration_since(Instant::now()).max(LAST_LOOK)) {
            let alive = instances(&session)?;
            let (instance, endpoint) = (instance.into(), target.endpoint.clone());
            // Who may look sees at least the daemon that it is connected to.
            return Err(match alive.is_empty() && target.tls.is_some() {
                true => ClientError::NothingToSee { instance, endpoint },
                false => ClientError::NoSuchInstance { instance, endpoint, alive },
            });
        }
        let closing = end_session_with_daemon(&session, &watch)?;
        let (target, loss) = (target.clone(), OnceLock::new());
        Ok(Self { keys, target, watch, loss, _liveliness: liveliness, session, _closing: closing })
    }

    /// Of this session, unique on the bus.
    pub(crate) fn session_id(&self) -> String {
        self.session.zid().to_string()
    }

    /// Declares a liveliness token, which vanishes with this session.
    pub(crate) fn declare_token(&self, key: &str) -> Result<LivelinessToken, ClientError> {
        self.session.liveliness().declare_token(key).wait().map_err(|error| ClientError::bus(&topic(key), error))
    }

    /// What to say when the daemon is no longer there. Looks once why, which takes some seconds where it hangs.
    pub(crate) fn gone(&self) -> ClientError {
        let loss = *self.loss.get_or_init(|| diagnose(&self.target, &self.keys.alive()));
        let (instance, endpoint) = (self.keys.instance().into(), self.target.endpoint.clone());
        ClientError::DaemonGone { instance, endpoint, loss }
    }

    /// What to say when there was no answer. Zenoh's access control denies without a word; who may come in at all may
    /// ask for `features`, which tell whether there is such control.
    fn no_answer(&self, what: &str) -> ClientError {
        let what = what.to_string();
        let features = self.send_query(&self.keys.features(), None, Some(LAST_MOMENTS)).ok();
        let answer = features.map(|question| question.answers.pop(Some(Instant::now() + LAST_MOMENTS)));
        let controls = match answer {
            Some(Popped::Item(Ok(payload))) => v1::Features::decode(payload).ok(),
            _ => None,
        };
        match controls {
            Some(features) if features.capabilities.iter().any(|each| each == "access_control") => {
                ClientError::Denied { what }
            }
            Some(_) => ClientError::NoAnswer { what },
            None if self.watch.wait_until_gone(LAST_MOMENTS) => self.gone(),
            None => ClientError::NoAnswer { what },
        }
    }

    /// Sends a question; it is on its way, in order with others, when this returns.
    pub(crate) fn send(
        &self,
        selector: &str,
        payload: Option<Vec<u8>>,
        patience: Option<Duration>,
    ) -> Result<Question, ClientError> {
        if self.watch.is_gone() {
            return Err(self.gone());
        }
        self.send_query(selector, payload, patience)
    }

    fn send_query(
        &self,
        selector: &str,
        payload: Option<Vec<u8>>,
        patience: Option<Duration>,
    ) -> Result<Question, ClientError> {
        let what = topic(selector);
        let answers = Arc::new(Queue::new(1));
        let receiver = Receiver(Arc::clone(&answers));
        let mut query = self
            .session
            .get(selector)
            .timeout(patience.map_or(NO_LIMIT, |patience| patience + GRACE))
            .consolidation(ConsolidationMode::None)
            .congestion_control(CongestionControl::Block)
            .express(true);
        if let Some(payload) = payload {
            query = query.payload(payload);
        }
        let sent = query.callback(move |reply| receiver.take(reply)).wait();
        sent.map_err(|error| self.failed(&what, error))?;
        self.watch.end_with_daemon(&answers);
        Ok(Question { what, answers })
    }

    /// Waits for the answer to a question.
    pub(crate) fn answer(&self, question: &Question, patience: Option<Duration>) -> Result<Bytes, ClientError> {
        let popped = question.answers.pop(patience.map(|patience| Instant::now() + patience));
        self.read_answer(&question.what, popped, patience)
    }

    /// What the answer to a question about `what` means. Looks why there is none, which may take seconds.
    pub(crate) fn read_answer(
        &self,
        what: &str,
        popped: Popped<Payload>,
        patience: Option<Duration>,
    ) -> Result<Bytes, ClientError> {
        match popped {
            Popped::Item(Ok(payload)) => Ok(payload),
            Popped::Item(Err(payload)) => match v1::Error::decode(payload.clone()) {
                Ok(error) => Err(Refusal::new(what, error, None).into()),
                Err(_) => Err(ClientError::bus(what, String::from_utf8_lossy(&payload))),
            },
            Popped::Ended if self.watch.is_gone() => Err(self.gone()),
            Popped::Ended => Err(self.no_answer(what)),
            Popped::TimedOut => {
                Err(ClientError::Timeout { what: what.into(), after: patience.unwrap_or(NO_LIMIT), request_id: None })
            }
        }
    }

    /// Calls `receive`, which must not wait, with every payload published under `key` from now on.
    pub(crate) fn subscribe(
        &self,
        key: &str,
        receive: impl Fn(Bytes) + Send + Sync + 'static,
    ) -> Result<Subscription, ClientError> {
        self.check()?;
        let take = move |sample: Sample| receive(bytes_of(sample.payload()));
        let declared = self.session.declare_subscriber(key).callback(take).wait();
        declared.map(Subscription::Live).map_err(|error| self.failed(&topic(key), error))
    }

    /// The same, with the recent past first; lost payloads are asked for again, and `missed`, which must not wait, is told
    /// how many could not be had.
    pub(crate) fn subscribe_with_history(
        &self,
        key: &str,
        receive: impl Fn(Bytes) + Send + Sync + 'static,
        missed: impl Fn(u64) + Send + Sync + 'static,
    ) -> Result<Subscription, ClientError> {
        self.check()?;
        let take = move |sample: Sample| receive(bytes_of(sample.payload()));
        let declared = self
            .session
            .declare_subscriber(key)
            .callback(take)
            .history(HistoryConfig::default().detect_late_publishers())
            .recovery(RecoveryConfig::default().heartbeat())
            .wait()
            .and_then(|subscriber| {
                let told = move |miss: Miss| missed(miss.nb().into());
                subscriber.sample_miss_listener().callback(told).background().wait()?;
                Ok(Subscription::WithHistory(subscriber))
            });
        declared.map_err(|error| self.failed(&topic(key), error))
    }

    fn check(&self) -> Result<(), ClientError> {
        if self.watch.is_gone() { Err(self.gone()) } else { Ok(()) }
    }

    /// Trouble of zenoh's own, which it also has with a session that was ended because the daemon is gone.
    fn failed(&self, what: &str, error: zenoh::Error) -> ClientError {
        if self.watch.is_gone() { self.gone() } else { ClientError::bus(what, error) }
    }
}

impl Drop for Bus {
    fn drop(&mut self) {
        self.watch.leave();
    }
}

/// Ends the session when the daemon is lost. Zenoh would connect it again by itself, with its liveliness token, and the
/// daemon would take this client, which has given up, for one that lives and holds its lease.
///
/// The thread also has the session last, and closes it: zenoh panics where that is done in a runtime of one thread.
fn end_session_with_daemon(session: &Session, watch: &Arc<Watch>) -> Result<Closing, ClientError> {
    let (session, watched) = (session.clone(), Arc::clone(watch));
    let (held, let_go) = channel::<()>();
    let wait = move || {
        if watched.wait_for_the_end() {
            drop(session.close().wait());
        }
        // Nothing is ever sent: it ends when the other end goes.
        let _ = let_go.recv();
        drop(session);
    };
    let thread = thread::Builder::new().name("sturz-loss".into()).spawn(wait);
    let thread = thread.map_err(|error| ClientError::bus("thread", error))?;
    Ok(Closing { held: Some(held), thread: Some(thread), watch: Arc::clone(watch) })
}

/// Lets the thread close the session, and waits for it where that is allowed and soon done.
struct Closing {
    held: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
    watch: Arc<Watch>,
}

impl Drop for Closing {
    fn drop(&mut self) {
        drop(self.held.take());
        let runtime = Handle::try_current().map(|handle| handle.runtime_flavor());
        let must_not_wait = runtime.is_ok_and(|flavor| flavor == RuntimeFlavor::CurrentThread);
        if let Some(thread) = self.thread.take()
            && !must_not_wait
            && !self.watch.is_gone()
        {
            // What it has failed at is over.
            drop(thread.join());
        }
    }
}

/// Puts replies into a queue, and ends it when zenoh drops it: then all replies are there.
struct Receiver(Arc<Queue<Payload>>);

impl Receiver {
    fn take(&self, reply: Reply) {
        self.0.push(match reply.result() {
            Ok(sample) => Ok(bytes_of(sample.payload())),
            Err(error) => Err(bytes_of(error.payload())),
        });
    }
}

impl Drop for Receiver {
    fn drop(&mut self) {
        self.0.end();
    }
}

/// In one piece: what is decoded out of it needs no copies of its own.
fn bytes_of(payload: &ZBytes) -> Bytes {
    payload.to_bytes().into_owned().into()
}

/// `state/latest` of `sturz/v1/drum/state/latest?columns=ids`.
fn topic(selector: &str) -> String {
    let key = selector.split('?').next().unwrap_or_default();
    key.splitn(4, '/').nth(3).unwrap_or(key).into()
}

/// Names of those that are alive, sorted.
fn instances(session: &Session) -> Result<Vec<String>, ClientError> {
    let replies = session.liveliness().get(ALL_ALIVE).timeout(SEARCH).wait();
    let replies = replies.map_err(|error| ClientError::bus("liveliness", error))?;
    let mut alive = Vec::new();
    while let Ok(reply) = replies.recv() {
        if let Ok(sample) = reply.result() {
            alive.extend(sample.key_expr().as_str().split('/').nth(2).map(String::from));
        }
    }
    alive.sort();
    alive.dedup();
    Ok(alive)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_are_what_follows_the_instance() {
        assert_eq!(topic("sturz/v1/drum/state/latest?columns=a|b;float=f32"), "state/latest");
        assert_eq!(topic("sturz/v1/drum/info"), "info");
    }

    #[test]
    fn nonsense_is_refused_before_anything_is_tried() {
        let open = |name, endpoint| Bus::open(name, &Target::new(endpoint), Duration::from_secs(60)).err().unwrap();
        assert!(matches!(open("a/b", "tcp/127.0.0.1:7447"), ClientError::InvalidName(_)));
        assert!(matches!(open("a", "somewhere"), ClientError::InvalidEndpoint { .. }));
    }

    #[test]
    fn an_endpoint_where_nobody_listens_is_named() {
        // Bound and dropped: the port was free a moment ago.
        let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let endpoint = format!("tcp/127.0.0.1:{port}");
        let error = Bus::open("a", &Target::new(endpoint.as_str()), Duration::from_millis(200)).err().unwrap();
        assert!(matches!(&error, ClientError::NobodyListens { .. }), "{error}");
        assert!(error.to_string().starts_with(&format!("no daemon listens at {endpoint}: ")), "{error}");
    }
}
