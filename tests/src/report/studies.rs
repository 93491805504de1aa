//! Studies of bundled scenes for the report: `sturz study`, run as a user would.

use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, bail};
use serde::Deserialize;

use crate::cases::Tier;

/// A study of the report.
#[derive(Clone, Copy, Debug)]
pub struct Study {
    /// Name of its files.
    pub name: &'static str,
    /// One line.
    pub title: &'static str,
    /// From which tier on.
    pub tier: Tier,
    /// Of `sturz study`.
    pub arguments: &'static [&'static str],
}

/// All of them: an impact, a top, rolling, a packing, a slope, a drum.
pub const STUDIES: &[Study] = &[
    Study {
        name: "impact",
        title: "Impact: velocity of a ball after its first bounce",
        tier: Tier::Fast,
        arguments: &[
            "bouncing-sphere",
            "--vary",
            "time_step=x16,x8,x4,x2,x1",
            "--measure",
            "velocity[0]",
            "--time",
            "0.3",
            "--error",
            "5e-3",
            "--samples",
            "8",
        ],
    },
    Study {
        name: "top",
        title: "Top: attitude after 20 s",
        tier: Tier::Fast,
        arguments: &["free-top", "--vary", "time_step,rotation", "--measure", "orientation[0]", "--error", "1e-3"],
    },
    Study {
        name: "rolling",
        title: "Rolling: speed of a ball on a slope after 1 s, against 5/7 g sin(30 deg)",
        tier: Tier::Fast,
        arguments: &[
            "rolling-sphere",
            "--vary",
            "time_step=x2,x1,x0.5,stiffness=x0.25,x1,x4,x16",
            "--measure",
            "velocity[0]",
            "--reference",
            "3.5035714285714286,0,0",
            "--error",
            "1e-4",
        ],
    },
    Study {
        name: "packing",
        title: "Packing: mean height of a layer of pinacoids after 0.25 s, over seeds",
        tier: Tier::Nightly,
        arguments: &[
            "pinacoid-layer",
            "--vary",
            "time_step=x2,x1",
            "--measure",
            "mean_height",
            "--time",
            "0.25",
            "--seeds",
            "--samples",
            "3",
            "--error",
            "0.02",
        ],
    },
    Study {
        name: "slope",
        title: "Slope: kinetic energy of flowing rods, over seeds, averaged from 0.3 to 0.5 s",
        tier: Tier::Nightly,
        arguments: &[
            "spherocylinder-slope",
            "--vary",
            "time_step=x2,x1",
            "--measure",
            "kinetic_energy",
            "--time",
            "0.5",
            "--average-from",
            "0.3",
            "--seeds",
            "--samples",
            "4",
            "--error",
            "0.05",
        ],
    },
    Study {
        name: "drum",
        title: "Drum: mean height of the spheres in a turning drum, over seeds, averaged from 0.5 to 1 s",
        tier: Tier::Nightly,
        arguments: &[
            "drum-spheres",
            "--vary",
            "time_step=x2,x1",
            "--measure",
            "mean_height",
            "--time",
            "1.0",
            "--average-from",
            "0.5",
            "--seeds",
            "--samples",
            "4",
            "--scale",
            "0.05",
            "--error",
            "0.02",
        ],
    },
];

/// What the page shows of a study.
#[derive(Debug, Deserialize)]
pub struct StudyResult {
    /// Of the study; filled in here.
    #[serde(skip)]
    pub title: String,
    /// What was typed.
    #[serde(skip)]
    pub command: String,
    /// The plot.
    #[serde(skip)]
    pub svg: String,
    /// Name of the scene.
    pub scene: String,
    /// What was measured.
    pub measure: String,
    /// What errors are measured from.
    pub reference: String,
    /// What was asked for.
    pub wanted_error: f64,
    /// Observed orders.
    pub orders: Vec<StudyOrder>,
    /// Cheapest setting for it.
    pub recommendation: Option<StudyRecommendation>,
    /// What must be known.
    pub remarks: Vec<String>,
}

/// See `sturz study`.
#[derive(Debug, Deserialize)]
pub struct StudyOrder {
    /// Of which key.
    pub key: String,
    /// The other values.
    pub others: String,
    /// Slope.
    pub order: f64,
}

/// See `sturz study`.
#[derive(Debug, Deserialize)]
pub struct StudyRecommendation {
    /// The setting.
    pub label: String,
    /// By a run of its own.
    pub confirmed_error: Option<f64>,
    /// Of that.
    pub confirmed_error_bar: f64,
    /// Of that, s.
    pub confirmed_wall_s: f64,
    /// Whether it kept to the wanted error.
    pub confirmed: Option<bool>,
}

impl Study {
    /// Whether it has left its files in this folder.
    pub fn is_kept(&self, folder: &Path) -> bool {
        folder.join(format!("{}.json", self.name)).exists()
    }

    /// Runs it with the program `sturz`, unless its files are there and younger than the program.
    pub fn run(&self, sturz: &Path, folder: &Path) -> anyhow::Result<StudyResult> {
        std::fs::create_dir_all(folder)?;
        let (json, svg) = (folder.join(format!("{}.json", self.name)), folder.join(format!("{}.svg", self.name)));
        let modified = |path: &Path| std::fs::metadata(path).and_then(|data| data.modified()).ok();
        if !svg.exists() || modified(&json) < modified(sturz) {
            let mut command = Command::new(sturz);
            command.arg("study").args(self.arguments).arg("--json").arg("--plot").arg(&svg);
            let output = command.output().with_context(|| format!("cannot run {}", sturz.display()))?;
            if !output.status.success() {
                bail!("study {}: {}", self.name, String::from_utf8_lossy(&output.stderr).trim());
            }
            std::fs::write(&json, output.stdout)?;
        }
        let mut result: StudyResult = serde_json::from_str(&std::fs::read_to_string(&json)?)?;
        result.title = self.title.into();
        result.command = format!("sturz study {}", self.arguments.join(" "));
        result.svg = std::fs::read_to_string(&svg)?;
        Ok(result)
    }
}
