//! The fluid as a particle finds it where it is.

use rayon::prelude::*;

use super::description::FluidFields;
use super::operator::Operator;
use crate::checkpoint::codec::pack_fields;
use crate::math::Vec3;

/// Sums over the cells with a particle's weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Values {
    /// m/s
    pub velocity: Vec3,
    /// Pa/m
    pub pressure_gradient: Vec3,
    /// m/s2
    pub acceleration: Vec3,
    /// rad/s
    pub vorticity: Vec3,
}

/// What a particle finds, from one look at where it is to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// Sum of its weights: the part of it that is in the fluid.
    pub immersed: f64,
    /// Mean over its weights.
    pub void_fraction: f64,
    /// At the start of the ramp.
    pub from: Values,
    /// At its end, and after.
    pub to: Values,
}

pack_fields!(Values { velocity: Vec3, pressure_gradient: Vec3, acceleration: Vec3, vorticity: Vec3 });
pack_fields!(Seen { immersed: f64, void_fraction: f64, from: Values, to: Values });

impl Values {
    /// Of a fluid that is the same everywhere.
    pub fn uniform(velocity: Vec3) -> Self {
        Self { velocity, ..Self::default() }
    }

    /// Between two.
    pub fn mix(from: &Self, to: &Self, part: f64) -> Self {
        if part >= 1.0 {
            return *to;
        }
        let mix = |a: &Vec3, b: &Vec3| a + (b - a) * part;
        Self { velocity: mix(&from.velocity, &to.velocity), vorticity: mix(&from.vorticity, &to.vorticity), ..*to }
    }
}

/// Mean of a column over weights; an empty one is 0.
fn mean(column: &[[f64; 3]], row: impl Iterator<Item = (usize, f64)>, over: f64) -> Vec3 {
    if column.is_empty() || over == 0.0 {
        return Vec3::zeros();
    }
    row.map(|(cell, weight)| Vec3::from(column[cell]) * weight).sum::<Vec3>() / over
}

fn values(fields: &FluidFields, operator: &Operator, particle: usize, over: f64) -> Values {
    let mean = |column: &[[f64; 3]]| mean(column, operator.row(particle), over);
    Values {
        velocity: mean(&fields.velocity_m_per_s),
        pressure_gradient: mean(&fields.pressure_gradient_pa_per_m),
        acceleration: mean(&fields.acceleration_m_per_s2),
        vorticity: mean(&fields.vorticity_rad_per_s),
    }
}

/// Of all particles of an operator.
pub(super) fn look(operator: &Operator, [from, to]: [&FluidFields; 2], void_fraction: &[f64]) -> Vec<Seen> {
    (0..operator.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|particle| {
            let immersed: f64 = operator.row(particle).map(|(_, weight)| weight).sum();
            let void: f64 = operator.row(particle).map(|(cell, weight)| weight * void_fraction[cell]).sum();
            Seen {
                immersed,
                void_fraction: if immersed > 0.0 { void / immersed } else { 1.0 },
                from: values(from, operator, particle, immersed),
                to: values(to, operator, particle, immersed),
            }
        })
        .collect()
}
