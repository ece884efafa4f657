//! Certificates and private keys from PEM files.

use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use std::path::Path;
use trunnion_acquire::credentials;
use trunnion_core::Secret;

/// All certificates of a file, in its order.
///
/// # Errors
/// A file that is not there, is no PEM, or has none: in words.
pub fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, String> {
    let all = CertificateDer::pem_file_iter(path).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    match all {
        Ok(all) if all.is_empty() => Err(format!("{} has no certificate (PEM)", path.display())),
        Ok(all) => Ok(all),
        Err(error) => Err(format!("{} cannot be read as certificates (PEM): {error}", path.display())),
    }
}

/// The private key of a secret.
///
/// # Errors
/// A file that is not there or holds none: in words, without what it holds.
pub fn private_key(secret: &Secret) -> Result<PrivateKeyDer<'static>, String> {
    let text = credentials::value(secret)?;
    PrivateKeyDer::from_pem_slice(text.as_bytes())
        .map_err(|error| format!("`key_file` holds no private key (PEM): {error}"))
}
