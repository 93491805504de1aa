//! What other machines can reach.

use std::io::Write as _;

use anyhow::anyhow;
use serde_json::Value;
use zenoh::Config;

use crate::config::Bus;

impl Bus {
    /// Refuses endpoints that other machines can reach, unless these need a certificate there, or it is wanted: whoever
    /// reaches the others can steer.
    ///
    /// # Errors
    /// The endpoint, and what to do.
    pub fn check_exposure(&self, insecure: bool) -> anyhow::Result<()> {
        let config = self.daemon_config()?;
        let (listed, connected) = (setting(&config, "listen/endpoints")?, setting(&config, "connect/endpoints")?);
        let mut all = endpoints(&listed);
        all.extend(endpoints(&connected));
        if self.tls.is_some()
            && let Some(plain) = all.iter().find(|endpoint| !endpoint.starts_with("tls/"))
        {
            return Err(anyhow!("--tls: every endpoint must be one of TLS, such as tls/0.0.0.0:7447; {plain} is not"));
        }
        let is_guarded = asks_for_certificates(&config);
        let exposed =
            all.iter().find(|endpoint| !(is_loopback(endpoint) || is_guarded && endpoint.starts_with("tls/")));
        match exposed {
            Some(endpoint) if insecure => {
                warn(&format!("--insecure: whoever reaches {endpoint} can steer this simulation, and end it"));
                Ok(())
            }
            Some(endpoint) => Err(anyhow!(
                "other machines can reach {endpoint}, and whoever does can steer: listen on tcp/127.0.0.1:PORT, ask for certificates by --tls (see `sturz certs`), or allow it with --insecure"
            )),
            None if insecure => {
                warn("--insecure is not needed: only this machine, or whoever has a certificate, reaches this daemon");
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Whether some clients may do less than others, which shows as questions without an answer.
    pub fn controls_access(&self) -> bool {
        let enabled = self.daemon_config().and_then(|config| setting(&config, "access_control/enabled"));
        enabled.is_ok_and(|enabled| enabled == Value::Bool(true))
    }
}

/// Said at each start, whatever the log filter.
pub fn warn(text: &str) {
    // Not by `eprintln!`, which ends a daemon whose standard error is on a full disk.
    drop(writeln!(std::io::stderr(), "sturz: warning: {text}"));
}

fn setting(config: &Config, key: &str) -> anyhow::Result<Value> {
    let json = config.get_json(key).map_err(|error| anyhow!("{key}: {error}"))?;
    Ok(serde_json::from_str(&json)?)
}

/// Whether TLS asks clients for a certificate, and access control denies by default.
fn asks_for_certificates(config: &Config) -> bool {
    let is = |key: &str, wanted: Value| setting(config, key).is_ok_and(|value| value == wanted);
    is("transport/link/tls/enable_mtls", true.into())
        && is("access_control/enabled", true.into())
        && is("access_control/default_permission", "deny".into())
}

/// All strings of a zenoh endpoint setting: a list, or a list per mode.
fn endpoints(value: &Value) -> Vec<&str> {
    match value {
        Value::String(endpoint) => vec![endpoint],
        Value::Array(list) => list.iter().flat_map(endpoints).collect(),
        Value::Object(modes) => modes.get("peer").map(endpoints).unwrap_or_default(),
        _ => Vec::new(),
    }
}

/// Whether only this machine can reach an endpoint such as `tcp/127.0.0.1:7447`.
fn is_loopback(endpoint: &str) -> bool {
    let Some((protocol, address)) = endpoint.split_once('/') else {
        return false;
    };
    if protocol.starts_with("unix") {
        return true;
    }
    let host =
        address.split(['?', '#']).next().and_then(|address| address.rsplit_once(':')).map_or("", |(host, _)| host);
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || host.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::config::ServerTls;
    use crate::security::authority::{Wanted, client, make};

    fn lab(folder: &Path) -> ServerTls {
        let wanted = Wanted { clients: vec![client("alice:view").unwrap()], days: 3, ..Wanted::default() };
        make(folder, &wanted).unwrap();
        ServerTls::open(folder, "a").unwrap()
    }

    #[test]
    fn only_loopback_goes_without_saying() {
        for endpoint in ["auto", "tcp/127.0.0.1:7447", "tcp/localhost:0", "tcp/[::1]:7447", "tcp/127.0.0.1:1#iface=lo"]
        {
            let bus = Bus { listen: vec![endpoint.into()], ..Bus::default() };
            assert!(bus.check_exposure(false).is_ok(), "{endpoint}");
        }
        for endpoint in
            ["tcp/0.0.0.0:7447", "tcp/[::]:7447", "tcp/192.0.2.1:7447", "tcp/example.org:1", "tls/0.0.0.0:7447"]
        {
            let bus = Bus { listen: vec!["auto".into(), endpoint.into()], ..Bus::default() };
            assert!(bus.check_exposure(false).unwrap_err().to_string().contains(endpoint));
            assert!(bus.check_exposure(true).is_ok());
        }
        // Zenoh's own default is every interface.
        assert!(Bus::default().check_exposure(false).is_err());
    }

    #[test]
    fn a_router_elsewhere_is_an_exposure_too() {
        let bus = |connect: &str| Bus { listen: vec!["auto".into()], connect: vec![connect.into()], ..Bus::default() };
        assert!(bus("tcp/127.0.0.1:7447").check_exposure(false).is_ok());
        let error = bus("tcp/192.0.2.1:7447").check_exposure(false).unwrap_err().to_string();
        assert!(error.contains("tcp/192.0.2.1:7447"), "{error}");
    }

    #[test]
    fn certificates_open_the_other_interfaces_and_no_plain_endpoint_stays_beside() {
        let folder = tempfile::tempdir().unwrap();
        let tls = lab(folder.path());
        let bus = |listen: &str| Bus { listen: vec![listen.into()], tls: Some(tls.clone()), ..Bus::default() };
        bus("tls/0.0.0.0:7447").check_exposure(false).unwrap();
        bus("auto").check_exposure(false).unwrap();
        let error = bus("tcp/127.0.0.1:7447").check_exposure(false).unwrap_err().to_string();
        assert!(error.contains("tcp/127.0.0.1:7447 is not"), "{error}");
    }
}
