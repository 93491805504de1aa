//! A bed repeated along x and y: the same packing with any number of particles.

use sturz_engine::Engine;
use sturz_engine::scene::{InsertionDescription, Placement, ScaleLaw, Scene, SceneDescription};

use super::cache::Bed;
use super::workload::{Softness, Workload};

/// The workload on a floor `k` times as wide.
fn wide(workload: &Workload, k: u32) -> Workload {
    Workload { side_m: workload.side_m * f64::from(k), count: workload.count * k * k, ..workload.clone() }
}

/// Starts `k` times `k` copies of a bed, at rest, with walls around all of them only.
///
/// Bodies on either side of a former wall touch each other instead, by twice what they overlapped it.
pub fn start(workload: &Workload, bed: &Bed, k: u32, softness: Softness, contact: &str) -> anyhow::Result<Engine> {
    if k == 1 {
        return workload.from_bed(bed, softness).contact(contact).start();
    }
    let mut description = SceneDescription::from_toml(&wide(workload, k).scene(softness).contact(contact).text())?;
    description.insertions = insertions(bed, |position| copies(position, workload.side_m, k));
    Ok(Engine::new(Scene::validate(description)?))
}

/// Starts the particles of a bed so far from each other that no pair is listed.
pub fn start_apart(workload: &Workload, bed: &Bed, softness: Softness, contact: &str) -> anyhow::Result<Engine> {
    const STRETCH: f64 = 4.0;
    let scene = Workload { side_m: workload.side_m * STRETCH, ..workload.clone() }.scene(softness);
    let mut description = SceneDescription::from_toml(&scene.contact(contact).text())?;
    description.insertions = insertions(bed, |position| vec![position.map(|x| x * STRETCH)]);
    Ok(Engine::new(Scene::validate(description)?))
}

fn copies(position: &[f64; 3], side_m: f64, k: u32) -> Vec<[f64; 3]> {
    let shifts = (0..k * k).map(|tile| [f64::from(tile % k), f64::from(tile / k)]);
    shifts.map(|[x, y]| [position[0] + x * side_m, position[1] + y * side_m, position[2]]).collect()
}

/// One insertion for each particle, which keeps its size.
fn insertions(bed: &Bed, place: impl Fn(&[f64; 3]) -> Vec<[f64; 3]>) -> Vec<InsertionDescription> {
    let of = |k: usize| {
        let positions_m = place(&bed.positions[k]);
        let orientations_wxyz = vec![bed.orientations[k]; positions_m.len()];
        InsertionDescription {
            shape: "s".to_owned(),
            material: "m".to_owned(),
            placement: Placement::Poses { positions_m, orientations_wxyz },
            velocity_m_per_s: [0.0; 3],
            angular_velocity_rad_per_s: [0.0; 3],
            scale: ScaleLaw::only(bed.scales[k]),
            frozen: false,
        }
    };
    (0..bed.positions.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{snapshot, steps};

    /// A pair that overlaps by `overlap` sizes across x = 2, on a floor.
    fn pair() -> (Workload, Bed) {
        let workload = Workload { scale: [1.0; 2], ..Workload::named("W1", super::super::Size::Full).unwrap() };
        let d = workload.size_m;
        let bed = Bed {
            positions: vec![[0.5 * d, d, 0.499 * d], [1.499 * d, d, 0.499 * d]],
            orientations: vec![[1.0, 0.0, 0.0, 0.0]; 2],
            scales: vec![1.0; 2],
        };
        (workload, bed)
    }

    #[test]
    fn copies_have_the_contacts_of_the_bed() {
        let (workload, bed) = pair();
        let one = start(&workload, &bed, 1, Softness::NONE, "").unwrap().report();
        let mut engine = start(&workload, &bed, 3, Softness::NONE, "").unwrap();
        let nine = engine.report();
        assert_eq!((one.touching_pairs, one.touching_boundary_pairs), (1, 2));
        assert_eq!((nine.touching_pairs, nine.touching_boundary_pairs, nine.particles), (9, 18, 18));
        steps(&mut engine, 10).unwrap();
        let heights: Vec<f64> = snapshot(&engine).positions.iter().map(|x| x[2]).collect();
        assert!(heights.iter().all(|z| (z - heights[0]).abs() < 1e-12 * workload.size_m), "{heights:?}");
    }

    #[test]
    fn apart_nothing_touches() {
        let (workload, bed) = pair();
        let report = start_apart(&workload, &bed, Softness::NONE, "").unwrap().report();
        assert_eq!((report.particles, report.touching_pairs, report.touching_boundary_pairs), (2, 0, 0));
    }
}
