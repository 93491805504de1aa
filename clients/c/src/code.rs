//! What every call returns.

use sturz_client::ClientError;
use sturz_client::v1::ErrorCode;

/// What became of a call: 0 when it did what it says. `sturz_last_error_message` tells more of the others.
/// cbindgen:rename-all=ScreamingSnakeCase
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
// As in C, where they are global.
#[allow(clippy::enum_variant_names)]
pub enum sturz_code {
    /// Done.
    SturzOk = 0,
    /// An argument of this call is null, not finite, misaligned, of an unknown kind, or does not fit the others. Nothing was
    /// sent.
    SturzInvalidArgument = 1,
    /// An array of the caller has less room than there are rows; it is untouched, and the needed count is set. What else the
    /// call does is done.
    SturzTooSmall = 2,
    /// No daemon, or none of that name, was found within the time given.
    SturzNotFound = 3,
    /// The daemon was there, and is no more. Only `sturz_reconnect` goes on.
    SturzGone = 4,
    /// No answer in time.
    SturzTimeout = 5,
    /// This client may not do that: its certificate, or its role.
    SturzDenied = 6,
    /// The window or the steps ended before their end: somebody paused or stopped the daemon, or the lease was lost.
    SturzEndedEarly = 7,
    /// The answer lacks what was asked for: the fluid was taken away by somebody else.
    SturzNotSent = 8,
    /// The answer cannot be read: the daemon is of another version.
    SturzUnreadable = 9,
    /// The message bus failed.
    SturzBus = 10,
    /// A window was repeated as often as allowed, and has not converged.
    SturzNotConverged = 11,
    /// A fault of this library.
    SturzPanic = 12,
    /// Refused by the daemon, whose state is as it was; of a kind that this library does not know.
    SturzRefused = 100,
    /// The daemon could not read the request.
    SturzRefusedUndecodable = 101,
    /// A value is missing, not finite, out of range or of the wrong length: `sturz_last_error_path` tells which.
    SturzRefusedInvalidInput = 102,
    /// Over a limit of the daemon.
    SturzRefusedTooLarge = 103,
    /// Its queue is full: try again.
    SturzRefusedBusy = 104,
    /// Windows and steps need a paused simulation: `sturz_pause` first.
    SturzRefusedNotPaused = 105,
    /// Another window is under way.
    SturzRefusedWindowInFlight = 106,
    /// The simulation is not where this client left it: somebody else went on. `sturz_get_info` takes note of where it is.
    SturzRefusedWrongTime = 107,
    /// The request id was used before.
    SturzRefusedRequestIdReused = 108,
    /// There is no checkpoint, or no fluid with a mesh.
    SturzRefusedNotFound = 109,
    /// The run has failed, and can only be read or restored.
    SturzRefusedRunFailed = 110,
    /// The daemon is ending.
    SturzRefusedStopping = 111,
    /// A fault of the daemon.
    SturzRefusedInternal = 112,
    /// The checkpoint is damaged, of another scene or of another version.
    SturzRefusedUnusableCheckpoint = 113,
    /// The daemon's disk is full, or refuses.
    SturzRefusedDisk = 114,
    /// Another client holds the lease, or this one does not.
    SturzRefusedLease = 115,
    /// A recording is played there: it cannot be steered.
    SturzRefusedRecording = 116,
}

impl From<ErrorCode> for sturz_code {
    fn from(code: ErrorCode) -> Self {
        match code {
            ErrorCode::Unspecified => Self::SturzRefused,
            ErrorCode::Undecodable => Self::SturzRefusedUndecodable,
            ErrorCode::InvalidInput => Self::SturzRefusedInvalidInput,
            ErrorCode::TooLarge => Self::SturzRefusedTooLarge,
            ErrorCode::Busy => Self::SturzRefusedBusy,
            ErrorCode::NotPaused => Self::SturzRefusedNotPaused,
            ErrorCode::WindowInFlight => Self::SturzRefusedWindowInFlight,
            ErrorCode::WrongTime => Self::SturzRefusedWrongTime,
            ErrorCode::RequestIdReused => Self::SturzRefusedRequestIdReused,
            ErrorCode::NotFound => Self::SturzRefusedNotFound,
            ErrorCode::RunFailed => Self::SturzRefusedRunFailed,
            ErrorCode::Stopping => Self::SturzRefusedStopping,
            ErrorCode::Internal => Self::SturzRefusedInternal,
            ErrorCode::UnusableCheckpoint => Self::SturzRefusedUnusableCheckpoint,
            ErrorCode::Disk => Self::SturzRefusedDisk,
            ErrorCode::Lease => Self::SturzRefusedLease,
            ErrorCode::Recording => Self::SturzRefusedRecording,
        }
    }
}

impl From<&ClientError> for sturz_code {
    fn from(error: &ClientError) -> Self {
        match error {
            denied if denied.is_denial() => Self::SturzDenied,
            ClientError::Refused(refusal) => refusal.code.into(),
            ClientError::InvalidName(_) | ClientError::InvalidEndpoint { .. } | ClientError::NoCertificate { .. } => {
                Self::SturzInvalidArgument
            }
            ClientError::NobodyListens { .. } | ClientError::NoSuchInstance { .. } | ClientError::Silent { .. } => {
                Self::SturzNotFound
            }
            ClientError::DaemonGone { .. } => Self::SturzGone,
            ClientError::Timeout { .. } | ClientError::NoAnswer { .. } => Self::SturzTimeout,
            ClientError::Unreadable { .. }
            | ClientError::ColumnMissing { .. }
            | ClientError::Column { .. }
            | ClientError::ColumnRows { .. } => Self::SturzUnreadable,
            _ => Self::SturzBus,
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
