//! A filed report in short.

use crate::number::{trimmed, value_and_u};
use crate::words::headline;
use trunnion_results::{Judged, Report};

/// What was found, pass or fail, and which files were written.
pub fn report_text(report: &Report) -> String {
    let mut text = format!("{}\n", headline(&report.comparison));
    if let Some(conformity) = &report.conformity {
        let line = |name: &str, judged: &Judged| {
            let (value, u) = value_and_u(Some(judged.largest_um), Some(judged.u_um), "um");
            format!(
                "{name}: {}, largest deviation {value} (u {u}) at {}\n",
                judged.decision.words(),
                judged.at
            )
        };
        text +=
            &format!("Tolerance {} µm ({})\n", trimmed(conformity.tolerance_um, 3), conformity.tolerance_of);
        text += &line("  as measured", &conformity.as_measured);
        text += &line("  expected once the model is corrected", &conformity.corrected);
    }
    for (name, file) in [("page", &report.html), ("PDF", &report.pdf), ("DCC", &report.dcc)] {
        if let Some(file) = file {
            text += &format!("{name}: {file}\n");
        }
    }
    if let Some(lacks) = &report.pdf_lacks {
        text += &format!("The PDF is not complete: {lacks}.\n");
    }
    text
}
