//! Texts: settings, limits, scenes, shapes of Rockable.

use std::path::Path;

use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::shape::{Shape, rockable_shapes};
use sturz_service::cli;
use sturz_service::config::Limits;
use sturz_service::scenes::BUNDLED;

use crate::decoders::world::SCENE;

fn bytes<const N: usize>(texts: [&str; N]) -> anyhow::Result<Vec<Vec<u8>>> {
    Ok(texts.map(|text| text.as_bytes().to_vec()).to_vec())
}

/// As a file of settings, and as one of limits.
pub fn read_settings(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    drop(cli::check_file(Path::new("settings.toml"), text));
    if let Ok(table) = text.parse() {
        drop(Limits::from_table(table));
    }
}

/// Every setting, and every limit.
pub fn settings() -> anyhow::Result<Vec<Vec<u8>>> {
    let limits = toml::to_string(&Limits::default())?;
    let settings = "name = \"drum\"\nlisten = [\"tls/0.0.0.0:7447\"]\nconnect = []\ntls = \"lab\"\ninsecure = false\n\
                    config = \"zenoh.json5\"\nmetrics = \"127.0.0.1:9464\"\njournal = \"runs/drum\"\n\
                    journal_fsync = \"command\"\njournal_keep = 1073741824\ncheckpoint_every = 60.0\nthreads = 2\n\
                    paused = true\n\n[limits]\nclients = 20\n";
    bytes([settings, &limits, "checkpoints = \"saved\"\njournal_keep = \"all\"\n"])
}

/// As a scene.
pub fn read_scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(description) = SceneDescription::from_toml(text) {
        drop(Scene::validate(description));
    }
}

/// The bundled ones.
pub fn scenes() -> anyhow::Result<Vec<Vec<u8>>> {
    let mut all = vec![SCENE.as_bytes().to_vec()];
    all.extend(BUNDLED.iter().map(|scene| scene.text.as_bytes().to_vec()));
    Ok(all)
}

/// As shapes of Rockable.
pub fn read_rockable(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    for shape in rockable_shapes(text).into_iter().flatten() {
        drop(Shape::build(&shape.description));
    }
}

/// A tetrahedron with all that its format has.
pub fn rockables() -> anyhow::Result<Vec<Vec<u8>>> {
    bytes([
        "<\nname Tetra\nradius 0.1\npreCompDone y\nnv 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\nne 6\n0 1\n0 2\n0 3\n1 2\n1 3\n2 3\n\
         nf 4\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\nobb.extent 0.6 0.6 0.6\nobb.e1 1 0 0\nobb.e2 0 1 0\nobb.e3 0 0 1\n\
         obb.center 0.5 0.5 0.5\nposition 0.25 0.25 0.25\norientation 1 0 0 0\nvolume 0.1666\nI/m 0.1 0.1 0.1\n>\n",
    ])
}
