//! Which crate may know which: DESIGN.md, sections 2 and 7.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

/// Names of all packages that `package` is built from, itself included, without those for tests and build scripts.
fn built_from(package: &str, features: &[&str]) -> BTreeSet<String> {
    let mut command = Command::new(env!("CARGO"));
    command.args(["tree", "--locked", "--edges", "normal", "--prefix", "none", "--package", package]);
    command.args(["--no-default-features", "--features", &features.join(",")]);
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("cargo prints UTF-8");
    text.lines().filter_map(|line| line.split(' ').next()).map(String::from).collect()
}

#[test]
fn the_engine_knows_no_bus_no_wire_and_no_runtime() {
    let packages = built_from("sturz-engine", &[]);
    assert!(packages.contains("nalgebra") && packages.contains("rayon"), "the list is not that of the engine");
    for stranger in ["tokio", "zenoh", "zenoh-ext", "prost", "tracing", "sturz-protocol", "sturz-service"] {
        assert!(!packages.contains(stranger), "the engine is built from {stranger}");
    }
}

#[test]
fn the_protocol_knows_no_bus_and_clients_know_no_engine() {
    let protocol = built_from("sturz-protocol", &["engine"]);
    assert!(protocol.contains("prost") && protocol.contains("sturz-engine"));
    assert!(!protocol.contains("zenoh") && !protocol.contains("tokio"));
    let client = built_from("sturz-client", &[]);
    assert!(client.contains("zenoh") && client.contains("sturz-protocol"));
    assert!(!client.contains("sturz-engine") && !client.contains("parry3d-f64"));
}

/// Licences that the workspace's own allow; a crate under another one is looked at by a person first.
#[test]
fn direct_dependencies_have_permissive_licences() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--locked", "--format-version", "1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("cargo prints JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let licences: BTreeMap<&str, &str> = packages
        .iter()
        .filter_map(|package| Some((package["name"].as_str()?, package["license"].as_str().unwrap_or("none"))))
        .collect();
    let own = packages.iter().filter(|package| package["source"].is_null());
    let names: BTreeSet<&str> = own
        .flat_map(|package| package["dependencies"].as_array().into_iter().flatten())
        .filter_map(|dependency| dependency["name"].as_str())
        .collect();
    assert!(names.contains("nalgebra") && names.contains("zenoh"), "{names:?}");
    // MPL-2.0. Issue 6 names it for the C header; it runs in a test, and nothing of it is in what is built.
    for name in names.into_iter().filter(|&name| name != "cbindgen") {
        let licence = licences[name];
        let allowed = ["MIT", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "Zlib", "EPL-2.0"];
        assert!(allowed.iter().any(|allowed| licence.contains(allowed)), "{name}: {licence}");
    }
}
