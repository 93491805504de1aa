//! The fields of a state.

use super::averaging::Average;
use super::columns::columns;
use super::definition::{FieldDefinition, FieldFrame, GridMotion, WidthColumns};
use super::pose::Pose;
use super::sample::sample;
use super::sources::FieldSources;
use crate::checkpoint::codec::pack_fields;
use crate::contact_network::ContactNetwork;
use crate::engine::Engine;
use crate::error::InvalidInput;
use crate::math::Vec3;
use crate::scene::Scene;
use crate::snapshot::Snapshot;

/// Of all particles of a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Totals {
    pub step: u64,
    pub time_s: f64,
    pub mass: f64,
    pub momentum: Vec3,
}

pack_fields!(Totals { step: u64, time_s: f64, mass: f64, momentum: Vec3 });

impl Totals {
    pub fn of(sources: &FieldSources<'_>) -> Self {
        Self {
            step: sources.step,
            time_s: sources.time_s,
            mass: sources.total_mass(),
            momentum: sources.total_momentum(),
        }
    }
}

/// Samples a valid definition.
///
/// # Errors
/// The definition takes contacts, and those of the state are not known.
pub fn compute(definition: &FieldDefinition, sources: &FieldSources<'_>) -> Result<FieldFrame, InvalidInput> {
    check_contacts(definition, sources)?;
    Ok(sampled(definition, sources))
}

fn check_contacts(definition: &FieldDefinition, sources: &FieldSources<'_>) -> Result<(), InvalidInput> {
    if let (None, Some(quantity)) =
        (&sources.contacts, definition.quantities.iter().find(|quantity| quantity.needs_contacts()))
    {
        let problem = format!("{} takes the contacts of step {}, which are not known", quantity.name(), sources.step);
        return Err(InvalidInput::new("quantities", problem));
    }
    Ok(())
}

/// A mean over states that are handed over one by one, such as recorded ones, whatever their steps.
pub struct FieldMean {
    average: Average,
    last: Option<FieldFrame>,
}

impl FieldMean {
    /// Of a valid definition with `average`, of which steps and times are passed over; `None` without it.
    pub fn new(definition: &FieldDefinition) -> Option<Self> {
        Some(Self { average: Average::new(definition)?, last: None })
    }

    /// Adds a state.
    ///
    /// # Errors
    /// The definition takes contacts, and those of the state are not known.
    pub fn add(&mut self, sources: &FieldSources<'_>) -> Result<(), InvalidInput> {
        let definition = self.average.definition();
        check_contacts(definition, sources)?;
        self.last = Some(blank(definition, sources));
        self.average.add(sources);
        Ok(())
    }

    /// The mean up to now; `None` before the first state.
    pub fn frame(&self) -> Option<FieldFrame> {
        self.last.clone().map(|blank| self.average.fill(blank))
    }
}

fn sampled(definition: &FieldDefinition, sources: &FieldSources<'_>) -> FieldFrame {
    let found = sample(definition, sources, None);
    let mut all = definition
        .widths_m()
        .zip(&found.widths)
        .map(|(width_m, sums)| WidthColumns { width_m, columns: columns(definition, sums, 1, &found.reference) });
    let first = all.next().map(|width| width.columns);
    FieldFrame { columns: first.unwrap_or_default(), more_widths: all.collect(), ..blank(definition, sources) }
}

/// Without columns.
fn blank(definition: &FieldDefinition, sources: &FieldSources<'_>) -> FieldFrame {
    let pose = Pose::of_motion(definition, sources);
    let totals = Totals::of(sources);
    FieldFrame {
        name: definition.name.clone(),
        step: sources.step,
        time_s: sources.time_s,
        grid: definition.grid,
        grid_origin_m: pose.origin.into(),
        grid_orientation_wxyz: pose.orientation_wxyz(),
        kernel: definition.kernel,
        width_m: definition.width_m,
        cutoff_widths: definition.cutoff_widths,
        columns: Vec::new(),
        more_widths: Vec::new(),
        total_mass_kg: totals.mass,
        total_momentum_kg_m_per_s: totals.momentum.into(),
        samples: 1,
        blocks: 0,
        from_time_s: sources.time_s,
    }
}

impl FieldDefinition {
    /// Whether a scene has what the definition names.
    pub fn check_against(&self, scene: &Scene, path: &str) -> Result<(), InvalidInput> {
        let names: Vec<&str> = scene.boundaries().iter().map(|boundary| boundary.name.as_str()).collect();
        self.check_names(&names, path)
    }

    /// The same with the names of the boundaries.
    pub(crate) fn check_names(&self, boundaries: &[&str], path: &str) -> Result<(), InvalidInput> {
        match &self.motion {
            Some(GridMotion::Boundary { name }) if !boundaries.contains(&name.as_str()) => {
                let problem = format!("is {name:?}; the scene has {boundaries:?}");
                Err(InvalidInput::new(format!("{path}.motion.name"), problem))
            }
            _ => Ok(()),
        }
    }
}

impl Engine {
    /// Checks a field before it is defined.
    pub fn validate_field(&self, definition: &FieldDefinition) -> Result<(), InvalidInput> {
        definition.validate("define_field")?;
        definition.check_against(&self.scene, "define_field")
    }

    /// A field: sampled now, or its mean over time up to now, if it is one that [`Engine::set_averages`] has begun. The
    /// definition must be valid.
    pub fn compute_field(&mut self, definition: &FieldDefinition) -> FieldFrame {
        self.in_pool(|engine| {
            let average = engine.averages.iter().find(|average| average.definition() == definition);
            let needs_contacts = definition.needs_contacts() && average.is_none();
            engine.with_sources(needs_contacts, |sources| match average {
                Some(average) => average.fill(blank(definition, sources)),
                None => sampled(definition, sources),
            })
        })
    }

    /// From now on means are taken of these definitions, at the ends of the steps that they name: those that are under way
    /// go on, others end, new ones begin. Definitions of the state of now are passed over. All must be valid.
    pub fn set_averages<'d>(&mut self, definitions: impl IntoIterator<Item = &'d FieldDefinition>) {
        let mut before = std::mem::take(&mut self.averages);
        for definition in definitions {
            let known = before.iter().position(|average| average.definition() == definition);
            self.averages.extend(match known {
                Some(k) => Some(before.swap_remove(k)),
                None => Average::new(definition),
            });
        }
    }

    /// Adds the state of now to the means that are due.
    pub(crate) fn sample_averages(&mut self) {
        let (step, time_s) = (self.clock.step(), self.clock.time_s());
        let is_due = |average: &Average| average.is_due(step, time_s);
        if !self.averages.iter().any(is_due) {
            return;
        }
        let mut averages = std::mem::take(&mut self.averages);
        let needs_contacts = averages.iter().any(|average| is_due(average) && average.definition().needs_contacts());
        self.with_sources(needs_contacts, |sources| {
            averages.iter_mut().filter(|average| is_due(average)).for_each(|average| average.add(sources));
        });
        self.averages = averages;
    }

    fn with_sources<R>(&self, needs_contacts: bool, f: impl FnOnce(&FieldSources<'_>) -> R) -> R {
        let mut snapshot = Snapshot::default();
        self.snapshot(&mut snapshot);
        let network = needs_contacts.then(|| {
            let mut network = ContactNetwork::default();
            self.contact_network(&mut network);
            network
        });
        let sources = FieldSources::new(&self.scene, &snapshot, network.as_ref());
        f(&sources.expect("the engine's own state is one of its scene"))
    }
}
