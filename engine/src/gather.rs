//! Sum of the wrenches per particle, in the order of partners' ids: the same bits on any number of threads.

use rayon::prelude::*;

use crate::broad::Neighbours;
use crate::contact::ContactTable;
use crate::math::Vec3;
use crate::particles::Particles;

/// Writes force and torque of every owned row.
pub fn gather(particles: &mut Particles, table: &ContactTable, neighbours: &Neighbours) {
    let Particles { force, torque, .. } = particles;
    (force.par_iter_mut(), torque.par_iter_mut()).into_par_iter().enumerate().with_min_len(512).for_each(
        |(row, (force, torque))| {
            let (mut f, mut t) = (Vec3::zeros(), Vec3::zeros());
            for entry in neighbours.of_row(row) {
                let wrench = &table.wrenches[entry.slot()];
                if wrench.points == 0 {
                    continue;
                }
                if entry.is_b() {
                    f -= wrench.force;
                    t += wrench.torque_b;
                } else {
                    f += wrench.force;
                    t += wrench.torque_a;
                }
            }
            *force = f;
            *torque = t;
        },
    );
}
