//! `sturz play`

use crate::cli;
use crate::commands::{Failure, runtime};
use crate::config::{Bus, DEFAULT_LISTEN};
use crate::daemon::{Ready, ServeError};
use crate::play::{self, Options, Speed};

/// Serves a recording until it is told to end.
pub fn play(options: cli::Play) -> Result<(), Failure> {
    let speed = Speed::parse(&options.speed).map_err(Failure::Usage)?;
    if let Some(name) = &options.name {
        sturz_protocol::keys::check_name(name).map_err(|error| Failure::Usage(format!("--name: {error}")))?;
    }
    let listen = if options.listen.is_empty() && options.config.is_none() {
        vec![DEFAULT_LISTEN.into()]
    } else {
        options.listen
    };
    let bus = Bus { listen, connect: options.connect, file: options.config, ..Bus::default() };
    bus.check_exposure(options.insecure).map_err(|error| Failure::Bus(error.to_string()))?;
    let (json, paused) = (options.json, options.paused);
    let options = Options {
        file: options.file,
        instance: options.name,
        bus,
        speed,
        repeat: options.repeat,
        paused,
        exit_at_end: options.exit_at_end,
        stop_on_stdin_eof: options.stop_on_stdin_eof,
    };
    let ready = |ready: &Ready| announce(ready, paused, json);
    runtime()?.block_on(play::play(options, ready)).map_err(|error| match error {
        ServeError::Other(error) => Failure::Other(error),
        refused => Failure::Bus(refused.to_string()),
    })
}

fn announce(ready: &Ready, paused: bool, json: bool) {
    if json {
        println!("ready {}", serde_json::to_string(ready).unwrap_or_default());
        return;
    }
    let state = if paused { "paused: it waits for `resume`" } else { "playing" };
    println!("the recording of {} is served at {}, {state}", ready.instance, ready.endpoint);
    println!("in Python:  sturz.connect(\"{}\", endpoint=\"{}\")", ready.instance, ready.endpoint);
    println!("Ctrl-C ends it");
}
