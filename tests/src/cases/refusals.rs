//! S19: numbers that no scene and no command may have.

use sturz_engine::Command;
use sturz_engine::scene::{InsertionDescription, Placement, Scene};

use super::{Case, Checks};
use crate::scene::SceneText;

pub fn cases() -> Vec<Case> {
    vec![Case::fast("S19", "NaN, infinite and negative numbers are refused with their path", bad_numbers)]
}

const LAW: &str = "stiffness_n_per_m = 1e5\nrestitution = 0.5\nfriction = 0.3";

fn good() -> SceneText {
    SceneText::new([0.0, 0.0, -9.81], "time_step_s = 1e-5")
        .materials(1000.0, LAW)
        .shape("kind = \"cube\", edge_m = 0.1")
        .floor()
        .particle([0.0, 0.0, 0.049], [0.0; 3], [0.0; 3])
}

/// S19, all parts.
fn bad_numbers(checks: &mut Checks) -> anyhow::Result<()> {
    scenes(checks);
    commands(checks)
}

/// A text of the good scene, what replaces it, and the path that the error must name.
const BAD: [(&str, &str, &str); 18] = [
    ("time_step_s = 1e-5", "time_step_s = nan", "scene.time_step_s"),
    ("time_step_s = 1e-5", "time_step_s = -1e-5", "scene.time_step_s"),
    ("time_step_s = 1e-5", "time_step_s = inf", "scene.time_step_s"),
    ("time_step_s = 1e-5", "time_step_s = 0.0", "scene.time_step_s"),
    ("-9.81]", "nan]", "scene.gravity_m_per_s2"),
    ("density_kg_per_m3 = 1000.0", "density_kg_per_m3 = -1.0", "material[0].density_kg_per_m3"),
    ("density_kg_per_m3 = 1000.0", "density_kg_per_m3 = 0.0", "material[0].density_kg_per_m3"),
    ("stiffness_n_per_m = 1e5", "stiffness_n_per_m = -1e5", "material_pair[0].stiffness_n_per_m"),
    ("stiffness_n_per_m = 1e5", "stiffness_n_per_m = inf", "material_pair[0].stiffness_n_per_m"),
    ("friction = 0.3", "friction = -0.1", "material_pair[0].friction"),
    ("friction = 0.3", "friction = nan", "material_pair[0].friction"),
    ("restitution = 0.5", "restitution = 1.5", "material_pair[0].restitution"),
    ("restitution = 0.5", "damping_n_s_per_m = -1.0", "material_pair[0].damping_n_s_per_m"),
    ("edge_m = 0.1", "edge_m = -0.1", "shape[0].geometry"),
    ("edge_m = 0.1", "edge_m = nan", "shape[0].geometry"),
    ("[[0.0, 0.0, 0.049]]", "[[0.0, inf, 0.049]]", "insertion[0].placement.positions_m[0]"),
    ("normal = [0.0, 0.0, 1.0]", "normal = [0.0, 0.0, 0.0]", "boundary[0].geometry.normal"),
    ("velocity_m_per_s = [0.0, 0.0, 0.0]", "velocity_m_per_s = [nan, 0.0, 0.0]", "insertion[0].velocity_m_per_s"),
];

fn scenes(checks: &mut Checks) {
    checks.holds("the scene without changes is accepted", good().validate().is_ok());
    for (from, to, path) in BAD {
        let text = good().text();
        let changed = text.replacen(from, to, 1);
        let error = sturz_engine::scene::SceneDescription::from_toml(&changed)
            .map_err(|error| error.to_string())
            .and_then(|description| Scene::validate(description).map_err(|error| error.to_string()))
            .err()
            .unwrap_or_default();
        checks.holds(format!("{to} is refused at {path}"), changed != text && error.contains(path));
    }
}

/// Commands: the error has a path, and the state hash stays.
fn commands(checks: &mut Checks) -> anyhow::Result<()> {
    let mut engine = good().start()?;
    checks.steps(&mut engine, 100)?;
    let before = engine.state_hash();
    let insertion = engine.scene().description().insertions[0].clone();
    let at = |position: [f64; 3], orientation: [f64; 4]| {
        let placement = Placement::Poses { positions_m: vec![position], orientations_wxyz: vec![orientation] };
        Command::Insert(InsertionDescription { placement, ..insertion.clone() })
    };
    let good_turn = [1.0, 0.0, 0.0, 0.0];
    let scaled = |min: f64, max: f64| {
        let scale = sturz_engine::scene::ScaleLaw::Uniform { min, max };
        Command::Insert(InsertionDescription { scale, ..insertion.clone() })
    };
    let bad = [
        ("NaN position", at([f64::NAN, 0.0, 1.0], good_turn), "positions_m[0]"),
        ("infinite position", at([0.0, f64::INFINITY, 1.0], good_turn), "positions_m[0]"),
        ("zero quaternion", at([0.0, 0.0, 1.0], [0.0; 4]), "orientations_wxyz[0]"),
        ("quaternion of norm 1.1", at([0.0, 0.0, 1.0], [1.1, 0.0, 0.0, 0.0]), "orientations_wxyz[0]"),
        ("NaN quaternion", at([0.0, 0.0, 1.0], [f64::NAN, 0.0, 0.0, 1.0]), "orientations_wxyz[0]"),
        ("negative scale", scaled(-1.0, 1.0), "scale"),
        ("NaN scale", scaled(f64::NAN, 1.0), "scale"),
        ("scale that the time step cannot follow", scaled(1e-6, 1e-6), "insert"),
        ("unknown id", Command::Remove(vec![0, 77]), "remove.ids[1]"),
        ("infinite gravity", Command::SetGravity([0.0, f64::INFINITY, 0.0]), "set_gravity"),
    ];
    for (name, command, path) in bad {
        let refusal = engine.apply(&command).err().map_or(String::new(), |error| error.path);
        checks.holds(format!("{name} is refused at {path}"), refusal.contains(path));
        checks.holds(format!("{name} leaves the state hash"), engine.state_hash() == before);
    }
    Ok(())
}
