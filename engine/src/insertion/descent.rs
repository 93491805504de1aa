//! Steepest descent of a sphere's centre over other spheres and planes: straight drops and arcs of circles, in closed form.
//!
//! The centre must keep out of a ball around every sphere and on one side of every plane ([`Obstacle`]). Where it touches
//! some of them, it moves along the projection of the downward direction onto the cone of directions that none of them
//! forbids: held by none it drops; by one it rolls in a vertical plane; by two it rolls around both, along the circle in
//! which their surfaces meet; by three it rests, unless one of them lets go. What ends an arc (another obstacle is met, one
//! of those touched lets go) is a zero of `k + a cos + b sin`.

use crate::math::Vec3;

/// Directions and rates below this are none: rounding of normals.
const FLAT: f64 = 1e-12;

/// What the centre must keep out of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Obstacle {
    /// A ball: another sphere, its radius added to that of the one that falls.
    Ball {
        /// m
        centre: Vec3,
        /// m
        reach: f64,
    },
    /// The half-space below `normal . x = offset`.
    Plane {
        /// Unit vector.
        normal: Vec3,
        /// m
        offset: f64,
    },
}

impl Obstacle {
    /// Distance of the centre from its surface, m; negative inside.
    pub fn gap(&self, x: &Vec3) -> f64 {
        match self {
            Self::Ball { centre, reach } => (x - centre).norm() - reach,
            Self::Plane { normal, offset } => normal.dot(x) - offset,
        }
    }

    /// Away from it.
    fn normal(&self, x: &Vec3) -> Vec3 {
        match self {
            Self::Ball { centre, .. } => (x - centre).normalize(),
            Self::Plane { normal, .. } => *normal,
        }
    }
}

/// A circle that the centre moves along, by angle: `hub + radius (cos u + sin v)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    hub: Vec3,
    u: Vec3,
    v: Vec3,
    radius: f64,
    /// Angle at which something it rolls on lets go, rad.
    pub end: f64,
}

/// What happens next.
#[derive(Clone, Copy, Debug)]
pub(super) enum Descent {
    /// Nothing holds it.
    Drop,
    /// It rolls on one or two of what it touches.
    Roll(Arc, [Obstacle; 2]),
    /// No direction leads down.
    Rest,
}

fn down() -> Vec3 {
    -Vec3::z()
}

impl Descent {
    /// Of a centre at `x` that touches these.
    pub fn of(x: &Vec3, touched: &[Obstacle]) -> Self {
        let normals: Vec<Vec3> = touched.iter().map(|obstacle| obstacle.normal(x)).collect();
        let allowed = |d: &Vec3| normals.iter().all(|normal| normal.dot(d) >= -FLAT);
        if allowed(&down()) {
            return Self::Drop;
        }
        for (k, normal) in normals.iter().enumerate() {
            let d = down() - normal * normal.dot(&down());
            if normal.z > 0.0 && allowed(&d) {
                return if d.norm() > FLAT { Self::on_one(x, &touched[k], &d) } else { Self::Rest };
            }
        }
        for (i, a) in normals.iter().enumerate() {
            for (j, b) in normals.iter().enumerate().skip(i + 1) {
                let axis = a.cross(b);
                let Some(along) = axis.try_normalize(FLAT) else { continue };
                let d = along * along.dot(&down());
                // both must push: multipliers of the projection
                let (share, fa, fb) = (a.dot(b), a.z, b.z);
                let push = [fa - share * fb, fb - share * fa];
                if push.iter().all(|&push| push >= -FLAT) && allowed(&d) {
                    return if d.norm() > FLAT { Self::on_two(x, [&touched[i], &touched[j]], &d) } else { Self::Rest };
                }
            }
        }
        Self::Rest
    }

    fn on_one(x: &Vec3, on: &Obstacle, d: &Vec3) -> Self {
        let Obstacle::Ball { centre, reach } = on else { return Self::Rest };
        let mut arc = Arc { hub: *centre, u: on.normal(x), v: d.normalize(), radius: *reach, end: 0.0 };
        // to where the surface is upright
        arc.end = arc.first_below(0.0, arc.u.z, arc.v.z).unwrap_or(0.0);
        Self::Roll(arc, [*on; 2])
    }

    fn on_two(x: &Vec3, on: [&Obstacle; 2], d: &Vec3) -> Self {
        let hub = match on {
            [Obstacle::Ball { centre: a, reach: ra }, Obstacle::Ball { centre: b, reach: rb }] => {
                let between = b - a;
                let distance2 = between.norm_squared();
                a + between * (0.5 * (distance2 + ra * ra - rb * rb) / distance2)
            }
            [ball @ Obstacle::Ball { centre, .. }, Obstacle::Plane { normal, offset }]
            | [Obstacle::Plane { normal, offset }, ball @ Obstacle::Ball { centre, .. }] => {
                debug_assert!(matches!(ball, Obstacle::Ball { .. }));
                centre - normal * (normal.dot(centre) - offset)
            }
            // two upright planes do not hold what drops, and a floor ends it
            [Obstacle::Plane { .. }, Obstacle::Plane { .. }] => return Self::Rest,
        };
        let v = d.normalize();
        let spoke = x - hub;
        let spoke = spoke - v * spoke.dot(&v);
        let mut arc = Arc { hub, u: spoke.normalize(), v, radius: spoke.norm(), end: 0.0 };
        let [a, b] = on.map(|obstacle| arc.normal_of(obstacle));
        // constant along the circle
        let share = on[0].normal(x).dot(&on[1].normal(x));
        let push = |own: &[Vec3; 3], other: &[Vec3; 3]| {
            let [k, c, s] = std::array::from_fn(|part| own[part].z - share * other[part].z);
            arc.first_below(k, c, s)
        };
        // the lowest point, should both push until there: -dz/d(angle) falls below 0
        let lowest = arc.first_below(0.0, -arc.v.z, arc.u.z);
        arc.end = [push(&a, &b), push(&b, &a), lowest].into_iter().flatten().fold(f64::INFINITY, f64::min);
        if arc.end.is_finite() { Self::Roll(arc, on.map(|obstacle| *obstacle)) } else { Self::Rest }
    }
}

impl Arc {
    /// Where the centre is at an angle.
    pub fn at(&self, angle: f64) -> Vec3 {
        self.hub + (self.u * angle.cos() + self.v * angle.sin()) * self.radius
    }

    /// How far apart two of its points may be, m.
    pub fn diameter(&self) -> f64 {
        2.0 * self.radius
    }

    /// Angle at which it meets an obstacle that it does not roll on; none within a turn.
    pub fn meets(&self, obstacle: &Obstacle) -> Option<f64> {
        match obstacle {
            Obstacle::Ball { centre, reach } => {
                let from = self.hub - centre;
                let k = from.norm_squared() + self.radius * self.radius - reach * reach;
                let twice = 2.0 * self.radius;
                self.first_below(k, twice * from.dot(&self.u), twice * from.dot(&self.v))
            }
            Obstacle::Plane { normal, offset } => {
                let k = normal.dot(&self.hub) - offset;
                self.first_below(k, self.radius * normal.dot(&self.u), self.radius * normal.dot(&self.v))
            }
        }
    }

    /// Normal of an obstacle along the arc, as (constant, factor of cos, factor of sin).
    fn normal_of(&self, obstacle: &Obstacle) -> [Vec3; 3] {
        match obstacle {
            Obstacle::Ball { centre, reach } => {
                let of = self.radius / reach;
                [(self.hub - centre) / *reach, self.u * of, self.v * of]
            }
            Obstacle::Plane { normal, .. } => [*normal, Vec3::zeros(), Vec3::zeros()],
        }
    }

    /// First angle in [0, 2 pi) at which `k + a cos + b sin` falls below 0.
    fn first_below(&self, k: f64, a: f64, b: f64) -> Option<f64> {
        let size = a.hypot(b);
        let cosine = k / size;
        // negative between middle - half and middle + half
        let (middle, half) = ((-b).atan2(-a), cosine.acos());
        let angle = (middle - half).rem_euclid(std::f64::consts::TAU);
        (cosine.abs() < 1.0).then_some(angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(centre: [f64; 3], reach: f64) -> Obstacle {
        Obstacle::Ball { centre: Vec3::from(centre), reach }
    }

    #[test]
    fn one_ball_is_rolled_down_to_its_equator() {
        let x = Vec3::new(0.6, 0.0, 0.8);
        let Descent::Roll(arc, _) = Descent::of(&x, &[ball([0.0; 3], 1.0)]) else { panic!("it rests") };
        assert!((arc.at(0.0) - x).norm() < 1e-15);
        assert!((arc.at(arc.end) - Vec3::x()).norm() < 1e-15);
        // met on the way: a ball of reach 1 at (2, 0, 0.4), by symmetry of the rhombus at half the distance or before
        let met = arc.meets(&ball([1.8, 0.0, 0.4], 1.0)).unwrap();
        assert!(met < arc.end && ball([1.8, 0.0, 0.4], 1.0).gap(&arc.at(met)).abs() < 1e-15);
    }

    /// Two equal balls side by side: around both, down to where the lower side lets go, by the closed form x.z = 0.
    #[test]
    fn two_balls_are_rolled_around() {
        let two = [ball([-0.5, 0.0, 0.0], 1.0), ball([0.5, 0.0, 0.0], 1.0)];
        let height = 0.75f64.sqrt();
        let (sin, cos) = 0.3f64.sin_cos();
        let x = Vec3::new(0.0, height * sin, height * cos);
        let Descent::Roll(arc, _) = Descent::of(&x, &two) else { panic!("it rests") };
        let end = arc.at(arc.end);
        assert!(two.iter().all(|ball| ball.gap(&end).abs() < 1e-15));
        assert!((end - Vec3::new(0.0, height, 0.0)).norm() < 1e-12, "{end}");
    }

    #[test]
    fn three_balls_hold_and_two_of_them_do_not() {
        let third = 2.0 * std::f64::consts::PI / 3.0;
        let centre = |k: f64| [0.6 * (k * third).cos(), 0.6 * (k * third).sin(), 0.0];
        let three = [0.0, 1.0, 2.0].map(|k| ball(centre(k), 1.0));
        let x = Vec3::new(0.0, 0.0, 0.8);
        assert!(three.iter().all(|ball| ball.gap(&x).abs() < 1e-15));
        assert!(matches!(Descent::of(&x, &three), Descent::Rest));
        assert!(matches!(Descent::of(&x, &three[..2]), Descent::Roll(..)));
        let floor = Obstacle::Plane { normal: Vec3::z(), offset: 0.8 };
        assert!(matches!(Descent::of(&x, &[floor]), Descent::Rest));
        assert!(matches!(Descent::of(&x, &[]), Descent::Drop));
        let wall = Obstacle::Plane { normal: Vec3::x(), offset: 0.0 };
        assert!(matches!(Descent::of(&x, &[wall]), Descent::Drop));
    }

    /// A ball beside a wall: along the circle in the wall, down to the height of the ball's centre.
    #[test]
    fn a_wall_guides() {
        let wall = Obstacle::Plane { normal: Vec3::x(), offset: 0.0 };
        let on = [ball([0.6, 0.0, 0.0], 1.0), wall];
        let x = Vec3::new(0.0, 0.8 * 0.2f64.sin(), 0.8 * 0.2f64.cos());
        let Descent::Roll(arc, _) = Descent::of(&x, &on) else { panic!("it rests") };
        assert!((arc.at(arc.end) - Vec3::new(0.0, 0.8, 0.0)).norm() < 1e-12);
    }
}
