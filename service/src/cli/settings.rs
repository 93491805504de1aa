//! Settings of `sturz serve`: flags over environment over the file of `--settings` over defaults.
//!
//! What the file says becomes the default of the flag of the same name, so that one parser checks all of them.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory as _, FromArgMatches as _};
use toml::{Table, Value};

use super::{Arguments, Command};
use crate::config::Limits;

/// What a setting holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Text,
    /// In a file: relative to its folder.
    Path,
    Texts,
    /// `journal_keep` may be a word, too.
    Number,
    Switch,
}

/// Names in the file, with `_` for the `-` of the flags. `limits` is apart: a table.
const SETTINGS: [(&str, Kind); 14] = [
    ("name", Kind::Text),
    ("listen", Kind::Texts),
    ("connect", Kind::Texts),
    ("config", Kind::Path),
    ("tls", Kind::Path),
    ("insecure", Kind::Switch),
    ("metrics", Kind::Text),
    ("journal", Kind::Path),
    ("journal_fsync", Kind::Text),
    ("journal_keep", Kind::Number),
    ("checkpoints", Kind::Path),
    ("checkpoint_every", Kind::Number),
    ("threads", Kind::Number),
    ("paused", Kind::Switch),
];

/// Settings of which the first takes the place of the others.
const EXCLUSIVE: [(&str, &[&str]); 3] =
    [("resume", &["journal", "checkpoints"]), ("journal", &["checkpoints"]), ("checkpoints", &["journal"])];

/// Where a value came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The command line.
    Flag,
    /// The environment.
    Environment,
    /// A file: that of `--settings`, of a limit perhaps that of `--limits`.
    File(PathBuf),
    /// The program.
    Default,
}

impl fmt::Display for Source {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Source::Flag => write!(out, "flag"),
            Source::Environment => write!(out, "environment"),
            Source::File(path) => write!(out, "file {}", path.display()),
            Source::Default => write!(out, "default"),
        }
    }
}

/// A file of settings.
#[derive(Debug, Default)]
struct File {
    path: PathBuf,
    /// As on the command line.
    values: BTreeMap<&'static str, Vec<String>>,
    limits: Table,
}

impl File {
    fn read(path: &Path) -> Result<Self, String> {
        let at = |error: &dyn fmt::Display| format!("--settings {}: {error}", path.display());
        let text = std::fs::read_to_string(path).map_err(|error| at(&error))?;
        Self::of(path, &text)
    }

    fn of(path: &Path, text: &str) -> Result<Self, String> {
        let at = |error: &dyn fmt::Display| format!("--settings {}: {error}", path.display());
        let table: Table = toml::from_str(text).map_err(|error| at(&error))?;
        let mut file = Self { path: path.into(), ..Self::default() };
        for (name, value) in table {
            if let ("limits", Value::Table(limits)) = (name.as_str(), &value) {
                Limits::from_table(limits.clone()).map_err(|error| at(&format!("[limits]: {error:#}")))?;
                file.limits = limits.clone();
                continue;
            }
            let known = SETTINGS.iter().find(|(known, _)| *known == name);
            let &(name, kind) = known.ok_or_else(|| at(&unknown(&name)))?;
            let folder = path.parent().unwrap_or(Path::new(""));
            let texts = texts(kind, &value, folder).ok_or_else(|| at(&wrong(name, kind, &value)))?;
            file.values.insert(name, texts);
        }
        if ["journal", "checkpoints"].iter().all(|name| file.values.contains_key(name)) {
            return Err(at(&"`journal` and `checkpoints` exclude each other: a journal has its own checkpoints"));
        }
        Ok(file)
    }

    /// Leaves out what the command line or the environment excludes.
    fn give_way(&mut self, given: &ArgMatches) {
        for (name, others) in EXCLUSIVE {
            if is_explicit(given, name) {
                self.values.retain(|held, _| !others.contains(held));
            }
        }
    }

    /// The command line with the file's values as defaults.
    fn under(&self, command: clap::Command) -> clap::Command {
        command.mut_subcommand("serve", |mut serve| {
            for (&name, texts) in &self.values {
                // clap holds defaults for as long as the program runs.
                let texts: Vec<&'static str> = texts.iter().map(|text| &*text.clone().leak()).collect();
                serve = serve.mut_arg(name, |flag| flag.default_values(texts));
            }
            serve
        })
    }
}

fn unknown(name: &str) -> String {
    let names: Vec<&str> = SETTINGS.iter().map(|(name, _)| *name).collect();
    format!("there is no setting `{name}`; there are {}, [limits]", names.join(", "))
}

fn wrong(name: &str, kind: Kind, value: &Value) -> String {
    let allowed = match kind {
        Kind::Text | Kind::Path => "a string",
        Kind::Texts => "an array of strings",
        Kind::Number => "a number",
        Kind::Switch => "true or false",
    };
    format!("`{name}` is {value}, must be {allowed}")
}

/// A value as on the command line; nothing where it is of another kind.
fn texts(kind: Kind, value: &Value, folder: &Path) -> Option<Vec<String>> {
    let one = match (kind, value) {
        (Kind::Text, Value::String(text)) => text.clone(),
        (Kind::Number, Value::String(text)) => text.clone(),
        (Kind::Path, Value::String(text)) => folder.join(text).to_str()?.into(),
        (Kind::Number, Value::Integer(number)) => number.to_string(),
        (Kind::Number, Value::Float(number)) => number.to_string(),
        (Kind::Switch, Value::Boolean(is_on)) => is_on.to_string(),
        (Kind::Texts, Value::Array(values)) => {
            return values.iter().map(|value| value.as_str().map(String::from)).collect();
        }
        _ => return None,
    };
    Some(vec![one])
}

fn is_explicit(given: &ArgMatches, name: &str) -> bool {
    matches!(given.value_source(name), Some(ValueSource::CommandLine | ValueSource::EnvVariable))
}

/// Settings as they are in force, each with its source.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effective {
    settings: Vec<(&'static str, Value, Source)>,
    limits: Vec<(String, Value, Source)>,
    /// Limits of the file of `--settings`.
    pub file_limits: Table,
    file: PathBuf,
}

impl Effective {
    fn of(given: &ArgMatches, file: &File) -> Self {
        let mut effective = Self { file_limits: file.limits.clone(), file: file.path.clone(), ..Self::default() };
        for (name, kind) in SETTINGS {
            let source = match given.value_source(name) {
                Some(ValueSource::CommandLine) => Source::Flag,
                Some(ValueSource::EnvVariable) => Source::Environment,
                Some(_) if file.values.contains_key(name) => Source::File(file.path.clone()),
                Some(_) => Source::Default,
                None => continue,
            };
            let texts = given.get_raw(name).into_iter().flatten().map(|text| text.to_string_lossy().into_owned());
            effective.settings.push((name, value(kind, texts.collect()), source));
        }
        effective
    }

    /// What the program chose where nothing was given.
    pub fn choose(&mut self, name: &'static str, value: impl Into<Value>) {
        if self.settings.iter().all(|(known, ..)| *known != name) {
            self.settings.push((name, value.into(), Source::Default));
        }
    }

    /// The limits in force; `asked` are those of the file of `--limits`.
    pub fn note_limits(&mut self, limits: &Limits, asked: (&Table, Option<&Path>)) {
        let in_force = Table::try_from(limits).unwrap_or_default();
        let source = |name: &str| match asked {
            (asked, Some(path)) if asked.contains_key(name) => Source::File(path.into()),
            _ if self.file_limits.contains_key(name) => Source::File(self.file.clone()),
            _ => Source::Default,
        };
        self.limits = in_force.into_iter().map(|(name, value)| (name.clone(), value, source(&name))).collect();
    }

    /// As a file of settings, the sources as comments.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        for (name, value, source) in &self.settings {
            text += &format!("{name} = {value} # {source}\n");
        }
        text += "\n[limits]\n";
        for (name, value, source) in &self.limits {
            text += &format!("{name} = {value} # {source}\n");
        }
        text
    }

    /// Into the log: a line for each setting that somebody made, one for all others.
    pub fn log(&self) {
        let limits = self.limits.iter().map(|(name, value, source)| (format!("limits.{name}"), value, source));
        let settings = self.settings.iter().map(|(name, value, source)| ((*name).to_string(), value, source));
        let (chosen, made): (Vec<_>, Vec<_>) =
            settings.chain(limits).partition(|(_, _, source)| **source == Source::Default);
        for (name, value, source) in made {
            tracing::info!("setting {name} = {value} ({source})");
        }
        let chosen: Vec<String> = chosen.iter().map(|(name, value, _)| format!("{name} = {value}")).collect();
        tracing::info!("settings by default: {}", chosen.join(", "));
    }
}

/// A value of the command line as it would be in a file.
fn value(kind: Kind, mut texts: Vec<String>) -> Value {
    if kind == Kind::Texts {
        return texts.into();
    }
    let text = texts.pop().unwrap_or_default();
    match kind {
        Kind::Switch => Value::Boolean(text == "true"),
        Kind::Number => match (text.parse::<i64>(), text.parse::<f64>()) {
            (Ok(number), _) => number.into(),
            (_, Ok(number)) => number.into(),
            _ => text.into(),
        },
        _ => text.into(),
    }
}

/// What is wrong with the text of a file of settings, before its values are looked at as flags.
pub fn check_file(path: &Path, text: &str) -> Result<(), String> {
    File::of(path, text).map(drop)
}

/// Reads a command line, and the file of settings that it names.
///
/// # Errors
/// What of them cannot be used; also help and version, which end the program.
pub fn parse(words: impl IntoIterator<Item = OsString>) -> Result<Arguments, clap::Error> {
    let words: Vec<OsString> = words.into_iter().collect();
    let given = Arguments::command().try_get_matches_from(&words)?;
    let Some(serve) = given.subcommand_matches("serve") else {
        return Arguments::from_arg_matches(&given);
    };
    let refuse = |text: String| Arguments::command().error(ErrorKind::InvalidValue, text);
    let mut file = match serve.get_one::<PathBuf>("settings") {
        Some(path) => File::read(path).map_err(refuse)?,
        None => File::default(),
    };
    file.give_way(serve);
    // The words alone were right: what is wrong now is in the file.
    let in_file = |error: clap::Error| {
        let text = error.to_string();
        refuse(format!("--settings {}: {}", file.path.display(), text.trim_start_matches("error: ")))
    };
    let all = file.under(Arguments::command()).try_get_matches_from(&words).map_err(in_file)?;
    let mut arguments = Arguments::from_arg_matches(&all)?;
    if let (Command::Serve(options), Some(serve)) = (&mut arguments.command, all.subcommand_matches("serve")) {
        options.effective = Effective::of(serve, &file);
    }
    Ok(arguments)
}
