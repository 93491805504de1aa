//! Files of a journal that were cut or have flipped bits: refused or recovered, never accepted wrong.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail, ensure};

use crate::cases::Checks;
use crate::faults::Size;
use crate::faults::chance::Chance;
use crate::faults::daemon::{Daemon, Folder};
use crate::faults::script::{self, HEAP};

/// What became of a damaged journal.
#[derive(Default)]
struct Fates {
    /// Not taken up, with a reason.
    refused: u32,
    /// Taken up at a place that the run has been at.
    recovered: u32,
    wrong: Vec<String>,
}

/// Damages every file of a journal in many places, and takes it up each time.
pub fn check(checks: &mut Checks, size: Size) -> anyhow::Result<()> {
    let folder = Folder::new("damage")?;
    let scene = folder.join("scene.toml");
    fs::write(&scene, HEAP)?;
    let journal = folder.join("journal");
    let mut daemon =
        Daemon::serve([&*scene, "--name", "damage", "--paused", "--journal", &journal, "--checkpoint-every", "0.05"])?;
    let simulation = daemon.connect()?;
    let mut reached = script::run(&simulation, &script::script(7, 30))?;
    // Snapshots come with steps and time: wait for two.
    while fs::read_dir(Path::new(&journal).join("snapshots"))?.count() < 2 {
        simulation.step(1)?;
        reached.push(script::Reached { outcome: None, repeated: false, state_hash: simulation.info()?.state_hash });
    }
    let mut states: HashSet<u64> = reached.iter().map(|one| one.state_hash).collect();
    daemon.kill()?;
    // A state in the midst of the log is that of a snapshot, too.
    let sound = take_up(Path::new(&journal))?.map_err(|said| anyhow::anyhow!("the sound journal: {said}"))?;
    ensure!(states.contains(&sound), "the sound journal is taken up elsewhere");
    states.insert(initial(&scene)?);

    let mut fates = Fates::default();
    let mut chance = Chance::new(1);
    for file in files(Path::new(&journal))? {
        for _ in 0..size.of(2, 60) {
            let whole = fs::read(&file)?;
            if whole.is_empty() {
                continue;
            }
            let at = chance.below(whole.len() as u64) as usize;
            let (damaged, how) = if chance.below(2) == 0 {
                (whole[..at].to_vec(), format!("cut at {at}"))
            } else {
                let mut bytes = whole.clone();
                bytes[at] ^= 1 << chance.below(8);
                (bytes, format!("a bit of byte {at}"))
            };
            let copy = Folder::new("damaged")?;
            copy_all(Path::new(&journal), copy.path())?;
            let name = file.strip_prefix(&journal).context("a file of the journal")?;
            fs::write(copy.path().join(name), damaged)?;
            match take_up(copy.path())? {
                Err(_) => fates.refused += 1,
                Ok(hash) if states.contains(&hash) => fates.recovered += 1,
                Ok(hash) => fates.wrong.push(format!("{}: {how}: state {hash:016x}", name.display())),
            }
        }
    }
    checks.shows("damaged journals refused", f64::from(fates.refused), "-");
    checks.shows("recovered at a state that the run has had", f64::from(fates.recovered), "-");
    checks.near("taken up with another state", fates.wrong.len() as f64, 0.0, 0.0, "-");
    checks.holds("both fates occur", fates.refused > 0 && fates.recovered > 0);
    fates.wrong.iter().take(5).for_each(|wrong| eprintln!("{wrong}"));
    Ok(())
}

/// State hash of a run that is taken up, or why it is not.
fn take_up(journal: &Path) -> anyhow::Result<Result<u64, String>> {
    let daemon = match Daemon::serve(["--resume".as_ref(), journal.as_os_str()]) {
        Ok(daemon) => daemon,
        Err(error) => return Ok(Err(error.to_string())),
    };
    Ok(Ok(daemon.connect()?.info()?.state_hash))
}

/// Before anything was asked.
fn initial(scene: &str) -> anyhow::Result<u64> {
    Ok(Daemon::serve([scene, "--name", "initial", "--paused"])?.connect()?.info()?.state_hash)
}

fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(files(&path)?);
        } else {
            found.push(path);
        }
    }
    found.sort();
    if found.is_empty() {
        bail!("{} is empty", folder.display());
    }
    Ok(found)
}

fn copy_all(from: &Path, to: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy_all(&path, &target)?;
        } else {
            fs::copy(&path, &target)?;
        }
    }
    Ok(())
}
