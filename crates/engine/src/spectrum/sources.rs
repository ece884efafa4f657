//! Which known part of a machine has a period that was found. A label only: nothing is found or left out because of it.

use trunnion_machine::Axis;

/// Periods that agree within this many standard uncertainties may be the same.
const WITHIN_U: f64 = 3.0;
/// Relative difference up to which a period is that of a part although its uncertainty is smaller: pitch errors of screws and tapes.
const WITHIN: f64 = 2e-3;
/// Highest fraction of a screw's lead that has a usual source: pole pairs of resolvers and motors, balls entering the nut.
const MOST_PARTS: u32 = 24;

/// What has the period of a linear axis: `lead`, `lead/4`, …; `None` when nothing of the machine file has it.
pub(crate) fn of_period_mm(axis: &Axis, period_mm: f64, u_mm: f64) -> Option<String> {
    let lead_mm = axis.facts.screw_lead_mm?;
    let near = |expected: f64| (period_mm - expected).abs() <= (WITHIN_U * u_mm).max(WITHIN * expected);
    // Fractions that lie closer together than the uncertainty name nothing.
    let distinct = |parts: u32| {
        let step = lead_mm / f64::from(parts) - lead_mm / f64::from(parts + 1);
        step > 2.0 * WITHIN_U * u_mm
    };
    (1..=MOST_PARTS).find(|&parts| near(lead_mm / f64::from(parts)) && distinct(parts)).map(|parts| {
        match parts {
            1 => "lead".into(),
            2 => "lead/2".into(),
            _ => format!("lead/{parts}"),
        }
    })
}

/// What has so many cycles a turn of a rotary axis: its gear teeth, or a whole number; `None` for a broken one.
pub(crate) fn of_cycles(axis: &Axis, cycles: f64, u: f64) -> Option<String> {
    let near = |expected: f64| (cycles - expected).abs() <= (WITHIN_U * u).max(WITHIN * expected);
    if let Some(teeth) = axis.facts.gear_teeth {
        for (times, word) in [(1.0, "gear teeth"), (2.0, "2 × gear teeth")] {
            if near(times * teeth) {
                return Some(word.into());
            }
        }
    }
    let whole = cycles.round();
    (whole >= 1.0 && near(whole) && 2.0 * WITHIN_U * u < 1.0).then(|| format!("{whole} per turn"))
}
