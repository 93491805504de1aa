//! What fields are made of: particles, contacts and walls of one state, live or recorded.

use super::definition::BodyAxis;
use super::layout::KINDS;
use crate::boundary::{Boundary, WallShape};
use crate::cell::Cell;
use crate::contact_network::{ContactKind, ContactNetwork, ContactRow};
use crate::error::InvalidInput;
use crate::math::{Mat3, Quat, Vec3};
use crate::scene::Scene;
use crate::shape::Shape;
use crate::snapshot::{BoundaryState, Snapshot};

/// One state of a scene as fields see it.
///
/// A recorded state gives the bits of the live one, as long as it was recorded in 64 bits.
pub struct FieldSources<'a> {
    pub(super) scene: &'a Scene,
    pub(super) step: u64,
    pub(super) time_s: f64,
    pub(super) particles: Vec<FieldParticle>,
    /// `None`: unknown.
    pub(super) contacts: Option<Vec<FieldContact>>,
    pub(super) boundaries: &'a [BoundaryState],
}

/// What a particle brings.
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldParticle {
    pub position: Vec3,
    pub velocity: Vec3,
    pub angular_velocity: Vec3,
    /// World from body.
    pub rotation: Mat3,
    pub mass: f64,
    pub volume: f64,
    /// Euler tensor about the body axes over the mass, m2.
    pub euler: Vec3,
    pub shape: u32,
    pub scale: f64,
    /// Touching neighbours by kind.
    pub neighbours: [f64; KINDS],
}

/// What a contact brings.
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldContact {
    /// Centre of side a.
    pub start: Vec3,
    /// From there to the centre of side b, or to the contact point at a boundary.
    pub branch: Vec3,
    /// On side a.
    pub force: Vec3,
    pub is_at_boundary: bool,
}

impl<'a> FieldSources<'a> {
    /// Of a state of the scene, with its contacts where they are known: without them, quantities that take contacts
    /// cannot be sampled.
    ///
    /// # Errors
    /// The state is not one of the scene, or the contacts are of another state.
    pub fn new(
        scene: &'a Scene,
        snapshot: &'a Snapshot,
        contacts: Option<&ContactNetwork>,
    ) -> Result<Self, InvalidInput> {
        let mut particles =
            (0..snapshot.ids.len()).map(|row| particle(scene, snapshot, row)).collect::<Result<Vec<_>, _>>()?;
        let contacts = match contacts {
            Some(network) if network.step != snapshot.step => {
                let problem = format!("are of step {}, the state of step {}", network.step, snapshot.step);
                return Err(InvalidInput::new("contacts", problem));
            }
            Some(network) => Some(read_contacts(network, snapshot, scene.cell(), &mut particles)?),
            None => None,
        };
        Ok(Self {
            scene,
            step: snapshot.step,
            time_s: snapshot.time_s,
            particles,
            contacts,
            boundaries: &snapshot.boundaries,
        })
    }

    pub(super) fn total_mass(&self) -> f64 {
        self.particles.iter().map(|particle| particle.mass).sum()
    }

    pub(super) fn total_momentum(&self) -> Vec3 {
        self.particles.iter().map(|particle| particle.velocity * particle.mass).sum()
    }

    /// Point and normal of every plane.
    pub(super) fn planes(&self) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
        let all = self.scene.boundaries().iter().zip(self.boundaries);
        all.filter(|(boundary, _)| boundary.shape == WallShape::Plane)
            .map(|(_, state)| (Vec3::from(state.point_m), Vec3::from(state.direction)))
    }

    /// The boundary of that name: as the scene has it, and now.
    pub(super) fn boundary(&self, name: &str) -> Option<(&Boundary, &BoundaryState)> {
        self.scene.boundaries().iter().zip(self.boundaries).find(|(boundary, _)| boundary.name == name)
    }
}

fn particle(scene: &Scene, snapshot: &Snapshot, row: usize) -> Result<FieldParticle, InvalidInput> {
    let bad = |column: &str, problem: String| Err(InvalidInput::new(format!("{column}[{row}]"), problem));
    let (shape_index, material) = (snapshot.shapes[row], snapshot.materials[row] as usize);
    let Some(shape) = scene.shapes().get(shape_index as usize) else {
        return bad("shapes", format!("is {shape_index}; the scene has {}", scene.shapes().len()));
    };
    let Some(density) = scene.description().materials.get(material).and_then(|material| material.density_kg_per_m3)
    else {
        return bad("materials", format!("is {material}: no material of the scene with a density"));
    };
    let scale = snapshot.scales[row];
    let properties = shape.mass_properties();
    let volume = properties.volume * scale.powi(3);
    let [w, i, j, k] = snapshot.orientations[row];
    let orientation = Quat::new_unchecked(nalgebra::Quaternion::new(w, i, j, k));
    let inertia = properties.principal_inertia;
    Ok(FieldParticle {
        position: Vec3::from(snapshot.positions[row]),
        velocity: Vec3::from(snapshot.velocities[row]),
        angular_velocity: Vec3::from(snapshot.angular_velocities[row]),
        rotation: orientation.to_rotation_matrix().into_inner(),
        mass: density * properties.volume * scale.powi(3),
        volume,
        euler: inertia.map(|moment| 0.5 * inertia.sum() - moment) * (scale * scale / properties.volume),
        shape: shape_index,
        scale,
        neighbours: [0.0; KINDS],
    })
}

/// Contacts, and the counts of neighbours of the particles.
fn read_contacts(
    network: &ContactNetwork,
    snapshot: &Snapshot,
    cell: &Cell,
    particles: &mut [FieldParticle],
) -> Result<Vec<FieldContact>, InvalidInput> {
    let row_of = |id: u64| {
        let found = snapshot.ids.binary_search(&id);
        found.map_err(|_| InvalidInput::new("contacts", format!("name particle {id}, which the state does not have")))
    };
    let mut contacts = Vec::with_capacity(network.rows.len());
    // rows of one pair follow each other
    for rows in network.rows.chunk_by(|p, q| (p.id_a, p.id_b, p.boundary) == (q.id_a, q.id_b, q.boundary)) {
        let a = row_of(rows[0].id_a)?;
        let b = rows[0].id_b.map(row_of).transpose()?;
        let kind = kind_of(rows);
        for (row, other) in [(Some(a), b), (b, Some(a))] {
            let Some(row) = row else { continue };
            let neighbours = &mut particles[row].neighbours;
            neighbours[0] += 1.0;
            neighbours[if other.is_some() { 1 } else { 2 }] += 1.0;
            neighbours[3 + kind] += 1.0;
        }
        let start = particles[a].position;
        contacts.extend(rows.iter().map(|row| {
            let point = Vec3::from(row.point_m);
            // the image of b that is nearest to where it touches
            let end = match b {
                Some(b) => point + cell.nearest_image(particles[b].position - point),
                None => point,
            };
            let force = Vec3::from(row.force_on_a_n());
            FieldContact { start, branch: end - start, force, is_at_boundary: b.is_none() }
        }));
    }
    Ok(contacts)
}

/// Of all the parts that two bodies touch with: several points where there are several.
fn kind_of(rows: &[ContactRow]) -> usize {
    let number = |kind: ContactKind| match kind {
        ContactKind::Smooth => 0,
        ContactKind::VertexFace => 1,
        ContactKind::EdgeEdge => 2,
        ContactKind::Manifold => 3,
        ContactKind::Overlap => 4,
    };
    match rows {
        [one] => number(one.kind),
        many if many.iter().all(|row| row.kind == ContactKind::Overlap) => number(ContactKind::Overlap),
        _ => number(ContactKind::Manifold),
    }
}

impl BodyAxis {
    /// Number of the axis of a shape.
    pub(super) fn of(self, shape: &Shape) -> usize {
        let inertia = shape.mass_properties().principal_inertia;
        // moments that differ by rounding are equal
        let nearly = |a: f64, b: f64| a > b * (1.0 + 1e-9);
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
            Self::Longest => (1..3).fold(0, |best, k| if nearly(inertia[best], inertia[k]) { k } else { best }),
            Self::Shortest => (1..3).fold(0, |best, k| if nearly(inertia[k], inertia[best]) { k } else { best }),
        }
    }
}
