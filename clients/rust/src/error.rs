//! What can go wrong between this program and the daemon.

use std::path::PathBuf;
use std::time::Duration;

use sturz_protocol::columns::ColumnError;
use sturz_protocol::keys::InvalidName;
use sturz_protocol::v1;
use thiserror::Error;

use crate::loss::Loss;

/// Why there is no answer, or why it is no.
#[derive(Debug, Error)]
pub enum ClientError {
    /// Of an instance or a field.
    #[error(transparent)]
    InvalidName(#[from] InvalidName),
    /// Not such as `tcp/127.0.0.1:7447`.
    #[error("{endpoint:?} is no endpoint, such as `tcp/127.0.0.1:7447`: {reason}")]
    InvalidEndpoint {
        /// As given.
        endpoint: String,
        /// As zenoh says.
        reason: String,
    },
    /// Nothing is there to connect to.
    #[error("no daemon listens at {endpoint}: start one with `sturz serve`, or give another endpoint ({reason})")]
    NobodyListens {
        /// Where.
        endpoint: String,
        /// As zenoh says.
        reason: String,
    },
    /// There is a bus, and no such simulation on it.
    #[error("no simulation {instance:?} is alive at {endpoint}; {}", alive_text(.alive))]
    NoSuchInstance {
        /// As asked for.
        instance: String,
        /// Where.
        endpoint: String,
        /// Those that are.
        alive: Vec<String>,
    },
    /// It was there, and is no more.
    #[error("the daemon of {instance:?} at {endpoint} is gone: {loss}")]
    DaemonGone {
        /// Its name.
        instance: String,
        /// Where it was.
        endpoint: String,
        /// Why, as far as it can be known.
        loss: Loss,
    },
    /// Somebody listens there, and opens no session.
    #[error("{endpoint} turns this client away: {}", turned_away_text(*.has_certificate, .endpoint))]
    TurnedAway {
        /// Where.
        endpoint: String,
        /// Whether this client has shown one.
        has_certificate: bool,
    },
    /// Connections are taken there, and nothing is answered.
    #[error("{endpoint} takes connections and answers nothing: the daemon hangs, or it is none")]
    Silent {
        /// Where.
        endpoint: String,
    },
    /// A session, and not one daemon to be seen.
    #[error(
        "{endpoint} shows this client nothing, not even whether {instance:?} is there: the name in its certificate has no role with the daemon (`sturz certs`)"
    )]
    NothingToSee {
        /// As asked for.
        instance: String,
        /// Where.
        endpoint: String,
    },
    /// This client may look, and not do that.
    #[error("{what}: the role of this client does not allow it")]
    Denied {
        /// What was asked, such as `cmd/stop`.
        what: String,
    },
    /// No folder of a client.
    #[error("{} is missing: give the folder of one client, such as lab/clients/alice, which `sturz certs` makes", .path.display())]
    NoCertificate {
        /// What is not there.
        path: PathBuf,
    },
    /// No answer in time. A command may have been applied: the same request with the same id finds out.
    #[error("{what}: nothing came within {} s{}", .after.as_secs_f64(), request_text(.request_id.as_deref()))]
    Timeout {
        /// What was asked, such as `cmd/set_gravity`.
        what: String,
        /// How long it was waited for.
        after: Duration,
        /// Of a command.
        request_id: Option<String>,
    },
    /// The daemon lives, and nobody answers there.
    #[error("{what}: the daemon gave no answer: it does not know the key, or is flooded")]
    NoAnswer {
        /// What was asked.
        what: String,
    },
    /// The daemon said no; its state is as it was.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// An answer that this client cannot read: perhaps of a newer daemon.
    #[error("{what}: cannot read the answer: {reason}")]
    Unreadable {
        /// What was asked.
        what: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A column that was not asked for.
    #[error("no column {name:?} was asked for; there are {there:?}")]
    ColumnMissing {
        /// As asked for.
        name: String,
        /// Those that were sent.
        there: Vec<String>,
    },
    /// A column of another kind, such as a scalar read as a vector.
    #[error("column {name:?} {error}")]
    Column {
        /// Its name.
        name: String,
        /// What is wrong with it.
        #[source]
        error: ColumnError,
    },
    /// A column that is longer or shorter than the others.
    #[error("column {name:?} has {rows} rows instead of {needed}")]
    ColumnRows {
        /// Its name.
        name: String,
        /// As sent.
        rows: usize,
        /// As the message says.
        needed: usize,
    },
    /// The bus itself failed.
    #[error("{what}: {reason}")]
    Bus {
        /// What was tried.
        what: String,
        /// As zenoh says.
        reason: String,
    },
}

/// What the daemon answers when it says no.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{command} refused ({}{}): {message}", code_text(*.code), path_text(.path))]
pub struct Refusal {
    /// What was asked, such as `set_gravity` or `state/latest`.
    pub command: String,
    /// Why not.
    pub code: v1::ErrorCode,
    /// Into the request, such as `placement.random.count`; empty when there is none.
    pub path: String,
    /// What is wrong, and what would be right.
    pub message: String,
    /// Steps done when it was refused; `None` for questions.
    pub step: Option<u64>,
}

impl Refusal {
    /// From the wire.
    pub(crate) fn new(command: &str, error: v1::Error, step: Option<u64>) -> Self {
        Self { command: command.into(), code: error.code(), path: error.path, message: error.message, step }
    }
}

impl ClientError {
    /// Why the daemon refused, if that is what happened.
    pub fn refusal(&self) -> Option<&Refusal> {
        match self {
            ClientError::Refused(refusal) => Some(refusal),
            _ => None,
        }
    }

    /// Whether this client was refused for who it is.
    pub fn is_denial(&self) -> bool {
        match self {
            ClientError::Denied { .. } | ClientError::TurnedAway { .. } | ClientError::NothingToSee { .. } => true,
            ClientError::DaemonGone { loss, .. } => *loss == Loss::Denied,
            _ => false,
        }
    }

    /// An answer that is no such message.
    pub(crate) fn unreadable(what: &str, reason: impl ToString) -> Self {
        ClientError::Unreadable { what: what.into(), reason: reason.to_string() }
    }

    /// Trouble of zenoh's own.
    pub(crate) fn bus(what: &str, reason: impl ToString) -> Self {
        ClientError::Bus { what: what.into(), reason: reason.to_string() }
    }
}

fn turned_away_text(has_certificate: bool, endpoint: &str) -> &'static str {
    match (endpoint.starts_with("tls/"), has_certificate) {
        (false, _) => "it is no Sturz daemon, or has as many clients as its limit `clients` allows",
        (true, false) => "it wants a certificate of its authority, and none was given",
        (true, true) => {
            "the certificate, or the daemon's, is of another authority, for another host or out of date; or it has as many clients as its limit `clients` allows"
        }
    }
}

fn alive_text(alive: &[String]) -> String {
    match alive {
        [] => "there is none".into(),
        names => format!("there are: {}", names.join(", ")),
    }
}

fn request_text(request_id: Option<&str>) -> String {
    request_id.map_or_else(String::new, |id| format!(" (request id {id:?})"))
}

fn code_text(code: v1::ErrorCode) -> &'static str {
    let name = code.as_str_name();
    name.strip_prefix("ERROR_CODE_").unwrap_or(name)
}

fn path_text(path: &str) -> String {
    if path.is_empty() { String::new() } else { format!(" at {path}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_says_what_where_and_why() {
        let error = v1::Error {
            code: v1::ErrorCode::InvalidInput.into(),
            path: "steps".into(),
            message: "is 0, must be at least 1".into(),
        };
        let refusal = Refusal::new("step", error.clone(), Some(7));
        assert_eq!(refusal.to_string(), "step refused (INVALID_INPUT at steps): is 0, must be at least 1");
        assert_eq!(refusal.step, Some(7));
        let nowhere = Refusal::new("step", v1::Error { path: String::new(), ..error }, None);
        assert_eq!(nowhere.to_string(), "step refused (INVALID_INPUT): is 0, must be at least 1");
    }

    #[test]
    fn a_code_of_a_newer_daemon_leaves_its_text() {
        let error = v1::Error { code: 4711, path: String::new(), message: "the moon is full".into() };
        let refusal = Refusal::new("step", error, None);
        assert_eq!(refusal.to_string(), "step refused (UNSPECIFIED): the moon is full");
    }

    #[test]
    fn who_is_alive_is_told() {
        let missing = |alive: &[&str]| {
            let alive = alive.iter().map(ToString::to_string).collect();
            ClientError::NoSuchInstance { instance: "a".into(), endpoint: "tcp/h:1".into(), alive }.to_string()
        };
        assert_eq!(missing(&["b", "c"]), "no simulation \"a\" is alive at tcp/h:1; there are: b, c");
        assert_eq!(missing(&[]), "no simulation \"a\" is alive at tcp/h:1; there is none");
    }

    #[test]
    fn a_timeout_names_the_request_to_repeat() {
        let request_id = Some("12".into());
        let error = ClientError::Timeout { what: "cmd/stop".into(), after: Duration::from_millis(1500), request_id };
        assert_eq!(error.to_string(), "cmd/stop: nothing came within 1.5 s (request id \"12\")");
    }
}
