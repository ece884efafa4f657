//! How sure the answer is: evidence in words, what it could be mistaken for, what to measure next, what is not observable.

use crate::certainty;
use crate::markup::{element, escape};
use crate::words::planned_words;
use trunnion_results::Comparison;

pub fn section(input: &Comparison) -> String {
    let Some(diagnosis) = &input.diagnosis else { return String::new() };
    let items = certainty::sure(input);
    let mut body = format!("<ul>{}</ul>\n", items.iter().map(|item| element("li", item)).collect::<String>());
    let next = certainty::measure_next(diagnosis);
    if !next.is_empty() {
        body += &format!("<p class=\"warn\"><b>Measure next:</b> {}</p>\n", escape(next));
    }
    if let Some(cycle) = diagnosis.next_cycle.as_ref().and_then(|next| next.cycle.as_ref()) {
        body += &element("p", &planned_words(cycle));
    }
    body += &unseen("This cycle cannot show", &diagnosis.not_visible);
    body += &unseen("Out of reach of these runs", &diagnosis.out_of_reach);
    format!("<section><h2>How sure this is</h2>\n{body}</section>\n")
}

fn unseen(words: &str, ids: &[String]) -> String {
    if ids.is_empty() {
        return String::new();
    }
    format!(
        "<details class=\"soft\"><summary>{} ({})</summary><p>{}</p></details>\n",
        escape(words),
        ids.len(),
        escape(&ids.join(", "))
    )
}
