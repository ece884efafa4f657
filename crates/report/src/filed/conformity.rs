//! Pass or fail on the first page.

use crate::markup::{element, escape, scrolling};
use crate::number::{trimmed, um, value_and_u};
use crate::words::effect_name;
use trunnion_results::{Conformity, Decision, Judged, Report, Verdict};

pub fn section(report: &Report) -> String {
    let body = match &report.conformity {
        Some(conformity) => {
            let rows: String = rows(conformity).iter().map(|(name, judged)| row(name, judged)).collect();
            let n = " class=\"n\"";
            let head = [
                ("machine", ""),
                ("largest deviation", n),
                ("standard uncertainty", n),
                ("where", ""),
                ("decision", ""),
            ];
            let head = head.map(|(name, class)| format!("<th scope=\"col\"{class}>{name}</th>")).concat();
            let table = format!("<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>");
            format!(
                "<p><span>Tolerance:</span> <b>{}</b> <span class=\"soft\">(<span>{}</span>)</span></p>\n\
                 {}\n\
                 <p class=\"soft\">Decision rule: ISO 14253-1, guard band 1.65 u.</p>\n{}",
                escape(&format!("{} µm", trimmed(conformity.tolerance_um, 3))),
                escape(&conformity.tolerance_of),
                scrolling("Tolerance", &table),
                remarks(conformity).iter().map(|remark| element("p", remark) + "\n").collect::<String>(),
            )
        }
        None => element("p", without(report)),
    };
    format!("<section class=\"conformity\"><h2>Tolerance</h2>\n{body}</section>\n")
}

/// The machine as it is, and as it is to be expected with a correction, where a control takes one.
pub(crate) fn rows(conformity: &Conformity) -> Vec<(&'static str, &Judged)> {
    let corrected =
        Some(("expected after a correction", &conformity.corrected)).filter(|_| !is_without(conformity));
    [Some(("as measured", &conformity.as_measured)), corrected].into_iter().flatten().collect()
}

fn is_without(conformity: &Conformity) -> bool {
    !conformity.why_not_corrected.is_empty()
}

/// What a decision waits for, and what a correction would hold.
pub(crate) fn remarks(conformity: &Conformity) -> Vec<String> {
    let waits = |(_, judged): &(&str, &Judged)| judged.waits_for_excluded(conformity.tolerance_um);
    let mut remarks = Vec::new();
    if rows(conformity).iter().any(waits) {
        remarks.push(
            "Not decidable: a point that was excluded from the fit is not within the tolerance. Measure its pose again."
                .into(),
        );
    }
    if is_without(conformity) {
        remarks.push(format!("No correction is expected: {}.", conformity.why_not_corrected));
        return remarks;
    }
    let mut left: Vec<String> =
        conformity.not_corrected.iter().map(|left| effect_name(&left.effect)).collect();
    left.dedup();
    remarks.push(match left.as_slice() {
        [] => "The correction holds the errors of the axes as tables over their positions.".into(),
        left => format!(
            "The correction holds the errors of the axes as tables over their positions. Left in: {}.",
            left.join("; ")
        ),
    });
    remarks
}

/// Where a deviation was, and what was excluded.
pub(crate) fn places(judged: &Judged) -> Vec<String> {
    let excluded = judged.excluded.as_ref().map(|excluded| {
        let largest = um(excluded.largest_um);
        match excluded.count {
            1 => format!("1 point excluded from the fit: {largest} at {}", excluded.at),
            count => format!("{count} points excluded from the fit: up to {largest} at {}", excluded.at),
        }
    });
    [Some(judged.at.clone()), excluded].into_iter().flatten().collect()
}

fn without(report: &Report) -> &'static str {
    match report.comparison.diagnosis.as_ref().map(|diagnosis| diagnosis.verdict) {
        Some(Verdict::NotJudged) => "Not decided: the runs were not judged.",
        _ => "Not decided: neither the machine file nor the command gives a tolerance.",
    }
}

fn row(name: &str, judged: &Judged) -> String {
    let (value, u) = value_and_u(Some(judged.largest_um), Some(judged.u_um), "um");
    let class = match judged.decision {
        Decision::Pass => "pass",
        Decision::Fail => "fail",
        Decision::NotDecidable => "open",
    };
    format!(
        "<tr><td>{name}</td><td class=\"n\">{value}</td><td class=\"n\">{u}</td><td>{}</td>\
         <td><b class=\"{class}-mark\">{}</b></td></tr>\n",
        places(judged).iter().map(|place| escape(place)).collect::<Vec<_>>().join("<br>"),
        judged.decision.words()
    )
}
