//! What the model leaves along each axis, by period.

use crate::markup::element;
use crate::number::{plain, um};
use crate::svg::{Mark, Series, XyChart, end_above, xy_chart};
use crate::words::{not_judged, wave};
use trunnion_results::AxisSpectrum;

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

/// Its waves are numbered from `first` on.
fn chart(spectrum: &AxisSpectrum, first: usize) -> String {
    // Along a line, waves per mm, so that harmonics stand at equal distances.
    let per_turn = spectrum.unit == "per turn";
    let at = |value: f64| if per_turn { value } else { 1.0 / value };
    let points: Vec<(f64, f64)> =
        spectrum.curve.iter().map(|[value, rms_um]| (at(*value), *rms_um)).collect();
    let marks: Vec<(f64, String)> = (first..)
        .zip(&spectrum.waves)
        .map(|(number, wave)| (at(wave.period.value), number.to_string()))
        .collect();
    let y_limit = end_above(points.iter().fold(0.0, |limit: f64, point| limit.max(point.1)));
    let x_name = if per_turn { "cycles per turn" } else { "waves per mm" };
    let title = format!(
        "Residual along {}, {} in all, up to {} {x_name}",
        spectrum.axis,
        um(spectrum.rms_um),
        plain(at(spectrum.limit))
    );
    let series = [Series { name: format!("wave along {}", spectrum.axis), mark: Mark::Line, points }];
    xy_chart(&XyChart {
        title: &title,
        x_name,
        y_name: "µm rms",
        series: &series,
        y: (0.0, y_limit),
        marks_on_x: &marks,
    })
}
