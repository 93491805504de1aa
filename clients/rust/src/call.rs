//! What each command sends, and what comes back: the same for callers that block and for those that do not.

use std::marker::PhantomData;

use sturz_protocol::{Request, v1};

use crate::error::ClientError;
use crate::outcome::{Applied, Checkpointed, Checkpoints, Inserted, Kind, Removed, Restored, Stepped, read};
use crate::request::vec3;

/// A command whose outcome is a `K`.
pub(crate) struct Call<K> {
    /// Without a header.
    pub(crate) request: Request,
    /// Answered at once; else it may take as long as it needs.
    pub(crate) is_quick: bool,
    outcome: PhantomData<fn() -> K>,
}

impl<K: Kind> Call<K> {
    /// Answered at once.
    fn quick(request: Request) -> Self {
        Self { request, is_quick: true, outcome: PhantomData }
    }

    /// Answered when it is done.
    pub(crate) fn long(request: Request) -> Self {
        Self { request, is_quick: false, outcome: PhantomData }
    }

    /// From the outcome of the request.
    pub(crate) fn read(outcome: v1::Outcome) -> Result<K, ClientError> {
        read(outcome)
    }
}

pub(crate) fn insert(request: v1::InsertRequest) -> Call<Inserted> {
    Call::long(Request::Insert(request))
}

pub(crate) fn remove(ids: impl IntoIterator<Item = u64>) -> Call<Removed> {
    Call::quick(Request::Remove(v1::RemoveRequest { header: None, ids: ids.into_iter().collect() }))
}

pub(crate) fn set_gravity(gravity_m_per_s2: [f64; 3]) -> Call<Applied> {
    let gravity_m_per_s2 = Some(vec3(gravity_m_per_s2));
    Call::quick(Request::SetGravity(v1::SetGravityRequest { header: None, gravity_m_per_s2 }))
}

pub(crate) fn set_motion(boundary: &str, motion: v1::Motion) -> Call<Applied> {
    let (boundary, motion) = (boundary.into(), Some(motion));
    Call::quick(Request::SetMotion(v1::SetMotionRequest { header: None, boundary, motion }))
}

pub(crate) fn set_loads(loads: v1::Loads) -> Call<Applied> {
    Call::quick(Request::SetLoads(v1::SetLoadsRequest { header: None, loads: Some(loads) }))
}

pub(crate) fn set_fluid(fluid: Option<v1::FluidDefinition>, fields: Option<v1::FluidFields>) -> Call<Applied> {
    Call::quick(Request::SetFluid(v1::SetFluidRequest { header: None, fluid, fields }))
}

pub(crate) fn pause() -> Call<Applied> {
    Call::quick(Request::Pause(v1::PauseRequest { header: None }))
}

pub(crate) fn resume() -> Call<Applied> {
    Call::quick(Request::Resume(v1::ResumeRequest { header: None }))
}

pub(crate) fn step(steps: u64) -> Call<Stepped> {
    Call::long(Request::Step(v1::StepRequest { header: None, steps }))
}

pub(crate) fn define_field(definition: v1::FieldDefinition) -> Call<Applied> {
    Call::quick(Request::DefineField(v1::DefineFieldRequest { header: None, field: Some(definition) }))
}

pub(crate) fn drop_field(name: &str) -> Call<Applied> {
    Call::quick(Request::DropField(v1::DropFieldRequest { header: None, name: name.into() }))
}

pub(crate) fn define_output(output: v1::OutputDefinition) -> Call<Applied> {
    Call::quick(Request::DefineOutput(v1::DefineOutputRequest { header: None, output: Some(output) }))
}

pub(crate) fn checkpoint(token: &str, on_disk: bool) -> Call<Checkpointed> {
    Call::long(Request::Checkpoint(v1::CheckpointRequest { header: None, token: token.into(), on_disk }))
}

pub(crate) fn restore(token: &str) -> Call<Restored> {
    Call::long(Request::Restore(v1::RestoreRequest { header: None, token: token.into() }))
}

pub(crate) fn list_checkpoints() -> Call<Checkpoints> {
    Call::quick(Request::ListCheckpoints(v1::ListCheckpointsRequest { header: None }))
}

pub(crate) fn drop_checkpoint(token: &str) -> Call<Applied> {
    Call::quick(Request::DropCheckpoint(v1::DropCheckpointRequest { header: None, token: token.into() }))
}

pub(crate) fn acquire_lease() -> Call<Applied> {
    Call::quick(Request::AcquireLease(v1::AcquireLeaseRequest { header: None }))
}

pub(crate) fn release_lease() -> Call<Applied> {
    Call::quick(Request::ReleaseLease(v1::ReleaseLeaseRequest { header: None }))
}

pub(crate) fn stop() -> Call<Applied> {
    Call::quick(Request::Stop(v1::StopRequest { header: None }))
}
