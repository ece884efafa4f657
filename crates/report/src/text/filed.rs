//! A filed report in short.

use crate::filed::conformity;
use crate::number::{trimmed, value_and_u};
use crate::words::headline;
use trunnion_results::{Judged, Report};

/// What was found, pass or fail, and which files were written.
pub fn report_text(report: &Report) -> String {
    let mut text = format!("{}\n", headline(&report.comparison));
    if let Some(of_tolerance) = &report.conformity {
        let line = |(name, judged): (&str, &Judged)| {
            let (value, u) = value_and_u(Some(judged.largest_um), Some(judged.u_um), "um");
            format!(
                "  {name}: {}, largest deviation {value} (u {u}) at {}\n",
                judged.decision.words(),
                conformity::places(judged).join("; ")
            )
        };
        text += &format!(
            "Tolerance {} µm ({})\n",
            trimmed(of_tolerance.tolerance_um, 3),
            of_tolerance.tolerance_of
        );
        text.extend(conformity::rows(of_tolerance).into_iter().map(line));
        for remark in conformity::remarks(of_tolerance) {
            text += &format!("  {remark}\n");
        }
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
