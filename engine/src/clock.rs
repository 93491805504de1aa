//! Time as (base time, base step, dt): never a running sum, so that 1e6 windows leave no drift.

use crate::checkpoint::codec::pack_fields;
use crate::error::InvalidInput;

/// Simulated time of the steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    base_time_s: f64,
    base_step: u64,
    step: u64,
    time_step_s: f64,
    nominal_time_step_s: f64,
    window: Option<Window>,
}

/// A stretch of time that is met exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Window {
    end_step: u64,
    end_time_s: f64,
}

pack_fields!(Clock {
    base_time_s: f64,
    base_step: u64,
    step: u64,
    time_step_s: f64,
    nominal_time_step_s: f64,
    window: Option<Window>,
});
pack_fields!(Window { end_step: u64, end_time_s: f64 });

/// Relative excess of window / step that still counts as a whole number of steps: rounding of the quotient.
const WHOLE_STEPS_TOLERANCE: f64 = 1e-9;

impl Clock {
    /// Step 0 at time 0.
    pub fn new(time_step_s: f64) -> Self {
        Self { base_time_s: 0.0, base_step: 0, step: 0, time_step_s, nominal_time_step_s: time_step_s, window: None }
    }

    /// Steps done.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Time after `step()` steps.
    pub fn time_s(&self) -> f64 {
        match self.window {
            Some(window) if self.step == window.end_step => window.end_time_s,
            _ => self.base_time_s + (self.step - self.base_step) as f64 * self.time_step_s,
        }
    }

    /// Time after `more` further steps.
    pub fn time_after_s(&self, more: u64) -> f64 {
        Self { step: self.step + more, ..*self }.time_s()
    }

    /// Step in use, at most the nominal one.
    pub fn time_step_s(&self) -> f64 {
        self.time_step_s
    }

    /// Step of the scene.
    pub fn nominal_time_step_s(&self) -> f64 {
        self.nominal_time_step_s
    }

    /// Whether a window has begun and not ended.
    pub fn is_in_window(&self) -> bool {
        self.window.is_some()
    }

    /// One step was done.
    pub(crate) fn advance(&mut self) {
        self.step += 1;
    }

    /// Cuts `duration_s` into equal steps not longer than the nominal one and returns their number.
    pub(crate) fn begin_window(&mut self, duration_s: f64) -> Result<u64, InvalidInput> {
        let steps = self.window_steps(duration_s)?;
        let start = self.time_s();
        self.rebase(start, duration_s / steps as f64);
        let end_step = self.step + steps;
        self.window = Some(Window { end_step, end_time_s: start + duration_s });
        Ok(steps)
    }

    /// Steps that a window of this length is cut into.
    pub(crate) fn window_steps(&self, duration_s: f64) -> Result<u64, InvalidInput> {
        if !(duration_s > 0.0 && duration_s.is_finite()) {
            return Err(InvalidInput::new("window_s", format!("is {duration_s}; must be finite and above 0")));
        }
        let quotient = duration_s / self.nominal_time_step_s;
        if quotient > 1e15 {
            return Err(InvalidInput::new(
                "window_s",
                format!("is {duration_s} s, more than 1e15 steps of {} s", self.nominal_time_step_s),
            ));
        }
        Ok((quotient * (1.0 - WHOLE_STEPS_TOLERANCE)).ceil().max(1.0) as u64)
    }

    /// Back to the nominal step, from the time reached.
    pub(crate) fn end_window(&mut self) {
        let now = self.time_s();
        self.rebase(now, self.nominal_time_step_s);
        self.window = None;
    }

    /// Whether an engine of this nominal step may have it.
    pub(crate) fn check(&self, nominal_time_step_s: f64) -> Result<(), InvalidInput> {
        let error = |problem: String| Err(InvalidInput::new("clock", problem));
        let Self { base_time_s, base_step, step, time_step_s, .. } = *self;
        if self.nominal_time_step_s != nominal_time_step_s {
            return error(format!(
                "has a time step of {} s, the scene {nominal_time_step_s} s",
                self.nominal_time_step_s
            ));
        }
        let in_use = time_step_s > 0.0 && time_step_s <= nominal_time_step_s * (1.0 + WHOLE_STEPS_TOLERANCE);
        let window = self.window.is_none_or(|window| window.end_step >= step && window.end_time_s.is_finite());
        if base_time_s.is_finite() && step >= base_step && step < u64::MAX / 2 && in_use && window {
            Ok(())
        } else {
            error(format!("is {self:?}"))
        }
    }

    fn rebase(&mut self, time_s: f64, time_step_s: f64) {
        self.base_time_s = time_s;
        self.base_step = self.step;
        self.time_step_s = time_step_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn window_end_is_met_exactly_and_leaves_no_drift() {
        let mut clock = Clock::new(0.3);
        let mut expected = 0.0;
        for _ in 0..1000 {
            let steps = clock.begin_window(0.7).unwrap();
            assert_eq!(steps, 3);
            (0..steps).for_each(|_| clock.advance());
            expected += 0.7;
            assert_eq!(clock.time_s().to_bits(), f64::to_bits(expected));
            clock.end_window();
        }
    }

    #[test]
    fn whole_number_of_steps_is_not_cut_further() {
        let mut clock = Clock::new(0.1);
        assert_eq!(clock.begin_window(0.3).unwrap(), 3);
    }

    #[test]
    fn bad_windows_are_refused() {
        let mut clock = Clock::new(0.1);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
            assert!(clock.begin_window(bad).is_err());
        }
        assert_eq!(clock, Clock::new(0.1));
    }
}
