//! A steered run as a list of requests, the same for whoever drives it.

use std::time::Duration;

use anyhow::{Context as _, bail};
use sturz_client::v1;
use sturz_client::{Amount, ClientError, Insertion, Loads, Placement, Refusal, Region, Request, Simulation};

use crate::faults::chance::Chance;
use crate::faults::daemon::SOON;

/// Balls and cubes that slide, stick and roll in a turning drum.
pub const HEAP: &str = r#"
[scene]
name = "heap"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 1e-5
seed = 4
[[material]]
name = "glass"
density_kg_per_m3 = 2500.0
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = 1e4
restitution = 0.5
friction = 0.4
[[shape]]
name = "bead"
geometry = { kind = "sphere", radius_m = 2e-3 }
[[shape]]
name = "cube"
geometry = { kind = "cube", edge_m = 4e-3 }
[[boundary]]
name = "drum"
material = "glass"
geometry = { kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.02 }
motion = { kind = "rotation", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], angular_velocity = { kind = "constant", rad_per_s = 5.0 } }
[[insertion]]
shape = "bead"
material = "glass"
placement = { method = "random", count = 20, region = { kind = "box", min_m = [-0.012, -0.01, -0.012], max_m = [0.012, 0.01, 0.0] } }
[[insertion]]
shape = "cube"
material = "glass"
placement = { method = "random", count = 12, region = { kind = "box", min_m = [-0.012, -0.01, 0.0], max_m = [0.012, 0.01, 0.014] } }
"#;

/// One request of a run, made from where the simulation is.
#[derive(Clone, Debug)]
pub enum Action {
    /// A window with loads on the first particles.
    Advance { window_s: f64, force_n: f64 },
    /// Some steps.
    Step(u64),
    /// One more ball, above the heap.
    Insert { x: f64 },
    /// That ball again, if it is there; an unknown id is refused.
    Remove(u64),
    /// Gravity tilts.
    Gravity { x: f64 },
    /// Gravity tilts so long after now.
    GravityLater { x: f64, after_s: f64 },
    /// The state is saved in memory or as a file.
    Checkpoint { token: u64, on_disk: bool },
    /// The state goes back; there may be no such token.
    Restore { token: u64 },
}

/// A run of so many requests.
pub fn script(seed: u64, length: usize) -> Vec<Action> {
    let mut chance = Chance::new(seed);
    let action = |chance: &mut Chance| match chance.below(16) {
        0..=5 => Action::Advance { window_s: 1e-3 * (0.2 + chance.unit()), force_n: 1e-4 * (chance.unit() - 0.5) },
        6 | 7 => Action::Step(1 + chance.below(120)),
        8 | 9 => Action::Insert { x: 0.01 * (chance.unit() - 0.5) },
        10 => Action::Remove(chance.below(60)),
        11 => Action::Gravity { x: 4.0 * (chance.unit() - 0.5) },
        12 => Action::GravityLater { x: 4.0 * (chance.unit() - 0.5), after_s: 2e-3 * chance.unit() },
        13 => Action::Checkpoint { token: chance.below(3), on_disk: false },
        14 => Action::Checkpoint { token: chance.below(3), on_disk: chance.below(2) == 0 },
        _ => Action::Restore { token: chance.below(3) },
    };
    (0..length).map(|_| action(&mut chance)).collect()
}

/// What a request led to.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached {
    /// The reply, without its data, or the refusal; `None` for what takes effect later.
    pub outcome: Option<Result<v1::Outcome, Refusal>>,
    /// It was answered from memory.
    pub repeated: bool,
    /// State hash behind it.
    pub state_hash: u64,
}

/// Request `k` of a run, made for where the simulation is. Sent again, it must be the same to the bit.
pub fn build(simulation: &Simulation, k: usize, action: &Action) -> Result<Request, ClientError> {
    let info = simulation.info()?;
    let mut header =
        v1::CommandHeader { client_id: "script".into(), request_id: format!("request-{k}"), at_time_s: None };
    if let Action::GravityLater { after_s, .. } = action {
        header.at_time_s = Some(info.sim_time_s + after_s);
    }
    Ok(request(&info, action).with_header(header))
}

/// Whether the reply to it comes with a later time only.
pub fn is_for_later(request: &Request) -> bool {
    request.header().is_some_and(|header| header.at_time_s.is_some())
}

/// Sends a request, for the first time or again.
pub fn send(simulation: &Simulation, request: &Request) -> Result<Reached, ClientError> {
    let mut repeated = false;
    let outcome = if is_for_later(request) {
        match simulation.command(request.clone(), Some(Duration::from_millis(1))) {
            Ok(_) | Err(ClientError::Timeout { .. }) => None,
            Err(other) => return Err(other),
        }
    } else {
        match simulation.command(request.clone(), Some(SOON)) {
            Ok(outcome) => {
                repeated = outcome.repeated;
                Some(Ok(v1::Outcome { repeated: false, ..outcome }))
            }
            Err(ClientError::Refused(refusal)) => Some(Err(refusal)),
            Err(other) => return Err(other),
        }
    };
    Ok(Reached { outcome, repeated, state_hash: simulation.info()?.state_hash })
}

fn request(info: &v1::Info, action: &Action) -> Request {
    match *action {
        Action::Advance { window_s, force_n } => {
            let ids = (0..5).collect();
            let force_n = vec![[force_n; 3]; 5];
            let loads = Loads { topology_epoch: info.topology_epoch, ids, force_n, ..Loads::default() };
            Request::Advance(v1::AdvanceRequest {
                header: None,
                from: Some(v1::advance_request::From::FromTimeS(info.sim_time_s)),
                window_s,
                outputs: None,
                loads: Some(loads.into()),
                fluid: None,
            })
        }
        Action::Step(steps) => Request::Step(v1::StepRequest { header: None, steps }),
        Action::Insert { x } => {
            let region = Region::Box { min_m: [x - 0.006, -0.01, -0.005], max_m: [x + 0.006, 0.01, 0.014] };
            Request::Insert(Insertion::new("bead", "glass", Placement::random(region, Amount::Count(1))).into())
        }
        Action::Remove(more) => Request::Remove(v1::RemoveRequest { header: None, ids: vec![31 + more] }),
        Action::Gravity { x } | Action::GravityLater { x, .. } => Request::SetGravity(v1::SetGravityRequest {
            header: None,
            gravity_m_per_s2: Some(v1::Vec3 { x, y: 0.0, z: -9.81 }),
        }),
        Action::Checkpoint { token, on_disk } => {
            Request::Checkpoint(v1::CheckpointRequest { header: None, token: format!("t{token}"), on_disk })
        }
        Action::Restore { token } => Request::Restore(v1::RestoreRequest { header: None, token: format!("t{token}") }),
    }
}

/// What a whole run leads to.
pub fn run(simulation: &Simulation, actions: &[Action]) -> anyhow::Result<Vec<Reached>> {
    let send = |(k, action)| {
        let reached = build(simulation, k, action).and_then(|request| send(simulation, &request));
        reached.with_context(|| format!("request {k}, {action:?}"))
    };
    actions.iter().enumerate().map(send).collect()
}

/// How two replies to the same request differ; `None`: not at all.
pub fn difference(expected: &Reached, found: &Reached) -> Option<String> {
    (expected.outcome != found.outcome || expected.state_hash != found.state_hash)
        .then(|| format!("expected {expected:?}, found {found:?}"))
}

/// Refuses a script in which next to everything is refused.
pub fn check_worth(reached: &[Reached]) -> anyhow::Result<()> {
    let refused = reached.iter().filter(|one| matches!(one.outcome, Some(Err(_)))).count();
    if 2 * refused > reached.len() {
        bail!("{refused} of {} requests are refused: the script tries too little", reached.len());
    }
    Ok(())
}
