//! A running daemon as those see it who watch it: `sturz top`, and Prometheus.

mod common;

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::process::{Command, Stdio};

use common::{Daemon, sturz, text};

#[test]
fn top_shows_one_view_of_a_paused_run() {
    let daemon = Daemon::serve_scene("cube-heap", &["--paused", "--name", "watched"]);
    let told = daemon.inspect();
    let top = daemon.ask(&["top", "--once"]);
    assert_eq!(top.status.code(), Some(0), "{}", text(&top.stderr));
    let view = text(&top.stdout);
    let particles = format!("particles      {}, ", told["particles"]);
    for part in
        ["watched (Heap of cubes)", "state          paused", "step 0", &particles, "no step yet", "residual", "report"]
    {
        assert!(view.contains(part), "{part} in\n{view}");
    }
    assert!(!view.contains('\x1b'), "no control characters where there is no terminal");
}

#[test]
fn top_follows_a_run_to_its_end() {
    let mut daemon = Daemon::serve(&["--name", "followed"]);
    let mut top = Command::new(env!("CARGO_BIN_EXE_sturz"));
    top.args(["top", "followed", "--every", "0.1", "--endpoint", daemon.endpoint()]);
    let mut top = top.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(top.stdout.take().unwrap()).lines().map_while(Result::ok);
    // Reports come, hence time goes on in the views: as many of them as that takes.
    let times = lines.by_ref().filter(|line| line.trim_start().starts_with("time  "));
    let mut steps = times.map(|line| line.rsplit(' ').next().unwrap().parse::<u64>().unwrap());
    let first = steps.next().unwrap();
    assert!(steps.any(|step| step > first));
    assert!(lines.by_ref().any(|line| line.contains("narrow") && line.contains('#')), "the stages have bars");
    daemon.end();
    assert_eq!(lines.last().as_deref(), Some("followed has ended"));
    assert_eq!(top.wait().unwrap().code(), Some(0));
}

#[test]
fn top_says_what_it_cannot_do() {
    let often = sturz(&["top", "--every", "0"]);
    assert_eq!(often.status.code(), Some(2));
    assert!(text(&often.stderr).contains("--every is 0"), "{}", text(&often.stderr));
    // Port 1 of the loopback interface: nobody listens there.
    let nobody = sturz(&["top", "--endpoint", "tcp/127.0.0.1:1"]);
    assert_eq!(nobody.status.code(), Some(6), "{}", text(&nobody.stderr));
}

/// With the folder of a client, and not without.
#[test]
fn top_comes_in_with_a_certificate() {
    let lab = tempfile::tempdir().unwrap();
    let folder = lab.path().join("lab");
    let path = folder.to_str().unwrap();
    let made = sturz(&["certs", path, "--client", "bob:view"]);
    assert_eq!(made.status.code(), Some(0), "{}", text(&made.stderr));
    let daemon = Daemon::serve_scene("cube-heap", &["--paused", "--name", "guarded", "--tls", path]);
    assert!(daemon.endpoint().starts_with("tls/"), "{}", daemon.endpoint());
    let bob = folder.join("clients").join("bob");
    let top = daemon.ask(&["top", "--once", "--tls", bob.to_str().unwrap()]);
    assert_eq!(top.status.code(), Some(0), "{}", text(&top.stderr));
    assert!(text(&top.stdout).contains("guarded (Heap of cubes)"), "{}", text(&top.stdout));
    let stranger = daemon.ask(&["top", "--once"]);
    assert_eq!(stranger.status.code(), Some(6), "{}", text(&stranger.stderr));
}

/// One request, all of the answer.
fn http(address: &str, request: &[u8]) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.write_all(request).unwrap();
    stream.shutdown(Shutdown::Write).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

fn get(address: &str, path: &str) -> String {
    http(address, format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes())
}

/// Address of the metrics.
fn metrics(daemon: &Daemon) -> String {
    let url = daemon.ready["metrics"].as_str().unwrap();
    url.strip_prefix("http://").unwrap().strip_suffix("/metrics").unwrap().into()
}

#[test]
fn prometheus_gets_the_numbers_of_the_report() {
    let daemon = Daemon::serve_scene("cube-heap", &["--paused", "--name", "measured", "--metrics", "127.0.0.1:0"]);
    let address = metrics(&daemon);
    let answer = get(&address, "/metrics");
    let (head, page) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("HTTP/1.1 200 OK\r\n") && head.contains("text/plain; version=0.0.4"), "{head}");
    assert!(head.contains(&format!("Content-Length: {}\r\n", page.len())), "{head}");
    let value = |name: &str| {
        let line = page.lines().find(|line| line.strip_prefix(name).is_some_and(|rest| rest.starts_with(' ')));
        let line = line.unwrap_or_else(|| panic!("no {name} in\n{page}"));
        line.rsplit(' ').next().unwrap().parse::<f64>().unwrap()
    };
    let told = daemon.inspect();
    let report = &told["report"];
    for (name, told) in [
        ("sturz_particles", &told["particles"]),
        ("sturz_steps_total", &told["step"]),
        ("sturz_simulated_time_seconds", &told["time_s"]),
        ("sturz_time_step_seconds", &told["time_step_s"]),
        ("sturz_threads", &told["threads"]),
        ("sturz_critical_time_step_seconds", &report["critical_time_step_s"]),
        ("sturz_energy_residual_joules", &report["energy_residual_j"]),
        ("sturz_touching_pairs{with=\"particle\"}", &report["touching_pairs"]),
        ("sturz_largest_overlap_meters", &report["largest_overlap_m"]),
    ] {
        assert_eq!(value(name), told.as_f64().unwrap(), "{name}");
    }
    assert!(value("sturz_particles") > 0.0);
    assert_eq!((value("sturz_run_state{state=\"paused\"}"), value("sturz_run_state{state=\"running\"}")), (1.0, 0.0));
    assert_eq!(value("sturz_stream_dropped_total{stream=\"state\"}"), 0.0);
    assert!(page.contains("instance_name=\"measured\""), "{page}");
}

#[test]
fn who_asks_for_something_else_than_the_metrics_is_told_so() {
    let daemon = Daemon::serve(&["--paused", "--name", "asked", "--metrics", "127.0.0.1:0"]);
    let address = metrics(&daemon);
    let long = format!("GET /metrics HTTP/1.1\r\nX: {}\r\n\r\n", "x".repeat(9000));
    for (request, status) in [
        (&b"GET / HTTP/1.1\r\n\r\n"[..], "404"),
        (b"GET /metrics/../etc HTTP/1.1\r\n\r\n", "404"),
        (b"POST /metrics HTTP/1.1\r\n\r\n", "405"),
        (b"hello\r\n\r\n", "400"),
        (b"\xff\xfe\r\n\r\n", "400"),
        (b"GET /metrics HTTP/1.1\r\n", "400"),
        (b"", "400"),
        (long.as_bytes(), "400"),
    ] {
        let answer = http(&address, request);
        assert!(answer.starts_with(&format!("HTTP/1.1 {status} ")), "{}: {answer}", text(request));
    }
    // Some who say nothing, and stay, keep nobody else out.
    let silent: Vec<_> = (0..8).map(|_| TcpStream::connect(&address).unwrap()).collect();
    assert!(get(&address, "/metrics").starts_with("HTTP/1.1 200 "));
    drop(silent);
}

#[test]
fn metrics_are_served_where_asked_for_only() {
    let plain = Daemon::serve(&["--paused", "--name", "plain"]);
    assert!(plain.ready.get("metrics").is_none(), "{}", plain.ready);
    let other = Daemon::serve(&["--paused", "--name", "other", "--metrics", "127.0.0.1:0"]);
    let taken = metrics(&other);
    let refused = sturz(&["serve", "drum-crosses", "--listen", "auto", "--metrics", &taken]);
    assert_eq!(refused.status.code(), Some(5));
    assert!(
        text(&refused.stderr).contains(&format!("--metrics: cannot listen on {taken}")),
        "{}",
        text(&refused.stderr)
    );
    let open = sturz(&["serve", "drum-crosses", "--listen", "auto", "--metrics", "0.0.0.0:0"]);
    assert_eq!(open.status.code(), Some(5));
    assert!(text(&open.stderr).contains("--insecure"), "{}", text(&open.stderr));
}
