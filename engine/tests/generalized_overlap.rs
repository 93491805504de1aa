//! Scenes whose polyhedra meet by generalized overlap: bits, restitution, rest, refusals.

mod common;

use common::{drum, engine, header, particle, plane, shape, steps};
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Command, Effect, StepError};

/// The drum of crosses with the other law; each beam is rounded by a hundredth of its thickness.
fn rounded_drum(count: u32) -> String {
    let contact = "[contact]\nnormal = \"generalized_overlap\"\n\
                   [contact.generalized_overlap]\nrounding_fraction = 0.05\n[domain]";
    drum(count).replacen("[domain]", contact, 1)
}

fn hashes(threads: usize, drop_caches_every: u64) -> Vec<u64> {
    let mut engine = engine(&rounded_drum(90));
    engine.set_threads(threads);
    let mut hashes = Vec::new();
    for stretch in 0..6 {
        for k in 0..800 {
            if drop_caches_every > 0 && (stretch * 800 + k) % drop_caches_every == 0 {
                engine.drop_caches();
            }
            steps(&mut engine, 1);
        }
        if stretch == 3 {
            assert_eq!(engine.apply(&Command::Remove(vec![7, 11])).unwrap(), Effect::Removed { count: 2 });
        }
        hashes.push(engine.state_hash());
    }
    let report = engine.report();
    assert!(report.contact_points > 20, "{report:?}");
    assert!(report.energy.dissipated_friction_j > 0.0);
    hashes
}

/// Lists of active terms, neighbour rebuilds with their re-sorting, images and removals leave no trace.
#[test]
fn threads_and_caches_are_invisible_in_the_bits() {
    let reference = hashes(1, 0);
    assert_eq!(hashes(2, 0), reference);
    assert_eq!(hashes(4, 0), reference);
    assert_eq!(hashes(2, 37), reference);
    assert_eq!(hashes(1, 3), reference);
}

const LAW: &str = "normal = \"generalized_overlap\"\ncontact_end = \"tension\"";

/// Two unit cubes (m = 2500 kg, k = 1e6 N/m) that meet head on along x; their speed overlaps them by 0.6 r.
fn restitution(pair: &str, contact: &str, orientations: [[f64; 4]; 2], distance: f64) -> (f64, f64) {
    let duration = std::f64::consts::PI * (1250.0f64 / 1e6).sqrt();
    let speed = 0.003 * std::f64::consts::PI / duration;
    let mut text = header([0.0; 3], duration / 200.0, contact, &format!("stiffness_n_per_m = 1e6\n{pair}"));
    text += &shape("kind = \"cube\", edge_m = 1.0");
    for (k, q) in orientations.iter().enumerate() {
        let (x, v) = if k == 0 { (0.0, 0.5 * speed) } else { (distance, -0.5 * speed) };
        text += &format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nvelocity_m_per_s = [{v:?}, 0.0, 0.0]\n\
             placement = {{ method = \"poses\", positions_m = [[{x:?}, 0.0, 0.0]], orientations_wxyz = [{q:?}] }}\n"
        );
    }
    let mut engine = engine(&text);
    let energy = |engine: &sturz_engine::Engine| {
        let energy = engine.report().energy;
        energy.kinetic_translation_j + energy.kinetic_rotation_j
    };
    let start = energy(&engine);
    steps(&mut engine, 1000);
    let report = engine.report();
    assert_eq!(report.energy.elastic_j, 0.0);
    ((energy(&engine) / start).sqrt(), report.energy.residual_j / start)
}

/// Aligned faces, and a corner (rounded: its tip recedes by (sqrt 3 - 1) r) on a face: e as asked at Tc/200.
#[test]
fn restitution_is_that_of_the_scene() {
    let corner = [[1.0, 0.0, 0.0, 0.0], corner_along_x()];
    let reach = 0.5 + 3f64.sqrt() * (0.5 - 5e-3) + 5e-3;
    for exponent in ["", "\n[contact.generalized_overlap]\nexponent = 1.5"] {
        for e in [0.9, 0.5] {
            let contact = format!("{LAW}{exponent}");
            let pair = format!("restitution = {e:?}");
            let (face, _) = restitution(&pair, &contact, [[1.0, 0.0, 0.0, 0.0]; 2], 1.0001);
            assert!((face - e).abs() < 0.01, "aligned faces, e = {e}: {face}");
            let (vertex, _) = restitution(&pair, &contact, corner, reach + 1e-4);
            assert!((vertex - e).abs() < 0.01, "corner on face, e = {e}: {vertex}");
        }
        let (elastic, residual) = restitution("restitution = 1.0", &format!("{LAW}{exponent}"), corner, reach + 1e-4);
        assert!((elastic - 1.0).abs() < 1e-4 && residual.abs() < 2e-4, "{elastic} {residual}");
        let clipped = format!("normal = \"generalized_overlap\"\ncontact_end = \"clip\"{exponent}");
        let (face, residual) = restitution("restitution = 0.5", &clipped, [[1.0, 0.0, 0.0, 0.0]; 2], 1.0001);
        assert!((face - 0.5).abs() < 0.01 && residual.abs() < 0.01, "clip: {face} {residual}");
        let (raw, _) = restitution("damping_n_s_per_m = 0.0", &format!("{LAW}{exponent}"), corner, reach + 1e-4);
        assert!((raw - 1.0).abs() < 1e-4, "no dashpot: {raw}");
    }
}

/// Quaternion that turns the diagonal (1, 1, 1) into -x: about (0, -1, 1), by the angle of cosine -1/sqrt 3.
fn corner_along_x() -> [f64; 4] {
    let (sine, cosine) = (0.5 * (-1.0 / 3f64.sqrt()).acos()).sin_cos();
    let part = sine / 2f64.sqrt();
    [cosine, 0.0, -part, part]
}

/// Two aligned cubes hit squarely: no rotation beyond rounding.
#[test]
fn aligned_hit_does_not_spin() {
    let mut text = header([0.0; 3], 2e-4, LAW, "stiffness_n_per_m = 1e6\nrestitution = 1.0");
    text += &shape("kind = \"cube\", edge_m = 1.0");
    text += &particle([0.0; 3], [0.05, 0.0, 0.0], [0.0; 3]);
    text += &particle([1.0001, 0.0, 0.0], [-0.05, 0.0, 0.0], [0.0; 3]);
    let mut engine = engine(&text);
    steps(&mut engine, 1000);
    let energy = engine.report().energy;
    assert!(energy.kinetic_rotation_j < 1e-20 * energy.kinetic_translation_j, "{energy:?}");
    assert!((energy.kinetic_translation_j / (0.5 * 5000.0 * 0.0025) - 1.0).abs() < 1e-3);
}

/// A cube on the floor with friction and a yaw: it slides and turns to rest, the balance closes, the floor carries it.
#[test]
fn cube_slides_and_turns_to_rest_on_the_floor() {
    let pair = "stiffness_n_per_m = 1e7\nrestitution = 0.3\nfriction = 0.4";
    let mut text = header([0.0, 0.0, -9.81], 1e-4, LAW, pair);
    text += &shape("kind = \"cube\", edge_m = 1.0");
    text += &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    text += &particle([0.0, 0.0, 0.5], [0.5, 0.1, 0.0], [0.0, 0.0, 1.0]);
    let mut engine = engine(&text);
    steps(&mut engine, 20_000);
    let report = engine.report();
    let energy = report.energy;
    let start = 0.5 * 2500.0 * 0.26 + 0.5 * 2500.0 / 6.0;
    assert!(energy.kinetic_translation_j + energy.kinetic_rotation_j < 1e-9 * start, "{energy:?}");
    assert!(energy.residual_j.abs() < 2e-3 * start, "{energy:?}");
    assert_eq!((report.touching_boundary_pairs, report.contact_points), (1, 4));
    // D = m g / (k |F|^2) with |F| = 4^(1/8) for four equal points
    let overlap = 2500.0 * 9.81 / 1e7 / 4f64.powf(0.125);
    assert!((report.largest_overlap_m / overlap - 1.0).abs() < 1e-3, "{} {overlap}", report.largest_overlap_m);
}

/// Beyond two rounding radii the law has no meaning: the step is refused, with the remedy.
#[test]
fn overlap_beyond_the_rounding_is_refused() {
    let mut text = header([0.0; 3], 1e-4, LAW, "stiffness_n_per_m = 1e6\nrestitution = 1.0");
    text += &shape("kind = \"cube\", edge_m = 1.0");
    text += &particle([0.0; 3], [1.5, 0.0, 0.0], [0.0; 3]);
    text += &particle([1.0001, 0.0, 0.0], [-1.5, 0.0, 0.0], [0.0; 3]);
    let mut engine = engine(&text);
    // the default rounding: 0.02 of the edge each
    let error = (0..1000).find_map(|_| engine.step().err()).expect("the law ends");
    assert!(matches!(error, StepError::BeyondRounding { a: 0, .. }), "{error}");
    assert!(engine.report().warnings.deep_rounding > 0);
}

/// Two cubes in one place: the law has no meaning there, and says so; no number breaks.
#[test]
fn identical_poses_are_refused_without_nan() {
    for turn in [[1.0, 0.0, 0.0, 0.0], [0.8, 0.6, 0.0, 0.0]] {
        let mut text = header([0.0; 3], 1e-4, LAW, "stiffness_n_per_m = 1e6\nrestitution = 0.5\nfriction = 0.5");
        text += &shape("kind = \"cube\", edge_m = 1.0");
        text += &format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = {{ method = \"poses\", \
             positions_m = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], orientations_wxyz = [[1.0, 0.0, 0.0, 0.0], {turn:?}] }}\n"
        );
        let mut engine = engine(&text);
        let error = engine.step().unwrap_err();
        let refused = matches!(error, StepError::BeyondRounding { .. } | StepError::ExcessiveOverlap { .. });
        assert!(refused, "{error}");
        assert!(engine.report().energy.elastic_j.is_finite());
    }
}

/// Scenes that cannot be: parameters out of range, a rounding that swallows the shape, a step beyond the critical one.
#[test]
fn unusable_scenes_are_refused_with_a_path() {
    let scene = |contact: &str, dt: f64| {
        let mut text = header([0.0; 3], dt, contact, "stiffness_n_per_m = 1e6\nrestitution = 1.0");
        text += &shape("kind = \"cube\", edge_m = 1.0");
        text += &particle([0.0; 3], [0.0; 3], [0.0; 3]);
        let description = SceneDescription::from_toml(&text).unwrap();
        Scene::validate(description).map(|_| ()).map_err(|error| error.to_string())
    };
    let refused = [
        ("p = 1.0", "contact.generalized_overlap.p"),
        ("exponent = 2", "contact.generalized_overlap.exponent"),
        ("rounding_fraction = 0.5", "contact.generalized_overlap.rounding_fraction"),
    ];
    for (line, path) in refused {
        let error = scene(&format!("{LAW}\n[contact.generalized_overlap]\n{line}"), 1e-5).unwrap_err();
        assert!(error.contains(path), "{error}");
    }
    // 2 / (8 omega1) with omega1 = sqrt(k / m_red)
    let critical = 2.0 / 8.0 / (1e6f64 / 1250.0).sqrt();
    assert!(scene(LAW, 0.999 * critical).is_ok());
    assert!(scene(LAW, 1.001 * critical).unwrap_err().contains("critical"));
    assert!(scene("normal = \"linear\"", 1.001 * critical).is_ok());
}
