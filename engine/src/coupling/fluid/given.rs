//! What the fluid gets from the particles, for whoever asks.

use super::super::exchange::{Exchange, ExchangeTotals};
use super::{Ahead, Derived, Fluid, poses, scatter_pending};
use crate::engine::Engine;
use crate::math::Vec3;

impl Engine {
    /// What the fluid gets from the particles, now. The run is not touched by it.
    pub fn exchange(&mut self) -> Option<Exchange> {
        self.fluid.as_ref().filter(|fluid| !fluid.state.sums.is_empty())?;
        self.in_pool(Self::exchange_in_pool)
    }

    fn exchange_in_pool(&mut self) -> Option<Exchange> {
        let scene = std::sync::Arc::clone(&self.written);
        let (step, epoch, time_s) = (self.clock.step(), self.topology_epoch, self.clock.time_s());
        let particles = &self.particles;
        let fluid = self.fluid.as_mut()?;
        let Fluid { state, derived, ahead } = fluid;
        let derived = derived.get_or_insert_with(|| Derived::new(state, &scene));
        let rows = particles.rows_by_id();
        let poses = poses(particles, &rows);
        let (operator, void_fraction) = derived.operator_at(&poses);
        let mut sums = state.sums.clone();
        scatter_pending(derived, &state.pending, &mut sums);
        let impulses = state.pending.iter().fold(state.totals, |sum, more| sum + *more);
        let mesh = derived.mesh.as_ref()?;
        let mut moving = vec![[0.0; 4]; sums.len()];
        let velocity = |slot: usize| {
            let volume = derived.volume(&poses[slot]);
            let [x, y, z] = (particles.velocity[rows[slot] as usize] * volume).into();
            [x, y, z, volume]
        };
        operator.scatter(velocity, &mut moving);
        let weights = |slot: usize| operator.row(slot).map(|(_, weight)| weight).sum::<f64>();
        let volumes = || (0..poses.len()).map(|slot| (derived.volume(&poses[slot]), weights(slot)));
        let free = rows.iter().map(|&row| row as usize).filter(|&row| !particles.is_frozen(row));
        let momentum: Vec3 = free.map(|row| particles.velocity[row] * particles.mass[row]).sum();
        let totals = ExchangeTotals {
            solid_volume_m3: volumes().map(|(volume, _)| volume).sum(),
            immersed_volume_m3: volumes().map(|(volume, weight)| volume * weight).sum(),
            outside: volumes().filter(|(_, weight)| *weight == 0.0).count() as u64,
            impulse_on_fluid_n_s: (-impulses.interaction).into(),
            pressure_impulse_n_s: impulses.pressure.into(),
            buoyancy_impulse_n_s: impulses.buoyancy.into(),
            momentum_kg_m_per_s: momentum.into(),
            refreshes: state.refreshes,
        };
        let over = time_s - state.counted_from_s;
        let per = |cell: usize| if over > 0.0 { 1.0 / (over * mesh.volume(cell)) } else { 0.0 };
        let column = |of: [usize; 3], sign: f64| -> Vec<[f64; 3]> {
            sums.iter().enumerate().map(|(cell, sum)| of.map(|k| sign * sum[k] * per(cell))).collect()
        };
        let exchange = Exchange {
            from_time_s: state.counted_from_s,
            time_s,
            step,
            topology_epoch: epoch,
            solid_velocity_m_per_s: moving
                .iter()
                .map(|[x, y, z, v]| if *v > 0.0 { [x / v, y / v, z / v] } else { [0.0; 3] })
                .collect(),
            interaction_n_per_m3: column([0, 1, 2], -1.0),
            pressure_force_n_per_m3: column([3, 4, 5], 1.0),
            drag_kg_per_m3_s: sums.iter().enumerate().map(|(cell, sum)| sum[6] * per(cell)).collect(),
            void_fraction: void_fraction.clone(),
            totals,
        };
        *ahead = Some(Ahead { step, epoch, operator, void_fraction });
        Some(exchange)
    }
}
