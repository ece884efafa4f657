//! A report to be filed: the first page says what is wrong, how large, how sure, what to do, what was not seen, and pass or fail;
//! then whose report it is, where the model fails and why, what was not seen in full; every table at the end.

mod annex;
pub(crate) mod conformity;
mod identity;
mod not_seen;

use crate::added::by_whom;
use crate::certainty;
use crate::html::{self, PAGE_CSS};
use crate::language::{Language, translated};
use crate::markup::{element, escape, table};
use crate::number::{um, um_or_dash};
use crate::to_do::to_do;
use crate::words::{headline, verdict};
use trunnion_results::{Comparison, Report};

/// How a report is printed, in addition to what every page has.
const PRINT_CSS: &str = include_str!("filed/print.css");
/// Parts of the comparison that belong to the annex.
const ANNEX: [&str; 3] = ["parameters", "missing", "timing"];

/// The report as one page without outside assets, made to be printed on A4.
pub fn report_html(report: &Report, language: Language) -> String {
    let input = &report.comparison;
    let sections = html::compare_sections(input);
    let (annexed, shown): (Vec<_>, Vec<_>) = sections.into_iter().partition(|(name, _)| ANNEX.contains(name));
    let mut body = first_page(report) + &identity::section(report);
    for (_, section) in shown {
        body += &section;
    }
    body += &not_seen::in_full(input);
    body += "<h1 class=\"page\">Annex: every table</h1>\n";
    body += &annex::fit(&input.identification);
    for (_, section) in annexed {
        body += &section.replace("<section class=\"page\">", "<section>");
    }
    body += &annex::readings(&input.residuals);
    // On paper nobody opens what is closed.
    page(report, &translated(&body.replace("<details", "<details open=\"\""), language), language)
}

fn page(report: &Report, body: &str, language: Language) -> String {
    let say = |text: &str| language.say(text).unwrap_or_else(|| text.into());
    let identity = &report.identity;
    let known = [Some(&identity.machine), identity.serial.as_ref(), Some(&identity.written)];
    let known: Vec<&str> =
        known.into_iter().flatten().map(String::as_str).filter(|text| !text.is_empty()).collect();
    let title = format!("{}: {}", say("Trunnion report"), known.join(" · "));
    format!(
        "<!DOCTYPE html>\n<html lang=\"{}\"><head><meta charset=\"utf-8\"/>\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\
         <meta name=\"color-scheme\" content=\"light dark\"/><title>{}</title>\n<style>\n{PAGE_CSS}{PRINT_CSS}\
         @page{{@bottom-left{{content:\"{}\"}}}}\n</style></head>\n<body class=\"filed\"><main>\n{body}</main></body></html>\n",
        language.code(),
        escape(&title),
        in_css(&title),
    )
}

/// A string of CSS holds any text but quotes, backslashes, ends of lines and what would end the style.
fn in_css(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || "\"\\<>&".contains(c) { ' ' } else { c }).collect()
}

fn first_page(report: &Report) -> String {
    let input = &report.comparison;
    let identity = &report.identity;
    let not_recorded = |text: &Option<String>| text.clone().unwrap_or_else(|| "not recorded".into());
    let about = [
        ("Machine", vec![identity.machine.clone()]),
        ("Serial number", vec![not_recorded(&identity.serial)]),
        ("Operator", vec![not_recorded(&identity.operator)]),
        ("Measured", vec![identity::measured(identity)]),
        ("Probe calibration", identity::calibrated(identity)),
    ]
    .map(|(name, values)| {
        let values: String = values.iter().map(|value| element("dd", value)).collect();
        format!("<div>{}{values}</div>", element("dt", name))
    })
    .concat();
    format!(
        "<header><p class=\"soft\">Trunnion report</p>\n<dl class=\"about\">{about}</dl>\n<h1>{}</h1>\n{}</header>\n{}{}{}{}{}",
        escape(&headline(input)),
        verdict(input).iter().map(|text| element("p", text)).collect::<String>(),
        conformity::section(report),
        listed("What to do", &to_do(input), "ol"),
        listed("How sure this is", &certainty::sure(input), "ul"),
        listed("What was not seen", &not_seen::in_short(input), "ul"),
        before_and_after(input),
    )
}

fn listed(title: &str, items: &[String], list: &str) -> String {
    if items.is_empty() {
        return String::new();
    }
    let rows: String = items.iter().map(|item| element("li", item)).collect();
    format!("<section>{}<{list}>{rows}</{list}></section>\n", element("h2", title))
}

/// The ladder in short: what was added, and how the error fell.
fn before_and_after(input: &Comparison) -> String {
    let rows: Vec<Vec<String>> = input
        .ladder
        .added()
        .map(|(effect, row)| {
            let [by, when] = by_whom(row);
            vec![
                effect.into(),
                um(row.error_before_um),
                um(row.error_after_um),
                um_or_dash(row.holdout_before_um),
                um_or_dash(row.holdout_after_um),
                by,
                when,
            ]
        })
        .collect();
    let body = match rows.is_empty() {
        true => element("p", "No effect was added to this model yet."),
        false => {
            let head = [
                "effect added",
                "error before",
                "error after",
                "held-out before",
                "held-out after",
                "added by",
                "date",
            ];
            table("Error before and after each added effect, rms", &head, &[1, 2, 3, 4], &rows)
        }
    };
    format!("<section><h2>Before and after</h2>\n{body}</section>\n")
}
