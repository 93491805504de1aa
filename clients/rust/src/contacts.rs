//! The contact network at one step, as arrays.

use sturz_protocol::columns::{self, ColumnError};
use sturz_protocol::v1;

use crate::error::ClientError;
use crate::state::read_named;

/// In [`Contacts::ids`], where side b is a boundary.
pub const NO_PARTICLE: u64 = u64::MAX;
/// In [`Contacts::boundaries`], where side b is a particle.
pub const NO_BOUNDARY: u32 = u32::MAX;

/// Who touches whom: a row per pair of convex parts, of particles a and b, a having the lower id, or of a particle and a
/// boundary; in ascending order of the ids.
///
/// On a acts `tangential_forces_n - normal_forces_n * normals`, and about its centre that force at `points_m` and
/// `moments_n_m`; on b the opposite of all. Columns that were not asked for are [`ClientError::ColumnMissing`].
#[derive(Clone, Debug, PartialEq)]
pub struct Contacts {
    frame: v1::ContactFrame,
}

impl Contacts {
    /// From the wire.
    pub(crate) fn new(frame: v1::ContactFrame) -> Self {
        Self { frame }
    }

    /// As it came.
    pub fn frame(&self) -> &v1::ContactFrame {
        &self.frame
    }

    /// Rows.
    pub fn len(&self) -> usize {
        self.frame.n as usize
    }

    /// Whether nothing touches.
    pub fn is_empty(&self) -> bool {
        self.frame.n == 0
    }

    /// Steps done.
    pub fn step(&self) -> u64 {
        self.frame.header.as_ref().map_or(0, |header| header.step)
    }

    /// Simulated time, s.
    pub fn time_s(&self) -> f64 {
        self.frame.header.as_ref().map_or(0.0, |header| header.sim_time_s)
    }

    /// Of a and b; [`NO_PARTICLE`] where that is a boundary. Always there.
    pub fn ids(&self) -> Result<Vec<[u64; 2]>, ClientError> {
        self.numbers("ids", columns::read)
    }

    /// Index into `Info.boundaries`; [`NO_BOUNDARY`] between particles. Always there.
    pub fn boundaries(&self) -> Result<Vec<u32>, ClientError> {
        self.numbers("boundaries", columns::read::<u32, 1>).map(Vec::into_flattened)
    }

    /// Convex parts of a and b; of a mesh the element.
    pub fn parts(&self) -> Result<Vec<[u32; 2]>, ClientError> {
        self.numbers("parts", columns::read)
    }

    /// Mean of the touching points, at the wrapped centre of a, m.
    pub fn points_m(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("points", columns::read_floats)
    }

    /// Unit vectors from a to b.
    pub fn normals(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("normals", columns::read_floats)
    }

    /// m; below 0 where cohesion holds parts that are apart.
    pub fn overlaps_m(&self) -> Result<Vec<f64>, ClientError> {
        self.numbers("overlaps", columns::read_floats::<1>).map(Vec::into_flattened)
    }

    /// N: positive where the parts are pushed apart.
    pub fn normal_forces_n(&self) -> Result<Vec<f64>, ClientError> {
        self.numbers("normal_forces", columns::read_floats::<1>).map(Vec::into_flattened)
    }

    /// On a, at right angles to the normal, N.
    pub fn tangential_forces_n(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("tangential_forces", columns::read_floats)
    }

    /// On a about the point, N m.
    pub fn moments_n_m(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("moments", columns::read_floats)
    }

    /// What touches; unspecified where the daemon knows more kinds than this client.
    pub fn kinds(&self) -> Result<Vec<v1::ContactKind>, ClientError> {
        let numbers = self.numbers("kinds", columns::read::<u32, 1>)?;
        let kind = |[number]: [u32; 1]| i32::try_from(number).ok().and_then(|n| v1::ContactKind::try_from(n).ok());
        Ok(numbers.into_iter().map(|number| kind(number).unwrap_or_default()).collect())
    }

    /// Touching points of each row.
    pub fn point_counts(&self) -> Result<Vec<u32>, ClientError> {
        self.numbers("point_counts", columns::read::<u32, 1>).map(Vec::into_flattened)
    }

    fn numbers<R>(
        &self,
        name: &str,
        read: impl Fn(&v1::Column) -> Result<Vec<R>, ColumnError>,
    ) -> Result<Vec<R>, ClientError> {
        let rows = read_named(&self.frame.columns, name, read)?;
        if rows.len() == self.len() {
            Ok(rows)
        } else {
            Err(ClientError::ColumnRows { name: name.into(), rows: rows.len(), needed: self.len() })
        }
    }
}
