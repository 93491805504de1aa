//! `sturz study`

use std::path::PathBuf;

use clap::Args;

use super::SceneArgument;

/// `sturz study`
#[derive(Debug, Args)]
pub struct Study {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgument,
    /// What to vary: time_step, stiffness, threads, restitution, friction, rounding, law, sharing, rotation, or a path into the
    /// scene file, each with values: time_step=x1,x0.5,x0.25,threads=1,2. `x` multiplies what the scene has
    #[arg(long, required = true, value_name = "KEY[=VALUE,...],...")]
    pub vary: Vec<String>,
    /// What to measure, such as position[0], mean_height, energy_residual, force_on[floor], field[NAME.density]
    #[arg(long, value_name = "NAME")]
    pub measure: String,
    /// What errors are measured from: `finest` (a run of its own at a quarter of the smallest time step), `exact`, or numbers
    #[arg(long, default_value = "finest", value_name = "finest|exact|NUMBERS", allow_hyphen_values = true)]
    pub reference: String,
    /// The error that the recommended setting must reach
    #[arg(long, default_value_t = 1e-2, value_name = "ERROR")]
    pub error: f64,
    /// Simulated time at which the runs end, s; the scene's `[stop] time_s` when absent
    #[arg(long, value_name = "SECONDS")]
    pub time: Option<f64>,
    /// Average the measure from this simulated time to the end, instead of reading it at the end
    #[arg(long, value_name = "SECONDS")]
    pub average_from: Option<f64>,
    /// Runs of each setting, each at another phase of the time step
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=1000), value_name = "N")]
    pub samples: u16,
    /// For chaotic scenes: each sample has a seed of its own; errors are those of the means, with their standard errors
    #[arg(long)]
    pub seeds: bool,
    /// What differences are divided by; the reference's norm when absent
    #[arg(long, value_name = "NUMBER")]
    pub scale: Option<f64>,
    /// Threads of the physics, where they are not varied
    #[arg(long, env = "STURZ_THREADS", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Do not run the recommended setting once more
    #[arg(long)]
    pub no_confirm: bool,
    /// Write the plot here: error against wall time, SVG
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// Print all of it as JSON, and no progress
    #[arg(long)]
    pub json: bool,
}
