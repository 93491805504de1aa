//! Who may come in, against the real daemon: certificates, roles, and what other machines can reach.

mod common;

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Daemon, SOON, binary, folder, scene, sturz};
use sturz_client::v1::{EventKind, RunState};
use sturz_client::{ClientError, FloatType, Simulation, Target, Tls};
use sturz_protocol::keys::{Keys, Verb};
use zenoh::{Session, Wait as _};

/// No message of the schema: a daemon that gets it says so, and does nothing.
const RUBBISH: &[u8] = &[0xff; 4];

/// Connections over TLS break by themselves now and then (docs/service.md), whoever they are of: what a test shows, refusals
/// included, must hold in one try from its start to its end.
fn in_a_few_tries(test: impl Fn() + std::panic::RefUnwindSafe) {
    for _ in 0..4 {
        if std::panic::catch_unwind(&test).is_ok() {
            return;
        }
    }
    test();
}

/// Makes a lab with these clients, `NAME:ROLE`.
fn lab(name: &str, more: &[&str]) -> PathBuf {
    let lab = folder(name).join("lab");
    let clients = ["--client", "eve:view", "--client", "sam:steer", "--client", "ada:admin", "--client", "rex:admin"];
    let made = sturz(&[&["certs", lab.to_str().unwrap()][..], &clients[..], more].concat());
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let revoked = sturz(&["certs", lab.to_str().unwrap(), "--revoke", "rex"]);
    assert!(revoked.status.success(), "{}", String::from_utf8_lossy(&revoked.stderr));
    lab
}

fn serve(name: &str, lab: &Path) -> Daemon {
    Daemon::serve_at(name, "tls/127.0.0.1:0", scene(), &["--tls", lab.to_str().unwrap()])
}

fn target(daemon: &Daemon, lab: &Path, client: &str) -> Target {
    let tls = Tls::from_folder(lab.join("clients").join(client)).unwrap();
    Target::new(&daemon.endpoint).with_tls(tls)
}

fn connect(daemon: &Daemon, lab: &Path, client: &str) -> Simulation {
    Simulation::connect_to(&daemon.instance, &target(daemon, lab, client), SOON).unwrap().with_timeout(SOON)
}

/// A session without the client library in between.
fn bare_session(daemon: &Daemon, lab: &Path, client: &str) -> Session {
    let own = lab.join("clients").join(client);
    let mut config = zenoh::Config::default();
    let tls = serde_json::json!({
        "root_ca_certificate": own.join("ca.pem"),
        "enable_mtls": true,
        "connect_certificate": own.join("certificate.pem"),
        "connect_private_key": own.join("key.pem"),
    });
    for (key, json) in [
        ("mode", r#""client""#.to_string()),
        ("connect/endpoints", format!("[{:?}]", daemon.endpoint)),
        ("scouting/multicast/enabled", "false".into()),
        ("transport/link/tls", tls.to_string()),
    ] {
        config.insert_json5(key, &json).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

/// Whether anything comes back, be it a refusal by the daemon itself.
fn is_answered(session: &Session, key: &str) -> bool {
    // Not its own session, which answers for itself.
    let asked = session.get(key).payload(RUBBISH).allowed_destination(zenoh::sample::Locality::Remote).timeout(SOON);
    asked.wait().unwrap().recv().is_ok()
}

fn questions(keys: &Keys) -> Vec<String> {
    let field = keys.field_latest("none");
    vec![
        keys.info(),
        keys.features(),
        keys.plan(),
        keys.shapes_latest(),
        keys.report_latest(),
        keys.state_latest(),
        field,
    ]
}

#[test]
fn without_a_certificate_or_with_a_foreign_one_nobody_comes_in() {
    in_a_few_tries(|| {
        let (lab, other) = (lab("certificates", &[]), lab("foreign", &[]));
        let daemon = serve("certificates", &lab);
        let at = |target: Target| Simulation::connect_to(&daemon.instance, &target, Duration::ZERO).err().unwrap();
        let turned_away = |error: ClientError, reason: &str| {
            assert!(matches!(error, ClientError::TurnedAway { .. }) && error.is_denial(), "{error}");
            assert!(error.to_string().contains(reason), "{error}");
        };
        turned_away(at(Target::new(&daemon.endpoint)), "none was given");
        // Of another lab, whose authority would not let us talk to this daemon either; and the same pretending to be of this.
        turned_away(at(target(&daemon, &other, "ada")), "of another authority");
        let (own, foreign) = (lab.join("clients/ada"), other.join("clients/ada"));
        let (certificate, key) = (foreign.join("certificate.pem"), foreign.join("key.pem"));
        turned_away(
            at(Target::new(&daemon.endpoint).with_tls(Tls { authority: own.join("ca.pem"), certificate, key })),
            "of another authority",
        );
        // The daemon's own certificate is not one of a client.
        let server = lab.join("server");
        turned_away(at(Target::new(&daemon.endpoint).with_tls(Tls::from_folder(server).unwrap())), "certificate");
        // Not in the clear either.
        let plain = daemon.endpoint.replace("tls/", "tcp/");
        let error = at(Target::new(plain));
        assert!(matches!(error, ClientError::TurnedAway { .. } | ClientError::Silent { .. }), "{error}");
        assert_eq!(connect(&daemon, &lab, "eve").info().unwrap().state(), RunState::Paused);
    });
}

/// The folder of a client of the lab whose certificate has run out this long ago.
fn expired(lab: &Path, name: &str, ago: time::Duration) -> PathBuf {
    let read = |file: &str| fs::read_to_string(lab.join(file)).unwrap();
    let authority = rcgen::KeyPair::from_pem(&read("ca.key")).unwrap();
    let issuer = rcgen::Issuer::from_ca_cert_pem(&read("ca.pem"), authority).unwrap();
    let mut parameters = rcgen::CertificateParams::default();
    parameters.distinguished_name = rcgen::DistinguishedName::new();
    parameters.distinguished_name.push(rcgen::DnType::CommonName, name);
    parameters.extended_key_usages = vec![rcgen::ExtendedKeyUsagePurpose::ClientAuth];
    let now = time::OffsetDateTime::now_utc();
    (parameters.not_before, parameters.not_after) = (now - time::Duration::hours(1), now - ago);
    let key = rcgen::KeyPair::generate().unwrap();
    let certificate = parameters.signed_by(&key, &issuer).unwrap().pem();
    let own = lab.join("expired");
    fs::create_dir_all(&own).unwrap();
    for (file, text) in [("ca.pem", read("ca.pem")), ("certificate.pem", certificate), ("key.pem", key.serialize_pem())]
    {
        fs::write(own.join(file), text).unwrap();
    }
    own
}

#[test]
fn a_certificate_that_has_run_out_is_turned_away() {
    in_a_few_tries(|| {
        let lab = lab("expired", &[]);
        let daemon = serve("expired", &lab);
        let connect = |ago: time::Duration| {
            let tls = Tls::from_folder(expired(&lab, "ada", ago)).unwrap();
            Simulation::connect_to(
                &daemon.instance,
                &Target::new(&daemon.endpoint).with_tls(tls),
                Duration::from_secs(1),
            )
        };
        let error = connect(time::Duration::minutes(5)).err().unwrap();
        assert!(matches!(error, ClientError::TurnedAway { .. }), "{error}");
        // All that it lacks is time.
        connect(time::Duration::hours(-1)).unwrap().info().unwrap();

        // One that runs out meanwhile; on a slow machine, one that holds for longer.
        let short = [4, 8, 16, 32, 64].map(time::Duration::seconds).into_iter().find_map(|holds| connect(-holds).ok());
        let short = short.expect("connecting takes less than a minute");
        let deadline = Instant::now() + Duration::from_secs(120);
        while !short.is_gone() {
            assert!(Instant::now() < deadline, "the connection outlives its certificate");
            std::thread::sleep(Duration::from_millis(20));
        }
        assert!(matches!(short.info(), Err(ClientError::DaemonGone { .. })));
        assert!(matches!(short.reconnect(Duration::ZERO), Err(ClientError::TurnedAway { .. })));
    });
}

#[test]
fn a_name_without_a_role_is_refused_on_every_key() {
    in_a_few_tries(|| {
        let lab = lab("revoked", &[]);
        let daemon = serve("revoked", &lab);
        let (viewer, stranger) = (connect(&daemon, &lab, "eve"), bare_session(&daemon, &lab, "rex"));
        let keys = Keys::new(&daemon.instance).unwrap();
        let heard = stranger.declare_subscriber("**").wait().unwrap();
        let alive = stranger.liveliness().declare_subscriber("**").history(true).wait().unwrap();
        let commands = Verb::ALL.into_iter().map(|verb| keys.command(verb));
        for key in questions(&keys).into_iter().chain(commands).chain(["sturz/**".into(), "@/**".into()]) {
            assert!(!is_answered(&stranger, &key), "{key}");
        }
        let ada = connect(&daemon, &lab, "ada");
        let mut reports = viewer.reports().unwrap();
        ada.resume().unwrap();
        reports.next_within(SOON).unwrap();
        assert!(heard.try_recv().unwrap().is_none(), "the stranger heard something");
        assert!(alive.try_recv().unwrap().is_none(), "the stranger saw somebody");

        let error = Simulation::connect_to(&daemon.instance, &target(&daemon, &lab, "rex"), Duration::from_secs(1));
        let error = error.err().unwrap();
        assert!(matches!(error, ClientError::NothingToSee { .. }) && error.is_denial(), "{error}");
        // Who may look is told the names that there are.
        let error = Simulation::connect_to("nothing", &target(&daemon, &lab, "eve"), Duration::from_secs(1));
        let error = error.err().unwrap().to_string();
        assert!(error.contains("there are: revoked"), "{error}");
    });
}

#[test]
fn each_role_may_what_it_may_and_nothing_else() {
    in_a_few_tries(|| {
        let lab = lab("roles", &[]);
        let daemon = serve("roles", &lab);
        let keys = Keys::new(&daemon.instance).unwrap();
        for (client, allowed) in [("eve", 0), ("sam", Verb::ALL.len() - 1), ("ada", Verb::ALL.len())] {
            let session = bare_session(&daemon, &lab, client);
            for key in questions(&keys) {
                assert!(is_answered(&session, &key), "{client} may ask {key}");
            }
            let given = Verb::ALL.into_iter().filter(|&verb| is_answered(&session, &keys.command(verb)));
            let given: Vec<Verb> = given.collect();
            assert_eq!(given.len(), allowed, "{client} may give {given:?}");
            assert_eq!(given.contains(&Verb::Stop), client == "ada");
            assert!(!is_answered(&session, "@/**"), "{client} sees zenoh's own space");
        }
    });
}

#[test]
fn commands_that_are_put_are_held_to_the_same_roles() {
    in_a_few_tries(|| {
        let lab = lab("puts", &[]);
        let daemon = serve("puts", &lab);
        let keys = Keys::new(&daemon.instance).unwrap();
        let ada = connect(&daemon, &lab, "ada");
        let mut events = ada.events().unwrap();
        for (client, verb) in [("eve", Verb::Pause), ("sam", Verb::Stop), ("sam", Verb::Pause), ("ada", Verb::Stop)] {
            let session = bare_session(&daemon, &lab, client);
            session.put(keys.command(verb), RUBBISH).wait().unwrap();
            // What was put before on this connection has come in when this is answered.
            assert!(is_answered(&session, &keys.info()));
        }
        let mut refused = Vec::new();
        while refused.len() < 2 {
            let event = events.next_within(SOON).unwrap();
            if event.kind() == EventKind::Command {
                refused.push(event.outcome.unwrap().command);
            }
        }
        assert_eq!(
            refused,
            ["pause", "stop"],
            "of sam and ada; those of eve and sam that are not allowed never came in"
        );
    });
}

#[test]
fn nobody_can_speak_for_the_daemon() {
    in_a_few_tries(|| {
        let lab = lab("forgery", &[]);
        let daemon = serve("forgery", &lab);
        let keys = Keys::new(&daemon.instance).unwrap();
        let (eve, forger) = (connect(&daemon, &lab, "eve"), bare_session(&daemon, &lab, "ada"));
        let (mut states, mut events) = (eve.states().unwrap(), eve.events().unwrap());
        assert_eq!(events.next_within(SOON).unwrap().kind(), EventKind::Started);
        let _answers =
            forger.declare_queryable(keys.info()).callback(|query| drop(query.reply(query.key_expr(), RUBBISH).wait()));
        for key in [keys.state_frame(), keys.event("run"), keys.report()] {
            forger.put(key, RUBBISH).wait().unwrap();
        }
        assert!(is_answered(&forger, &keys.features()));
        connect(&daemon, &lab, "sam").resume().unwrap();
        // Rubbish would be an unreadable item before these.
        states.next_within(SOON).unwrap();
        assert_eq!(events.next_within(SOON).unwrap().kind(), EventKind::Resumed);
        assert_eq!(eve.info().unwrap().pid, daemon.pid());
    });
}

#[test]
fn the_client_tells_a_denial_from_everything_else() {
    in_a_few_tries(|| {
        let lab = lab("denied", &[]);
        let mut daemon = serve("denied", &lab);
        let (eve, sam) = (connect(&daemon, &lab, "eve"), connect(&daemon, &lab, "sam"));
        let error = eve.step(1).unwrap_err();
        assert!(matches!(&error, ClientError::Denied { what } if what == "cmd/step") && error.is_denial(), "{error}");
        assert!(matches!(eve.acquire_lease(), Err(ClientError::Denied { .. })));
        assert!(matches!(sam.stop(), Err(ClientError::Denied { .. })));
        eve.state(&["ids"], FloatType::F64).unwrap();
        sam.acquire_lease().unwrap();
        assert_eq!(sam.step(3).unwrap().step, 3);
        sam.release_lease().unwrap();
        let inspect = |client: &str| {
            let folder = lab.join("clients").join(client);
            sturz(&["inspect", "--json", "--endpoint", &daemon.endpoint, "--tls", folder.to_str().unwrap()])
        };
        let seen = inspect("eve");
        assert!(seen.status.success(), "{}", String::from_utf8_lossy(&seen.stderr));
        let seen: serde_json::Value = serde_json::from_slice(&seen.stdout).unwrap();
        assert_eq!((seen["instance"].as_str(), seen["step"].as_u64()), (Some("denied"), Some(3)));
        let unseen = inspect("rex");
        assert_eq!(unseen.status.code(), Some(6));
        assert!(String::from_utf8_lossy(&unseen.stderr).contains("has no role"), "{unseen:?}");
        let bare = sturz(&["inspect", "--endpoint", &daemon.endpoint]);
        assert_eq!(bare.status.code(), Some(6));
        assert!(String::from_utf8_lossy(&bare.stderr).contains("wants a certificate"), "{bare:?}");
        connect(&daemon, &lab, "ada").stop().unwrap();
        assert!(daemon.ended_well());
    });
}

#[test]
fn a_plain_daemon_that_gives_no_answer_denies_nobody() {
    let daemon = Daemon::start("plain");
    let simulation = daemon.connect();
    // There is no such field: the daemon says so itself.
    let error = simulation.field("nothing").unwrap_err();
    assert!(!error.is_denial() && error.refusal().is_some(), "{error}");
    assert!(!simulation.features().unwrap().capabilities.iter().any(|each| each == "access_control"));
}

#[test]
fn more_clients_than_the_limit_are_turned_away() {
    let limits = folder("crowd-limits").join("limits.toml");
    fs::write(&limits, "clients = 2").unwrap();
    let daemon = Daemon::serve("crowd", scene(), &["--limits", limits.to_str().unwrap()]);
    let (first, second) = (daemon.connect(), daemon.connect());
    assert_eq!(first.features().unwrap().limits.unwrap().clients, 2);
    let error = Simulation::connect(&daemon.instance, &daemon.endpoint, Duration::ZERO).err().unwrap();
    assert!(matches!(error, ClientError::TurnedAway { .. }), "{error}");
    assert!(error.to_string().contains("limit `clients`"), "{error}");
    second.info().unwrap();
    drop(second);
    daemon.connect().info().unwrap();
}

/// Sockets of a process, by table of `/proc/<pid>/net`: local addresses, and those that listen.
fn sockets(pid: u32, table: &str) -> (Vec<SocketAddr>, Vec<SocketAddr>) {
    let inodes: Vec<String> = fs::read_dir(format!("/proc/{pid}/fd"))
        .unwrap()
        .filter_map(|entry| fs::read_link(entry.unwrap().path()).ok())
        .filter_map(|link| Some(link.to_str()?.strip_prefix("socket:[")?.strip_suffix(']')?.to_string()))
        .collect();
    let (mut all, mut listening) = (Vec::new(), Vec::new());
    // A machine without IPv6 has no such table.
    let text = fs::read_to_string(format!("/proc/{pid}/net/{table}")).unwrap_or_default();
    for line in text.lines().skip(1) {
        let words: Vec<&str> = line.split_whitespace().collect();
        if inodes.iter().any(|inode| inode == words[9]) {
            all.push(address(words[1]));
            if words[3] == "0A" {
                listening.push(address(words[1]));
            }
        }
    }
    (all, listening)
}

/// `0100007F:1D17` is 127.0.0.1:7447: words of the machine's byte order.
fn address(text: &str) -> SocketAddr {
    let (host, port) = text.split_once(':').unwrap();
    let words: Vec<[u8; 4]> =
        (0..host.len()).step_by(8).map(|k| u32::from_str_radix(&host[k..k + 8], 16).unwrap().to_ne_bytes()).collect();
    let bytes = words.concat();
    let host = match <[u8; 16]>::try_from(bytes.as_slice()) {
        Ok(v6) => IpAddr::from(v6),
        Err(_) => IpAddr::from(<[u8; 4]>::try_from(bytes.as_slice()).unwrap()),
    };
    SocketAddr::new(host, u16::from_str_radix(port, 16).unwrap())
}

fn listening(pid: u32) -> Vec<SocketAddr> {
    ["tcp", "tcp6"].iter().flat_map(|table| sockets(pid, table).1).collect()
}

/// Sockets that could join a multicast group.
fn datagram_sockets(pid: u32) -> Vec<SocketAddr> {
    ["udp", "udp6", "raw", "raw6"].iter().flat_map(|table| sockets(pid, table).0).collect()
}

/// Whether this machine has joined zenoh's group 224.0.0.224.
fn has_joined_zenohs_group() -> bool {
    let group = u32::from_ne_bytes([224, 0, 0, 224]);
    fs::read_to_string("/proc/net/igmp").unwrap().contains(&format!("{group:08X}"))
}

/// An address of this machine that others can reach. Connecting a datagram socket sends nothing.
fn outer_address() -> Option<IpAddr> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
    socket.connect((Ipv4Addr::new(198, 51, 100, 1), 9)).ok()?;
    socket.local_addr().ok().map(|address| address.ip()).filter(|ip| !ip.is_loopback() && !ip.is_unspecified())
}

fn port(daemon: &Daemon) -> u16 {
    daemon.endpoint.rsplit(':').next().unwrap().parse().unwrap()
}

#[test]
fn by_default_nothing_listens_but_on_loopback_and_no_group_is_joined() {
    let joined_before = has_joined_zenohs_group();
    let daemon = Daemon::serve_at("loopback", "auto", scene(), &[]);
    daemon.connect().info().unwrap();
    let (pid, port) = (daemon.pid(), port(&daemon));
    let listening = listening(pid);
    assert!(listening.iter().any(|address| address.port() == port), "{listening:?}");
    assert!(listening.iter().all(|address| address.ip().is_loopback()), "{listening:?}");
    assert_eq!(datagram_sockets(pid), []);
    assert!(joined_before || !has_joined_zenohs_group());
    if let Some(outer) = outer_address() {
        let refused = TcpStream::connect_timeout(&(outer, port).into(), SOON).unwrap_err();
        assert_eq!(refused.kind(), std::io::ErrorKind::ConnectionRefused, "{outer}:{port}");
    } else {
        eprintln!("this machine has no address but loopback: that one is refused was not tried");
    }
    a_peer_that_searches_is_seen();
}

/// That the test above can fail: zenoh as it comes has a socket for its group.
fn a_peer_that_searches_is_seen() {
    let mut config = zenoh::Config::default();
    config.insert_json5("listen/endpoints", r#"["tcp/127.0.0.1:0"]"#).unwrap();
    let session = zenoh::open(config).wait().unwrap();
    assert!(!datagram_sockets(std::process::id()).is_empty());
    let deadline = Instant::now() + SOON;
    while !has_joined_zenohs_group() {
        assert!(Instant::now() < deadline, "zenoh does not search as it did: the test above proves nothing any more");
        std::thread::sleep(Duration::from_millis(5));
    }
    session.close().wait().unwrap();
}

/// A daemon with its standard error kept, and its line `ready`. It ends with the returned process's input.
fn start_loudly(name: &str, arguments: &[&str]) -> (std::process::Child, String) {
    let path = folder(name).join("scene.toml");
    fs::write(&path, scene()).unwrap();
    let mut process = Command::new(binary())
        .args(["serve", path.to_str().unwrap(), "--name", name, "--paused", "--stop-on-stdin-eof", "--json"])
        .args(arguments)
        .env("STURZ_LOG", "off")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
    (process, line)
}

#[test]
fn insecure_opens_all_interfaces_and_warns_on_each_start() {
    let (mut process, ready) = start_loudly("insecure", &["--listen", "tcp/0.0.0.0:0", "--insecure"]);
    let pid = process.id();
    let listening = listening(pid);
    assert!(listening.iter().any(|address| !address.ip().is_loopback()), "{listening:?} {ready}");
    if let Some(outer) = outer_address() {
        let port = listening.iter().find(|address| !address.ip().is_loopback()).unwrap().port();
        TcpStream::connect_timeout(&(outer, port).into(), SOON).unwrap();
    }
    drop(process.stdin.take());
    let said = process.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&said.stderr);
    assert!(said.contains("warning: --insecure: whoever reaches tcp/0.0.0.0:0 can steer"), "{said}");
}

#[test]
fn other_interfaces_are_refused_without_certificates() {
    let path = folder("exposed").join("scene.toml");
    fs::write(&path, scene()).unwrap();
    let refused = sturz(&["serve", path.to_str().unwrap(), "--listen", "tcp/0.0.0.0:0"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(5), "{said}");
    assert!(said.contains("tcp/0.0.0.0:0") && said.contains("--tls") && said.contains("--insecure"), "{said}");
}

#[test]
fn with_certificates_a_daemon_is_reached_from_outside() {
    in_a_few_tries(|| {
        let Some(outer) = outer_address() else {
            eprintln!("this machine has no address but loopback: not tried");
            return;
        };
        let lab = lab("outside", &["--host", &outer.to_string()]);
        let daemon = Daemon::serve_at("outside", "tls/0.0.0.0:0", scene(), &["--tls", lab.to_str().unwrap()]);
        let port = listening(daemon.pid()).first().unwrap().port();
        let tls = Tls::from_folder(lab.join("clients/eve")).unwrap();
        let target = Target::new(format!("tls/{outer}:{port}")).with_tls(tls);
        let simulation = Simulation::connect_to("outside", &target, SOON).unwrap();
        assert_eq!(simulation.info().unwrap().pid, daemon.pid());
    });
}
