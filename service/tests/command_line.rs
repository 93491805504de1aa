//! The program `sturz` as a user or a script meets it: what it prints, and how it exits.

use std::process::{Command, Output};

use serde_json::Value;

fn sturz(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sturz")).args(arguments).output().expect("the program starts")
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", stdout(output)))
}

/// A scene file in a folder of its own.
fn scene_file(name: &str, text: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("sturz-cli-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn scenes_are_listed_printed_and_readable_again() {
    let list = sturz(&["scenes", "--json"]);
    assert_eq!(list.status.code(), Some(0));
    let names: Vec<String> =
        json(&list).as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap().into()).collect();
    assert!(names.contains(&"drum-crosses".to_string()), "{names:?}");
    for name in names {
        let printed = sturz(&["scenes", &name]);
        let copy = scene_file(&format!("{name}-copy.toml"), &stdout(&printed));
        let check = sturz(&["check", copy.to_str().unwrap(), "--json"]);
        assert_eq!(check.status.code(), Some(0), "{}", stderr(&check));
        assert!(json(&check)["critical_time_step_s"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn check_tells_plan_steps_and_doubts() {
    let good = sturz(&["check", "cube-heap"]);
    assert!(stdout(&good).contains("no doubts") && stdout(&good).contains("critical time step"), "{}", stdout(&good));
    let text = stdout(&sturz(&["scenes", "cube-heap"])).replace("time_step_s = 8e-6", "time_step_s = 2.25e-5");
    let coarse = scene_file("coarse.toml", &text);
    let doubtful = sturz(&["check", coarse.to_str().unwrap(), "--json"]);
    assert_eq!(doubtful.status.code(), Some(0));
    assert!(!json(&doubtful)["warnings"].as_array().unwrap().is_empty());
}

#[test]
fn a_scene_that_cannot_be_used_is_refused_with_paths() {
    let text = stdout(&sturz(&["scenes", "cube-heap"]));
    let broken = text.replace("friction = 0.5", "friction = -0.5").replace("edge_m = 0.01", "edge_m = 0.0");
    let path = scene_file("broken.toml", &broken);
    let refused = sturz(&["check", path.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(3));
    let said = stderr(&refused);
    assert!(said.contains("material_pair[0].friction") && said.contains("shape[0].geometry"), "{said}");

    let unknown_key = scene_file("unknown.toml", &text.replace("seed = 3", "sead = 3"));
    let refused = sturz(&["run", unknown_key.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(stderr(&refused).contains("sead"), "{}", stderr(&refused));

    let step = scene_file("step.toml", &text.replace("time_step_s = 8e-6", "time_step_s = 1e-3"));
    let refused = sturz(&["run", step.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(stderr(&refused).contains("scene.time_step_s") && stderr(&refused).contains("critical"));

    let nowhere = sturz(&["serve", "no/such/scene.toml"]);
    assert_eq!(nowhere.status.code(), Some(3));
    assert!(stderr(&nowhere).contains("bouncing-sphere"), "it names the bundled scenes: {}", stderr(&nowhere));
}

#[test]
fn run_reports_how_wrong_and_how_long() {
    let run = sturz(&["run", "bouncing-sphere", "--time", "0.3", "--json"]);
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    let summary = json(&run);
    assert_eq!(summary["ending"], "complete");
    assert!((summary["report"]["time_s"].as_f64().unwrap() - 0.3).abs() < 1e-9);
    let energy = &summary["report"]["energy"];
    let (lost, residual) = (energy["dissipated_normal_j"].as_f64().unwrap(), energy["residual_j"].as_f64().unwrap());
    assert!(lost > 0.0 && residual.abs() < 1e-3 * lost, "{energy}");
    let again = json(&sturz(&["run", "bouncing-sphere", "--time", "0.3", "--json", "--threads", "2"]));
    assert_eq!(again["state_hash"], summary["state_hash"], "two threads, other bits");

    let table = stdout(&sturz(&["run", "bouncing-sphere", "--time", "0.01"]));
    for word in ["how long", "how wrong", "energy residual", "largest overlap", "state hash"] {
        assert!(table.contains(word), "{table}");
    }
}

#[test]
fn a_run_without_an_end_and_a_run_that_fails_say_so() {
    let endless = sturz(&["run", "drum-crosses"]);
    assert_eq!(endless.status.code(), Some(2));
    assert!(stderr(&endless).contains("--time"));

    // Two cubes that nearly coincide: the guard ends the run.
    let text = stdout(&sturz(&["scenes", "cube-heap"]));
    let head = text.split("[[insertion]]").next().unwrap();
    let overlapping = format!(
        "{head}[[insertion]]\nshape = \"cube\"\nmaterial = \"stone\"\n\
         placement = {{ method = \"poses\", positions_m = [[0.0, 0.0, 0.02], [0.0005, 0.0, 0.02]] }}\n"
    );
    let path = scene_file("overlapping.toml", &overlapping);
    let failed = sturz(&["run", path.to_str().unwrap(), "--time", "0.1", "--json"]);
    assert_eq!(failed.status.code(), Some(4), "{}", stderr(&failed));
    let summary = json(&failed);
    assert_eq!(summary["ending"], "failed");
    let reason = summary["failure"].as_str().unwrap();
    assert!(reason.contains("particle 0") && reason.contains("overlap"), "{reason}");
}

#[test]
fn the_bus_is_refused_with_a_reason() {
    let exposed = sturz(&["serve", "drum-crosses", "--listen", "tcp/0.0.0.0:0"]);
    assert_eq!(exposed.status.code(), Some(5));
    assert!(stderr(&exposed).contains("--insecure"));
    let bad_name = sturz(&["serve", "drum-crosses", "--name", "a/b"]);
    assert_eq!(bad_name.status.code(), Some(2));
    // Port 1 of the loopback interface: nobody listens there.
    let nobody = sturz(&["inspect", "--endpoint", "tcp/127.0.0.1:1"]);
    assert_eq!(nobody.status.code(), Some(6), "{}", stderr(&nobody));
}

#[test]
fn the_schema_is_json() {
    assert!(json(&sturz(&["schema"]))["properties"]["scene"].is_object());
}

#[test]
fn certificates_are_made_added_and_never_replaced_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let lab = folder.path().join("lab");
    let certs = |more: &[&str]| sturz(&[&["certs", lab.to_str().unwrap()][..], more].concat());
    let made = certs(&["--host", "dem.example.org", "--client", "alice:steer"]);
    assert_eq!(made.status.code(), Some(0), "{}", stderr(&made));
    assert!(
        stdout(&made).contains("clients/alice") && stdout(&made).contains("ca.key to yourself"),
        "{}",
        stdout(&made)
    );
    let again = certs(&["--client", "alice:admin"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(stderr(&again).contains("clients/alice is there already: --force"), "{}", stderr(&again));
    let added = certs(&["--client", "bob:view"]);
    assert!(stdout(&added).contains("must be started again"), "{}", stdout(&added));
    let nobody = certs(&["--client", "carol"]);
    assert_eq!(nobody.status.code(), Some(2));
    assert!(stderr(&nobody).contains("such as alice:steer"), "{}", stderr(&nobody));
    let roles = std::fs::read_to_string(lab.join("server/roles.toml")).unwrap();
    assert!(roles.contains("alice = \"steer\"") && roles.contains("bob = \"view\""), "{roles}");

    let scene = scene_file("certs.toml", &stdout(&sturz(&["scenes", "cube-heap"])));
    let serve = |more: &[&str]| sturz(&[&["serve", scene.to_str().unwrap(), "--paused"][..], more].concat());
    let plain = serve(&["--listen", "tcp/127.0.0.1:0", "--tls", lab.to_str().unwrap()]);
    assert_eq!(plain.status.code(), Some(5));
    assert!(stderr(&plain).contains("every endpoint must be one of TLS"), "{}", stderr(&plain));
    let empty = serve(&["--listen", "auto", "--tls", folder.path().to_str().unwrap()]);
    assert_eq!(empty.status.code(), Some(2));
    assert!(stderr(&empty).contains("ca.pem is missing"), "{}", stderr(&empty));
}
