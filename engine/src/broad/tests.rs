//! The grid against all pairs.

use proptest::prelude::*;

use super::{NeighbourInputs, Neighbours, ShapeReach};
use crate::cell::Cell;
use crate::math::{Quat, Vec3};
use crate::particles::{NewParticle, Particles};
use crate::scene::DomainSection;
use crate::shape::{Shape, ShapeDescription};

const SKIN_FRACTION: f64 = 0.2;

/// Radii and places of spheres, and the extent of the periodic axes (0 where there is none).
#[derive(Clone, Debug)]
struct Cloud {
    radii: Vec<f64>,
    places: Vec<[f64; 3]>,
    extent: [f64; 3],
}

impl Cloud {
    fn cell(&self) -> Cell {
        let periodic = self.extent.map(|length| length > 0.0);
        Cell::new(&DomainSection { min_m: [0.0; 3], max_m: self.extent, periodic, ..DomainSection::default() })
    }

    fn particles(&self) -> Particles {
        let mut particles = Particles::default();
        let cell = self.cell();
        for (id, (&radius, place)) in (0..).zip(self.radii.iter().zip(&self.places)) {
            let mut position = Vec3::from(*place);
            cell.wrap(&mut position);
            particles.push(&NewParticle {
                id,
                shape: 0,
                material: 0,
                scale: radius,
                mass: 1.0,
                inertia: Vec3::repeat(1.0),
                radius,
                position,
                orientation: Quat::identity(),
                velocity: Vec3::zeros(),
                angular_velocity: Vec3::zeros(),
                frozen: false,
            });
        }
        particles
    }

    /// (lower id, higher id) of all listed pairs, once per image; and the skin.
    fn listed(&self) -> (Vec<[u64; 2]>, f64) {
        self.listed_up_to(usize::MAX).unwrap()
    }

    /// The same where there are no more than `most_pairs`.
    fn listed_up_to(&self, most_pairs: usize) -> Option<(Vec<[u64; 2]>, f64)> {
        let shape = Shape::build(&ShapeDescription::Sphere { radius_m: 1.0 }).unwrap();
        let reaches = [ShapeReach::of(&shape)];
        let cell = self.cell();
        let shapes = [shape];
        let inputs = NeighbourInputs {
            shapes: &shapes,
            reaches: &reaches,
            boundaries: &[],
            rounded: false,
            sphere_batch: true,
            cell: &cell,
            bonds: None,
            skin_fraction: SKIN_FRACTION,
            most_pairs,
            time_s: 0.0,
        };
        let mut particles = self.particles();
        let mut neighbours = Neighbours::default();
        let mut slots = Vec::new();
        let fits = neighbours.rebuild(&mut particles, &inputs, &mut slots);
        assert!(slots.is_empty());
        let id = |row: u32| particles.ids[particles.owner(row as usize)];
        let pairs: Vec<[u64; 2]> = neighbours.sphere_pairs().flatten().map(|&[a, b]| [id(a), id(b)]).collect();
        assert!(fits || pairs.is_empty());
        fits.then(|| (sorted(pairs), neighbours.skin))
    }

    /// The same by looking at all pairs and all images.
    fn all_pairs(&self, skin: f64) -> Vec<[u64; 2]> {
        let particles = self.particles();
        let shifts = self.extent.map(|length| if length > 0.0 { vec![-length, 0.0, length] } else { vec![0.0] });
        let mut pairs = Vec::new();
        for a in 0..self.radii.len() {
            for b in a + 1..self.radii.len() {
                let reach = self.radii[a] + self.radii[b] + skin;
                let d = particles.position[b] - particles.position[a];
                for &x in &shifts[0] {
                    for &y in &shifts[1] {
                        for &z in &shifts[2] {
                            if (d + Vec3::new(x, y, z)).norm_squared() < reach * reach {
                                pairs.push([a as u64, b as u64]);
                            }
                        }
                    }
                }
            }
        }
        sorted(pairs)
    }
}

fn sorted(mut pairs: Vec<[u64; 2]>) -> Vec<[u64; 2]> {
    pairs.sort_unstable();
    pairs
}

/// Sizes over three decades, some exact powers of two of the largest, half of them near the largest one's surface, in
/// a cell that just holds the largest.
fn clouds() -> impl Strategy<Value = Cloud> {
    let particle = (0.0..10.0f64, any::<bool>(), prop::array::uniform3(0.0..1.0f64), any::<bool>());
    let periodic = prop::array::uniform3(any::<bool>());
    (prop::collection::vec(particle, 2..150), periodic).prop_map(|(drawn, periodic)| {
        let side = 4.0 * (1.0 + 2.0 * SKIN_FRACTION);
        let (mut radii, mut places) = (Vec::new(), Vec::new());
        for (k, (octave, whole, place, near)) in drawn.into_iter().enumerate() {
            let radius = if k == 0 { 1.0 } else { (-if whole { octave.floor() } else { octave }).exp2() };
            let direction = Vec3::from(place).add_scalar(-0.5);
            let beside = Vec3::repeat(0.1) + direction.normalize() * (1.0 + radius * (1.0 + place[0]));
            radii.push(radius);
            places.push(match k {
                0 => [0.1; 3],
                _ if near => beside.into(),
                _ => place.map(|x| x * side),
            });
        }
        Cloud { radii, places, extent: periodic.map(|periodic| if periodic { side } else { 0.0 }) }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_grid_lists_what_all_pairs_list(cloud in clouds()) {
        let (listed, skin) = cloud.listed();
        prop_assert_eq!(listed, cloud.all_pairs(skin));
    }
}

/// Across a corner of the cell, both sizes on both sides.
#[test]
fn a_large_and_a_small_sphere_meet_across_a_corner() {
    for (first, second) in [(1.0, 0.01), (0.01, 1.0), (1.0, 1.0)] {
        let cloud = Cloud { radii: vec![first, second], places: vec![[0.1; 3], [-0.4; 3]], extent: [6.0; 3] };
        assert_eq!(cloud.listed().0, [[0, 1]], "{first} {second}");
    }
}

/// One of a thousandth among many of size 1 must not set their skin.
#[test]
fn dust_does_not_shorten_the_skin_of_grains() {
    let mut cloud = Cloud {
        radii: vec![0.5; 1000],
        places: (0..1000).map(|k| [f64::from(k), 0.0, 0.0]).collect(),
        extent: [0.0; 3],
    };
    let skin = cloud.listed().1;
    cloud.radii[500] = 5e-4;
    assert!(cloud.listed().1 > 0.4 * skin);
}

#[test]
fn a_list_that_is_too_long_is_none() {
    let cloud = Cloud { radii: vec![1.0; 600], places: vec![[0.5; 3]; 600], extent: [0.0; 3] };
    let pairs = 600 * 599 / 2;
    assert_eq!(cloud.listed_up_to(pairs).unwrap().0.len(), pairs);
    assert!(cloud.listed_up_to(pairs - 1).is_none());
}
