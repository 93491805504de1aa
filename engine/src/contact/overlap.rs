//! Contacts by generalized overlap: geometry of the slots of rounded polyhedra, and the springs of the step before.

use super::find::FindInputs;
use super::table::Slot;
use crate::boundary::{WallShape, WallSide};
use crate::math::{Mat3, Vec3};
use crate::mesh::PartAtMesh;
use crate::narrow::generalized_overlap::{
    ActiveTerms, Core, Overlap, OverlapGeometry, OverlapPoint, RoundedPair, Scratch, Term, aggregate,
    polyhedron_cylinder, polyhedron_plane,
};
use crate::narrow::overlap_volume::{Cutter, SharedFacet, SharedVolume};
use crate::scene::{RoundedShapes, WallOverlap};
use crate::shape::PartGeometry;

/// A touching pair of rounded polyhedra, or one at a wall. World axes, seen from the centre of `a`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapContact {
    /// Slot within the chunk.
    pub slot: u32,
    /// First of its points in the chunk.
    pub first_point: u32,
    /// Number of points, and how many of them are edge pairs.
    pub points: [u32; 2],
    /// D, m.
    pub overlap: f64,
    /// Sum of the rounding radii, m.
    pub radius_sum: f64,
    /// On `b` per unit of the scalar force.
    pub force: Vec3,
    /// Its moment about the centre of `a`, m.
    pub moment: Vec3,
    /// Tangential spring, m.
    pub spring: Vec3,
    /// Torsion spring as an arc, m.
    pub twist: f64,
}

/// Contacts by generalized overlap of one chunk, and what finding them needs.
#[derive(Clone, Debug, Default)]
pub struct OverlapChunk {
    /// In the order of slots.
    pub contacts: Vec<OverlapContact>,
    /// Points of all contacts; arms from the centre of `a`, m, world axes.
    pub points: Vec<OverlapPoint>,
    /// By slot; empty where the chunk has no pair of rounded polyhedra.
    pub active: Vec<ActiveTerms>,
    previous: Vec<OverlapContact>,
    terms: Vec<Term>,
    scratch: Scratch,
    cutter: Cutter,
    facets: Vec<SharedFacet>,
}

/// Frame and unit that terms are in, for their way to world axes about the centre of `a`.
struct TermFrame {
    rotation: Mat3,
    /// Centre of `a` in that frame.
    centre: Vec3,
    /// Unit, m.
    unit: f64,
    /// Sum of the rounding radii in that unit.
    radius_sum: f64,
}

impl OverlapChunk {
    /// Empties it for new slots; `slots` is the number of lists needed.
    pub fn reset(&mut self, slots: usize) {
        self.contacts.clear();
        self.previous.clear();
        self.points.clear();
        self.active.resize_with(slots, ActiveTerms::default);
        self.forget();
    }

    /// Makes every list of active terms be made anew.
    pub fn forget(&mut self) {
        self.active.iter_mut().for_each(ActiveTerms::forget);
    }

    /// Starts a step: the contacts become those of the step before.
    pub fn begin(&mut self) {
        std::mem::swap(&mut self.contacts, &mut self.previous);
        self.contacts.clear();
        self.points.clear();
    }

    /// Two rounded polyhedra.
    pub fn find_pair(&mut self, index: u32, slot: &Slot, inputs: &FindInputs<'_>, rounded: &RoundedShapes) {
        let particles = inputs.particles;
        let (a, b) = (slot.a as usize, slot.b as usize);
        let d = particles.separation(a, b);
        let reach = particles.radius[a] + particles.radius[b];
        if d.norm_squared() >= reach * reach {
            return;
        }
        let (a_from_b, unit) = particles.a_from_b(a, b, &d);
        let core_a = core(rounded, particles.shape[a], slot.part_a);
        let core_b = core(rounded, particles.shape[b], slot.part_b);
        let mut frame = TermFrame { rotation: particles.rotation[a], centre: Vec3::zeros(), unit, radius_sum: 0.0 };
        let Some(geometry) = &rounded.geometry else {
            let area = core_a.face_area.min(core_b.face_area * a_from_b.scale * a_from_b.scale);
            let shared = self.cutter.pair((core_a.solid(), core_b.solid()), &a_from_b, &mut self.facets);
            return self.push_volume(index, &frame, shared, area);
        };
        let pair = RoundedPair { a: core_a, b: core_b, b_to_a: &a_from_b, geometry };
        self.active[index as usize].evaluate(&pair, &mut self.scratch, &mut self.terms);
        frame.radius_sum = pair.radius();
        self.push_terms(index, &frame, geometry);
    }

    /// A rounded polyhedron at a wall.
    pub fn find_wall(&mut self, index: u32, slot: &Slot, inputs: &FindInputs<'_>, rounded: &RoundedShapes) {
        let particles = inputs.particles;
        let a = slot.a as usize;
        let WallSide { boundary, element, .. } = WallSide::of(inputs.boundaries, slot.b);
        // The neighbour list saw the row one or more periodic cells away: walls stay where they are.
        if boundary.distance(&particles.position[a]) >= particles.radius[a] {
            return;
        }
        let core = core(rounded, particles.shape[a], slot.part_a);
        let wall_from_body =
            boundary.wall_from_body(&particles.position[a], &particles.rotation[a], particles.scale[a]);
        let part = &inputs.shapes[particles.shape[a] as usize].parts()[slot.part_a as usize];
        let PartGeometry::Polyhedron(solid) = &part.geometry else { unreachable!("only polyhedra have cores") };
        if let Some((mesh, element)) = element {
            let deepest = inputs.shapes[particles.shape[a] as usize].half_thickness() * particles.scale[a];
            let at = PartAtMesh { part, mesh_from_body: &wall_from_body, deepest };
            let (mesh_from_patch, patch_from_body) = mesh.patch_terms(element, solid, &at, &mut self.terms);
            let frame = TermFrame {
                rotation: boundary.rotation * mesh_from_patch.rotation,
                centre: patch_from_body.translation,
                unit: 1.0,
                radius_sum: core.radius * particles.scale[a],
            };
            let geometry = rounded.geometry.as_ref().expect("scenes with volumes have planes only");
            return self.push_terms(index, &frame, geometry);
        }
        let frame = TermFrame {
            rotation: boundary.rotation,
            centre: wall_from_body.translation,
            unit: 1.0,
            radius_sum: core.radius * particles.scale[a],
        };
        let area = core.face_area * particles.scale[a] * particles.scale[a];
        match (boundary.shape, &rounded.geometry) {
            (WallShape::Plane, None) => {
                let shared = self.cutter.below_plane(solid, &wall_from_body, true, &mut self.facets);
                return self.push_volume(index, &frame, shared, area);
            }
            (WallShape::Plane, Some(_)) if rounded.walls == WallOverlap::Winkler => {
                let shared = self.cutter.below_plane(solid, &wall_from_body, false, &mut self.facets);
                return self.push_winkler(index, &frame, shared, area);
            }
            (WallShape::Plane, Some(_)) => polyhedron_plane(solid, &wall_from_body, &mut self.terms),
            (WallShape::CylinderInside(radius), _) => {
                polyhedron_cylinder(solid, &wall_from_body, radius, &mut self.terms);
            }
            (WallShape::CylinderOutside(_) | WallShape::Mesh, _) => unreachable!("polyhedra meet these by points"),
        }
        let geometry = rounded.geometry.as_ref().expect("scenes with volumes have planes only");
        self.push_terms(index, &frame, geometry);
    }

    /// D = V/A.
    fn push_volume(&mut self, index: u32, frame: &TermFrame, shared: Option<SharedVolume>, area: f64) {
        let Some(shared) = shared else { return };
        let first = self.points.len();
        self.points.extend(self.facets.iter().map(|facet| OverlapPoint {
            position: facet.position,
            normal: -facet.normal,
            share: facet.area / area,
            rocking: 0.0,
        }));
        let overlap =
            Overlap { value: shared.volume / area, force: -shared.area / area, moment: -shared.moment / area };
        self.push(index, frame, &overlap, first, 0);
    }

    /// D^2 = (integral of the squared depth over the plane)/A = 2 V z/A, z the depth of the centroid. Its gradient acts
    /// there, as buoyancy does. Each facet that faces the plane is a point of the area that it covers there.
    fn push_winkler(&mut self, index: u32, frame: &TermFrame, shared: Option<SharedVolume>, area: f64) {
        let Some(shared) = shared.filter(|shared| shared.centroid.z < 0.0) else { return };
        let value = (-2.0 * shared.volume * shared.centroid.z / area).sqrt();
        let first = self.points.len();
        self.points.extend(self.facets.iter().filter(|facet| facet.normal.z < 0.0).map(|facet| {
            let [depth, covered] = [-facet.position.z, -facet.normal.z * facet.area];
            OverlapPoint {
                position: facet.position + Vec3::z() * (0.5 * depth),
                normal: -Vec3::z(),
                share: covered * depth / (area * value),
                rocking: covered / area,
            }
        }));
        let force = Vec3::z() * (-shared.volume / (area * value));
        let overlap = Overlap { value, force, moment: shared.centroid.cross(&force) };
        self.push(index, frame, &overlap, first, 0);
    }

    /// Adds the terms up and appends the contact, if there are any.
    fn push_terms(&mut self, index: u32, frame: &TermFrame, geometry: &OverlapGeometry) {
        if self.terms.is_empty() {
            return;
        }
        let first = self.points.len();
        let overlap = aggregate(&self.terms, &geometry.norm, &mut self.points);
        let edges = self.terms.iter().filter(|term| term.is_edges).count();
        self.push(index, frame, &overlap, first, edges);
    }

    /// Carries overlap and points to world axes; the points are those from `first` on, `edges` of them edge pairs.
    fn push(&mut self, index: u32, frame: &TermFrame, overlap: &Overlap, first: usize, edges: usize) {
        let arm = |x: &Vec3| frame.rotation * ((x - frame.centre) * frame.unit);
        for point in &mut self.points[first..] {
            point.position = arm(&point.position);
            point.normal = frame.rotation * point.normal;
        }
        let moment = (overlap.moment - frame.centre.cross(&overlap.force)) * frame.unit;
        self.contacts.push(OverlapContact {
            slot: index,
            first_point: first as u32,
            points: [(self.points.len() - first) as u32, edges as u32],
            overlap: overlap.value * frame.unit,
            radius_sum: frame.radius_sum * frame.unit,
            force: frame.rotation * overlap.force,
            moment: frame.rotation * moment,
            spring: Vec3::zeros(),
            twist: 0.0,
        });
    }

    /// Copies the springs of the step before to the contacts of the same slots.
    pub fn carry_springs(&mut self) {
        let mut previous = self.previous.iter().peekable();
        for contact in &mut self.contacts {
            while previous.next_if(|old| old.slot < contact.slot).is_some() {}
            if let Some(old) = previous.peek().filter(|old| old.slot == contact.slot) {
                (contact.spring, contact.twist) = (old.spring, old.twist);
            }
        }
    }

    /// Puts springs where the next step takes those of the step before from; slots in ascending order.
    pub fn restore(&mut self, slot: u32, spring: Vec3, twist: f64) {
        self.contacts.push(OverlapContact {
            slot,
            first_point: 0,
            points: [0; 2],
            overlap: 0.0,
            radius_sum: 0.0,
            force: Vec3::zeros(),
            moment: Vec3::zeros(),
            spring,
            twist,
        });
    }
}

/// A core that the neighbour list has found to exist.
#[inline]
fn core(rounded: &RoundedShapes, shape: u32, part: u16) -> &Core {
    rounded.cores[shape as usize][part as usize].as_ref().expect("slots of this kind pair polyhedra")
}
