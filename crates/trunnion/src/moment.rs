//! Moments of recordings for a person. Imports and simulations have none.

use jiff::Timestamp;

/// `YYYY-MM-DD hh:mm UTC` of the wall clock at the beginning of a run; `None` where it has none.
pub fn minute(wall_start_ns: i64) -> Option<String> {
    let known = Some(wall_start_ns).filter(|ns| *ns > 0)?;
    let stamp = Timestamp::from_nanosecond(known.into()).ok()?;
    Some(stamp.strftime("%Y-%m-%d %H:%M UTC").to_string())
}

/// The first ten characters of the same: `YYYY-MM-DD`.
pub fn day(wall_ns: i64) -> Option<String> {
    Some(minute(wall_ns)?.chars().take("YYYY-MM-DD".len()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_a_minute_and_zero_is_none() {
        assert_eq!(minute(1_270_534_775_153_141_000).as_deref(), Some("2010-04-06 06:19 UTC"));
        assert_eq!(day(1_270_534_775_153_141_000).as_deref(), Some("2010-04-06"));
        assert_eq!((minute(0), day(0)), (None, None));
    }
}
