//! When the next message is due, and who may hold it up.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What is shown is repeated after this time while nothing moves, for those who come late.
const REPEAT: Duration = Duration::from_secs(1);
/// Longest wait between two messages: a speed of almost nothing must not overflow the clock.
const LONGEST: Duration = Duration::from_secs(1 << 30);

/// Simulated seconds per wall second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// As fast as listeners take it: nothing is dropped on the way to them.
    Max,
    /// Positive and finite.
    Times(f64),
}

impl Speed {
    /// From `max` or a positive number.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text.parse::<f64>() {
            _ if text == "max" => Ok(Self::Max),
            Ok(times) if times.is_finite() && times > 0.0 => Ok(Self::Times(times)),
            _ => Err(format!("--speed is {text:?}: a positive number or `max` is possible")),
        }
    }
}

/// Simulated time against the wall clock.
#[derive(Clone, Debug)]
pub struct Pace {
    speed: Speed,
    anchor: Option<(Instant, f64)>,
    last_s: f64,
}

impl Pace {
    /// Begins with the first message.
    pub fn new(speed: Speed) -> Self {
        Self { speed, anchor: None, last_s: f64::NEG_INFINITY }
    }

    /// Begins anew with the next message, as after a pause.
    pub fn restart(&mut self) {
        self.anchor = None;
    }

    /// When a message of this simulated time is due. Time that goes back, as after a restore, begins anew.
    pub fn due(&mut self, time_s: f64, now: Instant) -> Instant {
        let Speed::Times(speed) = self.speed else { return now };
        if time_s < self.last_s {
            self.anchor = None;
        }
        self.last_s = time_s;
        let (begin, begin_s) = *self.anchor.get_or_insert((now, time_s));
        begin + Duration::try_from_secs_f64((time_s - begin_s) / speed).unwrap_or(LONGEST).min(LONGEST)
    }
}

/// What the playback does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Goes on.
    Playing,
    /// Waits for `resume`.
    Paused,
    /// Is to end.
    Stopping,
}

/// Shared by the player and those who command it.
#[derive(Debug)]
pub struct Control {
    mode: Mutex<Mode>,
    changed: Condvar,
}

impl Control {
    /// Playing or paused.
    pub fn new(paused: bool) -> Self {
        Self { mode: Mutex::new(if paused { Mode::Paused } else { Mode::Playing }), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Mode> {
        self.mode.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What it does.
    pub fn mode(&self) -> Mode {
        *self.lock()
    }

    /// Makes it do that; what is to end goes on ending.
    pub fn set(&self, mode: Mode) {
        let mut present = self.lock();
        if *present != Mode::Stopping {
            *present = mode;
        }
        drop(present);
        self.changed.notify_all();
    }

    /// Waits until a message of this simulated time is due and nothing is paused, and calls `repeat` now and then while it
    /// is; `false` when the playback is to end.
    pub fn wait(&self, pace: &mut Pace, time_s: f64, mut repeat: impl FnMut()) -> bool {
        let mut mode = self.lock();
        loop {
            match *mode {
                Mode::Stopping => return false,
                Mode::Paused => {
                    pace.restart();
                    let (locked, timeout) = self.wait_on(mode, REPEAT);
                    mode = locked;
                    if timeout {
                        drop(mode);
                        repeat();
                        mode = self.lock();
                    }
                }
                Mode::Playing => {
                    let now = Instant::now();
                    let due = pace.due(time_s, now);
                    if due <= now {
                        return true;
                    }
                    mode = self.wait_on(mode, due - now).0;
                }
            }
        }
    }

    fn wait_on<'a>(&self, mode: MutexGuard<'a, Mode>, patience: Duration) -> (MutexGuard<'a, Mode>, bool) {
        let (mode, timeout) = self.changed.wait_timeout(mode, patience).unwrap_or_else(PoisonError::into_inner);
        (mode, timeout.timed_out())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_due_at_simulated_time_over_speed() {
        let mut pace = Pace::new(Speed::Times(0.5));
        let start = Instant::now();
        let due = |pace: &mut Pace, time_s| (pace.due(time_s, start) - start).as_secs_f64();
        assert_eq!(due(&mut pace, 3.0), 0.0, "the first one at once");
        assert_eq!(due(&mut pace, 3.25), 0.5);
        assert_eq!(due(&mut pace, 4.0), 2.0);
        assert_eq!(due(&mut pace, 1.0), 0.0, "a restore");
        assert_eq!(due(&mut pace, 1.5), 1.0);
        pace.restart();
        assert_eq!(due(&mut pace, 9.0), 0.0, "a pause");
        assert_eq!(due(&mut pace, f64::MAX), LONGEST.as_secs_f64());
        let mut pace = Pace::new(Speed::Max);
        assert_eq!(due(&mut pace, 1.0), 0.0);
        assert_eq!(due(&mut pace, 100.0), 0.0);
    }

    #[test]
    fn a_speed_is_a_positive_number_or_max() {
        assert_eq!(Speed::parse("max"), Ok(Speed::Max));
        assert_eq!(Speed::parse("0.1"), Ok(Speed::Times(0.1)));
        for text in ["0", "-1", "inf", "NaN", "fast", ""] {
            assert!(Speed::parse(text).unwrap_err().contains(text), "{text}");
        }
    }

    #[test]
    fn the_end_wins_over_pause_and_resume() {
        let control = Control::new(true);
        control.set(Mode::Stopping);
        control.set(Mode::Playing);
        assert_eq!(control.mode(), Mode::Stopping);
        assert!(!control.wait(&mut Pace::new(Speed::Max), 0.0, || ()));
    }

    #[test]
    fn a_paused_playback_goes_on_when_told() {
        let control = Control::new(true);
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| control.wait(&mut Pace::new(Speed::Max), 0.0, || ()));
            control.set(Mode::Playing);
            assert!(waiting.join().unwrap());
        });
    }
}
