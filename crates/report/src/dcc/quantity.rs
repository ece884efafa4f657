//! Quantities in D-SI: value and uncertainty in SI base and derived units.

use super::xml::{holding, plain, text};
use crate::markup::escape;
use std::f64::consts::PI;

/// Unit of files, its D-SI unit, how much of it one is.
const UNITS: [(&str, &str, f64); 17] = [
    ("1", "\\one", 1.0),
    ("mm", "\\metre", 1e-3),
    ("um", "\\metre", 1e-6),
    ("deg", "\\radian", PI / 180.0),
    ("urad", "\\radian", 1e-6),
    ("rad", "\\radian", 1.0),
    ("Hz", "\\hertz", 1.0),
    ("s", "\\second", 1.0),
    ("ms", "\\second", 1e-3),
    ("um/K", "\\metre\\kelvin\\tothe{-1}", 1e-6),
    ("um/m", "\\one", 1e-6),
    ("um/mm", "\\one", 1e-3),
    ("um/mm2", "\\metre\\tothe{-1}", 1.0),
    ("um/(m/s2)", "\\second\\tothe{2}", 1e-6),
    ("um/(rad/s)2", "\\metre\\second\\tothe{2}\\radian\\tothe{-2}", 1e-6),
    ("urad/(m/s2)", "\\radian\\second\\tothe{2}\\metre\\tothe{-1}", 1e-6),
    ("urad/(rad/s2)", "\\second\\tothe{2}", 1e-6),
];

/// How a quantity is uncertain.
#[derive(Clone, Copy)]
pub enum Uncertainty {
    /// Standard uncertainty, in the unit of the value.
    Standard(f64),
    /// Twice the standard uncertainty of a normal distribution [GUM 6.3.3].
    Expanded(f64),
    /// Not stated.
    None,
}

/// A value with name and unit of this program; a unit without a D-SI one stays in words.
pub fn quantity(name: &str, value: f64, unit: &str, uncertainty: Uncertainty) -> String {
    let Some((_, unit_si, factor)) = UNITS.iter().find(|(known, ..)| *known == unit) else {
        let words = format!("{value} {unit}");
        let words = format!("<dcc:content lang=\"en\">{}</dcc:content>", escape(&words));
        return holding("dcc:quantity", &(text("dcc:name", name) + &holding("dcc:noQuantity", &words)));
    };
    let number = |value: f64| format!("{:.6e}", value * factor);
    let uncertainty = match uncertainty {
        Uncertainty::None => String::new(),
        Uncertainty::Standard(u) => {
            let value = plain("si:valueStandardMU", &number(u)) + &plain("si:distribution", "normal");
            holding("si:measurementUncertaintyUnivariate", &holding("si:standardMU", &value))
        }
        Uncertainty::Expanded(u) => {
            let value = plain("si:valueExpandedMU", &number(2.0 * u))
                + &plain("si:coverageFactor", "2")
                + &plain("si:coverageProbability", "0.95")
                + &plain("si:distribution", "normal");
            holding("si:measurementUncertaintyUnivariate", &holding("si:expandedMU", &value))
        }
    };
    let real = plain("si:value", &number(value)) + &plain("si:unit", unit_si) + &uncertainty;
    holding("dcc:quantity", &(text("dcc:name", name) + &holding("si:real", &real)))
}

/// A temperature, which Kelvin would make hard to read.
pub fn celsius(name: &str, value_degc: f64) -> String {
    let real = plain("si:value", &format!("{value_degc:.3}")) + &plain("si:unit", "\\degreecelsius");
    holding("dcc:quantity", &(text("dcc:name", name) + &holding("si:real", &real)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_effects::Unit;

    /// Exponent of the metre in a D-SI unit.
    fn power_of_metre(unit: &str) -> i32 {
        let factors: Vec<&str> = unit.split('\\').filter(|factor| !factor.is_empty()).collect();
        let Some(at) = factors.iter().position(|factor| *factor == "metre") else { return 0 };
        let power = factors.get(at + 1).and_then(|next| next.strip_prefix("tothe{"));
        power.map_or(1, |power| power.trim_end_matches('}').parse().unwrap())
    }

    /// Inside are mm, rad, s and K: a value inside is the one in SI units but for the powers of mm.
    #[test]
    fn every_unit_of_a_parameter_is_one_of_d_si_and_of_its_size() {
        let shapes = ["tau_s", "period_mm", "phase_rad", "f_hz", "lobes"].map(Unit::in_name);
        let parameters = [
            Unit::UM,
            Unit::URAD,
            Unit::DEG,
            Unit::MS,
            Unit::UM_PER_M,
            Unit::UM_PER_K,
            Unit::UM_PER_MM,
            Unit::UM_PER_MM2,
            Unit::UM_PER_M_S2,
            Unit::UM_PER_RAD2_S2,
            Unit::URAD_PER_M_S2,
            Unit::URAD_PER_RAD_S2,
        ];
        for unit in parameters.into_iter().chain(shapes) {
            let known = UNITS.iter().find(|(symbol, ..)| *symbol == &*unit.symbol);
            let (_, unit_si, factor) = known.unwrap_or_else(|| panic!("{} is no unit of D-SI", unit.symbol));
            let (stated, expected) = (unit.per_inside * factor, 1e-3_f64.powi(power_of_metre(unit_si)));
            assert!((stated / expected - 1.0).abs() < 1e-12, "{unit_si}: {stated} is not {expected}");
        }
    }

    #[test]
    fn values_become_si_and_unknown_units_stay_words() {
        let xml = quantity("EX0C", -13.5, "um", Uncertainty::Standard(0.25));
        assert!(xml.contains("<si:value>-1.350000e-5</si:value>"), "{xml}");
        assert!(xml.contains("<si:unit>\\metre</si:unit>"), "{xml}");
        assert!(xml.contains("<si:valueStandardMU>2.500000e-7</si:valueStandardMU>"), "{xml}");
        let expanded = quantity("E", 1.0, "um", Uncertainty::Expanded(0.25));
        assert!(expanded.contains("<si:valueExpandedMU>5.000000e-7</si:valueExpandedMU>"), "{expanded}");
        assert!(quantity("a", 2.0, "um/furlong", Uncertainty::None).contains("2 um/furlong"));
    }
}
