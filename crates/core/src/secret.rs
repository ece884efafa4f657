//! Passwords in hand-written files, and what remains of such a file when it leaves the computer.
//!
//! A password is given as `password = "…"` or, better, as `password_file = "NAME"`: a credential of systemd, or a file next to the
//! configuration. Nothing that is recorded, logged, shown or published holds one.

use crate::input::Table;
use crate::spans::{Spans, spans};
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

/// A password, or where it is. Its value is in no text of this program.
#[derive(Clone, PartialEq, Eq)]
pub enum Secret {
    /// As written in the configuration.
    Given(String),
    /// In a file.
    File {
        /// Name as written: of a credential, or a path.
        name: PathBuf,
        /// Folder of the configuration, to which a relative path is relative.
        folder: PathBuf,
    },
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret")
    }
}

impl Secret {
    /// Reads `password` or `password_file` of a table; both together are a problem.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let given = table.optional_string("password").map(Self::Given);
        let file = Self::read_file(table, "password_file");
        if given.is_some() && file.is_some() {
            table.problem("password", "is given twice", "password or password_file", "Keep password_file.");
        }
        file.or(given)
    }

    /// Reads a required address. Messages, recordings and pages show addresses, so one with a user or a password is a problem,
    /// whose text does not hold it.
    pub fn read_address(table: &Table<'_>, key: &str) -> Option<String> {
        let address = table.string(key)?;
        if !has_login(&address) {
            return Some(address);
        }
        table.problem(
            key,
            "holds a user or a password",
            "an address without them",
            "Messages and recordings show it. Give user and password_file in its table.",
        );
        None
    }

    /// Reads a key that names a file of a secret.
    pub fn read_file(table: &Table<'_>, key: &str) -> Option<Self> {
        let name = table.optional_string(key)?;
        Some(Self::File { name: name.into(), folder: table.folder() })
    }
}

/// Stands where a secret was; also a value that configurations accept.
const LEFT_OUT: &str = "left out";
/// Words of keys whose value is a secret, and of comments that may hold one.
const WORDS: [&str; 5] = ["password", "passphrase", "secret", "token", "credential"];

/// Shortest part behind a colon of a secret that counts as a password of its own, characters: a shorter one, as of `a:table`, is a word
/// that remarks use for other things.
const SHORTEST_PART: usize = 6;

/// A hand-written file without its secrets: values of keys that end in the word for one, users and passwords in addresses, and
/// comments that speak of either, repeat one or stand behind one. A text that is no TOML is left out whole.
pub fn redacted(text: &str) -> String {
    let Some(spans) = spans(text) else { return format!("# {LEFT_OUT}: not readable as TOML\n") };
    let mut cuts = of_values(text, &spans);
    let values: Vec<Range<usize>> = cuts.iter().map(|cut| cut.at.clone()).collect();
    let secrets: Vec<&str> = cuts
        .iter()
        .flat_map(|cut| {
            let secret = text[cut.at.clone()].trim_matches(['"', '\'']);
            // Of `user:password` the password alone too.
            let password = secret.split_once(':').map(|(_, password)| password);
            [Some(secret), password.filter(|part| cut.is_login || part.chars().count() >= SHORTEST_PART)]
        })
        .flatten()
        .filter(|secret| !secret.is_empty() && *secret != LEFT_OUT)
        .collect();
    for comment in comments(text, &spans.all()) {
        let written = &text[comment.clone()];
        let repeats = secrets.iter().any(|secret| written.contains(secret));
        let is_behind = |value: &Range<usize>| {
            text.get(value.end..comment.start).is_some_and(|between| !between.contains('\n'))
        };
        let written = written.to_lowercase().replace("password_file", "").replace("token_file", "");
        let speaks = WORDS.iter().any(|word| written.contains(word)) || !logins(&written).is_empty();
        if speaks || repeats || values.iter().any(is_behind) {
            cuts.push(Cut { at: comment, instead: format!("# {LEFT_OUT}"), is_login: false });
        }
    }
    cuts.sort_by_key(|cut| cut.at.start);
    let (mut out, mut from) = (String::with_capacity(text.len()), 0);
    for Cut { at, instead, .. } in cuts {
        out += &text[from..at.start];
        out += &instead;
        from = at.end;
    }
    out + &text[from..]
}

/// True for an address with a user or a password in it.
pub fn has_login(address: &str) -> bool {
    // A host has no scheme before its login.
    let of_host = !address.contains("://") && address.contains('@');
    of_host || !logins(address).is_empty()
}

/// True when a value of the text is a secret.
pub fn holds_secret(text: &str) -> bool {
    spans(text).is_some_and(|spans| !of_values(text, &spans).is_empty())
}

/// A place of a text, and what stands there instead.
struct Cut {
    at: Range<usize>,
    instead: String,
    is_login: bool,
}

/// Places of the values that are secrets.
fn of_values(text: &str, spans: &Spans) -> Vec<Cut> {
    let cuts = |(key, value): &(String, Range<usize>)| {
        if is_secret(key) {
            let instead = format!("\"{LEFT_OUT}\"");
            return vec![Cut { at: value.clone(), instead, is_login: false }];
        }
        let cut = |login: Range<usize>| Cut {
            at: value.start + login.start..value.start + login.end,
            instead: LEFT_OUT.replace(' ', "-"),
            is_login: true,
        };
        logins(&text[value.clone()]).into_iter().map(cut).collect()
    };
    spans.values.iter().flat_map(cuts).collect()
}

/// `password`, `mqtt_password`, `token`; not `password_file`, which says where it is.
fn is_secret(key: &str) -> bool {
    let key = key.to_lowercase();
    WORDS.iter().any(|word| key.ends_with(word))
}

/// `user:password` of each address `scheme://user:password@host`.
fn logins(text: &str) -> Vec<Range<usize>> {
    let starts: Vec<_> = text.match_indices("://").map(|(at, sign)| at + sign.len()).collect();
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    starts.iter().zip(ends).filter_map(|(&start, end)| login(&text[start..end], start)).collect()
}

/// The login of one address without its scheme, which begins at `start` of the whole.
///
/// Host and port end before the first of `/ ? #`, a space or a quote (RFC 3986, section 3.2). What follows a colon there and is no
/// port is the beginning of a password that holds such a sign: its login goes on to the last `@`.
fn login(address: &str, start: usize) -> Option<Range<usize>> {
    let authority = &address[..address.find(['/', '?', '#', '"', '\'', ' ']).unwrap_or(address.len())];
    let port = authority.rsplit_once(':').map_or("", |(_, port)| port.trim_end_matches(']'));
    let is_host = port.chars().all(|sign| sign.is_ascii_digit()) || authority.contains('[');
    let end = authority.rfind('@').or_else(|| address.rfind('@').filter(|_| !is_host))?;
    Some(start..start + end)
}

/// Everything from a `#` outside of keys and values to the end of its line.
fn comments(text: &str, taken: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut comments: Vec<Range<usize>> = Vec::new();
    for (at, _) in text.match_indices('#') {
        let inside = |span: &Range<usize>| span.contains(&at);
        if taken.iter().any(inside) || comments.last().is_some_and(inside) {
            continue;
        }
        let end = text[at..].find(['\n', '\r']).map_or(text.len(), |length| at + length);
        comments.push(at..end);
    }
    comments
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Document;

    const FILE: &str = r##"format = "x/1"  # the password is 'hunter2'
name = "a # b"
# password = "hunter2"
[mqtt]
host = "broker"     # in the office
user = "cell"
password = "hunter2"
[[device]]
address = "http://cell:hunter2@cnc:5000/sample?a=b@c"
nested = { connection_password = 'hunter2', rate = 1 }
password_file = "cnc"
text = """
# not a comment, hunter-free
"""
"##;

    #[test]
    fn what_follows_a_colon_is_a_password_in_a_login_and_where_it_is_long() {
        for key in ["credential", "password", "token"] {
            let out = redacted(&format!("{key} = \"ada:hunter2\"\n# hunter2 is Ada's\n# ada is at home\n"));
            assert!(!out.contains("hunter2") && out.contains("# ada is at home"), "{out}");
        }
        let text = "token = \"a:table\"\n# of the table\nurl = \"http://u:hut@cnc\"\n# the hut is cold\n";
        let out = redacted(text);
        assert!(out.contains("# of the table"), "{out}");
        assert!(!out.contains("hut"), "{out}");
    }

    #[test]
    fn no_secret_remains_and_everything_else_does() {
        let out = redacted(FILE);
        assert!(!out.contains("hunter2"), "{out}");
        for kept in [
            "name = \"a # b\"",
            "# in the office",
            "user = \"cell\"",
            "password = \"left out\"",
            "http://left-out@cnc:5000/sample?a=b@c",
            "rate = 1",
            "password_file = \"cnc\"",
            "# not a comment, hunter-free",
        ] {
            assert!(out.contains(kept), "{kept} in {out}");
        }
        assert!(Document::parse("again", &out).is_ok(), "{out}");
        assert_eq!(redacted(&out), out, "nothing is left to take out");
        let where_it_is = "# password_file = \"cnc\" is better\nport = 1\n";
        assert_eq!(redacted(where_it_is), where_it_is);
        assert!(holds_secret(FILE) && !holds_secret(where_it_is));
        assert!(!redacted("password = \"hunter2").contains("hunter2"));
    }

    #[test]
    fn every_login_of_every_address_is_left_out() {
        for (address, kept) in [
            ("http://cell:hunter2@cnc:5000/a?b=c@d", "http://left-out@cnc:5000/a?b=c@d"),
            ("http://cell:hun/ter2@cnc", "http://left-out@cnc"),
            ("http://cell:hun?ter 2@cnc/x", "http://left-out@cnc/x"),
            ("http://cell:h@unter2@cnc", "http://left-out@cnc"),
            ("http://a, http://cell:hunter2@b", "http://a, http://left-out@b"),
            ("http://x:hunter2@a http://y:hunter2@b", "http://left-out@a http://left-out@b"),
        ] {
            assert_eq!(redacted(&format!("a = \"{address}\"")), format!("a = \"{kept}\""));
            assert!(!redacted(&format!("# {address}")).contains("ter"));
            let text = format!("url = \"{address}\"");
            let document = Document::parse("trunnion.toml", &text).unwrap();
            assert_eq!(Secret::read_address(&document.root(), "url"), None);
            let problem = document.finish(None::<()>).unwrap_err().to_string();
            assert!(
                problem.contains("url holds a user or a password") && !problem.contains("ter2"),
                "{problem}"
            );
        }
        let document = Document::parse("trunnion.toml", "host = \"cell:hunter2@broker\"").unwrap();
        assert_eq!(Secret::read_address(&document.root(), "host"), None, "a host has no scheme");
        for address in
            ["http://cnc:5000/a@b", "opc.tcp://[fe80::1]:4840", "http://[fe80::1:ab]/a@b", "linuxcnc://cnc"]
        {
            let text = format!("url = \"{address}\"");
            assert_eq!(redacted(&text), text);
            let document = Document::parse("trunnion.toml", &text).unwrap();
            assert_eq!(Secret::read_address(&document.root(), "url").as_deref(), Some(address));
        }
    }

    #[test]
    fn a_comment_that_repeats_a_secret_or_stands_behind_one_is_left_out() {
        let text = "# it is hunter2\n[mqtt]\npassword = 'hunter2' # hunter1 before\nport = 1 # usual\nurl = \"http://a:b@c\" # b\n";
        let out = redacted(text);
        let expected = "# left out\n[mqtt]\npassword = \"left out\" # left out\nport = 1 # usual\nurl = \"http://left-out@c\" # left out\n";
        assert_eq!(out, expected);
        assert_eq!(redacted(&out), out, "nothing is left to take out");
        let of_login = redacted("# it is hunter2\nurl = \"http://cell:hunter2@c\"\n# cell 2\n");
        assert_eq!(of_login, "# left out\nurl = \"http://left-out@c\"\n# cell 2\n");
    }

    #[test]
    fn a_secret_shows_nothing_when_it_is_printed() {
        let document = Document::parse("/etc/trunnion/trunnion.toml", FILE).unwrap();
        let given = Secret::read(&document.root().table("mqtt").unwrap()).unwrap();
        assert_eq!(given, Secret::Given("hunter2".into()));
        assert_eq!(format!("{given:?}"), "Secret");
        let file = Secret::read(&document.root().tables("device")[0]).unwrap();
        assert_eq!(file, Secret::File { name: "cnc".into(), folder: "/etc/trunnion".into() });
    }
}
