//! From what the physics thread copied to bytes on the wire. Runs on the I/O side.

use std::time::{SystemTime, UNIX_EPOCH};

use prost::Message;
use sturz_engine::fields::FieldQuantity;
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{ContactColumn, FloatType, ParticleColumn};
use sturz_protocol::SCHEMA_VERSION;
use sturz_protocol::convert;
use sturz_protocol::keys::Verb;
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::config::Limits;
use crate::mailbox::{Answer, ReportSample, Status};
use crate::ticket::Moment;

/// What of `info`, `features`, `plan` and `shapes` never changes, and who signs every header.
pub struct Identity {
    run_id: String,
    info: v1::Info,
    /// For `features`.
    pub features: v1::Features,
    /// For `plan`.
    pub plan: v1::Plan,
    /// For `shapes`.
    pub shapes: v1::Shapes,
}

impl Identity {
    /// Of a daemon that serves `scene` as `instance` on so many threads.
    pub fn new(instance: &str, run_id: String, scene: &Scene, threads: usize, limits: &Limits) -> Self {
        let description = scene.description();
        let info = v1::Info {
            version: env!("CARGO_PKG_VERSION").into(),
            schema_version: SCHEMA_VERSION,
            instance: instance.into(),
            run_id: run_id.clone(),
            scene: description.scene.name.clone(),
            pid: std::process::id(),
            domain: Some(convert::domain_to_wire(&description.domain)),
            boundaries: description.boundaries.iter().map(convert::boundary_to_wire).collect(),
            materials: description.materials.iter().map(|material| material.name.clone()).collect(),
            shapes: description.shapes.iter().map(|shape| shape.name.clone()).collect(),
            scene_toml: description.to_toml().unwrap_or_default(),
            threads: threads as u32,
            ..Default::default()
        };
        let shapes = description.shapes.iter().zip(scene.shapes());
        let shapes = shapes.map(|(named, shape)| convert::shape_to_wire(&named.name, &named.geometry, shape));
        Self {
            run_id,
            info,
            features: features(limits),
            plan: v1::Plan { lines: scene.plan().lines.clone() },
            shapes: v1::Shapes { epoch: 0, shapes: shapes.collect() },
        }
    }

    /// A header for the state of this moment.
    pub fn header(&self, moment: Moment, topology_epoch: u64, seq: u64) -> v1::Header {
        v1::Header {
            schema_version: SCHEMA_VERSION,
            run_id: self.run_id.clone(),
            seq,
            step: moment.step,
            sim_time_s: moment.time_s,
            wall_time_ns: wall_time_ns(),
            topology_epoch,
        }
    }

    /// A header whose state the conversion fills in.
    pub fn blank_header(&self, topology_epoch: u64, seq: u64) -> v1::Header {
        self.header(Moment { step: 0, time_s: 0.0 }, topology_epoch, seq)
    }

    /// For `info`.
    pub fn info(&self, status: &Status) -> v1::Info {
        v1::Info {
            state: status.state.into(),
            failure: status.failure.clone(),
            sim_time_s: status.time_s,
            step: status.step,
            time_step_s: status.time_step_s,
            particles: status.particles,
            topology_epoch: status.topology_epoch,
            state_hash: status.state_hash,
            gravity_m_per_s2: Some(convert::vec3(status.gravity_m_per_s2)),
            fields: status.fields.clone(),
            lease_holder: status.lease_holder.clone(),
            outputs: status.outputs.clone(),
            ..self.info.clone()
        }
    }

    /// What of `info` is that of the scene.
    pub fn scene_info(&self) -> v1::Info {
        self.info.clone()
    }

    /// For `report`.
    pub fn report(&self, sample: &ReportSample, seq: u64) -> v1::Report {
        let header = self.blank_header(sample.topology_epoch, seq);
        v1::Report {
            state: sample.state.into(),
            stages: sample.stages.clone(),
            sim_s_per_wall_s: sample.sim_s_per_wall_s,
            steps_per_wall_s: sample.steps_per_wall_s,
            longest_pause_s: sample.longest_pause_s,
            streams: sample.streams.clone(),
            state_hash: sample.state_hash,
            progress: sample.progress,
            wall_s: sample.wall_s,
            ..convert::report_to_wire(&sample.engine, header)
        }
    }

    /// An outcome, with its data encoded into it.
    pub fn outcome(&self, answer: Answer) -> Vec<u8> {
        let mut outcome = answer.outcome;
        if let (Some(Wire::Advanced(advanced)), Some(capture)) = (&mut outcome.result, &answer.capture) {
            let chosen = capture.outputs.columns.as_deref().unwrap_or_default();
            let epoch = capture.snapshot.as_ref().map_or(0, |snapshot| snapshot.topology_epoch);
            let header = || self.blank_header(epoch, 0);
            let frame = |snapshot| convert::frame_to_wire(snapshot, chosen, capture.outputs.float, header());
            advanced.frame = capture.snapshot.as_ref().map(frame);
            let field = |field| convert::field_to_wire(field, &[], FloatType::F64, header());
            advanced.fields = capture.fields.iter().map(field).collect();
            let contacts =
                |network| convert::contacts_to_wire(network, ContactColumn::ALL, capture.outputs.float, header());
            advanced.contacts = capture.contacts.as_ref().map(contacts);
            let exchange = |exchange| convert::exchange_to_wire(exchange, header());
            advanced.exchange = capture.exchange.as_ref().map(exchange);
        }
        outcome.encode_to_vec()
    }
}

/// Since 1970.
pub fn wall_time_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos() as u64
}

/// Other things that it can do, by name.
const CAPABILITIES: [&str; 11] = [
    "command_put",
    "at_time",
    "window",
    "event_history",
    "checkpoint",
    "loads",
    "lease",
    "journal",
    "contacts",
    "outputs",
    "fluid",
];

fn features(limits: &Limits) -> v1::Features {
    v1::Features {
        commands: Verb::ALL.map(|verb| verb.name().to_string()).to_vec(),
        columns: ParticleColumn::ALL.iter().map(|column| column.name().to_string()).collect(),
        contact_columns: ContactColumn::ALL.iter().map(|column| column.name().to_string()).collect(),
        field_quantities: FieldQuantity::ALL.map(|quantity| convert::quantity_name(quantity).0.to_string()).to_vec(),
        capabilities: CAPABILITIES.map(String::from).to_vec(),
        limits: Some(limits.to_wire()),
        scene_schema_json: scene_schema(),
    }
}

/// JSON schema of scene files.
pub fn scene_schema() -> String {
    let schema = schemars::schema_for!(SceneDescription);
    serde_json::to_string_pretty(&schema).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_names_what_a_scene_may_hold() {
        let schema: serde_json::Value = serde_json::from_str(&scene_schema()).unwrap();
        assert!(schema["properties"]["material_pair"].is_object());
    }
}
