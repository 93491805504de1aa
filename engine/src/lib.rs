//! Synchronous discrete element engine of Sturz: granular matter of non-spherical particles.
//!
//! No I/O, no async, no wall clock: scenes and commands come in as values, state goes out as values. Units are SI,
//! angles radians, orientations `world_from_body` unit quaternions. Results are the same, to the bit, on any number of
//! threads.
//!
//! | module | purpose |
//! |---|---|
//! | [`scene`] | what a user writes, and how it is proved usable |
//! | [`engine`], `relax`, `step`, `apply`, `view` | the owner of all state; before step 0; one step; commands; what may be read |
//! | [`shape`], [`narrow`] | shapes with their mass properties; where two of them touch |
//! | [`broad`], [`contact`] | which pairs may touch; persistent contacts and their laws |
//! | [`integrate`], [`boundary`], [`mesh`], [`insertion`] | motion of particles and walls; walls of triangles; new particles |
//! | [`mesh_file`] | OBJ and STL files, and the convex parts that they describe |
//! | [`hydrodynamics`] | forces and torques of a fluid on a particle |
//! | [`fields`] | coarse graining |
//! | [`snapshot`], [`contact_network`], [`columns`] | the state and who touches whom, copied; what their columns are called |
//! | [`guards`] | what there is to warn of |
//! | [`checkpoint`] | saving a run and going on from there, bitwise |
//!
//! ```
//! use sturz_engine::{Engine, scene::{Scene, SceneDescription}};
//!
//! let text = r#"
//!     [scene]
//!     name = "drop"
//!     gravity_m_per_s2 = [0.0, 0.0, -9.81]
//!     time_step_s = 1e-5
//!     [[material]]
//!     name = "glass"
//!     density_kg_per_m3 = 2500.0
//!     [[shape]]
//!     name = "bead"
//!     geometry = { kind = "sphere", radius_m = 1e-3 }
//!     [[insertion]]
//!     shape = "bead"
//!     material = "glass"
//!     placement = { method = "poses", positions_m = [[0.0, 0.0, 1.0]] }
//!     [[material_pair]]
//!     materials = ["glass", "glass"]
//!     stiffness_n_per_m = 1e4
//!     restitution = 0.8
//! "#;
//! let scene = Scene::validate(SceneDescription::from_toml(text)?)?;
//! let mut engine = Engine::new(scene);
//! for _ in 0..1000 {
//!     engine.step()?;
//! }
//! assert!((engine.clock().time_s() - 0.01).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(missing_docs)]

mod apply;
pub mod boundary;
pub mod broad;
pub mod cell;
pub mod checkpoint;
pub mod clock;
pub mod columns;
pub mod command;
pub mod contact;
pub mod contact_network;
pub mod coupling;
mod energy;
pub mod engine;
pub mod error;
mod external;
pub mod fields;
mod gather;
pub mod guards;
mod happening;
pub mod hydrodynamics;
mod inflow;
pub mod insertion;
pub mod integrate;
mod loads;
pub mod math;
pub mod mesh;
pub mod mesh_file;
pub mod narrow;
mod parallel;
pub mod particles;
mod random;
mod relax;
pub mod report;
pub mod scene;
mod servo;
pub mod shape;
pub mod snapshot;
mod stages;
mod step;
pub mod timing;
mod view;

pub use checkpoint::{CheckpointError, CheckpointSummary};
pub use clock::Clock;
pub use columns::{ContactColumn, FloatType, ParticleColumn};
pub use command::{Command, Effect};
pub use contact_network::{ContactKind, ContactNetwork, ContactRow};
pub use coupling::{Exchange, ExchangeTotals, FluidDescription, FluidFields, MeshDescription};
pub use engine::Engine;
pub use error::{InvalidInput, InvalidScene, StepError};
pub use guards::{Guard, GuardReading};
pub use happening::Happening;
pub use loads::LoadDescription;
pub use report::{EnergyBalance, Report, WarningCounts};
pub use snapshot::{BoundaryState, Snapshot};
pub use timing::{Stage, StageTimer};
