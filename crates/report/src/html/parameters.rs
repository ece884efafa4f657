//! Parameters of the model with their uncertainty, and what cannot be distinguished.

use crate::markup::{element, escape, table};
use crate::number::value_and_u;
use trunnion_results::sentences::inadequate;
use trunnion_results::{Combination, Comparison, Parameter};

fn cells(p: &Parameter) -> Vec<String> {
    let (value, u) = value_and_u(p.value, p.u, &p.unit);
    vec![p.name.clone(), value, u, p.note.clone()]
}

fn together(c: &Combination) -> Vec<String> {
    let (value, u) = value_and_u(Some(c.value), Some(c.u), &c.unit);
    vec![c.combination.clone(), value, u, String::new()]
}

pub fn section(input: &Comparison) -> String {
    let fit = &input.identification;
    let listed = fit.listed();
    let mut effects: Vec<&str> = listed.iter().map(|p| p.effect.as_str()).collect();
    effects.dedup();
    let mut body = inadequate(fit).map_or(String::new(), |sentence| element("p", &sentence));
    for effect in effects {
        let rows: Vec<_> = listed.iter().filter(|p| p.effect == effect).map(cells).collect();
        let head = ["parameter", "value", "standard uncertainty", "remark"];
        body += &table(&crate::words::effect_name(effect), &head, &[1, 2], &rows);
    }
    if listed.is_empty() {
        body += &element("p", "The model has no parameters.");
    }
    if !fit.seen_together.is_empty() {
        let rows: Vec<Vec<String>> = fit.seen_together.iter().map(together).collect();
        let head = ["seen only together", "value", "standard uncertainty", "remark"];
        body += &table("Combinations", &head, &[1, 2], &rows);
    }
    if !fit.unobservable.is_empty() {
        let rows: String = fit
            .unobservable
            .iter()
            .map(|row| format!("<li><b>{}</b>: {}</li>", escape(&row.direction), escape(&row.why)))
            .collect();
        body += &format!("<h3>What these readings leave confounded</h3>\n<ul>{rows}</ul>\n");
    }
    format!("<section class=\"page\"><h2>Location errors and other parameters</h2>\n{body}</section>\n")
}
