//! Two convex polyhedra: separating-axis test, then the clipped face or the crossing of two edges.
//!
//! Why not GJK with EPA: on exactly or nearly aligned faces and parallel edges, which settled packings are made of,
//! 0.1 to 4 % of parry's answers have a wrong normal or depth, and its tolerances are absolute lengths. Here every
//! tolerance is relative to the pair, and the answer depends on the relative pose alone.
//!
//! To come: the motion-bounded active feature set (PHYSICS A.1). It will replace [`Pair::deepest`] by a search over
//! the features that were within a window of the best at the last full test; the manifold below stays as it is.

use super::clipping::{Corner, FaceLoop, Frame, Polygon, Side, clip};
use super::closest::segment_segment;
use super::separating_axis::{Axis, Pair, Separation};
use super::{FeatureKey, Manifold, ManifoldPoint};
use crate::math::{Similarity, Vec3};
use crate::shape::{Part, Polyhedron};

/// Points closer than this, over the size of the smaller part, are one point.
const COINCIDENT: f64 = 1e-9;
/// Vertices whose heights differ by less than this, over the size of their part, are equally deep.
const EQUALLY_DEEP: f64 = 1e-9;

/// The points of a face contact, or the one point of two crossing edges; nothing if the parts are apart.
///
/// `hint` remembers a separating axis from call to call (start with 0). It saves time and never changes the answer.
/// `a` and `b` give the sizes (bounding spheres) that the tolerances are relative to.
pub fn polyhedron_polyhedron(
    (part_a, a): (&Part, &Polyhedron),
    (part_b, b): (&Part, &Polyhedron),
    b_to_a: &Similarity,
    hint: &mut u32,
    out: &mut Manifold,
) {
    let (size_a, size_b) = (part_a.radius, part_b.radius * b_to_a.scale);
    let pair = Pair { a, b, b_to_a };
    let Some(deepest) = pair.deepest(size_a + size_b, hint) else { return };
    if deepest.distance >= 0.0 {
        return;
    }
    let smaller = size_a.min(size_b);
    match deepest.axis {
        Axis::Edges(e, f) => out.push(crossing_edges(&pair, &deepest, e, f)),
        Axis::FaceOfA(face) => FaceContact::new(&pair, face, true, &deepest, size_b).push(smaller, out),
        Axis::FaceOfB(face) => FaceContact::new(&pair, face, false, &deepest, size_a).push(smaller, out),
    }
}

fn crossing_edges(pair: &Pair<'_>, deepest: &Separation, e: usize, f: usize) -> ManifoldPoint {
    let on_a = pair.a.edges()[e].vertices.map(|v| pair.a.vertices()[v as usize]);
    let on_b = pair.b.edges()[f].vertices.map(|v| pair.b_to_a.point(&pair.b.vertices()[v as usize]));
    // slid along the normal until they touch: the closest points are then where the edges cross
    let lifted = on_b.map(|x| x - deepest.normal * deepest.distance);
    let (x, y) = segment_segment(&on_a, &lifted);
    ManifoldPoint {
        position: (x + y + deepest.normal * deepest.distance) * 0.5,
        normal: deepest.normal,
        overlap: -deepest.distance,
        share: 1.0,
        feature: FeatureKey::edges(e as u32, f as u32),
    }
}

/// A reference face and the incident face of the other part, both in the frame of `a`.
struct FaceContact<'p> {
    reference: &'p Polyhedron,
    incident: &'p Polyhedron,
    reference_face: usize,
    incident_face: usize,
    reference_is_a: bool,
    reference_loop: FaceLoop,
    incident_loop: FaceLoop,
    /// Outwards from the reference.
    normal: Vec3,
    depth: f64,
    deepest_vertex: usize,
    deepest_point: Vec3,
}

impl<'p> FaceContact<'p> {
    fn new(pair: &Pair<'p>, face: usize, reference_is_a: bool, deepest: &Separation, incident_size: f64) -> Self {
        let b_to_a = pair.b_to_a;
        let (reference, incident) = if reference_is_a { (pair.a, pair.b) } else { (pair.b, pair.a) };
        let normal = if reference_is_a { deepest.normal } else { -deepest.normal };
        let (along, size) =
            if reference_is_a { (b_to_a.inverse_direction(&normal), incident_size / b_to_a.scale) } else { (normal, incident_size) };
        let (incident_face, deepest_vertex) = incident_face(incident, &along, EQUALLY_DEEP * size);
        let points = |p: &'p Polyhedron, face: usize, is_a: bool| {
            let to_a = move |v: &u32| if is_a { p.vertices()[*v as usize] } else { b_to_a.point(&p.vertices()[*v as usize]) };
            FaceLoop::new(p.face_vertices(face).iter().map(to_a))
        };
        let deepest_point = incident.vertices()[deepest_vertex];
        Self {
            reference,
            incident,
            reference_face: face,
            incident_face,
            reference_is_a,
            reference_loop: points(reference, face, reference_is_a),
            incident_loop: points(incident, incident_face, !reference_is_a),
            normal,
            depth: -deepest.distance,
            deepest_vertex,
            deepest_point: if reference_is_a { b_to_a.point(&deepest_point) } else { deepest_point },
        }
    }

    /// Clips, merges coincident corners and adds those below the reference face.
    fn push(&self, smaller: f64, out: &mut Manifold) {
        let first = out.len();
        let frame = Frame::new(self.normal, self.reference_loop.points());
        let reference = Corners::new(&frame, &self.reference_loop, Side::Reference);
        let incident = Corners::new(&frame, &self.incident_loop, Side::Incident);
        let mut polygon = Polygon::empty();
        for c in incident.all() {
            polygon.push(*c);
        }
        clip(&mut polygon, reference.all());
        let near = COINCIDENT * smaller;
        self.push_corners(polygon.corners(), &Context { frame: &frame, reference: &reference, incident: &incident, near }, out);
        if out.len() == first {
            // a polygon without area can lose its last corner to rounding; the contact must not be lost with it
            let position = self.deepest_point + self.normal * (0.5 * self.depth);
            let feature = self.incident_vertex_key(self.deepest_vertex as u32);
            out.push(self.contact(position, self.depth, near, feature));
        }
    }

    fn push_corners(&self, corners: &[Corner], context: &Context<'_>, out: &mut Manifold) {
        let n = corners.len();
        if n == 0 {
            return;
        }
        let coincide = |i: usize, j: usize| distance(&corners[i], &corners[j], true) <= context.near;
        // groups of coincident corners must not be split where the numbering starts
        let start = (0..n).find(|&i| !coincide((i + n - 1) % n, i)).unwrap_or(0);
        let mut k = 0;
        while k < n {
            let leader = (start + k) % n;
            let (mut feature, mut share, mut height) = (FeatureKey(u32::MAX), 0.0, f64::MAX);
            loop {
                let i = (start + k) % n;
                let (before, after) = ((i + n - 1) % n, (i + 1) % n);
                feature = feature.min(self.key(corners, before, i, context));
                share += 0.5 * (distance(&corners[before], &corners[i], false) + distance(&corners[i], &corners[after], false));
                height = height.min(corners[i].height);
                k += 1;
                if k == n || !coincide(i, after) {
                    break;
                }
            }
            if height < 0.0 {
                let position = context.frame.point(&corners[leader], 0.5 * height);
                out.push(self.contact(position, -height, share + context.near, feature));
            }
        }
    }

    fn contact(&self, position: Vec3, overlap: f64, share: f64, feature: FeatureKey) -> ManifoldPoint {
        let normal = if self.reference_is_a { self.normal } else { -self.normal };
        ManifoldPoint { position, normal, overlap, share, feature }
    }

    /// The key of corner `i`, the same whichever part is the reference: a vertex of `a` where there is one, else a
    /// vertex of `b`, else the two edges that cross.
    fn key(&self, corners: &[Corner], before: usize, i: usize, context: &Context<'_>) -> FeatureKey {
        let corner = &corners[i];
        let reference = context.reference.near(corner, context.near, false);
        let incident = context.incident.near(corner, context.near, true);
        let vertices = reference
            .map(|k| self.reference_vertex_key(self.reference.face_vertices(self.reference_face)[k]))
            .into_iter()
            .chain(incident.map(|k| self.incident_vertex_key(self.incident.face_vertices(self.incident_face)[k])));
        if let Some(key) = vertices.min() {
            return key;
        }
        let edge_of_reference = |k: u8| self.reference.face_edges(self.reference_face)[k as usize];
        let edge_of_incident = |k: u8| self.incident.face_edges(self.incident_face)[k as usize];
        match (corners[before].side, corner.side) {
            (Side::Incident(i), Side::Reference(r)) | (Side::Reference(r), Side::Incident(i)) => {
                let (r, i) = (edge_of_reference(r), edge_of_incident(i));
                if self.reference_is_a { FeatureKey::edges(r, i) } else { FeatureKey::edges(i, r) }
            }
            // between two sides of one face lies its vertex, up to rounding
            (Side::Incident(_), Side::Incident(k)) => {
                self.incident_vertex_key(self.incident.face_vertices(self.incident_face)[k as usize])
            }
            (Side::Reference(_), Side::Reference(k)) => {
                self.reference_vertex_key(self.reference.face_vertices(self.reference_face)[k as usize])
            }
        }
    }

    fn reference_vertex_key(&self, v: u32) -> FeatureKey {
        if self.reference_is_a { FeatureKey::vertex_of_a(v) } else { FeatureKey::vertex_of_b(v) }
    }

    fn incident_vertex_key(&self, v: u32) -> FeatureKey {
        if self.reference_is_a { FeatureKey::vertex_of_b(v) } else { FeatureKey::vertex_of_a(v) }
    }
}

/// What labels the corners of one lateral polygon.
struct Context<'c> {
    frame: &'c Frame,
    reference: &'c Corners,
    incident: &'c Corners,
    near: f64,
}

/// The vertices of a face in the plane of the reference face.
struct Corners(Polygon);

impl Corners {
    fn new(frame: &Frame, face: &FaceLoop, side: fn(u8) -> Side) -> Self {
        let mut corners = Polygon::empty();
        for (k, p) in (0..).zip(face.points()) {
            corners.push(frame.corner(p, side(k)));
        }
        Self(corners)
    }

    fn all(&self) -> &[Corner] {
        self.0.corners()
    }

    fn near(&self, corner: &Corner, near: f64, with_height: bool) -> Option<usize> {
        self.all().iter().position(|c| distance(c, corner, with_height) <= near)
    }
}

fn distance(c: &Corner, d: &Corner, with_height: bool) -> f64 {
    let (x, y) = (c.x - d.x, c.y - d.y);
    let height = if with_height { c.height - d.height } else { 0.0 };
    (x * x + y * y + height * height).sqrt()
}

/// The face that meets the reference, and the deepest vertex: of the faces with the most of the deepest vertices the
/// one that faces the reference most squarely. (The squarest face of all need not hold the deepest vertex.)
fn incident_face(p: &Polyhedron, along: &Vec3, tolerance: f64) -> (usize, usize) {
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
    (best.0, vertex)
}
