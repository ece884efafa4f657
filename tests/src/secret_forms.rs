//! The codings in which a program may write a secret.

use base64::Engine;
use base64::engine::general_purpose::{STANDARD_NO_PAD, URL_SAFE_NO_PAD};

/// A secret of letters and digits as each of them has it, with its name. Every coding of text leaves these signs as they are, or is here.
pub fn forms(secret: &str) -> Vec<(&'static str, String)> {
    let each = |write: fn(u8) -> String| secret.bytes().map(write).collect::<String>();
    let mut forms = vec![
        ("plain", secret.into()),
        ("percent-encoded", each(|byte| format!("%{byte:02X}"))),
        ("percent-encoded in small letters", each(|byte| format!("%{byte:02x}"))),
        ("hexadecimal", each(|byte| format!("{byte:02x}"))),
        ("hexadecimal in capitals", each(|byte| format!("{byte:02X}"))),
        ("as a list of numbers", secret.bytes().map(|byte| byte.to_string()).collect::<Vec<_>>().join(", ")),
        (
            "as a list of numbers in JSON",
            secret.bytes().map(|byte| byte.to_string()).collect::<Vec<_>>().join(","),
        ),
        ("UTF-16", secret.chars().flat_map(|sign| [sign, '\0']).collect()),
        ("backwards", secret.chars().rev().collect()),
    ];
    // Three bytes are four signs: where the secret begins within a longer text decides how it looks.
    for before in 0..3 {
        let bytes = [&[0; 2][..before], secret.as_bytes()].concat();
        let whole = (8 * before).div_ceil(6)..8 * bytes.len() / 6;
        for engine in [&STANDARD_NO_PAD, &URL_SAFE_NO_PAD] {
            forms.push(("base64", engine.encode(&bytes)[whole.clone()].into()));
        }
    }
    forms
}
