//! `sturz replay`: goes through a journal again.

use crate::cli;
use crate::commands::{Failure, print_json};
use crate::journal::{self, Folder};

/// Replays a journal from its first record, and tells whether the run was the same.
pub fn replay(options: &cli::Replay) -> Result<(), Failure> {
    let (folder, about) = Folder::look(&options.journal).map_err(|error| Failure::Usage(format!("{error:#}")))?;
    let found = match journal::replay(&folder, options.threads.into()) {
        Ok(found) => found,
        Err(error) => {
            eprintln!("sturz: the replay of {} differs: {error:#}", options.journal.display());
            return Err(Failure::Reported(4));
        }
    };
    if options.json {
        return print_json(&found);
    }
    println!("{}: {} records from record {} on, all as the run was", about.instance, found.records, found.from_record);
    println!("  starts         {}", found.starts);
    println!("  commands       {}", found.commands);
    println!("  outcomes       {} compared", found.outcomes);
    println!("  state hashes   {} compared", found.state_hashes);
    println!("  steps          {}", found.steps);
    println!("  last state     step {}, {:?} s, hash {}", found.step, found.time_s, found.state_hash);
    if found.torn {
        println!("  a last record that was not written to its end, nor acknowledged, is left out");
    }
    Ok(())
}
