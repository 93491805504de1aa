//! Sizes of inserted particles relative to their shape: laws by number, drawn as functions of (seed, id).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::InvalidInput;
use crate::random::Draw;

/// Law of the homothety of inserted particles, by number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ScaleSection", into = "ScaleSection")]
pub enum ScaleLaw {
    /// The same density of numbers anywhere in [min, max].
    Uniform {
        /// Smallest factor.
        min: f64,
        /// Largest factor.
        max: f64,
    },
    /// Gaussian, cut at both ends.
    Normal {
        /// Of the law before it is cut.
        mean: f64,
        /// Of the law before it is cut.
        standard_deviation: f64,
        /// Smallest factor.
        min: f64,
        /// Largest factor.
        max: f64,
    },
    /// The logarithm is Gaussian; cut at both ends.
    Lognormal {
        /// Of the law before it is cut.
        median: f64,
        /// Of the natural logarithm, before the law is cut.
        log_standard_deviation: f64,
        /// Smallest factor.
        min: f64,
        /// Largest factor.
        max: f64,
    },
    /// One of several factors.
    Table {
        /// (factor, weight) each; the probability by number is the weight over the sum of weights.
        rows: Vec<[f64; 2]>,
    },
}

/// `scale` as a scene file has it: `min` and `max` alone for a uniform law, or one of the others by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ScaleSection {
    /// Which one.
    #[serde(skip_serializing_if = "ScaleLawName::is_uniform")]
    pub law: ScaleLawName,
    /// Smallest factor: of all laws but `table`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Largest factor: of all laws but `table`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Of `normal`, before it is cut at `min` and `max`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean: Option<f64>,
    /// Of `normal`, before it is cut at `min` and `max`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_deviation: Option<f64>,
    /// Of `lognormal`, before it is cut at `min` and `max`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub median: Option<f64>,
    /// Of `lognormal`: standard deviation of the natural logarithm, before the law is cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log_standard_deviation: Option<f64>,
    /// Of `table`: (factor, weight by number) each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<Vec<[f64; 2]>>,
}

/// Name of a law of sizes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScaleLawName {
    /// Uniform by number in [min, max].
    #[default]
    Uniform,
    /// Gaussian by number, cut at `min` and `max`.
    Normal,
    /// The logarithm is Gaussian by number; cut at `min` and `max`.
    Lognormal,
    /// One of several factors, by weight.
    Table,
}

impl ScaleLawName {
    fn is_uniform(&self) -> bool {
        *self == Self::Uniform
    }
}

impl TryFrom<ScaleSection> for ScaleLaw {
    type Error = String;

    fn try_from(section: ScaleSection) -> Result<Self, String> {
        let law = section.law;
        let numbers = [
            ("min", section.min, law != ScaleLawName::Table),
            ("max", section.max, law != ScaleLawName::Table),
            ("mean", section.mean, law == ScaleLawName::Normal),
            ("standard_deviation", section.standard_deviation, law == ScaleLawName::Normal),
            ("median", section.median, law == ScaleLawName::Lognormal),
            ("log_standard_deviation", section.log_standard_deviation, law == ScaleLawName::Lognormal),
        ];
        for (name, value, belongs) in numbers {
            match value {
                Some(_) if !belongs => return Err(format!("scale.{name} is no part of the law {law:?}")),
                None if belongs => return Err(format!("scale.{name} is missing: the law {law:?} needs it")),
                _ => {}
            }
        }
        let [min, max, mean, standard_deviation, median, log_standard_deviation] =
            numbers.map(|(_, value, _)| value.unwrap_or(f64::NAN));
        match (law, section.table) {
            (ScaleLawName::Table, Some(rows)) => Ok(Self::Table { rows }),
            (ScaleLawName::Table, None) => Err("scale.table is missing: the law Table needs it".into()),
            (_, Some(_)) => Err(format!("scale.table is no part of the law {law:?}")),
            (ScaleLawName::Uniform, None) => Ok(Self::Uniform { min, max }),
            (ScaleLawName::Normal, None) => Ok(Self::Normal { mean, standard_deviation, min, max }),
            (ScaleLawName::Lognormal, None) => Ok(Self::Lognormal { median, log_standard_deviation, min, max }),
        }
    }
}

impl From<ScaleLaw> for ScaleSection {
    fn from(law: ScaleLaw) -> Self {
        let (empty, some) = (Self::default(), Some::<f64>);
        match law {
            ScaleLaw::Uniform { min, max } => Self { min: some(min), max: some(max), ..empty },
            ScaleLaw::Normal { mean, standard_deviation, min, max } => Self {
                law: ScaleLawName::Normal,
                mean: some(mean),
                standard_deviation: some(standard_deviation),
                min: some(min),
                max: some(max),
                ..empty
            },
            ScaleLaw::Lognormal { median, log_standard_deviation, min, max } => Self {
                law: ScaleLawName::Lognormal,
                median: some(median),
                log_standard_deviation: some(log_standard_deviation),
                min: some(min),
                max: some(max),
                ..empty
            },
            ScaleLaw::Table { rows } => Self { law: ScaleLawName::Table, table: Some(rows), ..empty },
        }
    }
}

impl Default for ScaleLaw {
    fn default() -> Self {
        Self::only(1.0)
    }
}

/// Least part of a law that its limits may leave: below it they are mistyped.
const LEAST_PART: f64 = 1e-9;

impl ScaleLaw {
    /// This factor always.
    pub fn only(scale: f64) -> Self {
        Self::Uniform { min: scale, max: scale }
    }

    /// Smallest and largest factor that may be drawn.
    pub fn range(&self) -> [f64; 2] {
        match self {
            Self::Uniform { min, max } | Self::Normal { min, max, .. } | Self::Lognormal { min, max, .. } => {
                [*min, *max]
            }
            Self::Table { rows } => {
                let drawn = || rows.iter().filter(|row| row[1] > 0.0).map(|row| row[0]);
                [drawn().fold(f64::INFINITY, f64::min), drawn().fold(0.0, f64::max)]
            }
        }
    }

    /// The law ready to draw from; the error names the number at `path` that cannot be.
    pub(crate) fn sampler(&self, path: &str) -> Result<ScaleSampler, InvalidInput> {
        match self {
            Self::Uniform { min, max } => {
                if !(*min > 0.0 && min <= max && max.is_finite()) {
                    return Err(InvalidInput::new(path, format!("is [{min}, {max}]; needs 0 < min <= max")));
                }
                Ok(ScaleSampler::Uniform { min: *min, max: *max })
            }
            Self::Normal { mean, standard_deviation, min, max } => {
                let gauss = CutGauss::new([*mean, *standard_deviation], [*min, *max], path)?;
                Ok(ScaleSampler::Normal(gauss))
            }
            Self::Lognormal { median, log_standard_deviation, min, max } => {
                if !(*median > 0.0 && *min > 0.0) {
                    let problem = format!("has median {median} and min {min}; both must be above 0");
                    return Err(InvalidInput::new(path, problem));
                }
                let law = [median.ln(), *log_standard_deviation];
                let gauss = CutGauss::new(law, [min.ln(), max.ln()], path)?;
                Ok(ScaleSampler::Lognormal { gauss, min: *min, max: *max })
            }
            Self::Table { rows } => table_sampler(rows, path),
        }
        .and_then(|sampler| {
            let [min, max] = self.range();
            if min > 0.0 && max.is_finite() {
                return Ok(sampler);
            }
            Err(InvalidInput::new(path, format!("spans [{min}, {max}]; needs finite factors above 0")))
        })
    }
}

fn table_sampler(rows: &[[f64; 2]], path: &str) -> Result<ScaleSampler, InvalidInput> {
    let bad = |k: usize, problem: String| Err(InvalidInput::new(format!("{path}.table[{k}]"), problem));
    let mut sum = 0.0;
    let mut cumulative = Vec::with_capacity(rows.len());
    for (k, &[scale, weight]) in rows.iter().enumerate() {
        if !(scale.is_finite() && scale > 0.0) {
            return bad(k, format!("has factor {scale}; must be finite and above 0"));
        }
        if !(weight.is_finite() && weight >= 0.0) {
            return bad(k, format!("has weight {weight}; must be finite and at least 0"));
        }
        sum += weight;
        cumulative.push((sum, scale));
    }
    if !(sum > 0.0 && sum.is_finite()) {
        return Err(InvalidInput::new(format!("{path}.table"), "needs at least one weight above 0, of a finite sum"));
    }
    Ok(ScaleSampler::Table { cumulative, sum })
}

/// A law of sizes that has been checked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ScaleSampler {
    Uniform { min: f64, max: f64 },
    Normal(CutGauss),
    Lognormal { gauss: CutGauss, min: f64, max: f64 },
    Table { cumulative: Vec<(f64, f64)>, sum: f64 },
}

impl ScaleSampler {
    /// One factor; takes one number of the generator, or none where there is no choice.
    pub fn draw(&self, draw: &mut Draw) -> f64 {
        match self {
            Self::Uniform { min, max } if min == max => *min,
            Self::Uniform { min, max } => draw.between(*min, *max),
            Self::Normal(gauss) => gauss.at(draw.unit()),
            Self::Lognormal { gauss, min, max } => gauss.at(draw.unit()).exp().clamp(*min, *max),
            Self::Table { cumulative, sum } => {
                let at = draw.unit() * sum;
                let row = cumulative.partition_point(|(up_to, _)| *up_to <= at);
                // rounding of the product may reach the sum itself
                cumulative[row.min(cumulative.len() - 1)].1
            }
        }
    }
}

/// A Gaussian between two limits, by its inverse distribution function: as rejection would give, from one number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CutGauss {
    mean: f64,
    deviation: f64,
    /// Limits in standard deviations from the mean; mirrored where both are above it, since the distribution function is
    /// accurate in its lower tail only.
    limits: [f64; 2],
    mirrored: bool,
}

/// Distribution function of the standard Gaussian.
fn below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

impl CutGauss {
    fn new([mean, deviation]: [f64; 2], [min, max]: [f64; 2], path: &str) -> Result<Self, InvalidInput> {
        if !(mean.is_finite() && deviation.is_finite() && deviation > 0.0) {
            let problem = "needs a finite mean (or median) and a standard deviation that is finite and above 0";
            return Err(InvalidInput::new(path, problem));
        }
        if !(min.is_finite() && max.is_finite() && min < max) {
            return Err(InvalidInput::new(path, "needs finite limits, min below max"));
        }
        let limits = [(min - mean) / deviation, (max - mean) / deviation];
        let mirrored = limits[0] > 0.0;
        let limits = if mirrored { [-limits[1], -limits[0]] } else { limits };
        let part = below(limits[1]) - below(limits[0]);
        if part < LEAST_PART {
            let problem = format!("keeps {part:e} of the law between min and max; at least {LEAST_PART:e} is needed");
            return Err(InvalidInput::new(path, problem));
        }
        Ok(Self { mean, deviation, limits, mirrored })
    }

    /// Where the part `u` of the cut law lies below (above, where mirrored), by bisection to the last bit.
    fn at(&self, u: f64) -> f64 {
        let [mut low, mut high] = self.limits;
        let (from, to) = (below(low), below(high));
        let wanted = from + u * (to - from);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if below(middle) <= wanted { low = middle } else { high = middle }
        }
        let z = if self.mirrored { -low } else { low };
        self.mean + self.deviation * z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    fn drawn(law: &ScaleLaw, n: u64) -> Vec<f64> {
        let sampler = law.sampler("scale").unwrap();
        let mut scales: Vec<f64> = (0..n).map(|id| sampler.draw(&mut Draw::new(11, id, Purpose::Scale))).collect();
        scales.sort_unstable_by(f64::total_cmp);
        scales
    }

    /// Largest distance of the empirical distribution from `cdf`; above 2.2/sqrt(n) once in 8000 samples (Kolmogorov).
    fn kolmogorov(scales: &[f64], cdf: impl Fn(f64) -> f64) -> f64 {
        let n = scales.len() as f64;
        scales
            .iter()
            .enumerate()
            .map(|(k, &x)| (cdf(x) - k as f64 / n).abs().max((cdf(x) - (k as f64 + 1.0) / n).abs()))
            .fold(0.0, f64::max)
    }

    const N: u64 = 20_000;

    fn limit() -> f64 {
        2.2 / (N as f64).sqrt()
    }

    #[test]
    fn uniform_law_is_the_one_it_always_was() {
        let law = ScaleLaw::Uniform { min: 0.8, max: 1.2 };
        let sampler = law.sampler("scale").unwrap();
        for id in 0..100 {
            let old = Draw::new(11, id, Purpose::Scale).between(0.8, 1.2);
            assert_eq!(sampler.draw(&mut Draw::new(11, id, Purpose::Scale)).to_bits(), old.to_bits());
        }
        assert!(kolmogorov(&drawn(&law, N), |x| (x - 0.8) / 0.4) < limit());
    }

    #[test]
    fn normal_law_is_cut_and_follows_its_distribution() {
        for (mean, deviation, min, max) in [(1.0, 0.1, 0.8, 1.15), (1.0, 0.05, 0.1, 3.0), (0.5, 0.1, 0.8, 1.5)] {
            let law = ScaleLaw::Normal { mean, standard_deviation: deviation, min, max };
            let scales = drawn(&law, N);
            assert!(scales[0] >= min && scales[scales.len() - 1] <= max);
            let phi = |x: f64| libm::erf((x - mean) / deviation / 2.0f64.sqrt());
            let cdf = |x: f64| (phi(x) - phi(min)) / (phi(max) - phi(min));
            assert!(kolmogorov(&scales, cdf) < limit(), "{law:?}");
            // another law would be told from it
            assert!(kolmogorov(&scales, |x| (x - min) / (max - min)) > 2.0 * limit());
        }
    }

    #[test]
    fn lognormal_law_is_cut_and_follows_its_distribution() {
        let law = ScaleLaw::Lognormal { median: 0.9, log_standard_deviation: 0.3, min: 0.5, max: 2.0 };
        let scales = drawn(&law, N);
        let phi = |x: f64| libm::erf((x / 0.9f64).ln() / 0.3 / 2.0f64.sqrt());
        let cdf = |x: f64| (phi(x) - phi(0.5)) / (phi(2.0) - phi(0.5));
        assert!(scales[0] >= 0.5 && scales[scales.len() - 1] <= 2.0);
        assert!(kolmogorov(&scales, cdf) < limit());
    }

    /// Counts within 4 standard errors of the binomial law.
    #[test]
    fn table_is_drawn_by_weight() {
        let law = ScaleLaw::Table { rows: vec![[0.5, 1.0], [2.0, 0.0], [1.0, 3.0], [1.5, 6.0]] };
        let scales = drawn(&law, N);
        for (scale, p) in [(0.5, 0.1), (2.0, 0.0), (1.0, 0.3), (1.5, 0.6)] {
            let count = scales.iter().filter(|&&s| s == scale).count() as f64;
            let n = N as f64;
            assert!((count - n * p).abs() <= 4.0 * (n * p * (1.0 - p)).sqrt(), "{scale}: {count}");
        }
        assert_eq!(law.range(), [0.5, 1.5]);
    }

    #[test]
    fn bad_laws_are_refused_by_path() {
        let normal = |mean, standard_deviation, min, max| ScaleLaw::Normal { mean, standard_deviation, min, max };
        for law in [
            ScaleLaw::Uniform { min: 0.0, max: 1.0 },
            ScaleLaw::Uniform { min: 2.0, max: 1.0 },
            normal(1.0, 0.0, 0.5, 1.5),
            normal(1.0, 0.1, -0.5, 1.5),
            normal(1.0, 0.1, 1.5, 1.5),
            normal(1.0, 0.1, 5.0, 6.0),
            normal(f64::NAN, 0.1, 0.5, 1.5),
            ScaleLaw::Lognormal { median: 0.0, log_standard_deviation: 0.3, min: 0.5, max: 2.0 },
            ScaleLaw::Table { rows: vec![] },
            ScaleLaw::Table { rows: vec![[1.0, 0.0]] },
            ScaleLaw::Table { rows: vec![[1.0, 1.0], [-1.0, 1.0]] },
        ] {
            assert!(law.sampler("here.scale").is_err_and(|error| error.path.starts_with("here.scale")), "{law:?}");
        }
    }

    #[test]
    fn files_name_the_law_or_give_limits_alone() {
        #[derive(Debug, PartialEq, Serialize, Deserialize)]
        struct File {
            scale: ScaleLaw,
        }
        let read = |text: &str| toml::from_str::<File>(text).map(|file| file.scale);
        assert_eq!(read("scale = { min = 0.9, max = 1.1 }"), Ok(ScaleLaw::Uniform { min: 0.9, max: 1.1 }));
        let laws = [
            ScaleLaw::Uniform { min: 0.9, max: 1.1 },
            ScaleLaw::Normal { mean: 1.0, standard_deviation: 0.1, min: 0.5, max: 1.5 },
            ScaleLaw::Lognormal { median: 1.0, log_standard_deviation: 0.1, min: 0.5, max: 1.5 },
            ScaleLaw::Table { rows: vec![[1.0, 2.0], [3.0, 4.0]] },
        ];
        for law in laws {
            let file = File { scale: law };
            assert_eq!(toml::from_str::<File>(&toml::to_string(&file).unwrap()).unwrap(), file);
        }
        for (text, named) in [
            ("scale = { min = 0.9 }", "scale.max is missing"),
            ("scale = { min = 0.9, max = 1.0, mean = 1.0 }", "scale.mean is no part"),
            ("scale = { law = 'table' }", "scale.table is missing"),
            ("scale = { law = 'gauss', min = 1.0, max = 2.0 }", "gauss"),
        ] {
            assert!(read(text).is_err_and(|error| error.to_string().contains(named)), "{text}");
        }
    }
}
