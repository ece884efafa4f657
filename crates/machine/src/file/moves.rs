//! What the table of an axis says of its motion: sense, travel, facts.

use crate::AxisFacts;
use trunnion_core::convert;
use trunnion_core::input::Table;

/// Largest coordinate a machine file may name, mm.
pub(super) const FARTHEST_MM: f64 = 100_000.0;

/// What every axis says of its motion.
pub(super) struct Moves {
    pub sense: f64,
    pub travel: (f64, f64),
    pub facts: AxisFacts,
}

/// Reads it; `None` with a problem at what is missing.
pub(super) fn moves(table: &Table<'_>, rotary: bool) -> Option<Moves> {
    let sense = table.number("sense", -1.0..=1.0);
    if sense.is_some_and(|s| s.abs() != 1.0) {
        table.problem("sense", "is neither way of turning", "1 or -1", "Run the sign-test cycle if unsure.");
    }
    let (travel_key, scale): (&str, fn(f64) -> f64) =
        if rotary { ("travel_deg", convert::rad_from_deg) } else { ("travel_mm", |mm| mm) };
    let allowed = "[lowest, highest]";
    let travel = table.require(travel_key, allowed).and_then(|()| table.optional_numbers(travel_key));
    let travel = match travel.as_deref() {
        Some(&[low, high]) if low < high => Some((scale(low), scale(high))),
        Some(_) => {
            table.problem(travel_key, "is not a range", allowed, "");
            None
        }
        None => None,
    };
    let feed_limit = if rotary {
        table.optional_number("feed_limit_deg_per_min", 0.0..=1e6).map(|f| convert::rad_from_deg(f) / 60.0)
    } else {
        table.optional_number("feed_limit_mm_per_min", 0.0..=1e6).map(|f| f / 60.0)
    };
    let facts = AxisFacts {
        screw_lead_mm: table.optional_number("screw_lead_mm", 0.1..=1000.0),
        gear_teeth: table.optional_count("gear_teeth", 1.0..=10_000.0),
        bearing_rollers: table.optional_count("bearing_rollers", 3.0..=1000.0),
        encoder_lines: table.optional_count("encoder_lines", 1.0..=1e7),
        feed_limit,
    };
    Some(Moves { sense: sense?, travel: travel?, facts })
}
