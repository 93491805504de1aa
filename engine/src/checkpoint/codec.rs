//! Values as bytes and back: little-endian, in the order of their fields, every bit kept.

use crate::math::{Mat3, Quat, Vec3};
use crate::scene::{AngularVelocity, MotionDescription};

/// Bytes that are no such value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Malformed(pub &'static str);

/// What is left to read.
#[derive(Clone, Copy)]
pub(crate) struct Reader<'a>(pub &'a [u8]);

impl<'a> Reader<'a> {
    /// The next `n` bytes.
    pub fn take(&mut self, n: usize) -> Result<&'a [u8], Malformed> {
        let (taken, rest) = self.0.split_at_checked(n).ok_or(Malformed("ends early"))?;
        self.0 = rest;
        Ok(taken)
    }

    /// The next value.
    pub fn get<T: Pack>(&mut self) -> Result<T, Malformed> {
        T::get(self)
    }

    /// The last value: nothing may follow it.
    pub fn get_all<T: Pack>(mut self) -> Result<T, Malformed> {
        let value = self.get()?;
        if self.0.is_empty() { Ok(value) } else { Err(Malformed("has more bytes than it needs")) }
    }
}

/// One codec for checkpoints, and for whatever else moves state as bytes.
pub(crate) trait Pack: Sized {
    /// Fewest bytes that a value takes: what a count is checked against before anything is allocated for it.
    const LEAST_BYTES: usize;
    /// Appends the value.
    fn put(&self, out: &mut Vec<u8>);
    /// Reads a value.
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed>;
}

macro_rules! numbers {
    ($($type:ty),*) => {$(
        impl Pack for $type {
            const LEAST_BYTES: usize = size_of::<$type>();
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
            fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
                let mut bytes = [0; size_of::<$type>()];
                bytes.copy_from_slice(from.take(size_of::<$type>())?);
                Ok(<$type>::from_le_bytes(bytes))
            }
        }
    )*};
}

numbers!(u8, u16, u32, u64, i32, f64);

impl Pack for bool {
    const LEAST_BYTES: usize = 1;
    fn put(&self, out: &mut Vec<u8>) {
        u8::from(*self).put(out);
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        match from.get::<u8>()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(Malformed("has a choice that is neither yes nor no")),
        }
    }
}

/// A struct, field by field.
macro_rules! pack_fields {
    ($type:ty { $($field:ident: $of:ty),* $(,)? }) => {
        impl $crate::checkpoint::codec::Pack for $type {
            const LEAST_BYTES: usize = 0 $(+ <$of as $crate::checkpoint::codec::Pack>::LEAST_BYTES)*;
            fn put(&self, out: &mut Vec<u8>) {
                $(self.$field.put(out);)*
            }
            fn get(
                from: &mut $crate::checkpoint::codec::Reader<'_>,
            ) -> Result<Self, $crate::checkpoint::codec::Malformed> {
                $(let $field: $of = from.get()?;)*
                Ok(Self { $($field),* })
            }
        }
    };
}
pub(crate) use pack_fields;

impl<T: Pack, const N: usize> Pack for [T; N] {
    const LEAST_BYTES: usize = N * T::LEAST_BYTES;
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|value| value.put(out));
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        let values = (0..N).map(|_| from.get()).collect::<Result<Vec<T>, _>>()?;
        values.try_into().map_err(|_| Malformed("ends early"))
    }
}

impl Pack for Vec3 {
    const LEAST_BYTES: usize = 24;
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|value| value.put(out));
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        Ok(Self::new(from.get()?, from.get()?, from.get()?))
    }
}

impl Pack for Mat3 {
    const LEAST_BYTES: usize = 72;
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|value| value.put(out));
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        Ok(Self::from_columns(&[from.get()?, from.get()?, from.get()?]))
    }
}

/// As it is: normalising it anew would change its last bits.
impl Pack for Quat {
    const LEAST_BYTES: usize = 32;
    fn put(&self, out: &mut Vec<u8>) {
        self.coords.iter().for_each(|value| value.put(out));
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        let [i, j, k, w] = from.get()?;
        Ok(Self::new_unchecked(nalgebra::Quaternion::new(w, i, j, k)))
    }
}

impl<T: Pack> Pack for Option<T> {
    const LEAST_BYTES: usize = 1;
    fn put(&self, out: &mut Vec<u8>) {
        u8::from(self.is_some()).put(out);
        self.iter().for_each(|value| value.put(out));
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        match from.get::<u8>()? {
            0 => Ok(None),
            1 => from.get().map(Some),
            _ => Err(Malformed("has an optional value that is neither there nor not")),
        }
    }
}

impl<T: Pack> Pack for Vec<T> {
    const LEAST_BYTES: usize = 8;
    fn put(&self, out: &mut Vec<u8>) {
        (self.len() as u64).put(out);
        self.iter().for_each(|value| value.put(out));
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        let count = from.get::<u64>()?;
        if count > (from.0.len() / T::LEAST_BYTES.max(1)) as u64 {
            return Err(Malformed("counts more rows than it has"));
        }
        (0..count).map(|_| from.get()).collect()
    }
}

impl Pack for AngularVelocity {
    const LEAST_BYTES: usize = 1;
    fn put(&self, out: &mut Vec<u8>) {
        match *self {
            Self::Constant { rad_per_s } => {
                0u8.put(out);
                rad_per_s.put(out);
            }
            Self::Ramp { rad_per_s, duration_s } => {
                1u8.put(out);
                [rad_per_s, duration_s].put(out);
            }
            Self::Oscillation { amplitude_rad_per_s, frequency_hz, phase_rad } => {
                2u8.put(out);
                [amplitude_rad_per_s, frequency_hz, phase_rad].put(out);
            }
        }
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        Ok(match from.get::<u8>()? {
            0 => Self::Constant { rad_per_s: from.get()? },
            1 => Self::Ramp { rad_per_s: from.get()?, duration_s: from.get()? },
            2 => Self::Oscillation {
                amplitude_rad_per_s: from.get()?,
                frequency_hz: from.get()?,
                phase_rad: from.get()?,
            },
            _ => return Err(Malformed("has an angular velocity of unknown kind")),
        })
    }
}

impl Pack for MotionDescription {
    const LEAST_BYTES: usize = 1;
    fn put(&self, out: &mut Vec<u8>) {
        match self {
            Self::Fixed => 0u8.put(out),
            Self::Rotation { point_m, axis, angular_velocity } => {
                1u8.put(out);
                [*point_m, *axis].put(out);
                angular_velocity.put(out);
            }
            Self::Translation { velocity_m_per_s } => {
                2u8.put(out);
                velocity_m_per_s.put(out);
            }
            Self::Oscillation { amplitude_m, frequency_hz, phase_rad } => {
                3u8.put(out);
                amplitude_m.put(out);
                [*frequency_hz, *phase_rad].put(out);
            }
            Self::Servo { direction, force_n, pressure_pa, area_m2, gain_m_per_s_per_n, max_velocity_m_per_s } => {
                4u8.put(out);
                direction.put(out);
                [*force_n, *pressure_pa, *area_m2].put(out);
                [*gain_m_per_s_per_n, *max_velocity_m_per_s].put(out);
            }
            Self::Table { times_s, displacements_m } => {
                5u8.put(out);
                times_s.put(out);
                displacements_m.put(out);
            }
        }
    }
    fn get(from: &mut Reader<'_>) -> Result<Self, Malformed> {
        Ok(match from.get::<u8>()? {
            0 => Self::Fixed,
            1 => Self::Rotation { point_m: from.get()?, axis: from.get()?, angular_velocity: from.get()? },
            2 => Self::Translation { velocity_m_per_s: from.get()? },
            3 => Self::Oscillation { amplitude_m: from.get()?, frequency_hz: from.get()?, phase_rad: from.get()? },
            4 => Self::Servo {
                direction: from.get()?,
                force_n: from.get()?,
                pressure_pa: from.get()?,
                area_m2: from.get()?,
                gain_m_per_s_per_n: from.get()?,
                max_velocity_m_per_s: from.get()?,
            },
            5 => Self::Table { times_s: from.get()?, displacements_m: from.get()? },
            _ => return Err(Malformed("has a motion of unknown kind")),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn bytes<T: Pack>(value: &T) -> Vec<u8> {
        let mut out = Vec::new();
        value.put(&mut out);
        out
    }

    fn any_motion() -> impl Strategy<Value = MotionDescription> {
        let vector = || prop::array::uniform3(any::<f64>());
        let rate = prop_oneof![
            any::<f64>().prop_map(|rad_per_s| AngularVelocity::Constant { rad_per_s }),
            any::<[f64; 2]>().prop_map(|[rad_per_s, duration_s]| AngularVelocity::Ramp { rad_per_s, duration_s }),
            any::<[f64; 3]>().prop_map(|[amplitude_rad_per_s, frequency_hz, phase_rad]| {
                AngularVelocity::Oscillation { amplitude_rad_per_s, frequency_hz, phase_rad }
            }),
        ];
        prop_oneof![
            Just(MotionDescription::Fixed),
            (vector(), vector(), rate).prop_map(|(point_m, axis, angular_velocity)| MotionDescription::Rotation {
                point_m,
                axis,
                angular_velocity
            }),
            vector().prop_map(|velocity_m_per_s| MotionDescription::Translation { velocity_m_per_s }),
            (vector(), any::<[f64; 2]>()).prop_map(|(amplitude_m, [frequency_hz, phase_rad])| {
                MotionDescription::Oscillation { amplitude_m, frequency_hz, phase_rad }
            }),
            (vector(), any::<[Option<f64>; 3]>(), any::<[f64; 2]>()).prop_map(|(direction, target, [gain, most])| {
                let [force_n, pressure_pa, area_m2] = target;
                MotionDescription::Servo {
                    direction,
                    force_n,
                    pressure_pa,
                    area_m2,
                    gain_m_per_s_per_n: gain,
                    max_velocity_m_per_s: most,
                }
            }),
            prop::collection::vec((any::<f64>(), vector()), 0..5).prop_map(|rows| {
                let (times_s, displacements_m) = rows.into_iter().unzip();
                MotionDescription::Table { times_s, displacements_m }
            }),
        ]
    }

    proptest! {
        /// Read back it is the same, to the byte; cut anywhere it is refused; any bytes give a value or a refusal.
        #[test]
        fn motions_keep_every_bit(motion in any_motion(), cut in any::<prop::sample::Index>(), noise in any::<Vec<u8>>()) {
            let whole = bytes(&motion);
            let back: MotionDescription = Reader(&whole).get_all().unwrap();
            prop_assert_eq!(bytes(&back), whole.clone());
            let cut = cut.index(whole.len());
            prop_assert!(Reader(&whole[..cut]).get_all::<MotionDescription>().is_err());
            if let Ok(motion) = Reader(&noise).get_all::<MotionDescription>() {
                prop_assert_eq!(bytes(&motion), noise);
            }
        }
    }

    #[test]
    fn a_count_is_not_believed_before_the_rows_are_there() {
        let huge = bytes(&u64::MAX);
        assert_eq!(Reader(&huge).get_all::<Vec<Vec3>>(), Err(Malformed("counts more rows than it has")));
        let more = [bytes(&vec![1.0, 2.0]), vec![0]].concat();
        assert_eq!(Reader(&more).get_all::<Vec<f64>>(), Err(Malformed("has more bytes than it needs")));
    }

    #[test]
    fn quaternions_and_signed_zeros_keep_every_bit() {
        let q = Quat::new_unchecked(nalgebra::Quaternion::new(0.6, -0.0, 0.8 + f64::EPSILON, 0.0));
        let back: Quat = Reader(&bytes(&q)).get_all().unwrap();
        assert_eq!(back.coords.map(f64::to_bits), q.coords.map(f64::to_bits));
    }
}
