//! What clients may read, on the physics thread: copied here, encoded on the I/O side.

use std::sync::Arc;

use sturz_engine::{ContactNetwork, ParticleColumn, Snapshot};
use sturz_protocol::convert::field_definition_to_wire;
use sturz_protocol::v1;
use tokio::sync::oneshot;

use crate::mailbox::{Capture, Read, ReadAnswer, ReportSample, Status};
use crate::order::{Outputs, error};
use crate::runner::{Phase, Runner};

impl Runner<'_> {
    /// Answers a question about the state of now.
    pub(crate) fn answer(&mut self, question: Read, reply: oneshot::Sender<ReadAnswer>) {
        let answer = match question {
            Read::Status => ReadAnswer::Status(Box::new(self.status())),
            Read::Report => ReadAnswer::Report(Box::new(self.report())),
            Read::State { forces } => ReadAnswer::State(Box::new(self.snapshot(forces))),
            Read::Contacts => ReadAnswer::Contacts(Box::new(self.contacts())),
            Read::Exchange => match self.engine.exchange() {
                Some(exchange) => ReadAnswer::Exchange(Box::new(exchange)),
                None => {
                    let text = "there is no fluid with a mesh: define one by set_fluid";
                    ReadAnswer::Refused(error(v1::ErrorCode::NotFound, "", text))
                }
            },
            Read::Field(name) => match self.outbox.field(&name) {
                Some(definition) => ReadAnswer::Field(Box::new(self.engine.compute_field(definition))),
                None => {
                    let text = format!("no field {name:?} is defined");
                    ReadAnswer::Refused(error(v1::ErrorCode::NotFound, "", text))
                }
            },
        };
        // A client that has gone no longer wants to know.
        drop(reply.send(answer));
    }

    fn snapshot(&self, forces: bool) -> Snapshot {
        let mut snapshot = Snapshot::default();
        self.engine.snapshot(&mut snapshot);
        if forces {
            self.engine.snapshot_forces(&mut snapshot);
        }
        snapshot
    }

    fn contacts(&self) -> ContactNetwork {
        let mut network = ContactNetwork::default();
        self.engine.contact_network(&mut network);
        network
    }

    /// State, fields and contacts of now; nothing when nothing was asked for.
    pub(crate) fn capture(&mut self, outputs: &Outputs) -> Option<Arc<Capture>> {
        if outputs.columns.is_none() && outputs.fields.is_empty() && !outputs.contacts && !outputs.exchange {
            return None;
        }
        let has_forces = |columns: &Vec<ParticleColumn>| columns.iter().any(|column| column.is_force());
        let snapshot = outputs.columns.as_ref().map(|columns| self.snapshot(has_forces(columns)));
        let contacts = outputs.contacts.then(|| self.contacts());
        let exchange = if outputs.exchange { self.engine.exchange() } else { None };
        let mut fields = Vec::with_capacity(outputs.fields.len());
        for name in &outputs.fields {
            // One that was dropped during the window is left out.
            if let Some(definition) = self.outbox.field(name) {
                fields.push(self.engine.compute_field(definition));
            }
        }
        Some(Arc::new(Capture { outputs: outputs.clone(), snapshot, fields, contacts, exchange }))
    }

    fn run_state(&self) -> v1::RunState {
        match self.phase {
            _ if self.window.is_some() => v1::RunState::Advancing,
            Phase::Running => v1::RunState::Running,
            Phase::Paused => v1::RunState::Paused,
            Phase::Failed(_) => v1::RunState::Failed,
            Phase::Ended => v1::RunState::Ended,
        }
    }

    fn status(&self) -> Status {
        let clock = self.engine.clock();
        let failure = match &self.phase {
            Phase::Failed(reason) => reason.clone(),
            _ => String::new(),
        };
        Status {
            state: self.run_state(),
            failure,
            step: clock.step(),
            time_s: clock.time_s(),
            time_step_s: clock.nominal_time_step_s(),
            particles: self.engine.len() as u64,
            topology_epoch: self.engine.topology_epoch(),
            state_hash: self.engine.state_hash(),
            gravity_m_per_s2: self.snapshot(false).gravity_m_per_s2,
            fields: self.outbox.fields.iter().map(|f| field_definition_to_wire(&f.definition)).collect(),
            lease_holder: self.lease_holder(),
            outputs: self.outbox.outputs(),
        }
    }

    /// The engine's report and what only the daemon knows.
    pub(crate) fn report(&mut self) -> ReportSample {
        let rates = self.meter.rates();
        ReportSample {
            engine: self.engine.report(),
            topology_epoch: self.engine.topology_epoch(),
            state_hash: self.engine.state_hash(),
            state: self.run_state(),
            progress: self.window.as_ref().map(|window| window.progress()),
            stages: rates.stages,
            sim_s_per_wall_s: rates.sim_s_per_wall_s,
            steps_per_wall_s: rates.steps_per_wall_s,
            longest_pause_s: rates.longest_pause_s,
            streams: self.outbox.counts(),
            wall_s: self.meter.wall_s(),
        }
    }
}
