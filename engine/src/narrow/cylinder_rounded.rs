//! A cylinder with flat caps and a rounded polyhedron: the features of its skeleton against those of the cylinder.
//!
//! While the skeleton and the cylinder are apart, the points where their distance is least are among these, r - distance deep:
//!
//! | pair | where |
//! |---|---|
//! | rim, face | of either rim the deepest point, its opposite and the two halfway, where the foot lies inside the face |
//! | rim, edge | where the distance of circle and line is least, up to two places, with the foot strictly inside the edge |
//! | side, edge | the common perpendicular of axis and edge, with its feet inside both |
//! | cap, side or rim, vertex | the nearest point of the cylinder |
//!
//! A pair counts where either feature is the nearest one of its body. Flat contacts lie on the boundary of these regions,
//! where the answer must not jump: a pair whose direction leans out of its region by a little because cap and face, axis and
//! face, cap and edge or axis and edge are nearly parallel keeps a share that fades out with the lean.
//! A convex skeleton that is inside the cylinder meets it as a sharp polyhedron does, deeper by r.

use super::cylinder::{QUARTERS, Solid};
use super::cylinder_polyhedron::cylinder_polyhedron;
use super::outline::Outline;
use super::segments::SegmentPair;
use super::{Cylinder, FeatureKey, Manifold, ManifoldPoint};
use crate::math::{Similarity, Vec3};
use crate::shape::{Part, RoundedPolyhedron, Side, Skeleton, SkeletonEdge};

/// Sine of the angle by which the direction of a flat contact may lean out of a region.
const LEAN: f64 = 0.1;
/// Sine of the angle between two features from which they are not flat on each other.
const FLAT: f64 = 0.2;
/// Feet this close to an end of an edge, over its length, belong to the vertex.
const END: f64 = 1e-9;
/// Regions overlap by so much, over the rounding radius, and by this over the size.
const TIE: [f64; 2] = [1e-6, 4e-9];
/// Squared sine below which axis and edge are parallel: their ends cover them.
const PARALLEL2: f64 = 1e-12;
/// Shares below this are rounding of a point that its neighbours stand for.
const FADED: f64 = 1e-9;
/// Distance over the cylinder's radius below which two points stand for one.
const BESIDE: f64 = 0.5;
/// Name of the side of the cylinder among what meets an edge, after two places of each rim.
const SIDE: u32 = 4;

/// The touching points, nothing if the parts are apart. The answer is how far they are apart at least, or minus the depth.
pub fn cylinder_rounded(
    (part_a, a): (&Part, &Cylinder),
    (part_b, b): (&Part, &RoundedPolyhedron),
    b_to_a: &Similarity,
    out: &mut Manifold,
) -> f64 {
    let (first, reach) = (out.len(), b.skeleton.radius * b_to_a.scale);
    let mut proven = f64::MIN;
    if let Some(core) = &b.solid {
        let distance = cylinder_polyhedron((part_a, a), (part_b, core), (b_to_a, f64::INFINITY), out);
        for point in &mut out.points_mut()[first..] {
            point.overlap += reach;
            point.position -= point.normal * (0.5 * reach);
        }
        if distance < 0.0 || distance >= reach {
            return distance - reach;
        }
        proven = distance;
    }
    let solid = Solid::of(a).mapped(&b_to_a.inverse());
    let skeleton = &b.skeleton;
    let tie = (TIE[0] * skeleton.radius).max(TIE[1] * (skeleton.reach + skeleton.radius));
    let mut search = Search { solid: &solid, skeleton, tie, least: f64::INFINITY, first, out };
    search.vertices();
    search.edges();
    search.faces();
    share_between_neighbours(&mut search.out.points_mut()[first..], BESIDE * solid.radius);
    let least = search.least * b_to_a.scale;
    out.map_from(first, b_to_a);
    let depth = out.points()[first..].iter().map(|point| point.overlap).fold(0.0, f64::max);
    if depth > 0.0 { -depth } else { (proven.max(least) - reach).max(0.0) }
}

/// 1 for features that are parallel, 0 from the sine on from which they are not flat on each other.
fn flatness(squared_sine: f64) -> f64 {
    (1.0 - squared_sine / (FLAT * FLAT)).max(0.0)
}

/// Divides the shares of points that are next to each other: at the corner of a patch one point becomes two.
fn share_between_neighbours(points: &mut [ManifoldPoint], beside: f64) {
    let mut crowd = [1.0; super::MAX_POINTS];
    for (i, p) in points.iter().enumerate() {
        for (j, q) in points[..i].iter().enumerate() {
            let near = 1.0 - (p.position - q.position).norm() / beside;
            if near > 0.0 {
                crowd[i] += near * q.share * (q.overlap / p.overlap).min(1.0);
                crowd[j] += near * p.share * (p.overlap / q.overlap).min(1.0);
            }
        }
    }
    points.iter_mut().zip(crowd).for_each(|(point, crowd)| point.share /= crowd);
}

/// A place where a feature of the skeleton may touch the cylinder.
struct Place {
    /// On the skeleton.
    at: Vec3,
    /// Unit vector from there to the cylinder.
    direction: Vec3,
    /// To the surface of the cylinder; negative inside.
    distance: f64,
}

/// The search in the frame of the skeleton.
struct Search<'s> {
    solid: &'s Solid,
    skeleton: &'s Skeleton,
    /// Width of the boundaries between regions, as a length.
    tie: f64,
    /// Lower bound of the distance of cylinder and skeleton.
    least: f64,
    first: usize,
    out: &'s mut Manifold,
}

impl Search<'_> {
    fn radius(&self) -> f64 {
        self.skeleton.radius
    }

    fn push(&mut self, place: &Place, share: f64, feature: FeatureKey) {
        let overlap = self.radius() - place.distance;
        if overlap > 0.0 && share > FADED {
            let position = place.at + place.direction * (0.5 * (self.radius() + place.distance));
            self.out.push_deepest(ManifoldPoint { position, normal: -place.direction, overlap, share, feature });
        }
    }

    /// What is left of a pair's share where its direction leans out of a region by this sine; `flat` is 1 where the features
    /// are parallel.
    fn kept(&self, lean: f64, flat: f64, distance: f64) -> f64 {
        if lean <= 0.0 || lean * distance.abs() <= self.tie {
            return 1.0;
        }
        (1.0 - lean / (LEAN * flat)).max(0.0)
    }

    fn vertices(&mut self) {
        let skeleton = self.skeleton;
        for (k, v) in skeleton.vertices().iter().enumerate() {
            let (distance, direction) = self.solid.distance(v);
            self.least = self.least.min(distance);
            if distance >= self.radius() {
                continue;
            }
            let d = v - self.solid.center;
            let along = d.dot(&self.solid.axis);
            let beside = (d - self.solid.axis * along).norm() <= self.solid.radius;
            let (over_cap, over_side) = (along.abs() > self.solid.half && beside, along.abs() <= self.solid.half);
            let direction = -direction;
            let share = skeleton.directions(k).iter().map(|edge| {
                let cosine2 = edge.dot(&self.solid.axis).powi(2);
                let flat = match (over_cap, over_side) {
                    (true, _) => flatness(cosine2),
                    (_, true) => flatness(1.0 - cosine2),
                    _ => 0.0,
                };
                self.kept(edge.dot(&direction), flat, distance)
            });
            let share = share.fold(1.0, f64::min);
            self.push(&Place { at: *v, direction, distance }, share, FeatureKey::vertex_of_b(k as u32));
        }
    }

    fn edges(&mut self) {
        let skeleton = self.skeleton;
        let axis = [self.solid.cap(-1.0), self.solid.cap(1.0)];
        for (k, edge) in skeleton.edges().iter().enumerate() {
            let pair = SegmentPair::new(&[edge.start, edge.start + edge.along], &axis);
            let (s, t) = pair.closest();
            let distance = (pair.on_p(s) - pair.on_q(t)).norm() - self.solid.radius;
            self.least = self.least.min(distance);
            if distance < self.radius() && edge.length2 > 0.0 {
                let sides = skeleton.sides_at_edge(k);
                self.rims_at_edge(k as u32, edge, sides);
                self.side_at_edge(k as u32, edge, sides);
            }
        }
    }

    /// How much of a share is left by the faces that meet in an edge; `flat` tells how nearly one is parallel to a feature.
    fn kept_at_edge(&self, sides: &[Side], place: &Place, flat: impl Fn(&Side) -> f64) -> f64 {
        let of_side = |side: &Side| self.kept(side.inwards.dot(&place.direction), flat(side), place.distance);
        sides.iter().map(of_side).fold(1.0, f64::min)
    }

    fn rims_at_edge(&mut self, k: u32, edge: &SkeletonEdge, sides: &[Side]) {
        let solid = self.solid;
        let length = edge.length2.sqrt();
        let along = edge.along / length;
        let outline = Outline::new(solid, &along);
        let reach = solid.radius + self.radius();
        for (rim, sense) in [(0, -1.0), (1, 1.0)] {
            let cap = solid.cap(sense);
            let foot = edge.start + along * along.dot(&(cap - edge.start)).clamp(0.0, length);
            if (cap - foot).norm_squared() >= reach * reach {
                continue;
            }
            outline.feet(sense, &edge.start, |foot| {
                let s = along.dot(&(foot.on_rim - edge.start));
                if !(s > END * length && s < (1.0 - END) * length) {
                    return;
                }
                let radial = (foot.on_rim - cap) / solid.radius;
                let end = u32::from(radial.dot(&along) >= 0.0);
                let key = FeatureKey::edges(2 * rim + end, k);
                let outwards = [solid.axis * sense, radial];
                let Some(place) = self.at_rim(&(edge.start + along * s), &foot.on_rim, &along, &outwards) else {
                    return;
                };
                // the same place may come twice
                if self.overlap_of(key) > 0.0 || place.distance >= self.radius() {
                    return;
                }
                let (direction, distance) = (&place.direction, place.distance);
                let cosine2 = along.dot(&solid.axis).powi(2);
                let beyond_cap = self.kept(radial.dot(direction), flatness(cosine2), distance);
                let beyond_side = self.kept(outwards[0].dot(direction), flatness(1.0 - cosine2), distance);
                let flat = |side: &Side| flatness(1.0 - side.inwards.cross(&along).dot(&solid.axis).powi(2));
                let share = beyond_cap.min(beyond_side).min(self.kept_at_edge(sides, &place, flat));
                self.push(&place, share, key);
            });
        }
    }

    /// The place of a point of an edge and its nearest one on a rim, where cap and side look along `outwards`. None if the
    /// cylinder is in between.
    fn at_rim(&self, x: &Vec3, on_rim: &Vec3, along: &Vec3, outwards: &[Vec3; 2]) -> Option<Place> {
        let gap = on_rim - x;
        let distance = gap.norm();
        let middle = outwards[0] + outwards[1];
        let inside = distance <= self.radius() && self.solid.distance(x).0 < 0.0;
        let direction = if distance > self.tie {
            gap * (if inside { -1.0 } else { 1.0 } / distance)
        } else {
            // across both tangents: next to touching the difference of the points is rounding
            let across = outwards[0].cross(&outwards[1]).cross(along);
            let across = across.try_normalize(1e-9).unwrap_or(-middle.normalize());
            across * -1.0_f64.copysign(across.dot(&middle))
        };
        (direction.dot(&middle) < 0.0).then(|| Place { at: *x, direction, distance: gap.dot(&direction) })
    }

    /// Overlap and share of a point that is there, else 0.
    fn overlap_of(&self, key: FeatureKey) -> f64 {
        let points = &self.out.points()[self.first..];
        points.iter().find(|point| point.feature == key).map_or(0.0, |point| point.share * point.overlap)
    }

    fn side_at_edge(&mut self, k: u32, edge: &SkeletonEdge, sides: &[Side]) {
        let solid = self.solid;
        let (start, axis) = (solid.cap(-1.0), solid.axis * (2.0 * solid.half));
        let cross = edge.along.cross(&axis);
        let squared = cross.norm_squared();
        let squared_sine = squared / (edge.length2 * axis.norm_squared());
        if squared_sine <= PARALLEL2 {
            return;
        }
        let between = start - edge.start;
        let on_edge = between.cross(&axis).dot(&cross) / squared;
        let on_axis = between.cross(&edge.along).dot(&cross) / squared;
        if !(on_edge > END && on_edge < 1.0 - END && (0.0..=1.0).contains(&on_axis)) {
            return;
        }
        let height = between.dot(&cross) / squared.sqrt();
        let direction = cross * (1.0_f64.copysign(height) / squared.sqrt());
        let place = Place { at: edge.start + edge.along * on_edge, direction, distance: height.abs() - solid.radius };
        let overlap = self.radius() - place.distance;
        if overlap <= 0.0 {
            return;
        }
        let length = edge.length2.sqrt();
        let flat = |side: &Side| flatness((side.inwards.cross(&edge.along).dot(&solid.axis) / length).powi(2));
        let mut share = self.kept_at_edge(sides, &place, flat);
        // where they are parallel the place is undefined, and the ends of the stretch stand for it
        let parallel = flatness(squared_sine);
        if parallel > 0.0 {
            let ends = edge.vertices.map(FeatureKey::vertex_of_b).into_iter();
            let ends = ends.chain((0..SIDE).map(|name| FeatureKey::edges(name, k)));
            let deepest = ends.map(|key| self.overlap_of(key)).fold(0.0, f64::max);
            share *= 1.0 - parallel * (deepest / overlap).min(1.0);
        }
        self.push(&place, share, FeatureKey::edges(SIDE, k));
    }

    fn faces(&mut self) {
        let skeleton = self.skeleton;
        for (f, plane) in skeleton.faces().iter().enumerate() {
            let height = plane.normal.dot(&self.solid.center) - plane.offset;
            // faces of a closed convex skeleton have an outside, others are two-sided
            let sense = if skeleton.is_convex() { 1.0 } else { 1.0_f64.copysign(height) };
            let above = sense * height - self.solid.reach_along(&plane.normal);
            let sides = skeleton.sides(f).iter();
            let beyond = |s: &Side| s.offset - s.inwards.dot(&self.solid.center) - self.solid.reach_along(&s.inwards);
            let distance = sides.map(beyond).fold(above, f64::max);
            self.least = self.least.min(distance);
            if distance < self.radius() {
                self.rims_at_face(f, &(plane.normal * sense), plane.offset * sense);
            }
        }
    }

    fn rims_at_face(&mut self, face: usize, normal: &Vec3, offset: f64) {
        let (solid, skeleton) = (self.solid, self.skeleton);
        let ring = solid.ring(&-normal);
        let drop = solid.radius * ring.sine;
        let around = [(ring.deepest, -1.0), (ring.side, 0.0), (-ring.deepest, 1.0), (-ring.side, 0.0)];
        let lowest = if skeleton.is_convex() { -self.tie } else { -self.radius() };
        for (rim, sense) in [(0, -1.0), (1, 1.0)] {
            let center = solid.cap(sense);
            let height = normal.dot(&center) - offset;
            let whole_rim = height + drop < self.radius();
            let lean = sense * solid.axis.dot(normal);
            for (k, (outwards, rise)) in (0..).zip(&around) {
                let distance = height + rise * drop;
                if distance >= self.radius() || distance < lowest {
                    continue;
                }
                let on_rim = center + outwards * solid.radius;
                if skeleton.sides(face).iter().any(|s| s.inwards.dot(&on_rim) - s.offset < -skeleton.tolerance) {
                    continue;
                }
                let foot = on_rim - normal * distance;
                // around the edge of a sheet it is behind the face, and has not come through it
                if distance < -self.tie && solid.distance(&foot).0 > 0.0 {
                    continue;
                }
                let share = self.kept(lean.max(rise * ring.sine), 1.0, distance);
                let slot = QUARTERS * rim + ring.slot(k, QUARTERS, whole_rim);
                let place = Place { at: foot, direction: *normal, distance };
                self.push(&place, share, FeatureKey::vertex_of_a_on_face(slot, face as u32));
            }
        }
    }
}
