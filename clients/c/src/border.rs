//! Pointers and lengths of the caller, checked as far as they can be.

use std::ffi::{CStr, c_char};
use std::time::Duration;

use crate::code::sturz_code;
use crate::failure::Failure;

/// What a pointer points to, for the length of a call.
///
/// # Safety
/// Null, or to a sound value that nobody else writes meanwhile.
pub(crate) unsafe fn shared<'a, T>(path: &str, pointer: *const T) -> Result<&'a T, Failure> {
    check_there(path, pointer)?;
    // SAFETY: neither null nor misaligned; the rest is the caller's word.
    Ok(unsafe { &*pointer })
}

/// The same to write to.
///
/// # Safety
/// Null, or to a sound value that nobody else touches meanwhile.
pub(crate) unsafe fn exclusive<'a, T>(path: &str, pointer: *mut T) -> Result<&'a mut T, Failure> {
    check_there(path, pointer)?;
    // SAFETY: neither null nor misaligned; the rest is the caller's word.
    Ok(unsafe { &mut *pointer })
}

/// The same, and `None` for null.
///
/// # Safety
/// Null, or to a sound value that nobody else touches meanwhile.
pub(crate) unsafe fn optional<'a, T>(path: &str, pointer: *mut T) -> Result<Option<&'a mut T>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's word.
    unsafe { exclusive(path, pointer) }.map(Some)
}

fn check_there<T>(path: &str, pointer: *const T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::argument(path, "is null"));
    }
    check_aligned(path, pointer)
}

/// An array of the caller starts where numbers of its type may start.
pub(crate) fn check_aligned<T>(path: &str, pointer: *const T) -> Result<(), Failure> {
    if pointer.is_aligned() {
        return Ok(());
    }
    Err(Failure::argument(path, &format!("is not aligned to {} bytes", align_of::<T>())))
}

/// A text.
///
/// # Safety
/// Null, or ends in a zero.
pub(crate) unsafe fn text<'a>(path: &str, pointer: *const c_char) -> Result<&'a str, Failure> {
    check_there(path, pointer)?;
    // SAFETY: not null, and ends by the caller's word.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| Failure::argument(path, "is not UTF-8"))
}

/// A text that says something.
///
/// # Safety
/// Null, or ends in a zero.
pub(crate) unsafe fn name<'a>(path: &str, pointer: *const c_char) -> Result<&'a str, Failure> {
    // SAFETY: the caller's word.
    match unsafe { text(path, pointer) }? {
        "" => Err(Failure::argument(path, "is empty")),
        name => Ok(name),
    }
}

/// An array of `count` numbers of the caller; empty for null, which stands for a column that is not there.
///
/// # Safety
/// Null, or that many numbers which nobody writes meanwhile.
pub(crate) unsafe fn column<T: Copy>(path: &str, pointer: *const T, count: u64) -> Result<Vec<T>, Failure> {
    if pointer.is_null() || count == 0 {
        return Ok(Vec::new());
    }
    check_aligned(path, pointer)?;
    let count = length::<T>(path, count)?;
    // SAFETY: not null, aligned, not beyond the address space; the rest is the caller's word.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) }.to_vec())
}

/// The same in rows.
///
/// # Safety
/// Null, or that many rows which nobody writes meanwhile.
pub(crate) unsafe fn rows<const C: usize>(
    path: &str,
    pointer: *const f64,
    count: u64,
) -> Result<Vec<[f64; C]>, Failure> {
    // SAFETY: an array of numbers has their alignment.
    unsafe { column(path, pointer.cast::<[f64; C]>(), count) }
}

/// As many as fit into memory.
fn length<T>(path: &str, count: u64) -> Result<usize, Failure> {
    let most = isize::MAX as usize / size_of::<T>();
    let fits = usize::try_from(count).ok().filter(|&count| count <= most);
    fits.ok_or_else(|| Failure::argument(path, &format!("has {count} rows, more than memory can hold ({most})")))
}

/// Copies rows to an array of the caller; null stands for one that is not wanted.
///
/// # Safety
/// Null, or room for all of them that nobody else touches meanwhile.
pub(crate) unsafe fn put<T: Copy>(out: *mut T, rows: &[T]) {
    if !out.is_null() {
        // SAFETY: the rows are of this library, so they do not overlap with the caller's.
        unsafe { std::ptr::copy_nonoverlapping(rows.as_ptr(), out, rows.len()) };
    }
}

/// There is room for what came.
pub(crate) fn check_room(what: &str, capacity: u64, count: u64) -> Result<(), Failure> {
    if count <= capacity {
        return Ok(());
    }
    let message =
        format!("{what}.capacity is {capacity}, and there are {count} rows: give larger arrays and ask again");
    Err(Failure { code: sturz_code::SturzTooSmall, path: format!("{what}.capacity"), message })
}

/// A duration.
pub(crate) fn seconds(path: &str, value: f64) -> Result<Duration, Failure> {
    Duration::try_from_secs_f64(value)
        .map_err(|_| Failure::argument(path, &format!("is {value}; must be finite and at least 0")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_read_is_named() {
        let bad = |failure: Failure| {
            assert_eq!(failure.code, sturz_code::SturzInvalidArgument);
            failure.message
        };
        // SAFETY: null and misaligned pointers and absurd lengths are found before anything is read.
        unsafe {
            assert_eq!(bad(text("name", std::ptr::null()).unwrap_err()), "name is null");
            assert_eq!(bad(name("token", c"".as_ptr()).unwrap_err()), "token is empty");
            assert_eq!(bad(text("name", c"\xff".as_ptr()).unwrap_err()), "name is not UTF-8");
            let numbers = [0.0_f64; 2];
            let beside = numbers.as_ptr().byte_add(1);
            assert_eq!(bad(column("drag", beside, 1).unwrap_err()), "drag is not aligned to 8 bytes");
            let message = bad(rows::<3>("force_n", numbers.as_ptr(), u64::MAX).unwrap_err());
            assert!(message.starts_with("force_n has 18446744073709551615 rows, more than"), "{message}");
            assert!(rows::<3>("force_n", std::ptr::null(), 9).unwrap().is_empty());
        }
        for value in [-1.0, f64::NAN, f64::INFINITY] {
            let message = bad(seconds("timeout_s", value).unwrap_err());
            assert!(message.contains("must be finite and at least 0"), "{message}");
        }
    }

    #[test]
    fn rows_are_copied_as_they_are() {
        let numbers = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let mut out = [0.0; 6];
        // SAFETY: both arrays have two rows.
        unsafe {
            let rows = rows::<3>("x", numbers.as_ptr(), 2).unwrap();
            put(out.as_mut_ptr(), rows.as_flattened());
        }
        assert_eq!(out, numbers);
    }

    #[test]
    fn too_little_room_says_how_much_is_needed() {
        assert!(check_room("state", 3, 3).is_ok());
        let failure = check_room("state", 3, 4).unwrap_err();
        assert!(failure.code == sturz_code::SturzTooSmall && failure.message.contains("there are 4 rows"));
    }
}
