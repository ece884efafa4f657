//! Pictures of the circular method: the trace magnified, what the list explains of it, and what is left.

use super::fit::{Contour, Fitted};
use crate::findings::{AxisName, Chart, Curve, NamedAmount, Plot};
use trunnion_core::convert::um_from_mm;
use trunnion_effects::Unit;

pub(super) fn charts(fit: &Fitted<'_>) -> Vec<Chart> {
    let [a, b] = fit.trace.plane;
    let group = format!(
        "Circle in {}: circular deviation {:.1} µm ({a} to the right at 0°, {b} at 90°; ↺ counter-clockwise, ↻ clockwise)",
        fit.trace.name,
        um_from_mm(fit.iso.of_the_trace_mm())
    );
    let curves = |k: usize, around: bool| -> Vec<Curve> {
        let drawn = |contour: &Contour| if around { closed(contour) } else { contour.clone() };
        fit.contours.iter().map(|(way, contours)| Curve::new(name(*way), drawn(&contours[k]))).collect()
    };
    let mut charts = vec![Chart {
        group: group.clone(),
        title: "What makes it: circularity of each error, and its share".into(),
        plot: Plot::Bars { unit: Unit::UM, bars: bars(fit) },
    }];
    for (k, title) in
        ["Measured, centred", "Explained by the list", "Left unexplained"].into_iter().enumerate()
    {
        let plot = Plot::Polar { unit: Unit::UM, curves: curves(k, true) };
        charts.push(Chart { group: group.clone(), title: title.into(), plot });
        if k != 1 {
            let plot = Plot::Xy {
                x: AxisName { name: "angle".into(), unit: Unit::DEG },
                y: AxisName { name: String::new(), unit: Unit::UM },
                curves: curves(k, false),
            };
            charts.push(Chart { group: group.clone(), title: title.into(), plot });
        }
    }
    charts
}

/// The errors that are significant and what is unexplained, largest first.
fn bars(fit: &Fitted<'_>) -> Vec<NamedAmount> {
    let bar = |name: &str, circularity_mm: f64| NamedAmount {
        name: name.into(),
        amount: circularity_mm,
        remark: fit.share(circularity_mm),
    };
    let significant = fit.errors.iter().filter(|error| error.significant());
    let mut bars: Vec<_> = significant.map(|error| bar(&error.listed.name, error.circularity_mm)).collect();
    bars.push(bar("unexplained beyond noise", fit.unexplained_circularity_mm()));
    bars.sort_by(|a, b| b.amount.total_cmp(&a.amount));
    bars
}

fn name(way: f64) -> &'static str {
    if way < 0.0 { "↻ −" } else { "↺ +" }
}

/// The first point once more.
fn closed(contour: &Contour) -> Contour {
    let first = contour.first().map(|(angle, value)| (angle + std::f64::consts::TAU, *value));
    contour.iter().copied().chain(first).collect()
}
