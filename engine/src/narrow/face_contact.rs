//! Two faces in contact: the corners of their common outline, as deep as the gap between their planes.
//!
//! With a face axis the reference is that face. With an edge axis the faces beside the two edges are used, so that two
//! cubes which are tilted by 1e-9 keep their four points although an edge axis is the deepest by that little. Edges
//! that cross like roof ridges have one corner below zero, their crossing.

use super::clipping::{Corner, Frame, Polygon, Side, clip};
use super::closest::segment_segment;
use super::separating_axis::{Pair, Separation};
use super::{FeatureKey, MAX_POINTS, Manifold, ManifoldPoint};
use crate::math::{Similarity, Vec3};
use crate::shape::Polyhedron;

/// Points closer than this, over the size of the smaller part, are one point.
pub(super) const COINCIDENT: f64 = 1e-9;
/// Vertices whose heights differ by less than this, over the size of their part, are equally deep.
pub(super) const EQUALLY_DEEP: f64 = 1e-9;
/// Faces of so many vertices together (two octagons) fit the small buffers, which cost less to clear.
const SMALL: usize = 16;

/// A face of `a`, or of `b` with its map to the frame of `a`.
#[derive(Clone, Copy)]
struct FaceOf<'p> {
    solid: &'p Polyhedron,
    face: usize,
    b_to_a: Option<&'p Similarity>,
}

impl FaceOf<'_> {
    fn len(&self) -> usize {
        self.solid.face_vertices(self.face).len()
    }

    fn point(&self, k: usize) -> Vec3 {
        let point = &self.solid.vertices()[self.solid.face_vertices(self.face)[k] as usize];
        self.b_to_a.map_or(*point, |to_a| to_a.point(point))
    }

    fn corners<const N: usize>(&self, frame: &Frame, side: fn(u8) -> Side) -> Polygon<N> {
        Polygon::new((0..self.len()).map(|k| frame.corner(&self.point(k), side(k as u8))))
    }

    fn edge(&self, k: u8) -> u32 {
        self.solid.face_edges(self.face)[k as usize]
    }

    fn vertex_key(&self, k: usize) -> FeatureKey {
        let v = self.solid.face_vertices(self.face)[k];
        if self.b_to_a.is_some() { FeatureKey::vertex_of_b(v) } else { FeatureKey::vertex_of_a(v) }
    }
}

/// A reference face, the incident face of the other part, and the frame in which they are clipped.
pub(super) struct FaceContact<'p> {
    reference: FaceOf<'p>,
    incident: FaceOf<'p>,
    /// Its normal points out of the reference.
    frame: Frame,
    depth: f64,
    /// Where the contact is if the outline has no area, and what it is then.
    fallback: (Vec3, FeatureKey),
}

impl<'p> FaceContact<'p> {
    /// With the face that made the axis as the reference.
    pub fn of_face(pair: &Pair<'p>, deepest: &Separation, face: usize, of_a: bool, incident_size: f64) -> Self {
        let (a, b) =
            (FaceOf { solid: pair.a, face, b_to_a: None }, FaceOf { solid: pair.b, face, b_to_a: Some(pair.b_to_a) });
        let (reference, mut incident) = if of_a { (a, b) } else { (b, a) };
        let normal = if of_a { deepest.normal } else { -deepest.normal };
        let along = if of_a { pair.b_to_a.inverse_direction(&normal) } else { normal };
        let size = if of_a { incident_size / pair.b_to_a.scale } else { incident_size };
        let vertex;
        (incident.face, vertex) = incident_face(incident.solid, &along, EQUALLY_DEEP * size);
        let (point, origin) = (incident.point(vertex), reference.point(0));
        let fallback = (point - normal * (0.5 * deepest.distance), incident.vertex_key(vertex));
        let frame = Frame::new(normal, origin, (reference.point(1) - origin).normalize());
        Self { reference, incident, frame, depth: -deepest.distance, fallback }
    }

    /// With the faces beside the edges that made the axis; the one of `a` is the reference.
    pub fn of_edges(pair: &Pair<'p>, deepest: &Separation, e: usize, f: usize) -> Self {
        let normal = deepest.normal;
        let face = face_along(pair.a, e, &normal);
        let reference = FaceOf { solid: pair.a, face, b_to_a: None };
        let face = face_along(pair.b, f, &pair.b_to_a.inverse_direction(&-normal));
        let incident = FaceOf { solid: pair.b, face, b_to_a: Some(pair.b_to_a) };
        let frame = Frame::new(normal, reference.point(0), pair.a.edges()[e].direction);
        let frame = frame.sloping(&pair.a.faces()[reference.face].normal);
        Self { reference, incident, frame, depth: -deepest.distance, fallback: crossing_edges(pair, deepest, e, f) }
    }

    /// Clips, merges coincident corners and adds those that overlap. Never adds nothing.
    pub fn push(&self, smaller: f64, out: &mut Manifold) {
        let (first, near) = (out.len(), COINCIDENT * smaller);
        if self.reference.len() + self.incident.len() <= SMALL {
            self.push_outline::<SMALL>(near, out);
        } else {
            self.push_outline::<MAX_POINTS>(near, out);
        }
        if out.len() == first {
            // an outline without area can lose its last corner to rounding; the contact must not be lost with it
            let (position, feature) = self.fallback;
            out.push(self.contact(position, self.depth, near, feature));
        }
    }

    fn push_outline<const N: usize>(&self, near: f64, out: &mut Manifold) {
        let reference = self.reference.corners::<N>(&self.frame, Side::Reference);
        let incident = self.incident.corners::<N>(&self.frame, Side::Incident);
        let outline = clip(&incident, reference.corners(), near);
        let labels =
            Labels { contact: self, reference: reference.corners(), incident: incident.corners(), near2: near * near };
        let (corners, first) = (outline.corners(), out.len());
        let n = corners.len();
        if n == 0 {
            return;
        }
        let next = |i: usize| if i + 1 == n { 0 } else { i + 1 };
        let coincide = |i: usize, j: usize| corners[i].distance2(&corners[j]) <= labels.near2;
        // groups of coincident corners must not be split where the numbering starts
        let last_of_group = (0..n).find(|&i| !coincide(i, next(i))).unwrap_or(n - 1);
        let (mut before, mut i, mut left) = (last_of_group, next(last_of_group), n);
        let mut side_before = corners[before].lateral2(&corners[i]).sqrt();
        while left > 0 {
            let leader = &corners[i];
            let (mut feature, mut share, mut overlap) = (FeatureKey(u32::MAX), 0.0, f64::MIN);
            loop {
                let side = corners[i].lateral2(&corners[next(i)]).sqrt();
                feature = feature.min(labels.key(&corners[before], &corners[i]));
                share += 0.5 * (side_before + side);
                overlap = overlap.max(self.frame.overlap(&corners[i]));
                let joined = coincide(i, next(i));
                (before, i, side_before, left) = (i, next(i), side, left - 1);
                if left == 0 || !joined {
                    break;
                }
            }
            if overlap > 0.0 {
                let position = self.frame.point(leader, leader.height + 0.5 * overlap);
                push_or_join(out, first, self.contact(position, overlap, share + near, feature));
            }
        }
    }

    fn contact(&self, position: Vec3, overlap: f64, share: f64, feature: FeatureKey) -> ManifoldPoint {
        let normal = if self.reference.b_to_a.is_none() { self.frame.normal } else { -self.frame.normal };
        ManifoldPoint { position, normal, overlap, share, feature }
    }
}

/// What names the corners of an outline.
struct Labels<'c> {
    contact: &'c FaceContact<'c>,
    reference: &'c [Corner],
    incident: &'c [Corner],
    near2: f64,
}

impl Labels<'_> {
    /// The key of a corner, the same whichever part is the reference: a vertex of `a` where there is one, else a
    /// vertex of `b`, else the two edges that cross.
    fn key(&self, before: &Corner, corner: &Corner) -> FeatureKey {
        let (reference, incident) = (&self.contact.reference, &self.contact.incident);
        let of_reference = self.reference.iter().position(|c| c.lateral2(corner) <= self.near2);
        let of_incident = self.incident.iter().position(|c| c.distance2(corner) <= self.near2);
        match (of_reference, of_incident) {
            (Some(r), Some(i)) => return reference.vertex_key(r).min(incident.vertex_key(i)),
            (Some(r), None) => return reference.vertex_key(r),
            (None, Some(i)) => return incident.vertex_key(i),
            (None, None) => {}
        }
        match (before.side, corner.side) {
            (Side::Incident(i), Side::Reference(r)) | (Side::Reference(r), Side::Incident(i)) => {
                let (r, i) = (reference.edge(r), incident.edge(i));
                if reference.b_to_a.is_none() { FeatureKey::edges(r, i) } else { FeatureKey::edges(i, r) }
            }
            // Between two sides of one face lies a vertex of it, up to rounding and to what clipping lets stand; not always
            // the one where the second side starts.
            (Side::Incident(_), Side::Incident(_)) => incident.vertex_key(nearest(self.incident, corner)),
            (Side::Reference(_), Side::Reference(_)) => reference.vertex_key(nearest(self.reference, corner)),
        }
    }
}

/// The corner that is nearest across the normal.
fn nearest(corners: &[Corner], to: &Corner) -> usize {
    let (mut best, mut least) = (0, f64::MAX);
    for (k, corner) in corners.iter().enumerate() {
        let distance2 = corner.lateral2(to);
        if distance2 < least {
            (best, least) = (k, distance2);
        }
    }
    best
}

/// Adds a point to those from `first` on. Two corners may be farther apart than coincident ones and yet lie at the same
/// vertex: they are one point, as deep as the deeper, or a spring would be carried to both.
fn push_or_join(out: &mut Manifold, first: usize, point: ManifoldPoint) {
    match out.points_mut()[first..].iter_mut().find(|known| known.feature == point.feature) {
        Some(known) => {
            let share = known.share + point.share;
            if point.overlap > known.overlap {
                *known = point;
            }
            known.share = share;
        }
        None => out.push(point),
    }
}

/// Where two edges cross: halfway between them, and which they are.
fn crossing_edges(pair: &Pair<'_>, deepest: &Separation, e: usize, f: usize) -> (Vec3, FeatureKey) {
    let on_a = pair.a.edges()[e].vertices.map(|v| pair.a.vertices()[v as usize]);
    let on_b = pair.b.edges()[f].vertices.map(|v| pair.b_to_a.point(&pair.b.vertices()[v as usize]));
    // slid along the normal until they touch: the closest points are then where the edges cross
    let lifted = on_b.map(|x| x - deepest.normal * deepest.distance);
    let (x, y) = segment_segment(&on_a, &lifted);
    ((x + y + deepest.normal * deepest.distance) * 0.5, FeatureKey::edges(e as u32, f as u32))
}

/// Of the two faces at an edge the one that looks most along a direction.
fn face_along(p: &Polyhedron, edge: usize, along: &Vec3) -> usize {
    let [f, g] = p.edges()[edge].faces.map(|f| f as usize);
    if p.faces()[g].normal.dot(along) > p.faces()[f].normal.dot(along) { g } else { f }
}

/// The face that meets the reference, and the place of the deepest vertex in it: of the faces with the most of the
/// deepest vertices the one that looks at the reference most squarely. (The squarest of all need not hold them.)
pub(super) fn incident_face(p: &Polyhedron, along: &Vec3, tolerance: f64) -> (usize, usize) {
    let (mut vertex, mut least) = (0, f64::MAX);
    for (i, v) in p.vertices().iter().enumerate() {
        let height = along.dot(v);
        if height < least {
            (vertex, least) = (i, height);
        }
    }
    let mut best = (0, 0, f64::MAX);
    for &f in p.vertex_faces(vertex) {
        let deep = |v: &&u32| along.dot(&p.vertices()[**v as usize]) <= least + tolerance;
        let count = p.face_vertices(f as usize).iter().filter(deep).count();
        let facing = p.faces()[f as usize].normal.dot(along);
        if count > best.1 || (count == best.1 && facing < best.2) {
            best = (f as usize, count, facing);
        }
    }
    let place = p.face_vertices(best.0).iter().position(|&v| v as usize == vertex);
    (best.0, place.unwrap_or(0))
}
