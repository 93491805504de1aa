//! All sums of one state, for every width.

use std::f64::consts::PI;

use super::definition::FieldDefinition;
use super::deposit::{Deposit, LineSource, PointSource};
use super::kernel::Kernel;
use super::lattice::Lattice;
use super::layout::{Group, Layout};
use super::pose::Pose;
use super::quantity::FieldQuantity;
use super::shape_points::shape_points;
use super::sources::{FieldParticle, FieldSources};
use super::walls::Walls;
use crate::cell::Cell;
use crate::math::{Mat3, Vec3};

/// Sums of the cells of one state.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sample {
    /// Velocity that momenta are told from, in the axes of the grid, m/s.
    pub reference: Vec3,
    /// For each width the sums of each cell, shape (nx, ny, nz, sums).
    pub widths: Vec<Vec<f64>>,
}

/// Samples a state; momenta are told from `reference`, else from the mean velocity, so that fluctuations keep their
/// digits.
pub(super) fn sample(definition: &FieldDefinition, sources: &FieldSources<'_>, reference: Option<Vec3>) -> Sample {
    let sampler = Sampler::new(definition, sources, reference);
    Sample { reference: sampler.reference, widths: definition.widths_m().map(|width| sampler.width(width)).collect() }
}

/// What all widths share.
struct Sampler<'a> {
    definition: &'a FieldDefinition,
    sources: &'a FieldSources<'a>,
    layout: Layout,
    lattice: Lattice,
    pose: Pose,
    reference: Vec3,
    /// Rows of the particles.
    rows: Vec<f64>,
    /// Farthest support, m.
    reach: f64,
    narrowest: f64,
}

impl<'a> Sampler<'a> {
    fn new(definition: &'a FieldDefinition, sources: &'a FieldSources<'a>, reference: Option<Vec3>) -> Self {
        let grid = &definition.grid;
        let pose = Pose::of_grid(&Pose::of_motion(definition, sources), grid.cylinder.as_ref());
        let narrowest = definition.widths_m().fold(f64::INFINITY, f64::min);
        let reach = definition.widths_m().fold(0.0, f64::max) * definition.cutoff_widths;
        let lattice = Lattice::new(grid, narrowest);
        let reference = reference.unwrap_or_else(|| {
            let mass = sources.total_mass();
            let mean = if mass > 0.0 { sources.total_momentum() / mass } else { Vec3::zeros() };
            let mean = pose.rotation.tr_mul(&mean);
            // local axes differ from point to point: only the one along a cylinder is the same everywhere
            if grid.cylinder.is_some() { Vec3::new(0.0, 0.0, mean.z) } else { mean }
        });
        let layout = Layout::of(&definition.quantities);
        let mut sampler =
            Self { definition, sources, layout, lattice, pose, reference, rows: Vec::new(), reach, narrowest };
        sampler.rows = sampler.particle_rows();
        sampler
    }

    fn width(&self, width: f64) -> Vec<f64> {
        let support = width * self.definition.cutoff_widths;
        let kernel = Kernel::new(self.definition.kernel, width, support, self.lattice.dimensions());
        let walls =
            self.definition.wall_correction.then(|| Walls::new(self.sources, &self.pose, &self.lattice, &kernel));
        let walls = walls.as_ref();
        let deposit = Deposit { lattice: &self.lattice, kernel: &kernel, layout: &self.layout };
        let mut sums = deposit.empty();
        let images = self.particle_images(&self.lattice, walls);
        if self.layout.of_particles > 0 || self.layout.has(Group::SecondMoment) {
            deposit.particles(&images, &self.rows, &mut sums);
        }
        if let Some(at) = self.layout.place(Group::ShapeVolume) {
            let (points, volumes) = self.shape_images(walls);
            deposit.points(&points, (&volumes, 1, at), &mut sums);
        }
        if let Some(at) = self.layout.place(Group::Peculiar) {
            self.add_peculiar(&deposit, (&images, walls), at, &mut sums);
        }
        let lines = self.lines(walls);
        if !lines.is_empty() {
            deposit.lines(&lines, &mut sums);
        }
        if let Some(at) = self.layout.place(Group::WallForce) {
            let (points, forces) = self.wall_points(walls);
            deposit.points(&points, (&forces, 3, at), &mut sums);
        }
        if let Some(walls) = walls {
            walls.clear_behind(&self.lattice, self.layout.size, &mut sums);
        }
        self.lattice.reduced(&sums, &self.layout)
    }

    fn velocity(&self, particle: &FieldParticle) -> Vec3 {
        self.pose.rotation.tr_mul(&particle.velocity) - self.reference
    }

    fn particle_rows(&self) -> Vec<f64> {
        let axes: Vec<usize> =
            self.sources.scene.shapes().iter().map(|shape| self.definition.body_axis.of(shape)).collect();
        let mut rows = Vec::with_capacity(self.sources.particles.len() * self.layout.of_particles);
        for particle in &self.sources.particles {
            for (group, _) in self.layout.groups().filter(|(group, _)| group.is_of_particles()) {
                self.push_group(group, particle, axes[particle.shape as usize], &mut rows);
            }
        }
        rows
    }

    fn push_group(&self, group: Group, particle: &FieldParticle, axis: usize, row: &mut Vec<f64>) {
        let (mass, turned) = (particle.mass, |v: &Vec3| self.pose.rotation.tr_mul(v));
        let symmetric = |m: Mat3| [m[(0, 0)], m[(0, 1)], m[(0, 2)], m[(1, 1)], m[(1, 2)], m[(2, 2)]];
        match group {
            Group::Mass => row.push(mass),
            Group::Volume => row.push(particle.volume),
            Group::Momentum => row.extend((self.velocity(particle) * mass).iter()),
            Group::Kinetic => {
                let u = self.velocity(particle);
                row.extend(symmetric(u * u.transpose() * mass));
            }
            Group::Spin => row.extend((turned(&particle.angular_velocity) * mass).iter()),
            Group::Rotational => {
                let turn = self.pose.rotation.tr_mul(&particle.rotation);
                let spin = turned(&particle.angular_velocity).cross_matrix() * turn;
                row.extend(symmetric(spin * Mat3::from_diagonal(&particle.euler) * spin.transpose() * mass));
            }
            Group::Axes => {
                let n = turned(&particle.rotation.column(axis).into_owned());
                row.extend(symmetric((n * n.transpose() * 3.0 - Mat3::identity()) * 0.5));
            }
            Group::Number => row.push(1.0),
            Group::Coordination => row.extend(particle.neighbours),
            Group::Diameter => row.push((6.0 / PI * particle.volume).cbrt()),
            _ => {}
        }
    }

    /// Particles and their images that reach into the lattice, in the order of ids.
    fn particle_images(&self, lattice: &Lattice, walls: Option<&Walls>) -> Vec<PointSource> {
        let images = Images::new(lattice, &self.pose, self.sources.scene.cell(), self.reach);
        let mut all = Vec::with_capacity(self.sources.particles.len());
        for (row, particle) in self.sources.particles.iter().enumerate() {
            images.each(&particle.position, 0.0, |x| push_point(&mut all, lattice, walls, (x, row)));
        }
        all
    }

    /// Points that stand for the true volumes, and the volume of each.
    fn shape_images(&self, walls: Option<&Walls>) -> (Vec<PointSource>, Vec<f64>) {
        let images = Images::new(&self.lattice, &self.pose, self.sources.scene.cell(), self.reach);
        let shapes = self.sources.scene.shapes();
        let of_shapes: Vec<Vec<Vec3>> = shapes.iter().map(|shape| shape_points(shape, self.narrowest)).collect();
        let (mut all, mut volumes) = (Vec::new(), Vec::new());
        for particle in &self.sources.particles {
            let points = &of_shapes[particle.shape as usize];
            let row = volumes.len();
            volumes.push(particle.volume / points.len() as f64);
            for point in points {
                let x = particle.position + particle.rotation * point * particle.scale;
                images.each(&x, 0.0, |x| push_point(&mut all, &self.lattice, walls, (x, row)));
            }
        }
        (all, volumes)
    }

    /// Fluctuations about the field at each particle, which is interpolated between the cells.
    fn add_peculiar(
        &self,
        deposit: &Deposit<'_>,
        (images, walls): (&[PointSource], Option<&Walls>),
        at: usize,
        sums: &mut [f64],
    ) {
        let layout = Layout::of(&[FieldQuantity::Velocity]);
        let lattice = self.lattice.padded(self.reach, self.narrowest);
        let rows: Vec<f64> = self
            .sources
            .particles
            .iter()
            .flat_map(|particle| {
                let momentum = self.velocity(particle) * particle.mass;
                [particle.mass, momentum.x, momentum.y, momentum.z]
            })
            .collect();
        let around = self.particle_images(&lattice, walls);
        let wide = Deposit { lattice: &lattice, kernel: deposit.kernel, layout: &layout };
        let mut moments = wide.empty();
        wide.points(&around, (&rows, 4, 0), &mut moments);
        if let Some(walls) = walls {
            walls.clear_behind(&lattice, layout.size, &mut moments);
        }
        let velocities: Vec<Option<Vec3>> = lattice
            .reduced(&moments, &layout)
            .chunks_exact(4)
            .map(|cell| (cell[0] > 0.0).then(|| Vec3::new(cell[1], cell[2], cell[3]) / cell[0]))
            .collect();
        let mut squares = Vec::with_capacity(6 * images.len());
        let mut points = Vec::with_capacity(images.len());
        for (k, image) in images.iter().enumerate() {
            let particle = &self.sources.particles[image.row as usize];
            let own = self.velocity(particle);
            let v = own - lattice.interpolated(&velocities, &image.position).unwrap_or(own);
            squares
                .extend([v.x * v.x, v.x * v.y, v.x * v.z, v.y * v.y, v.y * v.z, v.z * v.z].map(|s| particle.mass * s));
            points.push(PointSource { row: k as u32, ..*image });
        }
        deposit.points(&points, (&squares, 6, at), sums);
    }

    /// Branches of the contacts, with their images.
    fn lines(&self, walls: Option<&Walls>) -> Vec<LineSource> {
        let Some(contacts) = &self.sources.contacts else { return Vec::new() };
        let places = [self.layout.place(Group::PairStress), self.layout.place(Group::BoundaryStress)];
        let images = Images::new(&self.lattice, &self.pose, self.sources.scene.cell(), self.reach);
        let mut lines = Vec::new();
        for contact in contacts {
            let Some(at) = places[usize::from(contact.is_at_boundary)] else { continue };
            let along = self.pose.rotation.tr_mul(&contact.branch);
            let force = self.pose.rotation.tr_mul(&contact.force);
            // sigma = f b with b = x_a - x_b
            let tensor = std::array::from_fn(|k| -force[k / 3] * along[k % 3]);
            let middle = contact.start + contact.branch * 0.5;
            images.each(&middle, 0.5 * contact.branch.norm(), |middle| {
                let start = middle - along * 0.5;
                let Some(part) = part_within(&self.lattice, &start, &along) else { return };
                let mut line = LineSource { start, along, part, at, tensor, nodes: None };
                if let Some(walls) = walls {
                    walls.correct(&mut line);
                }
                lines.push(line);
            });
        }
        lines
    }

    /// Contact points at boundaries and the force on these.
    fn wall_points(&self, walls: Option<&Walls>) -> (Vec<PointSource>, Vec<f64>) {
        let images = Images::new(&self.lattice, &self.pose, self.sources.scene.cell(), self.reach);
        let (mut points, mut forces) = (Vec::new(), Vec::new());
        for contact in self.sources.contacts.iter().flatten().filter(|contact| contact.is_at_boundary) {
            let row = forces.len() / 3;
            forces.extend((-self.pose.rotation.tr_mul(&contact.force)).iter());
            let x = contact.start + contact.branch;
            images.each(&x, 0.0, |x| push_point(&mut points, &self.lattice, walls, (x, row)));
        }
        (points, forces)
    }
}

fn push_point(all: &mut Vec<PointSource>, lattice: &Lattice, walls: Option<&Walls>, (x, row): (Vec3, usize)) {
    if lattice.is_within(&x) {
        let factor = lattice.homogeneous_factor() * walls.map_or(1.0, |walls| walls.factor(&x));
        all.push(PointSource { position: x, row: row as u32, factor });
    }
}

/// The part of a line within the extent along homogeneous axes.
fn part_within(lattice: &Lattice, start: &Vec3, along: &Vec3) -> Option<std::ops::Range<f64>> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in (0..3).filter(|&axis| !lattice.active[axis]) {
        let (low, high) = lattice.bounds(axis);
        if along[axis] == 0.0 {
            if !(start[axis] >= low && start[axis] < high) {
                return None;
            }
            continue;
        }
        let ends = [(low - start[axis]) / along[axis], (high - start[axis]) / along[axis]];
        from = from.max(ends[0].min(ends[1]));
        to = to.min(ends[0].max(ends[1]));
    }
    (from < to).then_some(from..to)
}

/// Finds the periodic images that come near the lattice.
struct Images<'a> {
    pose: &'a Pose,
    cell: &'a Cell,
    low: Vec3,
    high: Vec3,
}

impl<'a> Images<'a> {
    /// Within `reach` of the lattice's bounds.
    fn new(lattice: &Lattice, pose: &'a Pose, cell: &'a Cell, reach: f64) -> Self {
        let bounds = [0, 1, 2].map(|axis| lattice.bounds(axis));
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for corner in 0..8 {
            let corner = Vec3::from_fn(|axis, _| if corner >> axis & 1 == 0 { bounds[axis].0 } else { bounds[axis].1 });
            let corner = pose.in_world(&corner);
            (low, high) = (low.inf(&corner), high.sup(&corner));
        }
        Self { pose, cell, low: low.add_scalar(-reach), high: high.add_scalar(reach) }
    }

    /// Calls `f` with each image of `x`, in the frame of the grid, that is within `radius` of the bounds.
    fn each(&self, x: &Vec3, radius: f64, mut f: impl FnMut(Vec3)) {
        let shifts: [(i64, i64); 3] = std::array::from_fn(|axis| {
            if !self.cell.periodic[axis] {
                return (0, 0);
            }
            let length = self.cell.extent[axis];
            let first = ((self.low[axis] - radius - x[axis]) / length).ceil();
            let last = ((self.high[axis] + radius - x[axis]) / length).floor();
            (first as i64, last as i64)
        });
        for i in shifts[0].0..=shifts[0].1 {
            for j in shifts[1].0..=shifts[1].1 {
                for k in shifts[2].0..=shifts[2].1 {
                    let mut image = *x;
                    for (axis, shift) in [i, j, k].into_iter().enumerate().filter(|(_, shift)| *shift != 0) {
                        image[axis] += shift as f64 * self.cell.extent[axis];
                    }
                    f(self.pose.in_frame(&image));
                }
            }
        }
    }
}
