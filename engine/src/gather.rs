//! Sum of the wrenches per particle, in the order of partners' ids: the same bits on any number of threads.

use rayon::prelude::*;

use crate::broad::Neighbours;
use crate::contact::ContactTable;
use crate::math::Vec3;
use crate::parallel::least;
use crate::particles::Particles;

/// Writes force and torque of every owned row: sphere pairs first, then the slots.
pub fn gather(particles: &mut Particles, table: &ContactTable, neighbours: &Neighbours) {
    let rows = particles.n_owned();
    let Particles { force, torque, .. } = particles;
    let (spheres, has_slots) = (&table.spheres, !table.slots.is_empty());
    (force.par_iter_mut(), torque.par_iter_mut())
        .into_par_iter()
        .enumerate()
        .with_min_len(least(rows, 512, 15))
        .for_each(|(row, (force, torque))| {
            let (mut f, mut t) = spheres.sum_of_row(row);
            if has_slots {
                add_slots(row, table, neighbours, &mut f, &mut t);
            }
            *force = f;
            *torque = t;
        });
}

fn add_slots(row: usize, table: &ContactTable, neighbours: &Neighbours, f: &mut Vec3, t: &mut Vec3) {
    for entry in neighbours.of_row(row) {
        let wrench = &table.wrenches[entry.slot()];
        if wrench.points == 0 {
            continue;
        }
        if entry.is_b() {
            *f -= wrench.force;
            *t += wrench.torque_b;
        } else {
            *f += wrench.force;
            *t += wrench.torque_a;
        }
    }
}
