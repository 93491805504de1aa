//! What the daemon refuses to exceed, and how it sits on the bus.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow};
use serde::{Deserialize, Serialize};
use serde_json::json;
use sturz_protocol::v1;

use crate::security::SecurityError;
use crate::security::access;
use crate::security::folder::{Identity, Roles};

/// Where a daemon listens unless told otherwise.
pub const DEFAULT_LISTEN: &str = "tcp/127.0.0.1:7447";

/// `--listen auto`: a free port of the loopback interface.
const AUTO_LISTEN: &str = "tcp/127.0.0.1:0";
/// The same where certificates are asked for.
pub const DEFAULT_LISTEN_TLS: &str = "tls/127.0.0.1:7447";
const AUTO_LISTEN_TLS: &str = "tls/127.0.0.1:0";

/// Bounds on what clients may ask for. A TOML file given with `--limits` may change them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Of one request. A hundred thousand poses take 5.6 MB.
    pub message_bytes: usize,
    /// Particles in one insertion.
    pub insertion_particles: u64,
    /// Particles in all.
    pub particles: u64,
    /// Requests waiting for the physics thread; twice as many may wait to be decoded.
    pub queue_length: usize,
    /// Requests not yet answered: windows under way and commands for later count here.
    pub open_requests: usize,
    /// Settled requests whose outcome is remembered.
    pub remembered_requests: usize,
    /// Fields defined at a time.
    pub fields: usize,
    /// Cells of one field.
    pub field_cells: u64,
    /// Events kept for those who come late.
    pub remembered_events: usize,
    /// Checkpoints in memory.
    pub checkpoints: usize,
    /// Of all checkpoints in memory together. A particle takes some 230 bytes, a contact some 130.
    pub checkpoint_bytes: u64,
    /// Checkpoints on disk.
    pub checkpoint_files: usize,
    /// Sessions of clients at a time.
    pub clients: usize,
    /// Pairs of parts that are near enough to be looked at in each step. One takes some 100 to 500 bytes.
    pub pairs: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            message_bytes: 64 << 20,
            insertion_particles: 100_000,
            particles: 1_000_000,
            queue_length: 256,
            open_requests: 1024,
            remembered_requests: 4096,
            fields: 64,
            field_cells: 4_000_000,
            remembered_events: 256,
            checkpoints: 16,
            checkpoint_bytes: 2 << 30,
            checkpoint_files: 100,
            clients: 256,
            pairs: 50_000_000,
        }
    }
}

impl Limits {
    /// Without bounds.
    pub fn none() -> Self {
        Self {
            message_bytes: usize::MAX,
            insertion_particles: u64::MAX,
            particles: u64::MAX,
            queue_length: usize::MAX,
            open_requests: usize::MAX,
            remembered_requests: usize::MAX,
            fields: usize::MAX,
            field_cells: u64::MAX,
            remembered_events: usize::MAX,
            checkpoints: usize::MAX,
            checkpoint_bytes: u64::MAX,
            checkpoint_files: usize::MAX,
            clients: usize::MAX,
            pairs: usize::MAX,
        }
    }

    /// The table of a TOML file; an empty one without a file.
    pub fn read(path: Option<&Path>) -> anyhow::Result<toml::Table> {
        let Some(path) = path else {
            return Ok(toml::Table::new());
        };
        let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        let table: toml::Table = toml::from_str(&text).with_context(|| format!("in {}", path.display()))?;
        Self::from_table(table.clone()).with_context(|| format!("in {}", path.display()))?;
        Ok(table)
    }

    /// From a table; defaults for what it lacks.
    ///
    /// # Errors
    /// It has other names, other types, or zeros where nothing would go.
    pub fn from_table(table: toml::Table) -> anyhow::Result<Self> {
        let limits: Self = table.try_into()?;
        let least = limits.queue_length.min(limits.open_requests).min(limits.remembered_events).min(limits.clients);
        if least == 0 {
            return Err(anyhow!("queue_length, open_requests, remembered_events and clients must be at least 1"));
        }
        Ok(limits)
    }

    /// For `features`.
    pub fn to_wire(&self) -> v1::Limits {
        v1::Limits {
            message_bytes: self.message_bytes as u64,
            insertion_particles: self.insertion_particles,
            particles: self.particles,
            queue_length: self.queue_length as u64,
            remembered_requests: self.remembered_requests as u64,
            fields: self.fields as u64,
            field_cells: self.field_cells,
            checkpoints: self.checkpoints as u64,
            checkpoint_bytes: self.checkpoint_bytes,
            checkpoint_files: self.checkpoint_files as u64,
            clients: self.clients as u64,
            pairs: self.pairs as u64,
            open_requests: self.open_requests as u64,
        }
    }
}

/// How a daemon or a client sits on the bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bus {
    /// Endpoints to listen on; `auto` for a free loopback port.
    pub listen: Vec<String>,
    /// Endpoints to connect to.
    pub connect: Vec<String>,
    /// A zenoh configuration file to start from.
    pub file: Option<PathBuf>,
    /// Certificates that a daemon asks for.
    pub tls: Option<ServerTls>,
    /// Certificates of a client.
    pub client_tls: Option<Identity>,
    /// Sessions that a daemon lets in; zenoh's default when absent.
    pub most_clients: Option<usize>,
}

/// What a daemon shows its clients, and what it lets them do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerTls {
    /// Its own certificate, and the authority of theirs.
    pub identity: Identity,
    /// What their names may do.
    pub roles: Roles,
    /// The daemon's name: whose keys they are about.
    pub instance: String,
}

impl ServerTls {
    /// From a folder that `sturz certs` made.
    pub fn open(folder: &Path, instance: &str) -> Result<Self, SecurityError> {
        let (identity, roles) = Identity::of_server(folder)?;
        Ok(Self { identity, roles, instance: instance.into() })
    }
}

impl Bus {
    /// Of a daemon: a peer that needs no router. Discovery is off, since two daemons that find each other by
    /// accident would answer for one another.
    pub fn daemon_config(&self) -> anyhow::Result<zenoh::Config> {
        let mut config = self.base()?;
        set(&mut config, "mode", &"peer")?;
        let auto = if self.tls.is_some() { AUTO_LISTEN_TLS } else { AUTO_LISTEN };
        let listen: Vec<&str> = self.listen.iter().map(|e| if e == "auto" { auto } else { e }).collect();
        if !listen.is_empty() {
            set(&mut config, "listen/endpoints", &listen)?;
        }
        set(&mut config, "listen/exit_on_failure", &true)?;
        set(&mut config, "listen/timeout_ms", &0)?;
        if !self.connect.is_empty() {
            set(&mut config, "connect/endpoints", &self.connect)?;
        }
        if let Some(most) = self.most_clients {
            set(&mut config, "transport/unicast/max_sessions", &(most + self.connect.len()))?;
        }
        if let Some(tls) = &self.tls {
            let Identity { authority, certificate, key } = &tls.identity;
            let setting = json!({
                "root_ca_certificate": authority,
                "enable_mtls": true,
                "listen_certificate": certificate,
                "listen_private_key": key,
                "connect_certificate": certificate,
                "connect_private_key": key,
                "close_link_on_expiration": true,
            });
            set(&mut config, "transport/link/tls", &setting)?;
            set(&mut config, "access_control", &access::control(&tls.instance, &tls.roles)?)?;
        }
        Ok(config)
    }

    /// Of a client of a daemon.
    pub fn client_config(&self) -> anyhow::Result<zenoh::Config> {
        let mut config = self.base()?;
        set(&mut config, "mode", &"client")?;
        set(&mut config, "connect/endpoints", &self.connect)?;
        set(&mut config, "connect/exit_on_failure", &true)?;
        set(&mut config, "connect/timeout_ms", &0)?;
        if let Some(Identity { authority, certificate, key }) = &self.client_tls {
            let setting = json!({
                "root_ca_certificate": authority,
                "enable_mtls": true,
                "connect_certificate": certificate,
                "connect_private_key": key,
            });
            set(&mut config, "transport/link/tls", &setting)?;
        }
        Ok(config)
    }

    fn base(&self) -> anyhow::Result<zenoh::Config> {
        let mut config = match &self.file {
            Some(path) => zenoh::Config::from_file(path).map_err(|error| anyhow!("{}: {error}", path.display()))?,
            None => zenoh::Config::default(),
        };
        set(&mut config, "scouting/multicast/enabled", &false)?;
        set(&mut config, "scouting/gossip/enabled", &false)?;
        Ok(config)
    }
}

fn set<T: serde::Serialize + ?Sized>(config: &mut zenoh::Config, key: &str, value: &T) -> anyhow::Result<()> {
    let json = serde_json::to_string(value).context("plain values are JSON")?;
    config.insert_json5(key, &json).map_err(|error| anyhow!("zenoh configuration {key} = {json}: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discovery_is_off_and_auto_is_a_loopback_port() {
        let bus = Bus { listen: vec!["auto".into()], ..Bus::default() };
        let config = bus.daemon_config().unwrap();
        for key in ["scouting/multicast/enabled", "scouting/gossip/enabled"] {
            assert_eq!(config.get_json(key).unwrap(), "false");
        }
        assert!(config.get_json("listen/endpoints").unwrap().contains("tcp/127.0.0.1:0"));
        assert_eq!(config.get_json("mode").unwrap(), "\"peer\"");
    }

    #[test]
    fn limits_refuse_unknown_keys() {
        let limits: Limits = toml::from_str("particles = 5").unwrap();
        assert_eq!(limits, Limits { particles: 5, ..Limits::default() });
        assert!(toml::from_str::<Limits>("partickles = 5").is_err());
    }
}
