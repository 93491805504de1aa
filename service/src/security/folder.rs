//! Folders of certificates.
//!
//! ```text
//! lab/ca.pem, ca.key                              the authority; its key stays here
//! lab/server/ca.pem, certificate.pem, key.pem     what the daemon needs
//! lab/server/roles.toml                           who may do what
//! lab/clients/alice/ca.pem, certificate.pem, key.pem   what a client needs: hand over this folder
//! ```

use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use super::{Role, SecurityError};

/// Who may do what, by the common name of the certificate.
pub type Roles = BTreeMap<String, Role>;

/// Certificate of the authority, in every folder.
pub const AUTHORITY: &str = "ca.pem";
/// Key of the authority.
pub const AUTHORITY_KEY: &str = "ca.key";
/// Of the folder's owner.
pub const CERTIFICATE: &str = "certificate.pem";
/// Of the folder's owner.
pub const KEY: &str = "key.pem";
/// Names and roles.
pub const ROLES: &str = "roles.toml";
/// Folder of the daemon.
pub const SERVER: &str = "server";
/// Folder of the folders of clients.
pub const CLIENTS: &str = "clients";

const ROLES_HEAD: &str = "\
# Who may come in, by the name in the certificate, and what for: view, steer or admin. Whoever is not named here is
# refused everything. Read by `sturz serve --tls` when it starts.
";

/// What one side of a connection needs to prove who it is and to check the other side.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Certificate of the authority.
    pub authority: PathBuf,
    /// Own certificate.
    pub certificate: PathBuf,
    /// Own key.
    pub key: PathBuf,
}

impl Identity {
    fn of(folder: &Path, remedy: &str) -> Result<Self, SecurityError> {
        let file = |name: &str| {
            let path = folder.join(name);
            if path.is_file() { Ok(path) } else { Err(SecurityError::Missing { path, remedy: remedy.into() }) }
        };
        Ok(Self { authority: file(AUTHORITY)?, certificate: file(CERTIFICATE)?, key: file(KEY)? })
    }

    /// Of a client, from its own folder.
    ///
    /// # Errors
    /// [`SecurityError::Missing`], with what to give instead.
    pub fn of_client(folder: &Path) -> Result<Self, SecurityError> {
        let remedy = "give the folder of one client, such as LAB/clients/NAME, which `sturz certs` makes";
        Self::of(folder, remedy)
    }

    /// Of a daemon: the folder that `sturz certs` made, or the `server` in it alone.
    ///
    /// # Errors
    /// [`SecurityError::Missing`], with how to make it.
    pub fn of_server(folder: &Path) -> Result<(Self, Roles), SecurityError> {
        let inner = folder.join(SERVER);
        let folder = if inner.is_dir() { inner.as_path() } else { folder };
        let identity = Self::of(folder, "`sturz certs DIR` makes it")?;
        let path = folder.join(ROLES);
        let roles = read_roles(&path)?;
        if roles.is_empty() { Err(SecurityError::Nobody { path }) } else { Ok((identity, roles)) }
    }
}

/// Reads a list of roles; one that is not there is empty.
pub fn read_roles(path: &Path) -> Result<Roles, SecurityError> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Roles::new()),
        Err(error) => return Err(SecurityError::file(path)(error)),
    };
    let wrong = |reason: String| SecurityError::Roles { path: path.into(), reason };
    let roles: Roles = toml::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    match roles.keys().find_map(|name| sturz_protocol::keys::check_name(name).err()) {
        Some(error) => Err(wrong(error.to_string())),
        None => Ok(roles),
    }
}

/// Replaces a list of roles as a whole.
pub fn write_roles(path: &Path, roles: &Roles) -> Result<(), SecurityError> {
    let lines = toml::to_string(roles)
        .map_err(|error| SecurityError::Roles { path: path.into(), reason: error.to_string() })?;
    let new = path.with_extension("new");
    fs::write(&new, format!("{ROLES_HEAD}{lines}")).map_err(SecurityError::file(&new))?;
    fs::rename(&new, path).map_err(SecurityError::file(path))
}

/// Makes a folder that only its owner may look into, and those above it.
pub fn make_folder(path: &Path) -> Result<(), SecurityError> {
    fs::DirBuilder::new().recursive(true).mode(0o700).create(path).map_err(SecurityError::file(path))
}

/// Writes a file that is not there yet; keys are for their owner alone.
pub fn write_new(path: &Path, text: &str, is_key: bool) -> Result<(), SecurityError> {
    let mode = if is_key { 0o600 } else { 0o644 };
    let file = OpenOptions::new().write(true).create_new(true).mode(mode).open(path);
    file.and_then(|mut file| file.write_all(text.as_bytes())).map_err(SecurityError::file(path))
}
