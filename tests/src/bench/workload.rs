//! The workloads W1 to W4: beds of spheres, cubes, pinacoids, crosses and spherocylinders; rounded ones in `given`.

use std::f64::consts::PI;

use anyhow::bail;

use super::cache::Bed;
use crate::scene::SceneText;

/// Acceleration of gravity, m/s2.
pub const GRAVITY: f64 = 9.81;

/// How much of a workload is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// As specified; what results are quoted for.
    Full,
    /// A few dozen particles, but given beds whole: for tests of the program itself.
    Small,
}

/// A bed under gravity: one shape, in a periodic cell over a floor or in an open box.
///
/// All have `contact_end = "tension"`: then the restitution of 0.1 or exp(-0.6) is that of the dashpot which other
/// programs derive from it (PHYSICS.md A.3), and sharing and skin are the engine's defaults.
#[derive(Clone, Debug, PartialEq)]
pub struct Workload {
    /// Name on the command line.
    pub name: &'static str,
    /// Shape, as in a scene file.
    pub geometry: String,
    /// Range of the homothety.
    pub scale: [f64; 2],
    /// Particles.
    pub count: u32,
    /// Side of the square floor, m.
    pub side_m: f64,
    /// Periodic in x and y instead of walled.
    pub periodic: bool,
    /// kg/m3
    pub density: f64,
    /// Volume at scale 1, m3.
    pub volume_m3: f64,
    /// Size of a particle, m: unit of overlaps and of energies (m g size).
    pub size_m: f64,
    /// Normal stiffness, N/m; the tangential one is 2/7 of it.
    pub stiffness: f64,
    /// Coulomb coefficient between particles, and at walls.
    pub friction: [f64; 2],
    /// Tangential over normal stiffness.
    pub tangential_stiffness_ratio: f64,
    /// Restitution.
    pub restitution: f64,
    /// Time step, s.
    pub time_step_s: f64,
    /// Solid fraction of the random insertion that the bed settles from.
    pub loose_fraction: f64,
    /// Whether a relaxed bed comes with the program: [`super::given`].
    pub is_given: bool,
}

/// Parameters that change while a bed settles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// Stiffness over the workload's.
    pub stiffness: f64,
    /// Time step over the critical one; the workload's own step when `None`.
    pub step_fraction: Option<f64>,
    /// Restitution; the workload's own when `None`.
    pub restitution: Option<f64>,
}

impl Softness {
    /// The workload as specified.
    pub const NONE: Self = Self { stiffness: 1.0, step_fraction: None, restitution: None };
}

impl Workload {
    /// Names on the command line.
    pub const NAMES: [&str; 8] = ["W1", "W2-cubes", "W2-pinacoids", "W2r", "R-octahedra", "W3", "W3r", "W4"];

    /// The workload of a name.
    pub fn named(name: &str, size: Size) -> anyhow::Result<Self> {
        let mut workload = match name {
            "W1" => spheres(),
            "W2-cubes" => polyhedra("W2-cubes", "kind = \"cube\", edge_m = 1.0", 1.0),
            "W2-pinacoids" => polyhedra(
                "W2-pinacoids",
                "kind = \"pinacoid\", length_m = 1.0, width_m = 1.0, height_m = 1.0, alpha_deg = 60.0",
                (3.0 - 1.0 / 3f64.sqrt()) / 6.0,
            ),
            "W3" => crosses(),
            "W4" => spherocylinders(),
            "W2r" => super::given::rounded_cubes(),
            "R-octahedra" => super::given::octahedra(),
            "W3r" => super::given::rounded_crosses(),
            _ => bail!("no workload '{name}'; there are {:?} and all", Self::NAMES),
        };
        if size == Size::Small && !workload.is_given {
            // A sixteenth of the floor and a quarter of the height.
            workload.side_m /= 4.0;
            workload.count /= 64;
            workload.loose_fraction /= 2.0;
        }
        Ok(workload)
    }

    /// Mass at scale 1, kg.
    pub fn mass(&self) -> f64 {
        self.density * self.volume_m3
    }

    /// m g size, J: the unit of energies per particle.
    pub fn energy_unit_j(&self) -> f64 {
        self.mass() * GRAVITY * self.size_m
    }

    /// Height that the random insertion fills, m.
    pub fn loose_height_m(&self) -> f64 {
        f64::from(self.count) * self.volume_m3 / (self.side_m * self.side_m * self.loose_fraction)
    }

    /// Without particles.
    pub fn scene(&self, softness: Softness) -> SceneText {
        let time_step = match softness.step_fraction {
            Some(fraction) => format!("time_step_fraction = {fraction:?}"),
            None => format!("time_step_s = {:?}", self.time_step_s),
        };
        let law = |friction: f64| {
            format!(
                "stiffness_n_per_m = {:?}\nrestitution = {:?}\nfriction = {friction:?}\ntangential_stiffness_ratio = {:?}",
                self.stiffness * softness.stiffness,
                softness.restitution.unwrap_or(self.restitution),
                self.tangential_stiffness_ratio
            )
        };
        let limit = if softness.stiffness < 1.0 { 2.0 } else { 0.3 };
        let scene = SceneText::new([0.0, 0.0, -GRAVITY], &time_step)
            .contact(&format!("contact_end = \"tension\"\noverlap_limit = {limit:?}"))
            .materials_apart(self.density, &law(self.friction[0]), &law(self.friction[1]))
            .shape(&self.geometry)
            .floor();
        let side = self.side_m;
        if self.periodic {
            return scene.cell([0.0; 3], [side, side, 0.0]);
        }
        scene
            .plane("left", [0.0; 3], [1.0, 0.0, 0.0])
            .plane("right", [side, 0.0, 0.0], [-1.0, 0.0, 0.0])
            .plane("front", [0.0; 3], [0.0, 1.0, 0.0])
            .plane("back", [0.0, side, 0.0], [0.0, -1.0, 0.0])
    }

    fn insertion(&self, placement: &str) -> String {
        let [min, max] = self.scale;
        format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nscale = {{ min = {min:?}, max = {max:?} }}\n\
             placement = {{ {placement} }}"
        )
    }

    /// Random, without overlap, high above the floor.
    pub fn loose(&self, softness: Softness) -> SceneText {
        // Insertion keeps bounding spheres inside the region; across periodic faces they may overhang.
        let margin = if self.periodic { 0.5 * self.size_m * self.scale[1] } else { 0.0 };
        let (low, high) = (-margin, self.side_m + margin);
        let region = format!(
            "region = {{ kind = \"box\", min_m = [{low:?}, {low:?}, 0.0], max_m = [{high:?}, {high:?}, {:?}] }}",
            self.loose_height_m()
        );
        let placement = format!("method = \"random\", count = {}, {region}", self.count);
        self.scene(softness).section(&self.insertion(&placement))
    }

    /// The particles of a bed, at rest. Sizes are a function of the seed and the id, so they come out the same.
    pub fn from_bed(&self, bed: &Bed, softness: Softness) -> SceneText {
        let placement = format!(
            "method = \"poses\", positions_m = {:?}, orientations_wxyz = {:?}",
            bed.positions, bed.orientations
        );
        self.scene(softness).section(&self.insertion(&placement))
    }
}

/// W1: d 2 mm +- 10 %, kn = 2e5 m g/d, gamma_n = 1.2/Tc in c = gamma_n m_reduced, hence e = exp(-0.6); dt = Tc/50.
fn spheres() -> Workload {
    let (d, density) = (2e-3, 2500.0);
    let volume = PI / 6.0 * d * d * d;
    let stiffness = 2e5 * density * volume * GRAVITY / d;
    // Tc = pi / sqrt(2 k/m - gamma^2/4) with gamma = 1.2/Tc
    let duration = ((PI * PI + 0.36) / (2.0 * stiffness / (density * volume))).sqrt();
    Workload {
        name: "W1",
        geometry: format!("kind = \"sphere\", radius_m = {:?}", 0.5 * d),
        scale: [0.9, 1.1],
        count: 10_240,
        side_m: 20.0 * d,
        periodic: true,
        density,
        volume_m3: volume,
        size_m: d,
        stiffness,
        friction: [0.5; 2],
        tangential_stiffness_ratio: 2.0 / 7.0,
        restitution: (-0.6f64).exp(),
        time_step_s: duration / 50.0,
        loose_fraction: 0.25,
        is_given: false,
    }
}

/// W2: 2,500 of a polyhedron of size 1 m in a box of 18 x 18 m.
pub(super) fn polyhedra(name: &'static str, geometry: &str, volume_m3: f64) -> Workload {
    Workload {
        name,
        geometry: geometry.to_owned(),
        scale: [1.0, 1.0],
        count: 2500,
        side_m: 18.0,
        periodic: false,
        density: 1000.0,
        volume_m3,
        size_m: 1.0,
        stiffness: 1.3e9,
        friction: [0.5; 2],
        tangential_stiffness_ratio: 2.0 / 7.0,
        restitution: 0.1,
        time_step_s: 4e-5,
        loose_fraction: 0.2 * volume_m3,
        is_given: false,
    }
}

/// W3: 800 crosses of three boxes 1 x 0.2 x 0.2 m in a box of 12 x 12 m.
///
/// At 1.3e9 N/m and e = 0.1 a contact at the tip of a beam is stable up to 3.3e-5 s only (effective mass 10 kg, damping
/// ratio 1.3 there), so the step is 1e-5 s instead of the 4e-5 s of the others; the cost of a step does not depend on it.
fn crosses() -> Workload {
    let geometry = "kind = \"cross_3d\", beam_length_m = 1.0, beam_width_m = 0.2";
    Workload { count: 800, side_m: 12.0, loose_fraction: 0.06, time_step_s: 1e-5, ..polyhedra("W3", geometry, 0.104) }
}

/// W4: 5,000 spherocylinders of total length 3 m and diameter 1 m in a box of 30 x 30 m.
fn spherocylinders() -> Workload {
    let geometry = "kind = \"spherocylinder\", radius_m = 0.5, total_length_m = 3.0";
    let volume = PI * 0.25 * 2.0 + PI / 6.0;
    Workload { count: 5000, side_m: 30.0, loose_fraction: 0.15, ..polyhedra("W4", geometry, volume) }
}
