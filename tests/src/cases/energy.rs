//! ENERGY: what a frictionless, undamped collision of polyhedra changes of the kinetic energy, by law and kind of hit.
//!
//! Bodies of unit mass and size, k/m = 1e6 1/s^2. Tc is the duration of the hit of two exactly aligned faces under the
//! law in question, and the speed is the one at which that hit overlaps by 1e-3 of the size.

use std::f64::consts::PI;

use rayon::prelude::*;
use sturz_engine::Engine;
use sturz_engine::math::{Quat, Vec3};

use super::rounded_pose::{Draw, Kind, Poses, Solid, solids};
use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![
        Case::slow("ENERGY", "elastic hits of polyhedra: 200 poses of each kind, all laws", full),
        Case::fast("ENERGYS", "the same, the laws with gates, few poses", short),
    ]
}

/// N/m
const STIFFNESS: f64 = 1e6;
/// Of the aligned hit, m.
const OVERLAP: f64 = 1e-3;

/// A law of the table.
struct Law {
    name: &'static str,
    contact: &'static str,
    /// Whether its figures must be within the gates of the default law.
    gated: bool,
}

const LAWS: [Law; 9] = [
    Law { name: "generalized_overlap", contact: "normal = \"generalized_overlap\"", gated: true },
    Law {
        name: "generalized_overlap, exponent 1.5",
        contact: "generalized_overlap = { exponent = 1.5, reference_overlap_fraction = 0.1 }",
        gated: true,
    },
    Law { name: "generalized_overlap, winkler", contact: "generalized_overlap = { walls = \"winkler\" }", gated: true },
    Law { name: "feature_pairs", contact: "normal = \"feature_pairs\"", gated: false },
    Law { name: "volume", contact: "normal = \"volume\"", gated: false },
    Law { name: "linear, per_point", contact: "normal = \"linear\"", gated: false },
    Law { name: "linear, model_a", contact: "normal = \"linear\"\nsharing = \"model_a\"", gated: false },
    Law { name: "linear, model_b", contact: "normal = \"linear\"\nsharing = \"model_b\"", gated: false },
    Law {
        name: "linear, max_overlap_shared",
        contact: "normal = \"linear\"\nsharing = \"max_overlap_shared\"",
        gated: false,
    },
];

/// How the bodies meet.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Category {
    /// A face tilted by an angle, or any orientation, on a plane.
    Wall(Option<f64>),
    Pair(Kind),
}

impl Category {
    const ALL: [(&'static str, Self); 11] = [
        ("wall, face", Self::Wall(Some(0.0))),
        ("wall, face tilted by 1e-3", Self::Wall(Some(1e-3))),
        ("wall, face tilted by 1e-2", Self::Wall(Some(1e-2))),
        ("wall, random", Self::Wall(None)),
        ("face on face", Self::Pair(Kind::FaceFace)),
        ("face on face, tilted by 1e-3", Self::Pair(Kind::TiltedThousandth)),
        ("face on face, tilted by 1e-2", Self::Pair(Kind::TiltedHundredth)),
        ("edge on face", Self::Pair(Kind::EdgeFace)),
        ("vertex on face", Self::Pair(Kind::VertexFace)),
        ("vertex on vertex", Self::Pair(Kind::VertexVertex)),
        ("random", Self::Pair(Kind::Random)),
    ];
}

/// Duration and speed of the aligned hit.
#[derive(Clone, Copy, Debug)]
struct Pace {
    duration_s: f64,
    speed: f64,
}

/// Bodies just before they meet.
#[derive(Clone, Copy, Debug)]
enum Start {
    OnWall(Quat, Vec3),
    Pair(Poses),
}

fn scene(law: &Law, solid: &Solid, start: &Start, speed: f64, time_step_s: f64) -> SceneText {
    let scene = SceneText::new([0.0; 3], &format!("time_step_s = {time_step_s:?}"))
        .contact(&format!("contact_end = \"tension\"\n{}", law.contact))
        .materials(1.0 / solid.volume, &format!("stiffness_n_per_m = {STIFFNESS:?}\nrestitution = 1.0"))
        .shape(&solid.geometry);
    let body = |scene: SceneText, x: &Vec3, q: &Quat, velocity: f64| {
        scene.section(&format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nvelocity_m_per_s = [0.0, 0.0, {velocity:?}]\n\
             placement = {{ method = \"poses\", positions_m = [{:?}], orientations_wxyz = [{:?}] }}",
            [x.x, x.y, x.z],
            [q.w, q.i, q.j, q.k]
        ))
    };
    match start {
        Start::OnWall(q, x) => body(scene.floor(), x, q, -speed),
        Start::Pair(poses) => {
            let scene = body(scene, &poses.position[0], &poses.orientation[0], 0.5 * speed);
            body(scene, &poses.position[1], &poses.orientation[1], -0.5 * speed)
        }
    }
}

fn touches(engine: &Engine) -> bool {
    let report = engine.report();
    report.touching_pairs + report.touching_boundary_pairs > 0
}

/// Finds the speed at which exactly aligned faces overlap as far as they should, and how long they touch then.
fn pace(law: &Law, solid: &Solid, wall: bool) -> anyhow::Result<Pace> {
    let start = if wall {
        let (q, height) = solid.on_floor(Some(0.0), &mut Draw(1));
        Start::OnWall(q, Vec3::z() * height)
    } else {
        Start::Pair(solid.sharp_pair(Kind::Aligned, 0.0, &mut Draw(1))?)
    };
    let bodies = if wall { 1.0 } else { 2.0 };
    // eight springs may add
    let time_step_s = PI * (1.0 / (8.0 * bodies * STIFFNESS)).sqrt() / 1000.0;
    let distance = |engine: &Engine| {
        let positions = snapshot(engine).positions;
        (positions[positions.len() - 1][2] - if wall { 0.0 } else { positions[0][2] }).abs()
    };
    let mut pace = Pace { duration_s: 0.0, speed: OVERLAP * (bodies * STIFFNESS).sqrt() };
    for _ in 0..3 {
        let mut engine = scene(law, solid, &start, pace.speed, time_step_s).start()?;
        let (from, mut closest, mut touching) = (distance(&engine), f64::MAX, 0u32);
        engine.in_pool(|engine| -> anyhow::Result<()> {
            for _ in 0..100_000 {
                engine.step()?;
                closest = closest.min(distance(engine));
                match touches(engine) {
                    true => touching += 1,
                    false if touching > 0 => break,
                    false => {}
                }
            }
            Ok(())
        })?;
        pace.duration_s = f64::from(touching) * time_step_s;
        pace.speed *= OVERLAP / (from - closest);
    }
    Ok(pace)
}

/// |dE/E| once the bodies are apart for half a Tc; `None` if they still touch after 60 Tc. With it the steps done.
fn change(
    law: &Law,
    solid: &Solid,
    start: &Start,
    pace: Pace,
    per_duration: u64,
) -> anyhow::Result<(Option<f64>, u64)> {
    let dt = pace.duration_s / per_duration as f64;
    let mut engine = scene(law, solid, start, pace.speed, dt).start()?;
    let kinetic = |engine: &Engine| {
        let energy = engine.report().energy;
        energy.kinetic_translation_j + energy.kinetic_rotation_j
    };
    let bodies = engine.len() as u64;
    let stretch = per_duration.div_ceil(4);
    // in one go: a hand-over to the pool costs more than some steps of two bodies
    engine.in_pool(|engine| {
        let (before, mut touched, mut apart) = (kinetic(engine), false, 0);
        for k in 1..=240 {
            (0..stretch).try_for_each(|_| engine.step())?;
            let touches = touches(engine);
            touched |= touches;
            apart = if touches || !touched { 0 } else { apart + 1 };
            if apart == 3 {
                return Ok((Some((kinetic(engine) / before - 1.0).abs()), k * stretch * bodies));
            }
        }
        Ok((None, 240 * stretch * bodies))
    })
}

/// Changes of energy of one kind of hit, ascending, and how many bodies did not part.
struct Sample {
    changes: Vec<f64>,
    touching: usize,
}

impl Sample {
    fn largest(&self) -> f64 {
        self.changes.last().copied().unwrap_or(f64::INFINITY)
    }

    fn median(&self) -> f64 {
        self.changes.get(self.changes.len() / 2).copied().unwrap_or(f64::INFINITY)
    }
}

fn sample(
    checks: &mut Checks,
    (law, solid, pace): (&Law, &Solid, Pace),
    category: Category,
    poses: u64,
    per_duration: u64,
) -> anyhow::Result<Sample> {
    let gap = pace.speed * pace.duration_s / 40.0;
    let outcomes: Vec<(Option<f64>, u64)> = (0..poses)
        .into_par_iter()
        .map(|k| {
            let mut draw = Draw(7919 * k + 11);
            let start = match category {
                Category::Wall(tilt) => {
                    let (q, height) = solid.on_floor(tilt, &mut draw);
                    Start::OnWall(q, Vec3::z() * (height + gap * draw.unit()))
                }
                Category::Pair(kind) => Start::Pair(solid.sharp_pair(kind, gap, &mut draw)?),
            };
            change(law, solid, &start, pace, per_duration)
        })
        .collect::<anyhow::Result<_>>()?;
    checks.count(outcomes.iter().map(|(_, steps)| steps).sum());
    let mut changes: Vec<f64> = outcomes.iter().filter_map(|(change, _)| *change).collect();
    changes.sort_unstable_by(f64::total_cmp);
    Ok(Sample { touching: outcomes.len() - changes.len(), changes })
}

fn full(checks: &mut Checks) -> anyhow::Result<()> {
    for law in &LAWS {
        table(checks, law, 200, &[50, 200, 800])?;
    }
    Ok(())
}

fn short(checks: &mut Checks) -> anyhow::Result<()> {
    table(checks, &LAWS[0], 8, &[50, 200])?;
    for law in LAWS[1..].iter().filter(|law| law.gated) {
        table(checks, law, 4, &[200])?;
    }
    let solids = solids()?;
    for solid in [&solids[0], &solids[2]] {
        aligned_hits_do_not_spin(checks, solid)?;
    }
    Ok(())
}

/// Gates of the default law: largest below 1e-3 at Tc/200, median below 1e-3 at Tc/50. The other laws are shown.
fn table(checks: &mut Checks, law: &Law, poses: u64, steps_per_duration: &[u64]) -> anyhow::Result<()> {
    for solid in solids()? {
        let paces = [pace(law, &solid, true)?, pace(law, &solid, false)?];
        for (name, category) in Category::ALL {
            let pace = paces[usize::from(matches!(category, Category::Pair(_)))];
            for &per_duration in steps_per_duration {
                let found = sample(checks, (law, &solid, pace), category, poses, per_duration)?;
                let name = format!("{}: {}, {name}, Tc/{per_duration}", law.name, solid.name);
                let mut row = |what: &str, value: f64, limit: Option<f64>| match limit {
                    Some(limit) if law.gated => checks.vanishes(format!("{name}: {what}"), value, limit, "-"),
                    _ => checks.shows(format!("{name}: {what}"), value, "-"),
                };
                row("largest", found.largest(), (per_duration >= 200).then_some(1e-3));
                row("median", found.median(), Some(1e-3));
                row("still touching", found.touching as f64, Some(0.0));
            }
        }
    }
    Ok(())
}

/// Faces whose normals go through the centroid: spin after an aligned hit over speed and size.
fn aligned_hits_do_not_spin(checks: &mut Checks, solid: &Solid) -> anyhow::Result<()> {
    let law = &LAWS[0];
    for wall in [true, false] {
        let pace = pace(law, solid, wall)?;
        let start = if wall {
            let (q, height) = solid.on_floor(Some(0.0), &mut Draw(5));
            Start::OnWall(q, Vec3::z() * height)
        } else {
            Start::Pair(solid.sharp_pair(Kind::Aligned, 0.0, &mut Draw(5))?)
        };
        let mut engine = scene(law, solid, &start, pace.speed, pace.duration_s / 200.0).start()?;
        checks.steps(&mut engine, 400)?;
        let spin = snapshot(&engine).angular_velocities.iter().map(|w| Vec3::from(*w).norm()).fold(0.0, f64::max);
        let name = if wall { "a wall" } else { "each other" };
        checks.vanishes(format!("{}: aligned on {name}: spin", solid.name), spin / pace.speed, 1e-10, "1/m");
    }
    Ok(())
}
