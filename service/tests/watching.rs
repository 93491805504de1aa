//! A running daemon as those see it who watch it: `sturz top`.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

/// A daemon of a test's own, on a free port; ends with its standard input.
struct Daemon {
    process: Child,
    ready: Value,
}

impl Daemon {
    fn serve(more: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sturz"));
        command.args(["serve", "drum-crosses", "--listen", "auto", "--json", "--stop-on-stdin-eof"]).args(more);
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let ready = line.strip_prefix("ready ").unwrap_or_else(|| panic!("{line:?} says that it is not ready"));
        let ready = serde_json::from_str(ready).unwrap();
        Self { process, ready }
    }

    fn endpoint(&self) -> &str {
        self.ready["endpoint"].as_str().unwrap()
    }

    fn ask(&self, arguments: &[&str]) -> Output {
        sturz(&[arguments, &["--endpoint", self.endpoint()]].concat())
    }

    fn inspect(&self) -> Value {
        serde_json::from_slice(&self.ask(&["inspect", "--json"]).stdout).unwrap()
    }

    fn end(&mut self) {
        drop(self.process.stdin.take());
        self.process.wait().unwrap();
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

fn sturz(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sturz")).args(arguments).stdin(Stdio::null()).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn top_shows_one_view_of_a_paused_run() {
    let daemon = Daemon::serve(&["--paused", "--name", "watched"]);
    let told = daemon.inspect();
    let top = daemon.ask(&["top", "--once"]);
    assert_eq!(top.status.code(), Some(0), "{}", text(&top.stderr));
    let view = text(&top.stdout);
    let particles = format!("particles      {}, ", told["particles"]);
    for part in [
        "watched (Rotating drum of 3D crosses)",
        "state          paused",
        "step 0",
        &particles,
        "no step yet",
        "residual",
        "report",
    ] {
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
