//! What every call returns.

use sturz_client::ClientError;
use sturz_client::v1::ErrorCode;

/// What became of a call: 0 when it did what it says. `sturz_last_error_message` tells more of the others.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum sturz_code {
    /// Done.
    Ok = 0,
    /// An argument of this call is null, not finite, misaligned, of an unknown kind, or does not fit the others. Nothing was
    /// sent.
    InvalidArgument = 1,
    /// An array of the caller has less room than there are rows; it is untouched, and the needed count is set. What else the
    /// call does is done.
    TooSmall = 2,
    /// No daemon, or none of that name, was found within the time given.
    NotFound = 3,
    /// The daemon was there, and is no more. Only `sturz_reconnect` goes on.
    Gone = 4,
    /// No answer in time.
    Timeout = 5,
    /// This client may not do that: its certificate, or its role.
    Denied = 6,
    /// The window or the steps ended before their end: somebody paused or stopped the daemon, or the lease was lost.
    EndedEarly = 7,
    /// The answer lacks what was asked for: the fluid was taken away by somebody else.
    NotSent = 8,
    /// The answer cannot be read: the daemon is of another version.
    Unreadable = 9,
    /// The message bus failed.
    Bus = 10,
    /// A window was repeated as often as allowed, and has not converged.
    NotConverged = 11,
    /// A fault of this library.
    Panic = 12,
    /// Refused by the daemon, whose state is as it was; of a kind that this library does not know.
    Refused = 100,
    /// The daemon could not read the request.
    RefusedUndecodable = 101,
    /// A value is missing, not finite, out of range or of the wrong length: `sturz_last_error_path` tells which.
    RefusedInvalidInput = 102,
    /// Over a limit of the daemon.
    RefusedTooLarge = 103,
    /// Its queue is full: try again.
    RefusedBusy = 104,
    /// Windows and steps need a paused simulation: `sturz_pause` first.
    RefusedNotPaused = 105,
    /// Another window is under way.
    RefusedWindowInFlight = 106,
    /// The simulation is not where this client left it: somebody else went on. `sturz_get_info` takes note of where it is.
    RefusedWrongTime = 107,
    /// The request id was used before.
    RefusedRequestIdReused = 108,
    /// There is no checkpoint, or no fluid with a mesh.
    RefusedNotFound = 109,
    /// The run has failed, and can only be read or restored.
    RefusedRunFailed = 110,
    /// The daemon is ending.
    RefusedStopping = 111,
    /// A fault of the daemon.
    RefusedInternal = 112,
    /// The checkpoint is damaged, of another scene or of another version.
    RefusedUnusableCheckpoint = 113,
    /// The daemon's disk is full, or refuses.
    RefusedDisk = 114,
    /// Another client holds the lease, or this one does not.
    RefusedLease = 115,
    /// A recording is played there: it cannot be steered.
    RefusedRecording = 116,
}

impl From<ErrorCode> for sturz_code {
    fn from(code: ErrorCode) -> Self {
        match code {
            ErrorCode::Unspecified => Self::Refused,
            ErrorCode::Undecodable => Self::RefusedUndecodable,
            ErrorCode::InvalidInput => Self::RefusedInvalidInput,
            ErrorCode::TooLarge => Self::RefusedTooLarge,
            ErrorCode::Busy => Self::RefusedBusy,
            ErrorCode::NotPaused => Self::RefusedNotPaused,
            ErrorCode::WindowInFlight => Self::RefusedWindowInFlight,
            ErrorCode::WrongTime => Self::RefusedWrongTime,
            ErrorCode::RequestIdReused => Self::RefusedRequestIdReused,
            ErrorCode::NotFound => Self::RefusedNotFound,
            ErrorCode::RunFailed => Self::RefusedRunFailed,
            ErrorCode::Stopping => Self::RefusedStopping,
            ErrorCode::Internal => Self::RefusedInternal,
            ErrorCode::UnusableCheckpoint => Self::RefusedUnusableCheckpoint,
            ErrorCode::Disk => Self::RefusedDisk,
            ErrorCode::Lease => Self::RefusedLease,
            ErrorCode::Recording => Self::RefusedRecording,
        }
    }
}

impl From<&ClientError> for sturz_code {
    fn from(error: &ClientError) -> Self {
        match error {
            denied if denied.is_denial() => Self::Denied,
            ClientError::Refused(refusal) => refusal.code.into(),
            ClientError::InvalidName(_) | ClientError::InvalidEndpoint { .. } | ClientError::NoCertificate { .. } => {
                Self::InvalidArgument
            }
            ClientError::NobodyListens { .. } | ClientError::NoSuchInstance { .. } | ClientError::Silent { .. } => {
                Self::NotFound
            }
            ClientError::DaemonGone { .. } => Self::Gone,
            ClientError::Timeout { .. } | ClientError::NoAnswer { .. } => Self::Timeout,
            ClientError::Unreadable { .. }
            | ClientError::ColumnMissing { .. }
            | ClientError::Column { .. }
            | ClientError::ColumnRows { .. } => Self::Unreadable,
            _ => Self::Bus,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_the_wire_are_those_above_a_hundred() {
        for wire in 0..=16 {
            let code = ErrorCode::try_from(wire).unwrap();
            assert_eq!(sturz_code::from(code) as i32, 100 + wire, "{code:?}");
        }
        assert!(ErrorCode::try_from(17).is_err(), "a new code of the wire needs one here");
    }
}
