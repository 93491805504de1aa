//! S4: needles and plates 1:100 against the fifteen axes of two boxes and the closest points of two segments.

use sturz_engine::math::{Mat3, Similarity, Vec3};
use sturz_engine::narrow::{Manifold, PairCache, collide};
use sturz_engine::shape::{Part, Shape, ShapeDescription};

use super::rounded_pose::Draw;
use super::{Case, Checks};

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("S4", "needles and plates 1:100: contacts missed, depth, normal; 30,000 pairs of a kind", few),
        Case::slow("S4L", "the same with 1,000,000 pairs of a kind", many),
    ]
}

fn few(checks: &mut Checks) -> anyhow::Result<()> {
    pairs(checks, 30_000)
}

fn many(checks: &mut Checks) -> anyhow::Result<()> {
    pairs(checks, 1_000_000)
}

/// What brute force says: separation (negative: depth), unit normal from `a` to `b`, and by how much the runner-up of
/// another direction is worse.
struct Answer {
    separation: f64,
    normal: Vec3,
    lead: f64,
}

fn part(description: &ShapeDescription) -> anyhow::Result<Part> {
    Ok(Shape::build(description)?.parts()[0].clone())
}

/// Half edges of `a` along its axes, of `b` along the columns of the pose's rotation: all face normals and all cross
/// products of edges.
fn boxes(a: &Vec3, b: &Vec3, pose: &Similarity) -> Answer {
    let t = pose.translation;
    let mut axes: Vec<Vec3> = (0..3).map(|k| Vec3::ith(k, 1.0)).collect();
    axes.extend((0..3).map(|k| pose.rotation.column(k).into_owned()));
    for i in 0..3 {
        for j in 0..3 {
            let cross = axes[i].cross(&axes[3 + j]);
            if cross.norm() > 1e-9 {
                axes.push(cross.normalize());
            }
        }
    }
    let reach = |axis: &Vec3| {
        let of_b = pose.rotation.tr_mul(axis);
        a.dot(&axis.abs()) + b.dot(&of_b.abs())
    };
    let mut found: Vec<(f64, Vec3)> =
        axes.iter().map(|n| (n.dot(&t).abs() - reach(n), if n.dot(&t) < 0.0 { -n } else { *n })).collect();
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    let (separation, normal) = found[0];
    let lead = found.iter().find(|(_, n)| (n - normal).norm() > 1e-6).map_or(1.0, |(s, _)| separation - s);
    Answer { separation, normal, lead }
}

/// Two segments along x: the least distance over their four ends against the other segment and, where both feet of the
/// common perpendicular are inside, over these.
fn capsules(half: f64, radius: f64, pose: &Similarity) -> Answer {
    let (d, t) = (pose.rotation.column(0).into_owned(), pose.translation);
    let gap = |s: f64, u: f64| t + d * u - Vec3::x() * s;
    let mut gaps: Vec<Vec3> = [-half, half]
        .into_iter()
        .flat_map(|end| {
            let on_a = (t + d * end).x.clamp(-half, half);
            let on_b = d.dot(&(Vec3::x() * end - t)).clamp(-half, half);
            [gap(on_a, end), gap(end, on_b)]
        })
        .collect();
    let sine2 = 1.0 - d.x * d.x;
    if sine2 > 0.0 {
        let u = (d.x * t.x - d.dot(&t)) / sine2;
        let s = t.x + d.x * u;
        if s.abs() <= half && u.abs() <= half {
            gaps.push(gap(s, u));
        }
    }
    let nearest = gaps.into_iter().min_by(|x, y| x.norm().total_cmp(&y.norm())).expect("four at least");
    let distance = nearest.norm();
    // where the rods are nearly parallel many points are nearly as close
    Answer { separation: distance - 2.0 * radius, normal: nearest / distance, lead: distance * sine2 }
}

/// Random poses, half of them turned so that long sides are nearly parallel, at depths around 0. What brute force leaves
/// open (a depth below 1e-12, two directions as good as each other) is not judged.
fn pairs(checks: &mut Checks, count: u64) -> anyhow::Result<()> {
    let needle = Vec3::new(0.5, 0.005, 0.005);
    let plate = Vec3::new(0.5, 0.5, 0.005);
    let solid = |half: &Vec3| part(&ShapeDescription::Box { size_m: (half * 2.0).into() });
    let rod = part(&ShapeDescription::Spherocylinder { radius_m: 0.005, total_length_m: 1.0 })?;
    type Oracle = Box<dyn Fn(&Similarity) -> Answer>;
    let kinds: [(&str, Part, Part, Oracle); 4] = [
        ("needle, needle", solid(&needle)?, solid(&needle)?, Box::new(move |pose| boxes(&needle, &needle, pose))),
        ("needle, plate", solid(&needle)?, solid(&plate)?, Box::new(move |pose| boxes(&needle, &plate, pose))),
        ("plate, plate", solid(&plate)?, solid(&plate)?, Box::new(move |pose| boxes(&plate, &plate, pose))),
        ("rod, rod", rod.clone(), rod, Box::new(|pose| capsules(0.495, 0.005, pose))),
    ];
    for (name, a, b, oracle) in &kinds {
        let (mut wrong, mut touching, mut depth_error, mut normal_error) = (0u64, 0u64, 0.0f64, 0.0f64);
        let mut draw = Draw(4);
        for k in 0..count {
            let pose = pose(&mut draw, k, oracle);
            let answer = oracle(&pose);
            if answer.separation.abs() < 1e-12 {
                continue;
            }
            let mut manifold = Manifold::default();
            collide(a, b, &pose, &mut PairCache::default(), &mut manifold);
            wrong += u64::from(manifold.is_empty() != (answer.separation > 0.0));
            let Some(deepest) = manifold.points().iter().max_by(|p, q| p.overlap.total_cmp(&q.overlap)) else {
                continue;
            };
            touching += 1;
            depth_error = depth_error.max((deepest.overlap + answer.separation).abs());
            if answer.lead > 1e-9 {
                normal_error = normal_error.max((deepest.normal - answer.normal).norm());
            }
        }
        checks.holds(format!("{name}: a quarter of the poses at least touch"), touching > count / 4);
        checks.vanishes(format!("{name}: missed or invented, of {count}"), wrong as f64, 0.0, "-");
        checks.vanishes(format!("{name}: depth"), depth_error, 1e-11, "m");
        checks.vanishes(format!("{name}: normal"), normal_error, 1e-6, "-");
    }
    Ok(())
}

/// The bodies are moved along their least axis to a separation between -1e-3 and 5e-4 of the thickness.
fn pose(draw: &mut Draw, k: u64, oracle: &dyn Fn(&Similarity) -> Answer) -> Similarity {
    let mut between = |low: f64, high: f64| low + (high - low) * draw.unit();
    let turn = |axis: Vec3| *sturz_engine::math::Quat::from_scaled_axis(axis).to_rotation_matrix().matrix();
    let mut rotation: Mat3 = turn(Vec3::from_fn(|_, _| between(-2.5, 2.5)));
    if k.is_multiple_of(2) {
        let small = 10f64.powf(between(-9.0, -1.0));
        rotation = turn(Vec3::from_fn(|_, _| between(-small, small)));
    }
    let translation = Vec3::new(between(-0.5, 0.5), between(-0.3, 0.3), between(-0.3, 0.3));
    let mut pose = Similarity::rigid(rotation, translation);
    let target = 0.01 * between(-1e-3, 5e-4);
    // a move along the normal changes it where the closest features change: a few rounds
    for _ in 0..6 {
        let answer = oracle(&pose);
        pose.translation += answer.normal * (target - answer.separation);
    }
    pose
}
