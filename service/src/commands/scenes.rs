//! `sturz scenes` and `sturz schema`

use serde::Serialize;

use crate::cli;
use crate::commands::{Failure, print_json};
use crate::reply::scene_schema;
use crate::scenes::{BUNDLED, Bundled};

/// One line of the list.
#[derive(Serialize)]
struct Entry {
    name: &'static str,
    description: String,
}

/// Lists the bundled scenes, or prints one.
pub fn scenes(options: &cli::Scenes) -> Result<(), Failure> {
    if let Some(name) = &options.name {
        let scene = Bundled::named(name)
            .ok_or_else(|| Failure::Scene(format!("no bundled scene {name:?}: `sturz scenes` lists them")))?;
        if options.json {
            return print_json(&scene.description()?);
        }
        print!("{}", scene.text);
        return Ok(());
    }
    let entry = |scene: &Bundled| Ok(Entry { name: scene.name, description: scene.description()?.scene.description });
    let entries = BUNDLED.iter().map(entry).collect::<Result<Vec<Entry>, Failure>>()?;
    if options.json {
        return print_json(&entries);
    }
    entries.iter().for_each(|entry| println!("{:22} {}", entry.name, entry.description));
    Ok(())
}

/// Prints the JSON schema of scene files.
pub fn schema() -> Result<(), Failure> {
    println!("{}", scene_schema());
    Ok(())
}
