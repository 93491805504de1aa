//! What must come to rest: TOWER (towers of 10 and 50 cubes, S5), SLOPE (blocks on an incline).

use sturz_engine::Engine;
use sturz_engine::math::{Quat, Vec3};

use super::rounded_pose::Draw;
use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![
        Case::slow("TOWER", "towers of 10 and 50 cubes: aligned, offset, leaning; 200 sqrt(a/g)", towers),
        Case::fast("TOWERS", "towers of 10 cubes: 15 sqrt(a/g)", short_towers),
        Case::fast("SLOPE", "32 convex blocks rest on a plane of 26.5 degrees", slope),
    ]
}

/// Stiffness of an aligned contact of two faces, or of a face and a wall, in units of m g/a.
const FACE_STIFFNESS: f64 = 1e6;

fn quat(q: &Quat) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// Cubes of unit mass and edge under unit gravity; pair stiffnesses among each other and with the floor.
fn cubes(stiffness: [f64; 2], tangential_ratio: f64, positions: &[[f64; 3]], turns: &[Quat]) -> SceneText {
    let law = |k: f64| {
        format!(
            "stiffness_n_per_m = {k:?}\nrestitution = 0.3\nfriction = 0.5\n\
             tangential_stiffness_ratio = {tangential_ratio:?}"
        )
    };
    SceneText::new([0.0, 0.0, -1.0], "time_step = \"auto\"")
        .contact("contact_end = \"tension\"")
        .materials_apart(1.0, &law(stiffness[0]), &law(stiffness[1]))
        .shape("kind = \"cube\", edge_m = 1.0")
        .floor()
        .poses("s", positions, &turns.iter().map(quat).collect::<Vec<_>>())
}

/// Stiffness of two aligned faces and of one on the floor, and of two faces against rocking, for pair stiffness 1; the
/// last over a^2. From the law's own energy at an overlap of 1e-6.
fn face_stiffness() -> anyhow::Result<[f64; 3]> {
    let overlap = 1e-6;
    let energy = |lower: f64, upper: f64, tilt: f64| -> anyhow::Result<f64> {
        let turns = [Quat::identity(), Quat::from_scaled_axis(Vec3::y() * tilt)];
        // about the middle of the contact
        let centre = turns[1] * Vec3::new(0.0, 0.0, 0.5);
        let positions = [[0.0, 0.0, lower], [centre.x, centre.y, upper - 0.5 + centre.z]];
        Ok(cubes([1.0; 2], 2.0 / 7.0, &positions, &turns).start()?.report().energy.elastic_j)
    };
    let two = 2.0 * energy(10.0, 11.0 - overlap, 0.0)? / (overlap * overlap);
    let wall = 2.0 * energy(0.5 - overlap, 5.0, 0.0)? / (overlap * overlap);
    let tilt = 1e-3 * overlap;
    let rocking = 2.0 * (energy(10.0, 11.0 - overlap, tilt)? - energy(10.0, 11.0 - overlap, 0.0)?) / (tilt * tilt);
    Ok([two, wall, rocking])
}

/// How the tower stands at first.
#[derive(Clone, Copy, Debug)]
enum Stand {
    Aligned,
    Offset,
    Leaning,
}

fn tower(count: u32, stand: Stand) -> anyhow::Result<SceneText> {
    let [two, wall, _] = face_stiffness()?;
    let lean = match stand {
        Stand::Leaning => Quat::from_scaled_axis(Vec3::y() * 1e-3),
        _ => Quat::identity(),
    };
    let offset = |k: u32| if matches!(stand, Stand::Offset) { 0.01 * f64::from(k % 2) } else { 0.0 };
    // turned about the edge that it leans over
    let edge = Vec3::new(0.5, 0.0, 0.0);
    let positions: Vec<[f64; 3]> =
        (0..count).map(|k| (edge + lean * (Vec3::new(offset(k), 0.0, f64::from(k) + 0.5) - edge)).into()).collect();
    let turns = vec![lean; count as usize];
    // 2/7 of the face's stiffness, not of the pair's
    Ok(cubes([FACE_STIFFNESS / two, FACE_STIFFNESS / wall], 2.0 / 7.0 * two, &positions, &turns))
}

fn towers(checks: &mut Checks) -> anyhow::Result<()> {
    let [two, wall, rocking] = face_stiffness()?;
    checks.shows("stiffness of two aligned faces over that of the pair", two, "-");
    checks.shows("of a face on the floor", wall, "-");
    // Euler's column under its own weight, q L^3 = 7.837 E I, with the contacts as its springs against bending
    for count in [10.0f64, 50.0] {
        checks.shows(format!("{count} cubes buckle at m g/(K a)"), 7.837 * rocking / two / count.powi(3), "-");
    }
    for count in [10, 50] {
        for stand in [Stand::Aligned, Stand::Offset, Stand::Leaning] {
            stands(checks, count, stand, 200.0)?;
        }
    }
    Ok(())
}

fn short_towers(checks: &mut Checks) -> anyhow::Result<()> {
    for stand in [Stand::Aligned, Stand::Offset] {
        stands(checks, 10, stand, 15.0)?;
    }
    Ok(())
}

fn kinetic(engine: &Engine) -> f64 {
    let energy = engine.report().energy;
    energy.kinetic_translation_j + energy.kinetic_rotation_j
}

/// Sideways and upwards.
fn largest_shift(from: &[[f64; 3]], to: &[[f64; 3]]) -> f64 {
    from.iter().zip(to).map(|(a, b)| (Vec3::from(*b) - Vec3::from(*a)).norm()).fold(0.0, f64::max)
}

/// Runs for `duration` sqrt(a/g); judged over the last tenth of it.
fn stands(checks: &mut Checks, count: u32, stand: Stand, duration: f64) -> anyhow::Result<()> {
    let mut engine = tower(count, stand)?.start()?;
    let name = format!("{count} cubes, {stand:?}");
    checks.run_for(&mut engine, 0.9 * duration)?;
    let before = snapshot(&engine);
    checks.run_for(&mut engine, 0.1 * duration)?;
    let after = snapshot(&engine);
    let n = f64::from(count);
    let drift = largest_shift(&before.positions, &after.positions) * 1e6 / (after.step - before.step) as f64;
    if matches!(stand, Stand::Leaning) && count > 10 {
        return sways(checks, &name, &engine, drift);
    }
    checks.vanishes(format!("{name}: kinetic energy per particle over m g a"), kinetic(&engine) / n, 1e-9, "-");
    checks.vanishes(format!("{name}: drift over a per 1e6 steps"), drift, 1e-5, "-");
    checks.close(
        format!("{name}: force on the floor over the weight"),
        -after.boundaries[0].force_n[2] / n,
        1.0,
        1e-6,
        "-",
    );
    let height = after.positions[0][2];
    checks.close(format!("{name}: overlap at the floor"), 0.5 - height, n / FACE_STIFFNESS, 1e-2, "a");
    if matches!(stand, Stand::Aligned) {
        let gap = after.positions[1][2] - height;
        checks.close(format!("{name}: overlap above the lowest"), 1.0 - gap, (n - 1.0) / FACE_STIFFNESS, 1e-2, "a");
    }
    Ok(())
}

/// 50 cubes that were let go while leaning rock on their edge and then sway in their lowest bending mode, 1.8 sqrt(g/a)
/// by Euler and Bernoulli with the contacts as springs. A dashpot made for contacts of 1,400 sqrt(g/a) takes 1e-4 to
/// 1e-3 sqrt(g/a) from it, whatever the law: at rest by contact damping alone is a matter of 1e4 sqrt(a/g). The figures
/// are shown; judged is that it stands and has lost energy.
fn sways(checks: &mut Checks, name: &str, engine: &Engine, drift: f64) -> anyhow::Result<()> {
    let state = snapshot(engine);
    let n = state.positions.len() as f64;
    let per_particle = kinetic(engine) / n;
    checks.shows(format!("{name}: kinetic energy per particle over m g a"), per_particle, "-");
    checks.shows(format!("{name}: motion over a per 1e6 steps"), drift, "-");
    // a lean of 1e-3 lifts the weight by half an edge times that
    checks.holds(format!("{name}: less than what letting go gave it"), per_particle < 0.5e-3);
    let top = state.positions.last().map_or(0.0, |x| x[2]);
    checks.close(format!("{name}: height of the top"), top, n - 0.5, 1e-4, "a");
    Ok(())
}

/// Cubes, boxes, tetrahedra, octahedra, pinacoids and wedges of sizes up to 2, each on one of its faces in any yaw.
/// mu = tan 26.5 deg + 0.01; a settling time of 10 sqrt(a/g), then 5 more.
fn slope(checks: &mut Checks) -> anyhow::Result<()> {
    let angle = 26.5f64.to_radians();
    let shapes = [
        "kind = \"cube\", edge_m = 1.0",
        "kind = \"box\", size_m = [1.5, 1.0, 0.7]",
        "kind = \"tetrahedron\", edge_m = 1.4",
        "kind = \"octahedron\", edge_m = 1.0",
        "kind = \"pinacoid\", length_m = 1.6, width_m = 1.6, height_m = 1.2, alpha_deg = 60.0",
        "kind = \"convex_polyhedron\", vertices_m = [[0.0, 0.0, 0.0], [1.2, 0.0, 0.0], [0.0, 1.0, 0.0], \
         [0.0, 0.0, 0.7], [1.2, 0.0, 0.7], [0.0, 1.0, 0.7]]",
    ];
    let mut scene = SceneText::new([angle.sin(), 0.0, -angle.cos()], "time_step = \"auto\"")
        .materials(1.0, &format!("stiffness_n_per_m = 1e6\nrestitution = 0.3\nfriction = {:?}", angle.tan() + 0.01))
        .floor();
    for (k, geometry) in shapes.iter().enumerate() {
        scene = scene.named_shape(&format!("s{k}"), geometry);
    }
    let built = scene.validate()?;
    let mut draw = Draw(26);
    for k in 0..32u32 {
        let shape = (k as usize) % shapes.len();
        let (turn, height) = lying(&built.shapes()[shape], &mut draw);
        // poses are those of the frame that the shape was given in
        let (given_from_body, shift) = built.shapes()[shape].given_from_body();
        let given = turn * given_from_body.inverse();
        let position = Vec3::new(f64::from(k % 8) * 3.0, f64::from(k / 8) * 3.0, height) - given * shift;
        scene = scene.poses(&format!("s{shape}"), &[position.into()], &[quat(&given)]);
    }
    let mut engine = scene.start()?;
    checks.run_for(&mut engine, 10.0)?;
    let before = snapshot(&engine);
    checks.run_for(&mut engine, 5.0)?;
    let (after, masses) = (snapshot(&engine), weights(&engine));
    checks.steps(&mut engine, 1)?;
    let next = snapshot(&engine);
    let dt = next.time_s - after.time_s;
    let unbalanced = (0..32)
        .map(|k| masses[k] * (Vec3::from(next.velocities[k]) - Vec3::from(after.velocities[k])).norm() / dt)
        .sum::<f64>();
    checks.vanishes("resultant over contact forces", unbalanced / masses.iter().sum::<f64>(), 1e-4, "-");
    let drift = largest_shift(&before.positions, &after.positions) / 5.0;
    checks.vanishes("drift", drift, 1e-6, "a/s");
    checks.holds("all stand on the plane", engine.report().touching_boundary_pairs == 32);
    Ok(())
}

/// With unit gravity.
fn weights(engine: &Engine) -> Vec<f64> {
    let state = snapshot(engine);
    let volume = |shape: u32| engine.scene().shapes()[shape as usize].mass_properties().volume;
    state.shapes.iter().map(|&shape| volume(shape)).collect()
}

/// An orientation with a face down on which the body does not topple at 26.5 degrees, and the height of its centre.
fn lying(shape: &sturz_engine::shape::Shape, draw: &mut Draw) -> (Quat, f64) {
    let sturz_engine::shape::PartGeometry::Polyhedron(solid) = &shape.parts()[0].geometry else {
        unreachable!("all are polyhedra")
    };
    // the height of the centre over the least distance of its foot from the sides: stable below cot 26.5 deg
    let slenderness = |face: usize| {
        let plane = &solid.faces()[face];
        let foot = plane.normal * plane.offset;
        let corners: Vec<Vec3> = solid.face_vertices(face).iter().map(|&v| solid.vertices()[v as usize]).collect();
        let inside = (0..corners.len())
            .map(|k| {
                let (p, q) = (corners[k], corners[(k + 1) % corners.len()]);
                plane.normal.cross(&(q - p).normalize()).dot(&(foot - p))
            })
            .fold(f64::MAX, f64::min);
        if inside > 0.0 { plane.offset / inside } else { f64::MAX }
    };
    let stable: Vec<usize> = (0..solid.faces().len()).filter(|&face| slenderness(face) < 1.8).collect();
    let face = stable[(draw.unit() * stable.len() as f64) as usize];
    let plane = &solid.faces()[face];
    let down = Quat::rotation_between(&plane.normal, &-Vec3::z())
        .unwrap_or_else(|| Quat::from_scaled_axis(Vec3::x() * std::f64::consts::PI));
    (Quat::from_scaled_axis(Vec3::z() * (std::f64::consts::TAU * draw.unit())) * down, plane.offset)
}
