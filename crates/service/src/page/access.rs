//! Who is let in: every user of this computer; from other computers who has the token, over TLS.

use crate::pem;
use rustls::ServerConfig;
use sha2::{Digest, Sha256};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use tokio_rustls::TlsAcceptor;
use trunnion_acquire::credentials;
use trunnion_core::Secret;
use trunnion_core::input::Table;

/// Shortest token: 20 characters of 64 kinds are 120 bits, which 40 calls a second do not find.
const SHORTEST_TOKEN: usize = 20;

/// What the table `[page]` says of other computers.
#[derive(Clone, Debug)]
pub struct Lan {
    /// Names of this computer in the network, as browsers call it.
    pub names: Vec<String>,
    /// PEM file of the certificate, and those that vouch for it.
    pub certificate: PathBuf,
    /// PEM file of its key.
    pub key: Secret,
    /// What whoever calls must know.
    pub token: Secret,
}

/// Why the page cannot be given to other computers.
#[derive(Debug, thiserror::Error)]
pub enum AccessError {
    /// A file of a secret.
    #[error("{0}")]
    Secret(String),
    /// A token that can be guessed.
    #[error(
        "the token has {found} characters, and {SHORTEST_TOKEN} are the fewest; `openssl rand -base64 24` makes one"
    )]
    ShortToken {
        /// Its length.
        found: usize,
    },
    /// A certificate or key that cannot be read.
    #[error("{0}")]
    Pem(String),
    /// A pair that does not fit.
    #[error("certificate and key cannot be used")]
    Pair(#[from] rustls::Error),
}

/// The rule by which a connection and a call are let in.
#[derive(Clone, Default)]
pub struct Access {
    /// Names of this computer in the network.
    pub(super) names: Vec<String>,
    /// Encrypts, where other computers call.
    pub(super) tls: Option<TlsAcceptor>,
    token: Option<Digests>,
}

/// What is compared in place of the token: how long that takes says nothing of it.
#[derive(Clone, Copy)]
struct Digests {
    token: [u8; 32],
    cookie: [u8; 32],
}

impl Lan {
    /// Reads the keys of `[page]` for other computers; `None` without any, or with one that is missing, which is a problem.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let names = table.optional_strings("names").unwrap_or_default();
        let certificate = table.optional_string("certificate");
        let (key, token) = (Secret::read_file(table, "key_file"), Secret::read_file(table, "token_file"));
        if certificate.is_none() && key.is_none() && token.is_none() {
            return None;
        }
        let given = [certificate.is_some(), key.is_some(), token.is_some()];
        for (name, given) in ["certificate", "key_file", "token_file"].into_iter().zip(given) {
            if !given {
                table.problem(name, "is missing", "all of certificate, key_file and token_file, or none", "");
            }
        }
        Some(Self { names, certificate: table.folder().join(certificate?), key: key?, token: token? })
    }
}

impl Access {
    /// Whoever uses this computer.
    pub fn this_computer() -> Self {
        Self::default()
    }

    /// Other computers too; reads certificate, key and token.
    ///
    /// # Errors
    /// Files that are not there or do not fit.
    pub fn of_lan(lan: &Lan) -> Result<Self, AccessError> {
        let token = credentials::value(&lan.token).map_err(AccessError::Secret)?;
        let token = token.trim();
        let found = token.chars().count();
        if found < SHORTEST_TOKEN {
            return Err(AccessError::ShortToken { found });
        }
        let chain = pem::certificates(&lan.certificate).map_err(AccessError::Pem)?;
        let key = pem::private_key(&lan.key).map_err(AccessError::Pem)?;
        let config = ServerConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .with_protocol_versions(&[&rustls::version::TLS13])?
            .with_no_client_auth()
            .with_single_cert(chain, key)?;
        let digests = Digests { token: digest("token", token), cookie: digest("cookie", token) };
        let tls = Some(TlsAcceptor::from(Arc::new(config)));
        Ok(Self { names: lan.names.clone(), tls, token: Some(digests) })
    }

    /// What an address of the page begins with.
    pub fn scheme(&self) -> &'static str {
        if self.tls.is_some() { "https" } else { "http" }
    }

    /// Whether this is the token; true where none is asked for.
    pub(super) fn is_token(&self, token: &str) -> bool {
        self.token.is_none_or(|known| known.token == digest("token", token.trim()))
    }

    /// Whether a call with this `Authorization` and `Cookie` knows the token.
    pub(super) fn lets_in(&self, authorization: &str, cookies: &str) -> bool {
        let Some(known) = &self.token else { return true };
        let of_browser = |cookie: &str| cookie.trim().strip_prefix("trunnion=").map(str::to_owned);
        authorization.strip_prefix("Bearer ").is_some_and(|token| self.is_token(token))
            || cookies.split(';').filter_map(of_browser).any(|value| value == hex(&known.cookie))
    }

    /// What a browser keeps after the token was right: no script reads it, no other page sends it.
    pub(super) fn cookie(&self) -> String {
        const MONTH_S: u32 = 30 * 24 * 3600;
        let value = self.token.map_or_else(String::new, |known| hex(&known.cookie));
        format!("trunnion={value}; Path=/; HttpOnly; Secure; SameSite=Strict; Max-Age={MONTH_S}")
    }

    /// Names with which a browser on this address may call, each with the port.
    pub(super) fn hosts(&self, address: SocketAddr) -> Vec<String> {
        let own = match address {
            SocketAddr::V4(address) => address.ip().to_string(),
            SocketAddr::V6(address) => format!("[{}]", address.ip()),
        };
        let local = ["localhost".into(), "127.0.0.1".into(), "[::1]".into(), own];
        let names = local.into_iter().chain(self.names.iter().cloned());
        let (port, usual) = (address.port(), if self.tls.is_some() { 443 } else { 80 });
        let both = |name: String| {
            let bare = (port == usual).then(|| name.clone());
            bare.into_iter().chain([format!("{name}:{port}")])
        };
        names.flat_map(both).collect()
    }
}

fn digest(what: &str, token: &str) -> [u8; 32] {
    Sha256::new().chain_update(what).chain_update([0]).chain_update(token).finalize().into()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
