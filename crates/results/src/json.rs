//! Answers as text.

/// JSON as the program writes it: indented, with a final newline.
///
/// # Errors
/// A value that JSON cannot hold; the types of this crate are none.
pub fn to_json(answer: &impl serde::Serialize) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(answer).map(|text| text + "\n")
}

/// The same on one line, for answers that come one after the other.
///
/// # Errors
/// As [`to_json`].
pub fn to_json_line(answer: &impl serde::Serialize) -> Result<String, serde_json::Error> {
    serde_json::to_string(answer).map(|text| text + "\n")
}
