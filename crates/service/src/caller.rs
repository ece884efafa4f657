//! Calls of the page of a running service by a program on the same computer (docs/use/page.md).
//!
//! Over TLS only the certificate of the configuration is accepted, itself: the name under which the computer is called plays no part.

use crate::config::PageConfig;
use crate::page::OWN_HEADER;
use crate::pem;
use http_body_util::{BodyExt, Full, Limited};
use hyper::body::Bytes;
use hyper::client::conn::http1;
use hyper::header::{AUTHORIZATION, CONTENT_TYPE, HOST};
use hyper::{Method, Request, StatusCode};
use hyper_util::rt::TokioIo;
use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::crypto::{CryptoProvider, verify_tls13_signature};
use rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use rustls::{CertificateError, ClientConfig, DigitallySignedStruct, Error, SignatureScheme};
use serde_json::{Value, json};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use trunnion::results::PageStatus;
use trunnion_acquire::credentials;

/// Longest wait for an answer; none of these calls computes anything.
const LONGEST: Duration = Duration::from_secs(10);
/// Longest answer: a status with its topics has some kilobytes.
const MOST_BYTES: usize = 16 << 20;
/// The name that every page knows itself by.
const OWN_NAME: &str = "localhost";

/// Who calls.
pub struct Caller {
    address: SocketAddr,
    /// With the token, where other computers are let in.
    lan: Option<(TlsConnector, String)>,
}

/// Why a call got no answer.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// Nothing listens.
    #[error("no service answers at {address} ({why}); is it running with this configuration?")]
    NotThere {
        /// Where it was looked for.
        address: SocketAddr,
        /// The system's words.
        why: String,
    },
    /// It does not answer.
    #[error("the service at {0} does not answer within {wait} s", wait = LONGEST.as_secs())]
    Silent(SocketAddr),
    /// Not our certificate, or another program.
    #[error("what answers at {address} is not the service of this configuration: {why}")]
    Stranger {
        /// Where.
        address: SocketAddr,
        /// What went wrong.
        why: String,
    },
    /// Refused, in the words of the service.
    #[error("{0}")]
    Refused(String),
    /// Certificate or token of the configuration.
    #[error("{0}")]
    Configuration(String),
}

impl Caller {
    /// Of the page of this configuration.
    ///
    /// # Errors
    /// A certificate or token that cannot be read.
    pub fn new(page: &PageConfig) -> Result<Self, CallError> {
        let lan = page.lan.as_ref().map(|lan| {
            let certificates = pem::certificates(&lan.certificate).map_err(CallError::Configuration)?;
            let token = credentials::value(&lan.token).map_err(CallError::Configuration)?;
            let connector = connector(certificates).map_err(|e| CallError::Configuration(e.to_string()))?;
            Ok((connector, token.trim().to_owned()))
        });
        Ok(Self { address: near(page.listen), lan: lan.transpose()? })
    }

    /// Where the service is.
    ///
    /// # Errors
    /// No service, or no answer.
    pub async fn status(&self) -> Result<PageStatus, CallError> {
        self.call(Method::GET, "/api/status", None).await
    }

    /// Which cycle begins next; empty: as the program says.
    ///
    /// # Errors
    /// No service, no answer, or a refusal.
    pub async fn choose(&self, cycle: &str) -> Result<PageStatus, CallError> {
        self.call(Method::POST, "/api/cycle/choose", Some(json!({ "cycle": cycle }))).await
    }

    /// Begins a cycle; empty: the one that serves every program.
    ///
    /// # Errors
    /// No service, no answer, or a refusal.
    pub async fn begin(&self, cycle: &str) -> Result<PageStatus, CallError> {
        self.call(Method::POST, "/api/cycle/begin", Some(json!({ "cycle": cycle }))).await
    }

    /// Ends the cycle that is measured.
    ///
    /// # Errors
    /// No service, no answer, or a refusal.
    pub async fn abort(&self) -> Result<PageStatus, CallError> {
        self.call(Method::POST, "/api/cycle/abort", None).await
    }

    async fn call(&self, method: Method, path: &str, body: Option<Value>) -> Result<PageStatus, CallError> {
        let answer = timeout(LONGEST, self.answer(method, path, body)).await;
        serde_json::from_value(answer.map_err(|_| CallError::Silent(self.address))??)
            .map_err(|error| self.stranger(&error))
    }

    async fn answer(&self, method: Method, path: &str, body: Option<Value>) -> Result<Value, CallError> {
        let not_there =
            |error: std::io::Error| CallError::NotThere { address: self.address, why: error.to_string() };
        let stream = TcpStream::connect(self.address).await.map_err(not_there)?;
        let request = self.request(method, path, body)?;
        match &self.lan {
            None => self.exchange(stream, request).await,
            Some((connector, _)) => {
                let name = ServerName::try_from(OWN_NAME).map_err(|error| self.stranger(&error))?;
                let stream = connector.connect(name, stream).await.map_err(|error| self.stranger(&error))?;
                self.exchange(stream, request).await
            }
        }
    }

    fn request(
        &self,
        method: Method,
        path: &str,
        body: Option<Value>,
    ) -> Result<Request<Full<Bytes>>, CallError> {
        let host = format!("{OWN_NAME}:{}", self.address.port());
        let mut request = Request::builder().method(method).uri(path).header(HOST, host);
        request = request.header(OWN_HEADER, "command").header(CONTENT_TYPE, "application/json");
        if let Some((_, token)) = &self.lan {
            request = request.header(AUTHORIZATION, format!("Bearer {token}"));
        }
        let body = body.map_or_else(Bytes::new, |body| Bytes::from(body.to_string()));
        request.body(Full::new(body)).map_err(|error| self.stranger(&error))
    }

    async fn exchange(
        &self,
        stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
        request: Request<Full<Bytes>>,
    ) -> Result<Value, CallError> {
        let (mut sender, connection) =
            http1::handshake(TokioIo::new(stream)).await.map_err(|error| self.stranger(&error))?;
        let (response, _) = tokio::join!(
            async move {
                let response = sender.send_request(request).await.map_err(|error| self.stranger(&error))?;
                let status = response.status();
                let body = Limited::new(response.into_body(), MOST_BYTES).collect().await;
                let body = body.map_err(|error| self.stranger(error.as_ref()))?.to_bytes();
                let answer: Value = serde_json::from_slice(&body).map_err(|error| self.stranger(&error))?;
                if status == StatusCode::OK { Ok(answer) } else { Err(refusal(status, &answer)) }
            },
            // The request reports what is wrong with the connection.
            async { drop(connection.await) },
        );
        response
    }

    fn stranger(&self, error: &(impl std::fmt::Display + ?Sized)) -> CallError {
        CallError::Stranger { address: self.address, why: error.to_string() }
    }
}

/// A service that listens everywhere also listens on this computer's own address.
fn near(listen: SocketAddr) -> SocketAddr {
    let own = match listen.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => IpAddr::V4(Ipv4Addr::LOCALHOST),
        IpAddr::V6(ip) if ip.is_unspecified() => IpAddr::V6(Ipv6Addr::LOCALHOST),
        other => other,
    };
    SocketAddr::new(own, listen.port())
}

fn refusal(status: StatusCode, answer: &Value) -> CallError {
    let why = answer["error"].as_str().map_or_else(|| status.to_string(), str::to_owned);
    CallError::Refused(why)
}

fn connector(certificates: Vec<CertificateDer<'static>>) -> Result<TlsConnector, Error> {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let verifier = Arc::new(ThisOne { certificates, provider: Arc::clone(&provider) });
    let config = ClientConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&rustls::version::TLS13])?
        .dangerous()
        .with_custom_certificate_verifier(verifier)
        .with_no_client_auth();
    Ok(TlsConnector::from(Arc::new(config)))
}

/// Accepts the first certificate of a file and no other; that the other side has its key is verified as ever.
#[derive(Debug)]
struct ThisOne {
    certificates: Vec<CertificateDer<'static>>,
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for ThisOne {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        _: &[CertificateDer<'_>],
        _: &ServerName<'_>,
        _: &[u8],
        _: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        match self.certificates.first() {
            Some(own) if own == end_entity => Ok(ServerCertVerified::assertion()),
            _ => Err(Error::InvalidCertificate(CertificateError::UnknownIssuer)),
        }
    }

    fn verify_tls12_signature(
        &self,
        _: &[u8],
        _: &CertificateDer<'_>,
        _: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        Err(Error::General("TLS 1.3 alone is offered".into()))
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let known = &self.provider.signature_verification_algorithms;
        verify_tls13_signature(message, certificate, signature, known)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}
