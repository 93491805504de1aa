//! Scenes as text, put together from the parts that cases and workloads share.
//!
//! Text, not structs: the scene file is the public interface, and a new key with a default breaks nothing here.

use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Engine, InvalidInput, InvalidScene, Snapshot};

/// A scene file under construction: material `m` of the particles, `w` of the boundaries, shape `s`.
#[derive(Clone, Debug)]
pub struct SceneText {
    head: String,
    contact: String,
    rest: String,
}

impl SceneText {
    /// A scene with a gravity and a line for the time step, such as `time_step_s = 1e-5`.
    pub fn new(gravity_m_per_s2: [f64; 3], time_step: &str) -> Self {
        let head =
            format!("[scene]\nname = \"harness\"\nseed = 1\ngravity_m_per_s2 = {gravity_m_per_s2:?}\n{time_step}\n");
        Self { head, contact: String::new(), rest: String::new() }
    }

    /// The time step, where it was not given at once.
    pub fn time_step_s(mut self, time_step_s: f64) -> Self {
        self.head += &format!("time_step_s = {time_step_s:?}\n");
        self
    }

    /// Lines of `[contact]`.
    pub fn contact(mut self, lines: &str) -> Self {
        self.contact += &format!("{lines}\n");
        self
    }

    /// Any further sections.
    pub fn section(mut self, text: &str) -> Self {
        self.rest += &format!("{text}\n");
        self
    }

    /// Periodic cell; an axis with `min == max` is not periodic.
    pub fn cell(self, min_m: [f64; 3], max_m: [f64; 3]) -> Self {
        let periodic = [0, 1, 2].map(|axis| max_m[axis] > min_m[axis]);
        self.section(&format!("[domain]\nmin_m = {min_m:?}\nmax_m = {max_m:?}\nperiodic = {periodic:?}"))
    }

    /// Materials `m` (with this density) and `w`, and one law for both pairs.
    pub fn materials(self, density: f64, law: &str) -> Self {
        self.materials_apart(density, law, law)
    }

    /// Materials `m` and `w` with a law between particles and one against boundaries.
    pub fn materials_apart(self, density: f64, between: &str, against_walls: &str) -> Self {
        self.section(&format!(
            "[[material]]\nname = \"m\"\ndensity_kg_per_m3 = {density:?}\n[[material]]\nname = \"w\"\n\
             [[material_pair]]\nmaterials = [\"m\", \"m\"]\n{between}\n\
             [[material_pair]]\nmaterials = [\"m\", \"w\"]\n{against_walls}"
        ))
    }

    /// The shape `s`, such as `kind = "cube", edge_m = 1.0`.
    pub fn shape(self, geometry: &str) -> Self {
        self.named_shape("s", geometry)
    }

    /// A further shape.
    pub fn named_shape(self, name: &str, geometry: &str) -> Self {
        self.section(&format!("[[shape]]\nname = \"{name}\"\ngeometry = {{ {geometry} }}"))
    }

    /// A plane of material `w`.
    pub fn plane(self, name: &str, point_m: [f64; 3], normal: [f64; 3]) -> Self {
        self.section(&format!(
            "[[boundary]]\nname = \"{name}\"\nmaterial = \"w\"\n\
             geometry = {{ kind = \"plane\", point_m = {point_m:?}, normal = {normal:?} }}"
        ))
    }

    /// The plane z = 0.
    pub fn floor(self) -> Self {
        self.plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
    }

    /// One particle of shape `s` with velocity and angular velocity.
    pub fn particle(self, position_m: [f64; 3], velocity: [f64; 3], angular_velocity: [f64; 3]) -> Self {
        self.section(&format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nvelocity_m_per_s = {velocity:?}\n\
             angular_velocity_rad_per_s = {angular_velocity:?}\n\
             placement = {{ method = \"poses\", positions_m = [{position_m:?}] }}"
        ))
    }

    /// Particles of a shape at rest at given poses; unrotated when there are no orientations.
    pub fn poses(self, shape: &str, positions_m: &[[f64; 3]], orientations_wxyz: &[[f64; 4]]) -> Self {
        self.section(&format!(
            "[[insertion]]\nshape = \"{shape}\"\nmaterial = \"m\"\n\
             placement = {{ method = \"poses\", positions_m = {positions_m:?}, orientations_wxyz = {orientations_wxyz:?} }}"
        ))
    }

    /// The file.
    pub fn text(&self) -> String {
        format!("{}[contact]\n{}{}", self.head, self.contact, self.rest)
    }

    /// The scene, or what is wrong with it.
    pub fn validate(&self) -> Result<Scene, InvalidScene> {
        let one = |error: InvalidInput| InvalidScene(vec![error]);
        Scene::validate(SceneDescription::from_toml(&self.text()).map_err(one)?)
    }

    /// The engine at step 0.
    pub fn start(&self) -> anyhow::Result<Engine> {
        Ok(Engine::new(self.validate()?))
    }
}

/// The state now.
pub fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

/// Does `n` steps inside the engine's pool.
pub fn steps(engine: &mut Engine, n: u64) -> anyhow::Result<()> {
    engine.in_pool(|engine| (0..n).try_for_each(|_| engine.step()))?;
    Ok(())
}
