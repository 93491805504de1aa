//! `sturz certs`

use crate::cli;
use crate::commands::Failure;
use crate::security::authority::{self, Wanted};
use crate::security::folder::{AUTHORITY_KEY, CLIENTS};
use crate::security::{Role, SecurityError};

/// Makes an authority and certificates, or adds to them.
pub fn certs(options: cli::Certs) -> Result<(), Failure> {
    let usage = |error: SecurityError| Failure::Usage(error.to_string());
    let clients: Vec<(String, Role)> =
        options.client.iter().map(|text| authority::client(text)).collect::<Result<_, _>>().map_err(usage)?;
    let wanted = Wanted {
        lab: options.name,
        hosts: options.host,
        clients,
        revoked: options.revoke,
        days: options.days,
        force: options.force,
    };
    let is_new = !options.folder.join(AUTHORITY_KEY).exists();
    let made = authority::make(&options.folder, &wanted).map_err(|error| match error {
        SecurityError::File { .. } => Failure::Other(error.into()),
        _ => usage(error),
    })?;
    for path in &made {
        println!("made {}", path.display());
    }
    for name in &wanted.revoked {
        println!("{name} has no role any more");
    }
    if is_new {
        println!("keep {} to yourself: who has it can make clients", options.folder.join(AUTHORITY_KEY).display());
        println!("serve with:  sturz serve SCENE --listen tls/0.0.0.0:7447 --tls {}", options.folder.display());
    } else {
        println!("daemons that are running must be started again to know of changed roles");
    }
    if let Some((name, _)) = wanted.clients.first() {
        let folder = options.folder.join(CLIENTS).join(name);
        println!("in Python:   sturz.connect(NAME, endpoint=\"tls/HOST:7447\", tls=\"{}\")", folder.display());
    }
    Ok(())
}
