//! Bodies glued of convex parts: G2.

use std::f64::consts::PI;

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![Case::fast("G2", "cylinder of N slices on its side: models A and B", slices)]
}

/// Of seed 001, Table 1: k, R, L, M, and gamma = 927.88 1/s in c = 2 gamma M for e = 0.85 at one point.
const STIFFNESS: f64 = 1e5;
const RADIUS: f64 = 4e-3;
const LENGTH: f64 = 5.3e-3;
const MASS: f64 = 3.1e-4;
const GAMMA: f64 = 927.88;
/// Corners of the prism that stands for the cylinder; one of its edges is the line of contact.
const SIDES: u32 = 24;

/// A prism along x, one edge down, cut into n slices.
fn prism(n: u32) -> String {
    let thickness = LENGTH / f64::from(n);
    let corners: Vec<[f64; 3]> = (0..2 * SIDES)
        .map(|k| {
            let (sine, cosine) = (2.0 * PI * f64::from(k / 2) / f64::from(SIDES) - 0.5 * PI).sin_cos();
            [thickness * (f64::from(k % 2) - 0.5), RADIUS * cosine, RADIUS * sine]
        })
        .collect();
    let part = |k: u32| {
        let x = thickness * (f64::from(k) + 0.5) - 0.5 * LENGTH;
        format!(
            "{{ shape = {{ kind = \"convex_polyhedron\", vertices_m = {corners:?} }}, position_m = [{x:?}, 0.0, 0.0] }}"
        )
    };
    let parts: Vec<String> = (0..n).map(part).collect();
    format!("kind = \"composite\", parts = [{}]", parts.join(", "))
}

/// Each slice touches with the two ends of its edge, so 2 n points. Model A: the springs add, Tc = 1.7515e-4 s/sqrt(2 n) and
/// gamma/sqrt(2 n) for the same e. Model B over the points of both bodies: both as for one point. A line does not spin.
fn slices(checks: &mut Checks) -> anyhow::Result<()> {
    let area = 0.5 * f64::from(SIDES) * RADIUS * RADIUS * (2.0 * PI / f64::from(SIDES)).sin();
    for n in [1, 3, 10, 30] {
        for (name, contact, softening) in [
            ("A", "sharing = \"model_a\"", f64::from(2 * n).sqrt()),
            ("B", "sharing = \"model_b\"\nsharing_scope = \"bodies\"", 1.0),
        ] {
            let duration = 1.7515e-4 / softening;
            let damping = 2.0 * GAMMA / softening * MASS;
            let law = format!("stiffness_n_per_m = {STIFFNESS:?}\ndamping_n_s_per_m = {damping:?}");
            let mut engine = SceneText::new([0.0; 3], &format!("time_step_s = {:?}", duration / 1000.0))
                .contact(&format!("normal = \"linear\"\n{contact}\ncontact_end = \"tension\""))
                .materials(MASS / (area * LENGTH), &law)
                .shape(&prism(n))
                .floor()
                .particle([0.0, 0.0, RADIUS + 1e-12], [0.0, 0.0, -1.0], [0.0; 3])
                .start()?;
            let mut touching = 0u32;
            for _ in 0..1500 {
                checks.steps(&mut engine, 1)?;
                touching += u32::from(engine.report().touching_boundary_pairs > 0);
            }
            let state = snapshot(&engine);
            let label = format!("model {name}, {n} slices");
            checks.close(format!("{label}: Tc"), f64::from(touching) * duration / 1000.0, duration, 3e-3, "s");
            checks.close(format!("{label}: V+"), state.velocities[0][2], 0.85, 1e-5, "m/s");
            let spin = state.angular_velocities[0].iter().fold(0f64, |worst, w| worst.max(w.abs()));
            checks.vanishes(format!("{label}: spin"), spin, 1e-9, "rad/s");
        }
    }
    Ok(())
}
