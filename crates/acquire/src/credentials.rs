//! User and password of a device: its keys, and the value of a password when it is needed.

use std::path::{Path, PathBuf};
use trunnion_core::Secret;
use trunnion_core::input::Table;

/// Reads `user` with `password` or `password_file`; one without the other is a problem.
pub fn read_login(table: &Table<'_>) -> Option<(String, Secret)> {
    match (table.optional_string("user"), Secret::read(table)) {
        (Some(user), Some(password)) => Some((user, password)),
        (None, None) => None,
        _ => {
            table.problem("user", "is not complete", "user with either password or password_file", "");
            None
        }
    }
}

/// The password as given, or what its file holds without the end of the line.
///
/// # Errors
/// What is wrong with the file, and what to do; never what it holds.
pub fn value(secret: &Secret) -> Result<String, String> {
    match secret {
        Secret::Given(password) => Ok(password.clone()),
        Secret::File { name, folder } => {
            let path = place_now(name, folder);
            let text = std::fs::read_to_string(&path)
                .map_err(|error| format!("the password file {} cannot be read: {error}", path.display()))?;
            Ok(text.trim_end_matches(['\r', '\n']).to_owned())
        }
    }
}

/// The file of a secret; `None` where it stands in the configuration.
pub fn file(secret: &Secret) -> Option<PathBuf> {
    match secret {
        Secret::Given(_) => None,
        Secret::File { name, folder } => Some(place_now(name, folder)),
    }
}

fn place_now(name: &Path, folder: &Path) -> PathBuf {
    place(name, folder, std::env::var_os("CREDENTIALS_DIRECTORY").as_deref().map(Path::new))
}

/// A relative name is that of a credential that systemd gives the service, else of a file next to the configuration.
fn place(name: &Path, folder: &Path, credentials: Option<&Path>) -> PathBuf {
    let given = credentials.filter(|_| name.is_relative()).map(|credentials| credentials.join(name));
    given.filter(|path| path.exists()).unwrap_or_else(|| folder.join(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_credential_of_systemd_goes_before_a_file_next_to_the_configuration() {
        let (credentials, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        std::fs::write(folder.path().join("cnc"), "from file\r\n").unwrap();
        let find = |name: &str| place(Path::new(name), folder.path(), Some(credentials.path()));
        assert_eq!(find("cnc"), folder.path().join("cnc"));
        std::fs::write(credentials.path().join("cnc"), "from systemd").unwrap();
        assert_eq!(find("cnc"), credentials.path().join("cnc"));
        assert_eq!(find("/run/cnc"), Path::new("/run/cnc"));

        let secret = |name: &str| Secret::File { name: name.into(), folder: folder.path().into() };
        assert_eq!(value(&secret("cnc")).unwrap(), "from file");
        assert!(value(&secret("gone")).unwrap_err().contains("gone cannot be read"));
    }
}
