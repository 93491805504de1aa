//! Initial overlaps taken apart before step 0: over-damped, with a bound on the way of each iteration.
//!
//! Every body moves along its contact force (springs alone: no weight, no dashpots, no friction) by so much that a contact
//! of it with its like closes without overshooting, however heavy its partner, and never by more than a part of its
//! thickness. Polyhedra meet by points meanwhile: the other laws end at overlaps that are to be taken apart here. Velocities
//! are left as they were given. Bodies move row by row, so the result is the same on any number of threads.

use rayon::prelude::*;

use crate::engine::Engine;
use crate::error::StepError;
use crate::math::{Quat, Vec3};
use crate::parallel::least;
use crate::particles::{ContactMotion, Particles};
use crate::scene::RelaxSection;

/// Overlap over the mean rounding radius at which rounded polyhedra count as relaxed: half of where their law ends.
const RELAXED_ROUNDING: f64 = 1.0;

impl Engine {
    /// Takes the overlaps of the start apart, where the scene asks for it.
    pub(crate) fn relax(&mut self) -> Result<(), StepError> {
        let Some(section) = self.scene.description().relax.clone() else { return Ok(()) };
        // ids count from 0 at the start; a rebuild re-sorts rows
        let spins: Vec<Vec3> = {
            let particles = &self.particles;
            particles.rows_by_id().into_iter().map(|row| particles.angular_velocity(row as usize)).collect()
        };
        let mobility = self.scene.relaxation_times_squared(self.written.particles());
        self.particles.motion.fill(ContactMotion::default());
        self.neighbours.invalidate();
        self.relaxing = true;
        let outcome = self.descend(&section, &mobility);
        self.relaxing = false;
        self.contacts.clear();
        let particles = &mut self.particles;
        for row in 0..particles.n_owned() {
            let in_body = particles.rotation[row].tr_mul(&spins[particles.ids[row] as usize]);
            particles.angular_momentum[row] = particles.rotation[row] * in_body.component_mul(&particles.inertia[row]);
        }
        outcome
    }

    fn descend(&mut self, section: &RelaxSection, mobility: &[f64]) -> Result<(), StepError> {
        let mut iterations = 0;
        loop {
            self.rebuild_neighbours_if_stale(self.clock.time_s());
            self.find_contacts();
            self.evaluate_with(0.0);
            self.sums = self.contacts.sums();
            if self.sums.largest_ratio <= section.overlap_ratio && self.sums.largest_rounding <= RELAXED_ROUNDING {
                return Ok(());
            }
            if iterations == section.max_iterations {
                return Err(self.not_relaxed(section));
            }
            self.gather_forces();
            let plan = self.scene.plan();
            let shapes = (&plan.rotates[..], &plan.half_thickness[..]);
            move_along(&mut self.particles, mobility, section.displacement_fraction, shapes);
            self.wrap_into_cell();
            iterations += 1;
        }
    }

    fn not_relaxed(&self, section: &RelaxSection) -> StepError {
        let by_radius = self.sums.largest_ratio > section.overlap_ratio;
        let (slot, overlap, limit, measure) = if by_radius {
            (self.sums.largest_slot, self.sums.largest_ratio, section.overlap_ratio, "of its bounding radius")
        } else {
            (self.sums.rounding_slot, self.sums.largest_rounding, RELAXED_ROUNDING, "of the rounding radius")
        };
        let (a, b) = self.sides(slot);
        StepError::NotRelaxed { a, b, overlap, limit, measure, iterations: section.max_iterations }
    }
}

/// Moves and turns the owned rows along force and torque; by shape: whether it turns, and its half-thickness, m.
fn move_along(
    particles: &mut Particles,
    mobility: &[f64],
    displacement_fraction: f64,
    (rotates, half_thickness): (&[bool], &[f64]),
) {
    let n = particles.n_owned();
    let Particles { ids, position, orientation, rotation, odometer, force, torque, shape, frozen, .. } = particles;
    let frozen = &*frozen;
    let (scale, radius, mass, inertia) = (&particles.scale, &particles.radius, &particles.mass, &particles.inertia);
    (&mut position[..n], &mut orientation[..n], &mut rotation[..n], &mut odometer[..n])
        .into_par_iter()
        .enumerate()
        .with_min_len(least(n, 512, 15))
        .for_each(|(row, (position, orientation, rotation, odometer))| {
            if !frozen.is_empty() && frozen[row] {
                return;
            }
            let (time2, shape) = (mobility[ids[row] as usize], shape[row] as usize);
            let way = force[row] * (time2 / mass[row]);
            let turn = if rotates[shape] {
                *rotation * (rotation.tr_mul(&torque[row]).component_div(&inertia[row]) * time2)
            } else {
                Vec3::zeros()
            };
            let path = way.norm() + turn.norm() * radius[row];
            // a force that is no number moves nothing: the overlap that gives it stays, and is named
            if path == 0.0 || !path.is_finite() {
                return;
            }
            let most = displacement_fraction * half_thickness[shape] * scale[row];
            let part = (most / path).min(1.0);
            *position += way * part;
            if rotates[shape] {
                *orientation = Quat::new_normalize((Quat::from_scaled_axis(turn * part) * *orientation).into_inner());
                *rotation = orientation.to_rotation_matrix().into_inner();
            }
            *odometer += path * part * (1.0 + 1e-9);
        });
}
