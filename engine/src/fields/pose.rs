//! Where the frame of a grid is: its motion, and the axis of a cylinder.

use super::definition::{FieldDefinition, GridCylinder, GridMotion};
use super::sources::FieldSources;
use crate::boundary::Boundary;
use crate::math::{Mat3, Quat, Vec3};
use crate::scene::MotionDescription;
use crate::snapshot::BoundaryState;

/// A rigid frame: x = origin + rotation x_in_frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    pub origin: Vec3,
    pub rotation: Mat3,
}

impl Pose {
    const REST: Self =
        Self { origin: Vec3::new(0.0, 0.0, 0.0), rotation: Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0) };

    /// World from where the grid is given, now. At rest where the scene has no such boundary, which validation refuses.
    pub fn of_motion(definition: &FieldDefinition, sources: &FieldSources<'_>) -> Self {
        match &definition.motion {
            None => Self::REST,
            Some(GridMotion::Translation { velocity_m_per_s }) => {
                Self { origin: Vec3::from(*velocity_m_per_s) * sources.time_s, ..Self::REST }
            }
            Some(GridMotion::Boundary { name }) => sources.boundary(name).map_or(Self::REST, |(scene, now)| {
                let rotation = turn(scene, now);
                Self { origin: Vec3::from(now.point_m) - rotation * scene.point, rotation }
            }),
        }
    }

    /// World from the frame that the lattice is in.
    pub fn of_grid(motion: &Self, cylinder: Option<&GridCylinder>) -> Self {
        let Some(cylinder) = cylinder else { return *motion };
        let axis = Vec3::from(cylinder.axis).normalize();
        let zero = match cylinder.zero {
            Some(zero) => Vec3::from(zero),
            None if axis.x.abs() > 0.9 => Vec3::y(),
            None => Vec3::x(),
        };
        let x = (zero - axis * zero.dot(&axis)).normalize();
        let axes = Mat3::from_columns(&[x, axis.cross(&x), axis]);
        Self {
            origin: motion.origin + motion.rotation * Vec3::from(cylinder.point_m),
            rotation: motion.rotation * axes,
        }
    }

    pub fn in_frame(&self, x: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(x - self.origin))
    }

    pub fn in_world(&self, x: &Vec3) -> Vec3 {
        self.origin + self.rotation * x
    }

    pub fn orientation_wxyz(&self) -> [f64; 4] {
        let q = Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(self.rotation));
        [q.w, q.i, q.j, q.k]
    }
}

/// How far a boundary has turned. What turns in itself keeps its frame and counts its angle instead.
fn turn(scene: &Boundary, now: &BoundaryState) -> Mat3 {
    let [w, i, j, k] = now.orientation_wxyz;
    let frame = Quat::new_unchecked(nalgebra::Quaternion::new(w, i, j, k)).to_rotation_matrix().into_inner();
    let turned = frame * scene.rotation.transpose();
    let same = (turned - Mat3::identity()).norm() < 1e-12;
    let direction = Vec3::from(now.direction);
    match scene.description() {
        MotionDescription::Rotation { axis, .. } if same && now.angle_rad != 0.0 => {
            let axis = Vec3::from(*axis).normalize();
            if axis.cross(&direction).norm() < 1e-9 {
                nalgebra::Rotation3::from_scaled_axis(axis * now.angle_rad).into_inner()
            } else {
                turned
            }
        }
        // set in motion by a command: about its own direction
        _ if same && now.angle_rad != 0.0 => {
            nalgebra::Rotation3::from_scaled_axis(direction * now.angle_rad).into_inner()
        }
        _ if same => Mat3::identity(),
        _ => turned,
    }
}
