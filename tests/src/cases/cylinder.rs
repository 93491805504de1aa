//! Cylinders with flat caps: P0.2 and P0.6 (mass), G1 and WP4 (impacts on a wall), I11 (rolling), elastic impacts.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};
use sturz_engine::shape::{PartDescription, Shape, ShapeDescription};

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("P0.2", "cylinder, and two that cross (P0.6): mass properties", mass_properties),
        Case::fast("G1", "cylinder hits a wall: spin and speed over the angle", impact_table),
        Case::fast("WP4", "cylinder hits a wall at 20 deg: over time step and stiffness", work_precision),
        Case::fast("G1-energy", "cylinder hits a wall without damping: energy", elastic_impacts),
        Case::fast("I11-cylinder", "slope: cylinder rolls", rolling),
    ]
}

/// Of seed 001, Table 1: R, L, M; gamma = 927.88 1/s in c = 2 gamma M for e = 0.85 at k = 1e5, and Tc.
const RADIUS: f64 = 4e-3;
const LENGTH: f64 = 5.3e-3;
const MASS: f64 = 3.1e-4;
const STIFFNESS: f64 = 1e5;
const GAMMA: f64 = 927.88;
const DURATION_S: f64 = 1.7515e-4;

fn density() -> f64 {
    MASS / (PI * RADIUS * RADIUS * LENGTH)
}

/// P0.2 of PHYSICS.md in closed form; P0.6 to what the lattice states (its figures: 1.8e-5, 5.7e-5, 5.1e-5).
fn mass_properties(checks: &mut Checks) -> anyhow::Result<()> {
    let shape = Shape::build(&ShapeDescription::Cylinder { radius_m: RADIUS, length_m: LENGTH })?;
    let properties = shape.mass_properties();
    let inertia = properties.principal_inertia * (MASS / properties.volume);
    checks.close("V", properties.volume, PI * RADIUS * RADIUS * LENGTH, 1e-12, "m3");
    checks.close("V, table", properties.volume, 2.66407e-7, 2e-6, "m3");
    checks.close("I axis", inertia.x, 0.5 * MASS * RADIUS * RADIUS, 1e-12, "kg m2");
    checks.close("I across", inertia.y, MASS * (3.0 * RADIUS * RADIUS + LENGTH * LENGTH) / 12.0, 1e-12, "kg m2");
    checks.close("I across, table", inertia.y, 1.96566e-9, 3e-6, "kg m2");
    let turned = |orientation_wxyz: [f64; 4]| PartDescription {
        shape: Box::new(ShapeDescription::Cylinder { radius_m: 1.0, length_m: 3.0 }),
        position_m: [0.0; 3],
        orientation_wxyz,
    };
    let half = 0.5f64.sqrt();
    let parts = vec![turned([1.0, 0.0, 0.0, 0.0]), turned([half, 0.0, 0.0, half])];
    let crossed = Shape::build(&ShapeDescription::Composite { parts, mass_properties: None })?;
    let properties = crossed.mass_properties();
    let relative = properties.relative_error;
    checks.vanishes("two crossed: stated error", relative, 2e-4, "-");
    checks.close("two crossed: V", properties.volume, 13.516222588, relative, "m3");
    checks.close("two crossed: Ixx", properties.principal_inertia.x, 11.648278052, relative, "m5");
    checks.close("two crossed: Izz", properties.principal_inertia.z, 16.005111477, relative, "m5");
    Ok(())
}

/// An impact without gravity and friction.
struct Impact {
    /// Of the axis to the normal.
    theta: f64,
    stiffness: f64,
    /// c = 2 gamma M.
    gamma: f64,
    /// `contact_end` and `sharing`.
    contact: String,
    steps_per_contact: f64,
    /// Way to the wall, in steps.
    phase: f64,
}

impl Impact {
    /// With the raw damping of the table, scaled as it scales with the stiffness.
    fn new(degrees: f64, stiffness: f64, end: &str) -> Self {
        let gamma = GAMMA * (stiffness / STIFFNESS).sqrt();
        let contact = format!("contact_end = \"{end}\"");
        Self { theta: degrees.to_radians(), stiffness, gamma, contact, steps_per_contact: 200.0, phase: 0.5 }
    }

    /// Spin (positive where theta grows) and speed when the contact is over.
    fn rebound(&self, checks: &mut Checks) -> anyhow::Result<(f64, f64)> {
        let dt = DURATION_S * (STIFFNESS / self.stiffness).sqrt() / self.steps_per_contact;
        let damping = 2.0 * self.gamma * MASS;
        let law = format!("stiffness_n_per_m = {:?}\ndamping_n_s_per_m = {damping:?}", self.stiffness);
        let height = 0.5 * LENGTH * self.theta.cos() + RADIUS * self.theta.sin();
        // about y, from the axis along x to the axis at theta to z
        let (sine, cosine) = (0.5 * (self.theta - FRAC_PI_2)).sin_cos();
        let mut engine = SceneText::new([0.0; 3], &format!("time_step_s = {dt:?}"))
            .contact(&self.contact)
            .materials(density(), &law)
            .shape(&format!("kind = \"cylinder\", radius_m = {RADIUS:?}, length_m = {LENGTH:?}"))
            .floor()
            .section(&format!(
                "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nvelocity_m_per_s = [0.0, 0.0, -1.0]\n\
                 placement = {{ method = \"poses\", positions_m = [[0.0, 0.0, {:?}]], \
                 orientations_wxyz = [[{cosine:?}, 0.0, {sine:?}, 0.0]] }}",
                height + self.phase * dt
            ))
            .start()?;
        let mut touched = false;
        for _ in 0..(6.0 * self.steps_per_contact) as u32 {
            checks.steps(&mut engine, 1)?;
            let touches = engine.report().touching_boundary_pairs > 0;
            // before the other rim comes down
            if touched && !touches {
                break;
            }
            touched |= touches;
        }
        let state = snapshot(&engine);
        Ok((state.angular_velocities[0][1], state.velocities[0][2]))
    }
}

/// G1 against the ODE of one rim point (oracles/impact.py `soft`), dt = Tc/200. Its rows at 0.01 and 89.99 deg are left
/// out: there all of the cap, or both rims, sink in. Exactly flat and exactly on the side nothing spins.
fn impact_table(checks: &mut Checks) -> anyhow::Result<()> {
    let table = [
        (10.0, [-330.553, -0.39986], [-332.877, -0.39570]),
        (20.0, [-350.093, -0.22685], [-352.091, -0.22253]),
        (40.0, [-306.793, 0.40258], [-307.859, 0.40717]),
        (50.0, [-154.439, 0.76009], [-154.877, 0.76467]),
        (60.0, [87.300, 0.82227], [87.540, 0.82683]),
        (80.0, [347.783, 0.13626], [349.228, 0.14078]),
    ];
    for (degrees, tension, clipped) in table {
        for (end, [spin, speed]) in [("tension", tension), ("clip", clipped)] {
            let (w, v) = Impact::new(degrees, STIFFNESS, end).rebound(checks)?;
            checks.close(format!("{degrees} deg, {end}: w+"), w, spin, 5e-3, "rad/s");
            checks.near(format!("{degrees} deg, {end}: V+"), v, speed, 5e-3, "m/s");
        }
    }
    for degrees in [0.0, 90.0] {
        let (w, v) = Impact::new(degrees, STIFFNESS, "tension").rebound(checks)?;
        checks.vanishes(format!("{degrees} deg exactly: w+"), w, 1e-9, "rad/s");
        checks.close(format!("{degrees} deg exactly: V+"), v, 0.85, 1e-4, "m/s");
    }
    Ok(())
}

/// WP4: error of w+ at 20 deg over 16 phases of the instant of impact against the soft ODE, and w+ over the stiffness
/// against the ODE and the limit of hard contacts, eq. 22 with e_eff.
///
/// The dashpot makes the force jump where the contact begins and, with tension, where it ends. Either jump falls anywhere
/// within a step (this contact does not last Tc), so a single impact is off in the first order, and the mean over the
/// phases in the second.
fn work_precision(checks: &mut Checks) -> anyhow::Result<()> {
    let mut errors = Vec::new();
    let mut curve = Vec::new();
    for steps in [25.0, 50.0, 100.0, 200.0, 400.0] {
        checks.loop_time_s();
        let (mean, error) = over_phases(checks, STIFFNESS, steps, -350.0934)?;
        curve.push((1.0 / steps, checks.loop_time_s(), error));
        checks.vanishes(format!("Tc/{steps}: mean error of w+"), error, 0.2 / steps, "-");
        checks.vanishes(format!("Tc/{steps}: error of the mean w+"), mean / -350.0934 - 1.0, 0.05 / steps, "-");
        errors.push(error);
    }
    checks.work_precision("error of w+ against the soft ODE", "time step over contact duration", "k = 1e5", &curve);
    checks.near("order, Tc/25 to Tc/400", (errors[0] / errors[4]).log2() / 4.0, 1.0, 0.15, "-");
    let soft = [(1e4, -348.007), (1e5, -350.093), (1e6, -350.774), (1e7, -350.991), (1e8, -351.060)];
    let mut gaps = Vec::new();
    let mut to_hard = Vec::new();
    for (stiffness, reference) in soft {
        checks.loop_time_s();
        let (mean, _) = over_phases(checks, stiffness, 800.0, reference)?;
        to_hard.push((stiffness, checks.loop_time_s(), (mean / -351.092 - 1.0).abs()));
        checks.close(format!("k = {stiffness:e}: w+"), mean, reference, 3e-5, "rad/s");
        gaps.push(mean + 351.092);
    }
    checks.work_precision("gap of w+ to hard contacts", "stiffness, N/m", "Tc/800", &to_hard);
    equal_cost(checks)?;
    checks.near("order of the gap to hard contacts in k", (gaps[0] / gaps[2]).log10() / 2.0, 0.5, 0.05, "-");
    Ok(())
}

/// Error to hard contacts over the run time, one line for each number of steps per contact: a stiffer contact costs more and
/// is harder, more steps cost more and are more exact, so each run time has its own best pair of the two.
fn equal_cost(checks: &mut Checks) -> anyhow::Result<()> {
    for steps in [25.0, 100.0, 400.0] {
        let mut points = Vec::new();
        for stiffness in [1e4, 1e5, 1e6, 1e7] {
            checks.loop_time_s();
            let (_, error) = over_phases(checks, stiffness, steps, -351.092)?;
            points.push((checks.loop_time_s(), error));
        }
        let axes = ("wall time of the physics loop, s", "error of w+ against hard contacts");
        checks.draws("k from 1e4 to 1e7 N/m along each line", axes, format!("Tc/{steps}"), points);
    }
    Ok(())
}

/// Mean w+, and mean of the relative error of each.
fn over_phases(checks: &mut Checks, stiffness: f64, steps: f64, reference: f64) -> anyhow::Result<(f64, f64)> {
    let (mut mean, mut error) = (0.0, 0.0);
    for k in 0..16 {
        let phase = (f64::from(k) + 0.37) / 16.0;
        let impact = Impact { steps_per_contact: steps, phase, ..Impact::new(20.0, stiffness, "tension") };
        let w = impact.rebound(checks)?.0;
        mean += w / 16.0;
        error += (w / reference - 1.0).abs() / 16.0;
    }
    Ok((mean, error))
}

/// Largest |E'/E - 1| of impacts without damping at tilts from flat to the side, with free spins.
///
/// Springs of their own (`model_a`) have an energy, and the error vanishes with the square of the step. Springs that share
/// the stiffness of one (`per_point`) have none while they are several: 8.1 % at any step. At one point both agree.
fn elastic_impacts(checks: &mut Checks) -> anyhow::Result<()> {
    for (sharing, limits) in [("model_a", [5e-3, 3e-4, 2e-5]), ("per_point", [0.1; 3])] {
        for (steps, limit) in [50.0, 200.0, 800.0].into_iter().zip(limits) {
            let (mut worst, mut worst_single) = (0.0f64, 0.0f64);
            for k in 0..40 {
                let degrees = if k < 30 { 0.02 * f64::from(k) } else { 89.7 + 0.03 * f64::from(k - 30) };
                worst = worst.max(energy_change(checks, sharing, degrees, steps)?);
                worst_single = worst_single.max(energy_change(checks, sharing, 5.0 + f64::from(2 * k), steps)?);
            }
            checks.vanishes(format!("{sharing}, Tc/{steps}: several points"), worst, limit, "-");
            checks.vanishes(format!("{sharing}, Tc/{steps}: one point"), worst_single, 3.0 / (steps * steps), "-");
        }
    }
    Ok(())
}

fn energy_change(checks: &mut Checks, sharing: &str, degrees: f64, steps: f64) -> anyhow::Result<f64> {
    let contact = format!("contact_end = \"tension\"\nsharing = \"{sharing}\"");
    let impact = Impact {
        gamma: 0.0,
        contact,
        steps_per_contact: steps,
        phase: 0.37,
        ..Impact::new(degrees, STIFFNESS, "clip")
    };
    let (w, v) = impact.rebound(checks)?;
    let inertia = MASS * (3.0 * RADIUS * RADIUS + LENGTH * LENGTH) / 12.0;
    Ok((v * v + inertia / MASS * w * w - 1.0).abs())
}

/// I11: without slip a = 2/3 g sin th up to tan th = 3 mu; beyond, g (sin th - mu cos th).
fn rolling(checks: &mut Checks) -> anyhow::Result<()> {
    const G: f64 = 9.81;
    let (radius, length, density, stiffness, mu) = (0.01, 0.03, 2500.0, 1e6, 0.3f64);
    for (part, rolls) in [(0.3, true), (0.95, true), (1.05, false)] {
        let theta = (part * 3.0 * mu).atan();
        let mass = density * PI * radius * radius * length;
        let overlap = mass * G * theta.cos() / stiffness;
        let half = 0.5f64.sqrt();
        let mut engine = SceneText::new([G * theta.sin(), 0.0, -G * theta.cos()], "time_step_s = 5e-6")
            .materials(density, "stiffness_n_per_m = 1e6\nrestitution = 0.5\nfriction = 0.3")
            .shape(&format!("kind = \"cylinder\", radius_m = {radius:?}, length_m = {length:?}"))
            .floor()
            .poses("s", &[[0.0, 0.0, radius - overlap]], &[[half, 0.0, 0.0, half]])
            .start()?;
        checks.run_for(&mut engine, 0.1)?;
        let before = snapshot(&engine).velocities[0][0];
        checks.run_for(&mut engine, 0.2)?;
        let state = snapshot(&engine);
        let acceleration = (state.velocities[0][0] - before) / 0.2;
        let (verb, expected) = if rolls {
            ("rolls", 2.0 / 3.0 * G * theta.sin())
        } else {
            ("slides", G * (theta.sin() - mu * theta.cos()))
        };
        checks.close(format!("{verb} at {part} of 3 mu: acceleration"), acceleration, expected, 1e-3, "m/s2");
        if rolls {
            let slip = (radius - 0.5 * overlap) * state.angular_velocities[0][1] - state.velocities[0][0];
            checks.vanishes(format!("rolls at {part} of 3 mu: slip"), slip, 1e-5, "m/s");
        }
        let [x, _, z] = state.angular_velocities[0];
        checks.vanishes(format!("{verb} at {part} of 3 mu: turns aside"), x.abs().max(z.abs()), 1e-9, "rad/s");
    }
    Ok(())
}
