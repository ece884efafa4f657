//! Who we are for a web server that asks for user and password: Basic, RFC 7617.
//!
//! credentials = "Basic " base64(user ":" password), both in UTF-8         [RFC 7617 §2]
//!
//! Sent with each request, and in no text. A user has no colon, neither has a control character [RFC 7617 §2].

use crate::credentials;
use crate::session_end::SessionEnd;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hyper::header::{HeaderValue, WWW_AUTHENTICATE};
use hyper::{HeaderMap, StatusCode};
use trunnion_core::Secret;
use trunnion_core::input::Table;

/// User and password of a web server.
#[derive(Clone, Debug)]
pub struct HttpLogin {
    user: String,
    password: Secret,
}

impl HttpLogin {
    /// Reads `user` with `password_file` or `password`; neither is no login.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let (user, password) = credentials::read_login(table)?;
        if user.is_empty() || user.contains(':') || user.chars().any(char::is_control) {
            table.problem("user", "cannot be sent", "a name without colon and control characters", "");
            return None;
        }
        Some(Self { user, password })
    }

    /// The value of `Authorization`; the password is read now, for its file may have been mended.
    pub(super) fn authorization(&self, server: &str) -> Result<HeaderValue, SessionEnd> {
        let refused = |why| SessionEnd::Refused { address: server.to_owned(), why };
        let password = credentials::value(&self.password).map_err(refused)?;
        if password.chars().any(char::is_control) {
            return Err(refused("the password holds a control character, which Basic cannot send".into()));
        }
        let coded = STANDARD.encode(format!("{}:{password}", self.user));
        let value = HeaderValue::try_from(format!("Basic {coded}"));
        let mut value = value.map_err(|_| refused("user and password make no header".into()))?;
        value.set_sensitive(true);
        Ok(value)
    }
}

/// What an answer says of who we are; `None` where it lets us in.
pub(super) fn refusal(login: Option<&HttpLogin>, status: StatusCode, headers: &HeaderMap) -> Option<String> {
    let why = match (status, login) {
        (StatusCode::UNAUTHORIZED, _) if !offers_basic(headers) => {
            "the agent asks for a login other than user and password (HTTP Basic), and no other is supported: set its web server \
             to Basic"
                .into()
        }
        (StatusCode::UNAUTHORIZED, None) => {
            "the agent asks for a user and a password: give `user` and `password_file`".into()
        }
        (StatusCode::UNAUTHORIZED, Some(HttpLogin { user, .. })) => {
            format!("the agent refuses user {user}: check `user` and `password_file`")
        }
        (StatusCode::FORBIDDEN, Some(HttpLogin { user, .. })) => {
            format!("the agent lets user {user} read nothing: check the rights of the user")
        }
        (StatusCode::FORBIDDEN, None) => {
            "the agent does not let us read: give `user` and `password_file`, or let this computer in".into()
        }
        _ => return None,
    };
    Some(why)
}

/// A server that names no kind is taken for one that means this one.
fn offers_basic(headers: &HeaderMap) -> bool {
    let mut kinds = headers.get_all(WWW_AUTHENTICATE).iter().filter_map(|kind| kind.to_str().ok()).peekable();
    kinds.peek().is_none() || kinds.any(|kind| kind.to_ascii_lowercase().contains("basic"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_core::input::Document;

    fn read(text: &str) -> Result<Option<HttpLogin>, String> {
        let document = Document::parse("trunnion.toml", text).unwrap();
        let login = HttpLogin::read(&document.root());
        document.finish(Some(login)).map_err(|problems| problems.to_string())
    }

    #[test]
    fn the_header_is_that_of_the_standard_and_is_in_no_text() {
        // RFC 7617 section 2, and section 2.1 with a pound sign in UTF-8.
        for (user, password, expected) in [
            ("Aladdin", "open sesame", "Basic QWxhZGRpbjpvcGVuIHNlc2FtZQ=="),
            ("test", "123£", "Basic dGVzdDoxMjPCow=="),
        ] {
            let login = read(&format!("user = \"{user}\"\npassword = \"{password}\"")).unwrap().unwrap();
            let value = login.authorization("http://cnc").unwrap();
            assert_eq!(value.to_str().unwrap(), expected);
            let shown = format!("{value:?} {login:?}");
            assert!(!shown.contains(password) && !shown.contains(expected), "{shown}");
        }
    }

    #[test]
    fn half_a_login_and_a_user_that_cannot_be_sent_are_problems() {
        assert!(read("").unwrap().is_none());
        for text in ["user = \"cell\"", "password_file = \"cnc\"", "user = \"a:b\"\npassword = \"x\""] {
            assert!(read(text).unwrap_err().contains("user "), "{text}");
        }
    }

    #[test]
    fn a_refusal_says_what_to_do() {
        let login = read("user = \"cell\"\npassword = \"x\"").unwrap().unwrap();
        let mut digest = HeaderMap::new();
        digest.insert(WWW_AUTHENTICATE, HeaderValue::from_static("Digest realm=\"cnc\""));
        for (login, status, headers, words) in [
            (Some(&login), StatusCode::UNAUTHORIZED, HeaderMap::new(), "the agent refuses user cell: check"),
            (None, StatusCode::UNAUTHORIZED, HeaderMap::new(), "give `user` and `password_file`"),
            (Some(&login), StatusCode::UNAUTHORIZED, digest, "set its web server to Basic"),
            (Some(&login), StatusCode::FORBIDDEN, HeaderMap::new(), "rights of the user"),
        ] {
            let why = refusal(login, status, &headers).unwrap();
            assert!(why.contains(words), "{why}");
        }
        assert_eq!(refusal(None, StatusCode::OK, &HeaderMap::new()), None);
    }
}
