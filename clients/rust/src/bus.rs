//! The zenoh session with one daemon: questions that get an answer or a reason why not, and subscriptions. Callbacks
//! of zenoh only enqueue: a call to the bus from inside one can hang.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use prost::Message as _;
use sturz_protocol::keys::{ALL_ALIVE, Keys};
use sturz_protocol::v1;
use zenoh::config::EndPoint;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::qos::CongestionControl;
use zenoh::query::{ConsolidationMode, Reply};
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Config, Session, Wait};
use zenoh_ext::{AdvancedSubscriber, AdvancedSubscriberBuilderExt, HistoryConfig, Miss, RecoveryConfig};

use crate::error::{ClientError, Refusal};
use crate::queue::{End, Popped, Queue};
use crate::watch::Watch;

/// Longer than any run; zenoh wants a number.
const NO_LIMIT: Duration = Duration::from_secs(10_000_000);
/// Zenoh's clock runs out after ours, which says more.
const GRACE: Duration = Duration::from_secs(5);
/// A daemon that goes ends its queries some moments before its liveliness is lost.
const LAST_MOMENTS: Duration = Duration::from_secs(1);
/// Between two attempts to connect.
const RETRY: Duration = Duration::from_millis(50);
/// How long to look for other instances.
const SEARCH: Duration = Duration::from_secs(2);

/// One session with one daemon.
pub(crate) struct Bus {
    /// Where everything is.
    pub(crate) keys: Keys,
    /// Where the daemon listens.
    pub(crate) endpoint: String,
    /// Whether it lives.
    pub(crate) watch: Arc<Watch>,
    _liveliness: Subscriber<()>,
    session: Session,
}

/// A question on its way, and its answer.
pub(crate) struct Question {
    what: String,
    /// One payload, of an answer (`Ok`) or of an error reply.
    answers: Arc<Queue<Result<Vec<u8>, Vec<u8>>>>,
}

/// A declared subscription; dropping it ends it.
pub(crate) enum Subscription {
    /// From now on.
    Live(#[allow(dead_code)] Subscriber<()>),
    /// Recent past first.
    WithHistory(#[allow(dead_code)] AdvancedSubscriber<()>),
}

impl Bus {
    /// Connects, and waits for the instance's liveliness token.
    pub(crate) fn open(instance: &str, endpoint: &str, patience: Duration) -> Result<Self, ClientError> {
        let keys = Keys::new(instance)?;
        let deadline = Instant::now() + patience;
        let session = open_session(endpoint, deadline)?;
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
        if !watch.wait_until_seen(deadline.saturating_duration_since(Instant::now()).max(RETRY)) {
            let alive = instances(&session)?;
            return Err(ClientError::NoSuchInstance { instance: instance.into(), endpoint: endpoint.into(), alive });
        }
        Ok(Self { keys, endpoint: endpoint.into(), watch, _liveliness: liveliness, session })
    }

    /// Of this session, unique on the bus.
    pub(crate) fn session_id(&self) -> String {
        self.session.zid().to_string()
    }

    /// Declares a liveliness token, which vanishes with this session.
    pub(crate) fn declare_token(&self, key: &str) -> Result<LivelinessToken, ClientError> {
        self.session.liveliness().declare_token(key).wait().map_err(|error| ClientError::bus(&topic(key), error))
    }

    /// What to say when the daemon is no longer there.
    pub(crate) fn gone(&self) -> ClientError {
        ClientError::DaemonGone { instance: self.keys.instance().into(), endpoint: self.endpoint.clone() }
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
        query.callback(move |reply| receiver.take(reply)).wait().map_err(|error| ClientError::bus(&what, error))?;
        self.watch.end_with_daemon(&answers);
        Ok(Question { what, answers })
    }

    /// Waits for the answer to a question.
    pub(crate) fn answer(&self, question: &Question, patience: Option<Duration>) -> Result<Vec<u8>, ClientError> {
        let what = &question.what;
        match question.answers.pop(patience.map(|patience| Instant::now() + patience)) {
            Popped::Item(Ok(payload)) => Ok(payload),
            Popped::Item(Err(payload)) => match v1::Error::decode(payload.as_slice()) {
                Ok(error) => Err(Refusal::new(what, error, None).into()),
                Err(_) => Err(ClientError::bus(what, String::from_utf8_lossy(&payload))),
            },
            Popped::Ended if self.watch.wait_until_gone(LAST_MOMENTS) => Err(self.gone()),
            Popped::Ended => Err(ClientError::NoAnswer { what: what.clone() }),
            Popped::TimedOut => {
                Err(ClientError::Timeout { what: what.clone(), after: patience.unwrap_or(NO_LIMIT), request_id: None })
            }
        }
    }

    /// Calls `receive`, which must not wait, with every payload published under `key` from now on.
    pub(crate) fn subscribe(
        &self,
        key: &str,
        receive: impl Fn(Vec<u8>) + Send + Sync + 'static,
    ) -> Result<Subscription, ClientError> {
        self.check()?;
        let take = move |sample: Sample| receive(sample.payload().to_bytes().into_owned());
        let declared = self.session.declare_subscriber(key).callback(take).wait();
        declared.map(Subscription::Live).map_err(|error| ClientError::bus(&topic(key), error))
    }

    /// The same, with the recent past first; lost payloads are asked for again, and `missed`, which must not wait, is told
    /// how many could not be had.
    pub(crate) fn subscribe_with_history(
        &self,
        key: &str,
        receive: impl Fn(Vec<u8>) + Send + Sync + 'static,
        missed: impl Fn(u64) + Send + Sync + 'static,
    ) -> Result<Subscription, ClientError> {
        self.check()?;
        let take = move |sample: Sample| receive(sample.payload().to_bytes().into_owned());
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
        declared.map_err(|error| ClientError::bus(&topic(key), error))
    }

    fn check(&self) -> Result<(), ClientError> {
        if self.watch.is_gone() { Err(self.gone()) } else { Ok(()) }
    }
}

/// Puts replies into a queue, and ends it when zenoh drops it: then all replies are there.
struct Receiver(Arc<Queue<Result<Vec<u8>, Vec<u8>>>>);

impl Receiver {
    fn take(&self, reply: Reply) {
        self.0.push(match reply.result() {
            Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
            Err(error) => Err(error.payload().to_bytes().into_owned()),
        });
    }
}

impl Drop for Receiver {
    fn drop(&mut self) {
        self.0.end();
    }
}

/// `state/latest` of `sturz/v1/drum/state/latest?columns=ids`.
fn topic(selector: &str) -> String {
    let key = selector.split('?').next().unwrap_or_default();
    key.splitn(4, '/').nth(3).unwrap_or(key).into()
}

fn open_session(endpoint: &str, deadline: Instant) -> Result<Session, ClientError> {
    let parsed = endpoint.parse::<EndPoint>();
    parsed.map_err(|error| ClientError::InvalidEndpoint { endpoint: endpoint.into(), reason: error.to_string() })?;
    let config = config(endpoint)?;
    loop {
        match zenoh::open(config.clone()).wait() {
            Ok(session) => return Ok(session),
            // A daemon that was just started may not listen yet.
            Err(_) if Instant::now() + RETRY < deadline => thread::sleep(RETRY),
            Err(error) => {
                return Err(ClientError::NobodyListens { endpoint: endpoint.into(), reason: error.to_string() });
            }
        }
    }
}

/// Mode client: two peers cannot reach each other through the daemon. Discovery is off: it would find others.
fn config(endpoint: &str) -> Result<Config, ClientError> {
    let mut config = Config::default();
    for (key, json5) in [
        ("mode", r#""client""#),
        ("connect/endpoints", &format!("[{endpoint:?}]")),
        ("connect/exit_on_failure", "true"),
        ("connect/timeout_ms", "0"),
        ("scouting/multicast/enabled", "false"),
        ("scouting/gossip/enabled", "false"),
    ] {
        config.insert_json5(key, json5).map_err(|error| ClientError::bus(key, error))?;
    }
    Ok(config)
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
    fn discovery_is_off_and_the_mode_is_client() {
        let config = config("tcp/127.0.0.1:7447").unwrap();
        assert_eq!(config.get_json("mode").unwrap(), r#""client""#);
        for key in ["scouting/multicast/enabled", "scouting/gossip/enabled"] {
            assert_eq!(config.get_json(key).unwrap(), "false");
        }
        assert!(config.get_json("connect/endpoints").unwrap().contains("tcp/127.0.0.1:7447"));
    }

    #[test]
    fn nonsense_is_refused_before_anything_is_tried() {
        let open = |name, endpoint| Bus::open(name, endpoint, Duration::from_secs(60)).err().unwrap();
        assert!(matches!(open("a/b", "tcp/127.0.0.1:7447"), ClientError::InvalidName(_)));
        assert!(matches!(open("a", "somewhere"), ClientError::InvalidEndpoint { .. }));
    }

    #[test]
    fn an_endpoint_where_nobody_listens_is_named() {
        // Bound and dropped: the port was free a moment ago.
        let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let endpoint = format!("tcp/127.0.0.1:{port}");
        let error = Bus::open("a", &endpoint, Duration::from_millis(200)).err().unwrap();
        assert!(matches!(&error, ClientError::NobodyListens { .. }), "{error}");
        assert!(error.to_string().starts_with(&format!("no daemon listens at {endpoint}: ")), "{error}");
    }
}
