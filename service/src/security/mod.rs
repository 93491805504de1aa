//! Who may come in: certificates of a lab, roles, and what the bus is told of them.
//!
//! A client proves its name by a certificate; `roles.toml` beside the daemon's says what that name may do; zenoh's access
//! control, denying by default, holds it to that.

pub mod access;
pub mod authority;
pub mod door;
pub mod exposure;
pub mod folder;

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What a client may do; each role may all that the one before it may.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Look.
    View,
    /// And change the simulation.
    Steer,
    /// And end the daemon.
    Admin,
}

impl Role {
    /// All of them.
    pub const ALL: [Role; 3] = [Role::View, Role::Steer, Role::Admin];

    /// As in `roles.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Role::View => "view",
            Role::Steer => "steer",
            Role::Admin => "admin",
        }
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Role {
    type Err = SecurityError;

    fn from_str(text: &str) -> Result<Self, SecurityError> {
        let known = Role::ALL.into_iter().find(|role| role.name() == text);
        known.ok_or_else(|| SecurityError::NoRole { text: text.into() })
    }
}

/// Why certificates cannot be made or used.
#[derive(Debug, Error)]
pub enum SecurityError {
    /// Not one of three.
    #[error("{text:?} is no role: view, steer and admin are")]
    NoRole {
        /// As given.
        text: String,
    },
    /// Not such as `alice:steer`.
    #[error("{text:?} is no client: NAME:ROLE is wanted, such as alice:steer ({reason})")]
    NoClient {
        /// As given.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Nothing is replaced unasked.
    #[error("{} is there already: --force replaces it", .path.display())]
    Exists {
        /// What would be lost.
        path: PathBuf,
    },
    /// A part of a folder of certificates is missing.
    #[error("{} is missing: {remedy}", .path.display())]
    Missing {
        /// What is not there.
        path: PathBuf,
        /// How it gets there.
        remedy: String,
    },
    /// The list of roles cannot be read.
    #[error("{}: {reason}", .path.display())]
    Roles {
        /// Of the list.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Nobody could come in.
    #[error("{} names nobody, so that nobody could come in: add a client by `sturz certs DIR --client NAME:ROLE`", .path.display())]
    Nobody {
        /// Of the list.
        path: PathBuf,
    },
    /// A certificate cannot be made.
    #[error("cannot make the certificate of {what}: {reason}")]
    Certificate {
        /// Whose.
        what: String,
        /// Why not.
        reason: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {error}", .path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// As the operating system says.
        #[source]
        error: std::io::Error,
    },
}

impl SecurityError {
    /// Trouble with a file.
    pub(crate) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |error| SecurityError::File { path, error }
    }
}
