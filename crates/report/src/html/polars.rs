//! Polar plots over the turning axis: what remains of radial, axial and tilt error motion, one plot per tilt.
//!
//! The residual as motion of the table side in the table plane's axes: radial = away from the turning axis,
//! tangential = along the turn, axial = along the axis; tilt = (radial high − radial low) / (z high − z low).
//! A ball on the axis has no radial direction: X and Y of the table plane are drawn instead (S0).

use crate::number::degrees;
use crate::svg::{Trace, end_above, polar};
use crate::views::{Axes, at_station, mean, stations};
use nalgebra::Vector3;
use trunnion_core::convert::{rad_from_deg, um_from_mm, urad_from_rad};
use trunnion_results::{ResidualPoint, Residuals};

/// A ball nearer than this to the turning axis counts as on it, mm.
const ON_AXIS_MM: f64 = 5.0;

pub fn section(residuals: &Residuals) -> String {
    let axes = Axes::of(residuals);
    let Some(turning) = axes.turning.filter(|_| residuals.points.len() > 2) else { return String::new() };
    let turns = stations(&residuals.points, turning);
    let tilts = axes.tilting.map_or(vec![0.0], |axis| stations(&residuals.points, axis));
    let at_tilt = |p: &ResidualPoint, tilt: f64| axes.tilting.is_none_or(|l| at_station(p, l, tilt, &tilts));
    let motion_at = |setup: usize, tilt: f64, turn: f64| -> Vector3<f64> {
        let here: Vec<_> = residuals
            .points
            .iter()
            .filter(|p| {
                p.setup == setup && !p.excluded && at_tilt(p, tilt) && at_station(p, turning, turn, &turns)
            })
            .map(motion_um)
            .collect();
        Vector3::from_fn(|k, _| mean(here.iter().map(|m| m[k]).filter(|v| v.is_finite())))
    };
    let mut motions: Vec<(String, Vec<Trace>)> = Vec::new();
    let mut leans: Vec<(String, Vec<Trace>)> = Vec::new();
    let pair = two_heights(residuals);
    for &tilt in &tilts {
        let place = axes
            .tilting
            .map_or(String::new(), |axis| format!("{} = {}", axis.name, degrees(rad_from_deg(tilt))));
        for (s, setup) in residuals.setups.iter().enumerate() {
            let around: Vec<_> = turns.iter().map(|&turn| (turn, motion_at(s, tilt, turn))).collect();
            let trace = |name: &str, k: usize| Trace {
                name: name.into(),
                points: around.iter().map(|(turn, m)| (rad_from_deg(*turn), m[k])).collect(),
            };
            let names = if on_axis(residuals, s) { ["X", "Y"] } else { ["radial", "tangential"] };
            let traces = vec![trace(names[0], 0), trace("axial", 2), trace(names[1], 1)];
            motions.push((joined(&place, &format!("setup {}", setup.name)), traces));
        }
        if let Some((low, high, height_mm)) = pair {
            let lean = |turn: f64| {
                let difference_um = motion_at(high, tilt, turn)[0] - motion_at(low, tilt, turn)[0];
                urad_from_rad(difference_um / um_from_mm(height_mm))
            };
            let points = turns.iter().map(|&turn| (rad_from_deg(turn), lean(turn))).collect();
            leans.push((place, vec![Trace { name: "tilt".into(), points }]));
        }
    }
    let mut body = plots(&motions, "µm");
    if !leans.is_empty() {
        body += "<h3>Residual tilt, from the two heights</h3>\n";
        body += &plots(&leans, "urad");
    }
    format!(
        "<section class=\"page\"><h2>Error motion of {} that the model leaves</h2>\n\
         <p class=\"soft\">Residual drawn as motion of the table around a zero circle; mean of both directions. \
         Outside the circle is positive: outward, up along the axis, forward.</p>\n{body}</section>\n",
        turning.name
    )
}

fn joined(place: &str, setup: &str) -> String {
    if place.is_empty() { setup.into() } else { format!("{place}, {setup}") }
}

fn plots(of: &[(String, Vec<Trace>)], unit: &str) -> String {
    let values = of.iter().flat_map(|(_, traces)| traces).flat_map(|t| t.points.iter().map(|p| p.1.abs()));
    let limit = end_above(values.filter(|v| v.is_finite()).fold(0.0, f64::max));
    let drawn = of.iter().map(|(title, traces)| polar(title, traces, limit, unit));
    format!("<div class=\"small\">{}</div>\n", drawn.collect::<String>())
}

/// Residual as motion of the table side: radial, tangential, axial; X, Y, Z when the ball is on the axis; µm.
fn motion_um(point: &ResidualPoint) -> Vector3<f64> {
    let place = &point.in_table_plane;
    let motion = Vector3::from(place.residual_um());
    let [x, y, _] = place.commanded_mm;
    let radius = x.hypot(y);
    if radius < ON_AXIS_MM {
        return motion;
    }
    let (cos, sin) = (x / radius, y / radius);
    Vector3::new(cos * motion.x + sin * motion.y, -sin * motion.x + cos * motion.y, motion.z)
}

fn on_axis(residuals: &Residuals, setup: usize) -> bool {
    let first = residuals.points.iter().find(|p| p.setup == setup);
    first.is_some_and(|p| {
        p.in_table_plane.commanded_mm[0].hypot(p.in_table_plane.commanded_mm[1]) < ON_AXIS_MM
    })
}

/// Two setups that differ in height alone: low, high, distance in mm.
fn two_heights(residuals: &Residuals) -> Option<(usize, usize, f64)> {
    let [first, second] = &residuals.setups[..] else { return None };
    let apart = Vector3::from(second.ball_in_table_mm) - Vector3::from(first.ball_in_table_mm);
    if apart.xy().norm() > 1.0 || apart.z.abs() < 1.0 || first.components.len() < 3 {
        return None;
    }
    Some(if apart.z > 0.0 { (0, 1, apart.z) } else { (1, 0, -apart.z) })
}
