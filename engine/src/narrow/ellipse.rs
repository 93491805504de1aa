//! Points of an ellipse that are nearest to a point, or farthest from it, each in its own bracket.

use std::f64::consts::FRAC_PI_2;

/// Cosine and sine of an angle.
pub(super) type Direction = (f64, f64);

/// Of the local minima of the distance from (x, y) to (a cos, b sin), a >= b: the nearest point, and the second where
/// there is one, on the other side of the long axis.
///
/// In the quadrant of the point a |x| / cos - b |y| / sin - (a^2 - b^2) rises from below to above zero. In the quadrant
/// beyond the long axis the second term changes its sign, and there are two zeros, the larger one a minimum, inside the
/// evolute only.
pub(super) fn nearest([a, b]: [f64; 2], [x, y]: [f64; 2]) -> (Direction, Option<Direction>) {
    let (p, q, k) = (a * x.abs(), b * y.abs(), a * a - b * b);
    let signed = |(cos, sin): Direction, sense: f64| (cos * sign(x), sin * sense * sign(y));
    let first = signed(root(p, -q, k, 0.0), 1.0);
    (first, beyond(p, q, k).map(|direction| signed(direction, -1.0)))
}

/// Of the local maxima of the distance of centre + radius (e1 cos + e2 sin) from the origin, with centre . e1 = `along[0]`,
/// centre . e2 = `along[1]`, |e1| = 1 and `k` = radius (1 - |e2|^2): the farthest point, and the second where there is
/// one, on the other side of e2.
pub(super) fn farthest(along: [f64; 2], k: f64) -> (Direction, Option<Direction>) {
    let [p, q] = along.map(f64::abs);
    let [x, y] = along.map(sign);
    let (sin, cos) = root(q, -p, k, 0.0);
    ((cos * x, sin * y), beyond(q, p, k).map(|(sin, cos)| (-cos * x, sin * y)))
}

/// 1 where the two maxima of [`farthest`] are equally far, 0 where the second is about to vanish; for its share.
pub(super) fn second_share([x, y]: [f64; 2], k: f64) -> f64 {
    let two_thirds = |x: f64| x.cbrt().powi(2);
    let limit = (two_thirds(k) - two_thirds(y)).max(0.0).powf(1.5);
    if limit > 0.0 { (1.0 - x.abs() / limit).clamp(0.0, 1.0) } else { 0.0 }
}

fn sign(x: f64) -> f64 {
    1.0_f64.copysign(x)
}

/// The larger zero of p / cos + q / sin = k in the quadrant, if there are two.
fn beyond(p: f64, q: f64, k: f64) -> Option<Direction> {
    let two_thirds = |x: f64| x.cbrt().powi(2);
    (two_thirds(p) + two_thirds(q) < two_thirds(k)).then(|| root(p, q, k, q.cbrt().atan2(p.cbrt())))
}

/// The zero of p sin + q cos - k sin cos between `low`, where it is not above zero, and a right angle, where it is p >= 0:
/// Newton's method within a bracket, to the last bit.
fn root(p: f64, q: f64, k: f64, low: f64) -> Direction {
    let (mut low, mut high) = (low, FRAC_PI_2);
    let mut angle = 0.5 * (low + high);
    for _ in 0..80 {
        let (sin, cos) = angle.sin_cos();
        let value = p * sin + q * cos - k * sin * cos;
        if value <= 0.0 {
            low = angle
        } else {
            high = angle
        }
        if value == 0.0 {
            break;
        }
        let slope = p * cos - q * sin - k * (cos * cos - sin * sin);
        let newton = angle - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let step = (next - angle).abs();
        angle = next;
        // a step of rounding may go to and fro for ever
        if step <= 2.0 * f64::EPSILON * angle {
            break;
        }
    }
    let (sin, cos) = angle.sin_cos();
    (cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Local extrema of a function of an angle, by sampling and golden sections: (angle, value) of the maxima.
    fn maxima(f: impl Fn(f64) -> f64) -> Vec<f64> {
        let n = 4000;
        let step = std::f64::consts::TAU / f64::from(n);
        let mut found = Vec::new();
        for i in 0..n {
            let middle = f64::from(i) * step;
            let (before, at, after) = (f(middle - step), f(middle), f(middle + step));
            if at > before && at >= after {
                let (mut low, mut high) = (middle - step, middle + step);
                for _ in 0..100 {
                    let (x, y) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                    if f(x) < f(y) { low = x } else { high = y }
                }
                found.push(f(0.5 * (low + high)));
            }
        }
        found.sort_by(f64::total_cmp);
        found.reverse();
        found
    }

    fn numbers(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    }

    #[test]
    fn agree_with_sampling() {
        let mut seed = 7;
        let (mut seconds, mut cases) = ([0, 0], 0);
        while cases < 400 {
            let (b, x, y) = (numbers(&mut seed).abs(), numbers(&mut seed), 0.4 * numbers(&mut seed));
            let distance = |phi: f64| (phi.cos() - x).hypot(b * phi.sin() - y);
            let (first, second) = nearest([1.0, b], [x, y]);
            let at = |(cos, sin): Direction| (cos - x).hypot(b * sin - y);
            let near: Vec<f64> = maxima(|phi| -distance(phi)).iter().map(|d| -d).collect();
            assert!((at(first) - near[0]).abs() < 1e-9, "{b} {x} {y}: {} {}", at(first), near[0]);
            let k = 1.0 - b * b;
            let (far_first, far_second) = farthest([-x, -b * y], k);
            let far = maxima(distance);
            assert!((at(far_first) - far[0]).abs() < 1e-9, "{b} {x} {y}: {} {}", at(far_first), far[0]);
            // where two extrema are about to merge the samples see one or two
            if second.is_some() == (near.len() == 2) && far_second.is_some() == (far.len() == 2) {
                cases += 1;
                for (k, (second, sampled)) in [(second, near), (far_second, far)].into_iter().enumerate() {
                    let Some(second) = second else { continue };
                    seconds[k] += 1;
                    assert!((at(second) - sampled[1]).abs() < 1e-9, "{b} {x} {y}");
                }
            }
        }
        assert!(seconds.iter().all(|&n| n > 50), "{seconds:?}");
    }

    #[test]
    fn on_the_axes_and_at_the_centre() {
        assert_eq!(nearest([1.0, 1.0], [0.0, 0.0]).1, None);
        let close = |(cos, sin): Direction, (c, s): Direction| assert!((cos - c).hypot(sin - s) < 1e-12, "{cos} {sin}");
        close(nearest([2.0, 1.0], [0.0, 0.5]).0, (0.0, 1.0));
        let (up, down) = nearest([2.0, 1.0], [0.75, 0.0]);
        close(up, (0.5, 0.75_f64.sqrt()));
        close(down.unwrap(), (0.5, -(0.75_f64.sqrt())));
        close(nearest([2.0, 1.0], [1.6, 0.0]).0, (1.0, 0.0));
        let (right, left) = farthest([0.0, 0.25], 0.5);
        close(right, (0.75_f64.sqrt(), 0.5));
        close(left.unwrap(), (-(0.75_f64.sqrt()), 0.5));
        assert_eq!(second_share([0.0, 0.25], 0.5), 1.0);
        for direction in [nearest([1.0, 0.0], [0.0, 0.0]).0, farthest([0.0, 0.0], 0.0).0] {
            assert!((direction.0.hypot(direction.1) - 1.0).abs() < 1e-15);
        }
    }
}
