//! Texts of this program in values that are written and read back: what is read is the text as this program has it, for the life of the
//! process. Whoever reads has made sure that this program wrote it: their number is then that of its texts.

use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// A text of this program: a symbol, a reason of the catalogue. Under a name of its own because serde would have a `&str` live as long as the
/// text that is read.
pub type FixedText = &'static str;

/// Texts that are known at most: the catalogue has some hundred.
const MOST: usize = 4096;

/// Reads such a text, for `#[serde(deserialize_with)]`.
///
/// # Errors
/// No text, or more different ones than this program has.
pub fn fixed_text<'de, D: Deserializer<'de>>(from: D) -> Result<FixedText, D::Error> {
    static KNOWN: Mutex<BTreeSet<FixedText>> = Mutex::new(BTreeSet::new());
    let text = String::deserialize(from)?;
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(same) = known.get(text.as_str()) {
        return Ok(same);
    }
    if known.len() == MOST {
        return Err(D::Error::custom("these are not texts of this program"));
    }
    let text: FixedText = text.leak();
    known.insert(text);
    Ok(text)
}
