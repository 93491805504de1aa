//! Where random insertion places particles.

use crate::error::InvalidInput;
use crate::math::Vec3;
use crate::particles::NewParticle;
use crate::random::Draw;
use crate::scene::Region;

/// m3; positive and finite.
pub(super) fn region_volume(region: &Region, path: &str) -> Result<f64, InvalidInput> {
    let volume = match region {
        Region::Box { min_m, max_m } => (Vec3::from(*max_m) - Vec3::from(*min_m)).map(|l| l.max(0.0)).product(),
        Region::Cylinder { axis, radius_m, length_m, .. } if Vec3::from(*axis).norm() > 0.0 => {
            std::f64::consts::PI * radius_m * radius_m.abs() * length_m
        }
        Region::Cylinder { .. } => 0.0,
    };
    if volume.is_finite() && volume > 0.0 {
        Ok(volume)
    } else {
        Err(InvalidInput::new(path, format!("has volume {volume} m3; must be positive and finite")))
    }
}

/// Uniform in the region.
pub(super) fn draw_point(region: &Region, draw: &mut Draw) -> Vec3 {
    match region {
        Region::Box { min_m, max_m } => draw.in_box(&Vec3::from(*min_m), &Vec3::from(*max_m)),
        Region::Cylinder { point_m, axis, radius_m, length_m } => {
            let z = Vec3::from(*axis).normalize();
            let frame = nalgebra::Rotation3::rotation_between(&Vec3::z(), &z)
                .unwrap_or_else(|| nalgebra::Rotation3::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI));
            let (rho, angle) = (radius_m * draw.unit().sqrt(), std::f64::consts::TAU * draw.unit());
            let local = Vec3::new(rho * angle.cos(), rho * angle.sin(), length_m * draw.unit());
            Vec3::from(*point_m) + frame * local
        }
    }
}

/// Whether the bounding sphere lies in the region.
pub(super) fn is_inside(region: &Region, particle: &NewParticle) -> bool {
    let (x, r) = (particle.position, particle.radius);
    match region {
        Region::Box { min_m, max_m } => (0..3).all(|axis| x[axis] - r >= min_m[axis] && x[axis] + r <= max_m[axis]),
        Region::Cylinder { point_m, axis, radius_m, length_m } => {
            let d = x - Vec3::from(*point_m);
            let z = Vec3::from(*axis).normalize();
            let along = d.dot(&z);
            along - r >= 0.0 && along + r <= *length_m && (d - z * along).norm() + r <= *radius_m
        }
    }
}

/// Refuses a region that has no volume, or no room for a sphere of this radius.
pub(crate) fn check_room(region: &Region, radius: f64, path: &str) -> Result<(), InvalidInput> {
    region_volume(region, path)?;
    let width = match region {
        Region::Box { min_m, max_m } => (Vec3::from(*max_m) - Vec3::from(*min_m)).min(),
        Region::Cylinder { radius_m, length_m, .. } => length_m.min(2.0 * radius_m),
    };
    if width >= 2.0 * radius {
        return Ok(());
    }
    let problem =
        format!("is {width:e} m wide; the largest particle, which must lie inside, needs {:e} m", 2.0 * radius);
    Err(InvalidInput::new(path, problem))
}
