//! What a format provides, and what all formats have in common: header, arguments, numbers.

use trunnion_results::{AxisErrors, CompensationValues};

/// One format: plain data and a function, one constant per file.
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
    /// The text of the file.
    pub write: fn(&AxisErrors, CompensationValues) -> String,
}

/// Lines that stand on top of every file, without the comment sign of the format.
pub(super) fn header(errors: &AxisErrors, values: CompensationValues) -> Vec<String> {
    let mut lines = vec![
        format!("Trunnion compensation of machine {}, identified from {}", errors.machine, errors.runs.join(", ")),
        match values {
            CompensationValues::Error => "values = error (actual - nominal); the control must apply correction = -error".into(),
            CompensationValues::Correction => "values = correction (-error, error = actual - nominal); the control must add it".into(),
        },
        "units: offsets mm, angles rad; arguments: X Y Z in mm, A B C in degrees".into(),
        "frame: pose of what the axis carries, in the nominal axes of what carries the axis, about the axis line (rotary) or the carriage (linear); a turn by the vector (A, B, C)".into(),
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
    lines.iter().map(|line| line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()).collect()
}

/// Position as an argument of a table, mm or degrees.
pub(super) fn argument(position: f64) -> String {
    let rounded = (position * 1e6).round() / 1e6;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

/// A value: picometres and picoradians are more than enough.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.12}");
    if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) {
        "0.000000000000".into()
    } else {
        text
    }
}
