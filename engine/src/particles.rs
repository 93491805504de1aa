//! The particles as columns, rows in spatial order: `[owned | ghosts]`, ghosts being shifted periodic images.

use rayon::prelude::*;

use crate::math::{Mat3, Quat, Similarity, Vec3};
use crate::parallel::least;

/// What a row needs to be made.
#[derive(Clone, Copy, Debug)]
pub struct NewParticle {
    /// Never reused.
    pub id: u64,
    /// Index of the shape.
    pub shape: u32,
    /// Index of the material.
    pub material: u32,
    /// Homothety.
    pub scale: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Principal moments of inertia, kg m2.
    pub inertia: Vec3,
    /// Bounding radius about the centre of mass, m.
    pub radius: f64,
    /// Centre of mass, m.
    pub position: Vec3,
    /// World from body.
    pub orientation: Quat,
    /// m/s.
    pub velocity: Vec3,
    /// World axes, rad/s.
    pub angular_velocity: Vec3,
    /// Keeps its velocity, whatever pushes.
    pub frozen: bool,
}

/// Columns by use. The first group moves, the second describes, the third is scratch of one step.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// Ids (n_owned).
    pub ids: Vec<u64>,
    /// Centre of mass, m (n_owned + n_ghosts).
    pub position: Vec<Vec3>,
    /// m/s (n_owned).
    pub velocity: Vec<Vec3>,
    /// World from body (n_owned).
    pub orientation: Vec<Quat>,
    /// World axes about the centre of mass, kg m2/s (n_owned).
    pub angular_momentum: Vec<Vec3>,
    /// Sum of the contact forces, N (n_owned).
    pub force: Vec<Vec3>,
    /// Sum of the contact torques about the centre of mass, world axes, N m (n_owned).
    pub torque: Vec<Vec3>,
    /// Periodic cells crossed since the insertion (n_owned).
    pub image: Vec<[i32; 3]>,

    /// Index of the shape (n_owned + n_ghosts).
    pub shape: Vec<u32>,
    /// Index of the material (n_owned + n_ghosts).
    pub material: Vec<u32>,
    /// Homothety of the shape (n_owned + n_ghosts).
    pub scale: Vec<f64>,
    /// Bounding radius, m (n_owned + n_ghosts).
    pub radius: Vec<f64>,
    /// kg (n_owned + n_ghosts).
    pub mass: Vec<f64>,
    /// Principal moments, kg m2 (n_owned).
    pub inertia: Vec<Vec3>,
    /// Keeps its velocity, whatever pushes (n_owned + n_ghosts); empty where nobody does.
    pub frozen: Vec<bool>,

    /// World from body as a matrix (n_owned + n_ghosts).
    pub rotation: Vec<Mat3>,
    /// Velocities that the contact laws see (n_owned + n_ghosts).
    pub motion: Vec<ContactMotion>,
    /// Whole periodic cells between `position` (always wrapped) and where the neighbour list saw the row, m
    /// (n_owned + n_ghosts). Two rows are `(x_b - x_a) + (o_b - o_a)` apart, in these very operations, so that the
    /// bits do not depend on when the list was rebuilt.
    pub offset: Vec<Vec3>,
    /// Bound on how far any point of the surface has moved since the row was made, added up over the steps, m
    /// (n_owned + n_ghosts). Two surfaces have closed in by at most the sum of what theirs have grown by.
    pub odometer: Vec<f64>,
    /// Which row a ghost is an image of (n_ghosts).
    pub ghost_owner: Vec<u32>,
    /// Offset of the ghost less that of its owner, m (n_ghosts).
    pub ghost_shift: Vec<Vec3>,
    /// What the sphere batch reads of every listed pair (n_owned + n_ghosts); empty where no two spheres are listed.
    pub places: Vec<Place>,
    scratch: SelectScratch,
}

/// Where a row is, in one cache line: a listed pair of spheres that does not touch needs no more than this.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub struct Place {
    /// m
    pub position: Vec3,
    /// Bounding radius, m.
    pub radius: f64,
    /// As [`Particles::offset`].
    pub offset: Vec3,
    /// Row that this one is an image of, or itself.
    pub owner: u32,
    /// Index of the material.
    pub material: u32,
}

/// Buffers of [`Particles::select`], one per type: 17 fresh columns per rebuild went to the system and back.
#[derive(Clone, Debug, Default)]
struct SelectScratch {
    id: Vec<u64>,
    index: Vec<u32>,
    number: Vec<f64>,
    vector: Vec<Vec3>,
    quaternion: Vec<Quat>,
    matrix: Vec<Mat3>,
    motion: Vec<ContactMotion>,
    image: Vec<[i32; 3]>,
    flag: Vec<bool>,
}

/// Velocities of one particle during the force evaluation, world axes.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactMotion {
    /// Predicted at the full step, m/s: a dashpot that lags by half a step makes the scheme first order.
    pub velocity: Vec3,
    /// Predicted at the full step, rad/s.
    pub angular_velocity: Vec3,
    /// Mean over the step, m/s: what the tangential spring stretches by.
    pub mean_velocity: Vec3,
    /// Mean over the step, rad/s.
    pub mean_angular_velocity: Vec3,
}

impl Particles {
    /// Rows that are not images.
    pub fn n_owned(&self) -> usize {
        self.ids.len()
    }

    /// Row that `row` is an image of, or itself.
    #[inline]
    pub fn owner(&self, row: usize) -> usize {
        if row < self.n_owned() { row } else { self.ghost_owner[row - self.n_owned()] as usize }
    }

    /// Appends an owned row; there must be no ghosts.
    pub fn push(&mut self, new: &NewParticle) {
        debug_assert!(self.ghost_owner.is_empty());
        let rotation = new.orientation.to_rotation_matrix().into_inner();
        if new.frozen && self.frozen.is_empty() {
            self.frozen.resize(self.ids.len(), false);
        }
        if new.frozen || !self.frozen.is_empty() {
            self.frozen.push(new.frozen);
        }
        self.ids.push(new.id);
        self.position.push(new.position);
        self.velocity.push(new.velocity);
        self.orientation.push(new.orientation);
        let angular_velocity_in_body = rotation.tr_mul(&new.angular_velocity);
        self.angular_momentum.push(rotation * new.inertia.component_mul(&angular_velocity_in_body));
        self.force.push(Vec3::zeros());
        self.torque.push(Vec3::zeros());
        self.image.push([0; 3]);
        self.shape.push(new.shape);
        self.material.push(new.material);
        self.scale.push(new.scale);
        self.radius.push(new.radius);
        self.mass.push(new.mass);
        self.inertia.push(new.inertia);
        self.rotation.push(rotation);
        self.motion.push(ContactMotion::default());
        self.offset.push(Vec3::zeros());
        self.odometer.push(0.0);
    }

    /// Forgets the ghosts.
    pub fn drop_ghosts(&mut self) {
        let n = self.n_owned();
        self.position.truncate(n);
        self.shape.truncate(n);
        self.material.truncate(n);
        self.scale.truncate(n);
        self.radius.truncate(n);
        self.mass.truncate(n);
        self.rotation.truncate(n);
        self.motion.truncate(n);
        self.offset.truncate(n);
        self.odometer.truncate(n);
        self.frozen.truncate(n);
        self.ghost_owner.clear();
        self.ghost_shift.clear();
    }

    /// Appends an image of `owner`.
    pub fn push_ghost(&mut self, owner: usize, shift: Vec3) {
        self.position.push(self.position[owner]);
        self.shape.push(self.shape[owner]);
        self.material.push(self.material[owner]);
        self.scale.push(self.scale[owner]);
        self.radius.push(self.radius[owner]);
        self.mass.push(self.mass[owner]);
        self.rotation.push(self.rotation[owner]);
        self.motion.push(self.motion[owner]);
        self.offset.push(self.offset[owner] + shift);
        self.odometer.push(self.odometer[owner]);
        if !self.frozen.is_empty() {
            self.frozen.push(self.frozen[owner]);
        }
        self.ghost_owner.push(owner as u32);
        self.ghost_shift.push(shift);
    }

    /// Writes the places of all rows, where `wanted`.
    pub fn update_places(&mut self, wanted: bool) {
        if !wanted {
            return;
        }
        let Self { places, position, radius, offset, material, ghost_owner, ghost_shift, .. } = self;
        let n = self.ids.len();
        let rows = position.len();
        places.resize(rows, Place::default());
        let place = |row: usize| {
            let (owner, shift) = match row.checked_sub(n) {
                None => (row, Vec3::zeros()),
                Some(k) => (ghost_owner[k] as usize, ghost_shift[k]),
            };
            Place {
                position: position[owner],
                radius: radius[owner],
                offset: offset[owner] + shift,
                owner: owner as u32,
                material: material[owner],
            }
        };
        places.par_iter_mut().enumerate().with_min_len(least(rows, 512, 3)).for_each(|(row, to)| *to = place(row));
    }

    /// Copies the moving columns of the owners to their ghosts.
    pub fn update_ghosts(&mut self) {
        let n = self.n_owned();
        for (k, (&owner, shift)) in self.ghost_owner.iter().zip(&self.ghost_shift).enumerate() {
            let owner = owner as usize;
            self.position[n + k] = self.position[owner];
            self.offset[n + k] = self.offset[owner] + shift;
            self.rotation[n + k] = self.rotation[owner];
            self.motion[n + k] = self.motion[owner];
            self.odometer[n + k] = self.odometer[owner];
        }
    }

    /// Puts the owned rows into the order `rows` (row `rows[k]` becomes row k); rows left out are removed.
    pub fn select(&mut self, rows: &[u32]) {
        debug_assert!(self.ghost_owner.is_empty());
        fn column<T: Copy>(values: &mut Vec<T>, rows: &[u32], scratch: &mut Vec<T>) {
            scratch.clear();
            scratch.extend(rows.iter().map(|&row| values[row as usize]));
            std::mem::swap(values, scratch);
        }
        let scratch = &mut self.scratch;
        column(&mut self.ids, rows, &mut scratch.id);
        column(&mut self.position, rows, &mut scratch.vector);
        column(&mut self.velocity, rows, &mut scratch.vector);
        column(&mut self.orientation, rows, &mut scratch.quaternion);
        column(&mut self.angular_momentum, rows, &mut scratch.vector);
        column(&mut self.force, rows, &mut scratch.vector);
        column(&mut self.torque, rows, &mut scratch.vector);
        column(&mut self.image, rows, &mut scratch.image);
        column(&mut self.shape, rows, &mut scratch.index);
        column(&mut self.material, rows, &mut scratch.index);
        column(&mut self.scale, rows, &mut scratch.number);
        column(&mut self.radius, rows, &mut scratch.number);
        column(&mut self.mass, rows, &mut scratch.number);
        column(&mut self.inertia, rows, &mut scratch.vector);
        column(&mut self.rotation, rows, &mut scratch.matrix);
        column(&mut self.motion, rows, &mut scratch.motion);
        column(&mut self.offset, rows, &mut scratch.vector);
        column(&mut self.odometer, rows, &mut scratch.number);
        if !self.frozen.is_empty() {
            column(&mut self.frozen, rows, &mut scratch.flag);
            if !self.frozen.contains(&true) {
                self.frozen.clear();
            }
        }
    }

    /// Whether a row or image keeps its velocity, whatever pushes.
    #[inline(always)]
    pub fn is_frozen(&self, row: usize) -> bool {
        !self.frozen.is_empty() && self.frozen[row]
    }

    /// Mass of two rows' relative motion, kg; one that is frozen has an infinite mass.
    #[inline(always)]
    pub fn reduced_mass(&self, a: usize, b: usize) -> f64 {
        let (mass_a, mass_b) = (self.mass[a], self.mass[b]);
        match [self.is_frozen(a), self.is_frozen(b)] {
            [false, false] => mass_a * mass_b / (mass_a + mass_b),
            [true, _] => mass_b,
            [false, true] => mass_a,
        }
    }

    /// Vector from `a` to `b`.
    #[inline(always)]
    pub fn separation(&self, a: usize, b: usize) -> Vec3 {
        (self.position[b] - self.position[a]) + (self.offset[b] - self.offset[a])
    }

    /// Body frame of `b`, `d` away, in the body frame and unit of `a`; and the unit of `a`, m.
    #[inline(always)]
    pub fn a_from_b(&self, a: usize, b: usize, d: &Vec3) -> (Similarity, f64) {
        let (rotation, scale) = (&self.rotation[a], self.scale[a]);
        let a_from_b = Similarity {
            rotation: rotation.tr_mul(&self.rotation[b]),
            translation: rotation.tr_mul(d) / scale,
            scale: self.scale[b] / scale,
        };
        (a_from_b, scale)
    }

    /// Angular velocity of an owned row in world axes, rad/s.
    pub fn angular_velocity(&self, row: usize) -> Vec3 {
        let in_body = self.rotation[row].tr_mul(&self.angular_momentum[row]).component_div(&self.inertia[row]);
        self.rotation[row] * in_body
    }

    /// Owned rows in ascending order of id.
    pub fn rows_by_id(&self) -> Vec<u32> {
        let mut rows: Vec<u32> = (0..self.n_owned() as u32).collect();
        rows.sort_unstable_by_key(|&row| self.ids[row as usize]);
        rows
    }
}
