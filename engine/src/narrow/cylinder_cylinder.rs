//! Two cylinders with flat caps: separating-axis test, then the points that caps and sides share.
//!
//! As for a polyhedron the nearest way out of the Minkowski difference leads to a smooth point of its surface: a cap, two
//! sides, a side against a rim (in closed form or in a bracket), and two rims, whose nearest points are found on a ring
//! of samples of one of them (`rims.rs`). Every direction is measured with the full supports.

use super::cylinder::Solid;
use super::cylinder_facets::{Contact, Facing, Line, crossing_key};
use super::face_contact::COINCIDENT;
use super::outline::Outline;
use super::rims::rim_directions;
use super::spherocylinder_spherocylinder::{parallelism, push_shared};
use super::{Cylinder, FeatureKey, Manifold, ManifoldPoint};
use crate::math::{Similarity, Vec3};

/// Any other direction must beat those of the caps by this, over the size of the pair.
const FACE_PREFERENCE: f64 = 1e-12;
/// Slack of distances that are compared to leave features out, over the size of the pair: far above rounding.
const SLACK: f64 = 1e-9;
/// Sine of the angle between the axes below which they are parallel to rounding.
const PARALLEL: f64 = 1e-14;

/// The points of a contact with a cap or along the sides, or a single one; nothing if the parts are apart. The answer is how
/// far they are apart at least, or minus the depth. `apart` is the most that they can be apart, infinite where it is not
/// known.
pub fn cylinder_cylinder((a, b): (&Cylinder, &Cylinder), b_to_a: &Similarity, apart: f64, out: &mut Manifold) -> f64 {
    let (a, b) = (Solid::of(a), Solid::of(b).mapped(b_to_a));
    let found = match Search::run(&a, &b, apart) {
        Ok(found) => found,
        Err(gap) => return gap,
    };
    let towards = found.towards;
    let near = COINCIDENT * a.reach().min(b.reach());
    // a rim of the other on a cap is one of its own points
    let feature = crossing_key(if found.is_cap { 3 } else { 0 });
    let contact = Contact { towards, depth: -found.distance, near, fallback: (found.middle, feature) };
    match (Facing::new(&a, &towards, true), Facing::new(&b, &-towards, false)) {
        (Facing::Cap(cap), Facing::Cap(other)) => cap.push_on_cap(other, &contact, out),
        (Facing::Line(line), Facing::Cap(cap)) => line.push_on_cap(&cap, &contact, out),
        (Facing::Cap(cap), Facing::Line(line)) => line.push_on_cap(&cap, &contact.reversed(), out),
        (Facing::Line(of_a), Facing::Line(of_b)) => {
            let first = out.len();
            if let Some((ends, length)) = side_by_side([&a, &b], [&of_a, &of_b], &contact) {
                let fade = parallelism(&of_a.ends, &of_b.ends);
                push_shared(&mut contact.single(), ends, fade, length, out);
            }
            if out.len() == first {
                out.push(contact.single());
            }
        }
    }
    -contact.depth
}

/// First and last end of either line that lies beside the other cylinder, each as deep as it is in that one's side.
fn side_by_side(
    solids: [&Solid; 2],
    lines: [&Line; 2],
    contact: &Contact,
) -> Option<([Option<ManifoldPoint>; 2], f64)> {
    let axis = solids[0].axis + solids[1].axis * 1.0_f64.copysign(solids[0].axis.dot(&solids[1].axis));
    let axis = axis.normalize();
    let mut ends: [Option<(f64, Option<ManifoldPoint>)>; 2] = [None, None];
    for (k, line) in lines.into_iter().enumerate() {
        let other = solids[1 - k];
        for (j, x) in (0..).zip(&line.ends) {
            let d = x - other.center;
            let along = d.dot(&other.axis);
            if along.abs() > other.half + contact.near {
                continue;
            }
            let point = end_point(x, &(d - other.axis * along), other.radius, contact, (k == 0, j));
            let place = axis.dot(x);
            if ends[0].is_none_or(|(first, _)| place < first) {
                ends[0] = Some((place, point));
            }
            if ends[1].is_none_or(|(last, _)| place > last) {
                ends[1] = Some((place, point));
            }
        }
    }
    let [(from, first), (to, last)] = [ends[0]?, ends[1]?];
    (to - from > contact.near).then_some(([first, last], to - from))
}

/// The j-th end of a line, seen from the other axis: as deep as it is in the side, at most the whole depth.
fn end_point(x: &Vec3, radial: &Vec3, radius: f64, contact: &Contact, (of_a, j): (bool, u32)) -> Option<ManifoldPoint> {
    let towards = if of_a { contact.towards } else { -contact.towards };
    let rho = radial.norm();
    // beyond the other axis its own way out is the wrong one, and deeper than the way out of all of it a longer one
    let goes_along = radial.dot(&towards) >= 0.0 || radius - rho > contact.depth;
    let (overlap, into) = if goes_along { (contact.depth, towards) } else { (radius - rho, radial / -rho) };
    let feature = if of_a { FeatureKey::vertex_of_a(j) } else { FeatureKey::vertex_of_b(j) };
    let normal = if of_a { into } else { -into };
    let position = x - into * (0.5 * overlap);
    (overlap > 0.0).then_some(ManifoldPoint { position, normal, overlap, share: 0.0, feature })
}

/// A direction from `a` to `b`, the separation along it, and where the parts meet in the middle.
struct Found {
    towards: Vec3,
    distance: f64,
    middle: Vec3,
    is_cap: bool,
}

struct Search<'s> {
    a: &'s Solid,
    b: &'s Solid,
    best: Found,
    to_beat: f64,
    /// The most that the parts can be apart.
    apart: f64,
    /// Whether the directions measured now are those of caps.
    is_cap: bool,
}

impl<'s> Search<'s> {
    /// The deepest direction, or the gap along one that separates.
    fn run(a: &'s Solid, b: &'s Solid, apart: f64) -> Result<Found, f64> {
        let nothing = Found { towards: a.axis, distance: f64::MIN, middle: a.center, is_cap: true };
        let mut search = Self { a, b, best: nothing, to_beat: f64::MIN, apart, is_cap: true };
        let d = b.center - a.center;
        let facing = |n: Vec3| n * 1.0_f64.copysign(n.dot(&d));
        search.measure(facing(a.axis), |towards, distance| b.support(&-towards) - towards * (0.5 * distance));
        search.measure(facing(b.axis), |towards, distance| a.support(&towards) + towards * (0.5 * distance));
        search.is_cap = false;
        search.to_beat = (search.best.distance + FACE_PREFERENCE * (a.reach() + b.reach())).min(0.0);
        if search.best.distance >= 0.0 {
            return Err(search.best.distance);
        }
        search.sides(&facing);
        search.side_at_rims(true);
        search.side_at_rims(false);
        if search.best.distance < 0.0 {
            let bounds = [-search.to_beat, search.most()];
            let slack = search.slack();
            rim_directions(a, b, bounds, |towards, middle, apart| {
                search.measure_if(towards, |_, _| middle, |_, distance| apart <= distance.abs() + 0.5 * slack);
            });
        }
        if search.best.distance < 0.0 { Ok(search.best) } else { Err(search.best.distance) }
    }

    fn measure(&mut self, towards: Vec3, at: impl Fn(Vec3, f64) -> Vec3) {
        self.measure_if(towards, at, |_, _| true);
    }

    /// Measures a direction with the full supports, of features that are near enough to each other for its distance.
    fn measure_if(&mut self, towards: Vec3, at: impl Fn(Vec3, f64) -> Vec3, are_near: impl Fn(&Self, f64) -> bool) {
        let d = self.b.center - self.a.center;
        let distance = towards.dot(&d) - self.a.reach_along(&towards) - self.b.reach_along(&towards);
        if distance > self.to_beat && are_near(self, distance) {
            let (middle, is_cap) = (at(towards, distance), self.is_cap);
            (self.best, self.to_beat) = (Found { towards, distance, middle, is_cap }, distance);
        }
    }

    /// The features that decide are no farther from each other than this: as far as the parts are deep, or apart.
    fn most(&self) -> f64 {
        (-self.to_beat).max(self.apart) + self.slack()
    }

    fn slack(&self) -> f64 {
        SLACK * (self.a.reach() + self.b.reach())
    }

    fn sides(&mut self, facing: &impl Fn(Vec3) -> Vec3) {
        let cross = self.a.axis.cross(&self.b.axis);
        let sine = cross.norm();
        if sine > PARALLEL {
            let line = |solid: &Solid| [solid.cap(-1.0), solid.cap(1.0)];
            let (x, y) = super::segment_segment(&line(self.a), &line(self.b));
            let (a, b) = (self.a.radius, self.b.radius);
            self.measure(facing(cross / sine), |towards, _| (x + towards * a + y - towards * b) * 0.5);
        }
    }

    /// The side of one against the rims of the other: seen along its axis it is a disc.
    fn side_at_rims(&mut self, of_a: bool) {
        let (side, rims) = if of_a { (self.a, self.b) } else { (self.b, self.a) };
        let most = self.most();
        let near = [1.0, -1.0].map(|sense| is_near(side, rims, sense, most));
        if near == [false; 2] {
            return;
        }
        let outline = Outline::new(rims, &side.axis);
        for (sense, _) in [1.0, -1.0].into_iter().zip(near).filter(|(_, near)| *near) {
            outline.feet(sense, &side.center, |foot| {
                let towards = if of_a { -foot.outwards } else { foot.outwards };
                // beside the side, also where the axes are parallel and any rim point is as near; from the surface of the one with the rims into its overlap with the other
                let along = side.axis.dot(&(foot.on_rim - side.center));
                let beside = foot.on_rim + side.axis * (along.clamp(-side.half, side.half) - along);
                self.measure_if(
                    towards,
                    |_, distance| beside + foot.outwards * (0.5 * distance),
                    // by the same rule as above, so that what is known of a pair does not show in ties
                    |search, distance| is_near(side, rims, sense, distance.abs() + 0.5 * search.slack()),
                );
            });
        }
    }
}

/// Whether the rim of a cap may be no farther from the side of the other than `most`.
fn is_near(side: &Solid, rims: &Solid, sense: f64, most: f64) -> bool {
    let d = rims.cap(sense) - side.center;
    let along = side.axis.dot(&d);
    let rho = (d - side.axis * along).norm();
    along.abs() - rims.radius <= side.half + most
        && rho - rims.radius <= side.radius + most
        && rho + rims.radius >= side.radius - most
}
