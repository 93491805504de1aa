//! Requests of clients.

use prost::bytes::Bytes;
use sturz_client::{Amount, FluidFields, Insertion, Loads, Motion, Output, Pace, Placement, Region};
use sturz_protocol::keys::Verb;
use sturz_protocol::{Request, columns, v1};
use sturz_service::order::Order;
use tokio::sync::oneshot;

use crate::decoders::world::{limits, with_runner};

/// The number of the verb, and the payload under its key.
pub fn read(bytes: &[u8]) {
    let Some((&number, payload)) = bytes.split_first() else { return };
    let verb = Verb::ALL[usize::from(number) % Verb::ALL.len()];
    let Ok(order) = Order::read(verb, Bytes::copy_from_slice(payload), &limits()) else { return };
    with_runner(|runner| {
        // Twice: the second one is a repetition, or comes in the midst of a window.
        for _ in 0..2 {
            let (reply, _answer) = oneshot::channel();
            runner.receive(order.clone(), reply);
            runner.step();
        }
    });
}

fn seed(request: &Request) -> Vec<u8> {
    let number = Verb::ALL.iter().position(|&verb| verb == request.verb()).unwrap_or_default();
    [vec![number as u8], request.encode()].concat()
}

/// Of every command, in all its forms.
pub fn seeds() -> anyhow::Result<Vec<Vec<u8>>> {
    let header = v1::CommandHeader { client_id: "c".into(), request_id: "1".into(), at_time_s: None };
    let later = v1::CommandHeader { at_time_s: Some(2e-3), ..header.clone() };
    let mut all: Vec<Request> = changes();
    all.extend(windows());
    all.extend(Verb::ALL.iter().filter_map(|&verb| Request::decode(verb, &[][..]).ok()));
    let with = |header: &v1::CommandHeader| {
        let header = header.clone();
        move |request: &Request| seed(&request.clone().with_header(header.clone()))
    };
    Ok(all.iter().map(with(&header)).chain(all.iter().map(with(&later))).collect())
}

fn insertions() -> Vec<Insertion> {
    let cylinder =
        Region::Cylinder { point_m: [0.0, -0.01, 0.0], axis: [0.0, 1.0, 0.0], radius_m: 0.01, length_m: 0.02 };
    let region = Region::Box { min_m: [-0.01, -0.01, -0.01], max_m: [0.01, 0.01, 0.01] };
    let lattice = Placement::Lattice {
        origin_m: [-0.01, -0.01, -0.01],
        spacing_m: [5e-3; 3],
        counts: [2, 2, 1],
        random_orientation: true,
    };
    let poses = Placement::Poses {
        positions_m: vec![[0.0, 0.01, 0.0], [5e-3, 0.01, 0.0]],
        orientations_wxyz: Some(vec![[1.0, 0.0, 0.0, 0.0], [0.6, 0.8, 0.0, 0.0]]),
    };
    let deposition = Placement::Deposition {
        min_m: [-5e-3, -5e-3, 0.0],
        max_m: [5e-3, 5e-3, 0.02],
        count: 2,
        fixed_orientation: false,
    };
    vec![
        Insertion { scale: [0.8, 1.2], ..Insertion::new("cube", "glass", lattice) },
        Insertion::new("rod", "glass", poses),
        Insertion::new("bead", "glass", Placement::random(region, Amount::Count(3))),
        Insertion::new("bead", "glass", Placement::random(cylinder, Amount::SolidFraction(0.02))),
        Insertion { frozen: true, ..Insertion::new("cube", "glass", deposition) },
    ]
}

/// What plain values of the client do not have.
fn scale_laws() -> Vec<v1::InsertRequest> {
    use v1::insert_request::ScaleLaw;
    let one = || v1::InsertRequest {
        scale: None,
        ..Insertion::new("bead", "glass", Placement::poses(vec![[0.0, 0.01, 0.0], [6e-3, 0.01, 0.0]])).into()
    };
    [
        ScaleLaw::NormalScale(v1::NormalScale { mean: 1.0, standard_deviation: 0.1, min: 0.8, max: 1.2 }),
        ScaleLaw::LognormalScale(v1::LognormalScale { median: 1.0, log_standard_deviation: 0.1, min: 0.8, max: 1.2 }),
        ScaleLaw::ScaleTable(v1::ScaleTable { scales: vec![0.8, 1.0], weights: vec![1.0, 3.0] }),
    ]
    .map(|law| v1::InsertRequest { scale_law: Some(law), ..one() })
    .to_vec()
}

fn motions() -> Vec<Motion> {
    let (point_m, axis) = ([0.0; 3], [0.0, 1.0, 0.0]);
    vec![
        Motion::Fixed,
        Motion::Rotation { point_m, axis, angular_velocity_rad_per_s: 1.0, ramp_s: None },
        Motion::Rotation { point_m, axis, angular_velocity_rad_per_s: 1.0, ramp_s: Some(1e-3) },
        Motion::Translation { velocity_m_per_s: [0.0, 0.0, -0.1] },
        Motion::Oscillation { amplitude_m: [0.0, 0.0, 1e-4], frequency_hz: 50.0, phase_rad: 0.5 },
        Motion::Servo {
            direction: [0.0, 0.0, -1.0],
            force_n: 1.0,
            gain_m_per_s_per_n: 1e-3,
            max_velocity_m_per_s: 0.1,
        },
        Motion::Table { times_s: vec![0.0, 1e-3], displacements_m: vec![[0.0; 3], [0.0, 0.0, 1e-4]] },
    ]
}

fn loads() -> Loads {
    Loads {
        topology_epoch: 0,
        ids: vec![0, 1, 2],
        force_n: vec![[1e-5, 0.0, 0.0]; 3],
        torque_n_m: vec![[0.0, 1e-8, 0.0]; 3],
        drag_n_s_per_m: vec![1e-4; 3],
        fluid_velocity_m_per_s: vec![[0.0, 0.1, 0.0]; 3],
        rotational_drag_n_m_s: vec![1e-9; 3],
        fluid_angular_velocity_rad_per_s: vec![[0.0, 1.0, 0.0]; 3],
        ramp_s: 1e-4,
        valid_until_s: Some(5e-3),
    }
}

/// A plain one, and one with all that a field can have.
fn fields() -> [v1::FieldDefinition; 2] {
    let plain = v1::FieldDefinition {
        name: "velocity".into(),
        grid: Some(v1::Grid {
            min_m: Some(v1::Vec3 { x: -0.02, y: -0.02, z: -0.02 }),
            max_m: Some(v1::Vec3 { x: 0.02, y: 0.02, z: 0.02 }),
            cells_x: 3,
            cells_y: 1,
            cells_z: 3,
            cylinder: None,
        }),
        quantities: vec![1, 2, 3, 4, 5],
        width_m: 4e-3,
        cutoff_widths: Some(3.0),
        ..Default::default()
    };
    let cylinder = v1::GridCylinder {
        point_m: Some(v1::Vec3::default()),
        axis: Some(v1::Vec3 { x: 0.0, y: 1.0, z: 0.0 }),
        zero: Some(v1::Vec3 { x: 1.0, y: 0.0, z: 0.0 }),
    };
    let full = v1::FieldDefinition {
        name: "full".into(),
        grid: plain.grid.map(|grid| v1::Grid { min_m: Some(v1::Vec3::default()), cylinder: Some(cylinder), ..grid }),
        quantities: (1..=20).collect(),
        kernel: v1::FieldKernel::Lucy.into(),
        cutoff_widths: None,
        more_widths_m: vec![2e-3, 8e-3],
        wall_correction: true,
        body_axis: 1,
        average: Some(v1::FieldAverage {
            every_steps: 10,
            samples_per_block: 5,
            blocks: Some(4),
            window: 1,
            from_time_s: 1e-3,
        }),
        motion: Some(v1::GridMotion { motion: Some(v1::grid_motion::Motion::Boundary("lid".into())) }),
        ..plain.clone()
    };
    [plain, full]
}

fn changes() -> Vec<Request> {
    let header = None;
    let mut all: Vec<Request> = insertions().into_iter().map(|insertion| Request::Insert(insertion.into())).collect();
    all.extend(scale_laws().into_iter().map(Request::Insert));
    all.extend(motions().into_iter().map(|motion| {
        let motion = Some(motion.into());
        Request::SetMotion(v1::SetMotionRequest { header: None, boundary: "lid".into(), motion })
    }));
    let down = Some(v1::Vec3 { x: 0.5, y: 0.0, z: -9.0 });
    let outputs = [
        Output::new("state").with_columns(["positions", "forces"]).at(Pace::EverySteps(10)),
        Output::new("contacts").with_columns(["all"]).at(Pace::EveryWallS(0.1)),
        Output::new("field/density").at(Pace::EverySimS(1e-3)),
    ];
    all.extend(
        outputs
            .map(|output| Request::DefineOutput(v1::DefineOutputRequest { header: None, output: Some(output.into()) })),
    );
    all.extend(fields().map(|field| Request::DefineField(v1::DefineFieldRequest { header: None, field: Some(field) })));
    all.extend(
        fluids().map(|fluid| Request::SetFluid(v1::SetFluidRequest { header: None, fluid: Some(fluid), fields: None })),
    );
    all.extend([
        Request::Remove(v1::RemoveRequest { header: None, ids: vec![1, 4] }),
        Request::SetGravity(v1::SetGravityRequest { header: None, gravity_m_per_s2: down }),
        Request::SetLoads(v1::SetLoadsRequest { header: None, loads: Some(loads().into()) }),
        Request::SetFluid(v1::SetFluidRequest { header: None, fluid: None, fields: None }),
        Request::SetFluid(v1::SetFluidRequest {
            header: None,
            fluid: Some(fluids()[1].clone()),
            fields: Some(fluid_fields(8)),
        }),
        Request::DropField(v1::DropFieldRequest { header: None, name: "density".into() }),
        Request::Checkpoint(v1::CheckpointRequest { header: None, token: "a".into(), on_disk: false }),
        Request::Restore(v1::RestoreRequest { header: None, token: "a".into() }),
        Request::DropCheckpoint(v1::DropCheckpointRequest { header, token: "a".into() }),
    ]);
    all
}

fn windows() -> Vec<Request> {
    use v1::advance_request::From;
    let outputs = v1::Outputs {
        columns: vec!["positions".into(), "forces".into()],
        fields: vec!["density".into()],
        float_type: v1::DataType::F32.into(),
        contacts: true,
        exchange: true,
    };
    let window = |from, loads: Option<Loads>| v1::AdvanceRequest {
        header: None,
        from: Some(from),
        window_s: 2e-5,
        outputs: Some(outputs.clone()),
        loads: loads.map(Into::into),
        fluid: None,
    };
    let no_length = v1::AdvanceRequest { window_s: 1e-5, ..window(From::FromStep(100), Some(loads())) };
    vec![
        Request::Step(v1::StepRequest { header: None, steps: 1 }),
        Request::Advance(window(From::FromStep(100), None)),
        Request::Advance(window(From::FromTimeS(1e-3), Some(loads()))),
        Request::Advance(no_length),
        Request::Advance(v1::AdvanceRequest { fluid: Some(fluid_fields(8)), ..window(From::FromStep(100), None) }),
    ]
}

fn fluid_fields(n: usize) -> v1::FluidFields {
    let rows = vec![[0.1, 0.0, -0.2]; n];
    FluidFields { velocity_m_per_s: rows.clone(), pressure_gradient_pa_per_m: rows, ramp_s: 2e-5, ..Default::default() }
        .into()
}

/// Everywhere the same, on boxes, and on points.
fn fluids() -> [v1::FluidDefinition; 3] {
    use v1::fluid_definition::Mesh;
    let plain = v1::FluidDefinition {
        density_kg_per_m3: 1000.0,
        viscosity_pa_s: 1e-3,
        drag: v1::DragLaw::HolzerSommerfeld.into(),
        lift: v1::LiftLaw::CrossFlow.into(),
        added_mass_coefficient: 0.5,
        buoyancy: true,
        ..Default::default()
    };
    let spacing = Some(v1::Vec3 { x: 0.05, y: 0.05, z: 0.05 });
    let boxes = v1::StructuredMesh { spacing_m: spacing, count_x: 2, count_y: 2, count_z: 2, ..Default::default() };
    let points_m = Some(columns::rows("points_m", "m", &[[0.0, 0.0, 0.01], [0.02, 0.0, 0.01]]));
    let volumes_m3 = Some(columns::flat("volumes_m3", "m3", 1, &[1e-5, 1e-5]));
    let points = v1::PointMesh { points_m, volumes_m3 };
    let on = |mesh| v1::FluidDefinition { mesh: Some(mesh), smoothing_length_m: Some(0.04), ..plain.clone() };
    [plain.clone(), on(Mesh::Structured(boxes)), on(Mesh::Points(points))]
}

/// Every command is among the seeds, and sound as a message.
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_is_among_the_seeds() {
        let seeds = seeds().unwrap();
        for (number, &verb) in Verb::ALL.iter().enumerate() {
            let ours: Vec<&Vec<u8>> = seeds.iter().filter(|seed| usize::from(seed[0]) == number).collect();
            assert!(!ours.is_empty(), "{}", verb.name());
            assert!(
                ours.iter().any(|seed| Order::read(verb, Bytes::copy_from_slice(&seed[1..]), &limits()).is_ok()),
                "{}",
                verb.name()
            );
        }
    }
}
