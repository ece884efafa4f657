//! Compensation tables of a machine: one file per format.
//!
//! Every format gets the same numbers: offsets in mm, angles in rad, arguments in mm and degrees. The first lines say
//! whether the values are errors or corrections (`correction = −error`), what they come from and what they leave out.

mod csv;
mod etalon;
mod isg;

use trunnion_core::{AxisLetter, Twist, convert};
use trunnion_methods::AxisErrors;

/// One format: plain data and a function, one constant per file.
pub struct Format {
    /// Name on the command line and of the file.
    pub name: &'static str,
    /// What reads it.
    pub readers: &'static str,
    /// Where it is described.
    pub source: &'static str,
    /// Usual ending of the file name.
    pub ending: &'static str,
    /// The text of the file.
    pub write: fn(&AxisErrors, Values) -> String,
}

/// The registry.
pub static FORMATS: [&Format; 3] = [&csv::FORMAT, &etalon::FORMAT, &isg::FORMAT];

/// The format of this name.
pub fn format(name: &str) -> Option<&'static Format> {
    FORMATS.into_iter().find(|format| format.name == name)
}

/// What the numbers of a table are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Actual minus nominal: the controller has to apply the opposite.
    Errors,
    /// The opposite of the errors: the controller has to add them.
    Corrections,
}

impl Values {
    fn sign(self) -> f64 {
        match self {
            Self::Errors => 1.0,
            Self::Corrections => -1.0,
        }
    }
}

/// Lines that stand on top of every file, without the comment sign of the format.
fn header(errors: &AxisErrors, values: Values) -> Vec<String> {
    let mut lines = vec![
        format!("Trunnion compensation of machine {}, identified from {}", errors.machine, errors.runs.join(", ")),
        match values {
            Values::Errors => "values = error (actual - nominal); the control must apply correction = -error".into(),
            Values::Corrections => "values = correction (-error, error = actual - nominal); the control must add it".into(),
        },
        "units: offsets mm, angles rad; arguments: X Y Z in mm, A B C in degrees".into(),
        "frame: pose of what the axis carries, in the nominal axes of what carries the axis, about the axis line (rotary) or the carriage (linear); a turn by the vector (A, B, C)".into(),
    ];
    for table in errors.axes.iter().filter(|table| !table.positions.is_empty()) {
        let edge = |position: f64| argument(table.axis, position);
        let range = (edge(table.positions[0]), edge(table.positions[table.positions.len() - 1]));
        let unit = if table.axis.is_rotary() { "deg" } else { "mm" };
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
fn argument(axis: AxisLetter, position: f64) -> String {
    let edge = if axis.is_rotary() { convert::deg_from_rad(position) } else { position };
    let rounded = (edge * 1e6).round() / 1e6;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

/// The six components of a twist in the order X Y Z A B C.
fn components(twist: &Twist) -> [f64; 6] {
    let ([x, y, z], [a, b, c]) = (twist.translation_mm.into(), twist.rotation_rad.into());
    [x, y, z, a, b, c]
}

/// A value: picometres and picoradians are more than enough.
fn number(value: f64) -> String {
    let text = format!("{value:.12}");
    if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) {
        "0.000000000000".into()
    } else {
        text
    }
}
