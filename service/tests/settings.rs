//! Settings of `sturz serve`: flags over environment over file over defaults.

mod common;

use std::path::Path;
use std::process::{Command, Output, Stdio};

use common::{Daemon, text};
use toml::{Table, Value};

/// A file of settings in a folder of its own.
fn file(lines: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lab.toml");
    std::fs::write(&path, lines).unwrap();
    let path = path.to_str().unwrap().into();
    (folder, path)
}

fn show(path: &str, more: &[&str], environment: &[(&str, &str)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sturz"));
    for name in ["NAME", "LISTEN", "TLS", "JOURNAL", "CHECKPOINTS", "THREADS", "METRICS", "SETTINGS"] {
        command.env_remove(format!("STURZ_{name}"));
    }
    command.args(["serve", "--show-settings", "--settings", path]).args(more).envs(environment.iter().copied());
    command.stdin(Stdio::null()).output().unwrap()
}

fn shown(output: &Output) -> Table {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    toml::from_str(&text(&output.stdout)).unwrap()
}

#[test]
fn flags_win_over_environment_over_file_over_defaults() {
    let lines =
        "name = 'file'\nthreads = 3\njournal_keep = 'all'\nlisten = ['auto', 'tcp/127.0.0.1:0']\npaused = true\n";
    let (_folder, path) = file(lines);
    let environment = [("STURZ_NAME", "environment"), ("STURZ_THREADS", "2")];
    let output = show(&path, &["--name", "flag"], &environment);
    let settings = shown(&output);
    let said = text(&output.stdout);
    for line in [
        "name = \"flag\" # flag",
        "threads = 2 # environment",
        &format!("journal_keep = \"all\" # file {path}"),
        &format!("paused = true # file {path}"),
        "journal_fsync = \"second\" # default",
        "insecure = false # default",
    ] {
        assert!(said.lines().any(|other| other == line), "{line} in\n{said}");
    }
    assert_eq!(settings["listen"], Value::from(vec!["auto", "tcp/127.0.0.1:0"]));
    let off = shown(&show(&path, &["--paused=false"], &[]));
    assert_eq!((&off["paused"], &off["threads"]), (&Value::from(false), &Value::from(3)));

    // What is shown is a file that says the same.
    let (_again, copy) = file(&said);
    assert_eq!(shown(&show(&copy, &[], &[])), settings);
}

#[test]
fn limits_are_a_table_over_which_their_file_wins() {
    let (folder, path) = file("[limits]\nparticles = 5\nfields = 6\n");
    let limits = folder.path().join("limits.toml");
    std::fs::write(&limits, "fields = 7\n").unwrap();
    let output = show(&path, &["--limits", limits.to_str().unwrap()], &[]);
    let settings = shown(&output);
    let number = |name: &str| settings["limits"][name].as_integer().unwrap();
    assert_eq!((number("particles"), number("fields"), number("clients")), (5, 7, 256));
    let said = text(&output.stdout);
    assert!(said.contains(&format!("particles = 5 # file {path}")), "{said}");
    assert!(said.contains(&format!("fields = 7 # file {}", limits.display())), "{said}");
}

#[test]
fn paths_in_a_file_are_relative_to_it_and_give_way() {
    let (folder, path) = file("journal = 'run'\n");
    let journal = |settings: &Table| settings.get("journal").and_then(Value::as_str).map(String::from);
    let own = shown(&show(&path, &[], &[]));
    assert_eq!(journal(&own).as_deref(), folder.path().join("run").to_str());
    assert_eq!(own["checkpoint_every"].as_float(), Some(60.0));
    // Checkpoints of the command line take the place of the file's journal.
    let other = shown(&show(&path, &["--checkpoints", "saved"], &[]));
    assert_eq!((journal(&other), &other["checkpoints"]), (None, &Value::from("saved")));
    assert!(!folder.path().join("run").exists(), "to show settings makes nothing");
}

#[test]
fn what_a_file_may_not_say_is_refused_with_its_place() {
    for (lines, parts) in [
        ("thread = 2", &["there is no setting `thread`", "threads", "[limits]"][..]),
        ("threads = [2]", &["`threads` is [2], must be a number"]),
        ("threads = 0", &["--threads", "1..=1024"]),
        ("paused = 'yes'", &["`paused` is \"yes\", must be true or false"]),
        ("listen = 'auto'", &["`listen` is", "array of strings"]),
        ("journal_fsync = 'never'", &["never", "second, command"]),
        ("metrics = 'here'", &["here", "--metrics"]),
        ("[limits]\npartickles = 1", &["[limits]", "partickles"]),
        ("[limits]\nclients = 0", &["clients must be at least 1"]),
        ("journal = 'a'\ncheckpoints = 'b'", &["exclude each other"]),
        ("name = ", &["TOML parse error"]),
    ] {
        let (_folder, path) = file(lines);
        let refused = show(&path, &[], &[]);
        assert_eq!(refused.status.code(), Some(2), "{lines}");
        let said = text(&refused.stderr);
        assert!(said.contains(&path), "{lines}: {said}");
        assert!(parts.iter().all(|part| said.contains(part)), "{lines}: {said}");
    }
    let nowhere = show(Path::new("no/such.toml").to_str().unwrap(), &[], &[]);
    assert_eq!(nowhere.status.code(), Some(2));
    assert!(text(&nowhere.stderr).contains("no/such.toml"), "{}", text(&nowhere.stderr));
}

#[test]
fn a_daemon_lives_by_its_file() {
    let (_folder, path) = file("name = 'filed'\nthreads = 2\npaused = true\nmetrics = '127.0.0.1:0'\n");
    let daemon = Daemon::serve(&["--settings", &path]);
    let told = daemon.inspect();
    assert_eq!((&told["instance"], &told["threads"], &told["state"]), (&"filed".into(), &2.into(), &"paused".into()));
    assert!(daemon.ready["metrics"].is_string(), "{}", daemon.ready);
}
