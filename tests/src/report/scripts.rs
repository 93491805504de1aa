//! Experiments of the papers: scripts of the Python client that drive the daemon, and what they leave.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, bail};
use serde::Deserialize;

use crate::cases::Tier;

/// A script, and how much of it a tier runs.
#[derive(Clone, Copy, Debug)]
pub struct Script {
    /// Name: of the file in `clients/python/examples/papers`, and of the folder of what it leaves.
    pub name: &'static str,
    /// One line.
    pub title: &'static str,
    /// From which tier on.
    pub tier: Tier,
    /// Arguments of that tier.
    pub arguments: &'static [&'static str],
}

const fn nightly(name: &'static str, title: &'static str, arguments: &'static [&'static str]) -> Script {
    Script { name, title, tier: Tier::Nightly, arguments }
}

const fn release(name: &'static str, title: &'static str, arguments: &'static [&'static str]) -> Script {
    Script { name, title, tier: Tier::Release, arguments }
}

/// All of them. A later entry of the same name does more of the same script, which does not repeat what is done.
pub const SCRIPTS: &[Script] = &[
    nightly("packing", "K1s: frictionless packing of pinacoids", &["--only", "deposited"]),
    nightly(
        "porosity",
        "G6, I16: porosity of settled beds, random close packing",
        &["--only", "sphere", "cube", "tetrahedron", "frictionless"],
    ),
    nightly("incline", "K2s: pinacoids down an incline at 36 and 39 degrees", &["--only", "default-36", "default-39"]),
    nightly(
        "drum",
        "G8s: drum at 80 and 200 rpm",
        &["--only", "sphere-200", "sphere-80", "cross_3d-200", "cross_3d-80"],
    ),
    nightly("chute", "C5s: spherocylinders down a chute", &["--only", "1.01-24", "2.0-28"]),
    nightly("silo", "I12, I13: Janssen and Beverloo", &[]),
    nightly(
        "bagnold",
        "I15: spheres down an incline, Bagnold's profile at 24 degrees",
        &["--only", "24-260", "24-400"],
    ),
    nightly("glued", "G1 to G4: true and glued bodies against a wall", &[]),
    nightly("reactor", "G9: one sphere and one 3D cross in a drum", &["--only", "single"]),
    nightly("fixed_bed", "CFD2: water through beds of spheres, cubes and crosses", &[]),
    nightly("fluidised_bed", "CFD3: a bed of spheres in water, fluidised", &["--only", "sphere"]),
    release("fluidised_bed", "CFD3: spheres and cubes", &[]),
    release(
        "packing",
        "K1s: cloud, deposited bed, the law of the paper",
        &["--only", "default", "shared", "deposited"],
    ),
    release("porosity", "G6: all shapes", &[]),
    release("incline", "K2s at 30 to 45 degrees, under two laws", &[]),
    release("bagnold", "I14, I15: Bagnold's profile over the height, mu(I) over the angle", &[]),
    release("dice", "I19: tetrahedra, poured and shaken", &[]),
    release("reactor", "G7, G9: beds of four shapes in a reactor, one particle in a drum", &[]),
    release("drum", "G8s: spheres and 3D crosses at 5, 80 and 200 rpm", &[]),
    release("chute", "C5s: the three regimes", &[]),
    release("packing", "K1: frictionless packing of pinacoids, the paper's own size", &["--full"]),
];

/// A number beside its reference, as the scripts write it; null where there is none.
#[derive(Clone, Debug, Deserialize)]
pub struct ScriptRow {
    /// Case, and which part of it.
    pub id: String,
    /// What was measured.
    pub metric: String,
    /// What was found.
    pub value: Option<f64>,
    /// Of it.
    pub uncertainty: Option<f64>,
    /// What it should be.
    pub reference: Option<f64>,
    /// Allowed distance.
    pub tolerance: Option<f64>,
    /// 1 for pure numbers.
    pub unit: String,
    /// `pass`, `miss`, `reported` or `short`.
    pub verdict: String,
    /// Of the run so far, s.
    pub wall_s: Option<f64>,
    /// Of the run so far.
    pub particle_steps: Option<f64>,
    /// Where the reference is from.
    #[serde(default)]
    pub source: String,
}

/// What a script has left.
#[derive(Debug)]
pub struct Found {
    /// The script.
    pub name: String,
    /// Its line.
    pub title: String,
    /// In the order of its parts.
    pub rows: Vec<ScriptRow>,
    /// Figures: name and SVG.
    pub figures: Vec<(String, String)>,
}

impl Script {
    /// Runs it to its end, or as far as it gets; it goes on where it stopped by itself.
    pub fn run(&self, python: &str, folder: &Path, threads: usize) -> anyhow::Result<()> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let file = root.join("clients/python/examples/papers").join(format!("{}.py", self.name));
        let out = std::path::absolute(folder.join(self.folder()))?;
        let mut command = Command::new(python);
        command.arg(&file).arg("--out").arg(&out).args(["--threads", &threads.to_string()]).args(self.arguments);
        let status = command.status().with_context(|| format!("cannot run {python} {}", file.display()))?;
        if !status.success() {
            bail!("{} ended with {status}", self.name);
        }
        Ok(())
    }

    /// Full-size runs have a folder of their own.
    fn folder(&self) -> String {
        let full = self.arguments.contains(&"--full");
        if full { format!("{}-full", self.name) } else { self.name.into() }
    }

    /// What it has left in its folder below this one; none when there is nothing.
    pub fn found(&self, folder: &Path) -> anyhow::Result<Option<Found>> {
        let folder = folder.join(self.folder());
        let Ok(text) = std::fs::read_to_string(folder.join("rows.json")) else { return Ok(None) };
        let parts: BTreeMap<String, Vec<ScriptRow>> =
            serde_json::from_str(&text).with_context(|| format!("rows of {}", self.name))?;
        let mut figures = Vec::new();
        let entries = std::fs::read_dir(&folder)?.filter_map(Result::ok).map(|entry| entry.path());
        for path in entries.filter(|path| path.extension().is_some_and(|extension| extension == "svg")) {
            let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
            figures.push((name, std::fs::read_to_string(&path)?));
        }
        figures.sort();
        let rows = parts.into_values().flatten().collect();
        Ok(Some(Found { name: self.folder(), title: self.title.into(), rows, figures }))
    }
}
