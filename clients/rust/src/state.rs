//! Particles at one step, as arrays.

use sturz_protocol::columns::{self, ColumnError};
use sturz_protocol::v1;

use crate::error::ClientError;

/// The particles at one step, in ascending order of id: row i of every array belongs to `ids()[i]`.
///
/// Columns that were not asked for are [`ClientError::ColumnMissing`]. Floats that were asked for as f32 come as f64.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    frame: v1::Frame,
}

impl State {
    /// From the wire.
    pub(crate) fn new(frame: v1::Frame) -> Self {
        Self { frame }
    }

    /// As it came.
    pub fn frame(&self) -> &v1::Frame {
        &self.frame
    }

    /// Particles.
    pub fn len(&self) -> usize {
        self.frame.n as usize
    }

    /// Whether there are no particles.
    pub fn is_empty(&self) -> bool {
        self.frame.n == 0
    }

    /// Steps done.
    pub fn step(&self) -> u64 {
        self.frame.header.as_ref().map_or(0, |header| header.step)
    }

    /// Counts insertions and removals: what [`crate::Loads`] are refused by when it has changed.
    pub fn topology_epoch(&self) -> u64 {
        self.frame.header.as_ref().map_or(0, |header| header.topology_epoch)
    }

    /// Simulated time, s.
    pub fn time_s(&self) -> f64 {
        self.frame.header.as_ref().map_or(0.0, |header| header.sim_time_s)
    }

    /// Boundaries in the order of the scene: where they are, and what acts on them.
    pub fn boundaries(&self) -> &[v1::BoundaryState] {
        &self.frame.boundaries
    }

    /// Ids, ascending. Always there.
    pub fn ids(&self) -> Result<Vec<u64>, ClientError> {
        self.numbers("ids", columns::read::<u64, 1>).map(Vec::into_flattened)
    }

    /// Index into `Info.shapes`.
    pub fn shapes(&self) -> Result<Vec<u32>, ClientError> {
        self.numbers("shapes", columns::read::<u32, 1>).map(Vec::into_flattened)
    }

    /// Index into `Info.materials`.
    pub fn materials(&self) -> Result<Vec<u32>, ClientError> {
        self.numbers("materials", columns::read::<u32, 1>).map(Vec::into_flattened)
    }

    /// Sizes relative to the shape.
    pub fn scales(&self) -> Result<Vec<f64>, ClientError> {
        self.numbers("scales", columns::read_floats::<1>).map(Vec::into_flattened)
    }

    /// Centres of mass, wrapped into the periodic cell, m.
    pub fn positions_m(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("positions", columns::read_floats)
    }

    /// Unit quaternions `world_from_body` (w, x, y, z).
    pub fn orientations_wxyz(&self) -> Result<Vec<[f64; 4]>, ClientError> {
        self.numbers("orientations", columns::read_floats)
    }

    /// Of the centres of mass, m/s.
    pub fn velocities_m_per_s(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("velocities", columns::read_floats)
    }

    /// In world axes, rad/s.
    pub fn angular_velocities_rad_per_s(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("angular_velocities", columns::read_floats)
    }

    /// Sum over the contacts as they acted in the last step, N: without gravity and loads.
    pub fn forces_n(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("forces", columns::read_floats)
    }

    /// Of the contacts about the centre of mass, world axes, N m.
    pub fn torques_n_m(&self) -> Result<Vec<[f64; 3]>, ClientError> {
        self.numbers("torques", columns::read_floats)
    }

    /// One row per particle of the column of this name.
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

/// Rows of the column of this name.
pub(crate) fn read_named<R>(
    columns: &[v1::Column],
    name: &str,
    read: impl Fn(&v1::Column) -> Result<Vec<R>, ColumnError>,
) -> Result<Vec<R>, ClientError> {
    let column = columns.iter().find(|column| column.name == name).ok_or_else(|| ClientError::ColumnMissing {
        name: name.into(),
        there: columns.iter().map(|column| column.name.clone()).collect(),
    })?;
    read(column).map_err(|error| ClientError::Column { name: name.into(), error })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> State {
        let columns = vec![
            columns::flat("ids", "", 1, &[3_u64, 8]),
            columns::rows("positions", "m", &[[0.5_f32, 1.0, 2.0], [3.0, 4.0, 5.0]]),
            columns::rows("velocities", "m/s", &[[1.0_f64, 2.0, 3.0]]),
            columns::flat("scales", "", 2, &[1.0_f64, 2.0, 3.0, 4.0]),
        ];
        let header = Some(v1::Header { step: 9, sim_time_s: 0.25, ..Default::default() });
        State::new(v1::Frame { header, n: 2, columns, ..Default::default() })
    }

    #[test]
    fn columns_become_arrays() {
        let state = state();
        assert_eq!((state.len(), state.step(), state.time_s()), (2, 9, 0.25));
        assert_eq!(state.ids().unwrap(), [3, 8]);
        assert_eq!(state.positions_m().unwrap(), [[0.5, 1.0, 2.0], [3.0, 4.0, 5.0]]);
    }

    #[test]
    fn columns_that_are_not_as_they_should_be_are_named() {
        let state = state();
        let texts = [
            (state.orientations_wxyz().unwrap_err(), "no column \"orientations\" was asked for; there are [\"ids\""),
            (state.velocities_m_per_s().unwrap_err(), "column \"velocities\" has 1 rows instead of 2"),
            (state.scales().unwrap_err(), "column \"scales\" has 2 components per row, needs 1"),
        ];
        for (error, text) in texts {
            assert!(error.to_string().starts_with(text), "{error}");
        }
    }
}
