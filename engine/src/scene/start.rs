//! `[start]`: a scene that goes on with the bed of another one.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;
use super::validate::Problems;
use crate::checkpoint::Bed;
use crate::error::InvalidInput;

/// `[start]`: the particles of a checkpoint that `sturz prepare` has written, instead of an empty scene, at time 0. Sizes,
/// positions, orientations, velocities and who is frozen are taken over; ids are counted from 0 in their old order. The
/// scene needs their shapes and materials under the same names, the shapes with the same geometry, and the same periodic
/// cell; masses follow from its own densities. All else may differ. The springs of contacts are taken over where
/// `[contact]` and the pairs of materials are the same, those at boundaries where these are as well. Insertions of the scene come
/// to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StartSection {
    /// Relative to the scene file.
    pub checkpoint: String,
    /// What is in it; whoever reads the scene file puts it here ([`super::SceneDescription::read_files`]).
    #[serde(skip)]
    pub bytes: FileBytes,
}

/// The contents of a file; empty until it is read.
#[derive(Clone, Default, PartialEq)]
pub struct FileBytes(pub Arc<Vec<u8>>);

impl std::fmt::Debug for FileBytes {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} bytes", self.0.len())
    }
}

impl Scene {
    /// The particles that `[start]` names, and what becomes of their contacts.
    pub(super) fn read_start(&mut self, problems: &mut Problems) {
        let Some(start) = self.description().start.clone() else { return };
        let path = "start.checkpoint";
        if start.bytes.0.is_empty() {
            problems.add(path, format!("'{}' was not read, or is empty", start.checkpoint));
            return;
        }
        let bed = Bed::read(&start.bytes.0, self);
        let bed = bed.map_err(|problem| InvalidInput::new(path, format!("'{}' {problem}", start.checkpoint)));
        let Some(bed) = problems.keep(bed) else { return };
        problems.keep(self.check_sizes(bed.particles(), path));
        self.add_plan_line(bed.line(&start.checkpoint));
        self.bed = Some(Arc::new(bed));
    }
}
