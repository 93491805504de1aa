//! Scenes that come with the program, and scenes from files.

use std::path::Path;
use std::sync::Arc;

use sturz_engine::scene::{FileBytes, Scene, SceneDescription, StartSection};

use crate::commands::Failure;

/// A scene that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct Bundled {
    /// Its name on the command line.
    pub name: &'static str,
    /// The scene file.
    pub text: &'static str,
}

macro_rules! bundled {
    ($($name:literal),* $(,)?) => {
        /// All of them.
        pub const BUNDLED: &[Bundled] =
            &[$(Bundled { name: $name, text: include_str!(concat!("../scenes/", $name, ".toml")) }),*];
    };
}

bundled!(
    "bagnold-spheres",
    "bouncing-sphere",
    "chute-spherocylinders",
    "cube-heap",
    "cube-tower",
    "drum-crosses",
    "drum-lifters",
    "drum-shapes",
    "drum-spheres",
    "free-top",
    "incline-pinacoids",
    "packing-pinacoids",
    "pinacoid-layer",
    "porosity-shapes",
    "rolling-sphere",
    "silo-discharge",
    "silo-janssen",
    "spherocylinder-slope"
);

impl Bundled {
    /// The one of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        BUNDLED.iter().find(|scene| scene.name == name)
    }

    /// What the file says.
    pub fn description(&self) -> Result<SceneDescription, Failure> {
        SceneDescription::from_toml(self.text).map_err(|error| Failure::Scene(format!("{}: {error}", self.name)))
    }
}

/// Reads a bundled scene or a file.
pub fn read(scene: &str) -> Result<SceneDescription, Failure> {
    read_with_files(scene, |_| {})
}

/// The same with the bed of its `[start]` left alone.
fn read_without_start(scene: &str) -> Result<SceneDescription, Failure> {
    read_with_files(scene, |description| description.start = None)
}

fn read_with_files(scene: &str, change: impl FnOnce(&mut SceneDescription)) -> Result<SceneDescription, Failure> {
    if let Some(bundled) = Bundled::named(scene) {
        return bundled.description();
    }
    let path = Path::new(scene);
    let text = std::fs::read_to_string(path).map_err(|error| {
        let names: Vec<&str> = BUNDLED.iter().map(|bundled| bundled.name).collect();
        Failure::Scene(format!("{scene}: {error}. It is no bundled scene either: those are {}", names.join(", ")))
    })?;
    let described = SceneDescription::from_toml(&text);
    let mut description = described.map_err(|error| Failure::Scene(format!("{scene}: {}", error.problem)))?;
    change(&mut description);
    let folder = path.parent().unwrap_or(Path::new(""));
    let files = description.read_files(|name| std::fs::read(folder.join(name)));
    files.map_err(|problems| Failure::Scene(format!("{scene} cannot be used:\n{problems}")))?;
    Ok(description)
}

/// Reads a scene and proves it usable.
pub fn load(scene: &str) -> Result<Scene, Failure> {
    Scene::validate(read(scene)?).map_err(|problems| Failure::Scene(format!("{scene} cannot be used:\n{problems}")))
}

/// The same, starting with the bed of a file that `sturz prepare` has written, where one is given.
pub fn load_from(scene: &str, from: Option<&Path>) -> Result<Scene, Failure> {
    let Some(from) = from else { return load(scene) };
    let bytes = std::fs::read(from).map_err(|error| Failure::Usage(format!("--from {}: {error}", from.display())))?;
    let start = StartSection { checkpoint: from.display().to_string(), bytes: FileBytes(Arc::new(bytes)) };
    let description = SceneDescription { start: Some(start), ..read_without_start(scene)? };
    Scene::validate(description).map_err(|problems| Failure::Scene(format!("{scene} cannot be used:\n{problems}")))
}

/// Last part of the name or path, as a name on the bus.
pub fn instance_name(scene: &str) -> String {
    let stem = Path::new(scene).file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy());
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    stem.chars().take(sturz_protocol::keys::MAX_NAME_BYTES).map(plain).collect()
}

#[cfg(test)]
mod tests {
    use sturz_engine::Engine;

    use super::*;

    #[test]
    fn every_bundled_scene_is_usable_without_doubt_and_runs() {
        for bundled in BUNDLED {
            let scene = load(bundled.name).unwrap_or_else(|failure| panic!("{failure}"));
            assert!(!scene.description().scene.description.is_empty(), "{}: no description", bundled.name);
            assert_eq!(scene.check().warnings, Vec::<String>::new(), "{}", bundled.name);
            let mut engine = Engine::new(scene);
            for _ in 0..200 {
                engine.step().unwrap_or_else(|failure| panic!("{}: {failure}", bundled.name));
            }
        }
    }

    /// Files lie beside the scene; a wrong one is named with its place.
    #[test]
    fn shapes_out_of_files_are_read_beside_the_scene() {
        let folder = std::env::temp_dir().join(format!("sturz-scenes-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let scene = folder.join("rocks.toml");
        let text = "[scene]\nname = \"rocks\"\nseed = 1\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\ntime_step = \"auto\"\n\
                    [[material]]\nname = \"m\"\ndensity_kg_per_m3 = 1000.0\n\
                    [[material_pair]]\nmaterials = [\"m\", \"m\"]\nstiffness_n_per_m = 1e6\nrestitution = 0.5\n\
                    [[shape]]\nname = \"s\"\ngeometry = { kind = \"file\", path = \"rock.obj\", scale = 1e-3 }\n";
        std::fs::write(&scene, text).unwrap();
        let rock = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
        std::fs::write(folder.join("rock.obj"), rock).unwrap();
        let loaded = load(scene.to_str().unwrap()).unwrap_or_else(|failure| panic!("{failure}"));
        assert!((loaded.shapes()[0].mass_properties().volume / (1e-9 / 6.0) - 1.0).abs() < 1e-12);
        std::fs::write(folder.join("rock.obj"), rock.replace("f 2 3 4\n", "")).unwrap();
        let refusal = load(scene.to_str().unwrap()).err().map(|failure| failure.to_string()).unwrap();
        assert!(refusal.contains("shape[0].geometry.path") && refusal.contains("is open"), "{refusal}");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn an_unknown_scene_is_refused_with_the_names_that_there_are() {
        let refusal = read("no-such-scene").unwrap_err();
        assert_eq!(refusal.exit_code(), 3);
        assert!(refusal.to_string().contains("drum-crosses"));
    }

    #[test]
    fn paths_become_names() {
        assert_eq!(instance_name("folder/my scene.v2.toml"), "my-scene-v2");
        assert_eq!(instance_name("drum-crosses"), "drum-crosses");
    }
}
