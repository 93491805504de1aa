//! Vertices and faces of the named solids, exact to the rounding of their coordinates.

use crate::math::Vec3;

/// Vertices and face loops.
pub(crate) type Solid = (Vec<Vec3>, Vec<Vec<u32>>);

fn loops<const N: usize>(faces: &[[u32; N]]) -> Vec<Vec<u32>> {
    faces.iter().map(|f| f.to_vec()).collect()
}

/// Cuboid of the given full edge lengths; the bits of a vertex index are its signs.
pub(crate) fn cuboid(size: &Vec3) -> Solid {
    let half = size * 0.5;
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let vertices = (0..8).map(|i| Vec3::new(sign(i, 0) * half.x, sign(i, 1) * half.y, sign(i, 2) * half.z)).collect();
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    (vertices, loops(&faces))
}

/// Regular tetrahedron.
pub(crate) fn tetrahedron(edge: f64) -> Solid {
    let h = edge / 8.0_f64.sqrt();
    let vertices = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let vertices = vertices.iter().map(|v| Vec3::from(*v) * h).collect();
    (vertices, loops(&[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))
}

/// Regular octahedron.
pub(crate) fn octahedron(edge: f64) -> Solid {
    let h = edge / 2.0_f64.sqrt();
    let vertices = vec![
        Vec3::new(h, 0.0, 0.0),
        Vec3::new(-h, 0.0, 0.0),
        Vec3::new(0.0, h, 0.0),
        Vec3::new(0.0, -h, 0.0),
        Vec3::new(0.0, 0.0, h),
        Vec3::new(0.0, 0.0, -h),
    ];
    let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    (vertices, loops(&faces))
}

/// Pinacoid of length `l`, width `g`, height `h` and ridge length `ridge`.
pub(crate) fn pinacoid(l: f64, g: f64, h: f64, ridge: f64) -> Solid {
    let (l, g, h, r) = (l * 0.5, g * 0.5, h * 0.5, ridge * 0.5);
    let vertices = vec![
        Vec3::new(l, g, 0.0),
        Vec3::new(l, -g, 0.0),
        Vec3::new(-l, -g, 0.0),
        Vec3::new(-l, g, 0.0),
        Vec3::new(r, 0.0, h),
        Vec3::new(-r, 0.0, h),
        Vec3::new(r, 0.0, -h),
        Vec3::new(-r, 0.0, -h),
    ];
    let mut faces = loops(&[[0, 4, 5, 3], [1, 2, 5, 4], [0, 3, 7, 6], [1, 6, 7, 2]]);
    faces.extend(loops(&[[0, 1, 4], [2, 3, 5], [0, 6, 1], [2, 7, 3]]));
    (vertices, faces)
}
