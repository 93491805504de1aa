//! Laws together: terminal speeds, pressure drops, limits.

use super::shape::test_shape as hydro;
use super::*;
use std::f64::consts::PI;

pub(super) const ALL_DRAG: [DragLaw; 5] =
    [DragLaw::Stokes, DragLaw::SchillerNaumann, DragLaw::HaiderLevenspiel, DragLaw::Ganser, DragLaw::HolzerSommerfeld];
const ALL_VOIDAGE: [VoidageLaw; 5] =
    [VoidageLaw::None, VoidageLaw::DiFelice, VoidageLaw::Gidaspow, VoidageLaw::Tenneti, VoidageLaw::Beetstra];
const CUBE: &str = "kind = 'cube'\nedge_m = 1.0";

fn sphere() -> HydroShape {
    hydro("kind = 'sphere'\nradius_m = 0.5")
}

fn laws(drag: DragLaw, voidage: VoidageLaw) -> HydrodynamicLaws {
    HydrodynamicLaws {
        drag,
        voidage,
        lift: LiftLaw::None,
        pitching: PitchingLaw::None,
        rotational_drag: RotationalDragLaw::None,
        added_mass_coefficient: 0.0,
    }
}

fn water(w: Vec3, void_fraction: f64) -> Flow {
    Flow {
        relative_velocity: w,
        relative_angular_velocity: Vec3::zeros(),
        vorticity: Vec3::zeros(),
        void_fraction,
        density: 1000.0,
        viscosity: 1e-3,
    }
}

/// K, N s/m, of a body of equivalent diameter d (m) at the speed w along x in water.
fn k(laws: &HydrodynamicLaws, shape: &HydroShape, d: f64, w: f64, void_fraction: f64) -> f64 {
    let scale = d / shape.equivalent_diameter_m();
    response(laws, shape, scale, &Mat3::identity(), &water(Vec3::x() * w, void_fraction)).drag_n_s_per_m
}

/// The w with K w = force.
fn speed(force: f64, k: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if k(middle) * middle < force { low = middle } else { high = middle }
    }
    low
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() <= relative, "{value} is not {expected} to {relative:e}");
}

/// PHYSICS I20: glass in water.
#[test]
fn terminal_speeds_of_glass_beads() {
    // to more digits than I20 prints, by an independent evaluation (there 0.146517 for 1 mm, one too many in the last)
    let table = [
        (0.05e-3, 1.964_491_96e-3),
        (0.1e-3, 7.138_106_86e-3),
        (0.5e-3, 7.213_257_70e-2),
        (1e-3, 0.146_516_458),
        (2e-3, 0.268_748_183),
    ];
    let law = laws(DragLaw::HaiderLevenspiel, VoidageLaw::None);
    for (d, expected) in table {
        let weight = 1500.0 * 9.81 * PI / 6.0 * d * d * d;
        close(speed(weight, |w| k(&law, &sphere(), d, w, 1.0)), expected, 1e-8);
    }
    let stokes = laws(DragLaw::Stokes, VoidageLaw::None);
    let weight = 1500.0 * 9.81 * PI / 6.0 * 0.05e-3f64.powi(3);
    close(speed(weight, |w| k(&stokes, &sphere(), 0.05e-3, w, 1.0)), 2.04375e-3, 1e-12);
}

/// PHYSICS I21: eps (-dp/dx) = n K w with n = (1 - eps)/V.
#[test]
fn ergun_pressure_drops() {
    let (eps, d) = (0.4, 1e-3);
    let drop = |law: &HydrodynamicLaws, shape: &HydroShape, d: f64, u: f64| {
        let w = u / eps;
        (1.0 - eps) / (PI / 6.0 * d * d * d) * k(law, shape, d, w, eps) * w / eps
    };
    for drag in ALL_DRAG {
        let law = laws(drag, VoidageLaw::Gidaspow);
        for (u, expected) in [(1e-3, 860.16), (5e-3, 4628.91), (1e-2, 10078.1), (2e-2, 23437.5)] {
            let exact = 150.0 * 0.36 * 1e-3 * u / (0.064 * d * d) + 1.75 * 0.6 * 1000.0 * u * u / (0.064 * d);
            close(drop(&law, &sphere(), d, u), exact, 1e-12);
            close(exact, expected, 2e-5);
        }
        // cubes: psi d in place of d
        let cube = hydro(CUBE);
        let short = cube.sphericity() * d;
        let u = 1e-2;
        let exact = 150.0 * 0.36 * 1e-3 * u / (0.064 * short * short) + 1.75 * 0.6 * 1000.0 * u * u / (0.064 * short);
        close(drop(&law, &cube, d, u), exact, 1e-12);
    }
}

/// PHYSICS I22: a bed held up by the flow, eps V (rho_s - rho_f) g = K w, expands as (Richardson and Zaki) U/v_t = eps^n.
#[test]
fn richardson_zaki() {
    let eps = 0.6;
    let law = laws(DragLaw::SchillerNaumann, VoidageLaw::DiFelice);
    for (d, excess, expected, re) in [(0.03e-3, 1500.0, 0.0930, [0.0, 0.2]), (4e-3, 1500.0, 0.2950, [500.0, 1e4])] {
        let weight = excess * 9.81 * PI / 6.0 * d * d * d;
        let alone = speed(weight, |w| k(&law, &sphere(), d, w, 1.0));
        let reynolds = 1e6 * alone * d;
        assert!(re[0] < reynolds && reynolds < re[1], "{reynolds}");
        let hindered = eps * speed(eps * weight, |w| k(&law, &sphere(), d, w, eps));
        close(hindered / alone, expected, 0.1);
    }
}

#[test]
fn creeping_limits_are_finite_and_exact() {
    let (shape, d) = (sphere(), 1e-3);
    let stokes = 3.0 * PI * 1e-3 * d;
    for drag in ALL_DRAG {
        for voidage in ALL_VOIDAGE {
            close(k(&laws(drag, voidage), &shape, d, 0.0, 1.0), stokes, 1e-14);
            close(k(&laws(drag, voidage), &shape, d, 1e-12, 1.0), stokes, 1e-4);
        }
    }
    // at eps = 0.6 and rest, by hand: 0.6^-2.7; Ergun 150 x 0.4/0.6/18; Tenneti; Beetstra
    let (e, p) = (0.6f64, 0.4f64);
    let by_hand = [
        (VoidageLaw::DiFelice, e.powf(-2.7)),
        (VoidageLaw::Gidaspow, 150.0 * p / e / 18.0),
        (VoidageLaw::Tenneti, 1.0 / e + 5.81 * p / e + 0.48 * p.cbrt() / (e * e)),
        (VoidageLaw::Beetstra, 10.0 * p / e + e.powi(3) * (1.0 + 1.5 * p.sqrt())),
    ];
    for (voidage, expected) in by_hand {
        close(k(&laws(DragLaw::SchillerNaumann, voidage), &shape, d, 0.0, e), expected * stokes, 1e-14);
    }
}

#[test]
fn dilute_limit_is_the_one_particle_law() {
    let cube = hydro(CUBE);
    for drag in ALL_DRAG {
        for voidage in [VoidageLaw::DiFelice, VoidageLaw::Gidaspow, VoidageLaw::Tenneti] {
            for w in [0.0, 1e-4, 1e-2, 1.0] {
                let alone = k(&laws(drag, VoidageLaw::None), &cube, 1e-3, w, 1.0);
                close(k(&laws(drag, voidage), &cube, 1e-3, w, 1.0), alone, 1e-14);
            }
        }
    }
}

/// Whether the mean pressure gradient is in it is a factor 1/eps: the laws of simulations agree better than that.
#[test]
fn laws_of_a_bed_agree_on_what_they_leave_out() {
    for eps in [0.5, 0.6] {
        let at = |v| k(&laws(DragLaw::SchillerNaumann, v), &sphere(), 1e-3, 0.0, eps);
        let carman = 10.0 * (1.0 - eps) / eps * 3.0 * PI * 1e-6;
        // Di Felice's convention is checked by the expansion of beds
        for voidage in [VoidageLaw::Tenneti, VoidageLaw::Beetstra, VoidageLaw::Gidaspow] {
            close(at(voidage), carman, 0.3);
        }
        close(at(VoidageLaw::Tenneti), at(VoidageLaw::Beetstra), 0.1);
    }
}

#[test]
fn finite_and_growing_with_speed() {
    let shapes = [sphere(), hydro(CUBE), hydro("kind = 'spherocylinder'\nradius_m = 0.1\ntotal_length_m = 1.0")];
    for shape in &shapes {
        for (drag, voidage) in ALL_DRAG.iter().flat_map(|d| ALL_VOIDAGE.map(|v| (*d, v))) {
            for eps in [0.0, 0.2, 0.3, 0.5, 0.74, 0.76, 0.8, 0.84, 0.86, 0.95, 0.999, 1.0] {
                let law = laws(drag, voidage);
                let speeds = (0..=90).map(|n| if n == 0 { 0.0 } else { 10f64.powf(-6.0 + 0.1 * f64::from(n)) });
                // Re = 1e6 w d, here 0 to 1e6
                let drags: Vec<[f64; 2]> = speeds.map(|w| [w, k(&law, shape, 1e-3, w, eps)]).collect();
                assert!(drags.iter().all(|[_, k]| k.is_finite() && *k > 0.0), "{law:?} {eps}");
                assert!(drags.windows(2).all(|d| d[1][0] * d[1][1] > d[0][0] * d[0][1]), "{law:?} {eps}");
                // Di Felice's exponent has a minimum at Re = 32, which a dense bed's K follows
                if voidage != VoidageLaw::DiFelice || eps >= 0.7 && drag != DragLaw::Stokes {
                    assert!(drags.windows(2).all(|d| d[1][1] >= d[0][1] * (1.0 - 1e-12)), "{law:?} {eps}");
                }
            }
        }
    }
}

#[test]
fn continuous_in_the_void_fraction() {
    let law = laws(DragLaw::SchillerNaumann, VoidageLaw::Gidaspow);
    for w in [0.0, 1e-2, 1.0] {
        let at = |eps: f64| k(&law, &sphere(), 1e-3, w, eps);
        for n in 0..400 {
            let eps = 0.7 + 5e-4 * f64::from(n);
            assert!((at(eps + 5e-4) / at(eps) - 1.0).abs() < 0.02, "{w} {eps}");
        }
    }
}

const ROD: &str = "kind = 'spherocylinder'\nradius_m = 0.5e-3\ntotal_length_m = 5e-3";

fn all_laws() -> HydrodynamicLaws {
    HydrodynamicLaws {
        drag: DragLaw::HolzerSommerfeld,
        voidage: VoidageLaw::DiFelice,
        lift: LiftLaw::CrossFlow,
        pitching: PitchingLaw::Rosendahl,
        rotational_drag: RotationalDragLaw::Dennis,
        added_mass_coefficient: 0.5,
    }
}

#[test]
fn a_rod_feels_the_flow_across_it_more() {
    let rod = hydro(ROD);
    let at = |w: Vec3| response(&all_laws(), &rod, 1.0, &Mat3::identity(), &water(w, 1.0));
    let (along, across) = (at(Vec3::x() * 0.1), at(Vec3::y() * 0.1));
    assert!(across.drag_n_s_per_m > 2.0 * along.drag_n_s_per_m, "{along:?} {across:?}");
    for calm in [along, across] {
        assert!(calm.force_n.norm() < 1e-20 && calm.torque_n_m.norm() < 1e-20, "{calm:?}");
    }
    // flow along +x, the rod's nose up: it is lifted, from below, and turned further up, towards broadside
    let tilted = at(Vec3::new(1.0, -1.0, 0.0) * 0.1);
    assert!(tilted.force_n.dot(&Vec3::new(1.0, 1.0, 0.0)) < 0.0 && tilted.torque_n_m.z > 0.0, "{tilted:?}");
    assert!(tilted.force_n.dot(&Vec3::new(1.0, -1.0, 0.0)).abs() < 1e-18);
}

/// Turning body and flow turns the forces; a shape scaled by s in a flow of the same Reynolds numbers has K times s.
#[test]
fn objective_and_similar() {
    let rod = hydro(ROD);
    let mut flow = water(Vec3::new(0.05, -0.02, 0.03), 0.7);
    flow.relative_angular_velocity = Vec3::new(10.0, 300.0, -200.0);
    flow.vorticity = Vec3::new(3.0, 1.0, -2.0);
    let turn = *crate::math::Quat::from_scaled_axis(Vec3::new(0.3, -1.1, 0.8)).to_rotation_matrix().matrix();
    let turned = Flow {
        relative_velocity: turn * flow.relative_velocity,
        relative_angular_velocity: turn * flow.relative_angular_velocity,
        vorticity: turn * flow.vorticity,
        ..flow
    };
    for lift in [LiftLaw::CrossFlow, LiftLaw::SaffmanMei] {
        let laws = HydrodynamicLaws { lift, ..all_laws() };
        let (a, b) = (response(&laws, &rod, 1.0, &Mat3::identity(), &flow), response(&laws, &rod, 1.0, &turn, &turned));
        close(b.drag_n_s_per_m, a.drag_n_s_per_m, 1e-12);
        close(b.rotational_drag_n_m_s, a.rotational_drag_n_m_s, 1e-12);
        assert!((b.force_n - turn * a.force_n).norm() < 1e-12 * a.force_n.norm());
        assert!((b.torque_n_m - turn * a.torque_n_m).norm() < 1e-12 * a.torque_n_m.norm());
        let slow = Flow {
            relative_velocity: flow.relative_velocity / 3.0,
            relative_angular_velocity: flow.relative_angular_velocity / 9.0,
            vorticity: flow.vorticity / 9.0,
            ..flow
        };
        let large = response(&laws, &rod, 3.0, &Mat3::identity(), &slow);
        close(large.drag_n_s_per_m, 3.0 * a.drag_n_s_per_m, 1e-12);
        close(large.rotational_drag_n_m_s, 27.0 * a.rotational_drag_n_m_s, 1e-12);
        assert!((large.force_n - a.force_n).norm() < 1e-12 * a.force_n.norm());
        assert!((large.torque_n_m - a.torque_n_m * 3.0).norm() < 1e-12 * a.torque_n_m.norm());
    }
}

#[test]
fn bodies_without_a_longest_axis_feel_neither_lift_nor_torque() {
    for body in [CUBE, "kind = 'sphere'\nradius_m = 1.0", "kind = 'cross_3d'\nbeam_length_m = 3.0\nbeam_width_m = 1.0"]
    {
        let shape = hydro(body);
        let calm = response(&all_laws(), &shape, 1e-3, &Mat3::identity(), &water(Vec3::new(0.1, 0.2, 0.3), 1.0));
        assert_eq!((calm.force_n, calm.torque_n_m), (Vec3::zeros(), Vec3::zeros()));
        assert!(calm.drag_n_s_per_m > 0.0 && calm.rotational_drag_n_m_s > 0.0);
    }
}

#[test]
fn at_rest() {
    for body in [CUBE, ROD] {
        let still = response(&all_laws(), &hydro(body), 1.0, &Mat3::identity(), &water(Vec3::zeros(), 0.5));
        assert!(still.drag_n_s_per_m > 0.0 && still.drag_n_s_per_m.is_finite());
        assert_eq!((still.force_n, still.torque_n_m), (Vec3::zeros(), Vec3::zeros()));
    }
}

/// The tables of docs/hydrodynamics.md: sphericities along the longest axis (or a face) and across it, and terminal speeds
/// (m/s) of glass in water, 1500 kg/m3 heavier, in bodies of the volume of a ball of 1 mm. Areas by hand: a cross of beams
/// 3 x 1 x 1 has 7 and 30, a cylinder of aspect 1 pi/4 and 3 pi/2, a spherocylinder of aspect 2 5 pi/12 and 2 pi.
#[test]
fn bodies_of_the_manual() {
    let bodies = [
        (CUBE, [0.8060, 1.2090, 0.7002, 1.2090, 0.7002], [0.1281, 0.1179, 0.1317, 0.1317]),
        (
            "kind = 'cross_3d'\nbeam_length_m = 3.0\nbeam_width_m = 1.0",
            [0.5899, 0.8848, 0.4717, 0.8848, 0.4717],
            [0.0897, 0.0862, 0.1084, 0.1084],
        ),
        (
            "kind = 'cylinder'\nradius_m = 0.5\nlength_m = 1.0",
            [0.8736, 1.3104, 0.7589, 1.0292, 0.8439],
            [0.1394, 0.1309, 0.1393, 0.1289],
        ),
        (
            "kind = 'spherocylinder'\nradius_m = 0.5\ntotal_length_m = 2.0",
            [0.9210, 1.8420, 1.0668, 0.8103, 0.8413],
            [0.1433, 0.1421, 0.1594, 0.1214],
        ),
    ];
    let d = 1e-3f64;
    let weight = 1500.0 * 9.81 * PI / 6.0 * d.powi(3);
    for (body, sphericities, speeds) in bodies {
        let shape = hydro(body);
        let (x, y) = (Vec3::x(), Vec3::y());
        let [along, across] = [x, y].map(|v| [shape.crosswise_sphericity(&v), shape.lengthwise_sphericity(&v)]);
        for (value, expected) in [shape.sphericity(), along[0], along[1], across[0], across[1]].iter().zip(sphericities)
        {
            // half of the last digit, and 1e-4 of the silhouettes by scan lines (exactly 0.88482 for the cross)
            assert!((value - expected).abs() <= 1.5e-4, "{body}: {value}, not {expected}");
        }
        let terminal = |drag, direction: &Vec3| {
            let scale = d / shape.equivalent_diameter_m();
            let law = laws(drag, VoidageLaw::None);
            speed(weight, |w| {
                response(&law, &shape, scale, &Mat3::identity(), &water(direction * w, 1.0)).drag_n_s_per_m
            })
        };
        let laws = [
            (DragLaw::HaiderLevenspiel, x),
            (DragLaw::Ganser, x),
            (DragLaw::HolzerSommerfeld, x),
            (DragLaw::HolzerSommerfeld, y),
        ];
        for ((drag, direction), expected) in laws.iter().zip(speeds) {
            let value = terminal(*drag, direction);
            assert!((value - expected).abs() <= 6e-5, "{body} {drag:?}: {value}, not {expected}");
        }
    }
}
