//! The p-norm of the overlaps, and its gradient as a force and a moment.

use super::Term;
use crate::math::Vec3;

/// x^(p-2) and x^(1/p) for one p, by multiplications and roots where p allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PNorm {
    p: f64,
    /// p - 2 if p is an integer.
    less_two: Option<i32>,
    /// m if p = 2^m.
    halvings: Option<u32>,
}

impl PNorm {
    /// For p >= 2.
    pub fn new(p: f64) -> Self {
        let integer = p.fract() == 0.0;
        let whole = p as u32;
        Self {
            p,
            less_two: integer.then_some(whole as i32 - 2),
            halvings: (integer && whole.is_power_of_two()).then(|| whole.trailing_zeros()),
        }
    }

    /// p.
    pub fn p(&self) -> f64 {
        self.p
    }

    #[inline(always)]
    fn power_less_two(&self, x: f64) -> f64 {
        self.less_two.map_or_else(|| x.powf(self.p - 2.0), |n| x.powi(n))
    }

    #[inline(always)]
    fn root(&self, x: f64) -> f64 {
        self.halvings.map_or_else(|| x.powf(1.0 / self.p), |m| (0..m).fold(x, |x, _| x.sqrt()))
    }
}

/// The generalized overlap and its gradient; frame and unit of the terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlap {
    /// D.
    pub value: f64,
    /// -dD/dx of `b`: force on `b` per unit of the scalar force, `a` takes the opposite.
    pub force: Vec3,
    /// Moment of that about the origin of `a`.
    pub moment: Vec3,
}

/// A point of the contact, as dashpots and friction see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapPoint {
    /// Halfway between the surfaces.
    pub position: Vec3,
    /// Unit, from `a` to `b`.
    pub normal: Vec3,
    /// g = w rho^(p-1), rho = d/D: its part of the scalar force.
    pub share: f64,
    /// w rho^(p-2): its dashpot against rocking.
    pub rocking: f64,
}

/// D = (sum w d^p)^(1/p) with its gradient; appends one point per term.
///
/// Per unit of the scalar force, a term pushes `b` with g n and, where its weight changes, with -h grad w,
/// h = (D/p) rho^p. There must be at least one term, and every term overlaps.
pub fn aggregate(terms: &[Term], norm: &PNorm, points: &mut Vec<OverlapPoint>) -> Overlap {
    let deepest = terms.iter().map(|term| term.overlap).fold(0.0, f64::max);
    let sum: f64 = terms
        .iter()
        .map(|term| {
            let x = term.overlap / deepest;
            term.weight * (norm.power_less_two(x) * (x * x))
        })
        .sum();
    let value = deepest * norm.root(sum);
    let mut overlap = Overlap { value, ..Overlap::default() };
    for term in terms {
        let rho = term.overlap / value;
        let power = norm.power_less_two(rho);
        let rocking = term.weight * power;
        let share = rocking * rho;
        let force = term.normal * share;
        overlap.force += force;
        overlap.moment += term.position.cross(&force);
        if let Some((gradient, moment)) = &term.weight_gradient {
            let h = value / norm.p * (power * (rho * rho));
            overlap.force -= gradient * h;
            overlap.moment -= moment * h;
        }
        points.push(OverlapPoint { position: term.position, normal: term.normal, share, rocking });
    }
    overlap
}
