//! `sturz inspect`, `sturz top`.

use std::path::PathBuf;

use clap::Args;

use crate::config::DEFAULT_LISTEN;

/// `sturz inspect`
#[derive(Debug, Args)]
pub struct Inspect {
    /// Name on the bus; not needed where only one daemon is alive
    pub name: Option<String>,
    /// Where the daemon listens
    #[arg(long, env = "STURZ_ENDPOINT", default_value = DEFAULT_LISTEN, value_name = "ENDPOINT")]
    pub endpoint: String,
    /// A zenoh configuration file to start from
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Folder with the certificate of this client, such as LAB/clients/NAME
    #[arg(long, value_name = "DIR")]
    pub tls: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `sturz top`
#[derive(Debug, Args)]
pub struct Top {
    /// Name on the bus; not needed where only one daemon is alive
    pub name: Option<String>,
    /// Where the daemon listens
    #[arg(long, env = "STURZ_ENDPOINT", default_value = DEFAULT_LISTEN, value_name = "ENDPOINT")]
    pub endpoint: String,
    /// A zenoh configuration file to start from
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Folder with the certificate of this client, such as LAB/clients/NAME
    #[arg(long, value_name = "DIR")]
    pub tls: Option<PathBuf>,
    /// Wall time between two views, s; at least 0.1
    #[arg(long, default_value_t = 1.0, value_name = "SECONDS")]
    pub every: f64,
    /// Print one view and end
    #[arg(long)]
    pub once: bool,
}
