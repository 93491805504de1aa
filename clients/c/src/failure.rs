//! Why the last call of a thread failed; nothing unwinds into C.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use sturz_client::ClientError;

use crate::code::sturz_code;

/// Why a call failed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Failure {
    pub(crate) code: sturz_code,
    /// Into the arguments or the request; empty when there is none.
    pub(crate) path: String,
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(code: sturz_code, message: impl Into<String>) -> Self {
        Self { code, path: String::new(), message: message.into() }
    }

    /// Of an argument of this side: `path` as in C, what it is and what it must be.
    pub(crate) fn argument(path: &str, what: &str) -> Self {
        Self { code: sturz_code::SturzInvalidArgument, path: path.into(), message: format!("{path} {what}") }
    }
}

impl From<ClientError> for Failure {
    fn from(error: ClientError) -> Self {
        let path = error.refusal().map(|refusal| refusal.path.clone()).unwrap_or_default();
        Self { code: (&error).into(), path, message: error.to_string() }
    }
}

/// Of one thread, as C reads it.
struct Last {
    code: sturz_code,
    message: CString,
    path: CString,
}

thread_local! {
    static LAST: RefCell<Last> =
        RefCell::new(Last { code: sturz_code::SturzOk, message: CString::default(), path: CString::default() });
}

/// Does the work of a call, remembers why it failed, and lets no panic through.
pub(crate) fn guard(work: impl FnOnce() -> Result<(), Failure>) -> sturz_code {
    // What a panic leaves behind is a connection, whose locks are taken poisoned or not.
    let failure = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => return sturz_code::SturzOk,
        Ok(Err(failure)) => failure,
        Err(panic) => Failure::new(sturz_code::SturzPanic, format!("a fault of this library: {}", panic_text(&*panic))),
    };
    remember(&failure);
    failure.code
}

fn remember(failure: &Failure) {
    let last = Last { code: failure.code, message: c_text(&failure.message), path: c_text(&failure.path) };
    // A thread that ends has nobody left to ask.
    drop(LAST.try_with(|slot| slot.replace(last)));
}

/// Without zeros inside, which end a text in C.
fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "\\0")).unwrap_or_default()
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("it does not say why")
}

/// What the last call of this thread that failed returned; `STURZ_OK` when none has.
#[unsafe(no_mangle)]
pub extern "C" fn sturz_last_error_code() -> sturz_code {
    LAST.try_with(|last| last.borrow().code).unwrap_or(sturz_code::SturzOk)
}

/// Why the last call of this thread that failed did so, as a sentence in UTF-8: what is wrong and what would be right. Empty
/// when none has failed. Valid until the next call of this thread that fails.
#[unsafe(no_mangle)]
pub extern "C" fn sturz_last_error_message() -> *const c_char {
    LAST.try_with(|last| last.borrow().message.as_ptr()).unwrap_or(c"".as_ptr())
}

/// What it was about, such as `loads.force_n[1]`; empty when it was about the whole. Valid as the message is.
#[unsafe(no_mangle)]
pub extern "C" fn sturz_last_error_path() -> *const c_char {
    LAST.try_with(|last| last.borrow().path.as_ptr()).unwrap_or(c"".as_ptr())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    fn last() -> (sturz_code, String, String) {
        let text = |text: *const c_char| {
            // SAFETY: of this thread, and read before the next call.
            unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
        };
        (sturz_last_error_code(), text(sturz_last_error_message()), text(sturz_last_error_path()))
    }

    #[test]
    fn a_panic_becomes_a_code() {
        assert_eq!(guard(|| panic!("number {}", 7)), sturz_code::SturzPanic);
        let (code, message, path) = last();
        assert!(code == sturz_code::SturzPanic && message.contains("number 7") && path.is_empty(), "{message}");
    }

    #[test]
    fn each_thread_has_its_own_last_error_and_success_keeps_it() {
        assert_eq!(guard(|| Err(Failure::argument("loads.ids", "is n\0ll"))), sturz_code::SturzInvalidArgument);
        assert_eq!(guard(|| Ok(())), sturz_code::SturzOk);
        let expected = (sturz_code::SturzInvalidArgument, "loads.ids is n\\0ll".to_owned(), "loads.ids".to_owned());
        assert_eq!(last(), expected);
        let other = std::thread::spawn(last).join().unwrap();
        assert_eq!(other, (sturz_code::SturzOk, String::new(), String::new()));
    }
}
