//! The particles as one side of a coupled run, in the verbs of preCICE.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use sturz_client::{FluidFields, Simulation, Start, Window};

use crate::border::{exclusive, optional, shared};
use crate::code::sturz_code;
use crate::exchange::sturz_exchange;
use crate::failure::{Failure, guard};
use crate::fluid::sturz_fluid_fields;
use crate::simulation::{connection, sturz_simulation};
use crate::window::{Outputs, march, sturz_advanced};

/// What rounding leaves of a window, relative to it, is no window.
const NO_WINDOW: f64 = 1e-9;

/// A participant of a coupled run. From `sturz_participant_initialize`, for `sturz_participant_finalize`.
pub struct sturz_participant {
    run: Mutex<Run>,
}

/// How a coupled run marches.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct sturz_coupling {
    /// Length of a window, above 0, s. The last one may be shorter.
    pub window_s: f64,
    /// Simulated time of the end, s. 0: without end.
    pub end_time_s: f64,
    /// 0: each window once (explicit). Above: a window is repeated until the fields of the fluid change from one iteration to
    /// the next by no more than this, relative to the last ones, for each of their columns (implicit).
    pub tolerance: f64,
    /// Of an implicit window, at least 2. 0 means 50.
    pub max_iterations: u32,
}

struct Run {
    simulation: Simulation,
    coupling: sturz_coupling,
    /// Of the checkpoint at the start of the window.
    token: String,
    start_s: f64,
    /// Of the window under way that are done.
    iterations: u32,
    /// Of the last iteration.
    fields: FluidFields,
    goes_back: bool,
    is_complete: bool,
}

impl Run {
    fn new(simulation: Simulation, coupling: sturz_coupling) -> Result<Self, Failure> {
        let bad = |name: &str, what: String| Err(Failure::argument(&format!("coupling.{name}"), &what));
        let sturz_coupling { window_s, end_time_s, tolerance, max_iterations } = coupling;
        if !(window_s > 0.0 && window_s.is_finite()) {
            return bad("window_s", format!("is {window_s}; must be finite and above 0"));
        }
        if end_time_s.is_nan() || end_time_s < 0.0 {
            return bad("end_time_s", format!("is {end_time_s}; must be at least 0"));
        }
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return bad("tolerance", format!("is {tolerance}; must be finite and at least 0"));
        }
        if max_iterations == 1 && tolerance > 0.0 {
            return bad("max_iterations", "is 1; two is the least that can show a change".into());
        }
        let end_time_s = if end_time_s == 0.0 { f64::INFINITY } else { end_time_s };
        let max_iterations = if max_iterations == 0 { 50 } else { max_iterations };
        Ok(Self {
            simulation,
            coupling: sturz_coupling { end_time_s, max_iterations, ..coupling },
            token: new_token(),
            start_s: 0.0,
            iterations: 0,
            fields: FluidFields::default(),
            goes_back: false,
            is_complete: false,
        })
    }

    fn is_implicit(&self) -> bool {
        self.coupling.tolerance > 0.0
    }

    fn is_ongoing(&self) -> bool {
        self.coupling.end_time_s - self.start_s > NO_WINDOW * self.coupling.window_s
    }

    fn window_s(&self) -> f64 {
        let left = self.coupling.end_time_s - self.start_s;
        if left < self.coupling.window_s * (1.0 + NO_WINDOW) { left } else { self.coupling.window_s }
    }

    fn requires_writing(&self) -> bool {
        self.is_implicit() && self.iterations == 0 && self.is_ongoing()
    }

    /// At the start of a window; only what is repeated needs it.
    fn begin_window(&mut self, start_s: f64) -> Result<(), Failure> {
        (self.start_s, self.iterations) = (start_s, 0);
        if self.requires_writing() {
            self.simulation.checkpoint(&self.token)?;
        }
        Ok(())
    }

    fn go_back(&mut self) -> Result<(), Failure> {
        if self.goes_back {
            self.simulation.restore(&self.token)?;
            self.goes_back = false;
        }
        Ok(())
    }

    /// # Safety
    /// The exchange is null or sound.
    unsafe fn advance(
        &mut self,
        fields: FluidFields,
        cells: u64,
        exchange: *mut sturz_exchange,
    ) -> Result<(), Failure> {
        if !self.is_ongoing() {
            let message = format!("the end, {} s, is reached", self.coupling.end_time_s);
            return Err(Failure::new(sturz_code::SturzInvalidArgument, message));
        }
        // SAFETY: the caller's word. Before the particles go back: a bad argument changes nothing.
        if let Some(exchange) = unsafe { optional("exchange", exchange) }? {
            exchange.check(Some(cells))?;
        }
        self.go_back()?;
        self.is_complete = false;
        let window = Window::new(self.window_s()).from(Start::Time(self.start_s)).with_fluid(fields.clone());
        let mut done = sturz_advanced::default();
        let outputs = Outputs { exchange, state: std::ptr::null_mut(), done: &mut done };
        // SAFETY: the caller's word.
        unsafe { march(&self.simulation, window, Some(cells), outputs) }?;
        let change = if self.iterations == 0 { f64::INFINITY } else { change(&self.fields, &fields) };
        self.fields = fields;
        self.iterations += 1;
        if !self.is_implicit() || change <= self.coupling.tolerance {
            self.is_complete = true;
            return self.begin_window(done.time_s);
        }
        self.goes_back = true;
        if self.iterations < self.coupling.max_iterations {
            return Ok(());
        }
        let (iterations, start_s, wanted) = (self.iterations, self.start_s, self.coupling.tolerance);
        self.go_back()?;
        self.iterations = 0;
        let message = format!(
            "the window from {start_s} s has not converged in {iterations} iterations: relative change {change:.3e}, wanted {wanted:.3e}; the particles are at its start: shorten the window, or relax the fields"
        );
        Err(Failure::new(sturz_code::SturzNotConverged, message))
    }

    fn finalize(&mut self) -> Result<(), Failure> {
        let dropped = match self.is_implicit() {
            true => self.forget(),
            false => Ok(()),
        };
        let released = self.simulation.release_lease();
        dropped?;
        released.map(drop).map_err(Failure::from)
    }

    fn forget(&self) -> Result<(), Failure> {
        if self.simulation.checkpoints()?.iter().any(|saved| saved.token == self.token) {
            self.simulation.drop_checkpoint(&self.token)?;
        }
        Ok(())
    }
}

/// Unlike those of other participants of the same daemon.
fn new_token() -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    format!("window-{}-{:x}-{}", std::process::id(), now.as_nanos(), COUNT.fetch_add(1, Relaxed))
}

/// The largest over the columns, as the norm of the difference over that of the newer one.
fn change(before: &FluidFields, after: &FluidFields) -> f64 {
    let columns = [
        (&before.velocity_m_per_s, &after.velocity_m_per_s),
        (&before.pressure_gradient_pa_per_m, &after.pressure_gradient_pa_per_m),
        (&before.acceleration_m_per_s2, &after.acceleration_m_per_s2),
        (&before.vorticity_rad_per_s, &after.vorticity_rad_per_s),
    ];
    columns.into_iter().map(|(before, after)| column_change(before, after)).fold(0.0, f64::max)
}

fn column_change(before: &[[f64; 3]], after: &[[f64; 3]]) -> f64 {
    if before.len() != after.len() {
        return f64::INFINITY;
    }
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let (before, after) = (before.as_flattened(), after.as_flattened());
    let difference = square(&mut before.iter().zip(after).map(|(a, b)| a - b)).sqrt();
    match square(&mut after.iter().copied()).sqrt() {
        size if size > 0.0 => difference / size,
        _ if difference > 0.0 => f64::INFINITY,
        _ => 0.0,
    }
}

/// # Safety
/// Null, or from `sturz_participant_initialize` and not finalized.
unsafe fn run<'a>(participant: *const sturz_participant) -> Result<MutexGuard<'a, Run>, Failure> {
    // SAFETY: the caller's word.
    let participant = unsafe { shared("participant", participant) }?;
    Ok(participant.run.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Answers a question of yes or no: 1, 0, or -1 where there is no participant.
///
/// # Safety
/// As for `run`.
unsafe fn ask(participant: *const sturz_participant, question: fn(&Run) -> bool) -> i32 {
    let mut answer = -1;
    guard(|| {
        // SAFETY: the caller's word.
        answer = i32::from(question(&*unsafe { run(participant) }?));
        Ok(())
    });
    answer
}

/// Takes the lease, fills `exchange` (may be null) with what the fluid gets at the start, and sets `*participant`, to null on
/// failure. The simulation must be paused and have a fluid with a mesh. The participant has the connection for itself: the
/// handle may be closed before it is finalized. Its calls from several threads wait for each other.
///
/// Each turn of the coupled run then is: the solver saves itself where `sturz_participant_requires_writing_checkpoint` says
/// so, goes to the end of a window of `sturz_participant_window_s`, and hands its fields to `sturz_participant_advance`; where
/// `sturz_participant_requires_reading_checkpoint` says so, it goes back to what it saved and does the window again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_initialize(
    simulation: *const sturz_simulation,
    coupling: *const sturz_coupling,
    exchange: *mut sturz_exchange,
    participant: *mut *mut sturz_participant,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        let (out, connection, coupling, exchange) = unsafe {
            let out = exclusive("participant", participant)?;
            *out = std::ptr::null_mut();
            let coupling = *shared("coupling", coupling)?;
            (out, connection(simulation)?, coupling, optional("exchange", exchange)?)
        };
        let mut run = Run::new(connection, coupling)?;
        if let Some(exchange) = &exchange {
            exchange.check(None)?;
        }
        let now = run.simulation.exchange()?;
        if let Some(exchange) = exchange {
            // SAFETY: the caller's word on the arrays.
            unsafe { exchange.fill(&now) }?;
        }
        run.simulation.acquire_lease()?;
        if let Err(failure) = run.begin_window(now.time_s()) {
            // What went wrong first is what is told.
            drop(run.simulation.release_lease());
            return Err(failure);
        }
        *out = Box::into_raw(Box::new(sturz_participant { run: Mutex::new(run) }));
        Ok(())
    })
}

/// Goes to the end of the window with the particles in these fields, and fills `exchange` (may be null) there.
/// `fields->ramp_s` says whether they hold from the start (0) or are those of the end (the window). After
/// `STURZ_NOT_CONVERGED` the particles are at the start of the window.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_advance(
    participant: *const sturz_participant,
    fields: *const sturz_fluid_fields,
    exchange: *mut sturz_exchange,
) -> sturz_code {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe {
            let fields = shared("fields", fields)?;
            run(participant)?.advance(fields.read()?, fields.count, exchange)
        }
    })
}

/// Whether there is a window to do: 1 or 0; -1 where `participant` is null, as for all questions.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_is_coupling_ongoing(participant: *const sturz_participant) -> i32 {
    // SAFETY: the caller's word.
    unsafe { ask(participant, Run::is_ongoing) }
}

/// Whether the last `sturz_participant_advance` has ended a window for good.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_is_time_window_complete(participant: *const sturz_participant) -> i32 {
    // SAFETY: the caller's word.
    unsafe { ask(participant, |run| run.is_complete) }
}

/// Whether the solver must save itself now: a window starts that may be repeated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_requires_writing_checkpoint(participant: *const sturz_participant) -> i32 {
    // SAFETY: the caller's word.
    unsafe { ask(participant, Run::requires_writing) }
}

/// Whether the solver must go back to the start of the window: it is repeated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_requires_reading_checkpoint(participant: *const sturz_participant) -> i32 {
    // SAFETY: the caller's word.
    unsafe { ask(participant, |run| run.goes_back) }
}

/// Length of the window under way, s: shorter at the end. -1 where `participant` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_window_s(participant: *const sturz_participant) -> f64 {
    let mut window_s = -1.0;
    guard(|| {
        // SAFETY: the caller's word.
        window_s = unsafe { run(participant) }?.window_s();
        Ok(())
    });
    window_s
}

/// Where the window under way starts, simulated time, s. -1 where `participant` is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_time_s(participant: *const sturz_participant) -> f64 {
    let mut start_s = -1.0;
    guard(|| {
        // SAFETY: the caller's word.
        start_s = unsafe { run(participant) }?.start_s;
        Ok(())
    });
    start_s
}

/// Gives the lease back and frees the participant, also where it fails; null is nothing to do. The particles stay where they
/// are. No other call may use the participant meanwhile or afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sturz_participant_finalize(participant: *mut sturz_participant) -> sturz_code {
    if participant.is_null() {
        return sturz_code::SturzOk;
    }
    guard(|| {
        // SAFETY: from `initialize`, and finalized once, by the caller's word.
        let participant = unsafe { Box::from_raw(participant) };
        participant.run.into_inner().unwrap_or_else(PoisonError::into_inner).finalize()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(velocity_m_per_s: Vec<[f64; 3]>) -> FluidFields {
        FluidFields { velocity_m_per_s, ..FluidFields::default() }
    }

    #[test]
    fn changes_are_relative_to_the_newer_fields() {
        let (one, two) = (fields(vec![[0.0, 3.0, 4.0]]), fields(vec![[0.0, 3.0, 4.5]]));
        assert_eq!(change(&one, &one), 0.0);
        assert_eq!(change(&two, &one), 0.1);
        assert_eq!(change(&one, &fields(vec![[0.0; 3]])), f64::INFINITY);
        assert_eq!(change(&one, &fields(Vec::new())), f64::INFINITY);
        let zero = fields(vec![[0.0; 3]]);
        assert_eq!(change(&zero, &zero), 0.0);
    }

    #[test]
    fn tokens_differ() {
        assert_ne!(new_token(), new_token());
    }
}
