//! Spheres that fall one after the other to local minima of height: a loose bed without any mechanics.
//!
//! Each particle is stood for by its circumscribed sphere, which drops at a random place onto the floor of a box or onto what
//! lies there, and rolls down by steepest descent ([`super::descent`]) until three others (or walls, or the floor) hold it.
//! Source: Visscher and Bolsterli, Nature 239 (1972) 504; as Camenen and Descantes (2012) and Descantes (2022), section
//! 3.1.1, prepare their beds. Cost: a few events per particle, each a look at the grid cells around.

use std::collections::HashMap;

use super::descent::{Descent, Obstacle};
use super::region::region_volume;
use super::space::boundary_touched_by;
use super::{MOST_PARTICLES, Request, Surroundings};
use crate::cell::Cell;
use crate::error::InvalidInput;
use crate::math::Vec3;
use crate::particles::NewParticle;
use crate::random::{Draw, Purpose};
use crate::scene::{Placement, Region};

/// Drops and arcs of one particle: far more than any takes; beyond it something is degenerate, and another place is drawn.
const MOST_EVENTS: usize = 2000;
/// Places drawn for one particle.
const ATTEMPTS: usize = 100;
/// Gap over the radius that counts as touching, and overlap that is rounding.
const TOUCH: f64 = 1e-9;

impl Request<'_> {
    /// The particles of a placement by deposition.
    pub(super) fn deposit(
        &self,
        surroundings: &Surroundings<'_>,
        path: &str,
    ) -> Result<Vec<NewParticle>, InvalidInput> {
        let Placement::Deposition { region, count, fixed_orientation } = &self.description.placement else {
            unreachable!("called for depositions only")
        };
        let error = |problem: String| InvalidInput::new(format!("{path}.placement"), problem);
        let Region::Box { min_m, max_m } = region else {
            return Err(InvalidInput::new(format!("{path}.placement.region"), "must be a box for a deposition"));
        };
        region_volume(region, &format!("{path}.placement.region"))?;
        if u64::from(*count) > MOST_PARTICLES {
            return Err(error(format!("asks for {count} particles; at most {MOST_PARTICLES} are allowed")));
        }
        let largest = self.shape.bounding_radius() * self.description.scale.range()[1];
        let (min, max) = (Vec3::from(*min_m), Vec3::from(*max_m));
        let mut bed = Bed::new([min, max], surroundings.scene.cell(), largest);
        if let Some(axis) = (0..2).find(|&axis| !bed.periodic[axis] && bed.extent[axis] < 2.0 * largest) {
            let problem = format!(
                "is {:e} m wide along {}, and the largest sphere needs {:e} m",
                bed.extent[axis],
                ["x", "y"][axis],
                2.0 * largest
            );
            return Err(InvalidInput::new(format!("{path}.placement.region"), problem));
        }
        surroundings.present.iter().for_each(|particle| bed.add(particle.position, particle.radius));
        let mut particles = Vec::with_capacity(*count as usize);
        for k in 0..u64::from(*count) {
            let id = surroundings.first_id + k;
            let mut particle = self.particle(id, Vec3::zeros(), self.orientation(id, !fixed_orientation));
            let mut draw = Draw::new(self.seed, id, Purpose::Position);
            let settled = (0..ATTEMPTS).find_map(|_| bed.settle(particle.radius, &mut draw));
            let Some(centre) = settled else {
                return Err(error(format!("no place holds particle {k} of the request")));
            };
            if centre.z + particle.radius > max.z {
                let problem = format!(
                    "particle {k} of the request lies at {:e} m, above the region: make it higher, or ask for {k}",
                    centre.z
                );
                return Err(error(problem));
            }
            particle.position = centre;
            if let Some(boundary) = boundary_touched_by(&particle, surroundings) {
                let problem =
                    format!("particle {k} of the request touches the boundary '{boundary}': keep the region off it");
                return Err(error(problem));
            }
            bed.add(centre, particle.radius);
            particles.push(particle);
        }
        Ok(particles)
    }
}

#[derive(Clone, Copy, Debug)]
struct Sphere {
    centre: Vec3,
    radius: f64,
}

/// Spheres at rest, by grid cell, on a floor between walls or periodic sides.
struct Bed {
    min: Vec3,
    max: Vec3,
    extent: Vec3,
    /// Along x and y.
    periodic: [bool; 2],
    /// Width of a grid cell along each axis, m.
    size: Vec3,
    /// Grid cells along x and y, where it is periodic.
    cells: [i64; 2],
    spheres: Vec<Sphere>,
    by_cell: HashMap<[i64; 3], Vec<u32>>,
    largest: f64,
    top: f64,
}

impl Bed {
    fn new([min, max]: [Vec3; 2], cell: &Cell, largest: f64) -> Self {
        let extent = max - min;
        // a side is periodic where the region spans the whole cell
        let spans = |axis: usize| {
            let off = (min[axis] - cell.min[axis]).abs() + (extent[axis] - cell.extent[axis]).abs();
            cell.periodic[axis] && off <= 1e-9 * extent[axis]
        };
        let periodic = [spans(0), spans(1)];
        let mut size = Vec3::repeat(2.0 * largest);
        let cells = [0, 1].map(|axis| {
            let count = (extent[axis] / size[axis]).floor().max(1.0);
            if periodic[axis] {
                size[axis] = extent[axis] / count;
            }
            count as i64
        });
        let (spheres, by_cell) = (Vec::new(), HashMap::new());
        Self { min, max, extent, periodic, size, cells, spheres, by_cell, largest, top: min.z }
    }

    fn key(&self, x: &Vec3) -> [i64; 3] {
        std::array::from_fn(|axis| ((x[axis] - self.min[axis]) / self.size[axis]).floor() as i64)
    }

    fn wrap(&self, mut x: Vec3) -> Vec3 {
        for axis in (0..2).filter(|&axis| self.periodic[axis]) {
            x[axis] = self.min[axis] + (x[axis] - self.min[axis]).rem_euclid(self.extent[axis]);
        }
        x
    }

    fn add(&mut self, centre: Vec3, radius: f64) {
        let centre = self.wrap(centre);
        self.largest = self.largest.max(radius);
        self.top = self.top.max(centre.z + radius);
        let key = self.cell_and_shift(self.key(&centre)).0;
        self.by_cell.entry(key).or_default().push(self.spheres.len() as u32);
        self.spheres.push(Sphere { centre, radius });
    }

    /// The cell that a cell of the infinite space is an image of, and by how much it is moved, m.
    fn cell_and_shift(&self, mut key: [i64; 3]) -> ([i64; 3], Vec3) {
        let mut shift = Vec3::zeros();
        for axis in (0..2).filter(|&axis| self.periodic[axis]) {
            shift[axis] = key[axis].div_euclid(self.cells[axis]) as f64 * self.extent[axis];
            key[axis] = key[axis].rem_euclid(self.cells[axis]);
        }
        (key, shift)
    }

    /// Spheres, images included, of all grid cells that a box around `x` meets.
    fn visit(&self, x: &Vec3, half: Vec3, mut see: impl FnMut(&Sphere)) {
        let (from, to) = (self.key(&(x - half)), self.key(&(x + half)));
        for i in from[0]..=to[0] {
            for j in from[1]..=to[1] {
                for k in from[2]..=to[2] {
                    let (key, shift) = self.cell_and_shift([i, j, k]);
                    for &index in self.by_cell.get(&key).into_iter().flatten() {
                        let Sphere { centre, radius } = self.spheres[index as usize];
                        see(&Sphere { centre: centre + shift, radius });
                    }
                }
            }
        }
    }

    /// Planes that a centre of a sphere of this radius keeps off.
    fn planes(&self, radius: f64) -> impl Iterator<Item = Obstacle> {
        let floor = Obstacle::Plane { normal: Vec3::z(), offset: self.min.z + radius };
        let walls = (0..2).filter(|&axis| !self.periodic[axis]).flat_map(move |axis| {
            let normal = Vec3::ith(axis, 1.0);
            [
                Obstacle::Plane { normal, offset: self.min[axis] + radius },
                Obstacle::Plane { normal: -normal, offset: radius - self.max[axis] },
            ]
        });
        std::iter::once(floor).chain(walls)
    }

    /// All that a centre at `x` could meet within a way.
    fn obstacles(&self, x: &Vec3, radius: f64, way: f64) -> Vec<Obstacle> {
        let mut found: Vec<Obstacle> = self.planes(radius).filter(|plane| plane.gap(x) <= way).collect();
        self.visit(x, Vec3::repeat(way + radius + self.largest), |sphere| {
            let ball = Obstacle::Ball { centre: sphere.centre, reach: sphere.radius + radius };
            if ball.gap(x) <= way {
                found.push(ball);
            }
        });
        found
    }

    /// Drops a sphere at a random place; its centre once it rests, unless nothing holds it there.
    fn settle(&self, radius: f64, draw: &mut Draw) -> Option<Vec3> {
        let inset = Vec3::from_fn(|axis, _| if axis < 2 && !self.periodic[axis] { radius } else { 0.0 });
        let mut x = draw.in_box(&(self.min + inset), &(self.max - inset));
        x.z = self.top + 2.0 * radius;
        for _ in 0..MOST_EVENTS {
            let touch = TOUCH * radius;
            let touched = self.obstacles(&x, radius, touch);
            x = match Descent::of(&x, &touched) {
                Descent::Drop => self.dropped(&x, radius, &touched),
                Descent::Roll(arc, on) => {
                    let mut angle = arc.end;
                    for obstacle in self.obstacles(&x, radius, arc.diameter()) {
                        if on.contains(&obstacle) {
                            continue;
                        }
                        // what is touched and not rolled on lets the centre go
                        let least = if touched.contains(&obstacle) { TOUCH } else { 0.0 };
                        if let Some(met) = arc.meets(&obstacle).filter(|&met| met >= least) {
                            angle = angle.min(met);
                        }
                    }
                    arc.at(angle)
                }
                Descent::Rest => return self.is_held(&x, radius).then_some(x),
            };
            x = self.wrap(x);
        }
        None
    }

    /// Straight down to the floor, or to the first sphere that is not just being left.
    fn dropped(&self, x: &Vec3, radius: f64, touched: &[Obstacle]) -> Vec3 {
        let reach = radius + self.largest;
        let mut landed = self.min.z + radius;
        let mut layer = *x;
        while layer.z + self.size.z + reach > landed {
            self.visit(&layer, Vec3::new(reach, reach, 0.0), |sphere| {
                let ball = Obstacle::Ball { centre: sphere.centre, reach: sphere.radius + radius };
                let off = x - sphere.centre;
                let rise2 = (sphere.radius + radius).powi(2) - off.xy().norm_squared();
                if rise2 > 0.0 && sphere.centre.z < x.z && !touched.contains(&ball) {
                    landed = landed.max(sphere.centre.z + rise2.sqrt());
                }
            });
            layer.z -= self.size.z;
        }
        Vec3::new(x.x, x.y, landed)
    }

    /// Whether it lies on the floor or touches three others or walls, and overlaps with none.
    fn is_held(&self, x: &Vec3, radius: f64) -> bool {
        let touched = self.obstacles(x, radius, TOUCH * radius);
        let floor = touched.iter().any(|obstacle| matches!(obstacle, Obstacle::Plane { normal, .. } if normal.z > 0.0));
        touched.iter().all(|obstacle| obstacle.gap(x) >= -TOUCH * radius) && (floor || touched.len() >= 3)
    }
}
