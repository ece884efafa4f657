//! Commanded, measured and predicted places of the table, deviations magnified (S1 Fig. 5 and 8).

use crate::markup::escape;
use crate::number::degrees;
use crate::svg::{Displaced, displaced, nice_above};
use crate::views::{Axes, at_station, rms_um, stations};
use crate::{CompareInput, Place, PointView};
use nalgebra::Vector3;
use trunnion_core::AxisLetter;

/// The largest deviation is drawn at about this share of the size of the picture.
const DRAWN_SHARE: f64 = 0.25;

pub fn section(input: &CompareInput) -> String {
    let axes = Axes::of(&input.rotary, &input.points);
    let Some(turning) = axes.turning.filter(|_| !input.on_the_fly) else { return String::new() };
    let three =
        |p: &&PointView| input.setups.get(p.setup).is_some_and(|s| s.components.len() == 3) && !p.outlier;
    let tilts = axes.tilting.map_or(vec![0.0], |letter| stations(&input.points, letter));
    let at = |p: &PointView, tilt: f64| axes.tilting.is_none_or(|l| at_station(p, l, tilt, &tilts));
    let upright = tilts.iter().copied().min_by(|a, b| a.abs().total_cmp(&b.abs()));
    let worst = tilts.iter().copied().filter(|t| Some(*t) != upright).max_by(|a, b| {
        let size = |tilt: f64| rms_um(input, input.points.iter().filter(|p| at(p, tilt)));
        size(*a).total_cmp(&size(*b))
    });
    let Some(setup) = input.points.iter().find(three).map(|p| p.setup) else { return String::new() };
    let one_way = |p: &&PointView| p.setup == setup && p.direction[turning] >= 0.0;
    let shown: Vec<&PointView> = input.points.iter().filter(three).filter(one_way).collect();
    let (across, up) = plane_across(axes.tilting);
    let mut pictures = String::new();
    let magnification = magnification(&shown);
    for tilt in [upright, worst].into_iter().flatten() {
        let here: Vec<_> = shown.iter().filter(|p| at(p, tilt)).collect();
        let place = axes.tilting.map_or(String::new(), |l| format!(" at {l} = {}", degrees(tilt)));
        let names = ["X", "Y", "Z"];
        let machine = here.iter().map(|p| picture(p, &p.in_machine, magnification, (across, up)));
        let title = format!("{}{} plane of the machine{place}", names[across], names[up]);
        pictures += &displaced(&title, &title, (names[across], names[up]), &machine.collect::<Vec<_>>());
        let table = here.iter().map(|p| picture(p, &p.in_table_plane, magnification, (0, 1)));
        let title = format!("Plane of the table{place}");
        pictures += &displaced(&title, &title, ("across", "up"), &table.collect::<Vec<_>>());
    }
    let name = &input.setups[setup].name;
    let words = format!(
        "Setup {name}, {turning} forward. Dot: commanded place. Circle: measured. Cross: predicted. The orange line from cross \
         to circle is what the model misses. Deviations are magnified {} times.",
        thousands(magnification)
    );
    format!(
        "<section class=\"page\"><h2>Commanded, measured and predicted places</h2>\n<p class=\"soft\">{}</p>\n\
         <div class=\"plots\">{pictures}</div></section>\n",
        escape(&words)
    )
}

/// The plane in which the tilting axis turns.
fn plane_across(tilting: Option<AxisLetter>) -> (usize, usize) {
    match tilting {
        Some(AxisLetter::A) => (1, 2),
        _ => (0, 2),
    }
}

fn picture(point: &PointView, place: &Place, magnification: f64, (i, j): (usize, usize)) -> Displaced {
    let shifted = |reading_mm: [f64; 3]| {
        let shift = place.shift_from_reading * Vector3::from(reading_mm) * magnification;
        let moved = place.commanded_mm + shift;
        (moved[i], moved[j])
    };
    Displaced {
        commanded: (place.commanded_mm[i], place.commanded_mm[j]),
        measured: shifted(point.measured_mm),
        predicted: Some(shifted(point.predicted_mm)),
    }
}

/// A round factor that makes the largest deviation visible without leaving the picture; at most S1's 10 000.
fn magnification(points: &[&PointView]) -> f64 {
    let size = |p: &&PointView| p.in_table_plane.commanded_mm.norm();
    let extent_mm = points.iter().map(size).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let shift = |p: &&PointView| Vector3::from(p.measured_mm).norm();
    let largest_mm = points.iter().map(shift).filter(|v| v.is_finite()).fold(0.0, f64::max);
    if extent_mm <= 0.0 || largest_mm <= 0.0 {
        return 1000.0;
    }
    nice_above(DRAWN_SHARE * extent_mm / largest_mm).clamp(10.0, 10_000.0)
}

fn thousands(number: f64) -> String {
    let digits = format!("{number:.0}");
    match digits.len() {
        0..=3 => digits,
        n => format!("{} {}", &digits[..n - 3], &digits[n - 3..]),
    }
}
