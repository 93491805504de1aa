//! Sequential deposition of circumscribed spheres at local minima of height.

mod common;

use common::{engine, header, plane, shape};
use nalgebra::Vector3;
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Engine, Snapshot};

type Vec3 = Vector3<f64>;

const PAIR: &str = "stiffness_n_per_m = 1e4\nrestitution = 0.6";
/// Radius of all circumscribed spheres at unit scale, m.
const R: f64 = 5e-3;

fn sphere_bed(count: u32, width: f64, scale: &str, periodic: bool) -> String {
    let mut text = header([0.0, 0.0, -9.81], 1e-5, "", PAIR);
    text += &format!(
        "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [{width:?}, {width:?}, 0.0]\nperiodic = [{periodic}, {periodic}, false]\n"
    );
    text += &shape("kind = \"sphere\", radius_m = 5e-3");
    text += &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    text += &format!(
        "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\n{scale}\nplacement = {{ method = \"deposition\", count = {count}, region = {{ kind = \"box\", min_m = [0.0, 0.0, 0.0], max_m = [{width:?}, {width:?}, 1.0] }} }}\n"
    );
    text
}

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

/// Centres and radii.
fn spheres(engine: &Engine) -> Vec<(Vec3, f64)> {
    let snapshot = snapshot(engine);
    snapshot.positions.iter().zip(&snapshot.scales).map(|(x, scale)| (Vec3::from(*x), R * scale)).collect()
}

/// By brute force: the largest overlap over the radius, and whether each sphere rests in a local minimum: downwards is in the
/// cone of the directions towards at most three supports that were there before it (or the floor, or walls).
struct Verdict {
    overlap: f64,
    unsupported: Vec<usize>,
}

fn judge(spheres: &[(Vec3, f64)], width: f64, periodic: bool) -> Verdict {
    let mut verdict = Verdict { overlap: 0.0, unsupported: Vec::new() };
    for (k, (x, r)) in spheres.iter().enumerate() {
        let mut supports: Vec<Vec3> = Vec::new();
        for (other, s) in &spheres[..k] {
            let mut d = x - other;
            for axis in 0..2 {
                if periodic {
                    d[axis] -= (d[axis] / width).round() * width;
                }
            }
            let gap = d.norm() - r - s;
            verdict.overlap = verdict.overlap.max(-gap / r);
            if gap < 1e-8 * r {
                supports.push(d.normalize());
            }
        }
        let mut side = |gap: f64, normal: Vec3| {
            verdict.overlap = verdict.overlap.max(-gap / r);
            if gap < 1e-8 * r {
                supports.push(normal);
            }
        };
        side(x.z - r, Vec3::z());
        if !periodic {
            for axis in 0..2 {
                let normal = Vec3::ith(axis, 1.0);
                side(x[axis] - r, normal);
                side(width - x[axis] - r, -normal);
            }
        }
        if !holds(&supports) {
            verdict.unsupported.push(k);
        }
    }
    verdict
}

/// Whether pushes along some three of these normals add up to a push straight up.
fn holds(normals: &[Vec3]) -> bool {
    if normals.iter().any(|n| n.z > 1.0 - 1e-12) {
        return true;
    }
    let n = normals.len();
    (0..n).any(|i| {
        (i + 1..n).any(|j| {
            (j + 1..n).any(|k| {
                let basis = nalgebra::Matrix3::from_columns(&[normals[i], normals[j], normals[k]]);
                basis.try_inverse().is_some_and(|inverse| (inverse * Vec3::z()).min() >= -1e-6)
            })
        })
    })
}

#[test]
fn every_sphere_rests_on_three_and_overlaps_none() {
    let width = 0.1;
    for (periodic, scale) in [
        (true, ""),
        (false, ""),
        (true, "scale = { min = 0.95, max = 1.05 }"),
        (true, "scale = { law = \"lognormal\", median = 0.7, log_standard_deviation = 0.4, min = 0.3, max = 1.6 }"),
        (false, "scale = { law = \"table\", table = [[0.4, 3.0], [1.5, 1.0]] }"),
    ] {
        let engine = engine(&sphere_bed(2500, width, scale, periodic));
        let spheres = spheres(&engine);
        let verdict = judge(&spheres, width, periodic);
        assert!(verdict.overlap < 1e-9, "{periodic} {scale}: {}", verdict.overlap);
        assert!(verdict.unsupported.is_empty(), "{periodic} {scale}: {:?}", verdict.unsupported);
    }
}

/// Random sequential deposition of equal spheres: 0.582 (Visscher and Bolsterli 1972; Jodrey and Tory 1979 have 0.58),
/// between the layers of the floor and the free surface. Exact volumes of caps of the spheres in the slice.
#[test]
fn solid_fraction_of_equal_spheres() {
    let width = 0.15;
    let engine = engine(&sphere_bed(9000, width, "", true));
    let spheres = spheres(&engine);
    let top = spheres.iter().map(|(x, _)| x.z).fold(0.0, f64::max);
    let (low, high) = (8.0 * R, top - 8.0 * R);
    let below = |x: f64, r: f64, z: f64| {
        let h = (z - (x - r)).clamp(0.0, 2.0 * r);
        std::f64::consts::PI * h * h * (r - h / 3.0)
    };
    let volume: f64 = spheres.iter().map(|(x, r)| below(x.z, *r, high) - below(x.z, *r, low)).sum();
    let fraction = volume / (width * width * (high - low));
    println!("solid fraction of deposited equal spheres: {fraction:.4}, {} layers", (high - low) / (2.0 * R));
    assert!((fraction - 0.582).abs() < 0.01, "{fraction}");
}

/// A function of seed and ids, whatever is there besides.
#[test]
fn same_seed_gives_the_same_bed() {
    let text = sphere_bed(300, 0.06, "", true);
    assert_eq!(spheres(&engine(&text)), spheres(&engine(&text)));
    let other = text.replace("time_step_s = 1e-5", "seed = 5\ntime_step_s = 1e-05");
    assert_ne!(text, other);
    assert_ne!(spheres(&engine(&text)), spheres(&engine(&other)));
}

/// Polyhedra lie inside of their spheres, each turned at random; a second insertion goes on top of a frozen first one.
#[test]
fn polyhedra_go_onto_a_frozen_base() {
    let width = 0.1;
    let mut text = header([0.0, 0.0, -9.81], 1e-5, "", PAIR);
    text += &format!(
        "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [{width:?}, {width:?}, 0.0]\nperiodic = [true, true, false]\n"
    );
    text += &shape("kind = \"box\", size_m = [0.0057735026918962, 0.0057735026918962, 0.0057735026918962]");
    for (count, frozen) in [(200, true), (800, false)] {
        text += &format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nfrozen = {frozen}\nscale = {{ min = 0.9, max = 1.1 }}\nplacement = {{ method = \"deposition\", count = {count}, region = {{ kind = \"box\", min_m = [0.0, 0.0, 0.0], max_m = [{width:?}, {width:?}, 1.0] }} }}\n"
        );
    }
    let engine = engine(&text);
    let spheres = spheres(&engine);
    let verdict = judge(&spheres, width, true);
    assert!(verdict.overlap < 1e-9 && verdict.unsupported.is_empty(), "{}", verdict.overlap);
    let first_on_floor = spheres[200..].iter().filter(|(x, r)| x.z - r < 1e-8 * r).count();
    assert!(first_on_floor < 100, "the base bears most of them, {first_on_floor} fell through its holes");
    assert_eq!(engine.report().touching_pairs, 0);
    let turned = snapshot(&engine).orientations;
    assert!(turned.windows(2).all(|two| two[0] != two[1]));
}

#[test]
fn what_has_no_room_is_refused() {
    let path = |text: &str| {
        let scene = Scene::validate(SceneDescription::from_toml(text).unwrap());
        scene.err().map(|error| error.0[0].to_string()).unwrap_or_default()
    };
    let low = sphere_bed(300, 0.06, "", true).replace("0.06, 1.0]", "0.06, 0.03]");
    let refused = path(&low);
    assert!(
        refused.starts_with("insertion[0].placement: particle ") && refused.contains("above the region"),
        "{refused}"
    );
    let narrow = sphere_bed(3, 0.009, "", false);
    assert!(path(&narrow).starts_with("insertion[0].placement.region: is 9e-3 m wide along x"), "{}", path(&narrow));
    let walled = sphere_bed(60, 0.06, "", false) + &plane("wall", [0.03, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert!(path(&walled).contains("touches the boundary 'wall'"), "{}", path(&walled));
    let round = sphere_bed(3, 0.06, "", true).replace(
        "kind = \"box\", min_m = [0.0, 0.0, 0.0], max_m = [0.06, 0.06, 1.0]",
        "kind = \"cylinder\", point_m = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], radius_m = 0.1, length_m = 1.0",
    );
    assert!(path(&round).contains("must be a box"), "{}", path(&round));
}
