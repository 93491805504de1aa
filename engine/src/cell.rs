//! The periodic cell.

use rayon::prelude::*;

use crate::math::Vec3;
use crate::parallel::least;
use crate::particles::Particles;
use crate::scene::DomainSection;

/// Periodic axes and their extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Lower corner, m.
    pub min: Vec3,
    /// Extent, m; meaningful along periodic axes.
    pub extent: Vec3,
    /// Which axes are periodic.
    pub periodic: [bool; 3],
}

impl Cell {
    /// From a validated section.
    pub fn new(domain: &DomainSection) -> Self {
        let min = Vec3::from(domain.min_m);
        Self { min, extent: Vec3::from(domain.max_m) - min, periodic: domain.periodic }
    }

    /// Whether any axis is periodic.
    pub fn is_periodic(&self) -> bool {
        self.periodic.contains(&true)
    }

    /// Brings a position into the cell; returns the cells it was moved by (0 for most).
    #[inline]
    pub fn wrap(&self, x: &mut Vec3) -> [i32; 3] {
        let mut cells = [0; 3];
        for axis in (0..3).filter(|&axis| self.periodic[axis]) {
            let length = self.extent[axis];
            let inside = x[axis] - self.min[axis];
            if inside < 0.0 || inside >= length {
                let moved = (inside / length).floor();
                x[axis] -= moved * length;
                cells[axis] = moved as i32;
            }
        }
        cells
    }

    /// Wraps all owned rows, remembering what was taken off.
    pub fn wrap_all(&self, particles: &mut Particles) {
        let n = particles.n_owned();
        let Particles { position, image, offset, .. } = particles;
        (&mut position[..n], image, &mut offset[..n]).into_par_iter().with_min_len(least(n, 512, 3)).for_each(
            |(position, image, offset)| {
                let cells = self.wrap(position);
                for (axis, &crossed) in cells.iter().enumerate().filter(|(_, crossed)| **crossed != 0) {
                    image[axis] += crossed;
                    offset[axis] += f64::from(crossed) * self.extent[axis];
                }
            },
        );
    }

    /// Shortest vector among the images of `d`.
    pub fn nearest_image(&self, mut d: Vec3) -> Vec3 {
        for axis in (0..3).filter(|&axis| self.periodic[axis]) {
            d[axis] -= (d[axis] / self.extent[axis]).round() * self.extent[axis];
        }
        d
    }

    /// Position in the infinite space of images.
    pub fn unwrapped(&self, x: &Vec3, image: [i32; 3]) -> Vec3 {
        Vec3::from_fn(
            |axis, _| if self.periodic[axis] { x[axis] + f64::from(image[axis]) * self.extent[axis] } else { x[axis] },
        )
    }

    /// Shortest periodic extent.
    pub fn shortest_periodic_extent(&self) -> f64 {
        (0..3).filter(|&axis| self.periodic[axis]).map(|axis| self.extent[axis]).fold(f64::INFINITY, f64::min)
    }
}
