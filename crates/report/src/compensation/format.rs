//! What a control or format provides, and what all have in common: header, arguments, numbers.

use trunnion_core::number::in_table;
use trunnion_results::{AxisErrors, Chain, ConfoundedErrors, CorrectionValues};

/// One control or format: plain data and two functions, one constant per file.
pub struct Format {
    /// Name on the command line and of the file.
    pub name: &'static str,
    /// What the file looks like, for the guide.
    pub about: &'static str,
    /// What reads it.
    pub readers: &'static str,
    /// Where it is described.
    pub source: &'static str,
    /// Usual ending of the file name.
    pub ending: &'static str,
    /// Which signs its values can have.
    pub signs: Signs,
    /// Where and how to enter the values, step by step.
    pub enter: &'static [&'static str],
    /// How to undo it.
    pub undo: &'static [&'static str],
    /// What no public document confirms.
    pub unconfirmed: &'static [&'static str],
    /// What of the errors the control can apply; the rest is added to what is left out, with the reason.
    pub takes: fn(&Chain, &AxisErrors) -> AxisErrors,
    /// The text of the file, for errors that `takes` gave.
    pub write: fn(&Chain, &AxisErrors, CorrectionValues) -> String,
}

/// Which signs the values of a format can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signs {
    /// Errors or corrections, as asked for; the file says which.
    Either,
    /// What the control asks for, and nothing else.
    OfTheControl,
}

/// A format of tables holds every error of every axis.
pub(super) fn takes_all(_: &Chain, errors: &AxisErrors) -> AxisErrors {
    errors.clone()
}

/// Lines that stand on top of every file, without the comment sign of the format.
pub(super) fn header(errors: &AxisErrors, values: &str) -> Vec<String> {
    let mut lines = vec![
        format!(
            "Trunnion correction of machine {}, identified from {}",
            errors.machine,
            errors.runs.join(", ")
        ),
        values.into(),
    ];
    for table in errors.axes.iter().filter(|table| !table.positions.is_empty()) {
        let edge = |position: f64| argument(position);
        let range = (edge(table.positions[0]), edge(table.positions[table.positions.len() - 1]));
        let unit = if table.rotary { "deg" } else { "mm" };
        lines.push(match table.whole_turn {
            true => format!("axis {}: a whole turn, periodic", table.axis),
            false => format!(
                "axis {}: measured from {} to {} {unit}, not valid beyond",
                table.axis, range.0, range.1
            ),
        });
    }
    lines.push(format!(
        "holds: {}",
        if errors.effects.is_empty() { "nothing".into() } else { errors.effects.join(", ") }
    ));
    for left_out in &errors.left_out {
        lines.push(format!("does not hold {}: {}", left_out.effect, left_out.why));
    }
    lines.extend(errors.confounded.iter().map(ConfoundedErrors::sentence));
    lines.iter().map(|line| line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()).collect()
}

/// The header of a table of errors or corrections, with sign, units and frame.
pub(super) fn header_of_tables(errors: &AxisErrors, values: CorrectionValues) -> Vec<String> {
    let sign = match values {
        CorrectionValues::Error => {
            "values = error (actual - nominal); the control must apply correction = -error"
        }
        CorrectionValues::Correction => {
            "values = correction (-error, error = actual - nominal); the control must add it"
        }
    };
    let mut lines = header(errors, sign);
    let frame = "frame: pose of what the axis carries, in the nominal axes of what carries the axis, about the axis line (rotary) or the carriage (linear); a turn by the vector (A, B, C)";
    let units = "units: offsets mm, angles rad; arguments: X Y Z in mm, A B C in degrees";
    lines.splice(2..2, [units.into(), frame.into()]);
    lines
}

/// Position as an argument of a table, mm or degrees.
pub(super) fn argument(position: f64) -> String {
    let rounded = (position * 1e6).round() / 1e6;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

/// A value: picometres and picoradians are more than enough.
pub(super) fn number(value: f64) -> String {
    in_table(value, 12)
}
