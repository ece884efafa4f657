//! Calls of a page over TLS, as another computer makes them.

use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;

/// The name in the certificate of the tests.
const NAME: &str = "cell-4.lan";

/// The page of a service.
pub struct Page {
    pub port: u16,
    config: Arc<ClientConfig>,
}

impl Page {
    /// At a port of this computer, with this certificate.
    pub fn at(port: u16, certificate: &Path) -> Self {
        let mut roots = RootCertStore::empty();
        roots.add(CertificateDer::from_pem_file(certificate).unwrap()).unwrap();
        let config = ClientConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_root_certificates(roots)
            .with_no_client_auth();
        Self { port, config: Arc::new(config) }
    }

    /// Status and whole answer; `None` while nobody listens.
    pub fn call(&self, line: &str, headers: &str, body: &str) -> Option<(u16, String)> {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).ok()?;
        let client =
            ClientConnection::new(Arc::clone(&self.config), ServerName::try_from(NAME).unwrap()).unwrap();
        let mut stream = StreamOwned::new(client, stream);
        let (host, length) = (format!("{NAME}:{}", self.port), body.len());
        let text = format!(
            "{line} HTTP/1.1\r\nHost: {host}\r\n{headers}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}"
        );
        stream.write_all(text.as_bytes()).ok()?;
        let mut answer = Vec::new();
        // The page closes without the farewell of TLS.
        stream.read_to_end(&mut answer).ok();
        let answer = String::from_utf8_lossy(&answer).into_owned();
        Some((answer.split(' ').nth(1)?.parse().ok()?, answer))
    }
}
