//! What streams hold, and when: checked at the border, defined on the physics thread.

use std::sync::Arc;

use sturz_engine::fields::FieldQuantity;
use sturz_engine::scene::Pace;
use sturz_engine::{ContactColumn, ContactNetwork, FloatType, ParticleColumn, Snapshot};
use sturz_protocol::convert::{self, float_from_wire, float_to_wire, pace_from_wire, pace_to_wire, quantity_name};
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::order::{error, invalid};
use crate::outbox::Outbox;
use crate::runner::Runner;

/// Columns of a stream, and the type of their floats.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice<C> {
    /// Of a field none: all of them.
    pub columns: Arc<[C]>,
    /// Of floating-point columns.
    pub float: FloatType,
}

/// What a stream hands out, and how it is to be encoded.
#[derive(Clone, Debug)]
pub struct Sample<T, C> {
    /// Copied from the engine.
    pub data: T,
    /// As it was defined then.
    pub choice: Choice<C>,
}

/// A used sample, if there is one, to be filled anew.
pub fn refilled<T: Default, C>(spare: Option<Box<Sample<T, C>>>, choice: &Choice<C>) -> Box<Sample<T, C>> {
    let choice = Choice { columns: Arc::clone(&choice.columns), float: choice.float };
    match spare {
        Some(mut sample) => {
            sample.choice = choice;
            sample
        }
        None => Box::new(Sample { data: T::default(), choice }),
    }
}

/// Of the state.
pub type StateSample = Sample<Snapshot, ParticleColumn>;
/// Of the contact network.
pub type ContactSample = Sample<ContactNetwork, ContactColumn>;

/// A checked definition of a stream; what is `None` is as in the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputOrder {
    /// Which stream, and which of its columns.
    pub stream: StreamColumns,
    /// Of floating-point columns.
    pub float: Option<FloatType>,
    /// When.
    pub pace: Option<Pace>,
}

/// A stream and the columns chosen of it.
#[derive(Clone, Debug, PartialEq)]
pub enum StreamColumns {
    /// `state/frame`
    State(Option<Vec<ParticleColumn>>),
    /// `contacts/frame`
    Contacts(Option<Vec<ContactColumn>>),
    /// `report`
    Report,
    /// `field/<name>`
    Field(String, Vec<FieldQuantity>),
}

impl OutputOrder {
    /// Checks what a client asks for.
    pub fn read(request: &v1::DefineOutputRequest) -> Result<Self, v1::Error> {
        let wire = request.output.as_ref();
        Self::of(wire.ok_or_else(|| error(v1::ErrorCode::InvalidInput, "output", "is missing"))?)
    }

    fn of(wire: &v1::OutputDefinition) -> Result<Self, v1::Error> {
        let stream = stream_columns(wire)?;
        let float = float_from_wire(wire.float_type).ok_or_else(|| {
            let text = format!("is {}, must be F64 or F32", wire.float_type);
            error(v1::ErrorCode::InvalidInput, "output.float_type", text)
        })?;
        let is_given = wire.float_type != v1::DataType::Unspecified as i32;
        if is_given && stream == StreamColumns::Report {
            return Err(error(v1::ErrorCode::InvalidInput, "output.float_type", "is not for reports"));
        }
        let pace = wire.pace.as_ref().map(pace_from_wire).transpose().map_err(invalid)?;
        Ok(Self { stream, float: is_given.then_some(float), pace })
    }
}

fn stream_columns(wire: &v1::OutputDefinition) -> Result<StreamColumns, v1::Error> {
    let no_column = |at: usize, known: Vec<&str>| {
        let text = format!("is {:?}: no column of {:?}, which has {known:?}", wire.columns[at], wire.stream);
        error(v1::ErrorCode::NotFound, &format!("output.columns[{at}]"), text)
    };
    let is_given = !wire.columns.is_empty();
    match wire.stream.as_str() {
        "state" => {
            let known = || ParticleColumn::ALL.iter().map(|column| column.name()).collect();
            let columns = ParticleColumn::select(&wire.columns).map_err(|at| no_column(at, known()))?;
            Ok(StreamColumns::State(is_given.then_some(columns)))
        }
        "contacts" => {
            let known = || ContactColumn::ALL.iter().map(|column| column.name()).collect();
            let columns = ContactColumn::select(&wire.columns).map_err(|at| no_column(at, known()))?;
            Ok(StreamColumns::Contacts(is_given.then_some(columns)))
        }
        "report" if is_given => {
            Err(error(v1::ErrorCode::InvalidInput, "output.columns", "are not for reports: they have none"))
        }
        "report" => Ok(StreamColumns::Report),
        other => match other.strip_prefix("field/") {
            Some(name) => {
                let known = || FieldQuantity::ALL.map(|quantity| quantity_name(quantity).0).to_vec();
                let mut chosen = Vec::new();
                for (at, column) in wire.columns.iter().enumerate().filter(|(_, column)| *column != "all") {
                    let found = FieldQuantity::ALL.into_iter().find(|&quantity| quantity_name(quantity).0 == column);
                    chosen.push(found.ok_or_else(|| no_column(at, known()))?);
                }
                let all = wire.columns.iter().any(|column| column == "all");
                Ok(StreamColumns::Field(name.into(), if all { Vec::new() } else { chosen }))
            }
            None => {
                let text = format!("is {other:?}, must be \"state\", \"contacts\", \"report\" or \"field/<name>\"");
                Err(error(v1::ErrorCode::InvalidInput, "output.stream", text))
            }
        },
    }
}

/// Columns and float type of a query such as `state/latest?columns=a|b;float=f32`.
pub struct Chosen<C> {
    /// The usual ones where none are named.
    pub columns: Vec<C>,
    /// F64 where none is named.
    pub float: FloatType,
}

/// What a query chooses: `select` names columns, `usual` are those of a query that names none.
pub fn choose<C>(
    [columns, float]: [Option<&str>; 2],
    select: impl Fn(&[&str]) -> Result<Vec<C>, usize>,
    usual: impl Fn() -> Vec<C>,
) -> Result<Chosen<C>, v1::Error> {
    let columns = match columns {
        None | Some("") => usual(),
        Some(list) => {
            let names: Vec<&str> = list.split('|').collect();
            select(&names)
                .map_err(|at| error(v1::ErrorCode::NotFound, "columns", format!("{:?} is no column", names[at])))?
        }
    };
    let float = match float {
        None | Some("f64") => FloatType::F64,
        Some("f32") => FloatType::F32,
        Some(other) => {
            let text = format!("is {other:?}: f64 or f32 are possible");
            return Err(error(v1::ErrorCode::NotFound, "float", text));
        }
    };
    Ok(Chosen { columns, float })
}

impl Runner<'_> {
    /// Defines a stream anew, for all who subscribe to it.
    pub(crate) fn define_output(&mut self, order: OutputOrder) -> Result<Wire, v1::Error> {
        let definition = self.outbox.define_output(order)?;
        self.revision += 1;
        self.announce_event(v1::Event {
            kind: v1::EventKind::Output.into(),
            severity: v1::Severity::Info.into(),
            message: format!("the output {:?} was defined", definition.stream),
            name: definition.stream.clone(),
            output: Some(definition),
            ..v1::Event::default()
        });
        Ok(Wire::Applied(v1::Applied {}))
    }
}

impl Outbox {
    /// Sets columns, type and pace of a stream, and returns what it is now.
    fn define_output(&mut self, order: OutputOrder) -> Result<v1::OutputDefinition, v1::Error> {
        let OutputOrder { stream, float, pace } = order;
        let scene = &self.scene;
        match stream {
            StreamColumns::State(columns) => {
                self.state.set_pace(pace.unwrap_or(scene.state_pace()));
                let columns = columns.map(Arc::from);
                let given = state_choice(scene);
                self.state_choice =
                    Choice { columns: columns.unwrap_or(given.columns), float: float.unwrap_or(given.float) };
                Ok(self.state_output())
            }
            StreamColumns::Contacts(columns) => {
                self.contacts.set_pace(pace.unwrap_or(scene.contacts_pace()));
                let columns = columns.map(Arc::from);
                let given = contacts_choice(scene);
                self.contacts_choice =
                    Choice { columns: columns.unwrap_or(given.columns), float: float.unwrap_or(given.float) };
                Ok(self.contacts_output())
            }
            StreamColumns::Report => {
                self.report.set_pace(pace.unwrap_or(scene.report_pace()));
                Ok(self.report_output())
            }
            StreamColumns::Field(name, columns) => {
                let pace = pace.unwrap_or(scene.field_pace());
                let found = self.fields.iter_mut().find(|field| field.definition.name == name);
                let Some(field) = found else {
                    let text = format!("no field {name:?} is defined");
                    return Err(error(v1::ErrorCode::NotFound, "output.stream", text));
                };
                if let Some(at) = columns.iter().position(|column| !field.definition.quantities.contains(column)) {
                    let text = format!("is {:?}, which the field does not have", quantity_name(columns[at]).0);
                    return Err(error(v1::ErrorCode::NotFound, &format!("output.columns[{at}]"), text));
                }
                field.stream.set_pace(pace);
                field.choice = Choice { columns: columns.into(), float: float.unwrap_or_default() };
                Ok(field.output())
            }
        }
    }

    /// Defines streams as they were told by [`Outbox::outputs`].
    pub fn restore_outputs(&mut self, outputs: &[v1::OutputDefinition]) -> Result<(), v1::Error> {
        for output in outputs {
            self.define_output(OutputOrder::of(output)?)?;
        }
        Ok(())
    }

    /// All streams as they are defined now, for `info`.
    pub fn outputs(&self) -> Vec<v1::OutputDefinition> {
        let fields = self.fields.iter().map(crate::outbox::FieldStream::output);
        [self.state_output(), self.contacts_output(), self.report_output()].into_iter().chain(fields).collect()
    }

    fn state_output(&self) -> v1::OutputDefinition {
        let names = self.state_choice.columns.iter().map(|column| column.name());
        definition("state".into(), names, self.state_choice.float, self.state.pace())
    }

    fn contacts_output(&self) -> v1::OutputDefinition {
        let names = self.contacts_choice.columns.iter().map(|column| column.name());
        definition("contacts".into(), names, self.contacts_choice.float, self.contacts.pace())
    }

    fn report_output(&self) -> v1::OutputDefinition {
        let none = v1::DataType::Unspecified.into();
        let whole = definition("report".into(), std::iter::empty(), FloatType::F64, self.report.pace());
        v1::OutputDefinition { float_type: none, ..whole }
    }
}

impl crate::outbox::FieldStream {
    fn output(&self) -> v1::OutputDefinition {
        let chosen =
            if self.choice.columns.is_empty() { &self.definition.quantities[..] } else { &self.choice.columns };
        let names = chosen.iter().map(|&quantity| quantity_name(quantity).0);
        definition(format!("field/{}", self.definition.name), names, self.choice.float, self.stream.pace())
    }
}

fn definition<'n>(
    stream: String,
    columns: impl Iterator<Item = &'n str>,
    float: FloatType,
    pace: Pace,
) -> v1::OutputDefinition {
    v1::OutputDefinition {
        stream,
        columns: columns.map(String::from).collect(),
        float_type: float_to_wire(float).into(),
        pace: Some(pace_to_wire(pace)),
    }
}

/// Of the scene.
pub fn state_choice(scene: &sturz_engine::scene::OutputSection) -> Choice<ParticleColumn> {
    let given = scene.state_columns.as_deref().map(ParticleColumn::with_keys);
    Choice { columns: given.unwrap_or_else(ParticleColumn::usual).into(), float: scene.state_float_type }
}

/// Of the scene.
pub fn contacts_choice(scene: &sturz_engine::scene::OutputSection) -> Choice<ContactColumn> {
    let given = scene.contacts_columns.as_deref().map(ContactColumn::with_keys);
    Choice { columns: given.unwrap_or_else(ContactColumn::usual).into(), float: scene.contacts_float_type }
}

/// Frames for the wire.
pub fn encode_state(sample: &StateSample, header: v1::Header) -> v1::Frame {
    convert::frame_to_wire(&sample.data, &sample.choice.columns, sample.choice.float, header)
}

/// Contacts for the wire.
pub fn encode_contacts(sample: &ContactSample, header: v1::Header) -> v1::ContactFrame {
    convert::contacts_to_wire(&sample.data, &sample.choice.columns, sample.choice.float, header)
}

#[cfg(test)]
mod tests {
    use super::*;
    use v1::output_definition::Pace as WirePace;

    fn read(output: v1::OutputDefinition) -> Result<OutputOrder, (v1::ErrorCode, String)> {
        let request = v1::DefineOutputRequest { header: None, output: Some(output) };
        OutputOrder::read(&request).map_err(|error| (error.code(), error.path))
    }

    fn output(stream: &str, columns: &[&str]) -> v1::OutputDefinition {
        let columns = columns.iter().map(ToString::to_string).collect();
        v1::OutputDefinition { stream: stream.into(), columns, ..Default::default() }
    }

    #[test]
    fn bad_definitions_are_refused_with_their_path() {
        use v1::ErrorCode::{InvalidInput, NotFound};
        assert_eq!(OutputOrder::read(&Default::default()).unwrap_err().path, "output");
        let pace = Some(WirePace::EverySteps(0));
        for (wire, code, path) in [
            (output("", &[]), InvalidInput, "output.stream"),
            (output("states", &[]), InvalidInput, "output.stream"),
            (output("state", &["ids", "colour"]), NotFound, "output.columns[1]"),
            (output("contacts", &["positions"]), NotFound, "output.columns[0]"),
            (output("field/f", &["density", "forces"]), NotFound, "output.columns[1]"),
            (output("report", &["energy"]), InvalidInput, "output.columns"),
            (v1::OutputDefinition { float_type: 3, ..output("state", &[]) }, InvalidInput, "output.float_type"),
            (v1::OutputDefinition { float_type: 2, ..output("report", &[]) }, InvalidInput, "output.float_type"),
            (v1::OutputDefinition { pace, ..output("state", &[]) }, InvalidInput, "output.every_steps"),
        ] {
            assert_eq!(read(wire).unwrap_err(), (code, path.to_string()));
        }
    }

    #[test]
    fn what_is_absent_is_left_to_the_scene() {
        let order = read(output("state", &[])).unwrap();
        assert_eq!(order, OutputOrder { stream: StreamColumns::State(None), float: None, pace: None });
        let wire = v1::OutputDefinition {
            float_type: v1::DataType::F32.into(),
            pace: Some(WirePace::EverySimS(0.5)),
            ..output("contacts", &["points"])
        };
        let order = read(wire).unwrap();
        let columns = vec![ContactColumn::Ids, ContactColumn::Boundaries, ContactColumn::Points];
        assert_eq!(order.stream, StreamColumns::Contacts(Some(columns)));
        assert_eq!((order.float, order.pace), (Some(FloatType::F32), Some(Pace::Simulated { every_s: 0.5 })));
    }

    #[test]
    fn a_query_names_its_columns() {
        use ParticleColumn::{Forces, Ids, Velocities};
        let choose =
            |columns, float| choose([columns, float], |names| ParticleColumn::select(names), ParticleColumn::usual);
        assert_eq!(choose(Some("velocities|forces"), None).unwrap().columns, [Ids, Velocities, Forces]);
        assert_eq!(choose(Some("all"), None).unwrap().columns, ParticleColumn::ALL);
        let plain = choose(None, Some("f32")).unwrap();
        assert_eq!((plain.columns, plain.float), (ParticleColumn::usual(), FloatType::F32));
        let refused = choose(Some("velocities|colour"), None).err().unwrap();
        assert_eq!((refused.code(), refused.path.as_str()), (v1::ErrorCode::NotFound, "columns"));
        assert!(refused.message.contains("colour"));
        assert_eq!(choose(None, Some("f16")).err().unwrap().path, "float");
    }
}
