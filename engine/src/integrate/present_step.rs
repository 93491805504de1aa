//! The critical step of the contacts that are there: several on one body add up, by how many and where they point.

use nalgebra::{Matrix6, Vector6};

use super::critical_step::largest_stable_product;
use crate::boundary::WallSide;
use crate::contact::law::PairLaw;
use crate::contact::{ContactTable, SlotKind};
use crate::math::Vec3;
use crate::particles::Particles;
use crate::scene::Scene;

/// Squared frequencies that the contacts of each body would give it if its partners stood still, as 6 x 6 matrices of
/// translations (over the root of the mass) and rotations (over those of the moments of inertia, body axes).
struct Frequencies<'a> {
    particles: &'a Particles,
    of_body: Vec<Matrix6<f64>>,
    /// Least omega dt that the laws met so far are stable at.
    product: f64,
}

impl Frequencies<'_> {
    /// A spring of stiffness `k` along the unit vector (or generalized force) `force` with moment `moment` about the
    /// centre of the row.
    fn add(&mut self, row: usize, k: f64, force: &Vec3, moment: &Vec3) {
        let particles = self.particles;
        if particles.is_frozen(row) {
            return;
        }
        let owner = particles.owner(row);
        let linear = force / particles.mass[owner].sqrt();
        let turning = particles.rotation[owner].tr_mul(moment).component_div(&particles.inertia[owner].map(f64::sqrt));
        let direction = Vector6::new(linear.x, linear.y, linear.z, turning.x, turning.y, turning.z);
        self.of_body[owner].ger(k, &direction, &direction, 1.0);
    }

    /// The same for both sides of a contact at `arm` from the centre of `a`; `b` is a row and its centre seen from `a`.
    /// A wall or a frozen particle has no frequency of its own: its contacts count half, because the bound below doubles them.
    fn add_spring(&mut self, a: usize, b: Option<(usize, Vec3)>, k: f64, direction: &Vec3, arm: &Vec3) {
        let stands = |row: usize| self.particles.is_frozen(row);
        let k = if stands(a) || b.is_none_or(|(row, _)| stands(row)) { 0.5 * k } else { k };
        self.add(a, k, direction, &arm.cross(direction));
        if let Some((row, centre)) = b {
            self.add(row, k, direction, &(arm - centre).cross(direction));
        }
    }

    /// A normal and two tangential springs.
    fn add_point(&mut self, a: usize, b: Option<(usize, Vec3)>, k: [f64; 2], normal: &Vec3, arm: &Vec3) {
        self.add_spring(a, b, k[0], normal, arm);
        if k[1] > 0.0 {
            let first = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
            self.add_spring(a, b, k[1], &first, arm);
            self.add_spring(a, b, k[1], &normal.cross(&first), arm);
        }
    }

    fn meet(&mut self, law: &PairLaw, reduced_mass: f64) {
        let zeta = law.raw_damping.map_or(law.damping_ratio, |c| 0.5 * c / (law.stiffness * reduced_mass).sqrt());
        self.product = self.product.min(largest_stable_product(zeta));
    }

    /// omega^2 <= 2 max over bodies of the largest eigenvalue: (x_i - x_j)^2 <= 2 x_i^2 + 2 x_j^2. Row sums bound the
    /// eigenvalues, so that few have to be computed.
    fn step_s(self) -> f64 {
        let mut bounds: Vec<(f64, usize)> = self
            .of_body
            .iter()
            .enumerate()
            .map(|(k, m)| (m.row_iter().map(|row| row.abs().sum()).fold(0.0, f64::max), k))
            .collect();
        bounds.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let mut largest = 0.0f64;
        for (bound, k) in bounds {
            if bound <= largest {
                break;
            }
            largest = largest.max(self.of_body[k].symmetric_eigenvalues().max());
        }
        self.product / (2.0 * largest).sqrt()
    }
}

/// Largest stable step of the contacts present, s; infinite without any.
///
/// An estimate from below: springs only, at their present directions, arms and (generalized overlap: with the p-norm's
/// stiffening between points) overlaps; the damping ratio by the law's limit; a bound on the coupling of bodies.
pub(crate) fn present_critical_step(particles: &Particles, table: &ContactTable, scene: &Scene) -> f64 {
    let n = particles.n_owned();
    let mut frequencies = Frequencies { particles, of_body: vec![Matrix6::zeros(); n], product: 2.0 };
    add_spheres(&mut frequencies, table, scene);
    for (index, contact) in table.contacts() {
        let Some(side) = Side::of(index, particles, table, scene) else { continue };
        frequencies.meet(side.law, side.reduced_mass);
        let k = side.stiffnesses(scene).map(|k| k * contact.weight);
        frequencies.add_point(side.a, side.b, k, &contact.normal, &contact.arm);
    }
    add_overlaps(&mut frequencies, table, scene);
    frequencies.step_s()
}

/// Who touches in a slot.
struct Side<'a> {
    a: usize,
    b: Option<(usize, Vec3)>,
    law: &'a PairLaw,
    reduced_mass: f64,
}

impl<'a> Side<'a> {
    fn of(index: usize, particles: &Particles, table: &ContactTable, scene: &'a Scene) -> Option<Self> {
        let slot = &table.slots[index];
        let (a, b) = (slot.a as usize, slot.b as usize);
        let material = |row: usize| particles.material[particles.owner(row)] as usize;
        let mass = |row: usize| particles.mass[particles.owner(row)];
        if slot.kind.is_wall() {
            let boundary = WallSide::of(scene.boundaries(), slot.b).boundary;
            let law = scene.pairs().get(material(a), boundary.material as usize)?;
            return Some(Self { a, b: None, law, reduced_mass: mass(a) });
        }
        let law = scene.pairs().get(material(a), material(b))?;
        let reduced_mass = particles.reduced_mass(a, b);
        Some(Self { a, b: Some((b, particles.separation(a, b))), law, reduced_mass })
    }

    fn stiffnesses(&self, scene: &Scene) -> [f64; 2] {
        let sticks = scene.plan().history && self.law.friction > 0.0;
        [self.law.stiffness, if sticks { self.law.tangential_stiffness } else { 0.0 }]
    }
}

fn add_spheres(frequencies: &mut Frequencies<'_>, table: &ContactTable, scene: &Scene) {
    let particles = frequencies.particles;
    for pair in table.spheres.touching_pairs() {
        let (a, b) = (pair.a as usize, pair.b as usize);
        let material = |row: usize| particles.material[particles.owner(row)] as usize;
        let Some(law) = scene.pairs().get(material(a), material(b)) else { continue };
        // images of the sphere batch are kept up to date by place only
        let (at_a, at_b) = (&particles.places[a], &particles.places[b]);
        let d = (at_b.position - at_a.position) + (at_b.offset - at_a.offset);
        let side = Side { a, b: Some((b, d)), law, reduced_mass: particles.reduced_mass(a, b) };
        frequencies.meet(law, side.reduced_mass);
        let normal = d.try_normalize(0.0).unwrap_or_else(Vec3::x);
        frequencies.add_point(a, side.b, side.stiffnesses(scene), &normal, &(normal * particles.radius[a]));
    }
}

fn add_overlaps(frequencies: &mut Frequencies<'_>, table: &ContactTable, scene: &Scene) {
    let Some(rounded) = scene.rounded() else { return };
    let particles = frequencies.particles;
    for (chunk_index, chunk) in table.chunks.iter().enumerate() {
        for contact in &chunk.overlaps.contacts {
            let index = chunk_index * crate::contact::CHUNK + contact.slot as usize;
            debug_assert!(matches!(table.slots[index].kind, SlotKind::RoundedParts | SlotKind::RoundedWall));
            let Some(side) = Side::of(index, particles, table, scene) else { continue };
            frequencies.meet(side.law, side.reduced_mass);
            let stiffening = rounded.law.present_stiffening(contact.overlap, contact.radius_sum);
            let [normal, tangential] = side.stiffnesses(scene);
            let first = contact.first_point as usize;
            let points = &chunk.overlaps.points[first..first + contact.points[0] as usize];
            let p = rounded.geometry.as_ref().map(|geometry| geometry.norm.p());
            if let Some(p) = p {
                for point in points {
                    // k (p - 1) w rho^(p-2) n n^T is above the Hessian of k D^2/2 by the depths
                    let k = normal * stiffening * (p - 1.0) * point.rocking;
                    frequencies.add_spring(side.a, side.b, k, &point.normal, &point.position);
                }
            } else {
                let k = normal * if side.b.is_none() { 0.5 } else { 1.0 };
                frequencies.add(side.a, k, &contact.force, &contact.moment);
                if let Some((b, d)) = side.b {
                    frequencies.add(b, k, &contact.force, &(contact.moment - d.cross(&contact.force)));
                }
            }
            let total: f64 = points.iter().map(|point| point.share).sum();
            if tangential > 0.0 && total > 0.0 {
                let centre = points.iter().map(|point| point.position * point.share).sum::<Vec3>() / total;
                let normal = contact.force.try_normalize(0.0).unwrap_or_else(Vec3::x);
                frequencies.add_point(side.a, side.b, [0.0, tangential], &normal, &centre);
            }
        }
    }
}
