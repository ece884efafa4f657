//! What symbols of errors and names of settings are called.

use super::size::{at_tool_um, is_clear};
use crate::Parameter;
use crate::number::justified;
use trunnion_core::LEVER_MM;

/// The largest errors of place and direction of the axes, in words.
pub fn location_sentence(parameters: &[Parameter], lead: &str) -> Option<String> {
    let mut errors: Vec<(f64, String)> = parameters
        .iter()
        .filter_map(|p| {
            let value = p.value.filter(|_| is_clear(p))?;
            let size = at_tool_um(value, &p.unit)?;
            Some((size, location_words(&p.name, value, p.u.unwrap_or(f64::NAN), &p.at_rest)?))
        })
        .collect();
    errors.sort_by(|a, b| b.0.total_cmp(&a.0));
    errors.truncate(3);
    if errors.is_empty() {
        return None;
    }
    let list = errors.into_iter().map(|(_, words)| words).collect::<Vec<_>>().join("; ");
    let axes = if lead.is_empty() { "Axes" } else { "axes" };
    Some(format!("{lead}{axes} have location errors: {list}."))
}

/// `axis B lies 13.6 µm off along Z` from `EZ0B`, or `axis C, as B stands, lies …` where it contains errors of an axis at rest; `None` for
/// what is no location error.
fn location_words(name: &str, value: f64, u: f64, at_rest: &[String]) -> Option<String> {
    let (direction, axis) = name.strip_prefix('E')?.split_once('0')?;
    let ([direction], false) = (direction.as_bytes(), axis.is_empty()) else { return None };
    let direction = char::from(*direction);
    let stands = as_axes_stand(at_rest).map_or_else(String::new, |words| format!(", {words},"));
    match direction {
        'X' | 'Y' | 'Z' => {
            Some(format!("axis {axis}{stands} lies {} µm off along {direction}", justified(value, u)))
        }
        'A' | 'B' | 'C' if axis.strip_prefix(direction) == Some("") => {
            Some(format!("the zero of {axis}{stands} is off by {} µrad", justified(value, u)))
        }
        'A' | 'B' | 'C' => {
            let about = ['X', 'Y', 'Z'][usize::from(direction as u8 - b'A')];
            let over = justified(value * LEVER_MM * 1e-3, u * LEVER_MM * 1e-3);
            Some(format!(
                "axis {axis}{stands} leans {} µrad about {about} ({over} µm over 100 mm)",
                justified(value, u)
            ))
        }
        _ => None,
    }
}

/// `as B stands` of a value that contains these errors of axes at rest; `None` without any.
pub fn as_axes_stand(at_rest: &[String]) -> Option<String> {
    let mut axes: Vec<&str> =
        at_rest.iter().filter_map(|name| Some(name.strip_prefix('E')?.split_once('0')?.1)).collect();
    axes.sort_unstable();
    axes.dedup();
    let (last, others) = axes.split_last()?;
    Some(match others {
        [] => format!("as {last} stands"),
        others => format!("as {} and {last} stand", others.join(", ")),
    })
}

/// What a symbol of ISO 230-1 stands for: `place of axis C along X` for `EX0C`, `error of axis B about Z` for `ECB`; `None` for what is
/// none.
pub fn error_in_words(symbol: &str) -> Option<String> {
    let mut letters = symbol.strip_prefix('E')?.chars();
    let direction = letters.next()?;
    let rest = letters.as_str();
    let (is_location, axis) = rest.strip_prefix('0').map_or((false, rest), |axis| (true, axis));
    let is_axis =
        axis.chars().next().is_some_and(char::is_alphabetic) && axis.chars().all(char::is_alphanumeric);
    let (words, along) = match "ABC".find(direction) {
        None if "XYZ".contains(direction) => (["place of", "error of"], format!("along {direction}")),
        None => return None,
        Some(_) if is_location && axis.strip_prefix(direction) == Some("") => {
            return Some(format!("zero of {axis}"));
        }
        Some(about) => (["direction of", "error of"], format!("about {}", ["X", "Y", "Z"][about])),
    };
    is_axis.then(|| format!("{} axis {axis} {along}", words[usize::from(!is_location)]))
}

/// What mounting left: `place of setup low along Y` for `ball-setting.low.y`, `turn of setup plate about X` for `ball-setting.plate.a`; `None`
/// for what is none.
pub fn setting_in_words(name: &str) -> Option<String> {
    let (setup, what) = name.strip_prefix("ball-setting.")?.rsplit_once('.')?;
    let axis = |of: &str| of.find(what).and_then(|k| ["X", "Y", "Z"].get(k));
    Some(match (what.len(), axis("xyz"), axis("abc")) {
        (1, Some(along), _) => format!("place of setup {setup} along {along}"),
        (1, _, Some(about)) => format!("turn of setup {setup} about {about}"),
        _ => format!("{} of setup {setup}", what.replace('-', " ")),
    })
}

/// Location errors without a number, by axis: `place of axis B along X/Y`, `direction of axis C about X`, `zero of B`.
pub fn unnumbered_locations(names: &[&str]) -> Vec<String> {
    let mut groups: Vec<(String, Vec<char>)> = Vec::new();
    for (direction, axis) in names.iter().filter_map(|name| name.strip_prefix('E')?.split_once('0')) {
        let Some(direction) = direction.chars().next() else { continue };
        let (of, along) = match "ABC".find(direction) {
            None => (format!("place of axis {axis} along"), Some(direction)),
            Some(_) if axis.strip_prefix(direction) == Some("") => (format!("zero of {axis}"), None),
            Some(about) => (format!("direction of axis {axis} about"), "XYZ".chars().nth(about)),
        };
        match groups.iter_mut().find(|(group, _)| *group == of) {
            Some((_, directions)) => directions.extend(along),
            None => groups.push((of, along.into_iter().collect())),
        }
    }
    let words = |(of, directions): (String, Vec<char>)| {
        let directions: Vec<String> = directions.into_iter().map(String::from).collect();
        format!("{of} {}", directions.join("/")).trim_end().into()
    };
    groups.into_iter().map(words).collect()
}

/// True for the parameter names of `location-errors`.
pub fn is_location(name: &str) -> bool {
    location_words(name, 0.0, f64::NAN, &[]).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_holds_those_of_an_axis_at_rest_is_not_said_to_be_its_own() {
        let error = |name: &str, value: f64, at_rest: &[&str]| Parameter {
            name: name.into(),
            effect: "location-errors".into(),
            value: Some(value),
            unit: if name.starts_with("EX") { "um" } else { "urad" }.into(),
            u: Some(0.1),
            observable: true,
            at_rest: at_rest.iter().map(ToString::to_string).collect(),
            ..Parameter::default()
        };
        let found = [
            error("EX0C", -5.7, &["EX0B"]),
            error("EB0C", -49.2, &["EB0B", "EB0A"]),
            error("EA0C", 6.8, &[]),
        ];
        assert_eq!(
            location_sentence(&found, "").unwrap_or_default(),
            "Axes have location errors: axis C, as B stands, lies −5.70 µm off along X; axis C, as A and B stand, leans −49.2 µrad about Y \
             (−4.92 µm over 100 mm); axis C leans 6.80 µrad about X (0.68 µm over 100 mm)."
        );
    }

    #[test]
    fn symbols_of_errors_are_said_in_words() {
        let said = |symbol: &str| error_in_words(symbol).unwrap_or_default();
        assert_eq!(said("EX0C"), "place of axis C along X");
        assert_eq!(said("EA0C"), "direction of axis C about X");
        assert_eq!(said("EB0B"), "zero of B");
        assert_eq!(said("ECB"), "error of axis B about Z");
        assert_eq!(said("EZ0C1"), "place of axis C1 along Z");
        for other in ["E", "EX", "EX0", "left", "low.radial-x", "EQ0C", "Error"] {
            assert_eq!(error_in_words(other), None, "{other}");
        }
    }

    #[test]
    fn what_mounting_left_is_said_in_words() {
        let said = |name: &str| setting_in_words(name).unwrap_or_default();
        assert_eq!(said("ball-setting.low.y"), "place of setup low along Y");
        assert_eq!(said("ball-setting.plate 1.b"), "turn of setup plate 1 about Y");
        assert_eq!(said("ball-setting.low.dead-path"), "dead path of setup low");
        assert_eq!(setting_in_words("EX0C"), None);
    }
}
