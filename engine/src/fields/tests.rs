//! Fields of states that are made by hand: closed forms, conservation, and sums over all pairs of particles and points.

use super::definition::{FieldDefinition, FieldFrame, Grid, GridCylinder, GridMotion};
use super::kernel::{FieldKernel, Kernel};
use super::sources::{FieldContact, FieldParticle, FieldSources};
use super::{BodyAxis, FieldQuantity as Q, compute};
use crate::math::{Mat3, Vec3};
use crate::scene::{Scene, SceneDescription};
use crate::snapshot::BoundaryState;

/// A unit cell, periodic along the axes named, with balls of radius 0.1; planes at the corners of the cell if wanted.
fn scene(periodic: [bool; 3], walls: bool) -> Scene {
    let mut text = format!(
        "[scene]\nname = \"f\"\ntime_step_s = 1e-5\n[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [1.0, 1.0, 1.0]\n\
         periodic = {periodic:?}\n[[material]]\nname = \"m\"\ndensity_kg_per_m3 = 1000.0\n\
         [[shape]]\nname = \"ball\"\ngeometry = {{ kind = \"sphere\", radius_m = 0.1 }}\n\
         [[shape]]\nname = \"rod\"\ngeometry = {{ kind = \"spherocylinder\", radius_m = 0.05, total_length_m = 0.3 }}\n"
    );
    for axis in (0..3).filter(|&axis| walls && !periodic[axis]) {
        for (side, place) in [("low", 0.0), ("high", 1.0)] {
            let (mut point, mut normal) = ([0.5; 3], [0.0; 3]);
            point[axis] = place;
            normal[axis] = 1.0 - 2.0 * place;
            text += &format!(
                "[[boundary]]\nname = \"{side} {axis}\"\nmaterial = \"m\"\ngeometry = {{ kind = \"plane\", \
                 point_m = {point:?}, normal = {normal:?} }}\n"
            );
        }
    }
    Scene::validate(SceneDescription::from_toml(&text).unwrap()).unwrap()
}

fn wall_states(scene: &Scene) -> Vec<BoundaryState> {
    let state = |boundary: &crate::boundary::Boundary| BoundaryState {
        name: boundary.name.clone(),
        point_m: boundary.point.into(),
        direction: boundary.direction().into(),
        orientation_wxyz: boundary.orientation_wxyz(),
        ..BoundaryState::default()
    };
    scene.boundaries().iter().map(state).collect()
}

fn particle(mass: f64, position: Vec3, velocity: Vec3) -> FieldParticle {
    FieldParticle {
        position,
        velocity,
        angular_velocity: Vec3::zeros(),
        rotation: Mat3::identity(),
        mass,
        volume: 0.004 * mass,
        euler: Vec3::repeat(0.002),
        shape: 0,
        scale: 1.0,
        neighbours: [0.0; 8],
    }
}

fn sources<'a>(
    scene: &'a Scene,
    walls: &'a [BoundaryState],
    particles: Vec<FieldParticle>,
    contacts: Vec<FieldContact>,
) -> FieldSources<'a> {
    FieldSources { scene, step: 0, time_s: 0.0, particles, contacts: Some(contacts), boundaries: walls }
}

fn draw(id: u64, low: f64, high: f64) -> (crate::random::Draw, Vec3) {
    let mut draw = crate::random::Draw::new(3, id, crate::random::Purpose::Position);
    let x = draw.in_box(&Vec3::repeat(low), &Vec3::repeat(high));
    (draw, x)
}

fn cloud() -> Vec<FieldParticle> {
    (0..40)
        .map(|id| {
            let (mut draw, x) = draw(id, 0.0, 1.0);
            let velocity = draw.in_box(&Vec3::repeat(4.0), &Vec3::repeat(5.0));
            let spin = draw.in_box(&Vec3::repeat(-3.0), &Vec3::repeat(3.0));
            FieldParticle { angular_velocity: spin, ..particle(1.0 + draw.unit(), x, velocity) }
        })
        .collect()
}

/// Branches of up to 0.2 between random points of the cell, and the forces on them.
fn contacts(n: u64) -> Vec<FieldContact> {
    (100..100 + n)
        .map(|id| {
            let (mut draw, start) = draw(id, 0.2, 0.8);
            let branch = draw.in_box(&Vec3::repeat(-0.11), &Vec3::repeat(0.11));
            let force = draw.in_box(&Vec3::repeat(-1.0), &Vec3::repeat(1.0));
            FieldContact { start, branch, force, is_at_boundary: id % 3 == 0 }
        })
        .collect()
}

fn unit_grid(cells: [u32; 3]) -> Grid {
    Grid { min_m: [0.0; 3], max_m: [1.0; 3], cells, cylinder: None }
}

fn definition(cells: [u32; 3], quantities: &[Q]) -> FieldDefinition {
    FieldDefinition::new("test", unit_grid(cells), quantities, 0.1)
}

fn column(frame: &FieldFrame, quantity: Q) -> &[f64] {
    &frame.columns.iter().find(|column| column.quantity == quantity).unwrap().data
}

/// Integral over the grid of every component.
fn integral(frame: &FieldFrame, quantity: Q) -> Vec<f64> {
    let volume: f64 = (0..3).map(|axis| frame.grid.spacing(axis)).product();
    let components = quantity.components();
    (0..components).map(|c| column(frame, quantity).iter().skip(c).step_by(components).sum::<f64>() * volume).collect()
}

fn total_of_branches(contacts: &[FieldContact]) -> Mat3 {
    contacts.iter().map(|contact| -contact.force * contact.branch.transpose()).sum()
}

/// The midpoint rule sums a smooth periodic function nearly exactly; what is left is the kernel's edge: exp(-8) of the
/// top of the Gaussian on a grid of a fifth of the width, nothing of Lucy's on one of a twentieth of the support.
#[test]
fn integrals_are_mass_momentum_and_moments_of_branches_in_every_dimension() {
    let scene = scene([true; 3], false);
    let contacts = contacts(30);
    let sources = sources(&scene, &[], cloud(), contacts.clone());
    for (kernel, tolerance) in [(FieldKernel::Gaussian, 2e-4), (FieldKernel::Lucy, 2e-5)] {
        for cells in [[50, 50, 50], [50, 1, 50], [1, 1, 50], [1, 1, 1]] {
            let definition =
                FieldDefinition { kernel, ..definition(cells, &[Q::Density, Q::Momentum, Q::ContactStress]) };
            let frame = compute(&definition, &sources).unwrap();
            let near = |found: f64, wanted: f64, scale: f64| {
                assert!((found - wanted).abs() < tolerance * scale, "{kernel:?} {cells:?} {found} {wanted}");
            };
            near(integral(&frame, Q::Density)[0], frame.total_mass_kg, frame.total_mass_kg);
            let momentum = Vec3::from(frame.total_momentum_kg_m_per_s);
            for (axis, found) in integral(&frame, Q::Momentum).into_iter().enumerate() {
                near(found, momentum[axis], momentum[axis]);
            }
            let branches = total_of_branches(&contacts);
            for (k, found) in integral(&frame, Q::ContactStress).into_iter().enumerate() {
                near(found, branches[(k / 3, k % 3)], branches.norm());
            }
        }
    }
}

/// With walls on all sides nothing is lost: the integral over the inside is the whole. What is left is the midpoint rule
/// at the walls, where the integrand ends in a jump that lies on the border of two cells, and at edges and corners, where
/// the parts are multiplied: 3e-4 with a Gaussian cut at 4 widths, as measured.
#[test]
fn walls_take_nothing_away_when_corrected() {
    let scene = scene([false; 3], true);
    let walls = wall_states(&scene);
    let contacts = contacts(30);
    let sources = sources(&scene, &walls, cloud(), contacts.clone());
    let whole = total_of_branches(&contacts);
    for cells in [[50, 50, 50], [50, 1, 50], [1, 1, 200]] {
        let mut definition = definition(cells, &[Q::Density, Q::ContactStress, Q::SolidFraction]);
        let mass_of = |definition: &FieldDefinition| {
            let frame = compute(definition, &sources).unwrap();
            let stress = Mat3::from_row_slice(&integral(&frame, Q::ContactStress));
            (integral(&frame, Q::Density)[0] / frame.total_mass_kg, (stress - whole).norm() / whole.norm())
        };
        let (mass, _) = mass_of(&definition);
        assert!(mass < 0.95, "{mass} without correction");
        definition.wall_correction = true;
        let (mass, stress) = mass_of(&definition);
        let tolerance = if cells[0] == 1 { 2e-5 } else { 6e-4 };
        assert!((mass - 1.0).abs() < tolerance && stress < 2.0 * tolerance, "{cells:?} {mass} {stress:e}");
    }
}

/// Sums over all particles and contacts and their images along y, at one point.
struct BruteForce<'a> {
    kernel: Kernel,
    at: Vec3,
    particles: &'a [FieldParticle],
    contacts: &'a [FieldContact],
}

impl BruteForce<'_> {
    const SHIFTS: [f64; 3] = [-1.0, 0.0, 1.0];

    /// The kernel, and from which image of `x` to the point.
    fn images(&self, x: &Vec3) -> [(f64, Vec3); 3] {
        let d = self.at - x;
        Self::SHIFTS.map(|shift| d - Vec3::y() * shift).map(|d| (self.kernel.value(d.norm_squared()), d))
    }

    fn phi(&self, x: &Vec3) -> f64 {
        self.images(x).iter().map(|(phi, _)| phi).sum()
    }

    fn sum(&self, f: &dyn Fn(&FieldParticle) -> f64) -> f64 {
        self.particles.iter().map(|p| f(p) * self.phi(&p.position)).sum()
    }

    fn second_moment(&self) -> Mat3 {
        let of = |p: &FieldParticle| self.images(&p.position).map(|(phi, d)| d * d.transpose() * (p.mass * phi));
        self.particles.iter().flat_map(of).sum()
    }

    /// By 4 x 5 nodes of Gauss-Legendre.
    fn along(&self, contact: &FieldContact) -> f64 {
        let node = |k: usize| {
            let (x, weight) = super::kernel::LEGENDRE[k % 5];
            let s = ((k / 5) as f64 + x) / 4.0;
            0.25 * weight * self.phi(&(contact.start + contact.branch * s))
        };
        (0..20).map(node).sum()
    }

    fn stress(&self, boundaries: bool) -> Mat3 {
        let of = self.contacts.iter().filter(|contact| contact.is_at_boundary == boundaries);
        of.map(|contact| -contact.force * contact.branch.transpose() * self.along(contact)).sum()
    }

    fn wall_force(&self) -> Vec3 {
        let of = self.contacts.iter().filter(|contact| contact.is_at_boundary);
        of.map(|contact| -contact.force * self.phi(&(contact.start + contact.branch))).sum()
    }

    /// Each quantity, and what errors of it are compared with; `None` where there is nothing.
    fn wanted(&self) -> Option<Vec<(Q, Vec<f64>, f64)>> {
        let mass = self.sum(&|p| p.mass);
        if mass == 0.0 {
            return None;
        }
        let v = Vec3::from_fn(|axis, _| self.sum(&|p| p.mass * p.velocity[axis]) / mass);
        let spin = Vec3::from_fn(|axis, _| self.sum(&|p| p.mass * p.angular_velocity[axis]) / mass);
        let kinetic = Mat3::from_fn(|a, b| self.sum(&|p| p.mass * (p.velocity - v)[a] * (p.velocity - v)[b]));
        let rows = |m: Mat3| m.transpose().as_slice().to_vec();
        // quadrature with 20 nodes feels where the kernel ends: a jump of exp(-8) of the top, or one of the third
        // derivative; errors are compared with 1e-11 of this
        let is_cut =
            self.kernel.value(0.999 * self.kernel.support * self.kernel.support) > 1e-5 * self.kernel.value(0.0);
        let line = self.kernel.value(0.0) * 0.1 * if is_cut { 1e7 } else { 1e4 };
        Some(vec![
            (Q::SolidFraction, vec![self.sum(&|p| p.volume)], 1.0),
            (Q::NumberDensity, vec![self.sum(&|_| 1.0)], 10.0),
            (Q::Velocity, v.as_slice().to_vec(), 1.0),
            (Q::AngularVelocity, spin.as_slice().to_vec(), 1.0),
            (Q::GranularTemperature, vec![kinetic.trace() / (3.0 * mass)], 1.0),
            (Q::KineticStress, rows(kinetic), 10.0),
            (Q::SecondMoment, rows(self.second_moment() / mass), 0.01),
            (Q::ContactStressPairs, rows(self.stress(false)), line),
            (Q::ContactStressBoundaries, rows(self.stress(true)), line),
            (Q::WallForceDensity, self.wall_force().as_slice().to_vec(), 1.0),
        ])
    }
}

#[test]
fn fields_equal_the_brute_force_sum() {
    let scene = scene([false, true, false], false);
    let (particles, contacts) = (cloud(), contacts(30));
    let quantities = [
        Q::SolidFraction,
        Q::NumberDensity,
        Q::Velocity,
        Q::AngularVelocity,
        Q::GranularTemperature,
        Q::KineticStress,
        Q::SecondMoment,
        Q::ContactStressPairs,
        Q::ContactStressBoundaries,
        Q::WallForceDensity,
    ];
    for form in [FieldKernel::Gaussian, FieldKernel::Lucy] {
        let definition = FieldDefinition { kernel: form, ..definition([5, 6, 7], &quantities) };
        let frame = compute(&definition, &sources(&scene, &[], particles.clone(), contacts.clone())).unwrap();
        let kernel = Kernel::new(form, 0.1, 0.4, 3);
        let (mut worst, mut touched) = (0.0_f64, 0);
        for index in 0..5 * 6 * 7 {
            let cell = [index / 42, index / 7 % 6, index % 7];
            let at = Vec3::from_fn(|axis, _| frame.grid.centre(axis, cell[axis]));
            let brute = BruteForce { kernel, at, particles: &particles, contacts: &contacts };
            let Some(all) = brute.wanted() else { continue };
            touched += 1;
            for (quantity, wanted, scale) in all {
                let n = quantity.components();
                let found = &column(&frame, quantity)[n * index..n * (index + 1)];
                let error = found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale;
                worst = worst.max(error);
            }
        }
        assert!(touched > 100 && worst < 1e-11, "{form:?} {touched} {worst:e}");
    }
}

/// PHYSICS.md C2: the numbers of the oracle for the kernel exp(-(R / 2w)^2) cut at 6 w, w = 0.5.
#[test]
fn the_fixture_of_the_oracle() {
    let scene = scene([false; 3], false);
    let mut particles = Vec::new();
    for k in 0..24 * 24 * 24 {
        let x = Vec3::new((k / 576) as f64, (k / 24 % 24) as f64, (k % 24) as f64).add_scalar(0.5) * 0.5;
        let wave = Vec3::new((3.0 * x.x).sin(), (2.0 * x.y).cos(), (x.x + x.z).sin()) * 0.1;
        particles.push(particle(1.0, x, Vec3::new(x.y - 6.0, 0.0, 0.0) + wave));
    }
    let sources = sources(&scene, &[], particles, Vec::new());
    let at = Vec3::new(6.1, 5.9, 6.05);
    let grid =
        Grid { min_m: at.add_scalar(-0.05).into(), max_m: at.add_scalar(0.15).into(), cells: [2; 3], cylinder: None };
    let width = 0.5 * 2.0_f64.sqrt();
    let quantities = [Q::Density, Q::Velocity, Q::KineticStress, Q::SecondMoment];
    let definition =
        FieldDefinition { cutoff_widths: 3.0 / width, ..FieldDefinition::new("c2", grid, &quantities, width) };
    let frame = compute(&definition, &sources).unwrap();
    let near = |quantity: Q, component: usize, wanted: f64, tolerance: f64| {
        let found = column(&frame, quantity)[component];
        assert!((found - wanted).abs() < tolerance, "{quantity:?} {component} {found} {wanted}");
    };
    near(Q::Density, 0, 8.000_277_925_652_7, 1e-12);
    for (axis, wanted) in [-0.105_516_024_167, 0.026_516_169_887, -0.024_543_504_713].into_iter().enumerate() {
        near(Q::Velocity, axis, wanted, 1e-12);
    }
    near(Q::KineticStress, 0, 4.030_623_173_431, 1e-12);
    for (axis, wanted) in [0.498_843, 0.498_843, 0.498_821].into_iter().enumerate() {
        near(Q::SecondMoment, 4 * axis, wanted, 5e-7);
    }
}

/// PHYSICS.md C3 without noise: particles of a lattice in simple shear do not fluctuate about the field at their places.
/// The kinetic stress about V(r) is rho w^2 gdot^2 for every width, all of it T^gamma.
#[test]
fn shear_is_told_from_fluctuations_at_every_width() {
    let scene = scene([true, false, true], false);
    let rate = 3.0;
    let particles: Vec<FieldParticle> = (0..20 * 20 * 20)
        .map(|k| {
            let x = Vec3::new((k / 400) as f64, (k / 20 % 20) as f64, (k % 20) as f64).add_scalar(0.5) * 0.05;
            particle(0.000_125, x, Vec3::new(1000.0 + rate * x.y, 0.0, 0.0))
        })
        .collect();
    let sources = sources(&scene, &[], particles, Vec::new());
    let quantities = [
        Q::KineticStress,
        Q::KineticStressOfGradient,
        Q::KineticStressScaleFree,
        Q::KineticStressAboutParticles,
        Q::VelocityGradient,
        Q::ShearRate,
    ];
    let grid = Grid { min_m: [0.0, 0.45, 0.0], max_m: [1.0, 0.55, 1.0], cells: [1, 2, 1], cylinder: None };
    let definition = FieldDefinition {
        more_widths_m: vec![0.06, 0.08, 0.1],
        cutoff_widths: 4.5,
        ..FieldDefinition::new("c3", grid, &quantities, 0.05)
    };
    let frame = compute(&definition, &sources).unwrap();
    let mut all = vec![(frame.width_m, &frame.columns)];
    all.extend(frame.more_widths.iter().map(|more| (more.width_m, &more.columns)));
    for (width, columns) in all {
        let xx: Vec<f64> = columns.iter().map(|column| column.data[0]).collect();
        let rho_d_gdot2 = rate * rate * Kernel::new(FieldKernel::Gaussian, width, 4.5 * width, 1).second_moment;
        // rho is 1; the lattice, whose period is the smallest width, is felt by exp(-2 pi^2) at that
        assert!((xx[0] / rho_d_gdot2 - 1.0).abs() < 2e-3, "{width} {xx:?} {rho_d_gdot2}");
        assert!((xx[1] / rho_d_gdot2 - 1.0).abs() < 6e-3, "{width} {xx:?} {rho_d_gdot2}");
        assert!(xx[2].abs() < 6e-3 * rho_d_gdot2 && xx[3].abs() < 1e-2 * rho_d_gdot2, "{width} {xx:?}");
        let gradient = &columns[4].data;
        assert!((gradient[1] / rate - 1.0).abs() < 2e-3 && gradient[3].abs() < 1e-10, "{gradient:?}");
        assert!((xx[5] / gradient[1] - 1.0).abs() < 1e-12);
    }
}

/// Two particles pushed apart along z by f: on a profile along z the stress is f over the area times the kernel's integral
/// over the branch, an error function; 0 shear.
#[test]
fn the_stress_of_two_particles_has_a_closed_form() {
    let scene = scene([false; 3], false);
    let contact = FieldContact {
        start: Vec3::new(0.5, 0.5, 0.4),
        branch: Vec3::new(0.0, 0.0, 0.2),
        force: Vec3::new(0.0, 0.0, -7.0),
        is_at_boundary: false,
    };
    let definition = FieldDefinition {
        cutoff_widths: 8.0,
        ..definition([1, 1, 20], &[Q::ContactStress, Q::ContactStressBoundaries])
    };
    let frame = compute(&definition, &sources(&scene, &[], Vec::new(), vec![contact])).unwrap();
    for k in 0..20 {
        let z = frame.grid.centre(2, k);
        let up_to = |end: f64| libm::erf((z - end) / (2.0_f64.sqrt() * 0.1));
        let wanted = 7.0 * 0.5 * (up_to(0.4) - up_to(0.6));
        let found = &column(&frame, Q::ContactStress)[9 * k..9 * (k + 1)];
        assert!((found[8] - wanted).abs() < 1e-13 && found[..8].iter().all(|&x| x == 0.0), "{found:?} {wanted}");
    }
    assert!(column(&frame, Q::ContactStressBoundaries).iter().all(|&x| x == 0.0));
    // of the whole extent: f b / V, exactly; of half of it half of the branch
    for (high, part) in [(1.0, 1.0), (0.5, 0.5)] {
        let grid = Grid { max_m: [1.0, 1.0, high], ..unit_grid([1; 3]) };
        let definition = FieldDefinition::new("0", grid, &[Q::ContactStress], 0.1);
        let frame = compute(&definition, &sources(&scene, &[], Vec::new(), vec![contact])).unwrap();
        assert!((column(&frame, Q::ContactStress)[8] - part * 7.0 * 0.2 / high).abs() < 1e-14);
    }
}

#[test]
fn totals_do_not_depend_on_where_the_cells_are() {
    let scene = scene([true; 3], false);
    let contacts = contacts(30);
    let sources = sources(&scene, &[], cloud(), contacts);
    let totals = |shift: f64| {
        let mut definition = definition([40, 40, 1], &[Q::Density, Q::ContactStress]);
        definition.kernel = FieldKernel::Lucy;
        definition.grid.min_m = [shift, shift, 0.0];
        definition.grid.max_m = [1.0 + shift, 1.0 + shift, 1.0];
        let frame = compute(&definition, &sources).unwrap();
        [integral(&frame, Q::Density), integral(&frame, Q::ContactStress)].concat()
    };
    let (here, there) = (totals(0.0), totals(0.313));
    assert!(here.iter().zip(&there).all(|(a, b)| (a - b).abs() < 2e-5 * here[0]), "{here:?} {there:?}");
}

/// A cylinder that the cloud lies in: the mass in all rings, and a solid rotation, whose velocity is linear in the place.
#[test]
fn cylinders_keep_mass_and_turn_vectors() {
    let scene = scene([false; 3], false);
    let (centre, rate) = (Vec3::new(0.5, 0.5, 0.5), 2.0);
    // a lattice with the symmetry of a square about the axis, which is y
    let particles: Vec<FieldParticle> = (0..16_000)
        .map(|k| Vec3::new((k / 400) as f64, (k / 40 % 10) as f64, (k % 40) as f64).add_scalar(0.5))
        .map(|x| x.component_div(&Vec3::new(40.0, 10.0, 40.0)))
        .filter(|x| (x - centre).xz().norm() < 0.45)
        .map(|x| particle(1e-3, x, (Vec3::y() * rate).cross(&(x - centre)) + Vec3::y() * 30.0))
        .collect();
    let mass: f64 = particles.iter().map(|p| p.mass).sum();
    let sources = sources(&scene, &[], particles, Vec::new());
    let cylinder = Some(GridCylinder { point_m: [0.5, 0.0, 0.5], axis: [0.0, 2.0, 0.0], zero: None });
    for cells in [[30, 1, 1], [30, 48, 1], [30, 1, 4], [1, 1, 1]] {
        let grid = Grid { min_m: [0.0; 3], max_m: [0.6, std::f64::consts::TAU, 1.0], cells, cylinder };
        let quantities = [Q::Density, Q::Velocity, Q::VelocityGradient];
        let definition =
            FieldDefinition { cutoff_widths: 4.5, ..FieldDefinition::new("drum", grid, &quantities, 0.03) };
        let frame = compute(&definition, &sources).unwrap();
        let per_r = (cells[1] * cells[2]) as usize;
        let ring =
            |i: usize| std::f64::consts::PI * ((i as f64 + 1.0).powi(2) - (i as f64).powi(2)) * grid.spacing(0).powi(2);
        let density = column(&frame, Q::Density);
        let found: f64 = density.iter().enumerate().map(|(k, rho)| rho * ring(k / per_r) / per_r as f64).sum();
        if cells[2] == 1 {
            assert!((found / mass - 1.0).abs() < 3e-3, "{cells:?} {found} {mass}");
        }
        if cells[0] == 1 {
            continue;
        }
        let velocity = column(&frame, Q::Velocity);
        for (k, v) in velocity.chunks(3).enumerate() {
            let radius = grid.centre(0, k / per_r);
            if radius < 0.3 {
                // the lattice of 0.025 is felt through a width of 0.03 by exp(-2 pi^2 1.44)
                assert!(v[0].abs() < 1e-5 && (v[1] - rate * radius).abs() < 1e-5, "{cells:?} {radius} {v:?}");
                assert!((v[2] - 30.0).abs() < 1e-9, "{v:?}");
                let gradient = &column(&frame, Q::VelocityGradient)[9 * k..9 * (k + 1)];
                assert!((gradient[1] + rate).abs() < 1e-2 && (gradient[3] - rate).abs() < 1e-2, "{gradient:?}");
            }
        }
    }
}

#[test]
fn a_grid_that_moves_with_its_particles_sees_no_change() {
    let scene = scene([false; 3], false);
    let quantities = [Q::Density, Q::Velocity, Q::ContactStress];
    let mut definition = definition([6, 5, 4], &quantities);
    let contacts = contacts(10);
    let rest = compute(&definition, &sources(&scene, &[], cloud(), contacts.clone())).unwrap();
    let velocity = Vec3::new(0.25, -0.5, 2.0);
    definition.motion = Some(GridMotion::Translation { velocity_m_per_s: velocity.into() });
    let moved = cloud().into_iter().map(|p| FieldParticle { position: p.position + velocity * 2.0, ..p }).collect();
    let shifted = contacts.iter().map(|c| FieldContact { start: c.start + velocity * 2.0, ..*c }).collect();
    let mut later = sources(&scene, &[], moved, shifted);
    later.time_s = 2.0;
    let frame = compute(&definition, &later).unwrap();
    assert_eq!(frame.grid_origin_m, [0.5, -1.0, 4.0]);
    for (a, b) in rest.columns.iter().zip(&frame.columns) {
        let size = a.data.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!(a.data.iter().zip(&b.data).all(|(a, b)| (a - b).abs() < 1e-9 * size), "{:?}", a.quantity);
    }
}

#[test]
fn volumes_of_shapes_are_spread_over_them() {
    let scene = scene([true; 3], false);
    let mut ball = particle(4.0, Vec3::repeat(0.5), Vec3::zeros());
    ball.volume = scene.shapes()[0].mass_properties().volume;
    let grid = Grid { min_m: [0.3; 3], max_m: [0.7; 3], cells: [5, 5, 5], cylinder: None };
    let mut definition = FieldDefinition::new("v", grid, &[Q::SolidFractionOfShapes, Q::SolidFraction], 0.02);
    let frame = compute(&definition, &sources(&scene, &[], vec![ball], Vec::new())).unwrap();
    // at the centre the kernel lies in the ball altogether; points at 0.7 widths are felt by exp(-2 pi^2 / 0.49)
    assert!((column(&frame, Q::SolidFractionOfShapes)[62] - 1.0).abs() < 0.02, "{frame:?}");
    assert!(column(&frame, Q::SolidFraction)[62] > 20.0);
    definition.grid = Grid { cells: [80, 80, 1], ..unit_grid([80, 80, 1]) };
    let frame = compute(&definition, &sources(&scene, &[], vec![ball], Vec::new())).unwrap();
    assert!((integral(&frame, Q::SolidFractionOfShapes)[0] / ball.volume - 1.0).abs() < 1e-3);
}

#[test]
fn rods_have_an_axis_and_spinning_ones_carry_momentum() {
    let scene = scene([false; 3], false);
    let rod = &scene.shapes()[1];
    let axis = BodyAxis::Longest.of(rod);
    assert!(
        (0..3).all(|k| rod.mass_properties().principal_inertia[axis] <= rod.mass_properties().principal_inertia[k])
    );
    let mut particle = particle(2.0, Vec3::repeat(0.5), Vec3::x());
    particle.shape = 1;
    // the body's long axis to world x
    let y = (axis + 1) % 3;
    let mut rotation = Mat3::zeros();
    (rotation[(0, axis)], rotation[(1, y)], rotation[(2, (axis + 2) % 3)]) = (1.0, 1.0, 1.0);
    particle.rotation = rotation;
    let inertia = rod.mass_properties().principal_inertia / rod.mass_properties().volume;
    particle.euler = inertia.map(|moment| 0.5 * inertia.sum() - moment);
    particle.angular_velocity = Vec3::z() * 3.0;
    let definition = definition([1, 1, 1], &[Q::Orientation, Q::KineticStressOfRotation, Q::KineticStress]);
    let frame = compute(&definition, &sources(&scene, &[], vec![particle], Vec::new())).unwrap();
    let orientation = column(&frame, Q::Orientation);
    let wanted = [1.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0, 0.0, -0.5];
    assert!(orientation.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-15), "{orientation:?}");
    // trace = twice the energy of rotation about z, along which the rod does not lie; nearly all of it is motion along y
    let stress = column(&frame, Q::KineticStressOfRotation);
    let twice_energy = 2.0 * inertia[y] * 9.0;
    assert!((stress[0] + stress[4] - twice_energy).abs() < 1e-14 && stress[4] > 5.0 * stress[0], "{stress:?}");
    assert!(stress[8] == 0.0 && column(&frame, Q::KineticStress).iter().all(|x| x.abs() < 1e-15));
}

#[test]
fn empty_fields_are_zero_and_finite() {
    let scene = scene([false; 3], false);
    for grid in [
        unit_grid([3, 1, 2]),
        Grid {
            cylinder: Some(GridCylinder { point_m: [0.0; 3], axis: [0.0, 0.0, 1.0], zero: None }),
            ..unit_grid([3, 1, 2])
        },
    ] {
        let quantities: Vec<Q> = Q::ALL.into_iter().filter(|q| *q != Q::KineticStressAboutParticles).collect();
        let definition =
            FieldDefinition { wall_correction: true, ..FieldDefinition::new("all", grid, &quantities, 0.1) };
        let frame = compute(&definition, &sources(&scene, &[], Vec::new(), Vec::new())).unwrap();
        assert_eq!(frame.columns.len(), quantities.len());
        assert!(frame.columns.iter().all(|column| column.data.len() == 6 * column.components));
        assert!(frame.columns.iter().all(|column| column.data.iter().all(|&v| v == 0.0)));
    }
}

#[test]
fn unknown_contacts_are_an_error_that_says_so() {
    let scene = scene([false; 3], false);
    let mut sources = sources(&scene, &[], cloud(), Vec::new());
    sources.contacts = None;
    let refusal = compute(&definition([1, 1, 1], &[Q::Density, Q::Stress]), &sources).unwrap_err();
    assert!(refusal.to_string().contains("stress takes the contacts of step 0, which are not known"), "{refusal}");
    compute(&definition([1, 1, 1], &[Q::Density, Q::KineticStress]), &sources).unwrap();
}

#[test]
fn bad_definitions_are_refused_with_their_path() {
    type Change = fn(&mut FieldDefinition);
    let cases: [(&str, Change); 10] = [
        ("f.more_widths_m[1]", |d| d.more_widths_m = vec![0.1, -1.0]),
        ("f.kernel", |d| (d.kernel, d.quantities) = (FieldKernel::Heaviside, vec![Q::ShearRate])),
        ("f.grid.cells", |d| d.quantities = vec![Q::KineticStressAboutParticles]),
        ("f.grid.cells", |d| d.grid.cells = [u32::MAX; 3]),
        ("f.grid.max_m[1]", |d| {
            d.grid.max_m[1] = 6.4;
            d.grid.cylinder = Some(GridCylinder { point_m: [0.0; 3], axis: [1.0, 0.0, 0.0], zero: None });
        }),
        ("f.grid.cylinder.zero", |d| {
            let zero = Some([2.0, 0.0, 0.0]);
            d.grid.cylinder = Some(GridCylinder { point_m: [0.0; 3], axis: [1.0, 0.0, 0.0], zero });
        }),
        ("f.motion.velocity_m_per_s", |d| {
            d.motion = Some(GridMotion::Translation { velocity_m_per_s: [f64::NAN, 0.0, 0.0] });
        }),
        ("f.average.every_steps", |d| d.average = average(0, 1, 2)),
        ("f.average.samples_per_block", |d| d.average = average(1, 0, 2)),
        ("f.average.blocks", |d| d.average = average(1, 1, 1)),
    ];
    for (path, change) in cases {
        let mut definition = definition([3, 3, 3], &[Q::Density]);
        definition.validate("f").unwrap();
        change(&mut definition);
        assert_eq!(definition.validate("f").unwrap_err().path, path);
    }
}

fn average(every_steps: u64, samples_per_block: u64, blocks: u32) -> Option<super::FieldAverage> {
    Some(super::FieldAverage { every_steps, samples_per_block, blocks, window: Default::default(), from_time_s: 0.0 })
}
