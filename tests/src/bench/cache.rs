//! Settled beds on disk, so that a benchmark settles once per machine.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use sturz_engine::{Engine, Snapshot};

use super::workload::Workload;
use crate::scene::snapshot;

/// To be raised when beds should be settled anew: another way to settle, or another engine behaviour.
const VERSION: u32 = 4;

/// Poses by id, of the frame in which the shape is given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bed {
    /// m
    pub positions: Vec<[f64; 3]>,
    /// `world_from_body` (w, x, y, z)
    pub orientations: Vec<[f64; 4]>,
    /// Sizes relative to the shape.
    pub scales: Vec<f64>,
}

impl Bed {
    /// The particles of an engine whose shapes have their given frame as body frame (all workloads').
    pub fn of(engine: &Engine) -> Self {
        let (rotation, centre) = engine.scene().shapes()[0].given_from_body();
        assert!(rotation.angle() == 0.0 && centre.norm() == 0.0, "poses of a bed are those of the given frame");
        let Snapshot { positions, orientations, scales, .. } = snapshot(engine);
        Self { positions, orientations, scales }
    }

    fn to_text(&self, title: &str) -> String {
        let mut text = format!("{title}\n");
        for ((x, q), s) in self.positions.iter().zip(&self.orientations).zip(&self.scales) {
            text += &format!("{s:?} {:?} {:?} {:?} {:?} {:?} {:?} {:?}\n", x[0], x[1], x[2], q[0], q[1], q[2], q[3]);
        }
        text
    }

    fn from_text(text: &str, title: &str) -> Option<Self> {
        let body = text.strip_prefix(title)?.strip_prefix('\n')?;
        let mut bed = Self::default();
        for line in body.lines() {
            let numbers: Vec<f64> = line.split(' ').map(str::parse).collect::<Result<_, _>>().ok()?;
            let [s, x, y, z, qw, qx, qy, qz] = numbers.try_into().ok()?;
            bed.positions.push([x, y, z]);
            bed.orientations.push([qw, qx, qy, qz]);
            bed.scales.push(s);
        }
        Some(bed)
    }
}

/// `.cache/bench` in cargo's target folder.
fn folder() -> PathBuf {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace.join("target"), PathBuf::from);
    target.join(".cache").join("bench")
}

/// First line of the file: a bed of other parameters is not used.
fn title(workload: &Workload) -> String {
    format!("bed {VERSION} {workload:?}")
}

fn path(workload: &Workload) -> PathBuf {
    folder().join(format!("{}-{}.bed", workload.name, workload.count))
}

/// The bed of an earlier run, if there is one of the same parameters.
pub fn load(workload: &Workload) -> Option<Bed> {
    let bed = Bed::from_text(&fs::read_to_string(path(workload)).ok()?, &title(workload))?;
    (bed.positions.len() == workload.count as usize).then_some(bed)
}

/// Keeps a bed for later runs.
pub fn store(workload: &Workload, bed: &Bed) -> anyhow::Result<()> {
    let path = path(workload);
    fs::create_dir_all(folder()).with_context(|| format!("cannot make {}", folder().display()))?;
    // Renamed when whole: a second program may be reading.
    let partial = path.with_extension(format!("{}.partial", std::process::id()));
    fs::write(&partial, bed.to_text(&title(workload)))
        .with_context(|| format!("cannot write {}", partial.display()))?;
    fs::rename(&partial, &path).with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_keeps_every_bit_and_refuses_another_title() {
        let bed = Bed {
            positions: vec![[0.1, 1.0 / 3.0, -1e-300]],
            orientations: vec![[0.5, -0.5, 0.5, 0.5]],
            scales: vec![1.1 - 1e-16],
        };
        let text = bed.to_text("bed 1");
        assert_eq!(Bed::from_text(&text, "bed 1"), Some(bed));
        assert_eq!(Bed::from_text(&text, "bed 2"), None);
        assert_eq!(Bed::from_text("bed 1\n1 2 x\n", "bed 1"), None);
    }
}
