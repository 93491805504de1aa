//! `sturz prepare`, and scenes that start with what it has written.

mod common;

use std::path::{Path, PathBuf};

use common::{Daemon, sturz};
use serde_json::Value;

/// Beads that come in over time, settle with local damping, and then rest without it.
const BED: &str = r#"
[scene]
name = "bed"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 2e-5
seed = 3
[domain]
min_m = [0.0, 0.0, 0.0]
max_m = [0.02, 0.02, 0.0]
periodic = [true, true, false]
[[material]]
name = "glass"
density_kg_per_m3 = 2500.0
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = 1e3
restitution = 0.5
friction = 0.3
[[shape]]
name = "bead"
geometry = { kind = "sphere", radius_m = 1.5e-3 }
[[boundary]]
name = "floor"
material = "glass"
geometry = { kind = "plane", point_m = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
"#;

const PREPARATION: &str = r#"
[[inflow]]
name = "shower"
shape = "bead"
material = "glass"
region = { kind = "box", min_m = [0.0, 0.0, 0.02], max_m = [0.02, 0.02, 0.03] }
rate_per_s = 2000.0
interval_s = 0.005
count = 60
[[stage]]
name = "settle"
local_damping = 0.5
kinetic_over_elastic = 1e-4
time_s = 2.0
[[stage]]
name = "rest"
time_s = 0.01
"#;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).unwrap_or_else(|error| panic!("{error}: {}", text(bytes)))
}

fn prepared(folder: &Path) -> (PathBuf, Value) {
    let scene = file(folder, "bed.toml", &format!("{BED}{PREPARATION}"));
    let out = folder.join("bed.sturz");
    let done = sturz(&["prepare", scene.to_str().unwrap(), "--out", out.to_str().unwrap(), "--json"]);
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    (out, json(&done.stdout))
}

#[test]
fn stages_run_to_their_end_and_a_later_scene_goes_on() {
    let folder = folder();
    let (out, said) = prepared(folder.path());
    assert_eq!((said["ended_by"].as_str(), said["particles"].as_u64()), (Some("stages"), Some(60)));
    assert!(said["kinetic_j"].as_f64().unwrap() < 1e-3 * said["elastic_j"].as_f64().unwrap(), "{said}");
    assert_eq!(said["bytes"].as_u64(), Some(std::fs::metadata(&out).unwrap().len()));

    let tilted = BED.replace("[0.0, 0.0, -9.81]", "[0.5, 0.0, -9.0]");
    let by_scene = format!("{tilted}[start]\ncheckpoint = \"bed.sturz\"\n[stop]\ntime_s = 0.01\n");
    let by_scene = file(folder.path(), "tilted.toml", &by_scene);
    let ran = sturz(&["run", by_scene.to_str().unwrap(), "--json"]);
    assert_eq!(ran.status.code(), Some(0), "{}", text(&ran.stderr));
    let by_flag = file(folder.path(), "plain.toml", &tilted);
    let from = ["--from", out.to_str().unwrap()];
    let flagged = sturz(&[&["run", by_flag.to_str().unwrap(), "--time", "0.01", "--json"], &from[..]].concat());
    let [ran, flagged] = [&ran, &flagged].map(|output| json(&output.stdout));
    assert_eq!((ran["report"]["particles"].as_u64(), &ran["state_hash"]), (Some(60), &flagged["state_hash"]));

    let check = sturz(&["check", by_scene.to_str().unwrap()]);
    let told = "start: 60 particles of 'bed' at";
    assert!(
        text(&check.stdout).contains(told) && text(&check.stdout).contains("contact history kept"),
        "{}",
        text(&check.stdout)
    );
    let check = text(&sturz(&["check", folder.path().join("bed.toml").to_str().unwrap()]).stdout);
    for told in [
        "stage 'settle': local damping 0.5; ends after 2 s or at kinetic over elastic energy below 1e-4",
        "inflow 'shower': 2000 particles/s of 'bead'",
    ] {
        assert!(check.contains(told), "{told}: {check}");
    }
}

#[test]
fn what_cannot_be_prepared_or_started_is_refused() {
    let folder = folder();
    let endless = file(folder.path(), "endless.toml", BED);
    let out = folder.path().join("out.sturz");
    let refused = sturz(&["prepare", endless.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("--until SECONDS"), "{}", text(&refused.stderr));
    let done =
        sturz(&["prepare", endless.to_str().unwrap(), "--out", out.to_str().unwrap(), "--until", "1e-3", "--json"]);
    assert_eq!(json(&done.stdout)["ended_by"].as_str(), Some("time"));
    let nowhere = folder.path().join("no/such/out.sturz");
    let refused = sturz(&["prepare", endless.to_str().unwrap(), "--out", nowhere.to_str().unwrap(), "--until", "1"]);
    assert_eq!(refused.status.code(), Some(2));
    let missing = file(folder.path(), "missing.toml", &format!("{BED}[start]\ncheckpoint = \"none.sturz\"\n"));
    let refused = sturz(&["check", missing.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(
        text(&refused.stderr).contains("start.checkpoint: 'none.sturz' cannot be read"),
        "{}",
        text(&refused.stderr)
    );
    let other = file(folder.path(), "other.toml", &BED.replace("max_m = [0.02, 0.02", "max_m = [0.03, 0.02"));
    let refused = sturz(&["run", other.to_str().unwrap(), "--time", "1", "--from", out.to_str().unwrap()]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(text(&refused.stderr).contains("differs along x"), "{}", text(&refused.stderr));
}

/// A journal keeps the bed: its run is gone through again without the file.
#[test]
fn a_journal_holds_the_bed() {
    let folder = folder();
    let (out, _) = prepared(folder.path());
    let scene = file(folder.path(), "plain.toml", BED);
    let journal = folder.path().join("journal");
    let more = ["--journal", journal.to_str().unwrap(), "--from", out.to_str().unwrap(), "--name", "bed"];
    let mut daemon = Daemon::serve_scene(scene.to_str().unwrap(), &more);
    assert_eq!(daemon.inspect()["particles"].as_u64(), Some(60), "{}", daemon.inspect());
    daemon.end();
    std::fs::remove_file(&out).unwrap();
    let replayed = sturz(&["replay", journal.to_str().unwrap()]);
    assert_eq!(replayed.status.code(), Some(0), "{}", text(&replayed.stderr));
}
