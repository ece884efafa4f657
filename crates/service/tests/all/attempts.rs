//! What somebody else may try against the page, and what he gets: docs/measured/page.md.

use crate::page::{ADD, OWN, Page};
use crate::section;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, ServerName};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use trunnion_service::config::{Config, PageConfig};
use trunnion_service::page::Access;

pub const TOKEN: &str = "cW5vdGhlci10b2tlbi1mb3ItdGVzdHM";
const NAME: &str = "cell-4.lan";
const LIMIT: Duration = Duration::from_secs(60);

fn first_line(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    let shown = |c: char| if c.is_control() { '?' } else { c };
    let short: String = line.chars().take(140).map(shown).collect();
    if short.len() < line.len() { short + " …" } else { short }
}

#[tokio::test]
async fn every_attempt_is_refused_and_the_model_stays_as_it_is() {
    let page = Page::open().await;
    let by = r#"{"by":"Mallory"}"#;
    let large = format!(r#"{{"by":"{}"}}"#, "x".repeat(100_000));
    let long = format!(r#"{{"by":"{}"}}"#, "x".repeat(100));
    let port = page.at.port();
    let foreign = format!("Host: attacker.example:{port}\r\n");
    let other_port = "Host: 127.0.0.1:1\r\n";
    let with = |more: &str| format!("{OWN}{more}");
    let attempts: &[(&str, &str, &str, &str, u16)] = &[
        ("DNS rebinding: a foreign name", "GET /api/runs", &foreign, "", 421),
        ("another port of this computer", "GET /api/runs", other_port, "", 421),
        ("a script of another page reads", "GET /api/runs", "Origin: http://attacker.example\r\n", "", 403),
        ("an image of another page", "GET /api/runs", "Sec-Fetch-Site: cross-site\r\n", "", 403),
        ("a page in a sandbox", "GET /api/runs", "Origin: null\r\n", "", 403),
        ("CSRF: a form", ADD, "Content-Type: text/plain\r\n", by, 403),
        ("CSRF: a script", ADD, &with("Origin: http://attacker.example\r\n"), by, 403),
        ("CSRF: another port", ADD, &with("Origin: http://127.0.0.1:1\r\n"), by, 403),
        ("CORS is asked", "OPTIONS /api/runs", "Origin: http://attacker.example\r\n", "", 403),
        ("removing by a form", "DELETE /api/runs/points-gravity/model/gravity-sag:B", "", "", 403),
        ("a path upwards", "GET /api/runs/..%2fsecret", "", "", 404),
        ("an absolute path", "GET /api/runs/%2fetc%2fpasswd", "", "", 404),
        ("a file next to the runs", "GET /api/runs/secret", "", "", 404),
        ("a zero byte", "GET /api/runs/points-gravity%00", "", "", 404),
        ("an asset upwards", "GET /assets/..%2f..%2fCargo.toml", "", "", 404),
        ("a path upwards, plain", "GET /assets/../../../../etc/passwd", "", "", 404),
        ("a large body", ADD, OWN, &large, 400),
        ("no name", ADD, OWN, r#"{"by":" "}"#, 400),
        ("a long name", ADD, OWN, &long, 400),
        ("a name with a line feed", ADD, OWN, r#"{"by":"a\nb"}"#, 400),
        ("another key", ADD, OWN, r#"{"by":"a","path":"/etc/passwd"}"#, 400),
        ("no JSON", ADD, OWN, "by=a", 400),
        ("an effect that is none", "POST /api/runs/points-gravity/model/..%2fx", OWN, by, 422),
        ("no such call", "POST /api/run-command", OWN, by, 404),
    ];
    let mut rows = String::from("| attempt | call | got |\n|---|---|---|\n");
    for (name, line, headers, body, expected) in attempts {
        let (status, answer) = page.ask(line, headers, body).await;
        let got = answer.split_once("\r\n\r\n").map_or("", |(_, body)| body);
        assert_eq!(status, *expected, "{name}: {answer}");
        assert!(!got.contains("root:") && !got.contains("[package]"), "{name}: {got}");
        assert!(!answer.to_lowercase().contains("access-control-allow"), "{name}: {answer}");
        let why = serde_json::from_str::<Value>(got).unwrap_or_default();
        let why = why["error"].as_str().unwrap_or_default().replace('|', "/");
        rows += &format!("| {name} | `{line}` | {status}: {} |\n", first_line(&why));
    }
    section::write_or_compare("docs/measured/page.md", "attempts on this computer", &rows);
    let left: Vec<_> = std::fs::read_dir(page.folder.path().join("points-gravity"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(left.len(), 2, "nothing was written: {left:?}");
}

/// Who other computers' calls are let in by, from a configuration in a folder of its own.
fn lan(folder: &Path, token: &str) -> Result<Access, String> {
    Access::of_lan(&page_of_lan(folder, token).lan.unwrap()).map_err(|error| error.to_string())
}

/// The table `[page]` of the example for other computers.
pub fn page_of_lan(folder: &Path, token: &str) -> PageConfig {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    for file in ["page.crt", "page.key"] {
        std::fs::copy(data.join(file), folder.join(file)).unwrap();
    }
    std::fs::write(folder.join("page-token"), format!("{token}\n")).unwrap();
    // The example has the lines of the table behind remarks.
    let example = include_str!("../../../../config/trunnion.toml");
    let (before, page) = example.split_once("[page]").unwrap();
    let (page, behind) = page.split_at(page.find("\n[").unwrap_or(page.len()));
    let page = page
        .replace("listen = \"127.0.0.1:8460\"", "listen = \"192.168.1.20:8460\"")
        .replace("# names =", "names =")
        .replace("# certificate =", "certificate =")
        .replace("# key_file =", "key_file =")
        .replace("# token_file =", "token_file =");
    let text = format!("{before}[page]{page}{behind}");
    Config::parse(&folder.join("trunnion.toml"), &text).unwrap().page.unwrap()
}

/// Status and answer of a request over TLS that trusts the page's certificate.
async fn ask(page: &Page, line: &str, headers: &str, body: &str) -> (u16, String) {
    let certificate = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/page.crt");
    let mut roots = rustls::RootCertStore::empty();
    roots.add(CertificateDer::from_pem_file(certificate).unwrap()).unwrap();
    let config =
        rustls::ClientConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_root_certificates(roots)
            .with_no_client_auth();
    let stream = TcpStream::connect(page.at).await.unwrap();
    let name = ServerName::try_from(NAME).unwrap();
    let mut stream = TlsConnector::from(Arc::new(config)).connect(name, stream).await.unwrap();
    let host = format!("Host: {NAME}:{}\r\n", page.at.port());
    let host = if headers.contains("Host:") { String::new() } else { host };
    let length = body.len();
    let text = format!(
        "{line} HTTP/1.1\r\n{host}{headers}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}"
    );
    stream.write_all(text.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    tokio::time::timeout(LIMIT, stream.read_to_end(&mut answer)).await.unwrap().ok();
    let answer = String::from_utf8_lossy(&answer).into_owned();
    (answer.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0), answer)
}

#[tokio::test]
async fn another_computer_needs_the_token_and_gets_nothing_without_tls() {
    let folder = tempfile::tempdir().unwrap();
    let page = Page::open_for(lan(folder.path(), TOKEN).unwrap()).await;
    let bearer = format!("Authorization: Bearer {TOKEN}\r\n");
    let wrong = "Authorization: Bearer cW5vdGhlci10b2tlbi1mb3ItdGVzdHN\r\n";
    let token = format!(r#"{{"token":"{TOKEN}"}}"#);
    let port = page.at.port();
    let with = |more: &str| format!("{OWN}{more}");
    let right_by_mallory = with(&format!("{bearer}Origin: https://attacker.example\r\n"));
    let unencrypted_origin = with(&format!("{bearer}Origin: http://{NAME}:{port}\r\n"));
    let foreign = format!("{bearer}Host: attacker.example:{port}\r\n");
    let attempts: &[(&str, &str, &str, &str, u16)] = &[
        ("no token", "GET /api/runs", "", "", 401),
        ("a wrong token", "GET /api/runs", wrong, "", 401),
        ("an empty token", "GET /api/runs", "Authorization: Bearer \r\n", "", 401),
        ("a cookie of his own", "GET /api/runs", "Cookie: trunnion=00\r\n", "", 401),
        ("the token as a cookie", "GET /api/runs", &format!("Cookie: trunnion={TOKEN}\r\n"), "", 401),
        ("watching without a token", "GET /api/live", "", "", 401),
        ("adding without a token", ADD, OWN, r#"{"by":"Mallory"}"#, 401),
        ("beginning a cycle without a token", "POST /api/cycle/begin", OWN, r#"{"cycle":""}"#, 401),
        ("logging in with a wrong token", "POST /api/login", OWN, r#"{"token":"guess"}"#, 401),
        ("logging in by a form", "POST /api/login", "Content-Type: text/plain\r\n", &token, 403),
        ("the token, from another page", ADD, &right_by_mallory, r#"{"by":"Mallory"}"#, 403),
        ("the token, from an unencrypted page", ADD, &unencrypted_origin, r#"{"by":"Mallory"}"#, 403),
        ("DNS rebinding with the token", "GET /api/runs", &foreign, "", 421),
        ("the token", "GET /api/runs", &bearer, "", 200),
    ];
    let mut rows = String::from("| attempt | call | got |\n|---|---|---|\n");
    for (name, line, headers, body, expected) in attempts {
        let (status, answer) = ask(&page, line, headers, body).await;
        assert_eq!(status, *expected, "{name}: {answer}");
        let got = answer.split_once("\r\n\r\n").map_or("", |(_, body)| body);
        let why = serde_json::from_str::<Value>(got).unwrap_or_default();
        let why = why["error"].as_str().unwrap_or("the list").to_owned();
        rows += &format!("| {name} | `{line}` | {status}: {} |\n", first_line(&why));
        assert!(!answer.contains(TOKEN), "{name}: {answer}");
    }
    // Who is refused takes no call of others, and holds up no login.
    let flood = async |line, body, least| {
        let (begun, mut refused) = (Instant::now(), 0);
        loop {
            let (status, _) = ask(&page, line, OWN, body).await;
            match status {
                429 => break,
                401 => refused += 1,
                other => panic!("{line}: {other}"),
            }
            assert!(begun.elapsed() < LIMIT, "guesses follow each other at will: {line}");
        }
        assert!(refused >= least, "{line}: too many after {refused} calls");
        refused
    };
    // 200 and 20 at once; the attempts above took some of them.
    flood("GET /api/runs", "", 180).await;
    let (status, answer) = ask(&page, "POST /api/login", OWN, &token).await;
    assert!(status == 200 && answer.to_lowercase().contains("content-type: application/json"), "{answer}");
    let begun = Instant::now();
    let guesses = flood("POST /api/login", r#"{"token":"guess"}"#, 15).await;
    assert!(guesses as f64 <= 20.0 + begun.elapsed().as_secs_f64(), "{guesses}");
    let (status, _) = ask(&page, "GET /api/runs", &bearer, "").await;
    assert_eq!(status, 200);
    rows += "| calls without a token and wrong logins as fast as they go, then a call with it | `GET /api/runs`, `POST /api/login` | 401, then 429 as they are too many; then 200: the list |\n";
    // Without TLS not a byte of an answer.
    let (status, answer) = page.ask("GET /api/runs", &bearer, "").await;
    assert!(status == 0 && !answer.contains("runs"), "{answer}");
    rows += "| no TLS | `GET /api/runs` | the connection ends without an answer |\n";
    section::write_or_compare("docs/measured/page.md", "attempts from another computer", &rows);

    // A browser: what the page shows before the token, then the cookie.
    assert_eq!(ask(&page, "GET /", "", "").await.0, 200);
    let (mut status, mut answer) = (429, String::new());
    // The guesses took the logins of this address; there is one more a second.
    while status == 429 && begun.elapsed() < LIMIT {
        (status, answer) = ask(&page, "POST /api/login", OWN, &token).await;
    }
    assert_eq!(status, 200, "{answer}");
    let cookie = answer.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap();
    for part in ["HttpOnly", "Secure", "SameSite=Strict"] {
        assert!(cookie.contains(part), "{cookie}");
    }
    let cookie = format!("Cookie: other=1; {}\r\n", cookie.split(';').next().unwrap());
    assert_eq!(ask(&page, "GET /api/runs", &cookie, "").await.0, 200);
}

#[test]
fn a_token_that_can_be_guessed_and_half_a_configuration_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let short = lan(folder.path(), "secret").err().unwrap();
    assert!(short.contains("6 characters") && !short.contains("secret"), "{short}");
    let text = include_str!("../../../../config/trunnion.toml").replace("# token_file =", "token_file =");
    let problems = Config::parse(&folder.path().join("trunnion.toml"), &text).unwrap_err().to_string();
    assert!(problems.contains("page.certificate is missing"), "{problems}");
    assert!(problems.contains("page.key_file is missing"), "{problems}");
}
