//! Triangle meshes for scenes.
#![allow(dead_code)]

pub type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A boundary of material `w`.
pub fn mesh(name: &str, (vertices, triangles): &Triangles, motion: &str) -> String {
    format!(
        "[[boundary]]\nname = \"{name}\"\nmaterial = \"w\"\ngeometry = {{ kind = \"mesh\", vertices_m = {vertices:?}, triangles = {triangles:?} }}\n{motion}\n"
    )
}

/// A sheet over [x0, x1] x [y0, y1], facing up, of squares cut along changing diagonals, their vertices moved about in
/// the plane.
pub fn sheet(n: u32, [x0, x1, y0, y1]: [f64; 4], height: impl Fn(f64) -> f64) -> Triangles {
    let mut vertices = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let inner = i > 0 && i < n && j > 0 && j < n;
            let shake = |seed: u32| if inner { 0.3 * f64::from(seed).sin() } else { 0.0 };
            let y = y0 + (y1 - y0) * (f64::from(j) + shake(7 * i + 3 * j)) / f64::from(n);
            let x = x0 + (x1 - x0) * f64::from(i) / f64::from(n);
            vertices.push([x, y, height(x)]);
        }
    }
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    (vertices, triangles)
}

/// A closed box, facing outwards.
pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Triangles {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}
