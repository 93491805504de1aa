//! Why a daemon is gone, as far as it can be known from here.

use std::fmt;
use std::io::ErrorKind;
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::{Duration, Instant};

use zenoh::Wait as _;

use crate::target::Target;

/// To reach the other machine.
const KNOCK: Duration = Duration::from_secs(2);
/// For its daemon to answer: one that hangs is given up by the bus only after its lease, so it has had its time.
const PROBE: Duration = Duration::from_secs(3);

/// Why a daemon is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// It has ended or was killed: nobody listens there any more, or who does does not know it.
    Died,
    /// Its machine takes connections for it, and it answers nothing: it is stopped, or swamped.
    Hung,
    /// Its machine cannot be reached.
    Unreachable,
    /// It lives, and does not let this client in any more: its certificate has run out, or others have taken its place.
    Denied,
    /// It lives: the connection broke, or was given up while this program was stopped.
    Broken,
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Loss::Died => "it has ended or was killed",
            Loss::Hung => "it hangs: its machine takes connections, and it answers nothing",
            Loss::Unreachable => "its machine cannot be reached",
            Loss::Denied => "it lives, and does not let this client in any more",
            Loss::Broken => "it lives, and the connection broke: `reconnect` goes on",
        })
    }
}

/// What the operating system says of an endpoint.
pub(crate) enum Answer {
    /// Somebody listens there.
    Listens,
    /// The machine is there, and nobody listens.
    Refuses,
    /// No way to it, and why.
    Unreachable(String),
    /// Not a matter of TCP.
    Unknown,
}

/// Knocks at an endpoint such as `tls/host:7447`, without a word of zenoh.
pub(crate) fn knock(endpoint: &str) -> Answer {
    let Some((protocol, address)) = endpoint.split_once('/') else { return Answer::Unknown };
    if !matches!(protocol, "tcp" | "tls") {
        return Answer::Unknown;
    }
    let address = address.split(['?', '#']).next().unwrap_or_default();
    let addresses = match address.to_socket_addrs() {
        Ok(addresses) => addresses,
        Err(error) => return Answer::Unreachable(error.to_string()),
    };
    let mut answer = Answer::Unknown;
    for address in addresses {
        match TcpStream::connect_timeout(&address, KNOCK) {
            Ok(_) => return Answer::Listens,
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => answer = Answer::Refuses,
            Err(error) => answer = Answer::Unreachable(error.to_string()),
        }
    }
    answer
}

/// Finds out why the instance with this liveliness token is gone.
pub(crate) fn diagnose(target: &Target, alive: &str) -> Loss {
    match knock(&target.endpoint) {
        Answer::Refuses => return Loss::Died,
        Answer::Unreachable(_) => return Loss::Unreachable,
        Answer::Listens | Answer::Unknown => {}
    }
    let Ok(config) = target.config(PROBE) else { return Loss::Broken };
    let started = Instant::now();
    let Ok(session) = zenoh::open(config).wait() else {
        // A process that ends may have taken the first knock and nothing after it.
        return match (started.elapsed() < PROBE, knock(&target.endpoint)) {
            (_, Answer::Refuses) => Loss::Died,
            (true, _) => Loss::Denied,
            (false, _) => Loss::Hung,
        };
    };
    let is_there = match session.liveliness().get(alive).timeout(PROBE).wait() {
        Ok(replies) => replies.recv().is_ok_and(|reply| reply.result().is_ok()),
        Err(_) => false,
    };
    if is_there { Loss::Broken } else { Loss::Died }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    #[test]
    fn a_knock_tells_a_listener_from_a_closed_port() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("tcp/{}", listener.local_addr().unwrap());
        assert!(matches!(knock(&format!("{endpoint}#iface=lo")), Answer::Listens));
        drop(listener);
        assert!(matches!(knock(&endpoint), Answer::Refuses));
        assert!(matches!(knock("unixsock-stream/a"), Answer::Unknown));
        assert!(matches!(knock("tcp/no-such-host.invalid:1"), Answer::Unreachable(_)));
    }

    /// A listener that never answers is what a stopped process looks like.
    #[test]
    fn silence_is_told_from_absence() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let target = Target::new(format!("tcp/{}", listener.local_addr().unwrap()));
        assert_eq!(diagnose(&target, "sturz/v1/a/alive"), Loss::Hung);
        drop(listener);
        assert_eq!(diagnose(&target, "sturz/v1/a/alive"), Loss::Died);
    }
}
