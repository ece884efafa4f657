//! What an agent answers, and why an answer is not taken.

use crate::session_end::SessionEnd;
use trunnion_protocol::mtconnect;
use trunnion_protocol::mtconnect::Document;

/// Reads a document.
///
/// # Errors
/// `Protocol`: bytes that are none.
pub(super) fn parse(body: &[u8]) -> Result<Document, SessionEnd> {
    mtconnect::parse(body)
        .map_err(|error| SessionEnd::Protocol { doing: "reading a document", fault: error.to_string() })
}

/// A document that is not the one asked for.
pub(super) fn unexpected(doing: &'static str, document: &Document) -> SessionEnd {
    let fault = match document {
        Document::Error(error) => {
            let words = error.errors.iter().map(|error| format!("{}: {}", error.code, error.text));
            words.collect::<Vec<_>>().join("; ")
        }
        Document::Devices(_) => "the agent sent a devices document".into(),
        Document::Streams(_) => "the agent sent a streams document".into(),
    };
    SessionEnd::Protocol { doing, fault }
}
