//! Taking meshes apart, and finding their elements.

use super::{Mesh, MeshError};
use crate::math::Vec3;
use crate::narrow::closest_on_segment;

/// Numbers in [-1, 1), the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::from_fn(|_, _| self.next())
    }
}

fn cuboid([x, y, z]: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let vertices = (0..8).map(|k| [(k & 1) as f64 * x, (k >> 1 & 1) as f64 * y, (k >> 2) as f64 * z]).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (vertices, faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

/// A sheet of n x n squares over the unit square.
fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            vertices.push([x, y, height(x, y)]);
        }
    }
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    (vertices, triangles)
}

fn build(mesh: &(Vec<[f64; 3]>, Vec<[u32; 3]>)) -> Mesh {
    Mesh::build(&mesh.0, &mesh.1, false).expect("a good mesh")
}

#[test]
fn meshes_are_taken_apart_into_patches_edges_and_corners() {
    assert_eq!(build(&cuboid([1.0, 2.0, 3.0])).counts(), [6, 12, 8]);
    // one patch; the rim's four straight edges, each of ten pieces
    assert_eq!(build(&sheet(10, |_, _| 0.3)).counts(), [1, 4, 4]);
    assert_eq!(build(&sheet(10, |x, _| 1e-7 * (40.0 * x).sin())).counts(), [1, 4, 4]);
    // a roof: the ridge is an edge between two of its corners
    let roof = build(&sheet(10, |x, _| -(x - 0.5).abs()));
    assert_eq!(roof.counts(), [2, 7, 6]);
    // a valley: the two patches reach beyond it, and it carries nothing
    let valley = build(&sheet(10, |x, _| (x - 0.5).abs()));
    assert_eq!(valley.counts(), [2, 6, 6]);
    assert!(valley.patches.iter().all(|patch| patch.has_concave_side));
    // many slopes: every one a patch of its own
    assert_eq!(build(&sheet(10, |x, _| -x * x)).counts()[0], 10);
    // a blade of no thickness: front and back
    let blade = (vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2], [0, 2, 1]]);
    assert_eq!(build(&blade).counts(), [2, 3, 3]);
}

#[test]
fn bad_meshes_are_refused_with_the_place() {
    let (vertices, triangles) = cuboid([1.0; 3]);
    let error =
        |vertices: &[[f64; 3]], triangles: &[[u32; 3]]| Mesh::build(vertices, triangles, false).expect_err("bad");
    assert_eq!(error(&vertices, &[]), MeshError::Empty);
    let mut broken = vertices.clone();
    broken[5][1] = f64::NAN;
    assert_eq!(error(&broken, &triangles), MeshError::NonFinite { vertex: 5 });
    let no_such = MeshError::NoSuchVertex { triangle: 1, vertex: 9, vertices: 8 };
    assert_eq!(error(&vertices, &[[0, 1, 2], [0, 9, 2]]), no_such);
    assert_eq!(error(&vertices, &[[0, 1, 1]]), MeshError::Degenerate { triangle: 0 });
    let line = [[0.0; 3], [0.5, 0.5, 0.5], [1.0, 1.0, 1.0]];
    assert_eq!(error(&line, &[[0, 1, 2]]), MeshError::Degenerate { triangle: 0 });
    let mut flipped = triangles.clone();
    flipped[3].swap(0, 1);
    assert!(matches!(error(&vertices, &flipped), MeshError::InconsistentOrientation { second: 3, .. }));
    let fin = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    let expected = MeshError::NotASurface { from: 0, to: 1, first: 0, second: 1, third: 2 };
    assert_eq!(error(&vertices, &fin), expected);
    assert!(expected.to_string().contains("more than two triangles"));
}

#[test]
fn the_tree_finds_what_looking_at_everything_finds() {
    let mut random = Random(5);
    let waves = build(&sheet(24, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos()));
    let mut found = Vec::new();
    let mut total = 0;
    for mesh in [waves, build(&cuboid([1.0, 0.2, 0.5])), build(&sheet(40, |_, _| 0.0))] {
        for _ in 0..2000 {
            let x = random.vector() + Vec3::repeat(0.5);
            let reach = 0.3 * (random.next() + 1.0) * (random.next() + 1.0);
            mesh.near(&x, reach, 0.05, &mut found);
            assert_eq!(found, mesh.near_by_brute_force(&x, reach, 0.05));
            total += found.len();
        }
    }
    assert!(total > 10_000, "{total}");
}

#[test]
fn distances_to_triangles_are_those_of_dense_samples() {
    let mut random = Random(6);
    let mesh = build(&sheet(2, |x, y| 0.3 * x * y));
    for _ in 0..200 {
        let x = random.vector() + Vec3::repeat(0.5);
        for triangle in 0..mesh.triangles.len() {
            let [p, q, r] = mesh.triangles[triangle].map(|v| mesh.vertices[v as usize]);
            let rib = |k: i32| (p + (q - p) * (f64::from(k) / 400.0), r);
            let sampled = (0..=400).map(|k| (closest_on_segment(&x, &rib(k).0, &rib(k).1).0 - x).norm());
            let (sampled, distance) =
                (sampled.fold(f64::MAX, f64::min), mesh.distance2_to_triangle(triangle, &x).sqrt());
            assert!(distance <= sampled + 1e-12 && distance > sampled - 3e-3, "{distance} {sampled}");
        }
    }
}
