//! What a study varies: `--vary time_step=x1,x0.5,stiffness,threads` becomes axes, axes become settings.

use serde::Serialize;
use sturz_engine::scene::{Scene, SceneDescription};
use toml::Value;

use crate::commands::Failure;

/// One value of an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Factor {
    /// `x0.5`: times what the scene has.
    Times(f64),
    /// A number in its place.
    Number(f64),
    /// A word in its place.
    Word(String),
}

impl std::fmt::Display for Factor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Factor::Times(factor) => write!(f, "x{factor}"),
            Factor::Number(number) => write!(f, "{number}"),
            Factor::Word(word) => f.write_str(word),
        }
    }
}

impl Factor {
    fn parse(text: &str) -> Result<Self, Failure> {
        let number = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_finite());
        if let Some(factor) = text.strip_prefix('x').and_then(number) {
            return if factor > 0.0 {
                Ok(Factor::Times(factor))
            } else {
                Err(Failure::Usage(format!("--vary: the factor '{text}' must be above 0")))
            };
        }
        Ok(number(text).map_or_else(|| Factor::Word(text.into()), Factor::Number))
    }
}

/// A key and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// `time_step`, `stiffness`, ..., or a path into the scene file.
    pub key: String,
    /// In the order given.
    pub values: Vec<Factor>,
}

/// Keys with a meaning of their own, what they set, and the values that they take when none are given.
const KEYS: &[(&str, &str, &[&str])] = &[
    ("time_step", "time step; in s, or times that of the scene", &["x2", "x1", "x0.5", "x0.25", "x0.125"]),
    (
        "stiffness",
        "stiffness of every pair (Young's moduli under hertz); the time step follows",
        &["x0.25", "x1", "x4", "x16"],
    ),
    ("restitution", "restitution of every pair", &[]),
    ("friction", "sliding friction of every pair", &[]),
    ("rounding", "contact.generalized_overlap.rounding_fraction", &["0.005", "0.01", "0.02", "0.05"]),
    ("law", "contact.normal", &[]),
    ("sharing", "contact.sharing", &["per_point", "model_a", "model_b", "max_overlap_shared"]),
    ("rotation", "integrator.rotation", &["omelyan", "splitting"]),
    ("threads", "threads of the physics", &["1", "2"]),
];

/// `time_step=x1,x0.5,threads=1,2,stiffness`: a word that is a key or has a `=` begins an axis, others are its values.
pub fn parse_axes(texts: &[String]) -> Result<Vec<Axis>, Failure> {
    let mut axes: Vec<Axis> = Vec::new();
    for token in texts.iter().flat_map(|text| text.split(',')).map(str::trim).filter(|token| !token.is_empty()) {
        if let Some((key, value)) = token.split_once('=') {
            axes.push(Axis { key: key.trim().into(), values: vec![Factor::parse(value.trim())?] });
        } else if KEYS.iter().any(|(key, ..)| *key == token) {
            axes.push(Axis { key: token.into(), values: Vec::new() });
        } else if let Some(axis) = axes.last_mut().filter(|axis| !axis.values.is_empty()) {
            axis.values.push(Factor::parse(token)?);
        } else {
            return Err(Failure::Usage(format!("--vary: '{token}' is no key; {}", keys_in_words())));
        }
    }
    for axis in &mut axes {
        if axis.values.is_empty() {
            let defaults = KEYS.iter().find(|(key, ..)| *key == axis.key).map_or(&[][..], |(.., values)| values);
            if defaults.is_empty() {
                return Err(Failure::Usage(format!("--vary: '{}' needs values, as in {0}=0.3,0.6", axis.key)));
            }
            axis.values = defaults.iter().map(|text| Factor::parse(text)).collect::<Result<_, _>>()?;
        }
    }
    if let Some(twice) = (1..axes.len()).find(|&k| axes[..k].iter().any(|axis| axis.key == axes[k].key)) {
        return Err(Failure::Usage(format!("--vary: '{}' is given twice", axes[twice].key)));
    }
    if axes.is_empty() {
        return Err(Failure::Usage(format!("--vary: what? {}", keys_in_words())));
    }
    Ok(axes)
}

/// What `--vary` knows.
pub fn keys_in_words() -> String {
    let keys: Vec<String> = KEYS.iter().map(|(key, what, _)| format!("{key} ({what})")).collect();
    format!(
        "keys are {}, or a path into the scene file with values, as in contact.skin_fraction=0.1,0.3",
        keys.join(", ")
    )
}

/// One point of the grid.
#[derive(Clone, Debug, Serialize)]
pub struct Setting {
    /// Key and value of each axis.
    pub values: Vec<(String, String)>,
    /// Threads of the physics.
    pub threads: usize,
    /// The scene with these values; why it cannot be used, where it cannot.
    #[serde(skip)]
    pub scene: Result<SceneDescription, String>,
    /// Time step that comes out of them, s; 0 where the scene cannot be used.
    pub time_step_s: f64,
}

impl Setting {
    /// The values in one line.
    pub fn label(&self) -> String {
        let parts: Vec<String> = self.values.iter().map(|(key, value)| format!("{key}={value}")).collect();
        parts.join(" ")
    }

    /// The number or factor of a key, where it has one.
    pub fn number_of(&self, key: &str) -> Option<f64> {
        let (_, value) = self.values.iter().find(|(known, _)| known == key)?;
        value.trim_start_matches('x').parse().ok()
    }

    /// The values but for one key, in one line.
    pub fn label_without(&self, without: &str) -> String {
        let others = self.values.iter().filter(|(key, _)| key != without);
        others.map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" ")
    }
}

/// The scene that is varied, with what varying needs to know of it.
pub struct Base<'a> {
    description: &'a SceneDescription,
    time_step_s: f64,
    critical_time_step_s: f64,
    threads: usize,
}

impl<'a> Base<'a> {
    /// Of a scene that is usable.
    pub fn new(description: &'a SceneDescription, threads: usize) -> Result<Self, Failure> {
        let scene = Scene::validate(description.clone())
            .map_err(|problems| Failure::Scene(format!("the scene cannot be used:\n{problems}")))?;
        Ok(Self {
            description,
            time_step_s: scene.time_step_s(),
            critical_time_step_s: scene.check().critical_time_step_s,
            threads,
        })
    }

    /// Every combination of the values, the last axis fastest.
    pub fn grid(&self, axes: &[Axis]) -> Result<Vec<Setting>, Failure> {
        let mut combinations: Vec<Vec<(&str, &Factor)>> = vec![Vec::new()];
        for axis in axes {
            combinations = combinations
                .into_iter()
                .flat_map(|chosen| {
                    axis.values.iter().map(move |value| {
                        let mut chosen = chosen.clone();
                        chosen.push((&axis.key, value));
                        chosen
                    })
                })
                .collect();
        }
        combinations.iter().map(|chosen| self.setting(chosen)).collect()
    }

    /// The scene with these values.
    pub fn setting(&self, chosen: &[(&str, &Factor)]) -> Result<Setting, Failure> {
        let mut tree = Value::try_from(self.description).map_err(anyhow::Error::from)?;
        let mut threads = self.threads;
        let mut time_step = &Factor::Times(1.0);
        let mut law_changes = false;
        for &(key, value) in chosen {
            match key {
                "threads" => threads = whole(key, value)?,
                "time_step" => time_step = value,
                _ => {
                    law_changes = true;
                    set(&mut tree, key, value)?;
                }
            }
        }
        self.set_time_step(&mut tree, time_step, law_changes)?;
        let described: Result<SceneDescription, _> = tree.try_into();
        let scene = described.map_err(|error| error.message().to_string()).and_then(|description| {
            Scene::validate(description.clone())
                .map(|scene| (description, scene.time_step_s()))
                .map_err(|problems| problems.to_string())
        });
        let time_step_s = scene.as_ref().map_or(0.0, |(_, dt)| *dt);
        let values = chosen.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect();
        Ok(Setting { values, threads, scene: scene.map(|(description, _)| description), time_step_s })
    }

    /// A time step relative to the scene's keeps its part of the critical one where the laws are varied too.
    fn set_time_step(&self, tree: &mut Value, value: &Factor, law_changes: bool) -> Result<(), Failure> {
        let (key, number) = match value {
            Factor::Word(word) => return Err(usage("time_step", word, "a number or a factor such as x0.5")),
            Factor::Number(seconds) => ("time_step_s", *seconds),
            Factor::Times(factor) if law_changes && self.critical_time_step_s.is_finite() => {
                ("time_step_fraction", factor * self.time_step_s / self.critical_time_step_s)
            }
            Factor::Times(factor) => ("time_step_s", factor * self.time_step_s),
        };
        let section = table(tree.get_mut("scene").and_then(Value::as_table_mut), "scene")?;
        for other in ["time_step", "time_step_s", "time_step_fraction"] {
            section.remove(other);
        }
        section.insert(key.into(), Value::Float(number));
        Ok(())
    }
}

fn usage(key: &str, value: &str, wanted: &str) -> Failure {
    Failure::Usage(format!("--vary: {key}={value}: must be {wanted}"))
}

fn whole(key: &str, value: &Factor) -> Result<usize, Failure> {
    match value {
        Factor::Number(n) if n.fract() == 0.0 && (1.0..=1024.0).contains(n) => Ok(*n as usize),
        other => Err(usage(key, &other.to_string(), "a whole number from 1 to 1024")),
    }
}

fn table<'t>(table: Option<&'t mut toml::Table>, path: &str) -> Result<&'t mut toml::Table, Failure> {
    table.ok_or_else(|| Failure::Usage(format!("--vary: the scene has no section '{path}'")))
}

/// Sets what a key stands for.
fn set(tree: &mut Value, key: &str, value: &Factor) -> Result<(), Failure> {
    match key {
        "stiffness" => {
            let pairs = set_each(tree, "material_pair", "stiffness_n_per_m", value, false)?;
            let moduli = set_each(tree, "material", "youngs_modulus_pa", value, false)?;
            if pairs + moduli == 0 {
                return Err(Failure::Usage("--vary: no pair of the scene has a stiffness".into()));
            }
            Ok(())
        }
        "restitution" => set_each(tree, "material_pair", "restitution", value, true).map(|_| ()),
        "friction" => set_each(tree, "material_pair", "friction", value, true).map(|_| ()),
        "rounding" => set_path(tree, "contact.generalized_overlap.rounding_fraction", value),
        "law" => set_path(tree, "contact.normal", value),
        "sharing" => set_path(tree, "contact.sharing", value),
        "rotation" => set_path(tree, "integrator.rotation", value),
        path => set_path(tree, path, value),
    }
}

/// Sets a key in every entry of a list, where it is there or `add`; how many.
fn set_each(tree: &mut Value, list: &str, key: &str, value: &Factor, add: bool) -> Result<usize, Failure> {
    let mut n = 0;
    for entry in tree.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten() {
        let entry = table(entry.as_table_mut(), list)?;
        if add || entry.contains_key(key) {
            let present = entry.get(key).cloned();
            entry.insert(key.into(), changed(present.as_ref(), value, key)?);
            n += 1;
        }
    }
    Ok(n)
}

/// The new value in place of the present one, of its type.
fn changed(present: Option<&Value>, value: &Factor, key: &str) -> Result<Value, Failure> {
    let number = match value {
        Factor::Word(word) => return Ok(word.parse().map_or_else(|_| Value::String(word.clone()), Value::Boolean)),
        Factor::Number(number) => *number,
        Factor::Times(factor) => {
            let present = present.and_then(|v| v.as_float().or_else(|| v.as_integer().map(|n| n as f64)));
            let problem = || Failure::Usage(format!("--vary: {key}: the scene has no number there to multiply"));
            factor * present.ok_or_else(problem)?
        }
    };
    Ok(match present {
        Some(Value::Integer(_)) if number.fract() == 0.0 => Value::Integer(number as i64),
        _ => Value::Float(number),
    })
}

/// Sets `a.b[2].c`; tables that are absent are made.
fn set_path(tree: &mut Value, path: &str, value: &Factor) -> Result<(), Failure> {
    let problem = |what: String| Failure::Usage(format!("--vary: path '{path}': {what}; {}", keys_in_words()));
    let (parents, last) = path.rsplit_once('.').ok_or_else(|| problem("is no key and no path".into()))?;
    let mut place = tree;
    for part in parents.split('.') {
        let (name, index) = match part.strip_suffix(']').and_then(|part| part.split_once('[')) {
            Some((name, index)) => {
                (name, Some(index.parse::<usize>().map_err(|_| problem(format!("'{index}' is no index")))?))
            }
            None => (part, None),
        };
        let parent = place.as_table_mut().ok_or_else(|| problem(format!("'{name}' is not in a table")))?;
        place = match index {
            None => parent.entry(name).or_insert_with(|| Value::Table(toml::Table::new())),
            Some(index) => parent
                .get_mut(name)
                .and_then(|list| list.get_mut(index))
                .ok_or_else(|| problem(format!("there is no {name}[{index}]")))?,
        };
    }
    let place = place.as_table_mut().ok_or_else(|| problem(format!("'{parents}' is no table")))?;
    let present = place.get(last).cloned();
    place.insert(last.into(), changed(present.as_ref(), value, path)?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;

    fn axes(text: &str) -> Result<Vec<Axis>, Failure> {
        parse_axes(&[text.into()])
    }

    #[test]
    fn keys_values_and_defaults_are_told_apart() {
        let parsed = axes("time_step=x1,x0.5,threads,law=linear,hertz").unwrap();
        assert_eq!(parsed.len(), 3);
        assert_eq!(parsed[0].values, [Factor::Times(1.0), Factor::Times(0.5)]);
        assert_eq!(parsed[1].values, [Factor::Number(1.0), Factor::Number(2.0)]);
        assert_eq!(parsed[2].values, [Factor::Word("linear".into()), Factor::Word("hertz".into())]);
        for wrong in ["speed", "x0.5", "restitution", "time_step=x0", "threads,threads", ""] {
            assert_eq!(axes(wrong).unwrap_err().exit_code(), 2, "{wrong}");
        }
    }

    #[test]
    fn the_time_step_keeps_its_part_of_the_critical_one_when_the_stiffness_changes() {
        let description = scenes::read("bouncing-sphere").unwrap_or_else(|failure| panic!("{failure}"));
        let base = Base::new(&description, 1).unwrap();
        let grid = base.grid(&axes("stiffness=x1,x4,time_step=x1,x0.5").unwrap()).unwrap();
        let dt: Vec<f64> = grid.iter().map(|setting| setting.time_step_s / base.time_step_s).collect();
        for (dt, expected) in dt.iter().zip([1.0, 0.5, 0.5, 0.25]) {
            assert!((dt / expected - 1.0).abs() < 1e-12, "{dt} {expected}");
        }
    }

    /// What the engine would refuse is a setting that says why.
    #[test]
    fn a_setting_beyond_the_stable_step_is_kept_with_its_reason() {
        let description = scenes::read("bouncing-sphere").unwrap_or_else(|failure| panic!("{failure}"));
        let grid = Base::new(&description, 1).unwrap().grid(&axes("time_step=1").unwrap()).unwrap();
        assert!(grid[0].scene.as_ref().unwrap_err().contains("critical"), "{:?}", grid[0].scene);
    }

    #[test]
    fn paths_reach_into_lists_and_wrong_ones_are_named() {
        let description = scenes::read("drum-spheres").unwrap_or_else(|failure| panic!("{failure}"));
        let base = Base::new(&description, 1).unwrap();
        let set = |text: &str| base.grid(&axes(text)?).map(|grid| grid[0].scene.clone());
        let scene = set("material_pair[0].restitution=0.25").unwrap().unwrap();
        assert_eq!(scene.material_pairs[0].restitution, Some(0.25));
        let scene = set("contact.skin_fraction=0.125").unwrap().unwrap();
        assert_eq!(scene.contact.skin_fraction, Some(0.125));
        assert!(set("material_pair[9].restitution=0.25").unwrap_err().to_string().contains("no material_pair[9]"));
        assert!(set("contact.no_such_key=1").unwrap().unwrap_err().contains("no_such_key"));
    }
}
