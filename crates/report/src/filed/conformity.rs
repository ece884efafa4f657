//! Pass or fail on the first page.

use crate::markup::{element, escape};
use crate::number::{trimmed, value_and_u};
use trunnion_results::{Decision, Judged, Report, Verdict};

pub fn section(report: &Report) -> String {
    let body = match &report.conformity {
        Some(conformity) => {
            let rows = [
                ("as measured", &conformity.as_measured),
                ("expected once the model is corrected", &conformity.corrected),
            ];
            let rows: String = rows.iter().map(|(name, judged)| row(name, judged)).collect();
            let head = ["machine", "largest deviation", "standard uncertainty", "where", "decision"];
            let head: String = head.iter().map(|name| format!("<th scope=\"col\">{name}</th>")).collect();
            format!(
                "<p><span>Tolerance:</span> <b>{}</b> <span class=\"soft\">(<span>{}</span>)</span></p>\n\
                 <div class=\"scroll\"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>\n\
                 <p class=\"soft\">Decision rule: ISO 14253-1, guard band 1.65 u.</p>\n",
                escape(&format!("{} µm", trimmed(conformity.tolerance_um, 3))),
                escape(&conformity.tolerance_of),
            )
        }
        None => element("p", without(report)),
    };
    format!("<section class=\"conformity\"><h2>Tolerance</h2>\n{body}</section>\n")
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
        escape(&judged.at),
        judged.decision.words()
    )
}
