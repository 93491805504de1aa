//! Coplanar triangles that hang together become one patch, or each of their edges would be a bump.

use super::build::MeshEdge;
use super::{FLAT, Patch, Side};
use crate::boundary::frame_with_z;
use crate::math::Vec3;

/// What [`find_patches`] finds.
pub(super) struct Patches {
    pub patches: Vec<Patch>,
    /// By triangle.
    pub patch_of: Vec<u32>,
    /// By triangle: its three sides in the plane of its patch, not yet known to be concave.
    pub sides: Vec<[Side; 3]>,
}

/// Twice the area, along the normal.
pub(super) fn area_vector(vertices: &[Vec3], triangle: &[u32; 3]) -> Vec3 {
    let [p, q, r] = triangle.map(|v| vertices[v as usize]);
    (q - p).cross(&(r - p))
}

/// Grows patches from the largest triangles on: each takes the neighbours that lie in its plane. A finely meshed curve
/// does not become one patch link by link: all members must be near one plane.
pub(super) fn find_patches(vertices: &[Vec3], triangles: &[[u32; 3]], edges: &[MeshEdge], size: f64) -> Patches {
    const NONE: u32 = u32::MAX;
    let areas: Vec<Vec3> = triangles.iter().map(|t| area_vector(vertices, t)).collect();
    let mut neighbours = vec![[NONE; 3]; triangles.len()];
    for edge in edges {
        if let [Some((a, side_a)), Some((b, side_b))] = edge.triangles {
            neighbours[a as usize][side_a as usize] = b;
            neighbours[b as usize][side_b as usize] = a;
        }
    }
    let mut seeds: Vec<u32> = (0..triangles.len() as u32).collect();
    seeds.sort_by(|&a, &b| areas[b as usize].norm().total_cmp(&areas[a as usize].norm()).then(a.cmp(&b)));
    let mut patch_of = vec![NONE; triangles.len()];
    let mut patches = Vec::new();
    for seed in seeds {
        if patch_of[seed as usize] != NONE {
            continue;
        }
        let patch = patches.len() as u32;
        let mut members = vec![seed];
        patch_of[seed as usize] = patch;
        // a small first triangle knows the plane badly: with the plane of all members, more may fit
        loop {
            let plane = plane_of(vertices, triangles, members.clone(), &areas);
            let lies_in_plane = |triangle: u32| {
                let flat = |v: &u32| plane.height(&vertices[*v as usize]).abs() <= FLAT * size;
                areas[triangle as usize].dot(&plane.normal()) > 0.0 && triangles[triangle as usize].iter().all(flat)
            };
            let before = members.len();
            let mut next = 0;
            while next < members.len() {
                for neighbour in neighbours[members[next] as usize] {
                    if neighbour != NONE && patch_of[neighbour as usize] == NONE && lies_in_plane(neighbour) {
                        patch_of[neighbour as usize] = patch;
                        members.push(neighbour);
                    }
                }
                next += 1;
            }
            if members.len() == before {
                break;
            }
        }
        members.sort_unstable();
        patches.push(plane_of(vertices, triangles, members, &areas));
    }
    let sides = triangles
        .iter()
        .zip(&patch_of)
        .map(|(triangle, &patch)| sides_of(vertices, triangle, &patches[patch as usize].normal()))
        .collect();
    Patches { patches, patch_of, sides }
}

/// The mean plane of the members.
fn plane_of(vertices: &[Vec3], triangles: &[[u32; 3]], members: Vec<u32>, areas: &[Vec3]) -> Patch {
    let normal = members.iter().map(|&t| areas[t as usize]).sum::<Vec3>().normalize();
    let first = vertices[triangles[members[0] as usize][0] as usize];
    let of_members = members.iter().flat_map(|&t| &triangles[t as usize]);
    // relative to the first, so that exactly planar patches keep an exact plane
    let height: f64 = of_members.map(|&v| normal.dot(&(vertices[v as usize] - first))).sum();
    // nearest to the origin: the same numbers as a plane given by that point
    let point = normal * (normal.dot(&first) + height / (3 * members.len()) as f64);
    Patch { rotation: frame_with_z(&normal), point, triangles: members, has_concave_side: false }
}

fn sides_of(vertices: &[Vec3], triangle: &[u32; 3], normal: &Vec3) -> [Side; 3] {
    [0, 1, 2].map(|k| {
        let (from, to) = (vertices[triangle[k] as usize], vertices[triangle[(k + 1) % 3] as usize]);
        let inwards = normal.cross(&(to - from)).normalize();
        Side { inwards, offset: inwards.dot(&from), is_concave: false }
    })
}
