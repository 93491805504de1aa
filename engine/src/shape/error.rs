//! Why a shape description was refused.

use thiserror::Error;

/// Why a shape description was refused; `path` leads to the value, relative to the description.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ShapeError {
    /// A length that is not a positive finite number.
    #[error("{path} is {value}: a length must be positive and finite")]
    NotPositive {
        /// Where.
        path: String,
        /// What was given.
        value: f64,
    },
    /// A coordinate that is NaN or infinite.
    #[error("{path} is {value}: coordinates must be finite")]
    NotFinite {
        /// Where.
        path: String,
        /// What was given.
        value: f64,
    },
    /// A spherocylinder whose total length is less than its two caps.
    #[error(
        "{path} is {total_length_m}: the total length includes both caps, so it must be at least 2 radius_m = {least}"
    )]
    TooShort {
        /// Where.
        path: String,
        /// What was given.
        total_length_m: f64,
        /// Twice the radius.
        least: f64,
    },
    /// A pinacoid whose ridge vanishes or inverts.
    #[error(
        "{path} is {height_m}: the ridge has length length_m - height_m / tan(alpha_deg), so it must be below length_m tan(alpha_deg) = {limit}"
    )]
    RidgeVanishes {
        /// Where.
        path: String,
        /// What was given.
        height_m: f64,
        /// Least upper bound of the height.
        limit: f64,
    },
    /// An angle outside its range.
    #[error("{path} is {value}: it must lie strictly between {low} and {high} degrees")]
    Angle {
        /// Where.
        path: String,
        /// What was given.
        value: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A cross whose beams are not longer than wide.
    #[error("{path} is {length_m}: beams must be longer than beam_width_m = {width_m}")]
    BeamTooShort {
        /// Where.
        path: String,
        /// Length of a beam.
        length_m: f64,
        /// Width of a beam.
        width_m: f64,
    },
    /// A quaternion that is not an orientation.
    #[error("{path} has norm {norm}: an orientation is a unit quaternion (w, x, y, z), to 1e-6")]
    Orientation {
        /// Where.
        path: String,
        /// Its norm.
        norm: f64,
    },
    /// Too few distinct vertices.
    #[error("{path} has {distinct} distinct points of {given}: a polyhedron needs at least 4")]
    TooFewPoints {
        /// Where.
        path: String,
        /// Number given.
        given: usize,
        /// Number after merging duplicates.
        distinct: usize,
    },
    /// All points on a line.
    #[error("{path} are collinear (off a line by {relative:e} of the size): a polyhedron needs a volume")]
    Collinear {
        /// Where.
        path: String,
        /// Largest distance from the line, over the size.
        relative: f64,
    },
    /// All points on a plane.
    #[error(
        "{path} are coplanar (off a plane by {relative:e} of the size, least {least:e}): a polyhedron needs a volume"
    )]
    Coplanar {
        /// Where.
        path: String,
        /// Largest distance from the plane, over the size.
        relative: f64,
        /// What is asked for.
        least: f64,
    },
    /// A volume too small for its size, or for floating point.
    #[error("{path} has volume {volume_m3:e} m^3 at size {size_m:e} m: too thin for reliable contacts")]
    Volume {
        /// Where.
        path: String,
        /// The volume.
        volume_m3: f64,
        /// The largest extent.
        size_m: f64,
    },
    /// The hull or its faces failed a check.
    #[error("{path}: no valid convex hull ({reason}): move or leave out nearly coincident or nearly coplanar points")]
    Hull {
        /// Where.
        path: String,
        /// Which check.
        reason: String,
    },
    /// More features than the narrow phase can name.
    #[error("{path} has {count} {what}: at most {most} are supported")]
    TooMany {
        /// Where.
        path: String,
        /// Of what.
        what: &'static str,
        /// How many.
        count: usize,
        /// The limit.
        most: usize,
    },
    /// A skeleton whose features do not fit together.
    #[error("{path}: {reason}")]
    Skeleton {
        /// Where.
        path: String,
        /// What does not fit.
        reason: String,
    },
    /// A body whose mass properties cannot be computed, or were given where they have no use.
    #[error("{path}: {reason}")]
    Mass {
        /// Where.
        path: String,
        /// What is missing or wrong.
        reason: String,
    },
    /// A composite without parts.
    #[error("{path} is empty: a composite needs at least one part")]
    NoParts {
        /// Where.
        path: String,
    },
    /// A file that nobody has read.
    #[error("{path} is '{file}': files are read together with a scene file only")]
    NotRead {
        /// Where.
        path: String,
        /// The file.
        file: String,
    },
    /// A part that is itself not convex.
    #[error("{path} is a {kind}: parts must be convex; list its parts instead")]
    PartNotConvex {
        /// Where.
        path: String,
        /// What it is.
        kind: &'static str,
    },
}
