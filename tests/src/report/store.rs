//! What is done is kept, so that a validation that was stopped goes on where it was: one file for each case.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use serde::{Deserialize, Serialize};

use super::curve::Curve;
use crate::cases::{Case, Row};

/// A case that was run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// Its id.
    pub id: String,
    /// One line.
    pub title: String,
    /// Of the program that ran it: what another program gave is not believed.
    pub fingerprint: u64,
    /// Its figures.
    pub rows: Vec<Row>,
    /// Its curves.
    pub curves: Vec<Curve>,
}

/// Folder of records.
pub struct Store {
    folder: PathBuf,
    fingerprint: u64,
}

impl Store {
    /// In a folder, which is made.
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        let program = std::fs::read(std::env::current_exe()?)?;
        let mut hasher = DefaultHasher::new();
        program.hash(&mut hasher);
        Ok(Self { folder: folder.to_owned(), fingerprint: hasher.finish() })
    }

    fn path(&self, id: &str) -> PathBuf {
        self.folder.join(format!("{id}.json"))
    }

    /// The record of a case, if this very program made it.
    pub fn done(&self, id: &str) -> Option<Record> {
        let text = std::fs::read_to_string(self.path(id)).ok()?;
        serde_json::from_str(&text).ok().filter(|record: &Record| record.fingerprint == self.fingerprint)
    }

    /// Runs a case, unless that is done, and keeps what it gave.
    pub fn run(&self, case: &Case, data: &Path) -> anyhow::Result<Record> {
        if let Some(record) = self.done(case.id) {
            return Ok(record);
        }
        let (rows, curves) = case.outcome_with(data);
        let (id, title) = (case.id.into(), case.title.into());
        let record = Record { id, title, fingerprint: self.fingerprint, rows, curves };
        // whole or not at all: the next run would believe half a file no less
        let (path, partial) = (self.path(case.id), self.folder.join("partial"));
        std::fs::write(&partial, serde_json::to_string(&record)?)?;
        std::fs::rename(&partial, &path).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(record)
    }
}
