//! Free rotation: I9, WP1 (order and error of Omelyan's scheme), S15 (large steps, degenerate inertia).

use sturz_engine::Snapshot;

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("I9", "Euler top (Dzhanibekov): angular velocity at t = 20", euler_top),
        Case::fast("WP1", "Euler top: attitude error and order against run time", attitude_work_precision),
        Case::fast("S15", "free rotation at large steps and with degenerate inertia", large_steps),
    ]
}

const TIME_S: f64 = 20.0;
const SPIN: [f64; 3] = [1e-3, 1.0, 1e-3];
/// Half a body with I = (1, 2, 3) must be flat: a thin plate has it to (thickness / size)^2.
const PLATE: &str = "kind = \"box\", size_m = [4.898979485566356, 3.4641016151377544, 1e-3]";

pub(super) type Quaternion = [f64; 4];

pub(super) fn product(p: Quaternion, q: Quaternion) -> Quaternion {
    [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]
}

pub(super) fn conjugate(q: Quaternion) -> Quaternion {
    [q[0], -q[1], -q[2], -q[3]]
}

/// A vector in the frame that `q` turns into the world.
pub(super) fn into_body(q: Quaternion, v: [f64; 3]) -> [f64; 3] {
    let r = product(product(conjugate(q), [0.0, v[0], v[1], v[2]]), q);
    [r[1], r[2], r[3]]
}

/// Angle between two attitudes, rad.
fn angle(p: Quaternion, q: Quaternion) -> f64 {
    let d = product(conjugate(p), q);
    2.0 * (d[1] * d[1] + d[2] * d[2] + d[3] * d[3]).sqrt().min(1.0).asin()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Angular velocity in body axes and attitude at the end.
struct End {
    angular_velocity: [f64; 3],
    attitude: Quaternion,
}

/// A lone body in free flight: the law is needed by the scene, and never used.
fn free_body(geometry: &str, spin: [f64; 3], time_step_s: f64) -> SceneText {
    SceneText::new([0.0; 3], &format!("time_step_s = {time_step_s:?}"))
        .materials(1.0, "stiffness_n_per_m = 1e-9\nrestitution = 1.0")
        .shape(geometry)
        .particle([0.0; 3], [0.0; 3], spin)
}

fn spun(checks: &mut Checks, n: u64) -> anyhow::Result<End> {
    spun_by("omelyan", checks, n)
}

fn spun_by(scheme: &str, checks: &mut Checks, n: u64) -> anyhow::Result<End> {
    let scheme = format!("[integrator]\nrotation = \"{scheme}\"");
    let mut engine = free_body(PLATE, SPIN, TIME_S / n as f64).section(&scheme).start()?;
    checks.steps(&mut engine, n)?;
    let Snapshot { orientations, angular_velocities, .. } = snapshot(&engine);
    Ok(End { angular_velocity: into_body(orientations[0], angular_velocities[0]), attitude: orientations[0] })
}

/// Euler's equations by Runge-Kutta of order 4 in 40,000 steps: 1e-12 exact, for the plate's own inertia.
fn reference(inertia: [f64; 3]) -> End {
    let slope = |y: &[f64; 7]| {
        let w = [y[0], y[1], y[2]];
        let turn = product([y[3], y[4], y[5], y[6]], [0.0, w[0], w[1], w[2]]);
        [
            (inertia[1] - inertia[2]) * w[1] * w[2] / inertia[0],
            (inertia[2] - inertia[0]) * w[2] * w[0] / inertia[1],
            (inertia[0] - inertia[1]) * w[0] * w[1] / inertia[2],
            0.5 * turn[0],
            0.5 * turn[1],
            0.5 * turn[2],
            0.5 * turn[3],
        ]
    };
    let ahead = |y: &[f64; 7], k: &[f64; 7], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let n = 40_000;
    let h = TIME_S / f64::from(n);
    let mut y = [SPIN[0], SPIN[1], SPIN[2], 1.0, 0.0, 0.0, 0.0];
    for _ in 0..n {
        let a = slope(&y);
        let b = slope(&ahead(&y, &a, 0.5 * h));
        let c = slope(&ahead(&y, &b, 0.5 * h));
        let d = slope(&ahead(&y, &c, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    End { angular_velocity: [y[0], y[1], y[2]], attitude: [y[3], y[4], y[5], y[6]] }
}

fn plate_inertia() -> anyhow::Result<[f64; 3]> {
    let scene = free_body(PLATE, SPIN, 0.1).validate()?;
    Ok(scene.shapes()[0].mass_properties().principal_inertia.into())
}

/// I9: w(20) = (-.105321007988, -.994438779049, .060812593881) for I = (1, 2, 3) (PHYSICS.md, exact by Jacobi elliptic
/// functions). The plate differs from that body by 1e-6 / 24 in I, which the reference of its own inertia measures.
fn euler_top(checks: &mut Checks) -> anyhow::Result<()> {
    let exact = [-0.105321007988, -0.994438779049, 0.060812593881];
    checks.vanishes(
        "reference integration at I = (1, 2, 3)",
        distance(reference([1.0, 2.0, 3.0]).angular_velocity, exact),
        // Rounding grows by exp(20 / sqrt 3) = 1e5 along the separatrix; PHYSICS.md I9 found 2e-11 itself.
        4e-11,
        "rad/s",
    );
    let own = reference(plate_inertia()?);
    let shift = distance(own.angular_velocity, exact);
    checks.vanishes("shift by the thickness of the plate", shift, 2e-6, "rad/s");
    let mut errors = Vec::new();
    for n in [2000, 4000, 8000] {
        errors.push(distance(spun(checks, n)?.angular_velocity, own.angular_velocity));
    }
    checks.near("order, dt 0.01 to 0.005", (errors[0] / errors[1]).log2(), 2.0, 0.05, "-");
    checks.near("order, dt 0.005 to 0.0025", (errors[1] / errors[2]).log2(), 2.0, 0.05, "-");
    let (coarse, fine) = (spun(checks, 8000)?.angular_velocity, spun(checks, 16_000)?.angular_velocity);
    for axis in 0..3 {
        let extrapolated = fine[axis] + (fine[axis] - coarse[axis]) / 3.0;
        checks.near(format!("w{axis}(20), extrapolated to dt = 0"), extrapolated, exact[axis], 1e-8 + shift, "rad/s");
    }
    Ok(())
}

/// WP1: errors of oracles/euler_top.py (its Omelyan; three digits) at T/dt = 200 to 3200; order 2.00 +- 0.05.
fn attitude_work_precision(checks: &mut Checks) -> anyhow::Result<()> {
    let own = reference(plate_inertia()?);
    let mut last: Option<f64> = None;
    let mut curve = Vec::new();
    for (n, expected) in [(200, 1.95e-2), (400, 4.88e-3), (800, 1.22e-3), (1600, 3.05e-4), (3200, 7.64e-5)] {
        let error = angle(spun(checks, n)?.attitude, own.attitude);
        curve.push((TIME_S / n as f64, median_loop_time(checks, "omelyan", n)?, error));
        checks.close(format!("attitude error, {n} steps"), error, expected, 5e-3, "rad");
        if let Some(last) = last.replace(error) {
            checks.near(format!("order at {n} steps"), (last / error).log2(), 2.0, 0.05, "-");
        }
    }
    checks.work_precision("attitude error, rad", "time step, s (|w| = 1 rad/s)", "omelyan", &curve);
    splitting_work_precision(checks, &own)
}

/// These runs are of milliseconds: a single one may be hit by whatever else the machine does.
fn median_loop_time(checks: &mut Checks, scheme: &str, n: u64) -> anyhow::Result<f64> {
    let mut times = Vec::new();
    for _ in 0..9 {
        checks.loop_time_s();
        spun_by(scheme, checks, n)?;
        times.push(checks.loop_time_s());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[4])
}

/// WP1 with the symmetric splitting: order 2.00 +- 0.05, and the error 33 times below Omelyan's at the same step
/// (PHYSICS.md D; between 25 and 45 is asked for, since the ratio is quoted to two digits at one step).
fn splitting_work_precision(checks: &mut Checks, own: &End) -> anyhow::Result<()> {
    let mut last: Option<f64> = None;
    let mut curve = Vec::new();
    for n in [400, 800, 1600, 3200] {
        let error = angle(spun_by("splitting", checks, n)?.attitude, own.attitude);
        curve.push((TIME_S / n as f64, median_loop_time(checks, "splitting", n)?, error));
        let ratio = angle(spun(checks, n)?.attitude, own.attitude) / error;
        checks.near(format!("Omelyan's error over that of splitting, {n} steps"), ratio, 35.0, 10.0, "-");
        if let Some(last) = last.replace(error) {
            checks.near(format!("splitting: order at {n} steps"), (last / error).log2(), 2.0, 0.05, "-");
        }
    }
    checks.work_precision("attitude error, rad", "time step, s (|w| = 1 rad/s)", "splitting", &curve);
    Ok(())
}

/// S15: energy to 1e-10 and the angular momentum to rounding, |w| dt from 0.1 to 1.5, over 2000 steps.
fn large_steps(checks: &mut Checks) -> anyhow::Result<()> {
    let bodies = [
        ("asymmetric", "kind = \"box\", size_m = [2.0, 1.5, 1.0]"),
        ("cube", "kind = \"cube\", edge_m = 1.0"),
        ("rod 1:100", "kind = \"spherocylinder\", radius_m = 0.01, total_length_m = 2.0"),
    ];
    for (name, geometry) in bodies {
        let (mut worst_energy, mut worst_momentum) = (0f64, 0f64);
        for product in [0.1, 0.5, 1.0, 1.5] {
            let spin = [0.6, 0.52, 0.608];
            let mut engine = free_body(geometry, spin, product).start()?;
            let inertia: [f64; 3] = engine.scene().shapes()[0].mass_properties().principal_inertia.into();
            let start: [f64; 3] = std::array::from_fn(|k| inertia[k] * spin[k]);
            let energy = engine.report().energy.kinetic_rotation_j;
            for _ in 0..20 {
                checks.steps(&mut engine, 100)?;
                worst_energy = worst_energy.max((engine.report().energy.kinetic_rotation_j / energy - 1.0).abs());
                let Snapshot { orientations, angular_velocities, .. } = snapshot(&engine);
                let w = into_body(orientations[0], angular_velocities[0]);
                let momentum = into_body(conjugate(orientations[0]), std::array::from_fn(|k| inertia[k] * w[k]));
                worst_momentum = worst_momentum.max(distance(momentum, start) / distance(start, [0.0; 3]));
            }
        }
        checks.vanishes(format!("{name}: largest |dE/E|"), worst_energy, 1e-10, "-");
        checks.vanishes(format!("{name}: largest |dL|/L"), worst_momentum, 1e-12, "-");
    }
    Ok(())
}
