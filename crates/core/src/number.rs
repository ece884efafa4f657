//! Numbers as people read them: a true minus sign, and none before what rounds to zero.

/// What stands for a number that is not finite.
pub const MISSING: &str = "—";

/// With so many decimals.
pub fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return MISSING.into();
    }
    let size = format!("{:.decimals$}", value.abs());
    match value < 0.0 && !is_zero(&size) {
        true => format!("−{size}"),
        false => size,
    }
}

/// The same with an explicit plus.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    match value > 0.0 && value.is_finite() && !is_zero(&text) {
        true => format!("+{text}"),
        false => text,
    }
}

/// With at most so many decimals and none that are zero, as a value that a person chose is written: a place, a limit, a scale.
pub fn trimmed(value: f64, most_decimals: usize) -> String {
    if !value.is_finite() {
        return MISSING.into();
    }
    let whole = 10_f64.powi(most_decimals as i32);
    let scaled = value * whole;
    // One too large for the product has no decimals.
    let rounded = if scaled.is_finite() { scaled.round() / whole } else { value };
    let size = format!("{}", rounded.abs());
    if rounded < 0.0 { format!("−{size}") } else { size }
}

/// Three significant digits from 1 on, and every digit before the decimal point; two below 1 and before a power of ten. A true minus
/// sign, no unit.
pub fn plain(value: f64) -> String {
    if !value.is_finite() {
        return MISSING.into();
    }
    match decimals(value) {
        Some(decimals) => fixed(value, decimals),
        None => format!("{value:.1e}").replace('-', "−"),
    }
}

/// Decimals of [`plain`]; `None` for what is written with a power of ten.
pub fn decimals(value: f64) -> Option<usize> {
    match value.abs() {
        m if m >= 1e6 || (m > 0.0 && m < 1e-3) => None,
        m if m >= 99.95 => Some(0),
        m if m >= 9.995 => Some(1),
        m if m >= 0.0995 || m == 0.0 => Some(2),
        m if m >= 0.00995 => Some(3),
        _ => Some(4),
    }
}

/// µm with unit, as [`plain`].
pub fn um(value_um: f64) -> String {
    if value_um.is_finite() { format!("{} µm", plain(value_um)) } else { MISSING.into() }
}

/// The same of a part of something larger: of less than a hundredth of a micrometre it says no more than that.
pub fn um_or_less(value_um: f64) -> String {
    let is_small = value_um != 0.0 && value_um.abs() < 0.01;
    if is_small { "< 0.01 µm".into() } else { um(value_um) }
}

/// `1 setup`, `2 setups`: of nouns that take an s.
pub fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// The same as [`fixed`] in a table that programs read: with the minus of ASCII, and `NaN` for what is not finite.
pub fn in_table(value: f64, decimals: usize) -> String {
    if value.is_finite() { fixed(value, decimals).replace('−', "-") } else { "NaN".into() }
}

/// Of odds beyond this power of ten no more is said: so far out no model of the noise holds.
const MOST_POWER: f64 = 100.0;

/// Odds by their logarithm to base 10: `10^4.5`, `above 10^100`.
pub fn odds(log10: f64) -> String {
    match log10 {
        power if power > MOST_POWER => format!("above 10^{MOST_POWER:.0}"),
        power => format!("10^{}", in_table(power, 1)),
    }
}

fn is_zero(size: &str) -> bool {
    size.chars().all(|c| matches!(c, '0' | '.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_less_than_a_hundredth_is_no_power_of_ten() {
        assert_eq!(
            [9.2e-4, -0.003, 0.0, 0.01].map(um_or_less),
            ["< 0.01 µm", "< 0.01 µm", "0.00 µm", "0.010 µm"]
        );
    }

    #[test]
    fn odds_are_a_power_of_ten_as_far_as_it_says_something() {
        assert_eq!([-0.01, 4.52, 99.96, 2092.0].map(odds), ["10^0.0", "10^4.5", "10^100.0", "above 10^100"]);
    }

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!([fixed(-1.25, 1), fixed(-0.04, 1), fixed(0.04, 1)], ["−1.2", "0.0", "0.0"]);
        assert_eq!([fixed(-0.4, 0), fixed(-0.6, 0), fixed(-0.0, 4)], ["0", "−1", "0.0000"]);
        assert_eq!([signed(2.25, 1), signed(-2.25, 1), signed(-0.04, 1)], ["+2.2", "−2.2", "0.0"]);
        assert_eq!(
            [trimmed(-75.0, 3), trimmed(2.0, 3), trimmed(0.05, 3), trimmed(-1e-9, 3)],
            ["−75", "2", "0.05", "0"]
        );
        assert_eq!(trimmed(f64::MAX, 3), format!("{}", f64::MAX));
        assert_eq!([in_table(-4e-5, 4), in_table(-1.25, 2)], ["0.0000", "-1.25"]);
        assert_eq!([fixed(f64::NAN, 1), signed(f64::INFINITY, 1), trimmed(f64::NAN, 1)], [MISSING; 3]);
    }
}
