//! Where a daemon is, and how this client proves who it is.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use zenoh::config::EndPoint;
use zenoh::{Config, Session, Wait};

use crate::error::ClientError;
use crate::loss::{Answer, knock};

/// Between two attempts to connect.
const RETRY: Duration = Duration::from_millis(50);
/// Least and most time for one attempt: who hangs does not say no.
const ATTEMPT: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(10)];

/// Certificates by which client and daemon know each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tls {
    /// Certificate of the authority that has signed the daemon's.
    pub authority: PathBuf,
    /// This client's.
    pub certificate: PathBuf,
    /// Its key.
    pub key: PathBuf,
}

impl Tls {
    /// The folder of one client that `sturz certs` has made, such as `lab/clients/alice`.
    ///
    /// # Errors
    /// [`ClientError::NoCertificate`] where a file is missing.
    pub fn from_folder(folder: impl AsRef<Path>) -> Result<Self, ClientError> {
        let file = |name: &str| {
            let path = folder.as_ref().join(name);
            if path.is_file() { Ok(path) } else { Err(ClientError::NoCertificate { path }) }
        };
        Ok(Self { authority: file("ca.pem")?, certificate: file("certificate.pem")?, key: file("key.pem")? })
    }
}

/// Where a daemon is, and how this client comes in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    pub(crate) endpoint: String,
    pub(crate) tls: Option<Tls>,
    file: Option<PathBuf>,
}

impl Target {
    /// An endpoint such as `tcp/127.0.0.1:7447`.
    pub fn new(endpoint: impl Into<String>) -> Self {
        Self { endpoint: endpoint.into(), tls: None, file: None }
    }

    /// With a certificate, for an endpoint such as `tls/host:7447`.
    pub fn with_tls(self, tls: Tls) -> Self {
        Self { tls: Some(tls), ..self }
    }

    /// With a zenoh configuration file to start from.
    pub fn with_config(self, file: impl Into<PathBuf>) -> Self {
        Self { file: Some(file.into()), ..self }
    }

    /// Mode client: two peers cannot reach each other through the daemon. Discovery is off: it would find others.
    pub(crate) fn config(&self, patience: Duration) -> Result<Config, ClientError> {
        let mut config = match &self.file {
            None => Config::default(),
            Some(path) => Config::from_file(path)
                .map_err(|error| ClientError::bus(&format!("configuration {}", path.display()), error))?,
        };
        let mut set =
            |key: &str, json5: &str| config.insert_json5(key, json5).map_err(|error| ClientError::bus(key, error));
        set("mode", r#""client""#)?;
        set("connect/endpoints", &format!("[{:?}]", self.endpoint))?;
        set("connect/exit_on_failure", "true")?;
        set("connect/timeout_ms", "0")?;
        set("scouting/multicast/enabled", "false")?;
        set("scouting/gossip/enabled", "false")?;
        set("transport/unicast/open_timeout", &patience.as_millis().to_string())?;
        if let Some(Tls { authority, certificate, key }) = &self.tls {
            let text = format!(
                "{{root_ca_certificate: {authority:?}, enable_mtls: true, connect_certificate: {certificate:?}, connect_private_key: {key:?}}}"
            );
            set("transport/link/tls", &text)?;
        }
        Ok(config)
    }

    /// A session with whoever listens there; tries until `deadline`.
    pub(crate) fn open(&self, deadline: Instant) -> Result<Session, ClientError> {
        let endpoint = &self.endpoint;
        let parsed = endpoint.parse::<EndPoint>();
        parsed
            .map_err(|error| ClientError::InvalidEndpoint { endpoint: endpoint.into(), reason: error.to_string() })?;
        loop {
            let patience = deadline.saturating_duration_since(Instant::now()).clamp(ATTEMPT[0], ATTEMPT[1]);
            let config = self.config(patience)?;
            let started = Instant::now();
            let reason = match zenoh::open(config).wait() {
                Ok(session) => return Ok(session),
                Err(reason) => reason.to_string(),
            };
            let said_no = started.elapsed() < patience;
            // A daemon that was just started may not listen yet.
            if Instant::now() + RETRY < deadline {
                thread::sleep(RETRY);
                continue;
            }
            let endpoint = endpoint.clone();
            return Err(match knock(&endpoint) {
                Answer::Listens if said_no => ClientError::TurnedAway { endpoint, has_certificate: self.tls.is_some() },
                Answer::Listens => ClientError::Silent { endpoint },
                Answer::Refuses | Answer::Unknown => ClientError::NobodyListens { endpoint, reason },
                Answer::Unreachable(reason) => ClientError::NobodyListens { endpoint, reason },
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discovery_is_off_and_the_mode_is_client() {
        let config = Target::new("tcp/127.0.0.1:7447").config(ATTEMPT[0]).unwrap();
        assert_eq!(config.get_json("mode").unwrap(), r#""client""#);
        for key in ["scouting/multicast/enabled", "scouting/gossip/enabled"] {
            assert_eq!(config.get_json(key).unwrap(), "false");
        }
        assert!(config.get_json("connect/endpoints").unwrap().contains("tcp/127.0.0.1:7447"));
    }

    #[test]
    fn a_folder_without_a_certificate_says_which_file_is_missing() {
        let error = Tls::from_folder("nowhere").unwrap_err().to_string();
        assert!(error.contains("nowhere/ca.pem") && error.contains("sturz certs"), "{error}");
    }
}
