//! A day of the calendar, `2026-05-12`.

use std::fmt;
use std::str::FromStr;
use toml::value::Datetime;

/// A day that the calendar has; days are ordered as they follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Day {
    year: u16,
    month: u8,
    day: u8,
}

impl Day {
    /// Reads `YYYY-MM-DD`; `None` for any other text and for a day that no calendar has.
    pub fn parse(text: &str) -> Option<Self> {
        Self::of(Datetime::from_str(text).ok()?).filter(|day| day.to_string() == text)
    }

    /// The day of a date of TOML; `None` where that has a time too.
    pub(crate) fn of(date: Datetime) -> Option<Self> {
        match date {
            Datetime { date: Some(date), time: None, offset: None } => {
                Some(Self { year: date.year, month: date.month, day: date.day })
            }
            _ => None,
        }
    }
}

impl fmt::Display for Day {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_is_one_of_the_calendar_and_days_have_an_order() {
        assert!(Day::parse("2025-12-31") < Day::parse("2026-01-01"));
        assert_eq!(Day::parse("2024-02-29").map(|day| day.to_string()).as_deref(), Some("2024-02-29"));
        for wrong in ["2026-02-29", "2026-13-01", "12.05.2026", "2026-05-12T08:00:00Z", "2026-5-1", ""] {
            assert_eq!(Day::parse(wrong), None, "{wrong}");
        }
    }
}
