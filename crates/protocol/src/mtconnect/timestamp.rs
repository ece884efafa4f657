//! ISO 8601 time stamps, `2010-04-06T06:19:35.153141Z`, as nanoseconds since 1970-01-01 UTC without leap seconds.
//! Any number of fraction digits (beyond nine cut off); `Z`, an offset `±hh:mm`, or nothing, which agents of early
//! versions send and mean as UTC. Days from a date: Howard Hinnant, "chrono-compatible low-level date algorithms".

const NS_PER_S: i64 = 1_000_000_000;

/// Nanoseconds since the epoch; `None` when the text is no time stamp or lies outside the years 1678 to 2261.
pub fn parse_timestamp(text: &str) -> Option<i64> {
    let (date, time) = text.trim().split_once('T')?;
    let mut date = date.splitn(3, '-');
    let (year, month, day) = (digits(date.next()?, 4)?, digits(date.next()?, 2)?, digits(date.next()?, 2)?);
    let (time, offset_s) = split_zone(time)?;
    let (whole, fraction) = time.split_once('.').unwrap_or((time, "0"));
    let mut clock = whole.splitn(3, ':');
    let (hour, minute, second) =
        (digits(clock.next()?, 2)?, digits(clock.next()?, 2)?, digits(clock.next()?, 2)?);
    let days_in_month = [31, 28 + i64::from(is_leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let length = *days_in_month.get(usize::try_from(month - 1).ok()?)?;
    // 60: a leap second, which becomes the first second of the next minute
    if !(1..=length).contains(&day) || hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let seconds = days_from_civil(year, month, day) * 86_400 + hour * 3600 + minute * 60 + second - offset_s;
    seconds.checked_mul(NS_PER_S)?.checked_add(fraction_ns(fraction)?)
}

/// The time stamp with nine fraction digits and `Z`.
pub fn format_timestamp(ns_since_epoch: i64) -> String {
    let (seconds, ns) = (ns_since_epoch.div_euclid(NS_PER_S), ns_since_epoch.rem_euclid(NS_PER_S));
    let (days, in_day) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
    let (year, month, day) = civil_from_days(days);
    let (hour, minute, second) = (in_day / 3600, in_day / 60 % 60, in_day % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{ns:09}Z")
}

fn split_zone(time: &str) -> Option<(&str, i64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0));
    }
    let Some(at) = time.find(['+', '-']) else { return Some((time, 0)) };
    let (time, zone) = time.split_at(at);
    let (hours, minutes) = zone[1..].split_once(':')?;
    let (hours, minutes) = (digits(hours, 2)?, digits(minutes, 2)?);
    if hours > 23 || minutes > 59 {
        return None;
    }
    let offset_s = hours * 3600 + minutes * 60;
    Some((time, if zone.starts_with('-') { -offset_s } else { offset_s }))
}

fn digits(text: &str, count: usize) -> Option<i64> {
    (text.len() == count && text.bytes().all(|byte| byte.is_ascii_digit())).then(|| text.parse().ok())?
}

fn fraction_ns(text: &str) -> Option<i64> {
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let nine = text.bytes().chain(std::iter::repeat(b'0')).take(9);
    Some(nine.fold(0, |ns, digit| 10 * ns + i64::from(digit - b'0')))
}

fn is_leap(year: i64) -> bool {
    year % 4 == 0 && (year % 100 != 0 || year % 400 == 0)
}

fn days_from_civil(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let year_of_era = year.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

fn civil_from_days(days: i64) -> (i64, i64, i64) {
    let days = days + 719_468;
    let (era, day_of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    (era * 400 + year_of_era + i64::from(month <= 2), month, day)
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
