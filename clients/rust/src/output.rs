//! What a stream of the daemon is to hold, and when.

use sturz_protocol::v1;
use sturz_protocol::v1::output_definition::Pace as Wire;

use crate::request::FloatType;

/// When a stream hands out frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// At every step whose number is a multiple of this.
    EverySteps(u64),
    /// At most one in so much wall time, at least 0.001 s.
    EveryWallS(f64),
    /// At the first step at or after every multiple of this simulated time, s.
    EverySimS(f64),
}

/// Definition of a stream, for all who subscribe to it; what is left out is as in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// `state`, `contacts`, `report` or `field/<name>`.
    pub stream: String,
    /// Names of columns; `all` for every one, none for those of the scene.
    pub columns: Vec<String>,
    /// Of floating-point columns.
    pub float_type: Option<FloatType>,
    /// When.
    pub pace: Option<Pace>,
}

impl Output {
    /// As in the scene.
    pub fn new(stream: impl Into<String>) -> Self {
        Self { stream: stream.into(), columns: Vec::new(), float_type: None, pace: None }
    }

    /// With these columns.
    pub fn with_columns<S: Into<String>>(mut self, columns: impl IntoIterator<Item = S>) -> Self {
        self.columns = columns.into_iter().map(Into::into).collect();
        self
    }

    /// With floats of this type.
    pub fn with_floats(self, float_type: FloatType) -> Self {
        Self { float_type: Some(float_type), ..self }
    }

    /// At this pace.
    pub fn at(self, pace: Pace) -> Self {
        Self { pace: Some(pace), ..self }
    }
}

impl From<Output> for v1::OutputDefinition {
    fn from(output: Output) -> Self {
        Self {
            stream: output.stream,
            columns: output.columns,
            float_type: output.float_type.map_or(0, |float_type| float_type.to_wire().into()),
            pace: output.pace.map(|pace| match pace {
                Pace::EverySteps(steps) => Wire::EverySteps(steps),
                Pace::EveryWallS(wall_s) => Wire::EveryWallS(wall_s),
                Pace::EverySimS(sim_s) => Wire::EverySimS(sim_s),
            }),
        }
    }
}
