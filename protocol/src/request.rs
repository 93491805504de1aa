//! A request of any kind, decoded.

use prost::bytes::Buf;
use prost::{DecodeError, Message as _};

use crate::keys::Verb;
use crate::v1;

/// A decoded request, not yet proved usable.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // each variant is the message of that name
#[expect(clippy::large_enum_variant, reason = "decoded one at a time, and never kept in numbers")]
pub enum Request {
    Insert(v1::InsertRequest),
    Remove(v1::RemoveRequest),
    SetGravity(v1::SetGravityRequest),
    SetMotion(v1::SetMotionRequest),
    SetLoads(v1::SetLoadsRequest),
    SetFluid(v1::SetFluidRequest),
    Pause(v1::PauseRequest),
    Resume(v1::ResumeRequest),
    Step(v1::StepRequest),
    Advance(v1::AdvanceRequest),
    DefineField(v1::DefineFieldRequest),
    DropField(v1::DropFieldRequest),
    DefineOutput(v1::DefineOutputRequest),
    Checkpoint(v1::CheckpointRequest),
    Restore(v1::RestoreRequest),
    ListCheckpoints(v1::ListCheckpointsRequest),
    DropCheckpoint(v1::DropCheckpointRequest),
    AcquireLease(v1::AcquireLeaseRequest),
    ReleaseLease(v1::ReleaseLeaseRequest),
    Stop(v1::StopRequest),
}

/// Calls `$use` with the message inside of a [`Request`].
macro_rules! each {
    ($request:expr, $message:ident => $use:expr) => {
        match $request {
            Request::Insert($message) => $use,
            Request::Remove($message) => $use,
            Request::SetGravity($message) => $use,
            Request::SetMotion($message) => $use,
            Request::SetLoads($message) => $use,
            Request::SetFluid($message) => $use,
            Request::Pause($message) => $use,
            Request::Resume($message) => $use,
            Request::Step($message) => $use,
            Request::Advance($message) => $use,
            Request::DefineField($message) => $use,
            Request::DropField($message) => $use,
            Request::DefineOutput($message) => $use,
            Request::Checkpoint($message) => $use,
            Request::Restore($message) => $use,
            Request::ListCheckpoints($message) => $use,
            Request::DropCheckpoint($message) => $use,
            Request::AcquireLease($message) => $use,
            Request::ReleaseLease($message) => $use,
            Request::Stop($message) => $use,
        }
    };
}

impl Request {
    /// From the payload found under the key of `verb`. Out of `Bytes`, columns are no copies.
    pub fn decode(verb: Verb, bytes: impl Buf) -> Result<Self, DecodeError> {
        Ok(match verb {
            Verb::Insert => Request::Insert(v1::InsertRequest::decode(bytes)?),
            Verb::Remove => Request::Remove(v1::RemoveRequest::decode(bytes)?),
            Verb::SetGravity => Request::SetGravity(v1::SetGravityRequest::decode(bytes)?),
            Verb::SetMotion => Request::SetMotion(v1::SetMotionRequest::decode(bytes)?),
            Verb::SetLoads => Request::SetLoads(v1::SetLoadsRequest::decode(bytes)?),
            Verb::SetFluid => Request::SetFluid(v1::SetFluidRequest::decode(bytes)?),
            Verb::Pause => Request::Pause(v1::PauseRequest::decode(bytes)?),
            Verb::Resume => Request::Resume(v1::ResumeRequest::decode(bytes)?),
            Verb::Step => Request::Step(v1::StepRequest::decode(bytes)?),
            Verb::Advance => Request::Advance(v1::AdvanceRequest::decode(bytes)?),
            Verb::DefineField => Request::DefineField(v1::DefineFieldRequest::decode(bytes)?),
            Verb::DropField => Request::DropField(v1::DropFieldRequest::decode(bytes)?),
            Verb::DefineOutput => Request::DefineOutput(v1::DefineOutputRequest::decode(bytes)?),
            Verb::Checkpoint => Request::Checkpoint(v1::CheckpointRequest::decode(bytes)?),
            Verb::Restore => Request::Restore(v1::RestoreRequest::decode(bytes)?),
            Verb::ListCheckpoints => Request::ListCheckpoints(v1::ListCheckpointsRequest::decode(bytes)?),
            Verb::DropCheckpoint => Request::DropCheckpoint(v1::DropCheckpointRequest::decode(bytes)?),
            Verb::AcquireLease => Request::AcquireLease(v1::AcquireLeaseRequest::decode(bytes)?),
            Verb::ReleaseLease => Request::ReleaseLease(v1::ReleaseLeaseRequest::decode(bytes)?),
            Verb::Stop => Request::Stop(v1::StopRequest::decode(bytes)?),
        })
    }

    /// To the payload for the key of [`Request::verb`].
    pub fn encode(&self) -> Vec<u8> {
        each!(self, message => message.encode_to_vec())
    }

    /// Which command it is.
    pub fn verb(&self) -> Verb {
        match self {
            Request::Insert(_) => Verb::Insert,
            Request::Remove(_) => Verb::Remove,
            Request::SetGravity(_) => Verb::SetGravity,
            Request::SetMotion(_) => Verb::SetMotion,
            Request::SetLoads(_) => Verb::SetLoads,
            Request::SetFluid(_) => Verb::SetFluid,
            Request::Pause(_) => Verb::Pause,
            Request::Resume(_) => Verb::Resume,
            Request::Step(_) => Verb::Step,
            Request::Advance(_) => Verb::Advance,
            Request::DefineField(_) => Verb::DefineField,
            Request::DropField(_) => Verb::DropField,
            Request::DefineOutput(_) => Verb::DefineOutput,
            Request::Checkpoint(_) => Verb::Checkpoint,
            Request::Restore(_) => Verb::Restore,
            Request::ListCheckpoints(_) => Verb::ListCheckpoints,
            Request::DropCheckpoint(_) => Verb::DropCheckpoint,
            Request::AcquireLease(_) => Verb::AcquireLease,
            Request::ReleaseLease(_) => Verb::ReleaseLease,
            Request::Stop(_) => Verb::Stop,
        }
    }

    /// Who asks; absent when the client left it out.
    pub fn header(&self) -> Option<&v1::CommandHeader> {
        each!(self, message => message.header.as_ref())
    }

    /// The same request, asked by somebody.
    pub fn with_header(mut self, header: v1::CommandHeader) -> Self {
        each!(&mut self, message => message.header = Some(header));
        self
    }
}
