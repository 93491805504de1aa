//! A small certificate authority for a lab.

use std::fs;
use std::path::{Path, PathBuf};

use rcgen::{
    BasicConstraints, CertificateParams, CertifiedIssuer, DistinguishedName, DnType, ExtendedKeyUsagePurpose, IsCa,
    Issuer, KeyPair, KeyUsagePurpose,
};
use sturz_protocol::keys::check_name;
use time::{Duration, OffsetDateTime};

use super::folder::{
    AUTHORITY, AUTHORITY_KEY, CERTIFICATE, CLIENTS, KEY, ROLES, SERVER, make_folder, read_roles, write_new, write_roles,
};
use super::{Role, SecurityError};

/// Clocks of a lab differ; what was made just now must hold already.
const CLOCKS_DIFFER: Duration = Duration::hours(1);
/// The authority outlives what it signs.
const AUTHORITY_DAYS: i64 = 3650;
/// Where every daemon can be reached by its own machine.
const LOCAL: [&str; 3] = ["localhost", "127.0.0.1", "::1"];

/// What to make.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Of the lab, for the authority's certificate.
    pub lab: String,
    /// Names and addresses by which clients reach the daemon, apart from the local ones.
    pub hosts: Vec<String>,
    /// Clients to make certificates for.
    pub clients: Vec<(String, Role)>,
    /// Names to strike off the list of roles.
    pub revoked: Vec<String>,
    /// How long the certificates hold.
    pub days: u32,
    /// Replace the certificates that are asked for.
    pub force: bool,
}

/// Parses `alice:steer`.
pub fn client(text: &str) -> Result<(String, Role), SecurityError> {
    let wrong = |reason: String| SecurityError::NoClient { text: text.into(), reason };
    let (name, role) = text.split_once(':').ok_or_else(|| wrong("the role is missing".into()))?;
    check_name(name).map_err(|error| wrong(error.to_string()))?;
    Ok((name.into(), role.parse().map_err(|error: SecurityError| wrong(error.to_string()))?))
}

/// Makes what is wanted and not there, in `folder`; returns the folders that were made.
///
/// # Errors
/// [`SecurityError::Exists`], before anything was written, when something would be replaced without
/// [`Wanted::force`]. The authority itself is never replaced.
pub fn make(folder: &Path, wanted: &Wanted) -> Result<Vec<PathBuf>, SecurityError> {
    let server = folder.join(SERVER);
    let renew_server = !server.exists() || !wanted.hosts.is_empty();
    let client_folders: Vec<PathBuf> = wanted.clients.iter().map(|(name, _)| folder.join(CLIENTS).join(name)).collect();
    let roles_path = server.join(ROLES);
    let mut roles = read_roles(&roles_path)?;
    for name in &wanted.revoked {
        if roles.remove(name).is_none() {
            let reason = format!("there is no {name:?} to revoke: there are {:?}", roles.keys().collect::<Vec<_>>());
            return Err(SecurityError::Roles { path: roles_path, reason });
        }
    }
    let made: Vec<PathBuf> = renew_server.then_some(server).into_iter().chain(client_folders.iter().cloned()).collect();
    if let Some(path) = made.iter().find(|path| path.exists() && !wanted.force) {
        return Err(SecurityError::Exists { path: path.clone() });
    }

    make_folder(folder)?;
    let authority = Authority::open_or_make(folder, wanted)?;
    if renew_server {
        let hosts = LOCAL.into_iter().map(String::from).chain(wanted.hosts.iter().cloned()).collect();
        authority.issue(&made[0], "sturz-server", hosts, ExtendedKeyUsagePurpose::ServerAuth, wanted.days)?;
    }
    for (path, (name, role)) in client_folders.iter().zip(&wanted.clients) {
        authority.issue(path, name, Vec::new(), ExtendedKeyUsagePurpose::ClientAuth, wanted.days)?;
        roles.insert(name.clone(), *role);
    }
    write_roles(&roles_path, &roles)?;
    Ok(made)
}

/// Signs certificates.
struct Authority {
    issuer: Issuer<'static, KeyPair>,
    certificate: String,
}

impl Authority {
    fn open_or_make(folder: &Path, wanted: &Wanted) -> Result<Self, SecurityError> {
        let (certificate_path, key_path) = (folder.join(AUTHORITY), folder.join(AUTHORITY_KEY));
        if !certificate_path.exists() && !key_path.exists() {
            return Self::make(&certificate_path, &key_path, wanted);
        }
        let read = |path: &Path| fs::read_to_string(path).map_err(SecurityError::file(path));
        let (certificate, key) = (read(&certificate_path)?, read(&key_path)?);
        let issuer = KeyPair::from_pem(&key).and_then(|key| Issuer::from_ca_cert_pem(&certificate, key));
        let issuer = issuer.map_err(failed(&format!("the authority in {}", folder.display())))?;
        Ok(Self { issuer, certificate })
    }

    fn make(certificate_path: &Path, key_path: &Path, wanted: &Wanted) -> Result<Self, SecurityError> {
        let what = format!("the authority of {}", wanted.lab);
        let key = KeyPair::generate().map_err(failed(&what))?;
        let mut parameters = parameters(&what, Vec::new(), i64::from(wanted.days).max(AUTHORITY_DAYS))?;
        // It may sign for ends, and no further authority.
        parameters.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        parameters.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
        let key_text = key.serialize_pem();
        let issuer = CertifiedIssuer::self_signed(parameters, key).map_err(failed(&what))?;
        let certificate = issuer.pem();
        write_new(key_path, &key_text, true)?;
        write_new(certificate_path, &certificate, false)?;
        let key = KeyPair::from_pem(&key_text).map_err(failed(&what))?;
        let issuer = Issuer::from_ca_cert_pem(&certificate, key).map_err(failed(&what))?;
        Ok(Self { issuer, certificate })
    }

    /// Makes the folder of a daemon or client; what was in it goes.
    fn issue(
        &self,
        folder: &Path,
        name: &str,
        hosts: Vec<String>,
        purpose: ExtendedKeyUsagePurpose,
        days: u32,
    ) -> Result<(), SecurityError> {
        let mut parameters = parameters(name, hosts, days.into())?;
        parameters.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        parameters.extended_key_usages = vec![purpose];
        parameters.use_authority_key_identifier_extension = true;
        let key = KeyPair::generate().map_err(failed(name))?;
        let certificate = parameters.signed_by(&key, &self.issuer).map_err(failed(name))?;
        make_folder(folder)?;
        for (file, text) in
            [(AUTHORITY, &self.certificate), (CERTIFICATE, &certificate.pem()), (KEY, &key.serialize_pem())]
        {
            let path = folder.join(file);
            if path.exists() {
                fs::remove_file(&path).map_err(SecurityError::file(&path))?;
            }
            write_new(&path, text, file == KEY)?;
        }
        Ok(())
    }
}

fn parameters(name: &str, hosts: Vec<String>, days: i64) -> Result<CertificateParams, SecurityError> {
    let mut parameters = CertificateParams::new(hosts).map_err(failed(name))?;
    parameters.distinguished_name = DistinguishedName::new();
    parameters.distinguished_name.push(DnType::CommonName, name);
    let now = OffsetDateTime::now_utc();
    parameters.not_before = now - CLOCKS_DIFFER;
    parameters.not_after = now + Duration::days(days);
    Ok(parameters)
}

fn failed(what: &str) -> impl FnOnce(rcgen::Error) -> SecurityError {
    let what = what.to_string();
    move |error| SecurityError::Certificate { what, reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::super::folder::Identity;
    use super::*;

    fn wanted(clients: &[&str]) -> Wanted {
        let clients = clients.iter().map(|text| client(text).unwrap()).collect();
        Wanted { lab: "lab".into(), clients, days: 30, ..Wanted::default() }
    }

    #[test]
    fn a_client_is_a_name_and_a_role() {
        assert_eq!(client("alice:steer").unwrap(), ("alice".into(), Role::Steer));
        for (text, reason) in
            [("alice", "role is missing"), ("alice:boss", "view, steer and admin"), ("a/b:view", "a/b")]
        {
            let error = client(text).unwrap_err().to_string();
            assert!(error.contains(reason) && error.contains("alice:steer"), "{error}");
        }
    }

    #[test]
    fn keys_are_private_and_a_client_can_be_added_later() {
        let folder = tempfile::tempdir().unwrap();
        let lab = folder.path().join("lab");
        make(&lab, &wanted(&["alice:steer"])).unwrap();
        let authority = fs::read_to_string(lab.join(AUTHORITY)).unwrap();
        assert_eq!(make(&lab, &wanted(&["bob:view"])).unwrap(), [lab.join("clients/bob")]);
        for key in ["ca.key", "server/key.pem", "clients/alice/key.pem", "clients/bob/key.pem"] {
            let mode = fs::metadata(lab.join(key)).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600, "{key}");
        }
        let (server, roles) = Identity::of_server(&lab).unwrap();
        assert_eq!(server, Identity::of_server(&lab.join("server")).unwrap().0);
        assert_eq!(roles.into_iter().collect::<Vec<_>>(), [("alice".into(), Role::Steer), ("bob".into(), Role::View)]);
        let bob = Identity::of_client(&lab.join("clients/bob")).unwrap();
        assert_eq!(fs::read_to_string(bob.authority).unwrap(), authority);
        let error = Identity::of_client(&lab).unwrap_err().to_string();
        assert!(error.contains("certificate.pem is missing") && error.contains("LAB/clients/NAME"), "{error}");
    }

    #[test]
    fn nothing_is_replaced_without_force_and_the_authority_never() {
        let folder = tempfile::tempdir().unwrap();
        let lab = folder.path();
        make(lab, &wanted(&["alice:view"])).unwrap();
        let read = |name: &str| fs::read_to_string(lab.join(name)).unwrap();
        let before = [read("ca.pem"), read("clients/alice/key.pem"), read("server/key.pem")];
        let error = make(lab, &wanted(&["bob:view", "alice:admin"])).unwrap_err();
        assert!(matches!(&error, SecurityError::Exists { path } if path.ends_with("alice")), "{error}");
        assert!(!lab.join("clients/bob").exists(), "nothing was made before the refusal");
        let hosts = Wanted { hosts: vec!["192.0.2.7".into()], ..wanted(&[]) };
        assert!(matches!(make(lab, &hosts), Err(SecurityError::Exists { .. })));
        make(lab, &Wanted { force: true, ..wanted(&["alice:admin"]) }).unwrap();
        assert_eq!(read("ca.pem"), before[0]);
        assert_ne!(read("clients/alice/key.pem"), before[1]);
        assert_eq!(read("server/key.pem"), before[2], "only what was asked for is replaced");
        assert_eq!(Identity::of_server(lab).unwrap().1["alice"], Role::Admin);
    }

    #[test]
    fn a_name_can_be_struck_off_the_list() {
        let folder = tempfile::tempdir().unwrap();
        make(folder.path(), &wanted(&["alice:view"])).unwrap();
        let revoke = Wanted { revoked: vec!["alice".into()], ..wanted(&[]) };
        assert!(make(folder.path(), &revoke).unwrap().is_empty());
        assert!(matches!(Identity::of_server(folder.path()), Err(SecurityError::Nobody { .. })));
        let error = make(folder.path(), &revoke).unwrap_err().to_string();
        assert!(error.contains("no \"alice\" to revoke"), "{error}");
    }
}
