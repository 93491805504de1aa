//! The runs: interleaved over all settings, so that a machine that is busy for a while disturbs all alike.

use std::time::{Duration, Instant};

use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Engine, Snapshot};

use super::Measure;
use super::plan::{Plan, Reference};
use super::vary::Setting;

/// Instants that an average is taken over.
const INSTANTS: u64 = 200;

/// One run of one setting.
#[derive(Clone, Debug)]
pub struct Sample {
    /// What was measured; why the run came to no end, otherwise.
    pub value: Result<Vec<f64>, String>,
    /// Of the steps alone, s.
    pub wall_s: f64,
    /// Steps done.
    pub steps: u64,
    /// Steps times particles.
    pub particle_steps: u64,
}

/// What makes one sample of a setting different from another.
#[derive(Clone, Copy, Debug)]
pub enum Variant {
    /// The first step is this part of a step, in [0, 1): the same motion met by the grid of time at another phase.
    Phase(f64),
    /// Added to the seed of the scene.
    Seed(u64),
}

/// All runs of a study.
pub struct Runs<'a> {
    plan: &'a Plan,
    settings: &'a [Setting],
    /// Of each setting.
    pub samples: Vec<Vec<Sample>>,
    /// Of the setting that the others are compared with, where there is one.
    pub reference: Vec<Sample>,
    /// Why there is none.
    pub reference_problem: Option<String>,
}

impl<'a> Runs<'a> {
    /// None yet.
    pub fn new(plan: &'a Plan, settings: &'a [Setting]) -> Self {
        let samples = vec![Vec::new(); settings.len()];
        Self { plan, settings, samples, reference: Vec::new(), reference_problem: None }
    }

    /// Does them all. A setting that fails once is not tried again.
    pub fn go(&mut self, progress: &mut impl FnMut(&str, usize)) {
        let finest = (self.plan.reference == Reference::Finest).then(|| self.plan.finest(self.settings));
        let finest = match finest.transpose() {
            Ok(finest) => finest,
            Err(failure) => {
                self.reference_problem = Some(failure.to_string());
                None
            }
        };
        let references = finest.as_ref().map_or(0, |_| if self.plan.seeds { self.plan.samples } else { 1 });
        let mut left = self.settings.len() * self.plan.samples + references;
        for k in 0..self.plan.samples {
            let variant = self.plan.variant(k);
            for (setting, samples) in self.settings.iter().zip(&mut self.samples) {
                progress(&setting.label(), left);
                left -= 1;
                if samples.last().is_none_or(|sample| sample.value.is_ok()) {
                    samples.push(sample(setting, self.plan, variant));
                }
            }
            if let Some(finest) = finest.as_ref().filter(|_| k < references) {
                progress("reference", left);
                left -= 1;
                self.reference.push(sample(finest, self.plan, variant));
            }
        }
    }
}

impl Plan {
    /// Of the sample of this index.
    pub fn variant(&self, k: usize) -> Variant {
        if self.seeds { Variant::Seed(k as u64) } else { Variant::Phase(k as f64 / self.samples as f64) }
    }
}

/// Runs a setting to its end.
pub fn sample(setting: &Setting, plan: &Plan, variant: Variant) -> Sample {
    let none = |reason: String| Sample { value: Err(reason), wall_s: 0.0, steps: 0, particle_steps: 0 };
    let mut description: SceneDescription = match &setting.scene {
        Ok(description) => description.clone(),
        Err(reason) => return none(format!("refused: {reason}")),
    };
    if let Variant::Seed(more) = variant {
        description.scene.seed = description.scene.seed.wrapping_add(more);
    }
    let scene = match Scene::validate(description) {
        Ok(scene) => scene,
        Err(problems) => return none(format!("refused: {problems}")),
    };
    let mut engine = Engine::new(scene);
    engine.set_threads(setting.threads);
    let mut run =
        Run { measure: &plan.measure, wall: Duration::ZERO, particle_steps: 0, snapshot: Snapshot::default() };
    let value = run.finish(&mut engine, plan, variant);
    Sample { value, wall_s: run.wall.as_secs_f64(), steps: engine.clock().step(), particle_steps: run.particle_steps }
}

struct Run<'a> {
    measure: &'a Measure,
    wall: Duration,
    particle_steps: u64,
    snapshot: Snapshot,
}

impl Run<'_> {
    fn finish(&mut self, engine: &mut Engine, plan: &Plan, variant: Variant) -> Result<Vec<f64>, String> {
        if let Variant::Phase(phase) = variant
            && phase > 0.0
        {
            let dt = engine.clock().time_step_s();
            self.window(engine, phase * dt)?;
        }
        if let Some(from_s) = plan.average_from_s {
            self.window(engine, from_s - engine.clock().time_s())?;
            return self.average(engine, plan.time_s);
        }
        self.window(engine, plan.time_s - engine.clock().time_s())?;
        self.measure.read(engine, &mut self.snapshot)
    }

    /// Goes on for a duration, met exactly; not at all where there is none.
    fn window(&mut self, engine: &mut Engine, duration_s: f64) -> Result<(), String> {
        if duration_s <= 0.0 {
            return Ok(());
        }
        let n = engine.begin_window(duration_s).map_err(|error| error.to_string())?;
        self.steps(engine, n)?;
        engine.end_window();
        Ok(())
    }

    fn steps(&mut self, engine: &mut Engine, n: u64) -> Result<(), String> {
        let begin = Instant::now();
        let mut particle_steps = 0;
        let outcome = engine.in_pool(|engine| {
            for _ in 0..n {
                engine.step()?;
                particle_steps += engine.len() as u64;
            }
            Ok(())
        });
        self.wall += begin.elapsed();
        self.particle_steps += particle_steps;
        outcome.map_err(|error: sturz_engine::StepError| format!("failed: {error}"))
    }

    /// Mean over instants that are as many steps apart from now to the end.
    fn average(&mut self, engine: &mut Engine, end_s: f64) -> Result<Vec<f64>, String> {
        let duration_s = end_s - engine.clock().time_s();
        let mut left = engine.begin_window(duration_s).map_err(|error| error.to_string())?;
        let every = (left / INSTANTS).max(1);
        let (mut sum, mut n) = (Vec::new(), 0.0);
        while left > 0 {
            let steps = every.min(left);
            self.steps(engine, steps)?;
            left -= steps;
            let value = self.measure.read(engine, &mut self.snapshot)?;
            sum.resize(value.len(), 0.0);
            sum.iter_mut().zip(&value).for_each(|(sum, value)| *sum += value);
            n += 1.0;
        }
        engine.end_window();
        sum.iter_mut().for_each(|sum| *sum /= n);
        Ok(sum)
    }
}
