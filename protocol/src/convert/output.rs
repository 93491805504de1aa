//! Paces of streams to and from the wire.

use sturz_engine::InvalidInput;
use sturz_engine::scene::Pace;

use crate::v1::output_definition::Pace as Wire;

/// Of an output; an error says which of its fields cannot be used.
pub fn pace_from_wire(pace: &Wire) -> Result<Pace, InvalidInput> {
    let (path, pace, given) = match *pace {
        Wire::EverySteps(every) => ("output.every_steps", Pace::Steps { every }, every.to_string()),
        Wire::EveryWallS(every_s) => ("output.every_wall_s", Pace::Wall { every_s }, every_s.to_string()),
        Wire::EverySimS(every_s) => ("output.every_sim_s", Pace::Simulated { every_s }, every_s.to_string()),
    };
    pace.check().map(|()| pace).map_err(|problem| InvalidInput::new(path, format!("is {given}, {problem}")))
}

/// The same pace for the wire.
pub fn pace_to_wire(pace: Pace) -> Wire {
    match pace {
        Pace::Steps { every } => Wire::EverySteps(every),
        Pace::Wall { every_s } => Wire::EveryWallS(every_s),
        Pace::Simulated { every_s } => Wire::EverySimS(every_s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paces_come_back_and_bad_ones_are_named() {
        for pace in [Pace::Steps { every: 7 }, Pace::Wall { every_s: 0.5 }, Pace::Simulated { every_s: 1e-9 }] {
            assert_eq!(pace_from_wire(&pace_to_wire(pace)), Ok(pace));
        }
        for (bad, path) in [
            (Wire::EverySteps(0), "output.every_steps"),
            (Wire::EveryWallS(1e-4), "output.every_wall_s"),
            (Wire::EveryWallS(f64::NAN), "output.every_wall_s"),
            (Wire::EverySimS(0.0), "output.every_sim_s"),
            (Wire::EverySimS(f64::INFINITY), "output.every_sim_s"),
        ] {
            assert_eq!(pace_from_wire(&bad).unwrap_err().path, path);
        }
    }
}
