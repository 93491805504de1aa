//! `sturz`: reads the command line, runs one command, and tells by the exit code how it went.

use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;

use sturz_service::cli::{self, Command};
use sturz_service::commands::{self, Failure};

fn main() -> ExitCode {
    let arguments = cli::parse(std::env::args_os()).unwrap_or_else(|error| error.exit());
    start_log(&arguments.log);
    let done = match arguments.command {
        Command::Serve(options) => commands::serve(*options),
        Command::Run(options) => commands::run(&options),
        Command::Study(options) => commands::study(&options),
        Command::Prepare(options) => commands::prepare(&options),
        Command::Check(options) => commands::check(&options),
        Command::Scenes(options) => commands::scenes(&options),
        Command::Certs(options) => commands::certs(options),
        Command::Inspect(options) => commands::inspect(&options),
        Command::Top(options) => commands::top(&options),
        Command::Replay(options) => commands::replay(&options),
        Command::Record(options) => commands::record(&options),
        Command::Play(options) => commands::play(options),
        Command::Export(options) => commands::export(&options),
        Command::Fields(options) => commands::fields(&options),
        Command::Schema => commands::schema(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !matches!(failure, Failure::Reported(_)) {
                // Where nobody can be told, the exit code still tells.
                drop(writeln!(std::io::stderr(), "sturz: {failure}"));
            }
            ExitCode::from(failure.exit_code())
        }
    }
}

/// The log goes to standard error: standard output is for what was asked for.
fn start_log(filter: &str) {
    let filter = tracing_subscriber::EnvFilter::try_new(filter).unwrap_or_else(|_| "warn".into());
    let colours = std::io::stderr().is_terminal();
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
    // A log that cannot be written must not end the thread that speaks: by default its failure is printed there, too.
    log.with_target(false).with_ansi(colours).log_internal_errors(false).init();
}
