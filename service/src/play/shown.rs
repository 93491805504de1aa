//! What a playback has shown last: the answers to queries.

use std::collections::BTreeMap;

use prost::Message as _;
use sturz_engine::{FloatType, ParticleColumn};
use sturz_protocol::columns;
use sturz_protocol::keys::Verb;
use sturz_protocol::v1;
use zenoh::bytes::ZBytes;

use crate::order::error;
use crate::output::choose;
use crate::record::{Headed, Recorded};
use crate::ticket::Moment;

/// Commands that a playback obeys.
pub const COMMANDS: [Verb; 3] = [Verb::Pause, Verb::Resume, Verb::Stop];

/// What was recorded up to now.
pub struct Shown {
    instance: String,
    info: v1::Info,
    features: v1::Features,
    plan: v1::Plan,
    shapes: v1::Shapes,
    moment: Moment,
    topology_epoch: u64,
    /// By key below the instance.
    streams: BTreeMap<String, ZBytes>,
}

/// A message of the schema, and its name.
pub type Answer = (&'static str, Vec<u8>);

impl Shown {
    /// Nothing yet, to be served as `instance`.
    pub fn new(instance: &str) -> Self {
        Self {
            instance: instance.into(),
            info: v1::Info::default(),
            features: v1::Features::default(),
            plan: v1::Plan::default(),
            shapes: v1::Shapes::default(),
            moment: Moment { step: 0, time_s: 0.0 },
            topology_epoch: 0,
            streams: BTreeMap::new(),
        }
    }

    /// Whether it knows what it shows: `info` and shapes, which every recording begins with.
    pub fn is_known(&self) -> bool {
        self.info.schema_version > 0
    }

    /// Whether anything was recorded that takes simulated time.
    pub fn is_moving(&self) -> bool {
        self.streams.keys().any(|tail| !tail.starts_with("event/"))
    }

    /// Whether it has a state to answer with.
    pub fn has_state(&self) -> bool {
        self.streams.contains_key("state/frame")
    }

    /// Steps and simulated time of the last state or report.
    pub fn moment(&self) -> Moment {
        self.moment
    }

    /// What is repeated for those who come late: the last of each stream, events apart.
    pub fn streams(&self) -> Vec<(String, ZBytes)> {
        let all = self.streams.iter().filter(|(tail, _)| !tail.starts_with("event/"));
        all.map(|(tail, payload)| (tail.clone(), payload.clone())).collect()
    }

    /// Takes over the next message; `payload` is its own.
    pub fn take(&mut self, message: &Recorded, payload: &ZBytes) -> Result<(), prost::DecodeError> {
        match message.topic.message.as_str() {
            "Info" => self.info = v1::Info::decode(message.payload.as_slice())?,
            "Features" => self.features = v1::Features::decode(message.payload.as_slice())?,
            "Plan" => self.plan = v1::Plan::decode(message.payload.as_slice())?,
            "Shapes" => self.shapes = v1::Shapes::decode(message.payload.as_slice())?,
            name => {
                let header = Headed::read(&message.payload).filter(|_| name != "Event");
                if let Some(header) = header {
                    self.moment = Moment { step: header.step, time_s: header.sim_time_s };
                    if name == "Frame" {
                        self.topology_epoch = header.topology_epoch;
                    }
                }
                self.streams.insert(message.topic.tail.clone(), payload.clone());
            }
        }
        Ok(())
    }

    /// Answers a query for the key `tail` below the instance, with the parameters `columns` and `float`.
    pub fn answer(&self, tail: &str, state: v1::RunState, parameters: [Option<&str>; 2]) -> Result<Answer, v1::Error> {
        match tail.split('/').collect::<Vec<_>>()[..] {
            ["info"] => Ok(("Info", self.info(state)?.encode_to_vec())),
            ["features"] => Ok(("Features", self.features().encode_to_vec())),
            ["plan"] => Ok(("Plan", self.plan.encode_to_vec())),
            ["shapes", epoch] if epoch == "latest" || epoch == self.shapes.epoch.to_string() => {
                Ok(("Shapes", self.shapes.encode_to_vec()))
            }
            ["state", "latest"] => Ok(("Frame", self.state(parameters)?.encode_to_vec())),
            ["report", "latest"] => Ok(("Report", self.stream("report")?.to_bytes().into_owned())),
            ["contacts", "latest"] => Ok(("ContactFrame", self.stream("contacts/frame")?.to_bytes().into_owned())),
            ["field", name, "latest"] => {
                Ok(("FieldFrame", self.stream(&format!("field/{name}"))?.to_bytes().into_owned()))
            }
            _ => Err(error(v1::ErrorCode::NotFound, "", format!("there is no {tail} in this recording"))),
        }
    }

    fn stream(&self, tail: &str) -> Result<&ZBytes, v1::Error> {
        let none = || format!("no {tail} has been played yet, or none was recorded");
        self.streams.get(tail).ok_or_else(|| error(v1::ErrorCode::NotFound, "", none()))
    }

    fn frame(&self) -> Result<v1::Frame, v1::Error> {
        let payload = self.stream("state/frame")?.to_bytes();
        v1::Frame::decode(payload.as_ref()).map_err(|reason| error(v1::ErrorCode::Internal, "", reason.to_string()))
    }

    /// Of the recorded run, with what has changed since it was asked for.
    fn info(&self, state: v1::RunState) -> Result<v1::Info, v1::Error> {
        let mut info = v1::Info {
            instance: self.instance.clone(),
            pid: std::process::id(),
            state: state.into(),
            lease_holder: String::new(),
            ..self.info.clone()
        };
        if self.moment.step != info.step {
            // Nobody has computed it for this state.
            info.state_hash = 0;
        }
        (info.step, info.sim_time_s) = (self.moment.step, self.moment.time_s);
        if self.has_state() {
            let frame = self.frame()?;
            (info.particles, info.topology_epoch) = (frame.n, self.topology_epoch);
            info.gravity_m_per_s2 = frame.gravity_m_per_s2;
        }
        Ok(info)
    }

    fn features(&self) -> v1::Features {
        v1::Features {
            commands: COMMANDS.map(|verb| verb.name().to_string()).to_vec(),
            capabilities: vec!["recording".into(), "event_history".into()],
            ..self.features.clone()
        }
    }

    fn state(&self, parameters: [Option<&str>; 2]) -> Result<v1::Frame, v1::Error> {
        let chosen = choose(parameters, |names| ParticleColumn::select(names), ParticleColumn::usual)?;
        let mut frame = self.frame()?;
        if let Some(header) = &mut frame.header {
            header.seq = 0;
        }
        let mut there = std::mem::take(&mut frame.columns);
        for column in chosen.columns {
            let Some(at) = there.iter().position(|one| one.name == column.name()) else { continue };
            frame.columns.push(narrowed(there.swap_remove(at), chosen.float));
        }
        Ok(frame)
    }
}

/// As f32, where that is asked for and the column is f64.
fn narrowed(column: v1::Column, float: FloatType) -> v1::Column {
    if float != FloatType::F32 || column.dtype() != v1::DataType::F64 {
        return column;
    }
    let numbers = column.data.chunks_exact(8).map(|bytes| {
        let mut raw = [0; 8];
        raw.copy_from_slice(bytes);
        f64::from_le_bytes(raw) as f32
    });
    columns::flat(&column.name, &column.unit, column.components as usize, &numbers.collect::<Vec<f32>>())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::record::Topic;

    fn recorded(tail: &str, message: &str, payload: Vec<u8>) -> Recorded {
        let topic = Topic { instance: "was".into(), tail: tail.into(), message: message.into() };
        Recorded { topic: Arc::new(topic), log_time_ns: 0, payload }
    }

    fn shown() -> Shown {
        let mut shown = Shown::new("is");
        let header = v1::Header { step: 40, sim_time_s: 0.4, topology_epoch: 3, seq: 9, ..Default::default() };
        let frame = v1::Frame {
            header: Some(header.clone()),
            n: 1,
            columns: vec![
                columns::flat("ids", "", 1, &[5_u64]),
                columns::rows("positions", "m", &[[0.1_f64, 0.2, 0.3]]),
                columns::rows("velocities", "m/s", &[[1.0_f64, 2.0, 3.0]]),
            ],
            gravity_m_per_s2: Some(v1::Vec3 { x: 0.0, y: 0.0, z: -1.0 }),
            ..Default::default()
        };
        let info =
            v1::Info { schema_version: 1, step: 10, state_hash: 77, instance: "was".into(), ..Default::default() };
        let field = v1::FieldFrame { header: Some(header), name: "slice".into(), ..Default::default() };
        for message in [
            recorded("info", "Info", info.encode_to_vec()),
            recorded("state/frame", "Frame", frame.encode_to_vec()),
            recorded("field/slice", "FieldFrame", field.encode_to_vec()),
        ] {
            shown.take(&message, &message.payload.clone().into()).unwrap();
        }
        shown
    }

    #[test]
    fn queries_are_answered_from_what_was_played() {
        let shown = shown();
        let ask = |tail, columns, float| shown.answer(tail, v1::RunState::Paused, [columns, float]);
        let info = v1::Info::decode(ask("info", None, None).unwrap().1.as_slice()).unwrap();
        assert_eq!((info.instance.as_str(), info.step, info.particles, info.topology_epoch), ("is", 40, 1, 3));
        assert_eq!((info.state(), info.state_hash), (v1::RunState::Paused, 0));
        let frame =
            v1::Frame::decode(ask("state/latest", Some("positions"), Some("f32")).unwrap().1.as_slice()).unwrap();
        assert_eq!(frame.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>(), ["ids", "positions"]);
        assert_eq!(columns::read::<f32, 3>(&frame.columns[1]), Ok(vec![[0.1, 0.2, 0.3]]));
        assert_eq!(ask("field/slice/latest", None, None).unwrap().0, "FieldFrame");
    }

    #[test]
    fn what_is_not_there_is_refused_by_name() {
        let shown = shown();
        let refusal = |tail, columns| {
            shown.answer(tail, v1::RunState::Running, [columns, None]).map(|(name, _)| name).unwrap_err()
        };
        assert!(refusal("report/latest", None).message.contains("report"));
        assert!(refusal("field/other/latest", None).message.contains("field/other"));
        assert!(refusal("shapes/7", None).message.contains("shapes/7"));
        assert_eq!(refusal("state/latest", Some("colour")).path, "columns");
    }
}
