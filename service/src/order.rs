//! From a request on the wire to an order for the physics thread: validation once, at the border.

use prost::bytes::Bytes;
use sturz_engine::fields::FieldDefinition;
use sturz_engine::scene::{InsertionDescription, Placement};
use sturz_engine::{
    Command, FloatType, FluidDescription, FluidFields, InvalidInput, LoadDescription, MeshDescription, ParticleColumn,
};
use sturz_protocol::convert::{self, Start, float_from_wire};
use sturz_protocol::keys::{MAX_NAME_BYTES, Verb, check_name};
use sturz_protocol::{Request, v1};
use xxhash_rust::xxh3::Xxh3Default;

use crate::config::Limits;
use crate::output::OutputOrder;

/// Which request of which client.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct RequestKey {
    /// As the client calls itself.
    pub client_id: String,
    /// Empty: not remembered.
    pub request_id: String,
}

/// A checked command.
#[derive(Clone, Debug)]
pub struct Order {
    /// Who asks.
    pub key: RequestKey,
    /// Which command.
    pub verb: Verb,
    /// As it came.
    pub request: Bytes,
    /// Of command and payload: a reused request id shows.
    pub fingerprint: u64,
    /// Not before this simulated time.
    pub at_time_s: Option<f64>,
    /// What to do.
    pub body: Body,
}

/// What an order asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// A change of the engine's state.
    Change(Command),
    /// Stop stepping.
    Pause,
    /// Step freely.
    Resume,
    /// Some steps, then a reply.
    Step {
        /// At least 1.
        steps: u64,
    },
    /// A window, then a reply with data.
    Advance {
        /// Where the client believes the engine to be.
        start: Start,
        /// Length.
        window_s: f64,
        /// Data for the reply.
        outputs: Outputs,
        /// Instead of those before.
        loads: Option<Box<LoadDescription>>,
        /// Instead of those before, of the fluid.
        fluid: Option<Box<FluidFields>>,
    },
    /// Define or replace a field.
    DefineField(FieldDefinition),
    /// Forget a field.
    DropField {
        /// Its name.
        name: String,
    },
    /// Set columns, type and pace of a stream.
    DefineOutput(OutputOrder),
    /// Save the state.
    Checkpoint {
        /// Empty: to be made.
        token: String,
        /// As a file, else in memory.
        on_disk: bool,
    },
    /// Go to a saved state.
    Restore {
        /// Which.
        token: String,
    },
    /// Name the saved states.
    ListCheckpoints,
    /// Forget a saved state.
    DropCheckpoint {
        /// Which.
        token: String,
    },
    /// Let nobody else advance.
    AcquireLease {
        /// Who asks.
        client: String,
    },
    /// Let others advance again.
    ReleaseLease {
        /// Who asks.
        client: String,
    },
    /// End the daemon.
    Stop,
}

/// Data asked for with a reply.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outputs {
    /// `None`: no frame.
    pub columns: Option<Vec<ParticleColumn>>,
    /// Of the frame.
    pub float: FloatType,
    /// Names of fields.
    pub fields: Vec<String>,
    /// The contact network.
    pub contacts: bool,
    /// What a fluid gets.
    pub exchange: bool,
}

/// A refusal at the border: who asked, as far as that could be read, and why it was refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Who asks.
    pub key: RequestKey,
    /// Why not.
    pub error: v1::Error,
}

/// An error of this kind.
pub fn error(code: v1::ErrorCode, path: &str, message: impl Into<String>) -> v1::Error {
    v1::Error { code: code.into(), path: path.into(), message: message.into() }
}

/// An input that cannot be used.
pub fn invalid(input: InvalidInput) -> v1::Error {
    error(v1::ErrorCode::InvalidInput, &input.path, input.problem)
}

impl Order {
    /// Decodes and checks what came in under the key of `verb`. The bytes are kept for the journal.
    pub fn read(verb: Verb, bytes: Bytes, limits: &Limits) -> Result<Self, Refusal> {
        let nobody = RequestKey::default();
        if bytes.len() > limits.message_bytes {
            let most = limits.message_bytes;
            let text = format!("{} bytes, at most {most} are allowed (limit `message_bytes`)", bytes.len());
            return Err(Refusal { key: nobody, error: error(v1::ErrorCode::TooLarge, "", text) });
        }
        let request = Request::decode(verb, bytes.clone()).map_err(|problem| {
            let text = format!("no {} request: {problem}", verb.name());
            Refusal { key: nobody, error: error(v1::ErrorCode::Undecodable, "", text) }
        })?;
        let header = request.header().cloned().unwrap_or_default();
        let key = RequestKey { client_id: header.client_id, request_id: header.request_id };
        let checked =
            check_key(&key).and_then(|()| check_time(verb, header.at_time_s)).and_then(|()| body(&request, limits));
        match checked {
            Ok(body) => {
                let fingerprint = fingerprint(verb, &bytes);
                Ok(Self { key, verb, request: bytes, fingerprint, at_time_s: header.at_time_s, body })
            }
            Err(error) => Err(Refusal { key, error }),
        }
    }
}

fn fingerprint(verb: Verb, bytes: &[u8]) -> u64 {
    let mut hasher = Xxh3Default::new();
    hasher.update(verb.name().as_bytes());
    hasher.update(bytes);
    hasher.digest()
}

fn check_key(key: &RequestKey) -> Result<(), v1::Error> {
    for (path, id) in [("header.client_id", &key.client_id), ("header.request_id", &key.request_id)] {
        if id.len() > MAX_NAME_BYTES {
            let text = format!("has {} bytes, at most {MAX_NAME_BYTES} are allowed", id.len());
            return Err(error(v1::ErrorCode::InvalidInput, path, text));
        }
    }
    Ok(())
}

/// Commands that cannot wait for a simulated time.
const AT_ONCE: [Verb; 10] = [
    Verb::Pause,
    Verb::Resume,
    Verb::Step,
    Verb::Advance,
    Verb::Restore,
    Verb::ListCheckpoints,
    Verb::DropCheckpoint,
    Verb::AcquireLease,
    Verb::ReleaseLease,
    Verb::Stop,
];

fn check_time(verb: Verb, at_time_s: Option<f64>) -> Result<(), v1::Error> {
    let refuse = |text: String| Err(error(v1::ErrorCode::InvalidInput, "header.at_time_s", text));
    match at_time_s {
        Some(time) if !time.is_finite() => refuse(format!("is {time}, must be finite")),
        Some(_) if AT_ONCE.contains(&verb) => refuse(format!("is not for {}: it takes effect at once", verb.name())),
        _ => Ok(()),
    }
}

fn body(request: &Request, limits: &Limits) -> Result<Body, v1::Error> {
    match request {
        Request::Insert(request) => {
            let insertion = convert::insertion_from_wire(request).map_err(invalid)?;
            check_insertion(&insertion, limits)?;
            Ok(Body::Change(Command::Insert(insertion)))
        }
        Request::Remove(request) => Ok(Body::Change(Command::Remove(request.ids.clone()))),
        Request::SetGravity(request) => {
            let gravity = convert::gravity_from_wire(request).map_err(invalid)?;
            Ok(Body::Change(Command::SetGravity(gravity)))
        }
        Request::SetMotion(request) => {
            let motion = convert::motion_from_wire(request).map_err(invalid)?;
            Ok(Body::Change(Command::SetMotion { boundary: request.boundary.clone(), motion }))
        }
        Request::SetLoads(request) => {
            let loads = request.loads.as_ref();
            let loads = loads.ok_or_else(|| error(v1::ErrorCode::InvalidInput, "loads", "is missing"))?;
            Ok(Body::Change(Command::SetLoads(convert::loads_from_wire(loads, "loads").map_err(invalid)?)))
        }
        Request::SetFluid(request) => {
            let fluid = request.fluid.as_ref().map(|fluid| convert::fluid_from_wire(fluid, "fluid"));
            let fluid = fluid.transpose().map_err(invalid)?;
            check_mesh(fluid.as_ref(), limits)?;
            let fields = request.fields.as_ref().map(|fields| convert::fluid_fields_from_wire(fields, "fields"));
            let fields = fields.transpose().map_err(invalid)?.map(Box::new);
            Ok(Body::Change(Command::SetFluid { fluid: fluid.map(Box::new), fields }))
        }
        Request::Pause(_) => Ok(Body::Pause),
        Request::Resume(_) => Ok(Body::Resume),
        Request::Step(request) if request.steps == 0 => {
            Err(error(v1::ErrorCode::InvalidInput, "steps", "is 0, must be at least 1"))
        }
        Request::Step(request) => Ok(Body::Step { steps: request.steps }),
        Request::Advance(request) => advance_body(request),
        Request::DefineField(request) => define_field_body(request, limits),
        Request::DropField(request) => Ok(Body::DropField { name: request.name.clone() }),
        Request::DefineOutput(request) => OutputOrder::read(request).map(Body::DefineOutput),
        Request::Checkpoint(request) => {
            let token = if request.token.is_empty() { String::new() } else { token(&request.token)? };
            Ok(Body::Checkpoint { token, on_disk: request.on_disk })
        }
        Request::Restore(request) => Ok(Body::Restore { token: token(&request.token)? }),
        Request::ListCheckpoints(_) => Ok(Body::ListCheckpoints),
        Request::DropCheckpoint(request) => Ok(Body::DropCheckpoint { token: token(&request.token)? }),
        Request::AcquireLease(_) => Ok(Body::AcquireLease { client: client(request) }),
        Request::ReleaseLease(_) => Ok(Body::ReleaseLease { client: client(request) }),
        Request::Stop(_) => Ok(Body::Stop),
    }
}

fn client(request: &Request) -> String {
    request.header().map_or_else(String::new, |header| header.client_id.clone())
}

/// It may become the name of a file.
fn token(name: &str) -> Result<String, v1::Error> {
    let checked = check_name(name).map_err(|problem| error(v1::ErrorCode::InvalidInput, "token", problem.to_string()));
    checked.map(|()| name.into())
}

fn advance_body(request: &v1::AdvanceRequest) -> Result<Body, v1::Error> {
    let start = convert::advance_start(request).map_err(invalid)?;
    let window_s = request.window_s;
    if !(window_s.is_finite() && window_s > 0.0) {
        let text = format!("is {window_s}, must be positive and finite");
        return Err(error(v1::ErrorCode::InvalidInput, "window_s", text));
    }
    let outputs = request.outputs.as_ref().map_or(Ok(Outputs::default()), outputs)?;
    let loads = request.loads.as_ref().map(|loads| convert::loads_from_wire(loads, "loads"));
    let loads = loads.transpose().map_err(invalid)?.map(Box::new);
    let fluid = request.fluid.as_ref().map(|fields| convert::fluid_fields_from_wire(fields, "fluid"));
    let fluid = fluid.transpose().map_err(invalid)?.map(Box::new);
    Ok(Body::Advance { start, window_s, outputs, loads, fluid })
}

fn outputs(wire: &v1::Outputs) -> Result<Outputs, v1::Error> {
    let columns = ParticleColumn::select(&wire.columns).map_err(|at| {
        let text = format!("is {:?}: no such column", wire.columns[at]);
        error(v1::ErrorCode::NotFound, &format!("outputs.columns[{at}]"), text)
    })?;
    let float = float_from_wire(wire.float_type).ok_or_else(|| {
        let text = format!("is {}, must be F64 or F32", wire.float_type);
        error(v1::ErrorCode::InvalidInput, "outputs.float_type", text)
    })?;
    let columns = (!wire.columns.is_empty()).then_some(columns);
    Ok(Outputs { columns, float, fields: wire.fields.clone(), contacts: wire.contacts, exchange: wire.exchange })
}

fn define_field_body(request: &v1::DefineFieldRequest, limits: &Limits) -> Result<Body, v1::Error> {
    let field = request.field.as_ref();
    let field = field.ok_or_else(|| error(v1::ErrorCode::InvalidInput, "field", "is missing"))?;
    let definition = convert::field_definition_from_wire(field).map_err(invalid)?;
    check_name(&definition.name)
        .map_err(|problem| error(v1::ErrorCode::InvalidInput, "field.name", problem.to_string()))?;
    let cells = definition.grid.cells.iter().map(|&cells| u64::from(cells)).fold(1, u64::saturating_mul);
    if cells > limits.field_cells {
        let most = limits.field_cells;
        let text = format!("is a grid of {cells} cells, at most {most} are allowed (limit `field_cells`)");
        return Err(error(v1::ErrorCode::TooLarge, "field.grid", text));
    }
    Ok(Body::DefineField(definition))
}

/// The mesh of a fluid is one of a field's size at most.
fn check_mesh(fluid: Option<&FluidDescription>, limits: &Limits) -> Result<(), v1::Error> {
    let (path, cells) = match fluid.and_then(|fluid| fluid.mesh.as_ref()) {
        Some(MeshDescription::Structured { counts, .. }) => {
            ("fluid.structured", counts.iter().map(|&count| u64::from(count)).fold(1, u64::saturating_mul))
        }
        Some(MeshDescription::Points { points_m, .. }) => ("fluid.points", points_m.len() as u64),
        None => return Ok(()),
    };
    if cells > limits.field_cells {
        let most = limits.field_cells;
        let text = format!("is a mesh of {cells} cells, at most {most} are allowed (limit `field_cells`)");
        return Err(error(v1::ErrorCode::TooLarge, path, text));
    }
    Ok(())
}

/// Attempts per particle of a random insertion, fifty times what is usual: the last particle may need all of them, and
/// nothing else is done meanwhile.
const MOST_ATTEMPTS: u32 = 100_000;

/// Refuses what is too much before anything is allocated for it.
fn check_insertion(insertion: &InsertionDescription, limits: &Limits) -> Result<(), v1::Error> {
    if let Placement::Random { attempts, .. } = insertion.placement
        && attempts > MOST_ATTEMPTS
    {
        let text = format!("is {attempts}, at most {MOST_ATTEMPTS} are allowed");
        return Err(error(v1::ErrorCode::InvalidInput, "placement.random.attempts", text));
    }
    let (path, count) = match &insertion.placement {
        Placement::Poses { positions_m, .. } => ("placement.poses.positions_m", positions_m.len() as u64),
        Placement::Lattice { counts, .. } => {
            let count = counts.iter().map(|&count| u64::from(count)).fold(1, u64::saturating_mul);
            ("placement.lattice.count_x", count)
        }
        Placement::Deposition { count, .. } => ("placement.deposition.count", u64::from(*count)),
        Placement::Random { count, .. } => ("placement.random.count", u64::from(count.unwrap_or(0))),
    };
    if count > limits.insertion_particles {
        let most = limits.insertion_particles;
        let text = format!("{count} particles, at most {most} per command are allowed (limit `insertion_particles`)");
        return Err(error(v1::ErrorCode::TooLarge, path, text));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(request: Request) -> (v1::ErrorCode, String) {
        let refusal = Order::read(request.verb(), request.encode().into(), &Limits::default()).unwrap_err();
        (refusal.error.code(), refusal.error.path)
    }

    #[test]
    fn every_verb_refuses_bytes_that_are_no_message() {
        for verb in Verb::ALL {
            let refusal = Order::read(verb, Bytes::from_static(&[0xff; 40]), &Limits::default()).unwrap_err();
            assert_eq!(refusal.error.code(), v1::ErrorCode::Undecodable);
            assert_eq!(refusal.error.path, "");
        }
    }

    #[test]
    fn a_million_insertions_are_refused_before_anything_is_made() {
        let one = Some(v1::Vec3 { x: 1.0, y: 1.0, z: 1.0 });
        let lattice = v1::LatticePlacement {
            origin_m: one,
            spacing_m: one,
            count_x: u32::MAX,
            count_y: u32::MAX,
            count_z: u32::MAX,
            random_orientation: false,
        };
        let placement = Some(v1::insert_request::Placement::Lattice(lattice));
        let request = Request::Insert(v1::InsertRequest { placement, ..Default::default() });
        assert_eq!(refusal(request), (v1::ErrorCode::TooLarge, "placement.lattice.count_x".into()));
    }

    /// Four thousand million of them would hold the physics up for an hour.
    #[test]
    fn attempts_without_end_are_refused() {
        let region = v1::random_placement::Region::Box(v1::BoxRegion {
            min_m: Some(v1::Vec3::default()),
            max_m: Some(v1::Vec3 { x: 1.0, y: 1.0, z: 1.0 }),
        });
        let random = |attempts| v1::RandomPlacement {
            region: Some(region),
            amount: Some(v1::random_placement::Amount::Count(2)),
            fixed_orientation: false,
            attempts: Some(attempts),
        };
        let insert = |attempts| {
            let placement = Some(v1::insert_request::Placement::Random(random(attempts)));
            Request::Insert(v1::InsertRequest { placement, ..Default::default() })
        };
        let path = (v1::ErrorCode::InvalidInput, "placement.random.attempts".into());
        assert_eq!(refusal(insert(MOST_ATTEMPTS + 1)), path);
        assert!(Order::read(Verb::Insert, insert(MOST_ATTEMPTS).encode().into(), &Limits::default()).is_ok());
    }

    #[test]
    fn a_message_over_the_limit_is_refused() {
        let limits = Limits { message_bytes: 3, ..Limits::default() };
        let refusal = Order::read(Verb::Pause, Bytes::from_static(&[0; 4]), &limits).unwrap_err();
        assert_eq!(refusal.error.code(), v1::ErrorCode::TooLarge);
    }

    #[test]
    fn bad_windows_ids_times_and_names_are_refused_with_their_path() {
        let from = Some(v1::advance_request::From::FromStep(0));
        for window_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let request = v1::AdvanceRequest { from, window_s, ..Default::default() };
            assert_eq!(refusal(Request::Advance(request)), (v1::ErrorCode::InvalidInput, "window_s".into()));
        }
        let header = v1::CommandHeader { client_id: "x".repeat(65), ..Default::default() };
        let request = Request::Pause(v1::PauseRequest { header: Some(header) });
        assert_eq!(refusal(request).1, "header.client_id");
        let header = v1::CommandHeader { at_time_s: Some(f64::NAN), ..Default::default() };
        let request = Request::Remove(v1::RemoveRequest { header: Some(header.clone()), ids: vec![] });
        assert_eq!(refusal(request).1, "header.at_time_s");
        let header = v1::CommandHeader { at_time_s: Some(1.0), ..header };
        assert_eq!(refusal(Request::Stop(v1::StopRequest { header: Some(header) })).1, "header.at_time_s");
        let outputs = v1::Outputs { columns: vec!["ids".into(), "colour".into()], ..Default::default() };
        let request = v1::AdvanceRequest { from, window_s: 1.0, outputs: Some(outputs), ..Default::default() };
        assert_eq!(refusal(Request::Advance(request)), (v1::ErrorCode::NotFound, "outputs.columns[1]".into()));
    }

    #[test]
    fn the_fingerprint_tells_requests_apart() {
        let order = |steps| {
            let request = Request::Step(v1::StepRequest { header: None, steps });
            Order::read(Verb::Step, request.encode().into(), &Limits::default()).unwrap().fingerprint
        };
        assert_eq!(order(1), order(1));
        assert_ne!(order(1), order(2));
    }
}
