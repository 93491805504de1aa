//! Whole scenes under the laws `volume` and `feature_pairs`: a packing settles, the balance closes, the bits are equal.

mod common;

use common::{engine, plane, shape, steps};
use sturz_engine::Snapshot;

const EDGE: f64 = 0.01;
const DENSITY: f64 = 2500.0;
const GRAVITY: f64 = 9.81;

/// A law, and numbers under which bodies that fall by ten edges stay within it.
struct Law {
    contact: &'static str,
    stiffness: f64,
    time_step_s: f64,
    /// Of the balance, over the energy of the fall, at the step, half and a quarter of it.
    residuals: [f64; 3],
}

const LAWS: [Law; 2] = [
    Law { contact: "normal = \"volume\"", stiffness: 5e3, time_step_s: 2e-5, residuals: [1e-4, 2e-6, 2e-6] },
    Law {
        contact: "normal = \"feature_pairs\"\nfeature_pairs = { rounding_fraction = 0.1 }",
        stiffness: 4e4,
        time_step_s: 8e-6,
        // the law's own: it jumps where the last corner of a face leaves (docs/contact.md)
        residuals: [1e-2; 3],
    },
];

/// 6 cubes and 6 pinacoids, dropped at random attitudes into a box of planes.
fn packing(law: &Law, time_step_s: f64, pair: &str) -> String {
    let pair = format!("stiffness_n_per_m = {:?}\n{pair}", law.stiffness);
    let mut text = common::header([0.0, 0.0, -GRAVITY], time_step_s, law.contact, &pair)
        .replace("name = \"test\"", "name = \"packing\"\nseed = 5");
    text += &shape(&format!("kind = \"cube\", edge_m = {EDGE:?}"));
    text += &format!(
        "[[shape]]\nname = \"p\"\ngeometry = {{ kind = \"pinacoid\", length_m = {EDGE:?}, width_m = {EDGE:?}, \
         height_m = {EDGE:?}, alpha_deg = 60.0 }}\n"
    );
    let side = 4.0 * EDGE;
    text += &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    for (name, point, normal) in [
        ("x-", [0.0; 3], [1.0, 0.0, 0.0]),
        ("x+", [side, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        ("y-", [0.0; 3], [0.0, 1.0, 0.0]),
        ("y+", [0.0, side, 0.0], [0.0, -1.0, 0.0]),
    ] {
        text += &plane(name, point, normal);
    }
    for (shape, from) in [("s", 0.0), ("p", 0.06)] {
        text += &format!(
            "[[insertion]]\nshape = \"{shape}\"\nmaterial = \"m\"\nplacement = {{ method = \"random\", count = 6, \
             region = {{ kind = \"box\", min_m = [0.0, 0.0, {from:?}], max_m = [{side:?}, {side:?}, {:?}] }} }}\n",
            from + 0.06
        );
    }
    text
}

const RESTS: &str = "restitution = 0.3\nfriction = 0.4";

/// Comes to rest, the boundaries carry the weight, and the balance closes to a part of the energy that was dissipated.
#[test]
fn packings_come_to_rest() {
    for law in LAWS {
        let mut engine = engine(&packing(&law, law.time_step_s, RESTS));
        let weight = GRAVITY * DENSITY * 6.0 * (EDGE.powi(3) + engine.scene().shapes()[1].mass_properties().volume);
        steps(&mut engine, (0.8 / law.time_step_s) as u64);
        let (energy, mut snapshot) = (engine.report().energy, Snapshot::default());
        engine.snapshot(&mut snapshot);
        let kinetic = energy.kinetic_translation_j + energy.kinetic_rotation_j;
        let dissipated = energy.dissipated_normal_j + energy.dissipated_friction_j;
        let carried: f64 = snapshot.boundaries.iter().map(|boundary| -boundary.force_n[2]).sum();
        assert!(kinetic < 1e-10 * weight * EDGE, "{}: kinetic energy {kinetic}", law.contact);
        assert!((carried / weight - 1.0).abs() < 1e-5, "{}: {carried} of {weight} is carried", law.contact);
        assert!(energy.residual_j.abs() < law.residuals[0] * dissipated, "{}: {energy:?}", law.contact);
    }
}

/// Without damping and friction the residual is that of the integrator, and of the jumps of `feature_pairs`.
#[test]
fn balances_close_with_the_step() {
    for law in LAWS {
        for (part, limit) in [1.0, 0.5, 0.25].into_iter().zip(law.residuals) {
            let dt = part * law.time_step_s;
            let mut engine = engine(&packing(&law, dt, "restitution = 1.0"));
            let before = engine.report().energy.potential_j;
            steps(&mut engine, (0.25 / dt) as u64);
            let energy = engine.report().energy;
            assert!(energy.residual_j.abs() < limit * before, "{} at {dt}: {energy:?}", law.contact);
        }
    }
}

#[test]
fn bits_do_not_depend_on_threads_or_caches() {
    for law in LAWS {
        let hashes = [(1, 0), (2, 0), (2, 17)].map(|(threads, every)| {
            let mut engine = engine(&packing(&law, law.time_step_s, RESTS));
            engine.set_threads(threads);
            for step in 0..12_000u64 {
                if every > 0 && step % every == 0 {
                    engine.drop_caches();
                }
                steps(&mut engine, 1);
            }
            assert!(engine.report().touching_pairs > 3, "{}", law.contact);
            engine.state_hash()
        });
        assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{}: {hashes:?}", law.contact);
    }
}
