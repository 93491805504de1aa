//! Particles into arrays of the caller.

use sturz_client::{FloatType, State};

use crate::border::{check_aligned, check_room, exclusive, put};
use crate::code::sturz_code;
use crate::failure::{Failure, guard};
use crate::simulation::{connection, sturz_simulation};

/// Particles at one moment: arrays of the caller with a row per particle, in ascending order of ids. Set `capacity` and the
/// arrays that are wanted; the others stay null. With all of them null the rest alone is set: to learn how much room is needed.
#[repr(C)]
#[derive(Debug)]
pub struct sturz_state {
    /// Rows that each of the arrays has room for.
    pub capacity: u64,
    /// (n): never used again for others.
    pub ids: *mut u64,
    /// (n, 3): centres of mass, wrapped into the periodic cell, m.
    pub positions_m: *mut f64,
    /// (n, 4): unit quaternions, world from body, as w, x, y, z.
    pub orientations_wxyz: *mut f64,
    /// (n, 3): of the centres of mass, m/s.
    pub velocities_m_per_s: *mut f64,
    /// (n, 3): world axes, rad/s.
    pub angular_velocities_rad_per_s: *mut f64,
    /// Set: n, the particles there are, also where the capacity is less.
    pub count: u64,
    /// Set: simulated time, s.
    pub time_s: f64,
    /// Set: steps done.
    pub step: u64,
    /// Set: of the ids, for `sturz_loads`.
    pub topology_epoch: u64,
}

impl sturz_state {
    /// Columns of the wire that have an array. Ids are always sent.
    pub(crate) fn columns(&self) -> Vec<&'static str> {
        let wanted = [
            ("ids", true),
            ("positions", !self.positions_m.is_null()),
            ("orientations", !self.orientations_wxyz.is_null()),
            ("velocities", !self.velocities_m_per_s.is_null()),
            ("angular_velocities", !self.angular_velocities_rad_per_s.is_null()),
        ];
        wanted.into_iter().filter_map(|(name, is_wanted)| is_wanted.then_some(name)).collect()
    }

    /// Before anything is asked for.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        check_aligned("state.ids", self.ids)?;
        check_aligned("state.positions_m", self.positions_m)?;
        check_aligned("state.orientations_wxyz", self.orientations_wxyz)?;
        check_aligned("state.velocities_m_per_s", self.velocities_m_per_s)?;
        check_aligned("state.angular_velocities_rad_per_s", self.angular_velocities_rad_per_s)
    }

    /// Sets the counts, and fills the arrays if they are large enough.
    ///
    /// # Safety
    /// Each array is null or has room for `capacity` rows.
    pub(crate) unsafe fn fill(&mut self, state: &State) -> Result<(), Failure> {
        self.count = state.len() as u64;
        (self.time_s, self.step, self.topology_epoch) = (state.time_s(), state.step(), state.topology_epoch());
        let columns = self.columns();
        if !self.ids.is_null() || columns.len() > 1 {
            check_room("state", self.capacity, self.count)?;
        }
        // All are read before one is written: what cannot be read leaves the arrays alone.
        let has = |name: &str| columns.contains(&name);
        let ids = state.ids()?;
        let positions = if has("positions") { state.positions_m()? } else { Vec::new() };
        let orientations = if has("orientations") { state.orientations_wxyz()? } else { Vec::new() };
        let velocities = if has("velocities") { state.velocities_m_per_s()? } else { Vec::new() };
        let spins = if has("angular_velocities") { state.angular_velocities_rad_per_s()? } else { Vec::new() };
        // SAFETY: no more rows than there is room for, as each column has `count` of them.
        unsafe {
            put(self.ids, &ids);
            put(self.positions_m, positions.as_flattened());
            put(self.orientations_wxyz, orientations.as_flattened());
            put(self.velocities_m_per_s, velocities.as_flattened());
            put(self.angular_velocities_rad_per_s, spins.as_flattened());
        }
        Ok(())
    }
}

/// The particles now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_get_state(simulation: *const sturz_simulation, state: *mut sturz_state) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, out) = unsafe { (connection(simulation)?, exclusive("state", state)?) };
        out.check()?;
        let state = connection.state(&out.columns(), FloatType::F64)?;
        // SAFETY: the caller's word on the arrays.
        unsafe { out.fill(&state) }
    })
}
