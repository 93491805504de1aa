//! Advance by a window.

use sturz_client::v1::StopReason;
use sturz_client::{Advanced, Simulation, Stepped, Window};

use crate::border::{optional, shared};
use crate::code::sturz_code;
use crate::exchange::sturz_exchange;
use crate::failure::{Failure, guard};
use crate::fluid::sturz_fluid_fields;
use crate::loads::sturz_loads;
use crate::simulation::{connection, sturz_simulation};
use crate::state::sturz_state;

/// Why a window or steps ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum sturz_stop_reason {
    /// Of a daemon newer than this library.
    #[default]
    Unknown = 0,
    /// All steps are done.
    Complete = 1,
    /// Somebody paused.
    Paused = 2,
    /// The daemon ends.
    Stopped = 3,
    /// The holder of the lease was lost.
    LeaseLost = 4,
}

impl From<StopReason> for sturz_stop_reason {
    fn from(reason: StopReason) -> Self {
        match reason {
            StopReason::Unspecified => Self::Unknown,
            StopReason::Complete => Self::Complete,
            StopReason::Paused => Self::Paused,
            StopReason::Stopped => Self::Stopped,
            StopReason::LeaseLost => Self::LeaseLost,
        }
    }
}

/// What became of a window or of steps.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct sturz_advanced {
    /// Simulated time now, s.
    pub time_s: f64,
    /// Steps done by the state now.
    pub step: u64,
    /// Of this window.
    pub steps_done: u64,
    /// All done, or ended early.
    pub stop_reason: sturz_stop_reason,
}

impl From<&Advanced> for sturz_advanced {
    fn from(done: &Advanced) -> Self {
        let stop_reason = done.stop_reason.into();
        Self { time_s: done.time_reached_s, step: done.step, steps_done: done.steps_done, stop_reason }
    }
}

impl From<&Stepped> for sturz_advanced {
    fn from(done: &Stepped) -> Self {
        let stop_reason = done.stop_reason.into();
        Self { time_s: done.time_reached_s, step: done.step, steps_done: done.steps_done, stop_reason }
    }
}

impl sturz_advanced {
    fn check_complete(&self) -> Result<(), Failure> {
        if self.stop_reason == sturz_stop_reason::Complete {
            return Ok(());
        }
        let message =
            format!("ended early, at {} s after {} steps: {:?}", self.time_s, self.steps_done, self.stop_reason);
        Err(Failure::new(sturz_code::SturzEndedEarly, message))
    }
}

/// Where the answer to a window goes; each may be null.
#[derive(Clone, Copy)]
pub(crate) struct Outputs {
    pub(crate) exchange: *mut sturz_exchange,
    pub(crate) state: *mut sturz_state,
    pub(crate) done: *mut sturz_advanced,
}

/// Does a window and fills what was given; `cells` where their number is known before.
///
/// # Safety
/// As the head of the header has it.
pub(crate) unsafe fn march(
    connection: &Simulation,
    mut window: Window,
    cells: Option<u64>,
    outputs: Outputs,
) -> Result<(), Failure> {
    // SAFETY: the caller's word.
    let (exchange, state, done) = unsafe {
        (optional("exchange", outputs.exchange)?, optional("state", outputs.state)?, optional("done", outputs.done)?)
    };
    if let Some(exchange) = &exchange {
        exchange.check(cells)?;
    }
    if let Some(state) = &state {
        state.check()?;
        window = window.with_columns(state.columns());
    }
    window.exchange = exchange.is_some();
    let advanced = connection.advance(window)?;
    let became = sturz_advanced::from(&advanced);
    if let Some(done) = done {
        *done = became;
    }
    let missing = |what: &str| {
        Failure::new(sturz_code::SturzNotSent, format!("the window is done, and the daemon sent no {what}"))
    };
    // SAFETY: the caller's word on the arrays. Both are filled, whatever becomes of the other.
    let filled = unsafe {
        let exchange = exchange.map_or(Ok(()), |out| match &advanced.exchange {
            Some(exchange) => out.fill(exchange),
            None => Err(missing("exchange: there is no fluid with a mesh (any more)")),
        });
        let state = state.map_or(Ok(()), |out| match &advanced.state {
            Some(state) => out.fill(state),
            None => Err(missing("state")),
        });
        exchange.and(state)
    };
    became.check_complete().and(filled)
}

/// Advances by exactly one window of `window_s` seconds of simulated time: as many equal steps as it takes, none longer than
/// the nominal one. Fluid and loads of before go on. Fills `exchange`, `state` and `done` at its end; each may be null.
///
/// The simulation must be paused, and where this client knows it to be (`STURZ_REFUSED_WRONG_TIME` otherwise). After
/// `STURZ_TOO_SMALL` and `STURZ_NOT_SENT` the window is done, and `sturz_get_state` and `sturz_get_exchange` can be asked;
/// after `STURZ_ENDED_EARLY` what was asked for is that of the time in `done`. A refused window leaves the particles where they
/// were; after a lost connection `sturz_get_info` tells where they are.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_advance(
    simulation: *const sturz_simulation,
    window_s: f64,
    exchange: *mut sturz_exchange,
    state: *mut sturz_state,
    done: *mut sturz_advanced,
) -> sturz_code {
    // SAFETY: the caller's word.
    guard(|| unsafe { march(&connection(simulation)?, Window::new(window_s), None, Outputs { exchange, state, done }) })
}

/// The same in other fields of the fluid from its start on, instead of those before. Room for the exchange must be that for
/// `fields->count` rows. Where the fields are refused, so is the window.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_advance_with_fluid(
    simulation: *const sturz_simulation,
    window_s: f64,
    fields: *const sturz_fluid_fields,
    exchange: *mut sturz_exchange,
    state: *mut sturz_state,
    done: *mut sturz_advanced,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe {
            let fields = shared("fields", fields)?;
            let window = Window::new(window_s).with_fluid(fields.read()?);
            march(&connection(simulation)?, window, Some(fields.count), Outputs { exchange, state, done })
        }
    })
}

/// The same with other loads on single particles from its start on, instead of those before: for a solver that finds the
/// forces itself. Where they are refused, so is the window.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_advance_with_loads(
    simulation: *const sturz_simulation,
    window_s: f64,
    loads: *const sturz_loads,
    state: *mut sturz_state,
    done: *mut sturz_advanced,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe {
            let loads = shared("loads", loads)?.read()?;
            let outputs = Outputs { exchange: std::ptr::null_mut(), state, done };
            march(&connection(simulation)?, Window::new(window_s).with_loads(loads), None, outputs)
        }
    })
}

/// Does `steps` steps of the nominal time step; `done` may be null. The simulation must be paused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_step(
    simulation: *const sturz_simulation,
    steps: u64,
    done: *mut sturz_advanced,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (connection, done) = unsafe { (connection(simulation)?, optional("done", done)?) };
        let became = sturz_advanced::from(&connection.step(steps)?);
        if let Some(done) = done {
            *done = became;
        }
        became.check_complete()
    })
}
