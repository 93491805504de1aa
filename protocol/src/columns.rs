//! Columns of numbers as raw bytes: little-endian, row-major.

use thiserror::Error;

use crate::v1::{Column, DataType};

/// A column that is not what its reader needs.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ColumnError {
    /// Another type of number.
    #[error("has dtype {got}, needs {needed}")]
    WrongType {
        /// As sent.
        got: &'static str,
        /// As needed.
        needed: &'static str,
    },
    /// Another number of components.
    #[error("has {got} components per row, needs {needed}")]
    WrongComponents {
        /// As sent.
        got: u32,
        /// As needed.
        needed: u32,
    },
    /// Bytes that are no whole number of rows.
    #[error("has {bytes} bytes, no multiple of the {row_bytes} of a row")]
    WrongLength {
        /// As sent.
        bytes: usize,
        /// Bytes of a row.
        row_bytes: usize,
    },
}

/// A number that columns may hold.
pub trait Number: Copy {
    /// Its type on the wire.
    const DTYPE: DataType;
    /// Its bytes.
    const BYTES: usize;
    /// Writes its bytes into exactly [`Number::BYTES`] of them.
    fn put(self, out: &mut [u8]);
    /// From exactly [`Number::BYTES`] bytes.
    fn get(bytes: &[u8]) -> Self;
}

macro_rules! number {
    ($type:ty, $dtype:expr) => {
        impl Number for $type {
            const DTYPE: DataType = $dtype;
            const BYTES: usize = size_of::<$type>();
            #[inline]
            fn put(self, out: &mut [u8]) {
                out.copy_from_slice(&self.to_le_bytes());
            }
            #[inline]
            fn get(bytes: &[u8]) -> Self {
                let mut raw = [0; size_of::<$type>()];
                raw.copy_from_slice(bytes);
                <$type>::from_le_bytes(raw)
            }
        }
    };
}

number!(f64, DataType::F64);
number!(f32, DataType::F32);
number!(u64, DataType::U64);
number!(u32, DataType::U32);

/// A column of rows of `C` numbers.
pub fn rows<T: Number, const C: usize>(name: &str, unit: &str, rows: &[[T; C]]) -> Column {
    flat(name, unit, C, rows.as_flattened())
}

/// A column of `components` numbers per row.
pub fn flat<T: Number>(name: &str, unit: &str, components: usize, numbers: &[T]) -> Column {
    let mut data = vec![0; numbers.len() * T::BYTES];
    // Of known lengths: the compiler makes one copy of it.
    data.chunks_exact_mut(T::BYTES).zip(numbers).for_each(|(bytes, number)| number.put(bytes));
    let (dtype, components, data) = (T::DTYPE.into(), components as u32, data.into());
    Column { name: name.into(), dtype, components, data, unit: unit.into() }
}

/// Numbers of a column of `C` components per row, proved to be such a column.
pub fn read<T: Number, const C: usize>(column: &Column) -> Result<Vec<[T; C]>, ColumnError> {
    if column.dtype != T::DTYPE as i32 {
        return Err(ColumnError::WrongType { got: type_name(column.dtype), needed: T::DTYPE.as_str_name() });
    }
    if column.components != C as u32 {
        return Err(ColumnError::WrongComponents { got: column.components, needed: C as u32 });
    }
    let row_bytes = C * T::BYTES;
    if !column.data.len().is_multiple_of(row_bytes) {
        return Err(ColumnError::WrongLength { bytes: column.data.len(), row_bytes });
    }
    let row = |bytes: &[u8]| std::array::from_fn(|c| T::get(&bytes[c * T::BYTES..(c + 1) * T::BYTES]));
    Ok(column.data.chunks_exact(row_bytes).map(row).collect())
}

/// The same for floats of either width, f32 widened: what a client reads, whichever it asked for.
pub fn read_floats<const C: usize>(column: &Column) -> Result<Vec<[f64; C]>, ColumnError> {
    if column.dtype == f32::DTYPE as i32 {
        Ok(read::<f32, C>(column)?.into_iter().map(|row| row.map(f64::from)).collect())
    } else {
        read(column)
    }
}

fn type_name(dtype: i32) -> &'static str {
    DataType::try_from(dtype).map_or("unknown", |known| known.as_str_name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn columns_keep_every_bit(numbers in prop::collection::vec(any::<[u64; 3]>(), 0..50)) {
            let floats: Vec<[f64; 3]> = numbers.iter().map(|row| row.map(f64::from_bits)).collect();
            let back: Vec<[f64; 3]> = read(&rows("x", "m", &floats)).unwrap();
            let bits: Vec<[u64; 3]> = back.iter().map(|row| row.map(f64::to_bits)).collect();
            prop_assert_eq!(bits, numbers);
        }
    }

    #[test]
    fn floats_are_read_whatever_their_width() {
        let (narrow, wide) = (rows("x", "m", &[[1.5_f32, 0.1]]), rows("x", "m", &[[1.5_f64, 0.1]]));
        assert_eq!(read_floats::<2>(&narrow), Ok(vec![[1.5, f64::from(0.1_f32)]]));
        assert_eq!(read_floats::<2>(&wide), Ok(vec![[1.5, 0.1]]));
        assert!(matches!(read_floats::<3>(&narrow), Err(ColumnError::WrongComponents { .. })));
        let ids = flat("ids", "", 1, &[1_u64]);
        assert!(matches!(read_floats::<1>(&ids), Err(ColumnError::WrongType { .. })));
    }

    #[test]
    fn columns_of_another_kind_are_refused() {
        let mut column = rows("x", "m", &[[1.0_f64, 2.0, 3.0]]);
        assert_eq!(read::<f64, 4>(&column), Err(ColumnError::WrongComponents { got: 3, needed: 4 }));
        assert!(matches!(read::<f32, 3>(&column), Err(ColumnError::WrongType { .. })));
        column.data.truncate(23);
        assert_eq!(read::<f64, 3>(&column), Err(ColumnError::WrongLength { bytes: 23, row_bytes: 24 }));
        column.dtype = 77;
        assert!(matches!(read::<f64, 3>(&column), Err(ColumnError::WrongType { got: "unknown", .. })));
    }
}
