//! Fields of running scenes: balances, conservation, threads, means over time and their checkpoints.

mod common;

use common::{drum, engine, header, plane, shape, steps};
use sturz_engine::fields::{
    AverageWindow, FieldAverage, FieldDefinition, FieldFrame, FieldMean, FieldQuantity as Q, FieldSources, Grid,
    GridCylinder, GridMotion, compute,
};
use sturz_engine::{Command, ContactNetwork, Engine, Snapshot};

const PAIR: &str = "stiffness_n_per_m = 1e3\nrestitution = 0.5\nfriction = 0.4";

fn column(frame: &FieldFrame, quantity: Q) -> &[f64] {
    &frame.columns.iter().find(|column| column.quantity == quantity).unwrap().data
}

/// Beads that have fallen into a drum that turns, 60 ms on: some rest on it, some fly.
fn beads(count: u32, threads: usize) -> Engine {
    let text = drum(count)
        .replace(
            "kind = \"cross_3d\", beam_length_m = 0.0051417, beam_width_m = 1.0283e-3",
            "kind = \"sphere\", radius_m = 2.5e-3",
        )
        .replace("stiffness_n_per_m = 1e3", "stiffness_n_per_m = 1e4");
    assert!(text.contains("sphere") && text.contains("1e4"));
    let mut engine = engine(&text);
    engine.set_threads(threads);
    steps(&mut engine, 3000);
    engine
}

fn whole_drum(cells: [u32; 3], quantities: &[Q]) -> FieldDefinition {
    let grid = Grid { min_m: [-0.06, -0.012, -0.06], max_m: [0.06, 0.012, 0.06], cells, cylinder: None };
    FieldDefinition::new("drum", grid, quantities, 4e-3)
}

fn about_the_axis(cells: [u32; 3], quantities: &[Q]) -> FieldDefinition {
    let cylinder = Some(GridCylinder { point_m: [0.0; 3], axis: [0.0, 1.0, 0.0], zero: None });
    let grid = Grid { min_m: [0.0, 0.0, -0.012], max_m: [0.06, std::f64::consts::TAU, 0.012], cells, cylinder };
    FieldDefinition::new("rings", grid, quantities, 4e-3)
}

fn with_state<R>(engine: &Engine, f: impl FnOnce(&Snapshot, &ContactNetwork) -> R) -> R {
    let (mut snapshot, mut network) = (Snapshot::default(), ContactNetwork::default());
    engine.snapshot(&mut snapshot);
    engine.contact_network(&mut network);
    f(&snapshot, &network)
}

/// Layers of spheres on a floor, at rest under local damping: the stress at any height is the weight above it per area,
/// since div sigma = rho g holds for every kernel; and the traction on the floor is the whole weight.
#[test]
fn the_stress_in_a_settled_bed_balances_the_weight_above() {
    let (radius, g) = (1e-3, 9.81);
    let mut positions = Vec::new();
    for k in 0..6 * 6 * 8 {
        let (i, j, layer) = (k % 6, k / 6 % 6, k / 36);
        // each second layer in the gaps of the one below
        let shift = if layer % 2 == 1 { radius } else { 0.0 };
        let x = |n: i32| f64::from(n) * 2.0 * radius + 0.5 * radius + shift;
        positions.push([x(i), x(j), radius + f64::from(layer) * radius * 2.0_f64.sqrt()]);
    }
    let side = 12.0 * radius;
    let text = header([0.0, 0.0, -g], 1e-5, "", PAIR)
        .replace("[contact]", "[integrator]\nlocal_damping = 0.7\n[contact]")
        + &format!(
            "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [{side}, {side}, 0.0]\nperiodic = [true, true, false]\n"
        )
        + &shape(&format!("kind = \"sphere\", radius_m = {radius}"))
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + &format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = {{ method = \"poses\", positions_m = {positions:?} }}\n"
        );
    let mut engine = engine(&text);
    steps(&mut engine, 8000);
    let grid = Grid { min_m: [0.0; 3], max_m: [side, side, 16e-3], cells: [1, 1, 160], cylinder: None };
    for wall_correction in [false, true] {
        let quantities = [Q::ContactStress, Q::Stress, Q::Density, Q::WallForceDensity, Q::Coordination];
        let definition = FieldDefinition { wall_correction, ..FieldDefinition::new("bed", grid, &quantities, 1e-3) };
        let frame = engine.compute_field(&definition);
        let (stress, density) = (column(&frame, Q::ContactStress), column(&frame, Q::Density));
        let dz = grid.spacing(2);
        let above = |k: usize| (density[k + 1..].iter().sum::<f64>() + 0.5 * density[k]) * dz * g;
        let weight = frame.total_mass_kg * g / (side * side);
        // beyond the kernel's reach of the floor
        for k in 40..140 {
            assert!((stress[9 * k + 8] - above(k)).abs() < 0.01 * weight, "{k} {} {}", stress[9 * k + 8], above(k));
            assert!(stress[9 * k + 2].abs() < 0.01 * weight && stress[9 * k + 5].abs() < 0.01 * weight);
        }
        assert!((stress[9 * 40 + 8] / above(40) - 1.0).abs() < 0.01, "{} {}", stress[9 * 40 + 8], above(40));
        assert!(stress.iter().zip(column(&frame, Q::Stress)).all(|(c, all)| (c - all).abs() < 1e-4 * weight));
        let mass = density.iter().sum::<f64>() * dz * side * side;
        let traction = column(&frame, Q::WallForceDensity).iter().skip(2).step_by(3).sum::<f64>() * dz;
        if wall_correction {
            assert!((mass / frame.total_mass_kg - 1.0).abs() < 1e-4, "{mass}");
            assert!((traction / -weight - 1.0).abs() < 1e-2, "{traction} {weight}");
        } else {
            assert!(mass < 0.99 * frame.total_mass_kg, "{mass}");
        }
        // in the middle of the bed each sphere touches four above and four below
        let middle = &column(&frame, Q::Coordination)[8 * 55..8 * 56];
        assert!((middle[0] - 8.0).abs() < 0.7 && middle[1] == middle[0] && middle[2] == 0.0, "{middle:?}");
        assert_eq!(middle[3], middle[0], "spheres touch smoothly");
    }
}

/// One cell over everything: the mean over the volume is what the network of contacts and the particles add up to.
#[test]
fn totals_are_those_of_particles_and_contacts() {
    let mut engine = beads(60, 1);
    steps(&mut engine, 10_000);
    let quantities = [Q::Momentum, Q::ContactStress, Q::ContactStressBoundaries, Q::KineticStress, Q::WallForceDensity];
    let definition = whole_drum([1; 3], &quantities);
    let frame = engine.compute_field(&definition);
    let volume = 0.12 * 0.12 * 0.024;
    let (wanted, on_walls, contacts) = with_state(&engine, |snapshot, network| {
        let mut wanted = [0.0; 9];
        let mut on_walls = [0.0; 3];
        let at = |id: u64| snapshot.positions[snapshot.ids.binary_search(&id).unwrap()];
        for row in &network.rows {
            let (a, force) = (at(row.id_a), row.force_on_a_n());
            let mut end = row.id_b.map_or(row.point_m, at);
            if row.id_b.is_some() {
                end[1] -= ((end[1] - row.point_m[1]) / 0.024).round() * 0.024;
            }
            (0..9).for_each(|k| wanted[k] += force[k / 3] * (a[k % 3] - end[k % 3]));
            if row.boundary.is_some() {
                (0..3).for_each(|k| on_walls[k] -= force[k]);
            }
        }
        (wanted, on_walls, network.rows.len())
    });
    assert!(contacts > 30 && on_walls[2] < 0.0, "{contacts} {on_walls:?}");
    let size = wanted.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (k, found) in column(&frame, Q::ContactStress).iter().enumerate() {
        assert!((found * volume - wanted[k]).abs() < 1e-12 * size, "{k} {found} {}", wanted[k] / volume);
    }
    for (k, found) in column(&frame, Q::WallForceDensity).iter().enumerate() {
        assert!((found * volume - on_walls[k]).abs() < 1e-11 * on_walls[2].abs(), "{k} {found}");
    }
    for (found, wanted) in column(&frame, Q::Momentum).iter().zip(frame.total_momentum_kg_m_per_s) {
        assert!((found * volume - wanted).abs() < 1e-15 * frame.total_mass_kg);
    }
    // sum of m v v / V less that of the mean
    let energy = engine.report().energy.kinetic_translation_j;
    let mean = frame.total_momentum_kg_m_per_s.map(|p| p / frame.total_mass_kg);
    let of_mean = 0.5 * frame.total_mass_kg * mean.iter().map(|v| v * v).sum::<f64>();
    let kinetic = column(&frame, Q::KineticStress);
    let trace = kinetic[0] + kinetic[4] + kinetic[8];
    assert!((0.5 * trace * volume / (energy - of_mean) - 1.0).abs() < 1e-9, "{trace} {energy} {of_mean}");
}

fn all_but(without: &[Q]) -> Vec<Q> {
    Q::ALL.into_iter().filter(|quantity| !without.contains(quantity)).collect()
}

#[test]
fn fields_have_the_same_bits_on_any_number_of_threads_and_from_a_recorded_state() {
    let fine = whole_drum([40, 8, 40], &all_but(&[Q::SolidFractionOfShapes]));
    let fine = FieldDefinition { wall_correction: true, more_widths_m: vec![6e-3], ..fine };
    let profile = whole_drum([1, 1, 50], &all_but(&[]));
    let rings = about_the_axis([24, 1, 1], &all_but(&[Q::SolidFractionOfShapes]));
    let mut frames = Vec::new();
    for threads in [1, 2, 4] {
        let mut engine = beads(60, threads);
        let found: Vec<FieldFrame> = [&fine, &profile, &rings].map(|field| engine.compute_field(field)).into();
        assert!(found.iter().all(|frame| frame.columns.iter().all(|c| c.data.iter().all(|x| x.is_finite()))));
        with_state(&engine, |snapshot, network| {
            let sources = FieldSources::new(engine.scene(), snapshot, Some(network)).unwrap();
            assert_eq!(compute(&profile, &sources).unwrap(), found[1]);
        });
        frames.push(found);
    }
    assert!(frames[0] == frames[1] && frames[0] == frames[2]);
    let drum_stress = column(&frames[0][0], Q::ContactStress);
    assert!(drum_stress.iter().any(|&x| x != 0.0));
}

fn averaged(definition: FieldDefinition, window: AverageWindow) -> FieldDefinition {
    let average = FieldAverage { every_steps: 10, samples_per_block: 3, blocks: 2, window, from_time_s: 0.0603 };
    FieldDefinition { average: Some(average), ..definition }
}

/// Samples at steps 3020, 3030, ... (60.3 ms are 3015 steps) in blocks of three.
#[test]
fn means_are_means_of_sums_with_errors_of_their_blocks() {
    let quantities = [Q::Density, Q::Momentum, Q::Velocity, Q::ContactStress];
    let now = whole_drum([6, 1, 6], &quantities);
    for (window, first) in [(AverageWindow::Growing, 0), (AverageWindow::Sliding, 3)] {
        let definition = averaged(now.clone(), window);
        let mut engine = beads(40, 1);
        engine.validate_field(&definition).unwrap();
        engine.set_averages([&definition]);
        let empty = engine.compute_field(&definition);
        assert_eq!((empty.samples, empty.blocks), (0, 0));
        assert!(empty.columns.iter().all(|column| column.data.iter().all(|&x| x == 0.0)));
        let mut samples = Vec::new();
        for step in 1..=120 {
            steps(&mut engine, 1);
            if step % 10 == 0 && step >= 20 {
                samples.push(engine.compute_field(&now));
            }
        }
        // 11 samples: three blocks and two more, of which the sliding window keeps the last two blocks
        let frame = engine.compute_field(&definition);
        let used = &samples[first..];
        assert_eq!((frame.samples, frame.step), (used.len() as u64, 3120));
        assert_eq!(frame.blocks, if first == 0 { 3 } else { 2 });
        assert_eq!(frame.from_time_s, samples[first].time_s);
        for quantity in [Q::Density, Q::Momentum, Q::ContactStress] {
            let size = column(&frame, quantity).iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            assert!(size > 0.0);
            for (k, found) in column(&frame, quantity).iter().enumerate() {
                let mean = used.iter().map(|one| column(one, quantity)[k]).sum::<f64>() / used.len() as f64;
                assert!((found - mean).abs() < 1e-12 * size, "{quantity:?} {k} {found} {mean}");
                let blocks: Vec<f64> = used[..3 * frame.blocks as usize]
                    .chunks(3)
                    .map(|block| block.iter().map(|one| column(one, quantity)[k]).sum::<f64>() / 3.0)
                    .collect();
                let (n, middle) = (blocks.len() as f64, blocks.iter().sum::<f64>() / blocks.len() as f64);
                let scatter = blocks.iter().map(|x| (x - middle).powi(2)).sum::<f64>();
                let error = (scatter / n / (n - 1.0)).sqrt();
                let columns = frame.columns.iter().find(|column| column.quantity == quantity).unwrap();
                let found = columns.standard_error.as_ref().unwrap()[k];
                assert!((found - error).abs() < 1e-11 * size, "{quantity:?} {k} {found} {error}");
            }
        }
        let velocity = column(&frame, Q::Velocity);
        for (k, rho) in column(&frame, Q::Density).iter().enumerate().filter(|(_, rho)| **rho > 1e-3) {
            let wanted = column(&frame, Q::Momentum)[3 * k + 2] / rho;
            assert!((velocity[3 * k + 2] - wanted).abs() < 1e-10, "{k}");
        }
        // with the fourth block a growing window of two makes two of four
        steps(&mut engine, 10);
        assert_eq!(engine.compute_field(&definition).blocks, 2);
        // an equal definition goes on, another one begins anew
        engine.set_averages([&definition]);
        assert_eq!(engine.compute_field(&definition).samples, if first == 0 { 12 } else { 6 });
        let other = FieldDefinition { width_m: 5e-3, ..definition.clone() };
        engine.set_averages([&other]);
        assert_eq!(engine.compute_field(&other).samples, 0);
    }
}

#[test]
fn means_go_on_from_a_checkpoint_to_the_bit() {
    let now = whole_drum([6, 1, 6], &all_but(&[]));
    let now = FieldDefinition { grid: Grid { cells: [40, 1, 40], ..now.grid }, more_widths_m: vec![3.5e-3], ..now };
    let fields = [
        averaged(now, AverageWindow::Growing),
        averaged(about_the_axis([8, 1, 1], &[Q::Velocity]), AverageWindow::Sliding),
    ];
    let mut first = beads(40, 1);
    first.set_averages(&fields);
    steps(&mut first, 87);
    let hash = first.state_hash();
    let saved = first.checkpoint().unwrap();
    let mut second = beads(40, 2);
    second.restore(&saved).unwrap();
    assert_eq!(second.state_hash(), hash);
    for engine in [&mut first, &mut second] {
        steps(engine, 64);
    }
    for field in &fields {
        let (a, b) = (first.compute_field(field), second.compute_field(field));
        assert!(a.samples > 5 && a.blocks > 1);
        assert!(a == b, "{}", field.name);
    }
    // who averages does not change the run, and who does not has no trace of it
    let mut plain = beads(40, 1);
    steps(&mut plain, 151);
    assert_eq!(plain.state_hash(), first.state_hash());
    plain.restore(&saved).unwrap();
    plain.set_averages([]);
    let mut without = beads(40, 1);
    steps(&mut without, 87);
    assert_eq!(plain.checkpoint().unwrap(), without.checkpoint().unwrap());
}

#[test]
fn a_mean_over_states_that_are_handed_over_is_the_same_mean() {
    let definition = averaged(whole_drum([4, 1, 4], &[Q::Velocity, Q::ContactStress]), AverageWindow::Growing);
    let mut engine = beads(40, 1);
    engine.set_averages([&definition]);
    let mut mean = FieldMean::new(&definition).unwrap();
    assert!(mean.frame().is_none());
    for _ in 0..8 {
        steps(&mut engine, 10);
        if engine.clock().step() >= 3020 {
            with_state(&engine, |snapshot, network| {
                mean.add(&FieldSources::new(engine.scene(), snapshot, Some(network)).unwrap()).unwrap();
                let unknown = FieldSources::new(engine.scene(), snapshot, None).unwrap();
                assert!(mean.add(&unknown).is_err(), "contacts are needed");
            });
        }
    }
    assert_eq!(mean.frame().unwrap(), engine.compute_field(&definition));
}

/// The drum turns in itself, so that its frame stays; the grid turns with it all the same. A particle that would be glued to
/// it stays in its cell: here the whole bed is seen turned back by the angle.
#[test]
fn a_grid_turns_with_its_drum() {
    let mut engine = engine(&drum(40));
    steps(&mut engine, 1000);
    let rest = whole_drum([12, 1, 12], &[Q::Density]);
    let turning = FieldDefinition { motion: Some(GridMotion::Boundary { name: "drum".into() }), ..rest.clone() };
    engine.validate_field(&turning).unwrap();
    let frame = engine.compute_field(&turning);
    let angle = 2.1 * engine.clock().time_s();
    let [w, x, y, z] = frame.grid_orientation_wxyz;
    assert!((w - (0.5 * angle).cos()).abs() < 1e-12 && (y - (0.5 * angle).sin()).abs() < 1e-12, "{w} {y} {angle}");
    assert_eq!((x, z, frame.grid_origin_m), (0.0, 0.0, [0.0; 3]));
    // centre of mass in the axes of the grid, turned back
    let centre = |frame: &FieldFrame| {
        let (mut sum, mut mass) = ([0.0; 2], 0.0);
        for (k, rho) in column(frame, Q::Density).iter().enumerate() {
            let at = [frame.grid.centre(0, k / 12), frame.grid.centre(2, k % 12)];
            (0..2).for_each(|c| sum[c] += rho * at[c]);
            mass += rho;
        }
        sum.map(|s| s / mass)
    };
    let (seen, real) = (centre(&frame), centre(&engine.compute_field(&rest)));
    let (s, c) = angle.sin_cos();
    // about +y: x' = c x + s z
    let back = [c * seen[0] + s * seen[1], c * seen[1] - s * seen[0]];
    assert!((back[0] - real[0]).abs() < 2e-4 && (back[1] - real[1]).abs() < 2e-4, "{back:?} {real:?}");
    let unknown = FieldDefinition { motion: Some(GridMotion::Boundary { name: "lid".into() }), ..rest };
    let refusal = engine.validate_field(&unknown).unwrap_err().to_string();
    assert!(refusal.contains("motion.name") && refusal.contains("\"drum\""), "{refusal}");
}

#[test]
fn a_scene_may_ask_for_means_from_the_start() {
    let text = drum(20)
        + "[[field]]\nname = \"profile\"\nquantities = [\"solid_fraction\", \"stress\"]\nwidth_m = 3e-3\n\
           more_widths_m = [4e-3, 5e-3]\nkernel = \"lucy\"\n\
           grid = { min_m = [-0.06, -0.012, -0.06], max_m = [0.06, 0.012, 0.06], cells = [1, 1, 30] }\n\
           average = { every_steps = 5, samples_per_block = 2, blocks = 4, window = \"sliding\" }\n";
    let mut engine = engine(&text);
    steps(&mut engine, 50);
    let field = engine.scene().description().fields[0].clone();
    let frame = engine.compute_field(&field);
    assert_eq!((frame.samples, frame.blocks, frame.more_widths.len()), (8, 4, 2));
    assert!(frame.more_widths[1].columns[1].standard_error.is_some());
    engine.apply(&Command::Remove((0..20).collect())).unwrap();
    steps(&mut engine, 50);
    let frame = engine.compute_field(&field);
    assert!(frame.columns.iter().all(|column| column.data.iter().all(|&x| x == 0.0)), "all were removed long ago");
}
