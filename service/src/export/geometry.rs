//! Vectors, rotations, and polygons cut by half-spaces.

/// Components x, y, z.
pub type Vector = [f64; 3];

/// a + s b
pub fn add(a: Vector, s: f64, b: Vector) -> Vector {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// a - b
pub fn difference(a: Vector, b: Vector) -> Vector {
    add(a, -1.0, b)
}

/// a . b
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length.
pub fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// Of unit length; zero stays zero.
pub fn unit(a: Vector) -> Vector {
    let length = norm(a);
    if length > 0.0 { a.map(|component| component / length) } else { a }
}

/// Two unit vectors that make a right-handed frame with the unit vector `z`.
pub fn frame(z: Vector) -> [Vector; 2] {
    let least = (0..3).min_by(|&i, &j| z[i].abs().total_cmp(&z[j].abs())).unwrap_or(0);
    let mut aside = [0.0; 3];
    aside[least] = 1.0;
    let x = unit(cross(aside, z));
    [x, cross(z, x)]
}

/// Turns vectors by a unit quaternion (w, x, y, z).
#[derive(Clone, Copy, Debug)]
pub struct Rotation([Vector; 3]);

impl Rotation {
    /// As a matrix.
    pub fn new([w, x, y, z]: [f64; 4]) -> Self {
        Self([
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ])
    }

    /// The turned vector.
    pub fn of(&self, v: Vector) -> Vector {
        self.0.map(|row| dot(row, v))
    }
}

/// Axis-aligned box; empty at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub min: Vector,
    /// Upper corner.
    pub max: Vector,
}

impl Bounds {
    /// Of nothing.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// Takes in a ball.
    pub fn take(&mut self, centre: Vector, radius: f64) {
        self.min = std::array::from_fn(|axis| self.min[axis].min(centre[axis] - radius));
        self.max = std::array::from_fn(|axis| self.max[axis].max(centre[axis] + radius));
    }

    /// Whether nothing was taken in.
    pub fn is_empty(&self) -> bool {
        self.min[0] > self.max[0]
    }

    /// Its diagonal.
    pub fn diagonal(&self) -> f64 {
        if self.is_empty() { 0.0 } else { norm(difference(self.max, self.min)) }
    }

    /// Its centre.
    pub fn centre(&self) -> Vector {
        std::array::from_fn(|axis| 0.5 * (self.min[axis] + self.max[axis]))
    }

    /// Its six sides.
    pub fn half_spaces(&self) -> Vec<HalfSpace> {
        let side = |axis: usize, sign: f64, corner: Vector| {
            let mut normal = [0.0; 3];
            normal[axis] = sign;
            HalfSpace { point: corner, normal }
        };
        (0..3).flat_map(|axis| [side(axis, 1.0, self.min), side(axis, -1.0, self.max)]).collect()
    }
}

/// What lies on the side of a plane that its normal points to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// A point of the plane.
    pub point: Vector,
    /// Unit vector.
    pub normal: Vector,
}

impl HalfSpace {
    /// How far inside a point is.
    pub fn depth(&self, x: Vector) -> f64 {
        dot(difference(x, self.point), self.normal)
    }
}

/// The part of a convex polygon inside a half-space.
pub fn cut(polygon: &[Vector], by: &HalfSpace) -> Vec<Vector> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &to) in polygon.iter().enumerate() {
        let from = polygon[(k + polygon.len() - 1) % polygon.len()];
        let (depth_from, depth_to) = (by.depth(from), by.depth(to));
        if (depth_from < 0.0) != (depth_to < 0.0) {
            kept.push(add(from, depth_from / (depth_from - depth_to), difference(to, from)));
        }
        if depth_to >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_are_cut() {
        let square = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
        let half = cut(&square, &HalfSpace { point: [1.0, 0.0, 0.0], normal: [1.0, 0.0, 0.0] });
        let bounds = half.iter().fold(Bounds::EMPTY, |mut bounds, &x| {
            bounds.take(x, 0.0);
            bounds
        });
        assert_eq!((half.len(), bounds), (4, Bounds { min: [1.0, 0.0, 0.0], max: [2.0, 2.0, 0.0] }));
        assert!(cut(&square, &HalfSpace { point: [3.0, 0.0, 0.0], normal: [1.0, 0.0, 0.0] }).is_empty());
        assert!(cut(&[], &HalfSpace { point: [0.0; 3], normal: [1.0, 0.0, 0.0] }).is_empty());
    }

    #[test]
    fn rotations_turn_and_frames_are_right_handed() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turned = Rotation::new([half, 0.0, 0.0, half]).of([1.0, 0.0, 0.0]);
        assert!(norm(difference(turned, [0.0, 1.0, 0.0])) < 1e-15, "{turned:?}");
        for z in [[1.0, 0.0, 0.0], [0.0, 0.6, -0.8], unit([1.0, 1.0, 1.0])] {
            let [x, y] = frame(z);
            assert!(norm(difference(cross(x, y), z)) < 1e-15);
        }
    }
}
