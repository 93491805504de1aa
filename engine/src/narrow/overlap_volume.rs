//! The volume that two convex polyhedra share, or that one has behind a plane, with its gradient.
//!
//! One solid is cut by the planes of the other one after the other. Every cut closes the solid again with one polygon,
//! so that volume and gradient are those of a closed body whatever lies in one plane. The gradient of the volume by a
//! motion of `b` is the flux of that motion through the faces that `b` contributes.

use crate::math::{Similarity, Vec3};
use crate::shape::Polyhedron;

/// A shared volume; lengths in the unit of the frame of `a`, everything in that frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedVolume {
    /// V.
    pub volume: f64,
    /// Its centroid.
    pub centroid: Vec3,
    /// Sum of the areas that `b` contributes times its outward normals: dV/dx of `b`.
    pub area: Vec3,
    /// The same with position: dV of a rotation of `b` about the origin.
    pub moment: Vec3,
}

/// A triangle of the surface of what is shared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedFacet {
    /// Its centroid.
    pub position: Vec3,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Its area.
    pub area: f64,
}

/// A polygon of the body that is being cut.
#[derive(Clone, Copy, Debug)]
struct Polygon {
    first: usize,
    len: usize,
    of_b: bool,
}

/// Buffers of one task.
#[derive(Clone, Debug, Default)]
pub struct Cutter {
    points: Vec<Vec3>,
    polygons: Vec<Polygon>,
    next_points: Vec<Vec3>,
    next_polygons: Vec<Polygon>,
    cap: Vec<(f64, Vec3)>,
}

impl Cutter {
    /// What `a` and `b` share, with its facets on the surface of `b`; `None` if nothing.
    pub fn pair(
        &mut self,
        (a, b): (&Polyhedron, &Polyhedron),
        b_to_a: &Similarity,
        facets: &mut Vec<SharedFacet>,
    ) -> Option<SharedVolume> {
        self.start(a, &Similarity::identity());
        for face in b.faces() {
            let normal = b_to_a.direction(&face.normal);
            let offset = normal.dot(&b_to_a.translation) + b_to_a.scale * face.offset;
            if !self.cut(&normal, offset) {
                return None;
            }
        }
        self.measure(true, facets)
    }

    /// What a solid has below the plane z = 0 of the frame that `to_wall` leads to; the wall is `b`. The facets are
    /// those in the plane, or those below it.
    pub fn below_plane(
        &mut self,
        solid: &Polyhedron,
        to_wall: &Similarity,
        facets_in_plane: bool,
        facets: &mut Vec<SharedFacet>,
    ) -> Option<SharedVolume> {
        self.start(solid, to_wall);
        if self.cut(&Vec3::z(), 0.0) { self.measure(facets_in_plane, facets) } else { None }
    }

    fn start(&mut self, solid: &Polyhedron, pose: &Similarity) {
        self.points.clear();
        self.polygons.clear();
        for face in 0..solid.faces().len() {
            let first = self.points.len();
            self.points.extend(solid.face_vertices(face).iter().map(|&v| pose.point(&solid.vertices()[v as usize])));
            self.polygons.push(Polygon { first, len: self.points.len() - first, of_b: false });
        }
    }

    /// Keeps what lies behind the plane `normal . x = offset` and closes it there; false if nothing is left.
    fn cut(&mut self, normal: &Vec3, offset: f64) -> bool {
        let height = |x: &Vec3| normal.dot(x) - offset;
        let (mut some_above, mut some_below) = (false, false);
        for x in &self.points {
            let h = height(x);
            some_above |= h > 0.0;
            some_below |= h < 0.0;
        }
        if !some_above {
            return some_below;
        }
        if !some_below {
            return false;
        }
        let Self { points, polygons, next_points, next_polygons, cap } = self;
        next_points.clear();
        next_polygons.clear();
        cap.clear();
        for polygon in polygons.iter() {
            let corners = &points[polygon.first..polygon.first + polygon.len];
            let first = next_points.len();
            for (k, x) in corners.iter().enumerate() {
                let y = &corners[(k + 1) % corners.len()];
                let (hx, hy) = (height(x), height(y));
                if hx <= 0.0 {
                    next_points.push(*x);
                }
                // from the inner to the outer end in both polygons of an edge: the same bits
                if hx <= 0.0 && hy > 0.0 {
                    let crossing = x + (y - x) * (hx / (hx - hy));
                    next_points.push(crossing);
                    // each corner of the cap is where one polygon is left
                    cap.push((0.0, crossing));
                } else if hx > 0.0 && hy <= 0.0 {
                    next_points.push(y + (x - y) * (hy / (hy - hx)));
                }
            }
            let len = next_points.len() - first;
            if len >= 3 {
                next_polygons.push(Polygon { first, len, of_b: polygon.of_b });
            } else {
                next_points.truncate(first);
            }
        }
        if cap.len() >= 3 {
            sort_around(normal, cap);
            let first = next_points.len();
            next_points.extend(cap.iter().map(|(_, x)| *x));
            next_polygons.push(Polygon { first, len: cap.len(), of_b: true });
        }
        std::mem::swap(points, next_points);
        std::mem::swap(polygons, next_polygons);
        !self.polygons.is_empty()
    }

    /// Sums over triangles about the middle of each polygon.
    fn measure(&self, facets_of_b: bool, facets: &mut Vec<SharedFacet>) -> Option<SharedVolume> {
        facets.clear();
        let origin = *self.points.first()?;
        let (mut volume, mut first_moment) = (0.0, Vec3::zeros());
        let (mut area, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for polygon in &self.polygons {
            let corners = &self.points[polygon.first..polygon.first + polygon.len];
            let middle = corners.iter().sum::<Vec3>() / corners.len() as f64;
            for (k, x) in corners.iter().enumerate() {
                let y = &corners[(k + 1) % corners.len()];
                let triangle = (x - middle).cross(&(y - middle)) * 0.5;
                let centroid = (middle + x + y) / 3.0;
                let cone = triangle.dot(&(middle - origin)) / 3.0;
                volume += cone;
                // the cone's centroid is a quarter of the way from its base to its tip
                first_moment += (centroid - origin) * (0.75 * cone);
                if polygon.of_b {
                    area += triangle;
                    moment += centroid.cross(&triangle);
                }
                let size = triangle.norm();
                if polygon.of_b == facets_of_b && size > 0.0 {
                    facets.push(SharedFacet { position: centroid, normal: triangle / size, area: size });
                }
            }
        }
        (volume > 0.0).then(|| SharedVolume { volume, centroid: origin + first_moment / volume, area, moment })
    }
}

/// Counter-clockwise about the normal.
fn sort_around(normal: &Vec3, corners: &mut [(f64, Vec3)]) {
    let middle = corners.iter().map(|(_, x)| x).sum::<Vec3>() / corners.len() as f64;
    let farthest = corners
        .iter()
        .map(|(_, x)| x - middle)
        .fold(Vec3::zeros(), |far, arm| if arm.norm_squared() > far.norm_squared() { arm } else { far });
    let across = normal.cross(&farthest);
    for (angle, x) in corners.iter_mut() {
        let arm = *x - middle;
        *angle = arm.dot(&across).atan2(arm.dot(&farthest));
    }
    corners.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Quat;
    use crate::random::{Draw, Purpose};
    use crate::shape::{PartGeometry, Shape, ShapeDescription};

    fn solid(description: &ShapeDescription) -> Polyhedron {
        let shape = Shape::build(description).unwrap();
        let PartGeometry::Polyhedron(solid) = &shape.parts()[0].geometry else { panic!() };
        solid.clone()
    }

    fn cube() -> Polyhedron {
        solid(&ShapeDescription::Cube { edge_m: 1.0 })
    }

    fn pose(turn: &Quat, shift: Vec3) -> Similarity {
        Similarity::rigid(*turn.to_rotation_matrix().matrix(), shift)
    }

    /// Aligned cubes, coplanar sides included: a cuboid, its face of `b`, and no sideways pull.
    #[test]
    fn aligned_cubes_share_a_cuboid() {
        let (cube, mut cutter, mut facets) = (cube(), Cutter::default(), Vec::new());
        for (shift, size) in [
            (Vec3::new(0.0, 0.0, 1.0 - 1e-3), Vec3::new(1.0, 1.0, 1e-3)),
            (Vec3::new(0.25, 0.0, 0.9), Vec3::new(0.75, 1.0, 0.1)),
            (Vec3::new(0.25, -0.5, 0.9), Vec3::new(0.75, 0.5, 0.1)),
        ] {
            let shared = cutter.pair((&cube, &cube), &pose(&Quat::identity(), shift), &mut facets).unwrap();
            let volume = size.product();
            assert!((shared.volume - volume).abs() < 1e-15, "{shared:?}");
            assert!((shared.area.z + size.x * size.y).abs() < 1e-14, "{shared:?}");
            assert!((shared.centroid.z - (0.5 - 0.5 * size.z)).abs() < 1e-12, "{shared:?}");
        }
        let above = pose(&Quat::identity(), Vec3::z());
        assert_eq!(cutter.pair((&cube, &cube), &above, &mut facets), None);
        let apart = pose(&Quat::from_scaled_axis(Vec3::x()), Vec3::new(0.0, 0.3, 3.0));
        assert_eq!(cutter.pair((&cube, &cube), &apart, &mut facets), None);
    }

    /// Random poses of cube, tetrahedron and pinacoid: dV is the flux, for shifts and rotations of `b`; the facets add
    /// up to the area; swapping the solids gives the same volume.
    #[test]
    fn gradient_is_that_of_the_volume() {
        let solids = [
            cube(),
            solid(&ShapeDescription::Tetrahedron { edge_m: 1.4 }),
            solid(&ShapeDescription::Pinacoid { length_m: 1.0, width_m: 1.0, height_m: 1.0, alpha_deg: 60.0 }),
        ];
        let (mut draw, mut cutter, mut facets) = (Draw::new(5, 0, Purpose::Position), Cutter::default(), Vec::new());
        let mut shared_count = 0;
        for round in 0..400 {
            let (a, b) = (&solids[round % 3], &solids[(round / 3) % 3]);
            let turn = Quat::from_scaled_axis(Vec3::from_fn(|_, _| draw.between(-3.0, 3.0)));
            let shift = Vec3::from_fn(|_, _| draw.between(-0.7, 0.7));
            let Some(shared) = cutter.pair((a, b), &pose(&turn, shift), &mut facets) else { continue };
            if shared.volume < 1e-4 {
                continue;
            }
            shared_count += 1;
            let sum: Vec3 = facets.iter().map(|facet| facet.normal * facet.area).sum();
            assert!((sum - shared.area).norm() < 1e-12);
            let back = pose(&turn, shift).inverse();
            let swapped = cutter.pair((b, a), &back, &mut facets).unwrap();
            assert!((swapped.volume - shared.volume).abs() < 1e-12);
            let h = 1e-6;
            let mut slope = |moved: &dyn Fn(f64) -> Similarity| {
                let mut at = |h: f64| cutter.pair((a, b), &moved(h), &mut facets).map_or(0.0, |s| s.volume);
                (at(h) - at(-h)) / (2.0 * h)
            };
            for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
                let by_shift = slope(&|h| pose(&turn, shift + axis * h));
                assert!((by_shift - shared.area.dot(&axis)).abs() < 1e-6, "{by_shift} {shared:?}");
                let by_turn = slope(&|h| {
                    let q = Quat::from_scaled_axis(axis * h);
                    pose(&(q * turn), q * shift)
                });
                assert!((by_turn - shared.moment.dot(&axis)).abs() < 1e-6, "{by_turn} {shared:?}");
            }
        }
        assert!(shared_count > 200, "{shared_count}");
    }

    /// A cube below a plane, upright and on its corner: cuboid and pyramid.
    #[test]
    fn submerged_part_of_a_cube() {
        let (cube, mut cutter, mut facets) = (cube(), Cutter::default(), Vec::new());
        let upright = pose(&Quat::identity(), Vec3::new(0.3, 0.2, 0.4));
        let shared = cutter.below_plane(&cube, &upright, true, &mut facets).unwrap();
        assert!((shared.volume - 0.1).abs() < 1e-15);
        assert!((shared.centroid - Vec3::new(0.3, 0.2, -0.05)).norm() < 1e-14);
        assert!((shared.area - Vec3::z()).norm() < 1e-14);
        let diagonal = Quat::rotation_between(&Vec3::new(1.0, 1.0, 1.0), &-Vec3::z()).unwrap();
        let depth = 0.1;
        let corner = pose(&diagonal, Vec3::z() * (0.75f64.sqrt() - depth));
        let shared = cutter.below_plane(&cube, &corner, true, &mut facets).unwrap();
        // legs depth sqrt(3) long, at right angles
        let leg = depth * 3f64.sqrt();
        assert!((shared.volume - leg.powi(3) / 6.0).abs() < 1e-14, "{shared:?}");
        assert!((shared.centroid.z + 0.25 * depth).abs() < 1e-12, "{shared:?}");
    }
}
