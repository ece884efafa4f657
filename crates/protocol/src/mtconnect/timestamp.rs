//! ISO 8601 time stamps, `2010-04-06T06:19:35.153141Z`, as nanoseconds since 1970-01-01 UTC without leap seconds.
//! Any number of fraction digits (beyond nine cut off); `Z`, an offset `±hh:mm`, or nothing, which agents of early
//! versions send and mean as UTC.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::Offset;

/// Nanoseconds since the epoch; `None` when the text is no time stamp or lies outside the years 1678 to 2261.
pub fn parse_timestamp(text: &str) -> Option<i64> {
    let text = nine_places(text.trim())?;
    let (_, time) = text.split_once('T')?;
    let has_zone = time.contains(['Z', 'z', '+', '-']);
    let stamp: Timestamp = match has_zone {
        true => text.parse().ok()?,
        false => Offset::UTC.to_timestamp(text.parse::<DateTime>().ok()?).ok()?,
    };
    stamp.as_nanosecond().try_into().ok()
}

/// The time stamp with nine fraction digits and `Z`.
pub fn format_timestamp(ns_since_epoch: i64) -> String {
    format!("{:.9}", timestamp(ns_since_epoch))
}

/// The instant; every 64-bit count of nanoseconds is one.
pub fn timestamp(ns_since_epoch: i64) -> Timestamp {
    Timestamp::from_nanosecond(ns_since_epoch.into()).expect("the years 1678 to 2261 are in range")
}

/// The text with at most nine digits in its fraction; `None` when a fraction has none.
fn nine_places(text: &str) -> Option<String> {
    let Some((whole, rest)) = text.split_once('.') else { return Some(text.into()) };
    let places = rest.bytes().take_while(u8::is_ascii_digit).count();
    (places > 0).then(|| format!("{whole}.{}{}", &rest[..places.min(9)], &rest[places..]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Seconds from `date -u -d … +%s` (GNU coreutils).
    #[test]
    fn time_stamps_are_those_of_date() {
        let check = |text: &str, expected: Option<i64>| assert_eq!(parse_timestamp(text), expected, "{text}");
        check("1970-01-01T00:00:00Z", Some(0));
        check("2010-04-06T06:19:35.153141Z", Some(1_270_534_775_153_141_000));
        check("2010-04-06T06:19:35.153141", Some(1_270_534_775_153_141_000));
        check("2024-02-29T23:59:59.1234567899Z", Some(1_709_251_199_123_456_789));
        check("2024-02-29T23:59:59.5+01:00", Some(1_709_247_599_500_000_000));
        check("1969-12-31T23:59:59.9Z", Some(-100_000_000));
        for wrong in [
            "",
            "2023-02-29T00:00:00Z",
            "2010-04-06 06:19:35Z",
            "2010-4-06T06:19:35Z",
            "2010-04-06T06:19:35.Z",
        ] {
            check(wrong, None);
        }
        check("9999-12-31T23:59:59Z", None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        #[test]
        fn any_instant_survives_its_text(ns in any::<i64>()) {
            // A year before 1678 or after 2261 cannot be a 64-bit count of nanoseconds.
            prop_assert_eq!(parse_timestamp(&format_timestamp(ns)), Some(ns));
        }

        #[test]
        fn no_text_makes_the_parser_panic(text in "[0-9TZ:.+\\-é]{0,40}") {
            parse_timestamp(&text);
        }
    }
}
