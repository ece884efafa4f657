//! What a named method found, as a page.

use crate::findings::{VALUE_HEADS, cells, heads, numeric, to_do, value_row, verdict};
use crate::markup::{element, escape, table};
use crate::number::unit_on_screen;
use crate::svg::{
    Displaced, Mark, Ranked, Series, Trace, XyChart, displaced, end_above, path_chart, polar, ranked,
    xy_chart,
};
use trunnion_core::convert::{mm_from_um, rad_from_deg};
use trunnion_results::{AxisName, Chart, Curve, Findings, MapPlace, NamedAmount, Plot};

pub fn sections(findings: &Findings, label: &str) -> String {
    let said = verdict(findings);
    let title = format!("Machine {}, {}: {}", findings.machine, findings.method, said[0]);
    let mut html = element("h1", &title) + "\n";
    html += &said[1..].iter().map(|sentence| element("p", sentence)).collect::<String>();
    let to_do = to_do(findings);
    if !to_do.is_empty() {
        let items: String = to_do.iter().map(|text| element("li", text)).collect();
        html += &format!("<section><h2>What to do</h2>\n<ol>{items}</ol></section>\n");
    }
    // Before a table of many rows a picture.
    let in_first = |chart: &&Chart| chart.group == findings.charts[0].group;
    let (first, others) = findings.charts.split_at(findings.charts.iter().take_while(in_first).count());
    html += &charts(first);
    let rows: Vec<_> = findings.values.iter().map(value_row).collect();
    html += &table("Values with standard uncertainties", &VALUE_HEADS, &[1, 2], &rows);
    if !findings.notes.is_empty() {
        let notes = findings.notes.iter().map(|note| element("li", note));
        let notes = notes.collect::<String>();
        html += &format!(
            "<section><h2>What it assumes, and what these runs could not show</h2>\n<ul>{notes}</ul></section>\n"
        );
    }
    html += &charts(others);
    if !findings.tables.is_empty() {
        html += "<section><h2>Tables</h2>\n";
        for found in &findings.tables {
            let heads = heads(found);
            let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
            let rows: Vec<_> = found.rows.iter().map(|row| cells(found, row)).collect();
            html += &table(&found.caption, &heads, &numeric(found), &rows);
        }
        html += "</section>\n";
    }
    let facts = [&findings.source, &findings.runs.join(", "), label].map(escape);
    html + &format!(
        "<section><h2>Method and source</h2>\n<p>Source: {}. Signs: {}.</p>\n<p class=\"soft\">Runs: {}. {}</p></section>\n",
        facts[0], findings.convention, facts[1], facts[2]
    )
}

fn charts(charts: &[Chart]) -> String {
    let mut html = String::new();
    for group in charts.chunk_by(|a, b| a.group == b.group) {
        let drawn: String = group.iter().map(figure).collect();
        html += &format!(
            "<section><h2>{}</h2>\n<div class=\"pairs\">{drawn}</div></section>\n",
            escape(&group[0].group)
        );
    }
    html
}

fn figure(chart: &Chart) -> String {
    let title = &chart.title;
    match &chart.plot {
        Plot::Polar { y_unit, curves, .. } => {
            let point = |[deg, value]: &[f64; 2]| (rad_from_deg(*deg), *value);
            let points = |curve: &Curve| curve.points.iter().map(point).collect();
            let trace = |curve: &Curve| Trace { name: curve.name.clone(), points: points(curve) };
            let traces: Vec<_> = curves.iter().map(trace).collect();
            polar(title, &traces, limit(traces.iter().map(|t| &t.points)), y_unit)
        }
        Plot::Xy { x, y, curves } => {
            let series: Vec<_> = curves
                .iter()
                .zip(Mark::LINES)
                .map(|(curve, (mark, _))| Series { name: curve.name.clone(), mark, points: points(curve) })
                .collect();
            let y_limit = limit(series.iter().map(|s| &s.points));
            xy_chart(&XyChart {
                title,
                x_name: &axis(x),
                y_name: &axis(y),
                y: (-y_limit, y_limit),
                series: &series,
                marks_on_x: &[],
            })
        }
        Plot::Path { unit, names, curves } => {
            let paths: Vec<_> = curves.iter().map(|c| (c.name.clone(), points(c))).collect();
            let names = names.clone().map(|name| axis(&AxisName { name, unit: unit.clone() }));
            path_chart(title, [&names[0], &names[1]], &paths)
        }
        Plot::Bars { unit, bars } => {
            let bar = |bar: &NamedAmount| Ranked {
                name: bar.name.clone(),
                amount: bar.amount,
                remark: bar.remark.clone(),
            };
            ranked(title, &unit_on_screen(unit), &bars.iter().map(bar).collect::<Vec<_>>())
        }
        Plot::PlaneMap { names, magnification, places } => {
            let places: Vec<_> = places.iter().map(|place| magnified(place, *magnification)).collect();
            let caption = format!("{title}; magnification of deviations {magnification:.0}");
            displaced(title, &caption, (&names[0], &names[1]), &places)
        }
    }
}

fn points(curve: &Curve) -> Vec<(f64, f64)> {
    curve.points.iter().map(|[x, y]| (*x, *y)).collect()
}

/// A round number above everything drawn.
fn limit<'a>(curves: impl Iterator<Item = &'a Vec<(f64, f64)>>) -> f64 {
    let all = curves.flatten().map(|p| p.1.abs()).filter(|v| v.is_finite());
    end_above(all.fold(0.0, f64::max))
}

/// Name and unit.
fn axis(axis: &AxisName) -> String {
    let unit = unit_on_screen(&axis.unit);
    match (axis.name.is_empty(), unit.is_empty()) {
        (_, true) => axis.name.clone(),
        (true, false) => unit,
        (false, false) => format!("{} ({unit})", axis.name),
    }
}

fn magnified(place: &MapPlace, magnification: f64) -> Displaced {
    let [x, y] = place.commanded_mm;
    let off = |[dx, dy]: [f64; 2]| (x + mm_from_um(dx) * magnification, y + mm_from_um(dy) * magnification);
    Displaced {
        commanded: (x, y),
        measured: off(place.measured_off_um),
        predicted: place.simulated_off_um.map(off),
    }
}
