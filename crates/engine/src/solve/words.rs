//! Directions in words.

use crate::solve::direction::{Named, Status, Unobservable};
use crate::solve::null_space::{Direction, Share};

/// The direction in words.
pub(crate) fn describe(direction: &Direction, names: &[Named], status: &[Status]) -> Unobservable {
    let pivot = direction.terms[0].0;
    let screen =
        |&(j, x): &(usize, f64)| (names[j].name.clone(), x * names[j].per_inside / names[pivot].per_inside);
    let terms: Vec<(String, f64)> = direction.terms.iter().map(screen).collect();
    let inside = direction.terms.clone();
    let pivot = terms[0].0.clone();
    let others: Vec<&str> = terms[1..].iter().map(|(name, _)| name.as_str()).collect();
    let without: Vec<&str> = direction.terms[1..]
        .iter()
        .filter(|(j, _)| status[*j] == Status::Unobservable)
        .map(|(j, _)| names[*j].name.as_str())
        .collect();
    let how = |s: &str| {
        if direction.weak {
            format!("move{s} the readings too little")
        } else {
            format!("move{s} no reading")
        }
    };
    let widened: Vec<&str> = direction.widened.iter().map(|&j| names[j].name.as_str()).collect();
    let held = match &widened[..] {
        [] => String::new(),
        _ => format!("; u of {} holds what 1 mm or 1 mrad of it makes", widened.join(", ")),
    };
    if direction.share == Share::Mounting {
        // A location error: direction, 0, name of the axis.
        let axis = pivot.split_once('0').map_or(pivot.as_str(), |(_, axis)| axis);
        let why = format!("not observable: axis {axis} is at rest in these runs; taken as 0");
        let why = match &others[..] {
            [] => why,
            _ => format!("{why}, and contained, as {axis} stands, in {}", others.join(", ")),
        };
        return Unobservable { direction: pivot, terms, inside, why, at_rest: true };
    }
    let why = if others.is_empty() {
        format!("not observable: {pivot} {} of these runs{held}", how("s"))
    } else if direction.share == Share::Base {
        let (without, keep): (Vec<_>, Vec<_>) =
            direction.terms.iter().partition(|(j, _)| status[*j] == Status::Unobservable);
        let listed = |terms: Vec<&(usize, f64)>| {
            terms.into_iter().map(|(j, _)| names[*j].name.as_str()).collect::<Vec<_>>().join(", ")
        };
        let verb = if without.len() == 1 { "is" } else { "are" };
        let (without, keep) = (listed(without), listed(keep));
        format!("not observable: {without} {verb} confounded with {keep} in these runs, which keep the share")
    } else if direction.share == Share::Nobody {
        let others = others.join(", ");
        let how = how("");
        format!(
            "not observable: {pivot} and {others} together {how} of these runs; none of them gets a number{held}"
        )
    } else {
        let (stand, all) = if others.len() == 1 { ("stands", "both") } else { ("stand", "all of them") };
        let others = others.join(", ");
        let meaning = if without.is_empty() {
            format!(", so {others} {stand} for {all}")
        } else {
            format!("; {} is not observable for another reason", without.join(", "))
        };
        format!("{pivot} is confounded with {others} in these runs; by convention {pivot} = 0{meaning}")
    };
    Unobservable { direction: in_words(&terms), terms, inside, why, at_rest: false }
}

/// `EX0A - 0.5 EX0C`.
pub fn in_words(terms: &[(String, f64)]) -> String {
    let mut text = String::new();
    for (k, (name, coefficient)) in terms.iter().enumerate() {
        let sign = match (k, *coefficient < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        text.push_str(sign);
        let size = coefficient.abs();
        if (size - 1.0).abs() > 1e-4 {
            text.push_str(&four_digits(size));
            text.push(' ');
        }
        text.push_str(name);
    }
    text
}

fn four_digits(size: f64) -> String {
    let decimals = (3 - size.log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{size:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
