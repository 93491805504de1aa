//! What the engine means survives the wire; what the engine cannot mean is refused with a path.
#![cfg(feature = "engine")]

use proptest::prelude::*;
use prost::Message;
use sturz_engine::fields::{
    AverageWindow, BodyAxis, FieldAverage, FieldDefinition, FieldKernel, FieldQuantity, Grid, GridCylinder, GridMotion,
};
use sturz_engine::scene::{AngularVelocity, InsertionDescription, MotionDescription, Placement, Region, ScaleLaw};
use sturz_engine::{FloatType, ParticleColumn};
use sturz_engine::{InvalidInput, Snapshot};
use sturz_protocol::convert;
use sturz_protocol::{Request, columns, keys::Verb, v1};

fn number() -> impl Strategy<Value = f64> {
    prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    [number(), number(), number()]
}

fn region() -> impl Strategy<Value = Region> {
    prop_oneof![
        (vector(), vector()).prop_map(|(min_m, max_m)| Region::Box { min_m, max_m }),
        (vector(), vector(), number(), number())
            .prop_map(|(point_m, axis, radius_m, length_m)| { Region::Cylinder { point_m, axis, radius_m, length_m } }),
    ]
}

fn placement() -> impl Strategy<Value = Placement> {
    let pose = (vector(), [number(), number(), number(), number()]);
    let amount = prop_oneof![
        any::<u32>().prop_map(|count| (Some(count), None)),
        number().prop_map(|fraction| (None, Some(fraction)))
    ];
    prop_oneof![
        (prop::collection::vec(pose, 0..20), any::<bool>()).prop_map(|(poses, rotated)| {
            let (positions_m, orientations): (Vec<_>, Vec<_>) = poses.into_iter().unzip();
            Placement::Poses { positions_m, orientations_wxyz: if rotated { orientations } else { vec![] } }
        }),
        (vector(), vector(), any::<[u32; 3]>(), any::<bool>()).prop_map(
            |(origin_m, spacing_m, counts, random_orientation)| Placement::Lattice {
                origin_m,
                spacing_m,
                counts,
                random_orientation
            }
        ),
        (region(), amount, any::<bool>(), any::<u32>()).prop_map(
            |(region, (count, solid_fraction), fixed_orientation, attempts)| Placement::Random {
                region,
                count,
                solid_fraction,
                fixed_orientation,
                attempts
            }
        ),
        (vector(), vector(), any::<u32>(), any::<bool>()).prop_map(|(min_m, max_m, count, fixed_orientation)| {
            Placement::Deposition { region: Region::Box { min_m, max_m }, count, fixed_orientation }
        }),
    ]
}

fn insertion() -> impl Strategy<Value = InsertionDescription> {
    let scale = prop_oneof![
        (number(), number()).prop_map(|(min, max)| ScaleLaw::Uniform { min, max }),
        (number(), number(), number(), number()).prop_map(|(mean, standard_deviation, min, max)| {
            ScaleLaw::Normal { mean, standard_deviation, min, max }
        }),
        (number(), number(), number(), number()).prop_map(|(median, log_standard_deviation, min, max)| {
            ScaleLaw::Lognormal { median, log_standard_deviation, min, max }
        }),
        prop::collection::vec([number(), number()], 0..5).prop_map(|rows| ScaleLaw::Table { rows }),
    ];
    (".*", ".*", placement(), vector(), vector(), scale, any::<bool>()).prop_map(
        |(shape, material, placement, velocity_m_per_s, angular_velocity_rad_per_s, scale, frozen)| {
            InsertionDescription {
                shape,
                material,
                placement,
                velocity_m_per_s,
                angular_velocity_rad_per_s,
                scale,
                frozen,
            }
        },
    )
}

fn motion() -> impl Strategy<Value = MotionDescription> {
    let angular_velocity = prop_oneof![
        number().prop_map(|rad_per_s| AngularVelocity::Constant { rad_per_s }),
        (number(), number()).prop_map(|(rad_per_s, duration_s)| AngularVelocity::Ramp { rad_per_s, duration_s }),
        (number(), number(), number()).prop_map(|(amplitude_rad_per_s, frequency_hz, phase_rad)| {
            AngularVelocity::Oscillation { amplitude_rad_per_s, frequency_hz, phase_rad }
        }),
    ];
    prop_oneof![
        Just(MotionDescription::Fixed),
        vector().prop_map(|velocity_m_per_s| MotionDescription::Translation { velocity_m_per_s }),
        (vector(), vector(), angular_velocity).prop_map(|(point_m, axis, angular_velocity)| {
            MotionDescription::Rotation { point_m, axis, angular_velocity }
        }),
        (vector(), number(), number()).prop_map(|(amplitude_m, frequency_hz, phase_rad)| {
            MotionDescription::Oscillation { amplitude_m, frequency_hz, phase_rad }
        }),
        proptest::collection::vec((number(), vector()), 0..5).prop_map(|rows| {
            let (times_s, displacements_m) = rows.into_iter().unzip();
            MotionDescription::Table { times_s, displacements_m }
        }),
    ]
}

fn grid() -> impl Strategy<Value = Grid> {
    let cylinder = (vector(), vector(), prop::option::of(vector())).prop_map(|(point_m, axis, zero)| GridCylinder {
        point_m,
        axis,
        zero,
    });
    (vector(), vector(), any::<[u32; 3]>(), prop::option::of(cylinder))
        .prop_map(|(min_m, max_m, cells, cylinder)| Grid { min_m, max_m, cells, cylinder })
}

fn field() -> impl Strategy<Value = FieldDefinition> {
    let quantities = prop::sample::subsequence(FieldQuantity::ALL.to_vec(), 0..=FieldQuantity::ALL.len());
    let kernel = prop::sample::select(FieldKernel::ALL.to_vec());
    let body_axis =
        prop::sample::select(vec![BodyAxis::Longest, BodyAxis::Shortest, BodyAxis::X, BodyAxis::Y, BodyAxis::Z]);
    let window = prop::sample::select(vec![AverageWindow::Growing, AverageWindow::Sliding]);
    let average = (any::<(u64, u64, u32)>(), window, number()).prop_map(
        |((every_steps, samples_per_block, blocks), window, from_time_s)| FieldAverage {
            every_steps,
            samples_per_block,
            blocks,
            window,
            from_time_s,
        },
    );
    let motion = prop_oneof![
        vector().prop_map(|velocity_m_per_s| GridMotion::Translation { velocity_m_per_s }),
        ".*".prop_map(|name| GridMotion::Boundary { name }),
    ];
    let smearing = (number(), number(), prop::collection::vec(number(), 0..4), kernel, any::<bool>(), body_axis);
    let over_time = (prop::option::of(average), prop::option::of(motion));
    (".*", grid(), quantities, smearing, over_time).prop_map(|(name, grid, quantities, smearing, (average, motion))| {
        let (width_m, cutoff_widths, more_widths_m, kernel, wall_correction, body_axis) = smearing;
        FieldDefinition {
            name,
            grid,
            quantities,
            width_m,
            cutoff_widths,
            more_widths_m,
            kernel,
            wall_correction,
            body_axis,
            average,
            motion,
        }
    })
}

/// Through the bytes and back.
fn over_the_wire(request: Request) -> Request {
    Request::decode(request.verb(), request.encode().as_slice()).unwrap()
}

proptest! {
    #[test]
    fn insertions_survive_the_wire(insertion in insertion()) {
        let request = over_the_wire(Request::Insert(convert::insertion_to_wire(&insertion)));
        let Request::Insert(request) = request else { panic!("another kind") };
        prop_assert_eq!(convert::insertion_from_wire(&request).unwrap(), insertion);
    }

    #[test]
    fn motions_survive_the_wire(motion in motion(), boundary in ".*") {
        let request = v1::SetMotionRequest { header: None, boundary, motion: Some(convert::motion_to_wire(&motion)) };
        let Request::SetMotion(request) = over_the_wire(Request::SetMotion(request)) else { panic!("another kind") };
        prop_assert_eq!(convert::motion_from_wire(&request).unwrap(), motion);
    }

    #[test]
    fn field_definitions_survive_the_wire(field in field()) {
        let bytes = convert::field_definition_to_wire(&field).encode_to_vec();
        let back = v1::FieldDefinition::decode(bytes.as_slice()).unwrap();
        prop_assert_eq!(convert::field_definition_from_wire(&back).unwrap(), field);
    }

    #[test]
    fn headers_survive_the_wire(client_id in ".*", request_id in ".*", at_time_s in prop::option::of(number())) {
        let header = v1::CommandHeader { client_id, request_id, at_time_s };
        for verb in Verb::ALL {
            let request = Request::decode(verb, &[][..]).unwrap().with_header(header.clone());
            let back = over_the_wire(request);
            prop_assert_eq!(back.header(), Some(&header));
        }
    }

    #[test]
    fn any_bytes_decode_or_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        for verb in Verb::ALL {
            // Whatever decodes must then convert or be refused, without a panic.
            match Request::decode(verb, bytes.as_slice()) {
                Ok(Request::Insert(request)) => drop(convert::insertion_from_wire(&request)),
                Ok(Request::SetMotion(request)) => drop(convert::motion_from_wire(&request)),
                Ok(Request::SetGravity(request)) => drop(convert::gravity_from_wire(&request)),
                Ok(Request::Advance(request)) => drop(convert::advance_start(&request)),
                Ok(Request::DefineField(request)) =>
                    drop(request.field.as_ref().map(convert::field_definition_from_wire)),
                _ => {}
            }
        }
    }

    #[test]
    fn frames_carry_every_bit_of_the_state(
        rows in prop::collection::vec((any::<u64>(), vector(), [number(), number(), number(), number()]), 0..20)
    ) {
        let snapshot = Snapshot {
            step: 7,
            time_s: 0.125,
            topology_epoch: 3,
            ids: rows.iter().map(|row| row.0).collect(),
            shapes: vec![1; rows.len()],
            materials: vec![2; rows.len()],
            scales: vec![0.5; rows.len()],
            positions: rows.iter().map(|row| row.1).collect(),
            orientations: rows.iter().map(|row| row.2).collect(),
            velocities: rows.iter().map(|row| row.1.map(|x| -x)).collect(),
            angular_velocities: rows.iter().map(|row| row.1).collect(),
            ..Default::default()
        };
        let frame = convert::frame_to_wire(&snapshot, &ParticleColumn::usual(), FloatType::F64, Default::default());
        let frame = v1::Frame::decode(frame.encode_to_vec().as_slice()).unwrap();
        let header = frame.header.unwrap();
        prop_assert_eq!((header.step, header.sim_time_s, header.topology_epoch), (7, 0.125, 3));
        let ids: Vec<[u64; 1]> = columns::read(&frame.columns[0]).unwrap();
        prop_assert_eq!(ids.as_flattened(), &snapshot.ids);
        prop_assert_eq!(columns::read::<f64, 3>(&frame.columns[4]).unwrap(), snapshot.positions);
        prop_assert_eq!(columns::read::<f64, 4>(&frame.columns[5]).unwrap(), snapshot.orientations);
        prop_assert_eq!(columns::read::<f64, 3>(&frame.columns[6]).unwrap(), snapshot.velocities);
        prop_assert_eq!(frame.n as usize, rows.len());
    }
}

/// The path of the error.
fn path<T: std::fmt::Debug>(result: Result<T, InvalidInput>) -> String {
    result.unwrap_err().path
}

fn poses(positions: &[[f64; 3]], orientations: &[[f64; 4]]) -> v1::InsertRequest {
    let placement = Placement::Poses { positions_m: positions.to_vec(), orientations_wxyz: orientations.to_vec() };
    convert::insertion_to_wire(&InsertionDescription {
        shape: "a".into(),
        material: "b".into(),
        placement,
        velocity_m_per_s: [0.0; 3],
        angular_velocity_rad_per_s: [0.0; 3],
        scale: ScaleLaw::default(),
        frozen: false,
    })
}

fn column_of(request: &mut v1::InsertRequest) -> &mut v1::Column {
    match request.placement.as_mut().unwrap() {
        v1::insert_request::Placement::Poses(poses) => poses.positions_m.as_mut().unwrap(),
        _ => panic!("another placement"),
    }
}

#[test]
fn errors_lead_to_the_place() {
    let bad = poses(&[[0.0; 3], [0.0, f64::NAN, 0.0]], &[]);
    assert_eq!(path(convert::insertion_from_wire(&bad)), "placement.poses.positions_m[1][1]");
    let bad = poses(&[[0.0; 3], [1.0; 3]], &[[1.0, 0.0, 0.0, 0.0]]);
    assert_eq!(path(convert::insertion_from_wire(&bad)), "placement.poses.orientations_wxyz");
    let mut bad = poses(&[[0.0; 3]], &[]);
    column_of(&mut bad).data.truncate(23);
    assert_eq!(path(convert::insertion_from_wire(&bad)), "placement.poses.positions_m");
    let mut bad = poses(&[[0.0; 3]], &[]);
    bad.velocity_m_per_s = Some(v1::Vec3 { x: 0.0, y: 0.0, z: f64::NEG_INFINITY });
    assert_eq!(path(convert::insertion_from_wire(&bad)), "velocity_m_per_s.z");
    bad.placement = None;
    assert_eq!(path(convert::insertion_from_wire(&bad)), "placement");
    assert_eq!(path(convert::gravity_from_wire(&Default::default())), "gravity_m_per_s2");
    assert_eq!(path(convert::motion_from_wire(&Default::default())), "motion");
    assert_eq!(path(convert::advance_start(&Default::default())), "from_time_s");
}

#[test]
fn an_unknown_quantity_is_refused() {
    let mut field = convert::field_definition_to_wire(&FieldDefinition::new(
        "f",
        Grid { min_m: [0.0; 3], max_m: [1.0; 3], cells: [1; 3], cylinder: None },
        &[FieldQuantity::Density],
        0.1,
    ));
    for unknown in [0, 99, -1] {
        field.quantities = vec![1, unknown];
        assert_eq!(path(convert::field_definition_from_wire(&field)), "field.quantities[1]");
    }
}
