//! The program, and a daemon of a test's own.
#![allow(dead_code)]

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

/// A daemon of a test's own, on a free port; ends with its standard input.
pub struct Daemon {
    process: Child,
    /// What it said when it was ready.
    pub ready: Value,
}

impl Daemon {
    /// Serves the drum of crosses; `more` goes to the command line.
    pub fn serve(more: &[&str]) -> Self {
        Self::serve_scene("drum-crosses", more)
    }

    /// Serves a bundled scene.
    pub fn serve_scene(scene: &str, more: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sturz"));
        command.args(["serve", scene, "--listen", "auto", "--json", "--stop-on-stdin-eof"]).args(more);
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let ready = line.strip_prefix("ready ").unwrap_or_else(|| panic!("{line:?} says that it is not ready"));
        let ready = serde_json::from_str(ready).unwrap();
        Self { process, ready }
    }

    /// Where it listens.
    pub fn endpoint(&self) -> &str {
        self.ready["endpoint"].as_str().unwrap()
    }

    /// Runs `sturz` against it.
    pub fn ask(&self, arguments: &[&str]) -> Output {
        sturz(&[arguments, &["--endpoint", self.endpoint()]].concat())
    }

    /// What it says of itself.
    pub fn inspect(&self) -> Value {
        serde_json::from_slice(&self.ask(&["inspect", "--json"]).stdout).unwrap()
    }

    /// Ends it, and waits until it has.
    pub fn end(&mut self) {
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

/// Runs the program to its end.
pub fn sturz(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sturz")).args(arguments).stdin(Stdio::null()).output().unwrap()
}

/// What it printed.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
