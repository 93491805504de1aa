//! Sums into quantities.

use super::definition::{FieldColumn, FieldDefinition};
use super::layout::{Group, KINDS, Layout};
use super::quantity::FieldQuantity;
use crate::math::{Mat3, Vec3};

/// Columns of the definition from the sums of all cells, each divided by `samples`.
pub(super) fn columns(definition: &FieldDefinition, sums: &[f64], samples: u64, reference: &Vec3) -> Vec<FieldColumn> {
    let layout = Layout::of(&definition.quantities);
    let cells = sums.len() / layout.size;
    let per_sample = if samples > 0 { 1.0 / samples as f64 } else { 0.0 };
    let of = |quantity: FieldQuantity| {
        let components = quantity.components();
        let mut data = Vec::with_capacity(cells * components);
        for cell in sums.chunks_exact(layout.size) {
            CellSums { layout: &layout, sums: cell, per_sample, reference }.push(quantity, &mut data);
        }
        FieldColumn { quantity, components, data, standard_error: None }
    };
    definition.quantities.iter().map(|&quantity| of(quantity)).collect()
}

/// The sums of one cell.
struct CellSums<'a> {
    layout: &'a Layout,
    sums: &'a [f64],
    per_sample: f64,
    reference: &'a Vec3,
}

impl CellSums<'_> {
    fn numbers(&self, group: Group) -> &[f64] {
        let at = self.layout.place(group).expect("the layout has all groups of its quantities");
        &self.sums[at..at + group.kind().size()]
    }

    fn scalar(&self, group: Group) -> f64 {
        self.numbers(group)[0] * self.per_sample
    }

    fn vector(&self, group: Group) -> Vec3 {
        Vec3::from_column_slice(self.numbers(group)) * self.per_sample
    }

    fn symmetric(&self, group: Group) -> Mat3 {
        let s = self.numbers(group);
        Mat3::new(s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]) * self.per_sample
    }

    fn tensor(&self, group: Group) -> Mat3 {
        Mat3::from_row_slice(self.numbers(group)) * self.per_sample
    }

    /// A ratio that is 0 where there is nothing.
    fn over<T: std::ops::Div<f64, Output = T> + Default>(&self, value: T, by: f64) -> T {
        if by > 0.0 { value / by } else { T::default() }
    }

    /// Velocity less the reference.
    fn relative_velocity(&self) -> Vec3 {
        self.over(self.vector(Group::Momentum), self.scalar(Group::Mass))
    }

    fn velocity(&self) -> Vec3 {
        let is_there = self.scalar(Group::Mass) > 0.0;
        if is_there { self.relative_velocity() + self.reference } else { Vec3::zeros() }
    }

    fn kinetic_stress(&self) -> Mat3 {
        let momentum = self.vector(Group::Momentum);
        let mut stress = self.symmetric(Group::Kinetic) - momentum * self.relative_velocity().transpose();
        // a lone particle's is 0 up to rounding
        (0..3).for_each(|k| stress[(k, k)] = stress[(k, k)].max(0.0));
        stress
    }

    fn velocity_gradient(&self) -> Mat3 {
        let of_momentum = self.tensor(Group::MomentumGradient);
        let of_mass = self.vector(Group::MassGradient);
        self.over(of_momentum - self.relative_velocity() * of_mass.transpose(), self.scalar(Group::Mass))
    }

    fn shear_rate(&self) -> f64 {
        let gradient = self.velocity_gradient();
        let strain = (gradient + gradient.transpose()) * 0.5;
        let deviator = strain - Mat3::identity() * (strain.trace() / 3.0);
        (2.0 * deviator.norm_squared()).sqrt()
    }

    fn stress_of_gradient(&self) -> Mat3 {
        let gradient = self.velocity_gradient();
        gradient * self.symmetric(Group::SecondMoment) * gradient.transpose()
    }

    fn contact_stress(&self) -> Mat3 {
        self.tensor(Group::PairStress) + self.tensor(Group::BoundaryStress)
    }

    fn pressure(&self) -> f64 {
        (self.contact_stress() + self.kinetic_stress()).trace() / 3.0
    }

    fn inertial_number(&self) -> f64 {
        let (pressure, volume) = (self.pressure(), self.scalar(Group::Volume));
        if !(pressure > 0.0 && volume > 0.0) {
            return 0.0;
        }
        let diameter = self.over(self.scalar(Group::Diameter), self.scalar(Group::Number));
        self.shear_rate() * diameter * (self.scalar(Group::Mass) / volume / pressure).sqrt()
    }

    fn push(&self, quantity: FieldQuantity, out: &mut Vec<f64>) {
        use FieldQuantity as Q;
        // nalgebra keeps matrices by columns
        let rows = |m: Mat3| m.transpose();
        match quantity {
            Q::SolidFraction => out.push(self.scalar(Group::Volume)),
            Q::SolidFractionOfShapes => out.push(self.scalar(Group::ShapeVolume)),
            Q::Density => out.push(self.scalar(Group::Mass)),
            Q::NumberDensity => out.push(self.scalar(Group::Number)),
            Q::Momentum => {
                out.extend((self.vector(Group::Momentum) + self.reference * self.scalar(Group::Mass)).iter())
            }
            Q::Velocity => out.extend(self.velocity().iter()),
            Q::AngularVelocity => out.extend(self.over(self.vector(Group::Spin), self.scalar(Group::Mass)).iter()),
            Q::VelocityGradient => out.extend(rows(self.velocity_gradient()).iter()),
            Q::ShearRate => out.push(self.shear_rate()),
            Q::ContactStress => out.extend(rows(self.contact_stress()).iter()),
            Q::ContactStressPairs => out.extend(rows(self.tensor(Group::PairStress)).iter()),
            Q::ContactStressBoundaries => out.extend(rows(self.tensor(Group::BoundaryStress)).iter()),
            Q::KineticStress => out.extend(self.kinetic_stress().iter()),
            Q::KineticStressAboutParticles => out.extend(self.symmetric(Group::Peculiar).iter()),
            Q::KineticStressOfGradient => out.extend(self.stress_of_gradient().iter()),
            Q::KineticStressScaleFree => out.extend((self.kinetic_stress() - self.stress_of_gradient()).iter()),
            Q::KineticStressOfRotation => out.extend(self.symmetric(Group::Rotational).iter()),
            Q::Stress => out.extend(rows(self.contact_stress() + self.kinetic_stress()).iter()),
            Q::Pressure => out.push(self.pressure()),
            Q::SecondMoment => {
                out.extend(self.over(self.symmetric(Group::SecondMoment), self.scalar(Group::Mass)).iter());
            }
            Q::GranularTemperature => {
                out.push(self.over(self.kinetic_stress().trace() / 3.0, self.scalar(Group::Mass)));
            }
            Q::Orientation => out.extend(self.over(self.symmetric(Group::Axes), self.scalar(Group::Number)).iter()),
            Q::Coordination => {
                let number = self.scalar(Group::Number);
                let counts = self.numbers(Group::Coordination);
                out.extend((0..KINDS).map(|k| self.over(counts[k] * self.per_sample, number)));
            }
            Q::InertialNumber => out.push(self.inertial_number()),
            Q::WallForceDensity => out.extend(self.vector(Group::WallForce).iter()),
        }
    }
}
