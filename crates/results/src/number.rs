//! Numbers with their units: what JSON holds ([`finite`]), and what a person reads. What is not finite is not known: `null`
//! there, a dash here.

pub use trunnion_core::number::{MISSING, fixed, odds, plain, signed, trimmed, um};

use trunnion_core::number::decimals;

/// A number that JSON can hold.
pub fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// The number with so many decimals.
pub fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale
}

/// Unit on screen for the ASCII unit of files, e.g. `µm` for `um`.
pub fn unit_on_screen(unit: &str) -> String {
    if unit == "1" {
        return String::new();
    }
    unit.replace("urad", "µrad")
        .replace("um", "µm")
        .replace("degC", "°C")
        .replace("deg", "°")
        .replace("^2", "²")
}

/// Decimals of two digits of a standard uncertainty. What rounds to the next power of ten has its digits: 0.0996 is 0.10.
pub fn decimals_of_u(u: f64) -> usize {
    (1.0 - (u / 0.995).log10().floor()).clamp(0.0, 6.0) as usize
}

/// [`plain`] in a sentence that does not say `u`: no digit that u does not justify.
pub fn justified(value: f64, u: f64) -> String {
    if !(value.is_finite() && u.is_finite() && u > 0.0) {
        return plain(value);
    }
    let most = decimals_of_u(u);
    let decimals = match decimals(value) {
        Some(decimals) => decimals.min(most),
        None if value.abs() < 1.0 => most,
        None => return plain(value),
    };
    fixed(value, decimals)
}

/// A number with its unit, `3.14 µm`.
pub fn with_unit(value: f64, unit: &str) -> String {
    let unit = unit_on_screen(unit);
    match value.is_finite() {
        true if unit.is_empty() => plain(value),
        true => format!("{} {unit}", plain(value)),
        false => MISSING.into(),
    }
}

/// µm with unit, or a dash.
pub fn um_or_dash(value_um: Option<f64>) -> String {
    value_um.map_or(MISSING.into(), um)
}

/// Whole per cent of a share 0…1.
pub fn percent(share: f64) -> String {
    if share.is_finite() { format!("{} %", fixed(share * 100.0, 0)) } else { MISSING.into() }
}

/// Degrees from rad, `−90°`, with decimals only where needed.
pub fn degrees(rad: f64) -> String {
    match rad.is_finite() {
        true => format!("{}°", trimmed(trunnion_core::convert::deg_from_rad(rad), 2)),
        false => MISSING.into(),
    }
}

/// A value with the digits that its standard uncertainty deserves (two digits of u), both with unit.
pub fn value_and_u(value: Option<f64>, u: Option<f64>, unit: &str) -> (String, String) {
    let unit_text = unit_on_screen(unit);
    match (value, u) {
        (Some(value), Some(u)) if value.is_finite() && u.is_finite() && u > 0.0 => {
            let decimals = decimals_of_u(u);
            (
                format!("{} {unit_text}", fixed(value, decimals)).trim_end().into(),
                format!("{} {unit_text}", fixed(u, decimals)).trim_end().into(),
            )
        }
        (Some(value), _) => (with_unit(value, unit), MISSING.into()),
        (None, _) => ("not observable".into(), MISSING.into()),
    }
}

/// Tick label: as many decimals as the step needs.
pub fn tick(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    fixed(value, decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_carry_unit_sign_and_sensible_digits() {
        assert_eq!(um(3.1428), "3.14 µm");
        assert_eq!(um(-12.345), "−12.3 µm");
        assert_eq!(um(f64::NAN), "—");
        assert_eq!(with_unit(1234.6, "urad"), "1235 µrad");
        assert_eq!(degrees(-std::f64::consts::FRAC_PI_2), "−90°");
        assert_eq!(degrees(-0.0), "0°");
        assert_eq!(
            ["0.0941", "0.0372", "0.00412"].map(|n| um(n.parse().unwrap())),
            ["0.094 µm", "0.037 µm", "0.0041 µm"]
        );
        assert_eq!((justified(13.562, 25.0), justified(0.339, 0.2)), ("14".into(), "0.34".into()));
        assert_eq!((justified(-7.9e-4, 0.3), justified(-7.9e-4, 1e-5)), ("0.00".into(), "−0.000790".into()));
        assert_eq!((justified(61.16, 0.021), justified(61.16, f64::NAN)), ("61.2".into(), "61.2".into()));
        assert_eq!(value_and_u(Some(13.5975), Some(0.213), "um"), ("13.60 µm".into(), "0.21 µm".into()));
        assert_eq!(value_and_u(Some(2.926), Some(0.0996), "um"), ("2.93 µm".into(), "0.10 µm".into()));
        assert_eq!(value_and_u(None, None, "um").0, "not observable");
        assert_eq!(value_and_u(Some(3.0), None, "1").0, "3.00");
        // Nothing that is written as zero has a sign.
        assert_eq!(value_and_u(Some(-4e-5), Some(0.02), "deg").0, "0.000 °");
        assert_eq!(
            (percent(-0.002), tick(-1e-9, 0.5), plain(-0.0)),
            ("0 %".into(), "0.0".into(), "0.00".into())
        );
    }
}
