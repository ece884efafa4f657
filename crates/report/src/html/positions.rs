//! Commanded, measured and predicted places of the table, deviations magnified (S1 Fig. 5 and 8).

use crate::markup::escape;
use crate::number::degrees;
use crate::svg::{Displaced, displaced, nice_above};
use crate::views::{Axes, Axis, at_station, rms_um, stations};
use trunnion_core::convert::{mm_from_um, rad_from_deg};
use trunnion_results::{ResidualPoint, Residuals, ShiftedPlace};

/// The largest deviation is drawn at about this share of the size of the picture.
const DRAWN_SHARE: f64 = 0.25;
/// Places of a picture beyond which every n-th is drawn: one every 5° once round, whose circles still lie apart.
const MOST_DRAWN: usize = 72;

pub fn section(residuals: &Residuals) -> String {
    let axes = Axes::of(residuals);
    let Some(turning) = axes.turning.filter(|_| !residuals.on_the_fly) else { return String::new() };
    let three = |p: &&ResidualPoint| {
        residuals.setups.get(p.setup).is_some_and(|s| s.components.len() == 3) && !p.excluded
    };
    let tilts = axes.tilting.map_or(vec![0.0], |axis| stations(&residuals.points, axis));
    let at = |p: &ResidualPoint, tilt: f64| axes.tilting.is_none_or(|l| at_station(p, l, tilt, &tilts));
    let upright = tilts.iter().copied().min_by(|a, b| a.abs().total_cmp(&b.abs()));
    let worst = tilts.iter().copied().filter(|t| Some(*t) != upright).max_by(|a, b| {
        let size = |tilt: f64| rms_um(residuals, residuals.points.iter().filter(|p| at(p, tilt)));
        size(*a).total_cmp(&size(*b))
    });
    let Some(setup) = residuals.points.iter().find(three).map(|p| p.setup) else { return String::new() };
    let one_way = |p: &&ResidualPoint| p.setup == setup && p.direction[turning.index] >= 0;
    let shown: Vec<&ResidualPoint> = residuals.points.iter().filter(three).filter(one_way).collect();
    let (across, up) = plane_across(axes.tilting);
    let mut pictures = String::new();
    let magnification = magnification(&shown);
    let mut most_places = 0;
    for tilt in [upright, worst].into_iter().flatten() {
        let mut here: Vec<_> = shown.iter().filter(|p| at(p, tilt)).collect();
        most_places = most_places.max(here.len());
        if every(here.len()) > 1 {
            // Evenly around.
            here.sort_by(|a, b| a.position[turning.index].total_cmp(&b.position[turning.index]));
        }
        let here: Vec<_> = here.iter().step_by(every(here.len())).collect();
        let place = axes
            .tilting
            .map_or(String::new(), |axis| format!(" at {} = {}", axis.name, degrees(rad_from_deg(tilt))));
        let names = ["X", "Y", "Z"];
        let machine = here.iter().map(|p| picture(&p.in_machine, magnification, (across, up)));
        let title = format!("{}{} plane of the machine{place}", names[across], names[up]);
        pictures += &displaced(&title, &title, (names[across], names[up]), &machine.collect::<Vec<_>>());
        let table = here.iter().map(|p| picture(&p.in_table_plane, magnification, (0, 1)));
        let title = format!("Plane of the table{place}");
        pictures += &displaced(&title, &title, ("across", "up"), &table.collect::<Vec<_>>());
    }
    let name = &residuals.setups[setup].name;
    let left_out = match every(most_places) {
        1 => String::new(),
        every => format!(" Of {most_places} places around {}, one in {every} is drawn.", turning.name),
    };
    let words = format!(
        "Setup {name}, {} forward. Dot: commanded place. Circle: measured. Cross: predicted. The orange line from cross \
         to circle is what the model misses. Deviations are magnified {} times.{left_out}",
        turning.name,
        thousands(magnification)
    );
    format!(
        "<section class=\"page\"><h2>Commanded, measured and predicted places</h2>\n<p class=\"soft\">{}</p>\n\
         <div class=\"plots\">{pictures}</div></section>\n",
        escape(&words)
    )
}

/// Of so many places every n-th is drawn.
fn every(places: usize) -> usize {
    places.div_ceil(MOST_DRAWN).max(1)
}

/// The plane in which the tilting axis turns.
fn plane_across(tilting: Option<Axis<'_>>) -> (usize, usize) {
    match tilting.map(|axis| axis.name) {
        Some("A") => (1, 2),
        _ => (0, 2),
    }
}

fn picture(place: &ShiftedPlace, magnification: f64, (i, j): (usize, usize)) -> Displaced {
    let shifted = |shift_um: [f64; 3]| {
        let moved = |k: usize| place.commanded_mm[k] + mm_from_um(shift_um[k]) * magnification;
        (moved(i), moved(j))
    };
    Displaced {
        commanded: (place.commanded_mm[i], place.commanded_mm[j]),
        measured: shifted(place.measured_um),
        predicted: Some(shifted(place.predicted_um)),
    }
}

/// A round factor that makes the largest deviation visible without leaving the picture; at most S1's 10 000.
pub fn magnification(points: &[&ResidualPoint]) -> f64 {
    let length = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let size = |p: &&ResidualPoint| length(&p.in_table_plane.commanded_mm);
    let extent_mm = points.iter().map(size).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let shift = |p: &&ResidualPoint| mm_from_um(length(&p.in_table_plane.measured_um));
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
