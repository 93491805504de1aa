//! `[output]`: what the daemon's streams hold, and how often.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::validate::Problems;
use crate::columns::{ContactColumn, FloatType, ParticleColumn};

/// `[output]`: defaults of the daemon's streams. Commands (`define_output`) may change them.
///
/// A stream has a pace: so many frames per wall second, or, instead, one every so many steps, or one at the first step at
/// or after every multiple of a simulated time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputSection {
    /// Most state frames per wall second.
    pub state_rate_hz: f64,
    /// Instead: steps between state frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state_every_steps: Option<u64>,
    /// Instead: simulated time between state frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state_every_sim_s: Option<f64>,
    /// Of state frames; all but forces and torques when absent. `ids` is always there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state_columns: Option<Vec<ParticleColumn>>,
    /// Of the floating-point columns of state frames.
    pub state_float_type: FloatType,
    /// Most frames of the contact network per wall second.
    pub contacts_rate_hz: f64,
    /// Instead: steps between frames of the contact network.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts_every_steps: Option<u64>,
    /// Instead: simulated time between frames of the contact network.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts_every_sim_s: Option<f64>,
    /// Of the contact network; all when absent. `ids` and `boundaries` are always there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts_columns: Option<Vec<ContactColumn>>,
    /// Of the floating-point columns of the contact network.
    pub contacts_float_type: FloatType,
    /// Most field frames per wall second.
    pub field_rate_hz: f64,
    /// Instead: steps between frames of a field.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field_every_steps: Option<u64>,
    /// Instead: simulated time between frames of a field.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field_every_sim_s: Option<f64>,
    /// Reports per wall second.
    pub report_rate_hz: f64,
    /// Instead: steps between reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub report_every_steps: Option<u64>,
    /// Instead: simulated time between reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub report_every_sim_s: Option<f64>,
}

impl Default for OutputSection {
    fn default() -> Self {
        Self {
            state_rate_hz: 10.0,
            state_every_steps: None,
            state_every_sim_s: None,
            state_columns: None,
            state_float_type: FloatType::F64,
            contacts_rate_hz: 5.0,
            contacts_every_steps: None,
            contacts_every_sim_s: None,
            contacts_columns: None,
            contacts_float_type: FloatType::F64,
            field_rate_hz: 5.0,
            field_every_steps: None,
            field_every_sim_s: None,
            report_rate_hz: 2.0,
            report_every_steps: None,
            report_every_sim_s: None,
        }
    }
}

/// When a stream hands out frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// At most one in so many seconds of wall time.
    Wall {
        /// Above 0.
        every_s: f64,
    },
    /// After every step whose number is a multiple.
    Steps {
        /// At least 1.
        every: u64,
    },
    /// At the first step at or after every multiple of a simulated time.
    Simulated {
        /// Above 0.
        every_s: f64,
    },
}

impl Pace {
    /// What is wrong with it.
    pub fn check(self) -> Result<(), &'static str> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        match self {
            Pace::Wall { every_s } if !positive(every_s) => Err("must be finite and above 0"),
            Pace::Wall { every_s } if every_s < 1e-3 => Err("must be at least 0.001 s of wall time"),
            Pace::Simulated { every_s } if !positive(every_s) => Err("must be finite and above 0"),
            Pace::Steps { every: 0 } => Err("must be at least 1"),
            _ => Ok(()),
        }
    }
}

fn pace(rate_hz: f64, every_steps: Option<u64>, every_sim_s: Option<f64>) -> Pace {
    match (every_steps, every_sim_s) {
        (Some(every), _) => Pace::Steps { every },
        (None, Some(every_s)) => Pace::Simulated { every_s },
        (None, None) => Pace::Wall { every_s: 1.0 / rate_hz },
    }
}

impl OutputSection {
    /// Of state frames.
    pub fn state_pace(&self) -> Pace {
        pace(self.state_rate_hz, self.state_every_steps, self.state_every_sim_s)
    }

    /// Of the contact network.
    pub fn contacts_pace(&self) -> Pace {
        pace(self.contacts_rate_hz, self.contacts_every_steps, self.contacts_every_sim_s)
    }

    /// Of every field.
    pub fn field_pace(&self) -> Pace {
        pace(self.field_rate_hz, self.field_every_steps, self.field_every_sim_s)
    }

    /// Of reports.
    pub fn report_pace(&self) -> Pace {
        pace(self.report_rate_hz, self.report_every_steps, self.report_every_sim_s)
    }

    pub(super) fn check(&self, problems: &mut Problems) {
        let streams = [
            ("state", self.state_rate_hz, self.state_every_steps, self.state_every_sim_s),
            ("contacts", self.contacts_rate_hz, self.contacts_every_steps, self.contacts_every_sim_s),
            ("field", self.field_rate_hz, self.field_every_steps, self.field_every_sim_s),
            ("report", self.report_rate_hz, self.report_every_steps, self.report_every_sim_s),
        ];
        for (stream, rate, steps, sim_s) in streams {
            let path = |key: &str| format!("output.{stream}_{key}");
            problems.in_range(&path("rate_hz"), rate, "in (0, 1000]", rate > 0.0 && rate <= 1000.0);
            if steps == Some(0) {
                problems.add(path("every_steps"), "is 0, must be at least 1");
            }
            if let Some(every) = sim_s {
                problems.in_range(&path("every_sim_s"), every, "finite and above 0", every > 0.0);
            }
            if steps.is_some() && sim_s.is_some() {
                problems.add(path("every_sim_s"), format!("and {}: give one of them", path("every_steps")));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, SceneDescription};

    fn scene(output: &str) -> Result<SceneDescription, String> {
        let text = format!("[scene]\nname = \"a\"\ntime_step_s = 1e-5\n[output]\n{output}");
        let description = SceneDescription::from_toml(&text).map_err(|error| error.to_string())?;
        Scene::validate(description.clone()).map_err(|error| error.to_string())?;
        Ok(description)
    }

    #[test]
    fn streams_keep_the_pace_that_is_given() {
        let output = scene("state_every_steps = 7\ncontacts_every_sim_s = 0.5\nreport_rate_hz = 4.0").unwrap().output;
        assert_eq!(output.state_pace(), Pace::Steps { every: 7 });
        assert_eq!(output.contacts_pace(), Pace::Simulated { every_s: 0.5 });
        assert_eq!(output.field_pace(), Pace::Wall { every_s: 0.2 });
        assert_eq!(output.report_pace(), Pace::Wall { every_s: 0.25 });
    }

    #[test]
    fn columns_go_by_name_and_come_back() {
        let text = "state_columns = [\"forces\", \"positions\"]\ncontacts_float_type = \"f32\"";
        let description = scene(text).unwrap();
        let columns = vec![ParticleColumn::Forces, ParticleColumn::Positions];
        assert_eq!(description.output.state_columns, Some(columns));
        assert_eq!(description.output.contacts_float_type, FloatType::F32);
        assert_eq!(SceneDescription::from_toml(&description.to_toml().unwrap()).unwrap(), description);
    }

    #[test]
    fn what_cannot_be_is_refused_with_its_key() {
        for (output, wanted) in [
            ("state_rate_hz = 0.0", "output.state_rate_hz"),
            ("field_every_steps = 0", "output.field_every_steps"),
            ("report_every_sim_s = -1.0", "output.report_every_sim_s"),
            ("contacts_every_steps = 1\ncontacts_every_sim_s = 1.0", "output.contacts_every_steps: give one of them"),
            ("state_columns = [\"colour\"]", "colour"),
        ] {
            let refused = scene(output).unwrap_err();
            assert!(refused.contains(wanted), "{refused}");
        }
    }
}
