//! `sturz fields`: coarse-grained fields from the states and contacts of a recording.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::{Context as _, anyhow};
use prost::Message as _;
use sturz_engine::fields::{
    FieldAverage, FieldColumn, FieldDefinition, FieldFrame, FieldKernel, FieldMean, FieldQuantity, FieldSources, Grid,
    compute,
};
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{ContactNetwork, InvalidInput, Snapshot};
use sturz_protocol::convert::{contacts_from_wire, field_definition_from_wire, snapshot_from_wire};
use sturz_protocol::v1;

use crate::cli;
use crate::commands::Failure;
use crate::record::Recording;

/// Writes the fields of each state, or their mean, as CSV.
pub fn fields(options: &cli::Fields) -> Result<(), Failure> {
    let given = given_definition(options)?;
    let mut recording = Recording::open(&options.recording).map_err(anyhow::Error::from)?;
    if !recording.is_finished() {
        tracing::warn!("{}", recording.warning_of_cut());
    }
    let mut reader = StateReader::default();
    let mut work: Option<Work> = None;
    while let Some(message) = recording.read().map_err(anyhow::Error::from)? {
        let payload = message.payload.as_slice();
        match message.topic.message.as_str() {
            "Info" if work.is_none() => {
                let info = v1::Info::decode(payload).map_err(anyhow::Error::from)?;
                work = Some(Work::begin(options, given.clone(), &info)?);
            }
            "Frame" => reader.state(payload)?,
            "ContactFrame" => reader.contacts(payload)?,
            _ => continue,
        }
        if let Some(work) = &mut work {
            work.take(&mut reader)?;
        }
    }
    let work = work.ok_or_else(|| anyhow!("{} does not say which scene it is of", options.recording.display()))?;
    work.finish(&reader)
}

/// The definition of the command line; `None`: one of the recorded simulation.
fn given_definition(options: &cli::Fields) -> Result<Option<FieldDefinition>, Failure> {
    if options.field.is_some() {
        return Ok(None);
    }
    let definition = match (&options.define, &options.grid) {
        (Some(path), _) => read_definition(path)?,
        (None, Some(grid)) => definition_of_flags(options, grid)?,
        (None, None) => return Err(Failure::Usage("one of --grid, --define and --field is needed".into())),
    };
    Ok(Some(definition))
}

fn read_definition(path: &Path) -> Result<FieldDefinition, Failure> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    toml::from_str(&text).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))
}

fn definition_of_flags(options: &cli::Fields, grid: &str) -> Result<FieldDefinition, Failure> {
    let unknown = |name: &String| {
        let known: Vec<&str> = FieldQuantity::ALL.iter().map(|quantity| quantity.name()).collect();
        Failure::Usage(format!("--quantities: there is no {name:?}, but {}", known.join(", ")))
    };
    let quantities = options.quantities.iter().map(|name| FieldQuantity::named(name).ok_or_else(|| unknown(name)));
    let quantities = quantities.collect::<Result<Vec<_>, _>>()?;
    let kernel = FieldKernel::ALL.into_iter().find(|kernel| kernel.name() == options.kernel).ok_or_else(|| {
        let known = FieldKernel::ALL.map(FieldKernel::name).join(", ");
        Failure::Usage(format!("--kernel: there is no {:?}, but {known}", options.kernel))
    })?;
    let [first, more @ ..] = &options.width[..] else {
        return Err(Failure::Usage("--width is needed with --grid".into()));
    };
    Ok(FieldDefinition {
        cutoff_widths: options.cutoff_widths,
        more_widths_m: more.to_vec(),
        kernel,
        wall_correction: options.wall_correction,
        ..FieldDefinition::new("field", read_grid(grid)?, &quantities, *first)
    })
}

/// A grid as `x,y,z:x,y,z:n,n,n`.
fn read_grid(text: &str) -> Result<Grid, Failure> {
    let bad = || Failure::Usage(format!("--grid is {text:?}; must be MIN:MAX:CELLS, such as 0,0,0:0.1,0.1,0.2:1,1,40"));
    let parts: Vec<Vec<&str>> = text.split(':').map(|part| part.split(',').map(str::trim).collect()).collect();
    fn three<T: std::str::FromStr>(part: &[&str]) -> Option<[T; 3]> {
        part.iter().map(|number| number.parse().ok()).collect::<Option<Vec<T>>>()?.try_into().ok()
    }
    let [min, max, cells] = &parts[..] else { return Err(bad()) };
    let grid = (three(min), three(max), three(cells));
    let (Some(min_m), Some(max_m), Some(cells)) = grid else { return Err(bad()) };
    Ok(Grid { min_m, max_m, cells, cylinder: None })
}

/// The last state and the last contacts, which come in either order.
#[derive(Default)]
struct StateReader {
    state: Option<Snapshot>,
    contacts: Option<ContactNetwork>,
    any_contacts: bool,
    states: u64,
}

impl StateReader {
    fn state(&mut self, payload: &[u8]) -> Result<(), Failure> {
        let frame = v1::Frame::decode(payload).map_err(anyhow::Error::from)?;
        // the recorder repeats the last state of a pause
        let step = frame.header.as_ref().map(|header| header.step);
        if self.state.as_ref().map(|state| state.step) != step {
            self.states += 1;
        }
        self.state = Some(snapshot_from_wire(&frame).map_err(anyhow::Error::from)?);
        Ok(())
    }

    fn contacts(&mut self, payload: &[u8]) -> Result<(), Failure> {
        let frame = v1::ContactFrame::decode(payload).map_err(anyhow::Error::from)?;
        self.any_contacts = true;
        self.contacts = Some(contacts_from_wire(&frame).map_err(anyhow::Error::from)?);
        Ok(())
    }
}

/// What is done with the states.
struct Work {
    scene: Scene,
    definition: FieldDefinition,
    mean: Option<FieldMean>,
    table: Table,
    times_s: [f64; 2],
    last_step: Option<u64>,
    done: u64,
}

impl Work {
    fn begin(options: &cli::Fields, given: Option<FieldDefinition>, info: &v1::Info) -> Result<Self, Failure> {
        let scene = SceneDescription::from_toml(&info.scene_toml).map_err(|error| Failure::Scene(error.to_string()))?;
        let scene = Scene::validate(scene).map_err(|error| Failure::Scene(error.to_string()))?;
        let mut definition = match given {
            Some(definition) => definition,
            None => recorded_definition(options.field.as_deref().unwrap_or_default(), info)?,
        };
        // a mean is over recorded states here, not over steps
        definition.average = options.mean.map(|blocks| FieldAverage {
            every_steps: 1,
            samples_per_block: 1,
            blocks,
            window: Default::default(),
            from_time_s: 0.0,
        });
        let bad = |error: InvalidInput| Failure::Usage(error.to_string());
        definition.validate("field").map_err(bad)?;
        definition.check_against(&scene, "field").map_err(bad)?;
        let out: Box<dyn Write> = match &options.out {
            Some(path) => Box::new(File::create(path).with_context(|| path.display().to_string())?),
            None => Box::new(std::io::stdout()),
        };
        let mean = FieldMean::new(&definition);
        let times_s = [options.from, options.to];
        let table = Table { out: BufWriter::new(out), has_head: false };
        Ok(Self { scene, definition, mean, table, times_s, last_step: None, done: 0 })
    }

    /// Samples the state that has come, once its contacts are there too where they are needed.
    fn take(&mut self, reader: &mut StateReader) -> Result<(), Failure> {
        let Some(state) = &reader.state else { return Ok(()) };
        let contacts = reader.contacts.as_ref().filter(|contacts| contacts.step == state.step);
        let is_wanted = state.time_s >= self.times_s[0] && state.time_s <= self.times_s[1];
        if !is_wanted || self.last_step == Some(state.step) || (self.definition.needs_contacts() && contacts.is_none())
        {
            return Ok(());
        }
        let sources = FieldSources::new(&self.scene, state, contacts).map_err(anyhow::Error::from)?;
        match &mut self.mean {
            Some(mean) => mean.add(&sources).map_err(anyhow::Error::from)?,
            None => {
                let frame = compute(&self.definition, &sources).map_err(anyhow::Error::from)?;
                self.table.write(&frame).context("cannot write the table")?;
            }
        }
        self.last_step = Some(state.step);
        self.done += 1;
        Ok(())
    }

    fn finish(mut self, reader: &StateReader) -> Result<(), Failure> {
        if self.definition.needs_contacts() && !reader.any_contacts && reader.states > 0 {
            let quantity = self.definition.quantities.iter().find(|quantity| quantity.needs_contacts());
            let name = quantity.map_or("", |quantity| quantity.name());
            let text = format!(
                "{name} needs contacts, and the recording has none: record them with --topics state,contacts,..."
            );
            return Err(anyhow!(text).into());
        }
        if self.done == 0 {
            let text = match self.definition.needs_contacts() {
                true => {
                    "the recording has no state with the contacts of the same step in that time: give both streams \
                         the same pace, such as state_every_steps and contacts_every_steps in [output]"
                }
                false => "the recording has no state in that time",
            };
            return Err(anyhow!(text).into());
        }
        if let Some(frame) = self.mean.as_ref().and_then(FieldMean::frame) {
            self.table.write(&frame).context("cannot write the table")?;
        }
        self.table.out.flush().context("cannot write the table")?;
        Ok(())
    }
}

fn recorded_definition(name: &str, info: &v1::Info) -> Result<FieldDefinition, Failure> {
    let found = info.fields.iter().find(|field| field.name == name).ok_or_else(|| {
        let known: Vec<&str> = info.fields.iter().map(|field| field.name.as_str()).collect();
        Failure::Usage(format!("--field: the recorded simulation had no field {name:?}, but {known:?}"))
    })?;
    Ok(field_definition_from_wire(found).map_err(anyhow::Error::from)?)
}

/// A table of cells.
struct Table {
    out: BufWriter<Box<dyn Write>>,
    has_head: bool,
}

impl Table {
    fn write(&mut self, frame: &FieldFrame) -> std::io::Result<()> {
        if !self.has_head {
            self.has_head = true;
            let axes = match frame.grid.cylinder {
                Some(_) => "radius_m,angle_rad,height_m",
                None => "x_m,y_m,z_m",
            };
            let names: Vec<String> = frame.columns.iter().flat_map(column_names).collect();
            writeln!(self.out, "time_s,width_m,{axes},{}", names.join(","))?;
        }
        self.cells(frame, frame.width_m, &frame.columns)?;
        frame.more_widths.iter().try_for_each(|more| self.cells(frame, more.width_m, &more.columns))
    }

    fn cells(&mut self, frame: &FieldFrame, width_m: f64, columns: &[FieldColumn]) -> std::io::Result<()> {
        let [nx, ny, nz] = frame.grid.cells.map(|n| n as usize);
        for cell in 0..nx * ny * nz {
            let at = [cell / (ny * nz), cell / nz % ny, cell % nz];
            write!(self.out, "{},{width_m}", frame.time_s)?;
            for (axis, index) in at.into_iter().enumerate() {
                write!(self.out, ",{}", frame.grid.centre(axis, index))?;
            }
            for column in columns {
                for data in std::iter::once(&column.data).chain(&column.standard_error) {
                    for number in &data[cell * column.components..(cell + 1) * column.components] {
                        write!(self.out, ",{number}")?;
                    }
                }
            }
            writeln!(self.out)?;
        }
        Ok(())
    }
}

/// Of the components of a column, and of their errors.
fn column_names(column: &FieldColumn) -> Vec<String> {
    let axes = ["x", "y", "z"];
    let suffixes: Vec<String> = match column.components {
        1 => vec![String::new()],
        3 => axes.iter().map(|a| format!("_{a}")).collect(),
        9 => axes.iter().flat_map(|a| axes.map(|b| format!("_{a}{b}"))).collect(),
        n => (0..n).map(|k| format!("_{k}")).collect(),
    };
    let name = column.quantity.name();
    let names = suffixes.iter().map(|suffix| format!("{name}{suffix}"));
    let errors =
        column.standard_error.iter().flat_map(|_| suffixes.iter().map(|suffix| format!("{name}_error{suffix}")));
    names.chain(errors).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_read_from_three_triples() {
        let grid = read_grid("0,0,0.5: 1,2e-1,3:1,1,40").unwrap();
        assert_eq!((grid.min_m, grid.max_m, grid.cells), ([0.0, 0.0, 0.5], [1.0, 0.2, 3.0], [1, 1, 40]));
        for bad in ["", "0,0,0:1,1,1", "0,0,0:1,1,1:1,1", "0,0,0:1,1,1:1,1,-4", "a,0,0:1,1,1:1,1,1"] {
            assert!(matches!(read_grid(bad), Err(Failure::Usage(text)) if text.contains("MIN:MAX:CELLS")), "{bad}");
        }
    }
}
