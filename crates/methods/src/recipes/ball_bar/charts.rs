//! Pictures of the ball-bar method, like S4 Fig. 6–11: traces after centring, and error motions.

use super::error_motions::error_motions;
use super::found::Found;
use super::shape::{Contour, Shape};
use super::track::{Axis, Kind};
use crate::findings::{AxisName, Chart, Curve, Plot};
use trunnion_effects::Unit;

pub(super) fn charts(found: &Found<'_>) -> Vec<Chart> {
    let mut charts = Vec::new();
    for axis in axes(found.shapes) {
        let group = format!("Traces of {} about their centres (S4 Fig. 6–10)", axis.letter);
        for k in 0..2 {
            let across =
                |s: &&Shape| matches!(s.kind, Kind::Across { axis: a, k: of, .. } if a == axis && of == k);
            let traces: Vec<&Shape> = found.shapes.iter().filter(across).collect();
            if !traces.is_empty() {
                let curves = traces.iter().map(|s| Curve::new(&*s.label, closed(&s.mean_contour))).collect();
                charts.push(polar(&group, format!("Bar along {}", axis.frame[k]), Unit::UM, curves));
            }
        }
        for shape in
            found.shapes.iter().filter(|s| matches!(s.kind, Kind::Along { .. } | Kind::Followed { .. }))
        {
            if shape.kind.axis() == Some(axis) {
                charts.push(polar(&group, shape.label.clone(), Unit::UM, directions(shape)));
            }
        }
    }
    for motions in found.axes {
        let group = format!("Error motions of {}", motions.axis.letter);
        for motion in error_motions(motions) {
            let curves = vec![Curve::new(&*motion.name, motion.points.clone())];
            charts.push(polar(
                &group,
                motion.name.clone(),
                motion.unit,
                vec![Curve::new(&*motion.name, closed(&motion.points))],
            ));
            let plot = Plot::Xy {
                x: AxisName { name: motions.axis.letter.to_string(), unit: Unit::DEG },
                y: AxisName { name: String::new(), unit: motion.unit },
                curves,
            };
            charts.push(Chart { group: group.clone(), title: motion.name, plot });
        }
    }
    for shape in found.shapes.iter().filter(|shape| shape.kind == Kind::Path) {
        let group = "Radial error over the path (S4 Fig. 11)";
        charts.push(polar(group, shape.label.clone(), Unit::UM, directions(shape)));
        let plot = Plot::Xy {
            x: AxisName { name: "way around".into(), unit: Unit::DEG },
            y: AxisName { name: String::new(), unit: Unit::UM },
            curves: shape.contours.iter().map(|(d, c)| Curve::new(way(*d), c.clone())).collect(),
        };
        charts.push(Chart { group: group.into(), title: shape.label.clone(), plot });
    }
    charts
}

fn axes(shapes: &[Shape]) -> Vec<Axis> {
    let mut axes: Vec<Axis> = Vec::new();
    for axis in shapes.iter().filter_map(|shape| shape.kind.axis()) {
        if !axes.contains(&axis) {
            axes.push(axis);
        }
    }
    axes
}

fn directions(shape: &Shape) -> Vec<Curve> {
    shape.contours.iter().map(|(direction, contour)| Curve::new(way(*direction), closed(contour))).collect()
}

fn way(direction: f64) -> &'static str {
    if direction < 0.0 { "backward" } else { "forward" }
}

/// The first point once more where the trace goes around.
fn closed(contour: &Contour) -> Contour {
    let angles: Vec<f64> = contour.iter().map(|(angle, _)| *angle).collect();
    let first = contour.first().filter(|_| super::track::whole_turn(&angles));
    contour
        .iter()
        .copied()
        .chain(first.map(|(angle, value)| (angle + std::f64::consts::TAU, *value)))
        .collect()
}

fn polar(group: &str, title: String, unit: Unit, curves: Vec<Curve>) -> Chart {
    Chart { group: group.into(), title, plot: Plot::Polar { unit, curves } }
}
