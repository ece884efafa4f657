//! A broker that lets in who has the key of a certificate, over TLS.

use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::server::WebPkiClientVerifier;
use rustls::{RootCertStore, ServerConfig};
use std::path::Path;
use std::sync::Arc;

/// With the certificate of the page as its own; its clients have `client.crt`.
pub fn of_broker(folder: &Path) -> Arc<ServerConfig> {
    let certificate = |name: &str| CertificateDer::from_pem_file(folder.join(name)).unwrap();
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let mut known = RootCertStore::empty();
    known.add(certificate("client.crt")).unwrap();
    let clients =
        WebPkiClientVerifier::builder_with_provider(Arc::new(known), Arc::clone(&provider)).build().unwrap();
    let config = ServerConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    let key = PrivateKeyDer::from_pem_file(folder.join("page.key")).unwrap();
    let config = config.with_client_cert_verifier(clients);
    Arc::new(config.with_single_cert(vec![certificate("page.crt")], key).unwrap())
}
