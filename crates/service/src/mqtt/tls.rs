//! Encryption of the connection to the broker.

use crate::pem;
use rumqttc::{TlsConfiguration, TlsError, Transport};
use rustls::{ClientConfig, RootCertStore};
use std::path::PathBuf;
use std::sync::Arc;
use trunnion_core::Secret;
use trunnion_core::input::Table;

/// What the table `[mqtt.tls]` says.
#[derive(Clone, Debug, PartialEq)]
pub struct MqttTls {
    /// PEM file of who signed the broker's certificate: usually the plant's own.
    pub ca: PathBuf,
    /// PEM file of our certificate, with its key, where the broker asks for one.
    pub client: Option<(PathBuf, Secret)>,
}

impl MqttTls {
    /// Reads the table; what is missing is a problem.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let ca = table.string("ca");
        let (certificate, key) = (table.optional_string("certificate"), Secret::read_file(table, "key_file"));
        table.no_other_keys();
        if certificate.is_some() != key.is_some() {
            let missing = if key.is_some() { "certificate" } else { "key_file" };
            table.problem(missing, "is missing", "both certificate and key_file, or neither", "");
            return None;
        }
        let client = certificate.map(|name| table.folder().join(name)).zip(key);
        Some(Self { ca: table.folder().join(ca?), client })
    }

    /// Whether the files are there and are what they should be.
    ///
    /// # Errors
    /// In words: the first that is not.
    pub fn check(&self) -> Result<(), String> {
        self.transport().map(drop)
    }

    /// Reads the files, as they are when a connection begins.
    ///
    /// # Errors
    /// In words: a file that is not there, or is not what it should be.
    pub(super) fn transport(&self) -> Result<Transport, String> {
        let mut roots = RootCertStore::empty();
        for certificate in pem::certificates(&self.ca)? {
            roots
                .add(certificate)
                .map_err(|error| format!("{} cannot be trusted: {error}", self.ca.display()))?;
        }
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let unfit =
            |error: rustls::Error| format!("certificate and key of [mqtt.tls] cannot be used: {error}");
        let builder = ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions();
        let builder = builder.map_err(unfit)?.with_root_certificates(roots);
        let config = match &self.client {
            None => builder.with_no_client_auth(),
            Some((certificate, key)) => builder
                .with_client_auth_cert(pem::certificates(certificate)?, pem::private_key(key)?)
                .map_err(unfit)?,
        };
        Ok(Transport::tls_with_config(TlsConfiguration::Rustls(Arc::new(config))))
    }
}

/// A failure of the encryption, with what to do.
pub(super) fn cause(error: &TlsError) -> String {
    let text = error.to_string();
    let advice = match text.contains("UnknownIssuer") || text.contains("NotValidForName") {
        true => {
            "; `ca` of [mqtt.tls] must have signed the broker's certificate, and `host` must be a name in it"
        }
        false => "",
    };
    format!("encryption: {text}{advice}")
}
