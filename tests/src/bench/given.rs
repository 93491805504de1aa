//! Workloads of rounded polyhedra on relaxed beds that come with the program: those that Rockable was timed on.
//!
//! `tests/data/*.bed.gz`: lines `x y z qw qx qy qz`, at rest, without contact history. Stiffness and dashpot belong to
//! each pair of features. What Rockable counts at the start: W2r 5,104 pairs with 3,627 vertex-face, 4,076 edge-edge and
//! 297 vertex-edge contacts; octahedra 16,028 pairs, 24,756 contacts; W3r 1,732 pairs, 2,749 contacts.

use std::io::Read;

use anyhow::{Context, bail};
use flate2::read::GzDecoder;

use super::cache::Bed;
use super::workload::{Workload, polyhedra};

/// The bed of a workload of this file.
pub fn bed(name: &str) -> anyhow::Result<Bed> {
    let file: &[u8] = match name {
        "W2r" => include_bytes!("../../data/cube_r05.bed.gz"),
        "R-octahedra" => include_bytes!("../../data/octa.bed.gz"),
        "W3r" => include_bytes!("../../data/cross_r02.bed.gz"),
        _ => bail!("no bed of '{name}' comes with the program"),
    };
    let mut text = String::new();
    GzDecoder::new(file).read_to_string(&mut text).context("the bed cannot be unpacked")?;
    let mut bed = Bed::default();
    for (k, line) in text.lines().enumerate() {
        let numbers: Vec<f64> = line.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
        let [x, y, z, qw, qx, qy, qz] = numbers[..] else { bail!("line {} of the bed has not 7 numbers", k + 1) };
        bed.positions.push([x, y, z]);
        bed.orientations.push([qw, qx, qy, qz]);
        bed.scales.push(1.0);
    }
    Ok(bed)
}

/// Corners of a box of these half edges.
fn corners(half: [f64; 3]) -> Vec<[f64; 3]> {
    (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half[axis] } else { -half[axis] })).collect()
}

fn mass_properties(volume: f64, inertia: f64) -> String {
    format!("mass_properties = {{ volume_m3 = {volume:?}, inertia_over_mass_m2 = {:?} }}", [inertia; 3])
}

/// W2r: 2,500 cubes, outer edge 1 m, Minkowski radius 0.05 m, with the mass and inertia of sharp ones.
pub fn rounded_cubes() -> Workload {
    let geometry = format!(
        "kind = \"rounded_polyhedron\", radius_m = 0.05, vertices_m = {:?}, {}",
        corners([0.45; 3]),
        mass_properties(1.0, 1.0 / 6.0)
    );
    Workload { is_given: true, ..polyhedra("W2r", &geometry, 1.0) }
}

/// R-octahedra: 5,520 octahedra of unit-less size, kn = kt = 1e4, mu 0.1 (0.3 at walls), e = 0.01.
pub fn octahedra() -> Workload {
    let (a, h) = (0.2310789, 0.3267949);
    let vertices = [[a, a, 0.0], [a, -a, 0.0], [-a, a, 0.0], [-a, -a, 0.0], [0.0, 0.0, h], [0.0, 0.0, -h]];
    let volume = 1.0 / 6.0;
    let geometry = format!(
        "kind = \"rounded_polyhedron\", radius_m = 0.1, vertices_m = {vertices:?}, {}",
        mass_properties(volume, 0.05)
    );
    Workload {
        count: 5520,
        side_m: 16.0,
        density: 1.0,
        stiffness: 1e4,
        friction: [0.1, 0.3],
        tangential_stiffness_ratio: 1.0,
        restitution: 0.01,
        time_step_s: 1e-5,
        is_given: true,
        ..polyhedra("R-octahedra", &geometry, volume)
    }
}

/// W3r: 800 crosses of three rounded boxes 1 x 0.2 x 0.2 m, Minkowski radius 0.02 m.
pub fn rounded_crosses() -> Workload {
    let part = |axis: usize| {
        let mut half = [0.08; 3];
        half[axis] = 0.48;
        let vertices = corners(half);
        format!("{{ shape = {{ kind = \"rounded_polyhedron\", radius_m = 0.02, vertices_m = {vertices:?} }} }}")
    };
    let parts: Vec<String> = (0..3).map(part).collect();
    let geometry =
        format!("kind = \"composite\", parts = [{}], {}", parts.join(", "), mass_properties(0.104, 0.0682051));
    Workload {
        count: 800,
        side_m: 12.0,
        stiffness: 4e7,
        time_step_s: 5e-5,
        loose_fraction: 0.06,
        is_given: true,
        ..polyhedra("W3r", &geometry, 0.104)
    }
}
