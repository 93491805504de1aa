//! The connection, what it is, the lease, checkpoints, pause and stop.

use std::ffi::c_char;
use std::sync::{PoisonError, RwLock};

use sturz_client::v1::{Info, RunState};
use sturz_client::{DEFAULT_ENDPOINT, Simulation, Target, Tls};

use crate::border::{exclusive, name, seconds, shared, text};
use crate::code::sturz_code;
use crate::failure::{Failure, guard};

/// A connected simulation. From `sturz_connect`, for `sturz_close`.
pub struct sturz_simulation {
    /// Another one after a reconnection.
    connection: RwLock<Simulation>,
}

impl sturz_simulation {
    /// The connection now; a call goes on with it whatever the others do.
    pub(crate) fn connection(&self) -> Simulation {
        self.connection.read().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// The connection behind a handle.
///
/// # Safety
/// Null, or from `sturz_connect` and not closed.
pub(crate) unsafe fn connection(simulation: *const sturz_simulation) -> Result<Simulation, Failure> {
    // SAFETY: the caller's word.
    unsafe { shared("simulation", simulation) }.map(sturz_simulation::connection)
}

/// What a simulation does.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum sturz_run_state {
    /// Of a daemon newer than this library.
    Unknown = 0,
    /// Steps freely.
    Running = 1,
    /// Waits for commands.
    Paused = 2,
    /// Inside a window.
    Advancing = 3,
    /// A step was refused: it can be read and restored, not advanced.
    Failed = 4,
    /// The daemon is going.
    Ended = 5,
}

/// Where a simulation stands.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct sturz_info {
    /// Simulated time, s.
    pub time_s: f64,
    /// Nominal time step, s.
    pub time_step_s: f64,
    /// Acceleration of gravity, m/s2.
    pub gravity_m_per_s2: [f64; 3],
    /// Steps done.
    pub step: u64,
    /// Particles present.
    pub particles: u64,
    /// Counts insertions and removals: ids asked for in one epoch are those of the particles while it lasts.
    pub topology_epoch: u64,
    /// Of the whole state: equal where two runs are equal to the bit.
    pub state_hash: u64,
    /// What it does.
    pub state: sturz_run_state,
}

impl From<Info> for sturz_info {
    fn from(info: Info) -> Self {
        let state = match info.state() {
            RunState::Unspecified => sturz_run_state::Unknown,
            RunState::Running => sturz_run_state::Running,
            RunState::Paused => sturz_run_state::Paused,
            RunState::Advancing => sturz_run_state::Advancing,
            RunState::Failed => sturz_run_state::Failed,
            RunState::Ended => sturz_run_state::Ended,
        };
        let gravity = info.gravity_m_per_s2.unwrap_or_default();
        Self {
            time_s: info.sim_time_s,
            time_step_s: info.time_step_s,
            gravity_m_per_s2: [gravity.x, gravity.y, gravity.z],
            step: info.step,
            particles: info.particles,
            topology_epoch: info.topology_epoch,
            state_hash: info.state_hash,
            state,
        }
    }
}

/// Version of this library, such as "0.1.0". Lives as long as the program.
#[unsafe(no_mangle)]
pub extern "C" fn sturz_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Connects to the daemon that serves the simulation `name` at `endpoint`, such as "tcp/127.0.0.1:7447"
/// (`STURZ_DEFAULT_ENDPOINT`; null means the same), within `timeout_s` seconds. Sets `*simulation`, to null on failure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_connect(
    name: *const c_char,
    endpoint: *const c_char,
    timeout_s: f64,
    simulation: *mut *mut sturz_simulation,
) -> sturz_code {
    // SAFETY: the caller's word.
    guard(|| unsafe { connect(name, endpoint, None, timeout_s, simulation) })
}

/// The same for a daemon that wants a certificate, such as at "tls/host:7447": `folder` is that of one client as
/// `sturz certs` makes it, with ca.pem, certificate.pem and key.pem.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_connect_tls(
    name: *const c_char,
    endpoint: *const c_char,
    folder: *const c_char,
    timeout_s: f64,
    simulation: *mut *mut sturz_simulation,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { connect(name, endpoint, Some(self::name("folder", folder)?), timeout_s, simulation) }
    })
}

/// # Safety
/// As the head of the header has it.
unsafe fn connect(
    name: *const c_char,
    endpoint: *const c_char,
    folder: Option<&str>,
    timeout_s: f64,
    out: *mut *mut sturz_simulation,
) -> Result<(), Failure> {
    // SAFETY: the caller's word.
    let (out, name, endpoint) = unsafe {
        let out = exclusive("simulation", out)?;
        *out = std::ptr::null_mut();
        let endpoint = if endpoint.is_null() { DEFAULT_ENDPOINT } else { text("endpoint", endpoint)? };
        (out, text("name", name)?, endpoint)
    };
    let timeout = seconds("timeout_s", timeout_s)?;
    let target = match folder {
        None => Target::new(endpoint),
        Some(folder) => Target::new(endpoint).with_tls(Tls::from_folder(folder)?),
    };
    let connection = RwLock::new(Simulation::connect_to(name, &target, timeout)?);
    *out = Box::into_raw(Box::new(sturz_simulation { connection }));
    Ok(())
}

/// Connects anew after `STURZ_GONE`, as the same client, within `timeout_s` seconds. The lease must be acquired again.
/// The daemon may be another one: compare `sturz_get_info` with what was known. Until it succeeds the handle stays as it is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_reconnect(simulation: *mut sturz_simulation, timeout_s: f64) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let handle = unsafe { shared("simulation", simulation) }?;
        let connection = handle.connection().reconnect(seconds("timeout_s", timeout_s)?)?;
        *handle.connection.write().unwrap_or_else(PoisonError::into_inner) = connection;
        Ok(())
    })
}

/// Ends the connection and frees the handle; null is nothing to do. The daemon goes on living, and is paused if this client
/// had the lease. No other call may use the handle meanwhile or afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_close(simulation: *mut sturz_simulation) {
    if simulation.is_null() {
        return;
    }
    guard(|| {
        // SAFETY: from `connect`, and closed once, by the caller's word.
        drop(unsafe { Box::from_raw(simulation) });
        Ok(())
    });
}

/// Where the simulation stands. The next window starts there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_get_info(simulation: *const sturz_simulation, info: *mut sturz_info) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, out) = unsafe { (connection(simulation)?, exclusive("info", info)?) };
        *out = connection.info()?.into();
        Ok(())
    })
}

/// Makes this client the only one that may advance, step, resume, restore, set loads and set the fluid, until
/// `sturz_release_lease` or `sturz_close`. When its connection is lost the run is paused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_acquire_lease(simulation: *const sturz_simulation) -> sturz_code {
    // SAFETY: the caller's word.
    guard(|| unsafe { connection(simulation) }?.acquire_lease().map(drop).map_err(Failure::from))
}

/// Lets others advance again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_release_lease(simulation: *const sturz_simulation) -> sturz_code {
    // SAFETY: the caller's word.
    guard(|| unsafe { connection(simulation) }?.release_lease().map(drop).map_err(Failure::from))
}

/// Sets the acceleration of gravity, m/s2, three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_set_gravity(
    simulation: *const sturz_simulation,
    gravity_m_per_s2: *const f64,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, gravity) =
            unsafe { (connection(simulation)?, shared("gravity_m_per_s2", gravity_m_per_s2.cast::<[f64; 3]>())?) };
        connection.set_gravity(*gravity).map(drop).map_err(Failure::from)
    })
}

/// Stops stepping. A window of another thread or client ends early by it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_pause(simulation: *const sturz_simulation) -> sturz_code {
    // SAFETY: the caller's word.
    guard(|| unsafe { connection(simulation) }?.pause().map(drop).map_err(Failure::from))
}

/// Lets the simulation step freely, until `sturz_pause`. Windows and steps are refused meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_resume(simulation: *const sturz_simulation) -> sturz_code {
    // SAFETY: the caller's word.
    guard(|| unsafe { connection(simulation) }?.resume().map(drop).map_err(Failure::from))
}

/// Ends the daemon, and waits until it is gone. The handle must still be closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_stop(simulation: *const sturz_simulation) -> sturz_code {
    // SAFETY: the caller's word.
    guard(|| unsafe { connection(simulation) }?.stop().map_err(Failure::from))
}

/// Saves the whole state under a name, in the daemon's memory or, where `on_disk` is not 0, as a file that outlives it (the
/// daemon must have a folder for them: `--checkpoints`). One of that name is replaced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_checkpoint(
    simulation: *const sturz_simulation,
    token: *const c_char,
    on_disk: i32,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, token) = unsafe { (connection(simulation)?, name("token", token)?) };
        let saved = if on_disk == 0 { connection.checkpoint(token) } else { connection.checkpoint_on_disk(token) };
        saved.map(drop).map_err(Failure::from)
    })
}

/// Goes to a saved state, bit for bit; a run that has failed is paused by it. The next window starts there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_restore(simulation: *const sturz_simulation, token: *const c_char) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, token) = unsafe { (connection(simulation)?, name("token", token)?) };
        connection.restore(token).map(drop).map_err(Failure::from)
    })
}

/// Forgets a saved state, its file included.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_drop_checkpoint(
    simulation: *const sturz_simulation,
    token: *const c_char,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, token) = unsafe { (connection(simulation)?, name("token", token)?) };
        connection.drop_checkpoint(token).map(drop).map_err(Failure::from)
    })
}
