//! What the fluid gets from the particles, into arrays of the caller.

use sturz_client::{Exchange, v1};

use crate::border::{check_aligned, check_room, exclusive, put};
use crate::code::sturz_code;
use crate::failure::{Failure, guard};
use crate::simulation::{connection, sturz_simulation};

/// What the fluid gets from the particles: arrays of the caller with a row per cell or point of its mesh, and totals. Set
/// `capacity` and the arrays that are wanted; the others stay null. Forces are means from `from_time_s` to `time_s`.
#[repr(C)]
#[derive(Debug)]
pub struct sturz_exchange {
    /// Rows that each of the arrays has room for.
    pub capacity: u64,
    /// (n): 1 less the part of the cell that particles fill, at the end.
    pub void_fraction: *mut f64,
    /// (n, 3): mean over the solid in the cell, at the end, m/s; 0 where there is none.
    pub solid_velocity_m_per_s: *mut f64,
    /// (n, 3): force on the fluid by drag, lift and added mass over the volume of the cell, N/m3.
    pub interaction_n_per_m3: *mut f64,
    /// (n, 3): force on the particles by the given pressure gradient, likewise, N/m3.
    pub pressure_force_n_per_m3: *mut f64,
    /// (n): by how much the interaction opposes a change of the fluid's velocity, kg/(m3 s).
    pub drag_kg_per_m3_s: *mut f64,
    /// Set: n, cells or points of the mesh, also where the capacity is less.
    pub cells: u64,
    /// Set: since when forces are counted, the start of the window, s.
    pub from_time_s: f64,
    /// Set: simulated time, s.
    pub time_s: f64,
    /// Set: volume of all particles, m3.
    pub solid_volume_m3: f64,
    /// Set: of it, in the mesh.
    pub immersed_volume_m3: f64,
    /// Set: particles that are wholly outside of the mesh.
    pub outside: u64,
    /// Set: looks at where the particles are in the mesh, since the fluid was defined.
    pub refreshes: u64,
    /// Set: on the fluid by drag, lift and added mass, N s.
    pub impulse_on_fluid_n_s: [f64; 3],
    /// Set: on the particles by the given pressure gradient, N s.
    pub pressure_impulse_n_s: [f64; 3],
    /// Set: on the particles by buoyancy, N s.
    pub buoyancy_impulse_n_s: [f64; 3],
    /// Set: of the particles that move freely, at the end, kg m/s.
    pub momentum_kg_m_per_s: [f64; 3],
}

impl sturz_exchange {
    fn wants_rows(&self) -> bool {
        let vectors = [self.solid_velocity_m_per_s, self.interaction_n_per_m3, self.pressure_force_n_per_m3];
        let numbers = [self.void_fraction, self.drag_kg_per_m3_s];
        vectors.into_iter().chain(numbers).any(|array| !array.is_null())
    }

    /// Before anything is asked for; `cells` where they are known by then.
    pub(crate) fn check(&self, cells: Option<u64>) -> Result<(), Failure> {
        check_aligned("exchange.void_fraction", self.void_fraction)?;
        check_aligned("exchange.solid_velocity_m_per_s", self.solid_velocity_m_per_s)?;
        check_aligned("exchange.interaction_n_per_m3", self.interaction_n_per_m3)?;
        check_aligned("exchange.pressure_force_n_per_m3", self.pressure_force_n_per_m3)?;
        check_aligned("exchange.drag_kg_per_m3_s", self.drag_kg_per_m3_s)?;
        match cells {
            Some(cells) if self.wants_rows() && cells > self.capacity => Err(Failure::argument(
                "exchange.capacity",
                &format!("is {}, and the fields have {cells} rows: nothing was done", self.capacity),
            )),
            _ => Ok(()),
        }
    }

    /// Sets the totals, and fills the arrays if they are large enough.
    ///
    /// # Safety
    /// Each array is null or has room for `capacity` rows.
    pub(crate) unsafe fn fill(&mut self, exchange: &Exchange) -> Result<(), Failure> {
        let frame = exchange.frame();
        let void_fraction = exchange.void_fraction()?;
        let solid_velocity = exchange.solid_velocity_m_per_s()?;
        let interaction = exchange.interaction_n_per_m3()?;
        let pressure_force = exchange.pressure_force_n_per_m3()?;
        let drag = exchange.drag_kg_per_m3_s()?;
        let rows = [void_fraction.len(), solid_velocity.len(), interaction.len(), pressure_force.len(), drag.len()];
        if rows.iter().any(|&rows| rows != void_fraction.len()) {
            let message = format!("the columns of the exchange have {rows:?} rows, and should have equally many");
            return Err(Failure::new(sturz_code::SturzUnreadable, message));
        }
        self.cells = void_fraction.len() as u64;
        (self.from_time_s, self.time_s) = (exchange.from_time_s(), exchange.time_s());
        (self.solid_volume_m3, self.immersed_volume_m3) = (frame.solid_volume_m3, frame.immersed_volume_m3);
        (self.outside, self.refreshes) = (frame.outside, frame.refreshes);
        self.impulse_on_fluid_n_s = vector(frame.impulse_on_fluid_n_s);
        self.pressure_impulse_n_s = vector(frame.pressure_impulse_n_s);
        self.buoyancy_impulse_n_s = vector(frame.buoyancy_impulse_n_s);
        self.momentum_kg_m_per_s = vector(frame.momentum_kg_m_per_s);
        if self.wants_rows() {
            check_room("exchange", self.capacity, self.cells)?;
        }
        // SAFETY: no more rows than there is room for, as each column has `cells` of them.
        unsafe {
            put(self.void_fraction, &void_fraction);
            put(self.solid_velocity_m_per_s, solid_velocity.as_flattened());
            put(self.interaction_n_per_m3, interaction.as_flattened());
            put(self.pressure_force_n_per_m3, pressure_force.as_flattened());
            put(self.drag_kg_per_m3_s, &drag);
        }
        Ok(())
    }
}

fn vector(vector: Option<v1::Vec3>) -> [f64; 3] {
    vector.map_or([0.0; 3], |v1::Vec3 { x, y, z }| [x, y, z])
}

/// What the fluid gets from the particles, now; refused where there is no fluid with a mesh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_get_exchange(
    simulation: *const sturz_simulation,
    exchange: *mut sturz_exchange,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, out) = unsafe { (connection(simulation)?, exclusive("exchange", exchange)?) };
        out.check(None)?;
        let exchange = connection.exchange()?;
        // SAFETY: the caller's word on the arrays.
        unsafe { out.fill(&exchange) }
    })
}
