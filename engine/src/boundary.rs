//! Walls and drums with prescribed motion.

use std::sync::Arc;

use crate::checkpoint::codec::pack_fields;
use crate::math::{Mat3, Quat, Similarity, Vec3};
use crate::mesh::Mesh;
use crate::narrow::{self, Manifold};
use crate::scene::{AngularVelocity, BoundaryDescription, BoundaryGeometry, MotionDescription};
use crate::shape::Part;

/// Geometry in a wall frame, as the narrow phase wants it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallShape {
    /// Half-space z < 0.
    Plane,
    /// Outside of the cylinder of this radius about z.
    CylinderInside(f64),
    /// Inside of the cylinder of this radius about z.
    CylinderOutside(f64),
    /// Triangles, whose elements have slots of their own.
    Mesh,
}

impl WallShape {
    /// Appends the contacts of a part, in the frame of the wall.
    pub fn contacts(self, part: &Part, wall_from_body: &Similarity, out: &mut Manifold) {
        match self {
            WallShape::Plane => narrow::part_plane(part, wall_from_body, out),
            WallShape::CylinderInside(radius) => narrow::part_cylinder(part, wall_from_body, radius, out),
            WallShape::CylinderOutside(radius) => narrow::part_roller(part, wall_from_body, radius, out),
            WallShape::Mesh => debug_assert!(false, "a mesh is met element by element"),
        }
    }

    /// Whether polyhedra that have cores meet it, or its patches, by generalized overlap; else by points.
    pub fn has_overlap_terms(self) -> bool {
        !matches!(self, WallShape::CylinderOutside(_))
    }
}

/// A boundary of the running engine.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Name in the scene.
    pub name: String,
    /// Index of the material.
    pub material: u32,
    /// Geometry.
    pub shape: WallShape,
    /// Point of the plane or axis, or where the origin of a mesh's vertices is, now, m.
    pub point: Vec3,
    /// Wall frame now: the third column is the normal of the plane or the direction of the axis; of a mesh the frame of its
    /// vertices.
    pub rotation: Mat3,
    /// Angle turned since the start, rad.
    pub angle: f64,
    /// Velocity of the wall frame's points: v(x) = `velocity` + `angular_velocity` x (x - `pivot`).
    pub velocity: Vec3,
    /// World axes, rad/s.
    pub angular_velocity: Vec3,
    /// A point of the axis of rotation, m.
    pub pivot: Vec3,
    motion: Motion,
    mesh: Option<NumberedMesh>,
}

/// A mesh, and the number that its first element has in slots.
#[derive(Clone, Debug, PartialEq)]
struct NumberedMesh {
    mesh: Arc<Mesh>,
    first: u32,
}

/// What side b of a wall's slot is: boundaries by their index, then the elements of all meshes.
#[derive(Clone, Copy)]
pub struct WallSide<'a> {
    /// Index of the boundary.
    pub index: usize,
    /// The boundary.
    pub boundary: &'a Boundary,
    /// The mesh and which of its elements.
    pub element: Option<(&'a Mesh, u32)>,
}

impl<'a> WallSide<'a> {
    /// Of side b of a slot.
    #[inline]
    pub fn of(boundaries: &'a [Boundary], b: u32) -> Self {
        if let Some(boundary) = boundaries.get(b as usize) {
            return Self { index: b as usize, boundary, element: None };
        }
        Self::of_element(boundaries, b)
    }

    fn of_element(boundaries: &'a [Boundary], b: u32) -> Self {
        let holds = |numbered: &NumberedMesh| b >= numbered.first && b - numbered.first < numbered.mesh.n_elements();
        let found = boundaries.iter().enumerate().find_map(|(index, boundary)| {
            let numbered = boundary.mesh.as_ref().filter(|numbered| holds(numbered))?;
            Some(Self { index, boundary, element: Some((&*numbered.mesh, b - numbered.first)) })
        });
        found.expect("slots name boundaries and elements that are there")
    }
}

/// The motion from `start` on.
#[derive(Clone, Debug, PartialEq)]
struct Motion {
    start_time_s: f64,
    start_point: Vec3,
    start_rotation: Mat3,
    start_angle: f64,
    /// Angular velocity about the new axis when the motion was set.
    start_rate: f64,
    description: MotionDescription,
}

/// Where a boundary is and how it moves: what its scene does not say of it.
pub(crate) struct BoundaryMotion {
    point: Vec3,
    pub(crate) rotation: Mat3,
    angle: f64,
    velocity: Vec3,
    angular_velocity: Vec3,
    pivot: Vec3,
    motion: Motion,
}

pack_fields!(BoundaryMotion {
    point: Vec3,
    rotation: Mat3,
    angle: f64,
    velocity: Vec3,
    angular_velocity: Vec3,
    pivot: Vec3,
    motion: Motion,
});
pack_fields!(Motion {
    start_time_s: f64,
    start_point: Vec3,
    start_rotation: Mat3,
    start_angle: f64,
    start_rate: f64,
    description: MotionDescription,
});

impl BoundaryMotion {
    pub(crate) fn description(&self) -> &MotionDescription {
        &self.motion.description
    }

    /// The description apart.
    pub(crate) fn is_finite(&self) -> bool {
        let motion = &self.motion;
        let numbers = [self.angle, motion.start_time_s, motion.start_angle, motion.start_rate];
        let vectors = [&self.point, &self.velocity, &self.angular_velocity, &self.pivot, &motion.start_point];
        let frames = [&self.rotation, &motion.start_rotation];
        let all = numbers.iter().chain(vectors.into_iter().flatten()).chain(frames.into_iter().flatten());
        all.into_iter().all(|number| number.is_finite())
    }
}

/// Unit vector of an array that validation has shown not to be zero.
fn unit(v: &[f64; 3]) -> Vec3 {
    Vec3::from(*v).normalize()
}

/// A right-handed frame whose third axis is `z`.
pub(crate) fn frame_with_z(z: &Vec3) -> Mat3 {
    let smallest = z.iamin();
    let mut other = Vec3::zeros();
    other[smallest] = 1.0;
    let x = other.cross(z).normalize();
    let y = z.cross(&x);
    Mat3::from_columns(&[x, y, *z])
}

impl AngularVelocity {
    /// (angle, rate) after `t`, starting at `rate0`.
    fn at(&self, rate0: f64, t: f64) -> (f64, f64) {
        match *self {
            AngularVelocity::Constant { rad_per_s } => (rad_per_s * t, rad_per_s),
            AngularVelocity::Ramp { rad_per_s, duration_s } => {
                let ramp = t.min(duration_s);
                let slope = (rad_per_s - rate0) / duration_s;
                let angle = rate0 * ramp + 0.5 * slope * ramp * ramp + rad_per_s * (t - ramp);
                (angle, if t < duration_s { rate0 + slope * ramp } else { rad_per_s })
            }
            AngularVelocity::Oscillation { amplitude_rad_per_s, frequency_hz, phase_rad } => {
                let omega = std::f64::consts::TAU * frequency_hz;
                let (sine, cosine) = (omega * t + phase_rad).sin_cos();
                (amplitude_rad_per_s / omega * (phase_rad.cos() - cosine), amplitude_rad_per_s * sine)
            }
        }
    }

    /// Largest magnitude from now on.
    fn largest(&self, rate0: f64) -> f64 {
        match *self {
            AngularVelocity::Constant { rad_per_s } => rad_per_s.abs(),
            AngularVelocity::Ramp { rad_per_s, .. } => rad_per_s.abs().max(rate0.abs()),
            AngularVelocity::Oscillation { amplitude_rad_per_s, .. } => amplitude_rad_per_s.abs(),
        }
    }
}

/// (displacement, velocity) after `t` of a table of validated rows.
fn table_at(times_s: &[f64], displacements_m: &[[f64; 3]], t: f64) -> (Vec3, Vec3) {
    let next = times_s.partition_point(|&time| time <= t);
    let last = times_s.len() - 1;
    if next > last {
        return (Vec3::from(displacements_m[last]), Vec3::zeros());
    }
    let (from, to) = (Vec3::from(displacements_m[next - 1]), Vec3::from(displacements_m[next]));
    let velocity = (to - from) / (times_s[next] - times_s[next - 1]);
    (from + velocity * (t - times_s[next - 1]), velocity)
}

impl Boundary {
    /// From a validated description, at time 0.
    pub fn new(description: &BoundaryDescription, material: u32) -> Self {
        let (shape, point, direction) = match &description.geometry {
            BoundaryGeometry::Plane { point_m, normal } => (WallShape::Plane, point_m, normal),
            BoundaryGeometry::CylinderInside { point_m, axis, radius_m } => {
                (WallShape::CylinderInside(*radius_m), point_m, axis)
            }
            // its frame is the one that its vertices are given in
            BoundaryGeometry::Mesh { .. } => (WallShape::Mesh, &[0.0; 3], &[0.0, 0.0, 1.0]),
            BoundaryGeometry::Box { .. } | BoundaryGeometry::MeshFile { .. } => {
                unreachable!("validation puts planes in the place of boxes and refuses files that nobody has read")
            }
            BoundaryGeometry::CylinderOutside { point_m, axis, radius_m } => {
                (WallShape::CylinderOutside(*radius_m), point_m, axis)
            }
        };
        let is_mesh = shape == WallShape::Mesh;
        let rotation = if is_mesh { Mat3::identity() } else { frame_with_z(&unit(direction)) };
        let point = Vec3::from(*point);
        let motion = Motion {
            start_time_s: 0.0,
            start_point: point,
            start_rotation: rotation,
            start_angle: 0.0,
            start_rate: 0.0,
            description: MotionDescription::Fixed,
        };
        let mut boundary = Self {
            name: description.name.clone(),
            material,
            shape,
            point,
            rotation,
            angle: 0.0,
            velocity: Vec3::zeros(),
            angular_velocity: Vec3::zeros(),
            pivot: point,
            motion,
            mesh: None,
        };
        boundary.set_motion(description.motion.clone(), 0.0);
        boundary
    }

    /// Gives it the mesh it is made of; `first` is the number of the first element, that of the next mesh is returned.
    pub(crate) fn set_mesh(&mut self, mesh: Mesh, first: u32) -> u32 {
        let next = first + mesh.n_elements();
        self.mesh = Some(NumberedMesh { mesh: Arc::new(mesh), first });
        next
    }

    /// The mesh it is made of.
    pub fn mesh(&self) -> Option<&Mesh> {
        self.mesh.as_ref().map(|numbered| &*numbered.mesh)
    }

    /// The mesh with the number of its first element in slots.
    pub(crate) fn numbered_mesh(&self) -> Option<(&Mesh, u32)> {
        self.mesh.as_ref().map(|numbered| (&*numbered.mesh, numbered.first))
    }

    /// Whether a command for `name` means this boundary: by its name, or by that of its box.
    pub fn answers_to(&self, name: &str) -> bool {
        self.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    }

    /// Starts another motion at `time_s`, from the present pose; a ramp starts at the present angular velocity.
    pub fn set_motion(&mut self, description: MotionDescription, time_s: f64) {
        let start_rate = match &description {
            MotionDescription::Rotation { axis, .. } => self.angular_velocity.dot(&unit(axis)),
            _ => 0.0,
        };
        self.motion = Motion {
            start_time_s: time_s,
            start_point: self.point,
            start_rotation: self.rotation,
            start_angle: self.angle,
            start_rate,
            description,
        };
        if self.servo().is_some() {
            self.velocity = Vec3::zeros();
            self.angular_velocity = Vec3::zeros();
        }
        self.move_to(time_s);
    }

    /// Direction and target, N, if it moves by the force on it.
    fn servo(&self) -> Option<(Vec3, f64)> {
        let MotionDescription::Servo { direction, force_n, pressure_pa, area_m2, .. } = &self.motion.description else {
            return None;
        };
        let target = force_n.or_else(|| Some((*pressure_pa)? * (*area_m2)?)).unwrap_or(0.0);
        Some((unit(direction), target))
    }

    /// Whether it moves by the force on it.
    pub fn is_servo(&self) -> bool {
        matches!(self.motion.description, MotionDescription::Servo { .. })
    }

    /// Moves a servo over a step of `time_s`, by the force (N) of the particles on it at its start. Returns the work (J)
    /// on the particles that the trapezoidal rule misses because the velocity jumps: the force at the start of the step
    /// acts over it with the new velocity.
    pub(crate) fn drive(&mut self, force: &Vec3, time_s: f64) -> f64 {
        let Some((direction, target)) = self.servo() else { return 0.0 };
        let MotionDescription::Servo { gain_m_per_s_per_n: gain, max_velocity_m_per_s: most, .. } =
            self.motion.description
        else {
            return 0.0;
        };
        let before = self.velocity;
        self.velocity = direction * (gain * (target + force.dot(&direction))).clamp(-most, most);
        self.point += self.velocity * time_s;
        -0.5 * time_s * force.dot(&(self.velocity - before))
    }

    /// Puts the boundary where it is at `time_s`.
    pub fn move_to(&mut self, time_s: f64) {
        let motion = &self.motion;
        let t = time_s - motion.start_time_s;
        match &motion.description {
            MotionDescription::Fixed => {
                self.velocity = Vec3::zeros();
                self.angular_velocity = Vec3::zeros();
            }
            MotionDescription::Translation { velocity_m_per_s } => {
                let velocity = Vec3::from(*velocity_m_per_s);
                self.shift_to(velocity * t, velocity);
            }
            MotionDescription::Oscillation { amplitude_m, frequency_hz, phase_rad } => {
                let omega = std::f64::consts::TAU * frequency_hz;
                let (sine, cosine) = (omega * t + phase_rad).sin_cos();
                let amplitude = Vec3::from(*amplitude_m);
                self.shift_to(amplitude * (sine - phase_rad.sin()), amplitude * (omega * cosine));
            }
            MotionDescription::Table { times_s, displacements_m } => {
                let (displacement, velocity) = table_at(times_s, displacements_m, t.max(0.0));
                self.shift_to(displacement, velocity);
            }
            // moved by `drive`
            MotionDescription::Servo { .. } => self.pivot = self.point,
            MotionDescription::Rotation { point_m, axis, angular_velocity } => {
                let axis = unit(axis);
                let (angle, rate) = angular_velocity.at(motion.start_rate, t);
                let pivot = Vec3::from(*point_m);
                self.angle = motion.start_angle + angle;
                self.velocity = Vec3::zeros();
                self.angular_velocity = axis * rate;
                self.pivot = pivot;
                if !self.turns_in_itself(&pivot, &axis) {
                    let turn = nalgebra::Rotation3::from_scaled_axis(axis * angle).into_inner();
                    self.rotation = turn * self.motion.start_rotation;
                    self.point = pivot + turn * (self.motion.start_point - pivot);
                }
            }
        }
    }

    /// Moved by `displacement` since the start of the motion, without rotation.
    fn shift_to(&mut self, displacement: Vec3, velocity: Vec3) {
        self.velocity = velocity;
        self.angular_velocity = Vec3::zeros();
        self.point = self.motion.start_point + displacement;
        self.pivot = self.point;
    }

    /// Whether the rotation maps the surface onto itself, so that its pose need not change.
    fn turns_in_itself(&self, pivot: &Vec3, axis: &Vec3) -> bool {
        let direction = self.motion.start_rotation.column(2).into_owned();
        let parallel = direction.cross(axis).norm() < 1e-14;
        match self.shape {
            WallShape::Mesh => false,
            WallShape::Plane => parallel,
            WallShape::CylinderInside(radius) | WallShape::CylinderOutside(radius) => {
                parallel && (self.motion.start_point - pivot).cross(axis).norm() < 1e-14 * radius
            }
        }
    }

    /// Velocity of the surface at `x`, m/s.
    #[inline]
    pub fn surface_velocity(&self, x: &Vec3) -> Vec3 {
        self.velocity + self.angular_velocity.cross(&(x - self.pivot))
    }

    /// Bound on how fast the surface moves towards a point within `reach` of the pivot, m/s.
    pub fn largest_closing_speed(&self, reach: f64) -> f64 {
        match &self.motion.description {
            MotionDescription::Fixed => 0.0,
            MotionDescription::Servo { max_velocity_m_per_s, .. } => *max_velocity_m_per_s,
            MotionDescription::Translation { velocity_m_per_s } => Vec3::from(*velocity_m_per_s).norm(),
            MotionDescription::Oscillation { amplitude_m, frequency_hz, .. } => {
                Vec3::from(*amplitude_m).norm() * std::f64::consts::TAU * frequency_hz
            }
            MotionDescription::Table { times_s, displacements_m } => {
                times_s.iter().map(|&time| table_at(times_s, displacements_m, time).1.norm()).fold(0.0, f64::max)
            }
            MotionDescription::Rotation { point_m, axis, angular_velocity } => {
                if self.turns_in_itself(&Vec3::from(*point_m), &unit(axis)) {
                    0.0
                } else {
                    angular_velocity.largest(self.motion.start_rate) * reach
                }
            }
        }
    }

    /// Body frame of a particle into the wall frame.
    #[inline]
    pub fn wall_from_body(&self, position: &Vec3, rotation: &Mat3, scale: f64) -> Similarity {
        Similarity {
            rotation: self.rotation.tr_mul(rotation),
            translation: self.rotation.tr_mul(&(position - self.point)),
            scale,
        }
    }

    /// Distance of a point from the surface, positive on the particles' side; of a mesh unknown, minus infinity.
    #[inline]
    pub fn distance(&self, x: &Vec3) -> f64 {
        let local = self.rotation.tr_mul(&(x - self.point));
        match self.shape {
            WallShape::Plane => local.z,
            WallShape::Mesh => f64::NEG_INFINITY,
            WallShape::CylinderInside(radius) => radius - (local.x * local.x + local.y * local.y).sqrt(),
            WallShape::CylinderOutside(radius) => (local.x * local.x + local.y * local.y).sqrt() - radius,
        }
    }

    /// Present direction (normal or axis).
    pub fn direction(&self) -> Vec3 {
        self.rotation.column(2).into_owned()
    }

    /// Present rotation of the wall frame (w, x, y, z).
    pub fn orientation_wxyz(&self) -> [f64; 4] {
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(self.rotation);
        let q = Quat::from_rotation_matrix(&rotation);
        [q.w, q.i, q.j, q.k]
    }

    /// The motion under way.
    pub(crate) fn description(&self) -> &MotionDescription {
        &self.motion.description
    }

    /// For checkpoints.
    pub(crate) fn present_motion(&self) -> BoundaryMotion {
        BoundaryMotion {
            point: self.point,
            rotation: self.rotation,
            angle: self.angle,
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
            pivot: self.pivot,
            motion: self.motion.clone(),
        }
    }

    /// From a checkpoint.
    pub(crate) fn set_present_motion(&mut self, saved: BoundaryMotion) {
        self.point = saved.point;
        self.rotation = saved.rotation;
        self.angle = saved.angle;
        self.velocity = saved.velocity;
        self.angular_velocity = saved.angular_velocity;
        self.pivot = saved.pivot;
        self.motion = saved.motion;
    }

    /// Numbers that determine the boundary's future, for the state hash and checkpoints; the velocity of a servo's next
    /// step follows from its contacts.
    pub fn state_words(&self) -> [f64; 9] {
        let (p, w, v) = (self.point, self.angular_velocity, self.velocity);
        [p.x, p.y, p.z, self.angle, w.x, w.y, w.z, v.norm(), self.motion.start_time_s]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drum() -> Boundary {
        let description = BoundaryDescription {
            name: "drum".into(),
            material: "steel".into(),
            geometry: BoundaryGeometry::CylinderInside { point_m: [0.0; 3], axis: [0.0, 1.0, 0.0], radius_m: 0.05 },
            motion: MotionDescription::Fixed,
        };
        Boundary::new(&description, 0)
    }

    fn about_y(angular_velocity: AngularVelocity) -> MotionDescription {
        MotionDescription::Rotation { point_m: [0.0; 3], axis: [0.0, 1.0, 0.0], angular_velocity }
    }

    #[test]
    fn ramp_starts_at_the_present_rate_and_angles_add_up() {
        let mut drum = drum();
        drum.set_motion(about_y(AngularVelocity::Constant { rad_per_s: 2.0 }), 1.0);
        drum.move_to(2.0);
        assert!((drum.angle - 2.0).abs() < 1e-15);
        drum.set_motion(about_y(AngularVelocity::Ramp { rad_per_s: 6.0, duration_s: 2.0 }), 2.0);
        assert!((drum.angular_velocity.y - 2.0).abs() < 1e-15);
        drum.move_to(3.0);
        assert!((drum.angular_velocity.y - 4.0).abs() < 1e-15);
        drum.move_to(5.0);
        // 2 + mean 4 over the ramp of 2 s + 6 for 1 s more
        assert!((drum.angle - (2.0 + 8.0 + 6.0)).abs() < 1e-14);
    }

    #[test]
    fn oscillations_and_tables_start_where_the_boundary_is_and_move_at_their_velocity() {
        let mut drum = drum();
        let table = MotionDescription::Table {
            times_s: vec![0.0, 1.0, 3.0],
            displacements_m: vec![[0.0; 3], [0.0, 2.0, 0.0], [4.0, 2.0, 0.0]],
        };
        let wave = MotionDescription::Oscillation { amplitude_m: [0.1, 0.0, 0.2], frequency_hz: 0.7, phase_rad: 0.4 };
        let turn =
            about_y(AngularVelocity::Oscillation { amplitude_rad_per_s: 3.0, frequency_hz: 1.3, phase_rad: -0.3 });
        let mut start_s = 1.0;
        for motion in [table, wave, turn] {
            let before = (drum.point, drum.angle);
            drum.set_motion(motion, start_s);
            assert_eq!((drum.point, drum.angle), before);
            let largest = drum.largest_closing_speed(1.0);
            for k in 0..40 {
                let (time, h) = (start_s + 0.05 + 0.1 * f64::from(k), 1e-6);
                let at = |drum: &mut Boundary, time| {
                    drum.move_to(time);
                    (drum.point, drum.angle)
                };
                let ((x0, a0), (x1, a1)) = (at(&mut drum, time - h), at(&mut drum, time + h));
                drum.move_to(time);
                assert!(((x1 - x0) / (2.0 * h) - drum.surface_velocity(&drum.point)).norm() < 1e-7, "{time}");
                assert!(((a1 - a0) / (2.0 * h) - drum.angular_velocity.y).abs() < 1e-7, "{time}");
                assert!(drum.velocity.norm() <= largest * (1.0 + 1e-12));
            }
            start_s += 5.0;
        }
        drum.set_motion(MotionDescription::Fixed, start_s);
    }

    #[test]
    fn surface_speed_of_the_drum_is_omega_r() {
        let mut drum = drum();
        drum.set_motion(about_y(AngularVelocity::Constant { rad_per_s: 2.0 }), 0.0);
        let v = drum.surface_velocity(&Vec3::new(0.0, 0.3, -0.05));
        assert!((v - Vec3::new(-0.1, 0.0, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn plane_swings_about_a_pivot() {
        let description = BoundaryDescription {
            name: "floor".into(),
            material: "steel".into(),
            geometry: BoundaryGeometry::Plane { point_m: [1.0, 0.0, 0.0], normal: [0.0, 0.0, 2.0] },
            motion: about_y(AngularVelocity::Constant { rad_per_s: std::f64::consts::FRAC_PI_2 }),
        };
        let mut plane = Boundary::new(&description, 0);
        plane.move_to(1.0);
        assert!((plane.direction() - Vec3::x()).norm() < 1e-15);
        assert!((plane.point - Vec3::new(0.0, 0.0, -1.0)).norm() < 1e-15);
    }
}
