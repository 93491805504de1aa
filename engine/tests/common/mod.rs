//! Scenes of the tests.
#![allow(dead_code)]

use sturz_engine::Engine;
use sturz_engine::scene::{Scene, SceneDescription};

/// Starts a scene from text.
pub fn engine(text: &str) -> Engine {
    let description = SceneDescription::from_toml(text).unwrap_or_else(|error| panic!("{error}"));
    Engine::new(Scene::validate(description).unwrap_or_else(|error| panic!("{error}")))
}

/// Does `n` steps.
pub fn steps(engine: &mut Engine, n: u64) {
    engine.in_pool(|engine| (0..n).for_each(|_| engine.step().unwrap_or_else(|error| panic!("{error}"))));
}

/// Steps to the time, exactly.
pub fn run_for(engine: &mut Engine, duration_s: f64) {
    let n = engine.begin_window(duration_s).unwrap();
    steps(engine, n);
    engine.end_window();
}

/// Header of a scene with one material `m` (density 2500) on itself and on a wall material `w`.
pub fn header(gravity: [f64; 3], dt: f64, contact: &str, pair: &str) -> String {
    format!(
        r#"
[scene]
name = "test"
gravity_m_per_s2 = {gravity:?}
time_step_s = {dt:?}
[contact]
{contact}
[[material]]
name = "m"
density_kg_per_m3 = 2500.0
[[material]]
name = "w"
[[material_pair]]
materials = ["m", "m"]
{pair}
[[material_pair]]
materials = ["m", "w"]
{pair}
"#
    )
}

/// A shape named `s`.
pub fn shape(geometry: &str) -> String {
    format!("[[shape]]\nname = \"s\"\ngeometry = {{ {geometry} }}\n")
}

/// A plane through `point` with `normal`.
pub fn plane(name: &str, point: [f64; 3], normal: [f64; 3]) -> String {
    format!(
        "[[boundary]]\nname = \"{name}\"\nmaterial = \"w\"\ngeometry = {{ kind = \"plane\", point_m = {point:?}, normal = {normal:?} }}\n"
    )
}

/// One particle of shape `s`.
pub fn particle(position: [f64; 3], velocity: [f64; 3], rate: [f64; 3]) -> String {
    format!(
        "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nvelocity_m_per_s = {velocity:?}\nangular_velocity_rad_per_s = {rate:?}\nplacement = {{ method = \"poses\", positions_m = [{position:?}] }}\n"
    )
}

/// 3D crosses in a drum that is periodic along its axis and turns: every part of the engine at work.
pub fn drum(count: u32) -> String {
    let beam = 5.1417e-3;
    format!(
        r#"
[scene]
name = "drum"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 2e-5
seed = 3
[domain]
min_m = [0.0, -0.012, 0.0]
max_m = [0.0, 0.012, 0.0]
periodic = [false, true, false]
[[material]]
name = "m"
density_kg_per_m3 = 2470.0
[[material_pair]]
materials = ["m", "m"]
stiffness_n_per_m = 1e3
restitution = 0.73
friction = 0.55
[[shape]]
name = "s"
geometry = {{ kind = "cross_3d", beam_length_m = {beam}, beam_width_m = 1.0283e-3 }}
[[boundary]]
name = "drum"
material = "m"
geometry = {{ kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.05 }}
motion = {{ kind = "rotation", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], angular_velocity = {{ kind = "constant", rad_per_s = 2.1 }} }}
[[insertion]]
shape = "s"
material = "m"
[insertion.placement]
method = "random"
count = {count}
region = {{ kind = "cylinder", point_m = [0.0, -0.015, -0.02], axis = [0.0, 1.0, 0.0], radius_m = 0.03, length_m = 0.03 }}
"#
    )
}

/// State hashes after each of `stretches`, on so many threads, with all that pairs know dropped every so many steps (0: never).
pub fn hashes_of(
    engine: &mut Engine,
    (stretches, length): (u64, u64),
    threads: usize,
    drop_caches_every: u64,
) -> Vec<u64> {
    engine.set_threads(threads);
    let mut done = 0;
    let mut stretch = || {
        for _ in 0..length {
            if drop_caches_every > 0 && done % drop_caches_every == 0 {
                engine.drop_caches();
            }
            steps(engine, 1);
            done += 1;
        }
        engine.state_hash()
    };
    (0..stretches).map(|_| stretch()).collect()
}

/// How the layers of a [`mixed_drum`] are filled, one over the other.
pub struct Filling {
    /// Particles of a layer.
    pub count: u32,
    /// More lines of each insertion.
    pub lines: &'static str,
    /// Half the width and half the length of a layer, m.
    pub half: [f64; 2],
    /// From one layer to the next, and thickness, m.
    pub heights: [f64; 2],
}

/// Particles of several shapes in a turning drum that is periodic along its axis.
pub fn mixed_drum(time_step_s: f64, shapes: &[(&str, String)], filling: &Filling) -> String {
    let mut text = format!(
        r#"
[scene]
name = "drum"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = {time_step_s:?}
seed = 3
[domain]
min_m = [0.0, -0.012, 0.0]
max_m = [0.0, 0.012, 0.0]
periodic = [false, true, false]
[[material]]
name = "m"
density_kg_per_m3 = 2470.0
[[material_pair]]
materials = ["m", "m"]
stiffness_n_per_m = 2e3
restitution = 0.6
friction = 0.5
[[boundary]]
name = "drum"
material = "m"
geometry = {{ kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.03 }}
motion = {{ kind = "rotation", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], angular_velocity = {{ kind = "constant", rad_per_s = 4.0 }} }}
"#
    );
    let Filling { count, lines, half: [x, y], heights: [step, thick] } = filling;
    for (k, (name, geometry)) in shapes.iter().enumerate() {
        let z = -0.022 + step * k as f64;
        text += &format!(
            "[[shape]]\nname = \"{name}\"\ngeometry = {{ {geometry} }}\n[[insertion]]\nshape = \"{name}\"\nmaterial = \"m\"\n{lines}\n\
             placement = {{ method = \"random\", count = {count}, region = {{ kind = \"box\", min_m = [{:?}, {:?}, {z:?}], max_m = [{x:?}, {y:?}, {:?}] }} }}\n",
            -x,
            -y,
            z + thick
        );
    }
    text
}
