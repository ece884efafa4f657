//! What a file of compensation tables holds, for the terminal.

use super::table::clean;
use trunnion_core::convert::{um_from_mm, urad_from_rad};
use trunnion_results::{AxisErrors, AxisTable};

/// What was written to `path`, axis by axis, and what is not in it.
pub fn axis_errors_text(errors: &AxisErrors, path: &str) -> String {
    let mut text = format!("{path}: {}\n", clean(&errors.effects.join(", ")));
    for table in &errors.axes {
        text += &format!("  {}  {}\n", table.axis, sizes(table));
    }
    for left_out in &errors.left_out {
        text += &format!("  not in it: {}: {}\n", clean(&left_out.effect), clean(&left_out.why));
    }
    text
}

fn sizes(table: &AxisTable) -> String {
    let place = format!("location up to {}", largest([&table.location]));
    match table.positions.len() {
        0 => place,
        rows => format!("{place}; {rows} rows up to {}", largest(&table.errors)),
    }
}

/// Largest offset and largest angle.
fn largest<'a>(twists: impl IntoIterator<Item = &'a [f64; 6]>) -> String {
    let (mm, rad) = twists.into_iter().fold((0.0, 0.0), |(mm, rad): (f64, f64), [x, y, z, a, b, c]| {
        let most = |so_far: f64, values: [&f64; 3]| values.into_iter().fold(so_far, |m, v| m.max(v.abs()));
        (most(mm, [x, y, z]), most(rad, [a, b, c]))
    });
    format!("{:.1} µm, {:.1} µrad", um_from_mm(mm), urad_from_rad(rad))
}
