//! Work of many steps that a client waits for: `step` and `advance` (co-simulation windows).

use sturz_protocol::convert::Start;
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::order::{Outputs, error};
use crate::ticket::{Moment, Ticket};

/// A step command or a window under way.
pub struct Window {
    /// Who waits.
    pub ticket: Ticket,
    /// What the reply carries; `None` for a step command.
    pub outputs: Option<Outputs>,
    /// The state that it began with.
    pub begun: Moment,
    /// Simulated time at its end.
    pub to_time_s: f64,
    /// Steps that it was cut into.
    pub steps_total: u64,
    /// Of these, done.
    pub steps_done: u64,
}

impl Window {
    /// Whether all steps are done.
    pub fn is_complete(&self) -> bool {
        self.steps_done >= self.steps_total
    }

    /// Whether the engine steps by a window's own time step, rather than by the nominal one.
    pub fn has_own_time_step(&self) -> bool {
        self.outputs.is_some()
    }

    /// For the reply, without data.
    pub fn result(&self, now: Moment, reason: v1::StopReason) -> Wire {
        let stop_reason = reason.into();
        if self.outputs.is_some() {
            Wire::Advanced(v1::Advanced {
                time_reached_s: now.time_s,
                step: now.step,
                steps_done: self.steps_done,
                window_steps: self.steps_total,
                stop_reason,
                frame: None,
                fields: Vec::new(),
                contacts: None,
                exchange: None,
            })
        } else {
            Wire::Stepped(v1::Stepped {
                steps_done: self.steps_done,
                step: now.step,
                time_reached_s: now.time_s,
                stop_reason,
            })
        }
    }

    /// For reports.
    pub fn progress(&self) -> v1::Progress {
        v1::Progress {
            from_time_s: self.begun.time_s,
            to_time_s: self.to_time_s,
            steps_done: self.steps_done,
            steps_total: self.steps_total,
        }
    }
}

/// Refuses a window that does not start where the engine is: the client lost or doubled one.
pub fn check_start(start: Start, now: Moment) -> Result<(), v1::Error> {
    match start {
        // Bits, not values: -0.0 is not the 0.0 that was echoed.
        Start::Time(time) if time.to_bits() != now.time_s.to_bits() => {
            let text = format!(
                "the window starts at {time:?} s, the engine is at {:?} s (step {}): echo the last time_reached_s",
                now.time_s, now.step
            );
            Err(error(v1::ErrorCode::WrongTime, "from_time_s", text))
        }
        Start::Step(step) if step != now.step => {
            let text =
                format!("the window starts after step {step}, the engine is at step {} ({:?} s)", now.step, now.time_s);
            Err(error(v1::ErrorCode::WrongTime, "from_step", text))
        }
        Start::Time(_) | Start::Step(_) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_starts_where_the_engine_is_to_the_last_bit() {
        let now = Moment { step: 3, time_s: 0.1 + 0.2 };
        assert!(check_start(Start::Time(0.1 + 0.2), now).is_ok());
        assert!(check_start(Start::Step(3), now).is_ok());
        let wrong = check_start(Start::Time(0.3), now).unwrap_err();
        assert_eq!((wrong.code(), wrong.path.as_str()), (v1::ErrorCode::WrongTime, "from_time_s"));
        assert!(wrong.message.contains("0.3 s") && wrong.message.contains("0.30000000000000004 s"));
        assert_eq!(check_start(Start::Step(2), now).unwrap_err().path, "from_step");
    }
}
