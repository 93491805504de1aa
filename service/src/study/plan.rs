//! What a study is to do, checked.

use sturz_engine::scene::SceneDescription;

use super::measure::{MEASURES, Measure};
use super::vary::{Axis, Base, Setting, parse_axes};
use crate::cli;
use crate::commands::Failure;
use crate::scenes;

/// What errors are measured from.
#[derive(Clone, Debug, PartialEq)]
pub enum Reference {
    /// A run of its own: a quarter of the smallest time step, the largest stiffness and, else, the last value of each axis.
    Finest,
    /// What holds for every scene: 0 for residuals.
    Exact,
    /// Given, one number for each component.
    Value(Vec<f64>),
}

/// All that a study needs.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scene that is varied.
    pub base: SceneDescription,
    /// What is varied.
    pub axes: Vec<Axis>,
    /// What is measured.
    pub measure: Measure,
    /// What it is compared with.
    pub reference: Reference,
    /// End of every run, s.
    pub time_s: f64,
    /// Time from which the measure is averaged, s; at the end only when absent.
    pub average_from_s: Option<f64>,
    /// Runs of each setting.
    pub samples: usize,
    /// Whether each sample has a seed of its own; else a phase of the time steps.
    pub seeds: bool,
    /// Threads where they are not varied.
    pub threads: usize,
    /// What the recommended setting is to reach.
    pub wanted_error: f64,
    /// What differences are divided by; of the reference when absent.
    pub scale: Option<f64>,
    /// Whether the recommended setting is run once more.
    pub confirm: bool,
}

impl Plan {
    /// Checks the command line.
    pub fn new(options: &cli::Study) -> Result<Self, Failure> {
        let base = scenes::read(&options.scene.scene)?;
        let measure = Measure::parse(&options.measure, &base)?;
        let reference = reference(&options.reference, &measure)?;
        let time_s = options.time.or(base.stop.time_s).ok_or_else(|| {
            Failure::Usage("when shall the runs end? Give --time SECONDS, or `[stop] time_s` in the scene".into())
        })?;
        let positive = |name: &str, value: f64| {
            let message = format!("{name} is {value}, must be positive and finite");
            if value.is_finite() && value > 0.0 { Ok(()) } else { Err(Failure::Usage(message)) }
        };
        positive("--time", time_s)?;
        positive("--error", options.error)?;
        options.scale.map_or(Ok(()), |scale| positive("--scale", scale))?;
        if let Some(from) = options.average_from.filter(|from| !(0.0..time_s).contains(from)) {
            return Err(Failure::Usage(format!("--average-from is {from}, must be from 0 to below the end, {time_s}")));
        }
        if options.seeds && options.samples < 2 {
            return Err(Failure::Usage("--seeds needs --samples of 2 or more: one run has no error bar".into()));
        }
        Ok(Self {
            axes: parse_axes(&options.vary)?,
            base,
            measure,
            reference,
            time_s,
            average_from_s: options.average_from,
            samples: options.samples.into(),
            seeds: options.seeds,
            threads: options.threads.into(),
            wanted_error: options.error,
            scale: options.scale,
            confirm: !options.no_confirm,
        })
    }

    /// The grid.
    pub fn settings(&self) -> Result<Vec<Setting>, Failure> {
        Base::new(&self.base, self.threads)?.grid(&self.axes)
    }

    /// The setting of [`Reference::Finest`].
    pub fn finest(&self, settings: &[Setting]) -> Result<Setting, Failure> {
        let base = Base::new(&self.base, self.threads)?;
        let sizes = |axis: &Axis| axis.values.iter().map(size).collect::<Vec<f64>>();
        let chosen: Vec<(&str, &super::vary::Factor)> = self
            .axes
            .iter()
            .filter(|axis| axis.key != "threads")
            .map(|axis| {
                let sizes = sizes(axis);
                let by_size = |&a: &usize, &b: &usize| sizes[a].total_cmp(&sizes[b]);
                let place = match axis.key.as_str() {
                    "time_step" => (0..sizes.len()).min_by(by_size),
                    "stiffness" => (0..sizes.len()).max_by(by_size),
                    _ => sizes.len().checked_sub(1),
                };
                (axis.key.as_str(), &axis.values[place.unwrap_or(0)])
            })
            .collect();
        let mut finest = base.setting(&chosen)?;
        let usable = settings.iter().map(|setting| setting.time_step_s).filter(|&dt| dt > 0.0);
        let smallest = usable.fold(f64::INFINITY, f64::min).min(finest.time_step_s);
        let scene = finest.scene.as_mut().map_err(|reason| {
            Failure::Usage(format!("--reference finest: the finest setting ({chosen:?}) cannot be used: {reason}"))
        })?;
        (scene.scene.time_step, scene.scene.time_step_fraction) = (None, None);
        scene.scene.time_step_s = Some(0.25 * smallest);
        finest.time_step_s = 0.25 * smallest;
        Ok(finest)
    }
}

fn size(value: &super::vary::Factor) -> f64 {
    match value {
        super::vary::Factor::Times(size) | super::vary::Factor::Number(size) => *size,
        super::vary::Factor::Word(_) => 0.0,
    }
}

fn reference(text: &str, measure: &Measure) -> Result<Reference, Failure> {
    match text {
        "finest" => Ok(Reference::Finest),
        "exact" if measure.exact().is_some() => Ok(Reference::Exact),
        "exact" => Err(Failure::Usage(format!(
            "--reference exact: of {measure} no value is known that holds for every scene (of energy_residual and \
             force_residual 0 is); give the number, or finest. Measures are {MEASURES}"
        ))),
        numbers => {
            let numbers: Result<Vec<f64>, _> = numbers.split(',').map(|number| number.trim().parse()).collect();
            let numbers = numbers.ok().filter(|numbers| numbers.iter().all(|number: &f64| number.is_finite()));
            numbers.map(Reference::Value).ok_or_else(|| {
                Failure::Usage(format!("--reference is '{text}', must be finest, exact, or numbers parted by commas"))
            })
        }
    }
}
