//! Means over time with standard errors from block means.
//!
//! What is kept are sums, so that every quantity is made of mean sums: a velocity is mean momentum over mean density, and
//! fluctuations are about the mean over time.

use super::columns::columns;
use super::compute::Totals;
use super::definition::{AverageWindow, FieldAverage, FieldColumn, FieldDefinition, FieldFrame, WidthColumns};
use super::lattice::Lattice;
use super::layout::Layout;
use super::sample::{Sample, sample};
use super::sources::FieldSources;
use crate::checkpoint::codec::pack_fields;
use crate::error::InvalidInput;
use crate::math::Vec3;

/// Sums over some samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Block {
    samples: u64,
    /// For each width the sums of each cell.
    widths: Vec<Vec<f64>>,
}

/// A definition's mean in the making.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Average {
    definition: FieldDefinition,
    /// Velocity that momenta are told from, since the first sample.
    reference: Option<Vec3>,
    samples_per_block: u64,
    /// Complete ones, the oldest first.
    blocks: Vec<Block>,
    current: Block,
    /// Times of the first samples of the complete blocks and of the current one.
    starts_s: Vec<f64>,
    totals: Totals,
}

/// What a checkpoint keeps of an average; the definition as TOML.
pub(crate) struct SavedAverage {
    definition: Vec<u8>,
    reference: Option<Vec3>,
    samples_per_block: u64,
    blocks: Vec<Block>,
    current: Block,
    starts_s: Vec<f64>,
    totals: Totals,
}

pack_fields!(Block { samples: u64, widths: Vec<Vec<f64>> });
pack_fields!(SavedAverage {
    definition: Vec<u8>,
    reference: Option<Vec3>,
    samples_per_block: u64,
    blocks: Vec<Block>,
    current: Block,
    starts_s: Vec<f64>,
    totals: Totals,
});

impl Block {
    fn add(&mut self, samples: u64, widths: &[Vec<f64>]) {
        if self.widths.is_empty() {
            self.widths = widths.to_vec();
        } else {
            for (sums, more) in self.widths.iter_mut().zip(widths) {
                sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
            }
        }
        self.samples += samples;
    }
}

impl Average {
    /// Without samples. `None` for a definition of the state of now.
    pub fn new(definition: &FieldDefinition) -> Option<Self> {
        let average = definition.average.as_ref()?;
        Some(Self {
            definition: definition.clone(),
            reference: None,
            samples_per_block: average.samples_per_block,
            blocks: Vec::new(),
            current: Block::default(),
            starts_s: Vec::new(),
            totals: Totals::default(),
        })
    }

    pub fn definition(&self) -> &FieldDefinition {
        &self.definition
    }

    fn rule(&self) -> FieldAverage {
        self.definition.average.expect("averages are only made of definitions with a mean")
    }

    /// Whether the state after so many steps is to be sampled.
    pub fn is_due(&self, step: u64, time_s: f64) -> bool {
        let rule = self.rule();
        step.is_multiple_of(rule.every_steps) && time_s >= rule.from_time_s
    }

    /// Adds a state.
    pub fn add(&mut self, sources: &FieldSources<'_>) {
        let Sample { reference, widths } = sample(&self.definition, sources, self.reference);
        self.reference = Some(reference);
        self.totals = Totals::of(sources);
        if self.current.samples == 0 {
            self.starts_s.push(sources.time_s);
        }
        self.current.add(1, &widths);
        if self.current.samples == self.samples_per_block {
            self.blocks.push(std::mem::take(&mut self.current));
            self.limit_blocks();
        }
    }

    fn limit_blocks(&mut self) {
        let rule = self.rule();
        let most = rule.blocks as usize;
        match rule.window {
            AverageWindow::Sliding if self.blocks.len() > most => {
                self.blocks.remove(0);
                self.starts_s.remove(0);
            }
            AverageWindow::Growing if self.blocks.len() == 2 * most => {
                self.samples_per_block *= 2;
                self.starts_s = self.starts_s.iter().copied().step_by(2).collect();
                let pairs = std::mem::take(&mut self.blocks);
                self.blocks = pairs
                    .chunks_exact(2)
                    .map(|pair| {
                        let mut both = pair[0].clone();
                        both.add(pair[1].samples, &pair[1].widths);
                        both
                    })
                    .collect();
            }
            _ => {}
        }
    }

    /// The mean up to now. `frame` says where and when.
    pub fn fill(&self, frame: FieldFrame) -> FieldFrame {
        let samples = self.blocks.iter().map(|block| block.samples).sum::<u64>() + self.current.samples;
        let mut all = self
            .definition
            .widths_m()
            .enumerate()
            .map(|(k, width_m)| WidthColumns { width_m, columns: self.mean(k, samples, &frame) });
        let first = all.next().map(|width| width.columns);
        FieldFrame {
            step: self.totals.step,
            time_s: self.totals.time_s,
            columns: first.unwrap_or_default(),
            more_widths: all.collect(),
            total_mass_kg: self.totals.mass,
            total_momentum_kg_m_per_s: self.totals.momentum.into(),
            samples,
            blocks: self.blocks.len() as u64,
            from_time_s: self.starts_s.first().copied().unwrap_or(frame.time_s),
            ..frame
        }
    }

    fn mean(&self, width: usize, samples: u64, frame: &FieldFrame) -> Vec<FieldColumn> {
        let reference = self.reference.unwrap_or_default();
        let size = Layout::of(&self.definition.quantities).size;
        let cells = frame.grid.cells.iter().map(|&cells| cells as usize).product::<usize>();
        let mut total = vec![0.0; cells * size];
        let parts = self.blocks.iter().chain(std::iter::once(&self.current));
        for sums in parts.filter_map(|block| block.widths.get(width)) {
            total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
        }
        let mut mean = columns(&self.definition, &total, samples, &reference);
        if self.blocks.len() >= 2 {
            self.add_errors(width, &reference, &mut mean);
        }
        mean
    }

    /// Standard error of the mean of the blocks' own values.
    fn add_errors(&self, width: usize, reference: &Vec3, mean: &mut [FieldColumn]) {
        let n = self.blocks.len() as f64;
        let of_blocks: Vec<Vec<FieldColumn>> = self
            .blocks
            .iter()
            .map(|block| columns(&self.definition, &block.widths[width], block.samples, reference))
            .collect();
        for (k, column) in mean.iter_mut().enumerate() {
            let error = |index: usize| {
                let values = || of_blocks.iter().map(|columns| columns[k].data[index]);
                let middle = values().sum::<f64>() / n;
                (values().map(|value| (value - middle).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt()
            };
            column.standard_error = Some((0..column.data.len()).map(error).collect());
        }
    }

    /// For a checkpoint.
    pub fn saved(&self) -> SavedAverage {
        SavedAverage {
            definition: toml::to_string(&self.definition).unwrap_or_default().into_bytes(),
            reference: self.reference,
            samples_per_block: self.samples_per_block,
            blocks: self.blocks.clone(),
            current: self.current.clone(),
            starts_s: self.starts_s.clone(),
            totals: self.totals,
        }
    }
}

impl SavedAverage {
    /// Checks what a checkpoint kept; `path` names it in errors.
    pub fn restored(self, path: &str) -> Result<Average, InvalidInput> {
        let definition: FieldDefinition = toml::from_slice(&self.definition)
            .map_err(|error| InvalidInput::new(format!("{path}.definition"), error.message().to_string()))?;
        definition.validate(path)?;
        let average = Average {
            samples_per_block: self.samples_per_block,
            reference: self.reference,
            blocks: self.blocks,
            current: self.current,
            starts_s: self.starts_s,
            totals: self.totals,
            ..Average::new(&definition)
                .ok_or_else(|| InvalidInput::new(format!("{path}.average"), "is missing from a mean"))?
        };
        average.check().map_err(|problem| InvalidInput::new(path, problem))?;
        Ok(average)
    }
}

impl Average {
    /// Whether there are as many numbers as there must be.
    fn check(&self) -> Result<(), &'static str> {
        let size = Layout::of(&self.definition.quantities).size;
        let cells = Lattice::new(&self.definition.grid, self.definition.width_m).n_cells();
        let widths = self.definition.widths_m().count();
        let fits = |block: &Block| {
            block.samples > 0
                && block.widths.len() == widths
                && block.widths.iter().all(|sums| sums.len() == cells * size && sums.iter().all(|x| x.is_finite()))
        };
        let is_empty = self.current == Block::default();
        if !self.blocks.iter().all(fits) || !(is_empty || fits(&self.current)) {
            return Err("has blocks that do not fit its definition");
        }
        if self.starts_s.len() != self.blocks.len() + usize::from(!is_empty) {
            return Err("has another number of blocks than of their times");
        }
        if self.samples_per_block == 0 || self.current.samples >= self.samples_per_block {
            return Err("has more samples in a block than it may");
        }
        if self.blocks.len() >= 2 * self.rule().blocks as usize {
            return Err("has more blocks than it may");
        }
        Ok(())
    }
}
