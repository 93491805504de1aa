//! Impacts of spheres under the linear law: I4, I6, I7 (sliding and sticking), WP2 and WP3 (error over dt).

use std::f64::consts::PI;

use super::{Case, Checks, oblique};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("I4", "oblique impact on a wall: sliding and sticking", oblique),
        Case::fast("I6", "spinning sphere on a wall: sliding", spinning_on_wall),
        Case::fast("I7", "two spinning spheres: sliding, and surfaces that do not slip", spinning_pair),
        Case::fast("WP2", "normal impact: error of restitution against time step", restitution_work_precision),
        Case::fast(
            "WP3",
            "oblique impact: error of e_t and spin against time step, by law of friction",
            oblique::work_precision,
        ),
    ]
}

/// So stiff that overlaps are below 1e-7 of the radius: the closed forms are those of hard spheres.
const STIFFNESS: f64 = 1e15;
/// A contact that is clipped at zero force ends within a step, which makes the scheme first order (PHYSICS.md A.4):
/// 2e-3 of e at 400 steps.
const STEPS_PER_CONTACT: f64 = 1600.0;

/// A ball for hard impacts.
struct Ball {
    radius: f64,
    density: f64,
}

impl Ball {
    fn mass(&self) -> f64 {
        self.density * 4.0 / 3.0 * PI * self.radius.powi(3)
    }

    /// Duration of an undamped impact on a wall, s.
    fn duration_s(&self) -> f64 {
        PI * (self.mass() / STIFFNESS).sqrt()
    }

    fn time_step_s(&self) -> f64 {
        self.duration_s() / STEPS_PER_CONTACT
    }

    /// A scene without gravity, with this law.
    fn scene(&self, law: &str) -> SceneText {
        SceneText::new([0.0; 3], &format!("time_step_s = {:?}", self.time_step_s()))
            .materials(self.density, &format!("stiffness_n_per_m = {STIFFNESS:?}\n{law}"))
            .shape(&format!("kind = \"sphere\", radius_m = {:?}", self.radius))
    }

    /// Steps until an impact that starts with touching spheres is over.
    fn steps(&self) -> u64 {
        (3.0 * STEPS_PER_CONTACT) as u64
    }
}

/// Velocity and angular velocity after an impact.
struct Rebound {
    normal: f64,
    tangential: f64,
    spin: f64,
}

/// Chung and Ooi (2011), test 4 with a linear law (PHYSICS.md I4): aluminium oxide, r = 2.5 mm, 3.9 m/s, mu = 0.092,
/// e = 0.98. Angles from the normal. Sliding from 32.52 deg on: e_t = 1 - mu (1 + e) / tan th,
/// omega = 2.5 mu (1 + e) v_n / r. Below: the ODE of oracles/chung_ooi.py with kt = 2/7 kn and no tangential dashpot,
/// which sticks and gives 3/7 up to about 15 deg.
fn oblique(checks: &mut Checks) -> anyhow::Result<()> {
    let (ball, mu) = (Ball { radius: 2.5e-3, density: 4000.0 }, 0.092);
    let mut hit = |degrees: f64, law: &str| -> anyhow::Result<(f64, Rebound)> {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let scene = ball.scene(&format!("friction = {mu:?}\n{law}")).floor();
        let velocity = [3.9 * sine, 0.0, -3.9 * cosine];
        let mut engine = scene.particle([0.0, 0.0, ball.radius], velocity, [0.0; 3]).start()?;
        checks.steps(&mut engine, ball.steps())?;
        let state = snapshot(&engine);
        let [tangential, _, normal] = state.velocities[0];
        Ok((3.9 * cosine, Rebound { normal, tangential, spin: state.angular_velocities[0][1] }))
    };
    let mut rows = Vec::new();
    for (degrees, digits) in
        [(35.0, (0.7398, 581.95)), (40.0, (0.7829, 544.22)), (60.0, (0.8948, 355.22)), (80.0, (0.9679, 123.36))]
    {
        let (v_n, rebound) = hit(degrees, "restitution = 0.98")?;
        rows.push((degrees, digits, v_n, rebound));
    }
    let mut sticking = Vec::new();
    for (degrees, e_t) in [(5.0, 3.0 / 7.0), (15.0, 0.4287), (20.0, 0.4997), (25.0, 0.6094)] {
        let (v_n, rebound) = hit(degrees, "restitution = 0.98\ntangential_damping_ratio = 0.0")?;
        sticking.push((degrees, e_t, rebound.tangential / (v_n * f64::to_radians(degrees).tan())));
    }
    for (degrees, (e_t, spin), v_n, rebound) in rows {
        // with the restitution that was reached: the identity holds at any time step
        let e = rebound.normal / v_n;
        let tangent = f64::to_radians(degrees).tan();
        let measured = rebound.tangential / (v_n * tangent);
        checks.close(format!("{degrees} deg: e_n"), e, 0.98, 1e-3, "-");
        checks.close(format!("{degrees} deg: e_t, identity"), measured, 1.0 - mu * (1.0 + e) / tangent, 1e-6, "-");
        checks.close(
            format!("{degrees} deg: omega, identity"),
            rebound.spin,
            2.5 * mu * (1.0 + e) * v_n / ball.radius,
            1e-6,
            "rad/s",
        );
        checks.close(format!("{degrees} deg: e_t, table"), measured, e_t, 5e-3, "-");
        checks.close(format!("{degrees} deg: omega, table"), rebound.spin, spin, 5e-3, "rad/s");
    }
    for (degrees, reference, measured) in sticking {
        checks.close(format!("{degrees} deg, sticks at first: e_t"), measured, reference, 5e-3, "-");
    }
    Ok(())
}

/// Chung and Ooi (2011), test 6 (PHYSICS.md I6): r w1/(mu v_n) >= 5.25 slides throughout: v_t' = mu (1 + e) v_n = 0.12,
/// w1' = w1 - 3.0, for a restitution that is calibrated for the rule of contact end.
fn spinning_on_wall(checks: &mut Checks) -> anyhow::Result<()> {
    for (name, density) in [("aluminium", 2700.0), ("copper", 8900.0)] {
        let ball = Ball { radius: 0.1, density };
        let scene = ball.scene("restitution = 0.5\nfriction = 0.4").floor();
        let mut engine = scene.particle([0.0, 0.0, ball.radius], [0.0, 0.0, -0.2], [0.0, -10.0, 0.0]).start()?;
        checks.steps(&mut engine, ball.steps())?;
        let state = snapshot(&engine);
        checks.close(format!("{name}: v_t'"), -state.velocities[0][0], 0.12, 1e-3, "m/s");
        checks.close(format!("{name}: w1'"), -state.angular_velocities[0][1], 7.0, 1e-3, "rad/s");
        checks.close(format!("{name}: v_n'"), state.velocities[0][2], 0.1, 1e-3, "m/s");
    }
    Ok(())
}

/// Chung and Ooi (2011), test 7 (PHYSICS.md I7): spins (w, -w) leave v_t' = 0 and w' = w; spins (w, w) repeat test 6.
fn spinning_pair(checks: &mut Checks) -> anyhow::Result<()> {
    let ball = Ball { radius: 0.1, density: 2700.0 };
    let mut collide = |second: f64| -> anyhow::Result<([f64; 3], f64)> {
        let scene = ball
            .scene("restitution = 0.5\nfriction = 0.4")
            .particle([-ball.radius, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.0, 10.0])
            .particle([ball.radius, 0.0, 0.0], [-0.2, 0.0, 0.0], [0.0, 0.0, second]);
        let mut engine = scene.start()?;
        checks.steps(&mut engine, ball.steps())?;
        let state = snapshot(&engine);
        Ok((state.velocities[0], state.angular_velocities[0][2]))
    };
    let (velocity, spin) = collide(-10.0)?;
    let (sliding, slower) = collide(10.0)?;
    checks.vanishes("spins (w, -w): v_t'", velocity[1], 1e-12, "m/s");
    checks.near("spins (w, -w): w'", spin, 10.0, 1e-12, "rad/s");
    checks.close("spins (w, w): v_t'", sliding[1].abs(), 0.12, 1e-3, "m/s");
    checks.close("spins (w, w): w'", slower, 7.0, 1e-3, "rad/s");
    Ok(())
}

/// A damped oscillator as law: damping ratio, rule, exact restitution and duration in units of 1/omega0.
struct Law {
    name: &'static str,
    zeta: f64,
    end: &'static str,
    exact: f64,
    duration: f64,
    /// Error at Tc/20, half a unit of its last digit, and order between Tc/40 and Tc/320.
    reference: (f64, f64, f64),
}

fn laws() -> [Law; 4] {
    let zeta = -(0.85f64.ln()) / (PI * PI + 0.85f64.ln().powi(2)).sqrt();
    let s = (1.0 - zeta * zeta).sqrt();
    let clipped = (-(zeta / s) * (2.0 * zeta * s).atan2(2.0 * zeta * zeta - 1.0)).exp();
    [
        Law { name: "elastic", zeta: 0.0, end: "tension", exact: 1.0, duration: PI, reference: (1.2e-4, 5e-6, 3.0) },
        Law {
            name: "e 0.85, tension",
            zeta,
            end: "tension",
            exact: 0.85,
            duration: PI / s,
            reference: (2.2e-3, 5e-5, 2.0),
        },
        Law {
            name: "e 0.85, clip",
            zeta,
            end: "clip",
            exact: clipped,
            duration: PI / s,
            reference: (4.4e-3, 5e-5, 1.0),
        },
        Law {
            name: "critical, clip",
            zeta: 1.0,
            end: "clip",
            exact: (-2f64).exp(),
            duration: 2.0,
            reference: (6.8e-3, 5e-5, 1.0),
        },
    ]
}

/// WP2: mean |e - e_exact| over 32 phases of the instant of impact. References: oracles/work_precision.py, `vv` (the
/// dashpot sees the velocity predicted at the full step), two digits; slopes of PHYSICS.md D.
fn restitution_work_precision(checks: &mut Checks) -> anyhow::Result<()> {
    for law in laws() {
        let mut errors = Vec::new();
        let mut curve = Vec::new();
        for steps in [20, 40, 80, 160, 320] {
            checks.loop_time_s();
            let error = mean_error(checks, &law, steps)?;
            curve.push((1.0 / f64::from(steps), checks.loop_time_s(), error));
            if steps == 20 {
                let (value, half_digit, _) = law.reference;
                checks.near(format!("{}: error at Tc/20", law.name), error, value, half_digit, "-");
            }
            errors.push(error);
        }
        checks.work_precision("error of e", "time step over contact duration", law.name, &curve);
        let slope = (errors[1] / errors[4]).log2() / 3.0;
        checks.near(format!("{}: order, Tc/40 to Tc/320", law.name), slope, law.reference.2, 0.1, "-");
    }
    Ok(())
}

/// 32 balls of unit mass, stiffness and frequency, each at another phase of the step.
fn mean_error(checks: &mut Checks, law: &Law, steps_per_contact: u32) -> anyhow::Result<f64> {
    let dt = law.duration / f64::from(steps_per_contact);
    let speed = 1e-3;
    let damping = format!("stiffness_n_per_m = 1.0\ndamping_n_s_per_m = {:?}", 2.0 * law.zeta);
    // Between particles, which never meet, a soft law: at a wall the reduced mass is twice as large.
    let mut scene = SceneText::new([0.0; 3], &format!("time_step_s = {dt:?}"))
        .contact(&format!("contact_end = \"{}\"", law.end))
        .materials_apart(0.75 / PI, "stiffness_n_per_m = 1e-3\nrestitution = 1.0", &damping)
        .shape("kind = \"sphere\", radius_m = 1.0")
        .floor();
    for k in 0..32 {
        let phase = (f64::from(k) + 0.37) / 32.0;
        scene = scene.particle([4.0 * f64::from(k), 0.0, 1.0 + phase * dt * speed], [0.0, 0.0, -speed], [0.0; 3]);
    }
    let mut engine = scene.start()?;
    checks.steps(&mut engine, u64::from(6 * steps_per_contact))?;
    let state = snapshot(&engine);
    Ok(state.velocities.iter().map(|v| (v[2] / speed - law.exact).abs()).sum::<f64>() / 32.0)
}
