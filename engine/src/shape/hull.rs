//! Convex hull of raw points: parry gives the triangles, planes and polygons are made here.

use super::error::ShapeError;
use super::polyhedron::{Polyhedron, TopologyError, extent};
use crate::math::{Vec3, parry};
use std::collections::{BTreeMap, BTreeSet};

/// Points closer than this, over the size, are one point.
const DUPLICATE: f64 = 1e-9;
/// Triangles whose corners lie this close to a plane, over the size, are one face.
const COPLANAR: f64 = 1e-10;
/// Least thickness over the size: below it the tolerances of the narrow phase are no longer small against the shape.
const THINNEST: f64 = 1e-6;

/// The hull of `points`; errors name `path`.
pub(crate) fn convex_hull(points: &[Vec3], path: &str) -> Result<Polyhedron, ShapeError> {
    let hull_error = |reason: String| ShapeError::Hull { path: path.into(), reason };
    let size = extent(points);
    let distinct = without_duplicates(points, size * DUPLICATE);
    check_spread(&distinct, points.len(), path)?;
    let (low, high) = distinct.iter().fold((distinct[0], distinct[0]), |(l, h), p| (l.inf(p), h.sup(p)));
    let middle = (low + high) * 0.5;
    let unit: Vec<Vec3> = distinct.iter().map(|p| (p - middle) / size).collect();
    let triangles = parry::hull_triangles(&unit).map_err(hull_error)?;
    let loops = merge_coplanar(&unit, &triangles).map_err(hull_error)?;
    let (kept, loops) = drop_unused(distinct.len(), loops);
    let vertices: Vec<Vec3> = kept.iter().map(|&v| distinct[v as usize]).collect();
    let hull = Polyhedron::from_faces(vertices, loops).map_err(|e| topology_error(e, path))?;
    for f in hull.faces() {
        let out = distinct.iter().map(|p| f.normal.dot(p) - f.offset).fold(f64::MIN, f64::max);
        if out > 10.0 * COPLANAR * size {
            return Err(hull_error(format!("a point lies {:e} of the size outside a face", out / size)));
        }
    }
    Ok(hull)
}

/// A topology error at a place in the description.
pub(crate) fn topology_error(error: TopologyError, path: &str) -> ShapeError {
    match error {
        TopologyError::TooMany { what, count, most } => ShapeError::TooMany { path: path.into(), what, count, most },
        TopologyError::Invalid(reason) => ShapeError::Hull { path: path.into(), reason },
    }
}

fn without_duplicates(points: &[Vec3], tolerance: f64) -> Vec<Vec3> {
    // a grid of cells of the tolerance, so that 1e4 points do not need 1e8 comparisons
    let cell = |p: &Vec3| [p.x, p.y, p.z].map(|c| (c / tolerance.max(f64::MIN_POSITIVE)).floor() as i64);
    let mut grid: BTreeMap<[i64; 3], Vec<Vec3>> = BTreeMap::new();
    let mut kept = Vec::new();
    for p in points {
        let c = cell(p);
        let near = (0..27).any(|k| {
            let neighbour = [c[0].wrapping_add(k % 3 - 1), c[1].wrapping_add(k / 3 % 3 - 1), c[2].wrapping_add(k / 9 - 1)];
            grid.get(&neighbour).is_some_and(|others| others.iter().any(|q| (p - q).norm() <= tolerance))
        });
        if !near {
            grid.entry(c).or_default().push(*p);
            kept.push(*p);
        }
    }
    kept
}

fn check_spread(points: &[Vec3], given: usize, path: &str) -> Result<(), ShapeError> {
    let path = path.to_string();
    if points.len() < 4 {
        return Err(ShapeError::TooFewPoints { path, given, distinct: points.len() });
    }
    let farthest = |distance: &dyn Fn(&Vec3) -> f64| {
        points.iter().map(|p| (distance(p), *p)).fold((0.0, points[0]), |m, x| if x.0 > m.0 { x } else { m })
    };
    let origin = farthest(&|p| (p - points[0]).norm()).1;
    let (length, end) = farthest(&|p| (p - origin).norm());
    let along = (end - origin) / length;
    let (off_line, side) = farthest(&|p| (p - origin).cross(&along).norm());
    if off_line < THINNEST * length {
        return Err(ShapeError::Collinear { path, relative: off_line / length });
    }
    let normal = along.cross(&(side - origin)).normalize();
    let spread = points.iter().map(|p| normal.dot(&(p - origin)));
    let (low, high) = spread.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
    if high - low < THINNEST * length {
        return Err(ShapeError::Coplanar { path, relative: (high - low) / length, least: THINNEST });
    }
    Ok(())
}

/// Face loops from hull triangles: regions that lie in the plane of their largest triangle, bounded by one loop.
fn merge_coplanar(points: &[Vec3], triangles: &[[u32; 3]]) -> Result<Vec<Vec<u32>>, String> {
    let at = |v: u32| points[v as usize];
    let area = |t: &[u32; 3]| (at(t[1]) - at(t[0])).cross(&(at(t[2]) - at(t[0])));
    let mut across = BTreeMap::new();
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            if across.insert((t[k], t[(k + 1) % 3]), i).is_some() {
                return Err("two triangles share a directed edge".into());
            }
        }
    }
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&i, &j| area(&triangles[j]).norm().total_cmp(&area(&triangles[i]).norm()).then(i.cmp(&j)));
    let mut taken = vec![false; triangles.len()];
    let mut loops = Vec::new();
    for seed in order {
        if taken[seed] {
            continue;
        }
        let normal = area(&triangles[seed]).normalize();
        let offset = normal.dot(&at(triangles[seed][0]));
        let mut region = vec![seed];
        let mut boundary = BTreeMap::new();
        taken[seed] = true;
        while let Some(i) = region.pop() {
            let t = triangles[i];
            for k in 0..3 {
                let (from, to) = (t[k], t[(k + 1) % 3]);
                let other = *across.get(&(to, from)).ok_or("the hull is not closed")?;
                let flat = triangles[other].iter().all(|&v| (normal.dot(&at(v)) - offset).abs() <= COPLANAR);
                if !taken[other] && flat {
                    taken[other] = true;
                    region.push(other);
                }
                boundary.insert((from, to), ());
            }
        }
        loops.push(single_loop(boundary.into_keys().collect())?);
    }
    Ok(loops)
}

/// The outline of a region: directed edges whose reverse is not in the region, as one loop.
fn single_loop(directed: Vec<(u32, u32)>) -> Result<Vec<u32>, String> {
    let all: BTreeSet<(u32, u32)> = directed.iter().copied().collect();
    let mut next = BTreeMap::new();
    for (from, to) in directed {
        if !all.contains(&(to, from)) && next.insert(from, to).is_some() {
            return Err("a face touches itself".into());
        }
    }
    let start = *next.keys().next().ok_or("a face without outline")?;
    let mut polygon = vec![start];
    while let Some(&to) = next.get(polygon.last().unwrap_or(&start)) {
        if to == start {
            break;
        }
        polygon.push(to);
        if polygon.len() > next.len() {
            return Err("the outline of a face is not closed".into());
        }
    }
    if polygon.len() == next.len() { Ok(polygon) } else { Err("a face has several outlines".into()) }
}

/// Removes points of no face, and points on a straight edge between two faces; renumbers the loops.
fn drop_unused(count: usize, mut loops: Vec<Vec<u32>>) -> (Vec<u32>, Vec<Vec<u32>>) {
    let mut uses = vec![0; count];
    for v in loops.iter().flatten() {
        uses[*v as usize] += 1;
    }
    let kept: Vec<u32> = (0..count as u32).filter(|&v| uses[v as usize] > 2).collect();
    let mut renumbered = vec![0; count];
    for (new, &old) in kept.iter().enumerate() {
        renumbered[old as usize] = new as u32;
    }
    for polygon in &mut loops {
        polygon.retain(|&v| uses[v as usize] > 2);
        for v in polygon {
            *v = renumbered[*v as usize];
        }
    }
    (kept, loops)
}
