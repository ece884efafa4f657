//! `circular` where a true value is zero: the arithmetic leaves no figure of its own.

use crate::circular::{circle, circular, near, value};
use trunnion_core::State;
use trunnion_core::axis::iso::Y;
use trunnion_methods::findings::{Cell, Plot};

/// Figures of an exact circle, and of what a cause shares with an error of the list in noise: even and odd shapes share nothing.
#[test]
fn a_figure_that_is_zero_to_rounding_is_zero() {
    let squareness = |s: &State| (-30e-6 * s.position[Y], 0.0);
    let in_noise = circular(circle(squareness, 0.3, true));
    let doubts = in_noise.tables.iter().any(|table| table.caption.starts_with("What else may read"));
    assert!(doubts, "the table of the test");
    let exact = [circular(circle(|_| (0.0, 0.0), 0.0, true)), circular(circle(squareness, 0.0, true))];
    for found in exact.iter().chain([&in_noise]) {
        let of_values =
            found.values.iter().flat_map(|v| [v.value, v.u.unwrap_or(0.0)].map(|of| (&v.name, of)));
        let of_tables = found.tables.iter().flat_map(|table| {
            let of_cell = |cell: &Cell| if let Cell::Number(number) = cell { Some(*number) } else { None };
            table.rows.iter().flatten().filter_map(of_cell).map(|number| (&table.caption, number))
        });
        let of_charts = found.charts.iter().flat_map(|chart| {
            let (Plot::Polar { curves, .. } | Plot::Xy { curves, .. }) = &chart.plot else {
                return Vec::new();
            };
            let points = curves.iter().flat_map(|curve| &curve.points).map(|point| (&chart.title, point.1));
            points.collect()
        });
        let rounding: Vec<_> = of_values
            .chain(of_tables)
            .chain(of_charts)
            .filter(|(_, figure)| *figure != 0.0 && figure.abs() < 1e-12)
            .collect();
        assert_eq!(rounding, []);
    }
    assert_eq!(value(&exact[0], "XY G(b)"), 0.0);
    near(value(&exact[1], "XY EC0Y"), 30e-6, 1e-12, "squareness");
}
