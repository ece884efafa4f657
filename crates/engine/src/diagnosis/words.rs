//! Sentences of a diagnosis.

use crate::diagnosis::families::travel::{CYCLES, PERIOD};
use crate::diagnosis::verdict::ShapeNumber;
use std::f64::consts::TAU;
use trunnion_effects::Instance;

/// The measurements that separate an effect from its rivals; empty without rivals.
pub fn separate_by(instance: &Instance, rivals: &[&Instance]) -> String {
    if rivals.is_empty() {
        return String::new();
    }
    let shows = |instance: &Instance| {
        let seen_by = instance.about().map_or("", |about| about.seen_by);
        format!("{} shows in: {seen_by}", instance.id())
    };
    let all: Vec<_> = std::iter::once(instance).chain(rivals.iter().copied()).map(shows).collect();
    all.join(" ")
}

/// Where a term of the grammar acts.
pub fn location(site: &str, components: &[&str], words: &str) -> String {
    let along = |prefix: &str, names: [&str; 3]| {
        let of_sort = components.iter().filter_map(|component| component.strip_prefix(prefix));
        let letters: Vec<&str> = of_sort
            .filter_map(|last| names.iter().position(|n| *n == last).map(|k| ["X", "Y", "Z"][k]))
            .collect();
        listed(&letters)
    };
    let shift = along("d", ["x", "y", "z"]).map(|axes| format!("displacement along {axes}"));
    let turn = along("e", ["a", "b", "c"]).map(|axes| format!("rotation about {axes}"));
    let what: Vec<String> = [shift, turn].into_iter().flatten().collect();
    let place = match site.strip_prefix("axis:") {
        Some(axis) => format!("at axis {axis}, in the axes of what carries it"),
        None if site == "ball" => "of the ball or nest on the table, in table axes".into(),
        None => format!("of the {site}"),
    };
    format!("{} {place}: {words}", what.join(" with "))
}

/// The words of a family with the numbers that its shape turned out to have: `near 32° of B`, `2.90 per turn of C`.
pub fn placed(words: &str, shape: &[ShapeNumber]) -> String {
    let mut words = words.to_owned();
    for number in shape {
        words = match number.name.as_str() {
            "at" | "centre" | "knee" => {
                let angle = format!("{:.0}° of", number.value.to_degrees());
                words.replace("one angle of", &angle).replace("an angle of", &angle)
            }
            "cycles" => words.replace(CYCLES, &format!("{:.2}", number.value)),
            "per_mm" => words.replace(PERIOD, &format!("{:.4}", TAU / number.value)),
            _ => words,
        };
    }
    words
}

/// `X`, `X and Y`, `X, Y and Z`; none for nothing.
fn listed(names: &[&str]) -> Option<String> {
    let (last, others) = names.split_last()?;
    Some(if others.is_empty() { (*last).into() } else { format!("{} and {last}", others.join(", ")) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_of_a_sort_are_named_together() {
        let centre = ShapeNumber { name: "centre".into(), value: 0.5585, unit: "rad" };
        let words = location("axis:B", &["dx", "dz", "ec"], &placed("near one angle of B", &[centre]));
        let expected = "displacement along X and Z with rotation about Z at axis B, in the axes of what carries it: near 32° of B";
        assert_eq!(words, expected);
    }

    #[test]
    fn a_wave_is_said_with_the_period_that_the_fit_gives() {
        let said = |words: &str, name: &str, value: f64| {
            placed(words, &[ShapeNumber { name: name.into(), value, unit: "1" }])
        };
        assert_eq!(said(&format!("{CYCLES} per turn of C"), "cycles", 2.8961), "2.90 per turn of C");
        let words = format!("repeating along X every {PERIOD} mm");
        assert_eq!(said(&words, "per_mm", TAU / 20.0), "repeating along X every 20.0000 mm");
    }
}
