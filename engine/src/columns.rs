//! Names of what a snapshot and a contact network hold, one per column: what scene files and clients choose by.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Numbers with a name each, in the order in which "all" lists them.
macro_rules! columns {
    ($(#[$doc:meta])* $type:ident { $($(#[$of:meta])* $variant:ident = $name:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $type { $($(#[$of])* $variant,)* }

        impl $type {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// As on the wire and in scene files.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The columns of these names, what is always there first, each once; `"all"` stands for every one. `Err` is
            /// the index of a name that is none.
            pub fn select<S: AsRef<str>>(names: &[S]) -> Result<Vec<Self>, usize> {
                let mut named = Vec::with_capacity(names.len());
                for (at, name) in names.iter().map(AsRef::as_ref).enumerate() {
                    if name == "all" {
                        return Ok(Self::ALL.to_vec());
                    }
                    named.push(*Self::ALL.iter().find(|column| column.name() == name).ok_or(at)?);
                }
                Ok(Self::with_keys(&named))
            }

            /// These, what is always there first, each once.
            pub fn with_keys(columns: &[Self]) -> Vec<Self> {
                let mut selected = Self::KEYS.to_vec();
                for column in columns {
                    if !selected.contains(column) {
                        selected.push(*column);
                    }
                }
                selected
            }
        }
    };
}

columns!(
    /// A column of a [`Snapshot`](crate::Snapshot).
    ParticleColumn {
        /// Stable ids.
        Ids = "ids",
        /// Indices into the scene's shapes.
        Shapes = "shapes",
        /// Indices into the scene's materials.
        Materials = "materials",
        /// Sizes relative to the shape.
        Scales = "scales",
        /// Centres of mass, m.
        Positions = "positions",
        /// `world_from_body`.
        Orientations = "orientations",
        /// m/s.
        Velocities = "velocities",
        /// rad/s.
        AngularVelocities = "angular_velocities",
        /// Of contacts, N.
        Forces = "forces",
        /// Of contacts about the centre of mass, N m.
        Torques = "torques",
        /// 1 where the particle keeps its velocity whatever pushes, else 0.
        Frozen = "frozen",
    }
);

impl ParticleColumn {
    /// Always there.
    pub const KEYS: &[Self] = &[Self::Ids];

    /// Whether it is one of forces and torques, which nobody gets without asking.
    pub fn is_force(self) -> bool {
        matches!(self, Self::Forces | Self::Torques)
    }

    /// Where nothing is chosen: all but forces, torques and who is frozen.
    pub fn usual() -> Vec<Self> {
        Self::ALL.iter().copied().filter(|&column| !column.is_force() && column != Self::Frozen).collect()
    }
}

columns!(
    /// A column of a [`ContactNetwork`](crate::ContactNetwork).
    ContactColumn {
        /// Ids of both particles; the second is 2^64 - 1 at a boundary.
        Ids = "ids",
        /// Indices into the scene's boundaries; 2^32 - 1 between particles.
        Boundaries = "boundaries",
        /// Convex parts of both; of a mesh its element.
        Parts = "parts",
        /// Where, m.
        Points = "points",
        /// Unit vectors from the first to the second.
        Normals = "normals",
        /// m
        Overlaps = "overlaps",
        /// N
        NormalForces = "normal_forces",
        /// On the first, N.
        TangentialForces = "tangential_forces",
        /// On the first about the point, N m.
        Moments = "moments",
        /// Kinds of contact.
        Kinds = "kinds",
        /// Touching points.
        PointCounts = "point_counts",
    }
);

impl ContactColumn {
    /// Always there.
    pub const KEYS: &[Self] = &[Self::Ids, Self::Boundaries];

    /// Where nothing is chosen: all of them.
    pub fn usual() -> Vec<Self> {
        Self::ALL.to_vec()
    }
}

/// Of the floating-point columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FloatType {
    /// As the engine has them.
    #[default]
    F64,
    /// Half the bytes, rounded to nearest.
    F32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_scene_files() {
        for &column in ParticleColumn::ALL {
            assert_eq!(toml::Value::try_from(column).unwrap().as_str(), Some(column.name()));
        }
        for &column in ContactColumn::ALL {
            assert_eq!(toml::Value::try_from(column).unwrap().as_str(), Some(column.name()));
        }
    }

    #[test]
    fn keys_are_always_there_and_each_column_once() {
        use ParticleColumn::{Forces, Ids, Positions};
        assert_eq!(ParticleColumn::select(&["forces", "positions", "forces"]), Ok(vec![Ids, Forces, Positions]));
        assert_eq!(ParticleColumn::select::<&str>(&[]), Ok(vec![Ids]));
        assert_eq!(ParticleColumn::select(&["ids", "all"]), Ok(ParticleColumn::ALL.to_vec()));
        assert_eq!(ParticleColumn::select(&["ids", "colour"]), Err(1));
        assert_eq!(ParticleColumn::usual().len() + 3, ParticleColumn::ALL.len());
        let keys = [ContactColumn::Ids, ContactColumn::Boundaries];
        assert_eq!(ContactColumn::select(&["ids"]), Ok(keys.to_vec()));
    }
}
