//! VTK files of recordings, of running daemons and of runs: particles with their true shapes, contacts, fields, boundaries.
//!
//! All sources are read as messages of the wire ([`Exporter`]), so an exported state is the published one.

mod boundaries;
mod contacts;
mod exporter;
mod fields;
mod geometry;
mod particles;
mod series;
mod sources;
mod table;
mod vtk;

pub use exporter::{Choice, ExportError, Exporter, Options, Written};
pub use sources::{SceneRun, export_daemon, export_recording, export_scene};
pub use vtk::Precision;
