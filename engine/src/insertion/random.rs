//! Random places without overlap.

use super::region::{draw_point, is_inside, region_volume};
use super::space::Space;
use super::{MOST_PARTICLES, Request, Surroundings};
use crate::error::InvalidInput;
use crate::particles::NewParticle;
use crate::random::{Draw, Purpose};
use crate::scene::{InsertionDescription, Placement};

/// How much is placed: until one of both is reached.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Amount {
    /// Particles.
    pub count: u64,
    /// Of the particles, m3.
    pub volume: f64,
}

/// What was placed, and whether it was all.
pub(crate) struct Placed {
    /// With consecutive ids.
    pub particles: Vec<NewParticle>,
    /// The next one found no room.
    pub is_full: bool,
}

/// As much of an amount as finds room in the region of a random placement.
pub(crate) fn place_what_fits(
    description: &InsertionDescription,
    surroundings: &Surroundings<'_>,
    amount: Amount,
    path: &str,
) -> Result<Placed, InvalidInput> {
    let request = Request::resolve(description, surroundings.scene, path)?;
    request.fill(surroundings, amount, path)
}

impl Request<'_> {
    /// The particles of a random placement.
    pub(super) fn random(&self, surroundings: &Surroundings<'_>, path: &str) -> Result<Vec<NewParticle>, InvalidInput> {
        let Placement::Random { region, count, solid_fraction, attempts, .. } = &self.description.placement else {
            unreachable!("called for random placements only")
        };
        let volume = region_volume(region, &format!("{path}.placement.region"))?;
        let amount = match (count, solid_fraction) {
            (Some(count), None) => Amount { count: u64::from(*count), volume: f64::INFINITY },
            (None, Some(fraction)) if *fraction > 0.0 && *fraction < 1.0 => {
                Amount { count: u64::MAX, volume: fraction * volume }
            }
            (None, Some(fraction)) => {
                let problem = format!("is {fraction}; must lie in (0, 1)");
                return Err(InvalidInput::new(format!("{path}.placement.solid_fraction"), problem));
            }
            _ => return Err(InvalidInput::new(format!("{path}.placement"), "give count or solid_fraction, not both")),
        };
        let placed = self.fill(surroundings, amount, path)?;
        if placed.is_full {
            let problem = format!(
                "no free place for particle {} of the request after {attempts} attempts; ask for fewer, or enlarge the region",
                placed.particles.len()
            );
            return Err(InvalidInput::new(format!("{path}.placement"), problem));
        }
        Ok(placed.particles)
    }

    fn fill(&self, surroundings: &Surroundings<'_>, amount: Amount, path: &str) -> Result<Placed, InvalidInput> {
        let Placement::Random { region, fixed_orientation, attempts, .. } = &self.description.placement else {
            unreachable!("called for random placements only")
        };
        let mut space = Space::new(surroundings);
        let mut particles: Vec<NewParticle> = Vec::new();
        let mut filled = 0.0;
        while (particles.len() as u64) < amount.count && filled < amount.volume {
            let id = surroundings.first_id + particles.len() as u64;
            let mut draw = Draw::new(self.seed, id, Purpose::Position);
            let orientation = self.orientation(id, !fixed_orientation);
            let scale = self.draw_scale(id);
            let placed = (0..*attempts).find_map(|_| {
                let candidate = self.particle_of_scale(id, scale, (draw_point(region, &mut draw), orientation));
                (is_inside(region, &candidate) && space.is_free(&candidate)).then_some(candidate)
            });
            let Some(particle) = placed else {
                return Ok(Placed { particles, is_full: true });
            };
            filled += particle.mass / self.density;
            space.add(particle);
            particles.push(particle);
            if particles.len() as u64 > MOST_PARTICLES {
                let problem = format!("asks for more than {MOST_PARTICLES} particles");
                return Err(InvalidInput::new(format!("{path}.placement"), problem));
            }
        }
        Ok(Placed { particles, is_full: false })
    }
}
