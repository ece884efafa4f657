//! Pictures of the two-height method, like S0 Fig. 5–10 (trajectories and displacements), 22 (components) and 23 (motions).

use super::error_motions::{Signs, error_motions};
use super::fit::{HeightFit, Heights};
use crate::common::turning::Turning;
use crate::findings::{AxisName, Chart, Curve, Plot};
use nalgebra::Vector3;
use trunnion_effects::Unit;

pub(super) fn charts(turning: &Turning, heights: &Heights, signs: &Signs) -> Vec<Chart> {
    let mut charts = measured(turning, heights);
    charts.extend(components(turning, heights));
    let group = format!("Error motions of {} (S0 Fig. 23)", turning.axis);
    for motion in error_motions(turning, heights, signs) {
        let curves = vec![Curve::new(motion.name.clone(), motion.points)];
        charts.extend(both_ways(&group, &motion.name, turning, motion.unit, curves));
    }
    charts
}

/// Trajectory of the ball and its displacements, setting included.
fn measured(turning: &Turning, heights: &Heights) -> Vec<Chart> {
    let group = "Displacement of the ball as measured, mean of the passes (S0 Fig. 6–10)";
    let [u, v, _] = turning.frame;
    let path = |set: &HeightFit| {
        let mut points: Vec<_> = set.measured_mm.iter().flatten().map(|m| (m.x, m.y)).collect();
        if turning.whole_turn() {
            points.extend(points.first().copied());
        }
        Curve::new(set.name.clone(), points)
    };
    let mut charts = vec![Chart {
        group: "Trajectory of the ball as measured, mean of the passes (S0 Fig. 5, 8)".into(),
        title: format!("Trajectory in {u} and {v}"),
        plot: Plot::Path {
            unit: Unit::UM,
            names: [u, v].map(|letter| letter.as_str().into()),
            curves: heights.sets.iter().map(path).collect(),
        },
    }];
    for k in 0..3 {
        let curves = heights.sets.iter().map(|set| over_angle(set, &set.measured_mm, |m| m[k])).collect();
        charts.extend(both_ways(
            group,
            &format!("Displacement in {}", turning.frame[k]),
            turning,
            Unit::UM,
            curves,
        ));
    }
    charts
}

/// What setting and centre leave, at each height.
fn components(turning: &Turning, heights: &Heights) -> Vec<Chart> {
    let group = "Error motion components at each height (S0 Fig. 22)";
    let mut charts = Vec::new();
    for k in 0..3 {
        let curves = heights.sets.iter().map(|set| over_angle(set, &set.motion_mm, |m| m[k])).collect();
        let title = format!("Component {}", turning.frame[k]);
        charts.extend(both_ways(group, &title, turning, Unit::UM, curves));
    }
    let radial = |set: &HeightFit| {
        let points = set.angles_rad.iter().zip(&set.motion_mm).filter_map(|(&angle, m)| {
            let (sin, cos) = angle.sin_cos();
            Some((angle, m.as_ref().map(|m| cos * m.x + sin * m.y)?))
        });
        Curve::new(set.name.clone(), points.collect())
    };
    charts.extend(both_ways(
        group,
        "Radial component",
        turning,
        Unit::UM,
        heights.sets.iter().map(radial).collect(),
    ));
    charts
}

fn over_angle(set: &HeightFit, of: &[Option<Vector3<f64>>], value: impl Fn(&Vector3<f64>) -> f64) -> Curve {
    let points = set.angles_rad.iter().zip(of).filter_map(|(&angle, m)| Some((angle, value(m.as_ref()?))));
    Curve::new(set.name.clone(), points.collect())
}

/// The same curves over the angle and around it.
fn both_ways(group: &str, title: &str, turning: &Turning, unit: Unit, curves: Vec<Curve>) -> [Chart; 2] {
    let chart = |plot| Chart { group: group.into(), title: title.into(), plot };
    [
        chart(Plot::Polar { unit, curves: curves.clone() }),
        chart(Plot::Xy {
            x: AxisName { name: turning.axis.to_string(), unit: Unit::DEG },
            y: AxisName { name: String::new(), unit },
            curves,
        }),
    ]
}
