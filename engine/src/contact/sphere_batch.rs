//! Forces of sphere pairs: a pass over the listed pairs picks those that touch, a block at a time; their motion is collected
//! into columns, the law evaluated there ([`Lanes`]), and the answers handed out in the order of pairs.

use super::evaluate::ForceInputs;
use super::sphere_lanes::{BLOCK, Lanes, get, set};
use super::spheres::{ROWS, Side, SpherePair};
use super::table::Sums;
use crate::math::Vec3;
use crate::particles::Place;
use crate::scene::Tangential;

/// The columns of a stretch of chunks.
pub(super) struct Stretch<'a> {
    pub first_row: usize,
    pub pairs: &'a [SpherePair],
    pub springs: &'a mut [Vec3],
    pub on_b: &'a mut [Side],
    pub touching: &'a mut [bool],
    pub on_a: &'a mut [Side],
    pub sums: &'a mut [Sums],
}

/// A chunk to be evaluated by code for the instruction set at hand, chosen at run time; the bits do not depend on it.
struct ChunkTask<'a, 'b> {
    stretch: Stretch<'a>,
    first_pair: usize,
    inputs: &'b ForceInputs<'b>,
}

impl pulp::WithSimd for ChunkTask<'_, '_> {
    type Output = ();

    // What is inlined here, and only that, is compiled for each instruction set.
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        self.stretch.evaluate_blocks(self.first_pair, self.inputs);
    }
}

/// Touching pairs of a block.
struct Touches {
    /// Within the block.
    index: [u32; BLOCK],
    /// Row that owns side a.
    owner_a: [u32; BLOCK],
    /// Distances of the point from both centres, m.
    arms: [[f64; 2]; BLOCK],
}

impl Stretch<'_> {
    /// Splits down to single chunks. `starts` is that of all rows.
    pub fn evaluate(self, starts: &[u32], inputs: &ForceInputs<'_>, share: bool) {
        let chunks = self.sums.len();
        if chunks == 1 {
            let first_pair = starts[self.first_row] as usize;
            return self.evaluate_chunk(first_pair, inputs);
        }
        let rows = chunks / 2 * ROWS;
        let middle_row = self.first_row + rows;
        let pairs = (starts[middle_row] - starts[self.first_row]) as usize;
        let (springs, springs_right) = self.springs.split_at_mut(pairs);
        let (on_b, on_b_right) = self.on_b.split_at_mut(pairs);
        let (touching, touching_right) = self.touching.split_at_mut(pairs);
        let (on_a, on_a_right) = self.on_a.split_at_mut(rows);
        let (sums, sums_right) = self.sums.split_at_mut(chunks / 2);
        let left =
            Stretch { first_row: self.first_row, pairs: &self.pairs[..pairs], springs, on_b, touching, on_a, sums };
        let right = Stretch {
            first_row: middle_row,
            pairs: &self.pairs[pairs..],
            springs: springs_right,
            on_b: on_b_right,
            touching: touching_right,
            on_a: on_a_right,
            sums: sums_right,
        };
        if share {
            rayon::join(|| left.evaluate(starts, inputs, share), || right.evaluate(starts, inputs, share));
        } else {
            left.evaluate(starts, inputs, share);
            right.evaluate(starts, inputs, share);
        }
    }

    fn evaluate_chunk(self, first_pair: usize, inputs: &ForceInputs<'_>) {
        pulp::Arch::new().dispatch(ChunkTask { stretch: self, first_pair, inputs });
    }

    #[inline(always)]
    fn evaluate_blocks(&mut self, first_pair: usize, inputs: &ForceInputs<'_>) {
        let friction = inputs.tangential == Tangential::CoulombHistory && inputs.pairs.any_friction();
        let stretch_time_s = friction.then_some(inputs.stretch_time_s);
        let mut sums = Sums::default();
        self.on_a.fill(Side::default());
        let mut touches = Touches { index: [0; BLOCK], owner_a: [0; BLOCK], arms: [[0.0; 2]; BLOCK] };
        let mut lanes = Lanes::new();
        let mut deepest = Deepest::default();
        for first in (0..self.pairs.len()).step_by(BLOCK) {
            let count = self.find_touching(first, &inputs.particles.places, &mut touches, &mut lanes);
            self.load((first, count), &mut touches, &mut lanes, (inputs, first_pair, &mut deepest));
            lanes.evaluate(count, inputs.contact_end, stretch_time_s);
            self.store((first, count), &touches, &lanes, &mut sums);
        }
        if deepest.overlap > 0.0 {
            sums.largest_overlap = deepest.absolute;
            (sums.largest_ratio, sums.largest_slot) = (deepest.overlap / deepest.smaller, deepest.index);
        }
        self.sums[0] = sums;
    }

    /// Writes the touching pairs of a block to the front of `touches` and `lanes` (the square of the distance for the
    /// distance) and returns their number; clears what has parted. What does not touch is to cost little.
    #[inline(always)]
    fn find_touching(&mut self, first: usize, places: &[Place], touches: &mut Touches, lanes: &mut Lanes) -> usize {
        let last = (first + BLOCK).min(self.pairs.len());
        let (springs, on_b) = (&mut self.springs[first..last], &mut self.on_b[first..last]);
        let mut count = 0;
        for (index, (pair, was)) in self.pairs[first..last].iter().zip(&mut self.touching[first..last]).enumerate() {
            let (a, b) = (&places[pair.a as usize], &places[pair.b as usize]);
            // In these very operations wherever two rows are compared: see `Particles::offset`.
            let d = (b.position - a.position) + (b.offset - a.offset);
            let distance2 = d.norm_squared();
            let reach = a.radius + b.radius;
            let touching = distance2 < reach * reach;
            let k = count & (BLOCK - 1);
            touches.index[k] = index as u32;
            lanes.distance[k] = distance2;
            set(&mut lanes.normal, k, &d);
            count += usize::from(touching);
            if *was && !touching {
                springs[index] = Vec3::zeros();
                on_b[index] = Side::default();
            }
            *was = touching;
        }
        count
    }

    /// Collects what the laws read. Velocities at the point differ by `v_a - v_b + (l_a w_a + l_b w_b) x n`.
    #[inline(always)]
    fn load(
        &self,
        (first, count): (usize, usize),
        touches: &mut Touches,
        lanes: &mut Lanes,
        (inputs, first_pair, deepest): (&ForceInputs<'_>, usize, &mut Deepest),
    ) {
        let (motion, places) = (inputs.particles.motion.as_slice(), inputs.particles.places.as_slice());
        for k in 0..count.min(BLOCK) {
            let index = first + touches.index[k] as usize;
            let pair = &self.pairs[index];
            let (a, b) = (&places[pair.a as usize], &places[pair.b as usize]);
            let (of_a, of_b) = (&motion[a.owner as usize], &motion[b.owner as usize]);
            let distance = lanes.distance[k].sqrt();
            let overlap = (a.radius + b.radius) - distance;
            let [arm_a, arm_b] = [a.radius - 0.5 * overlap, b.radius - 0.5 * overlap];
            (touches.owner_a[k], touches.arms[k]) = (a.owner, [arm_a, arm_b]);
            deepest.take(overlap, a.radius.min(b.radius), first_pair + index);
            (lanes.distance[k], lanes.overlap[k]) = (distance, overlap);
            set(&mut lanes.velocity, k, &(of_a.velocity - of_b.velocity));
            set(&mut lanes.mean_velocity, k, &(of_a.mean_velocity - of_b.mean_velocity));
            set(&mut lanes.turning, k, &(of_a.angular_velocity * arm_a + of_b.angular_velocity * arm_b));
            let mean_turning = of_a.mean_angular_velocity * arm_a + of_b.mean_angular_velocity * arm_b;
            set(&mut lanes.mean_turning, k, &mean_turning);
            set(&mut lanes.spring, k, &self.springs[index]);
            let law = inputs.pairs.law(a.material, b.material);
            lanes.stiffness[k] = law.stiffness;
            lanes.damping[k] = pair.damping;
            lanes.tangential_stiffness[k] = law.tangential_stiffness;
            lanes.tangential_damping[k] = pair.damping * law.tangential_damping_ratio;
            lanes.friction[k] = law.friction;
        }
    }

    /// Hands the answers out, in the order of pairs.
    #[inline(always)]
    fn store(&mut self, (first, count): (usize, usize), touches: &Touches, lanes: &Lanes, sums: &mut Sums) {
        for k in 0..count.min(BLOCK) {
            let index = first + touches.index[k] as usize;
            let (force, twist) = (get(&lanes.force, k), get(&lanes.twist, k));
            let on_a = &mut self.on_a[touches.owner_a[k] as usize - self.first_row];
            on_a.force += force;
            on_a.torque += twist * touches.arms[k][0];
            self.on_b[index] = Side { force: -force, torque: twist * touches.arms[k][1] };
            self.springs[index] = get(&lanes.spring, k);
            sums.elastic_normal += lanes.elastic[0][k];
            sums.elastic_tangential += lanes.elastic[1][k];
            sums.power_normal += lanes.power[0][k];
            sums.power_tangential += lanes.power[1][k];
        }
        sums.points_by_kind[0] += count as u64;
    }
}

/// The largest overlap over the smaller radius, compared without a division.
#[derive(Default)]
struct Deepest {
    absolute: f64,
    overlap: f64,
    smaller: f64,
    index: u32,
}

impl Deepest {
    #[inline(always)]
    fn take(&mut self, overlap: f64, smaller: f64, index: usize) {
        let absolute = self.absolute.max(overlap);
        if overlap * self.smaller > self.overlap * smaller || self.smaller == 0.0 {
            *self = Self { absolute, overlap, smaller, index: index as u32 };
        }
        self.absolute = absolute;
    }
}
