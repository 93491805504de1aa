//! Brute force for polyhedra: every face normal and every cross product of two edges, both senses, no pruning.

use super::*;

/// Largest separation over all axes, its direction from `a` to `b`, and by how much it beats every other direction.
pub(crate) struct Answer {
    pub separation: f64,
    pub normal: Vec3,
    pub lead: f64,
}

pub(crate) fn vertices_in_a(p: &Polyhedron, to_a: &Similarity) -> Vec<Vec3> {
    p.vertices().iter().map(|v| to_a.rotation * v * to_a.scale + to_a.translation).collect()
}

/// From corner points alone: planes are rebuilt from the loops.
pub(crate) fn brute_force(a: &Polyhedron, b: &Polyhedron, b_to_a: &Similarity) -> Answer {
    let (va, vb) = (vertices_in_a(a, &Similarity::identity()), vertices_in_a(b, b_to_a));
    let mut axes = Vec::new();
    for (p, v) in [(a, &va), (b, &vb)] {
        for f in 0..p.faces().len() {
            let at = |k: usize| v[p.face_vertices(f)[k] as usize];
            let normal =
                (2..p.face_vertices(f).len()).map(|k| (at(k - 1) - at(0)).cross(&(at(k) - at(0)))).sum::<Vec3>();
            axes.push(normal.normalize());
        }
    }
    let edge = |p: &Polyhedron, v: &[Vec3], i: usize| {
        let e = p.edges()[i].vertices;
        (v[e[1] as usize] - v[e[0] as usize]).normalize()
    };
    for i in 0..a.edges().len() {
        for j in 0..b.edges().len() {
            let cross = edge(a, &va, i).cross(&edge(b, &vb, j));
            if cross.norm() > 1e-15 {
                axes.push(cross.normalize());
            }
        }
    }
    let mut found: Vec<(f64, Vec3)> = Vec::new();
    for n in axes {
        for n in [n, -n] {
            let top = va.iter().map(|x| n.dot(x)).fold(f64::MIN, f64::max);
            let bottom = vb.iter().map(|x| n.dot(x)).fold(f64::MAX, f64::min);
            found.push((bottom - top, n));
        }
    }
    let (separation, normal) =
        found.iter().copied().fold((f64::MIN, Vec3::zeros()), |m, x| if x.0 > m.0 { x } else { m });
    let others = found.iter().filter(|x| (x.1 - normal).norm() > 1e-6).map(|x| x.0);
    Answer { separation, normal, lead: separation - others.fold(f64::MIN, f64::max) }
}

/// Checks one pose of two polyhedra against brute force; `true` if they touch.
///
/// Tolerance 4e-12 of the size of the pair: faces may be preferred by 1e-12, the rest is rounding of the supports
/// (1e-15 of the size each) and of the planes of slivers 1:100.
pub(crate) fn check_pair(a: &Part, b: &Part, b_to_a: &Similarity, label: &str) -> bool {
    let answer = brute_force(solid(a), solid(b), b_to_a);
    let size = a.radius + b.radius * b_to_a.scale;
    let tolerance = 4e-12 * size;
    let manifold = contacts(a, b, b_to_a);
    if answer.separation.abs() <= tolerance {
        return false;
    }
    let touching = answer.separation < 0.0;
    assert_eq!(!manifold.is_empty(), touching, "{label}: separation {:e}", answer.separation / size);
    if !touching {
        return false;
    }
    let found = depth(&manifold);
    assert!((found + answer.separation).abs() <= tolerance, "{label}: depth {found:e}, not {:e}", -answer.separation);
    for p in manifold.points() {
        assert!((p.normal.norm() - 1.0).abs() < 1e-12, "{label}: normal {}", p.normal);
        assert!(p.share > 0.0 && p.share.is_finite() && p.overlap > 0.0, "{label}");
        assert_eq!(p.normal, manifold.points()[0].normal, "{label}");
        let outside = crate::narrow::farthest_face(solid(a), &p.position).1;
        assert!(outside <= found + tolerance, "{label}: a point {outside:e} outside a");
        let in_b = b_to_a.inverse_point(&p.position);
        let outside = crate::narrow::farthest_face(solid(b), &in_b).1 * b_to_a.scale;
        assert!(outside <= found + tolerance, "{label}: a point {outside:e} outside b");
    }
    if answer.lead > 10.0 * tolerance {
        // nearly parallel edges: the cross product has a relative error of rounding over |sin|, hence 1e-6
        let off = (manifold.points()[0].normal - answer.normal).norm();
        assert!(off < 1e-6, "{label}: normal off by {off:e}");
    }
    check_keys(&manifold, label);
    check_swapped(a, b, b_to_a, &manifold, tolerance, label);
    true
}

pub fn check_keys(manifold: &Manifold, label: &str) {
    let mut keys: Vec<u32> = manifold.points().iter().map(|p| p.feature.0).collect();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), manifold.len(), "{label}: a key twice");
}

/// Swapping the parts: the same depth; and opposite normals wherever the axis is unique.
fn check_swapped(a: &Part, b: &Part, b_to_a: &Similarity, direct: &Manifold, tolerance: f64, label: &str) {
    let mut swapped = contacts(b, a, &b_to_a.inverse());
    swapped.map_from(0, b_to_a);
    swapped.flip_from(0);
    assert!((depth(direct) - depth(&swapped)).abs() <= 2.0 * tolerance, "{label}: swapped depth");
}
