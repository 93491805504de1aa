//! The wire of Sturz: messages of the protobuf package `sturz.v1`, the keys that they travel under, and (feature
//! `engine`) their conversion to and from the engine's own types.
//!
//! The schema is in `proto/sturz/v1`; [`v1`] is generated from it. This crate knows no bus.
//!
//! ```
//! use sturz_protocol::{Request, keys::{Keys, Verb}, v1};
//! use prost::Message;
//!
//! let keys = Keys::new("drum").unwrap();
//! assert_eq!(keys.command(Verb::SetGravity), "sturz/v1/drum/cmd/set_gravity");
//!
//! let down = v1::Vec3 { x: 0.0, y: 0.0, z: -9.81 };
//! let bytes = v1::SetGravityRequest { header: None, gravity_m_per_s2: Some(down) }.encode_to_vec();
//! assert!(matches!(Request::decode(Verb::SetGravity, bytes.as_slice()), Ok(Request::SetGravity(_))));
//! ```

#![deny(missing_docs)]

pub mod columns;
#[cfg(feature = "engine")]
pub mod convert;
pub mod keys;
mod request;

pub use request::Request;

/// Messages of the protobuf package `sturz.v1`; the documentation is that of `proto/sturz/v1`.
#[allow(missing_docs, clippy::all)]
pub mod v1 {
    include!(concat!(env!("OUT_DIR"), "/sturz.v1.rs"));
}

/// `Header.schema_version` of this package.
pub const SCHEMA_VERSION: u32 = 1;

/// Descriptor set of the schema that this crate was built from, without comments.
pub const DESCRIPTOR_SET: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/descriptor.binpb"));
