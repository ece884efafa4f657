//! What a line with a value looks like.
//!
//! | in the pattern | stands for |
//! |---|---|
//! | `{value}` | a decimal number; blanks may follow its sign |
//! | `{unit}` | the word or sign that follows, perhaps none |
//! | `#` | one digit |
//! | `?` | one character |
//! | `*` | anything up to the end |
//! | blank | any number of blanks, also none |
//! | any other character | itself |

use std::str::FromStr;
use thiserror::Error;

/// A pattern, ready to match.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Piece {
    Value,
    Unit,
    Digit,
    Any,
    Rest,
    Blanks,
    Exactly(char),
}

/// Why a text is no pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PatternError {
    /// There is no place for the value, or more than one.
    #[error("a pattern holds {{value}} exactly once; \"GN##,{{value}}\" is one")]
    Value,
    /// `*` is not at the end.
    #[error("* stands for everything up to the end of the line, so it can only come last")]
    Rest,
}

/// A decimal number as sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Number {
    /// All digits as one whole number, with the sign.
    pub digits: i64,
    /// How many of them stand behind the point.
    pub decimals: u32,
}

impl Number {
    /// The number.
    pub fn value(self) -> f64 {
        self.digits as f64 / 10f64.powi(self.decimals as i32)
    }
}

/// More digits than any display has; they fit an `i64`.
const MOST_DIGITS: usize = 15;

impl FromStr for Pattern {
    type Err = PatternError;

    fn from_str(text: &str) -> Result<Self, PatternError> {
        let mut pieces = Vec::new();
        let mut rest = text;
        while let Some(letter) = rest.chars().next() {
            let (piece, length) = match letter {
                _ if rest.starts_with("{value}") => (Piece::Value, "{value}".len()),
                _ if rest.starts_with("{unit}") => (Piece::Unit, "{unit}".len()),
                '#' => (Piece::Digit, 1),
                '?' => (Piece::Any, 1),
                '*' => (Piece::Rest, 1),
                ' ' => (Piece::Blanks, 1),
                letter => (Piece::Exactly(letter), letter.len_utf8()),
            };
            pieces.push(piece);
            rest = &rest[length..];
        }
        if pieces.iter().filter(|piece| **piece == Piece::Value).count() != 1 {
            return Err(PatternError::Value);
        }
        if pieces.iter().rev().skip(1).any(|piece| *piece == Piece::Rest) {
            return Err(PatternError::Rest);
        }
        Ok(Self { pieces })
    }
}

impl Pattern {
    /// The value and the unit word of a line; `None` when the line does not look like this.
    pub fn read<'a>(&self, line: &'a str) -> Option<(Number, &'a str)> {
        let (mut number, mut unit, mut rest) = (None, "", line);
        for piece in &self.pieces {
            rest = match piece {
                Piece::Value => {
                    let (found, rest) = number_at(rest)?;
                    number = Some(found);
                    rest
                }
                Piece::Unit => {
                    let end = rest.find(|c: char| !c.is_ascii_alphabetic() && c != '"').unwrap_or(rest.len());
                    unit = &rest[..end];
                    &rest[end..]
                }
                Piece::Digit => rest.strip_prefix(|c: char| c.is_ascii_digit())?,
                Piece::Any => rest.strip_prefix(|_| true)?,
                Piece::Rest => "",
                Piece::Blanks => rest.trim_start(),
                Piece::Exactly(letter) => rest.strip_prefix(*letter)?,
            };
        }
        if !rest.trim_end().is_empty() {
            return None;
        }
        number.map(|number| (number, unit))
    }

    /// A line that looks like this: what a device would send for the value in `width` characters.
    pub fn write(&self, value: &str, unit: &str) -> String {
        let piece = |piece: &Piece| match piece {
            Piece::Value => value.to_owned(),
            Piece::Unit => unit.to_owned(),
            Piece::Digit => "0".to_owned(),
            Piece::Any => "N".to_owned(),
            Piece::Rest => String::new(),
            Piece::Blanks => " ".to_owned(),
            Piece::Exactly(letter) => letter.to_string(),
        };
        self.pieces.iter().map(piece).collect()
    }
}

/// The number a text begins with, and what follows it.
fn number_at(text: &str) -> Option<(Number, &str)> {
    let text = text.trim_start();
    let negative = text.starts_with('-');
    let text = text.strip_prefix(['+', '-']).map_or(text, str::trim_start);
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (written, rest) = text.split_at(end);
    let (whole, fraction) = written.split_once('.').unwrap_or((written, ""));
    let count = whole.len() + fraction.len();
    if count == 0 || count > MOST_DIGITS || fraction.contains('.') {
        return None;
    }
    let magnitude: i64 = format!("{whole}{fraction}").parse().ok()?;
    let digits = if negative { -magnitude } else { magnitude };
    Some((Number { digits, decimals: fraction.len() as u32 }, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_takes_lines_that_look_like_it_and_no_others() {
        let check = |pattern: &str, line: &str, expected: Option<(i64, u32, &str)>| {
            let found = pattern.parse::<Pattern>().unwrap().read(line);
            let expected = expected.map(|(digits, decimals, unit)| (Number { digits, decimals }, unit));
            assert_eq!(found, expected, "{pattern:?} {line:?}");
        };
        check("{value}", "+01.2500", Some((12500, 4, "")));
        check("{value}", "- 5.23 ", Some((-523, 2, "")));
        check("{value}", "12", Some((12, 0, "")));
        check("{value}", ".000125", Some((125, 6, "")));
        check("{value}", "1.2.3", None);
        check("{value}", "", None);
        check("{value}", "+", None);
        check("{value}", "1.0 mm", None);
        check("GN##,{value}", "GN07,-0016.2345", Some((-162_345, 4, "")));
        check("GN##,{value}", "GNx7,-0016.2345", None);
        check("# {value} {unit} *", "1 +003.25 um = <", Some((325, 2, "um")));
        check("# {value} {unit} *", "1 +003.25", Some((325, 2, "")));
        check("{value} {unit}", "1234567890123456", None);
    }

    #[test]
    fn a_pattern_without_a_place_for_the_value_is_refused() {
        assert_eq!("GN##".parse::<Pattern>(), Err(PatternError::Value));
        assert_eq!("{value}{value}".parse::<Pattern>(), Err(PatternError::Value));
        assert_eq!("*{value}".parse::<Pattern>(), Err(PatternError::Rest));
    }
}
