//! Particles that come in over time: batches of random places, as functions of (seed, id).

use std::sync::Arc;

use crate::checkpoint::codec::pack_fields;
use crate::engine::Engine;
use crate::error::InvalidInput;
use crate::happening::Happening;
use crate::insertion::{self, Amount, Surroundings};
use crate::scene::InflowDescription;

/// Where one inflow is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct InflowRun {
    /// Number of the next batch.
    next: u64,
    /// Particles brought in.
    pub count: u64,
    /// Of these, kg.
    mass: f64,
    /// Batches that found too little room.
    short: u64,
    /// 1 once it has brought all.
    over: u32,
}

pack_fields!(InflowRun { next: u64, count: u64, mass: f64, short: u64, over: u32 });

/// Rounding of a rate times a time that still counts as a whole particle.
const WHOLE: f64 = 1e-9;

impl InflowRun {
    /// Whether an engine may have it.
    pub(crate) fn check(&self) -> Result<(), InvalidInput> {
        if self.mass.is_finite() && self.mass >= 0.0 && self.over <= 1 {
            return Ok(());
        }
        Err(InvalidInput::new("inflow", format!("is {self:?}")))
    }

    /// Words for the state hash.
    pub(crate) fn words(&self) -> [f64; 5] {
        [self.next as f64, self.count as f64, self.mass, self.short as f64, f64::from(self.over)]
    }

    fn has_all(&self, inflow: &InflowDescription) -> bool {
        inflow.count.is_some_and(|count| self.count >= count) || inflow.mass_kg.is_some_and(|mass| self.mass >= mass)
    }

    /// What the next batch, at this time, is to bring; `None` where none is due.
    fn due(&mut self, inflow: &InflowDescription, now_s: f64) -> Option<(u64, f64)> {
        let since_s = now_s - inflow.start_s;
        if self.over == 1 || since_s < self.next as f64 * inflow.interval_s {
            return None;
        }
        if inflow.end_s.is_some_and(|end| now_s >= end) {
            self.over = 1;
            return None;
        }
        self.next = (since_s / inflow.interval_s).floor() as u64 + 1;
        // so that a batch brings what its interval is to bring
        let up_to_s = self.next as f64 * inflow.interval_s;
        let count = inflow.rate_per_s.map_or(u64::MAX, |rate| (rate * up_to_s + WHOLE).floor() as u64);
        let mass = inflow.mass_rate_kg_per_s.map_or(f64::INFINITY, |rate| rate * up_to_s);
        let count = count.min(inflow.count.unwrap_or(u64::MAX)).saturating_sub(self.count);
        let mass = mass.min(inflow.mass_kg.unwrap_or(f64::INFINITY)) - self.mass;
        (count > 0 && mass > 0.0).then_some((count, mass))
    }
}

impl Engine {
    /// Whether an inflow of the scene is not over.
    pub fn has_inflow_ahead(&self) -> bool {
        self.inflows.iter().any(|run| run.over == 0)
    }

    /// Before a step: brings in what is due.
    pub(crate) fn feed_inflows(&mut self) {
        let now_s = self.clock.time_s();
        for index in 0..self.inflows.len() {
            let written = Arc::clone(&self.written);
            let inflow = &written.description().inflows[index];
            let was_over = self.inflows[index].over == 1;
            if let Some((count, mass)) = self.inflows[index].due(inflow, now_s) {
                self.bring(index, inflow, (count, mass));
            }
            let run = &mut self.inflows[index];
            if run.has_all(inflow) {
                run.over = 1;
            }
            if run.over == 1 && !was_over {
                let count = run.count;
                self.tell(Happening::InflowOver { index, count });
            }
        }
    }

    fn bring(&mut self, index: usize, inflow: &InflowDescription, (count, mass): (u64, f64)) {
        let description = inflow.batch();
        let materials = &self.scene.description().materials;
        let density =
            materials.iter().find(|material| material.name == inflow.material).and_then(|m| m.density_kg_per_m3);
        let amount = Amount { count, volume: mass / density.unwrap_or(f64::NAN) };
        let present = self.present();
        let surroundings = Surroundings {
            scene: &self.scene,
            boundaries: &self.boundaries,
            present: &present,
            first_id: self.next_id,
        };
        let path = format!("inflow[{index}]");
        // the scene has proved the rest: what is left to refuse is a batch of absurd size
        let placed = insertion::place_what_fits(&description, &surroundings, amount, &path);
        let (new, is_short) = placed.map_or((Vec::new(), true), |placed| (placed.particles, placed.is_full));
        let run = &mut self.inflows[index];
        run.count += new.len() as u64;
        run.mass += new.iter().map(|particle| particle.mass).sum::<f64>();
        run.short += u64::from(is_short);
        let total = run.short;
        if !new.is_empty() {
            self.tell(Happening::Inflow { index, first_id: self.next_id, count: new.len() as u64 });
            self.add_particles(&new);
        }
        if is_short {
            self.tell(Happening::InflowShort { index, total });
        }
    }
}
