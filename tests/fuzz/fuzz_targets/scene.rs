//! Text as a scene file: a scene or a list of what is wrong.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sturz_engine::scene::{Scene, SceneDescription};

fuzz_target!(|text: &str| {
    if let Ok(description) = SceneDescription::from_toml(text) {
        let _ = Scene::validate(description);
    }
});
