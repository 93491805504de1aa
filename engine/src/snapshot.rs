//! A copy of the state in the order of ids, for whoever lives outside the physics thread.

/// Columns in ascending order of id; row i of each belongs to `ids[i]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Steps done.
    pub step: u64,
    /// Simulated time.
    pub time_s: f64,
    /// Counts insertions and removals; ids are the same as long as it is.
    pub topology_epoch: u64,
    /// Acceleration of gravity, m/s2.
    pub gravity_m_per_s2: [f64; 3],
    /// Ids, ascending.
    pub ids: Vec<u64>,
    /// Index of the shape in the scene.
    pub shapes: Vec<u32>,
    /// Index of the material in the scene.
    pub materials: Vec<u32>,
    /// Homothety of the shape.
    pub scales: Vec<f64>,
    /// Centre of mass, m, wrapped into the periodic cell.
    pub positions: Vec<[f64; 3]>,
    /// Orientation `world_from_body` (w, x, y, z) of the body frame (centre of mass, principal axes).
    pub orientations: Vec<[f64; 4]>,
    /// Velocity of the centre of mass, m/s.
    pub velocities: Vec<[f64; 3]>,
    /// Angular velocity in world axes, rad/s.
    pub angular_velocities: Vec<[f64; 3]>,
    /// 1 where the particle is frozen, else 0; empty where none is.
    pub frozen: Vec<u32>,
    /// Sum of the contact forces, N, with local damping where the scene has it; without gravity and loads. Empty unless
    /// [`Engine::snapshot_forces`](crate::Engine::snapshot_forces) was called.
    pub forces: Vec<[f64; 3]>,
    /// Sum of the contact torques about the centre of mass in world axes, N m, with local damping; as `forces`.
    pub torques: Vec<[f64; 3]>,
    /// Pose of each boundary now, in the order of the scene.
    pub boundaries: Vec<BoundaryState>,
}

/// Where a boundary is, how it moves, and what acts on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoundaryState {
    /// Name in the scene.
    pub name: String,
    /// A point of the plane or of the cylinder's axis, or where the origin of a mesh is, now, m.
    pub point_m: [f64; 3],
    /// Normal of the plane or direction of the axis, now.
    pub direction: [f64; 3],
    /// Angle of rotation since the start, rad.
    pub angle_rad: f64,
    /// Angular velocity about the axis of its motion, rad/s.
    pub angular_velocity_rad_per_s: f64,
    /// Force of the particles on it, N.
    pub force_n: [f64; 3],
    /// Torque of the particles on it about `point_m`, N m.
    pub torque_n_m: [f64; 3],
    /// World from the frame of a mesh's vertices, now (w, x, y, z); of others a frame whose third axis is `direction`.
    pub orientation_wxyz: [f64; 4],
}
