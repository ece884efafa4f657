//! What the model leaves along each axis, by period.

use crate::markup::element;
use crate::number::{plain, um};
use crate::svg::{Mark, Series, XyChart, end_above, xy_chart};
use crate::words::{not_judged, wave};
use trunnion_results::{AxisSpectrum, SpectraBeforeAfter};

/// The unit of a rotary axis.
const PER_TURN: &str = "per turn";

pub fn section(spectra: &[AxisSpectrum]) -> String {
    if spectra.is_empty() {
        return String::new();
    }
    let (mut charts, mut waves, mut number) = (String::new(), String::new(), 0);
    for axis in spectra {
        charts += &chart(axis, number + 1);
        number += axis.waves.len();
        waves.extend(axis.waves.iter().map(|one| element("li", &wave(&axis.axis, one))));
    }
    let open: String = spectra.iter().filter_map(not_judged).map(|words| element("p", &words)).collect();
    let waves = match (waves.is_empty(), open.is_empty()) {
        (true, true) => element("p", "No wave stands out of what remains."),
        (true, false) => String::new(),
        (false, _) => format!("<ol>{waves}</ol>\n"),
    };
    format!(
        "<section><h2>What repeats along the axes</h2>\n{waves}{open}<div class=\"plots\">{charts}</div>\n\
         <p class=\"soft\">Size of a wave in the residual at each frequency. Finer waves than the right end need closer positions.</p></section>\n"
    )
}

/// The axes along which a wave stood out of the residual without an effect, or positions were too few to say that none did, with the spectrum with
/// it; empty where there is no such axis.
pub fn before_and_after(spectra: &SpectraBeforeAfter) -> String {
    let chart = |before: &AxisSpectrum| {
        let after =
            spectra.after.iter().find(|after| after.axis == before.axis && after.unit == before.unit)?;
        let series = [("before", Mark::Line, before), ("after", Mark::Dashed, after)]
            .map(|(name, mark, of)| Series { name: name.into(), mark, points: curve(of) });
        let title = format!("Residual along {}, before and after", before.axis);
        Some(drawn(&title, before, &series, 1))
    };
    let charts: String = spectra
        .before
        .iter()
        .filter(|axis| !axis.waves.is_empty() || !axis.judged)
        .filter_map(chart)
        .collect();
    match charts.is_empty() {
        true => charts,
        false => format!(
            "<h3>What repeated along the axes, before and after</h3>\n<div class=\"plots\">{charts}</div>\n"
        ),
    }
}

/// Along a line, waves per mm, so that harmonics stand at equal distances.
fn at(spectrum: &AxisSpectrum, value: f64) -> f64 {
    if spectrum.unit == PER_TURN { value } else { 1.0 / value }
}

fn curve(spectrum: &AxisSpectrum) -> Vec<(f64, f64)> {
    spectrum.curve.iter().map(|[value, rms_um]| (at(spectrum, *value), *rms_um)).collect()
}

fn x_name(spectrum: &AxisSpectrum) -> &'static str {
    if spectrum.unit == PER_TURN { "cycles per turn" } else { "waves per mm" }
}

/// Its waves are numbered from `first` on.
fn chart(spectrum: &AxisSpectrum, first: usize) -> String {
    let title = format!(
        "Residual along {}, {} in all, up to {} {}",
        spectrum.axis,
        um(spectrum.rms_um),
        plain(at(spectrum, spectrum.limit)),
        x_name(spectrum)
    );
    let name = format!("wave along {}", spectrum.axis);
    drawn(&title, spectrum, &[Series { name, mark: Mark::Line, points: curve(spectrum) }], first)
}

/// Curves over the frequencies of an axis, whose waves are numbered from `first` on.
fn drawn(title: &str, spectrum: &AxisSpectrum, series: &[Series], first: usize) -> String {
    let marks: Vec<(f64, String)> = (first..)
        .zip(&spectrum.waves)
        .map(|(number, wave)| (at(spectrum, wave.period.value), number.to_string()))
        .collect();
    let points = series.iter().flat_map(|one| &one.points);
    let y_limit = end_above(points.fold(0.0, |limit: f64, point| limit.max(point.1)));
    xy_chart(&XyChart {
        title,
        x_name: x_name(spectrum),
        y_name: "µm rms",
        series,
        y: (0.0, y_limit),
        marks_on_x: &marks,
    })
}
