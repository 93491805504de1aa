//! Aliases of the nalgebra types that the engine uses, and the similarity transform of scaled particles.

pub(crate) mod parry;

/// Column vector of three f64.
pub type Vec3 = nalgebra::Vector3<f64>;
/// 3 x 3 matrix of f64.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// Unit quaternion; as an orientation it is `world_from_body`.
pub type Quat = nalgebra::UnitQuaternion<f64>;

/// Maps points of a frame `b` into a frame `a`: `x_a = rotation * (scale * x_b) + translation`.
///
/// The scale is the homothety of polydisperse particles: one shape serves every size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Proper rotation.
    pub rotation: Mat3,
    /// In the length unit of frame `a`.
    pub translation: Vec3,
    /// Length of a unit of frame `b` in frame `a`; positive.
    pub scale: f64,
}

impl Similarity {
    /// The identity.
    pub fn identity() -> Self {
        Self { rotation: Mat3::identity(), translation: Vec3::zeros(), scale: 1.0 }
    }

    /// Rotation and translation without scaling.
    pub fn rigid(rotation: Mat3, translation: Vec3) -> Self {
        Self { rotation, translation, scale: 1.0 }
    }

    /// Maps `a` into `b`.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        let scale = 1.0 / self.scale;
        Self { rotation, translation: rotation * self.translation * -scale, scale }
    }

    /// Image of a point.
    #[inline(always)]
    pub fn point(&self, x: &Vec3) -> Vec3 {
        self.rotation * (x * self.scale) + self.translation
    }

    /// Image of a direction (not scaled).
    #[inline(always)]
    pub fn direction(&self, d: &Vec3) -> Vec3 {
        self.rotation * d
    }

    /// A direction of `a` seen in `b`.
    #[inline(always)]
    pub fn inverse_direction(&self, d: &Vec3) -> Vec3 {
        self.rotation.tr_mul(d)
    }

    /// A point of `a` seen in `b`.
    #[inline(always)]
    pub fn inverse_point(&self, x: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(x - self.translation)) / self.scale
    }
}
