//! What these runs do not show: in short for the first page, in full before the annex.

use crate::markup::{element, escape};
use crate::words::{effect_name, effect_title, is_failed, is_location, is_setting, unnumbered_locations};
use trunnion_results::{Comparison, Complete, Verdict, sentences};

/// Groups of effects that the first page names; the rest is counted.
const MOST_NAMED: usize = 6;

/// For the first page; never empty.
pub fn in_short(input: &Comparison) -> Vec<String> {
    let fit = &input.identification;
    let mut said: Vec<String> = Vec::new();
    if fit.complete.planned.is_some_and(|planned| planned != fit.complete.read) {
        said.extend(sentences::complete(&Complete { losses: Vec::new(), ..fit.complete.clone() }));
    }
    said.extend(input.losses.iter().map(|loss| format!("Data loss: {loss}")));
    said.extend(input.left_out.iter().cloned());
    let without: Vec<_> = fit.parameters.iter().filter(|p| !p.observable && !is_setting(&p.effect)).collect();
    let locations: Vec<&str> =
        without.iter().map(|p| p.name.as_str()).filter(|name| is_location(name)).collect();
    if !locations.is_empty() {
        said.push(format!(
            "Location errors without a number of their own: {}.",
            unnumbered_locations(&locations).join("; ")
        ));
    }
    let mut others: Vec<&str> =
        without.iter().filter(|p| !is_location(&p.name)).map(|p| p.effect.as_str()).collect();
    others.dedup();
    if !others.is_empty() {
        let names: Vec<String> = others.iter().map(|id| effect_name(id)).collect();
        said.push(format!("Effects with numbers that are not known: {}.", names.join("; ")));
    }
    match &input.diagnosis {
        Some(diagnosis) if diagnosis.verdict != Verdict::NotJudged => {
            said.extend(listed(
                "This cycle cannot show, because the model imitates it",
                &diagnosis.not_visible,
            ));
            said.extend(listed("These runs cannot have", &diagnosis.out_of_reach));
        }
        _ if is_failed(input) => {
            said.push("Whether an effect is missing is not known, because the diagnosis failed.".into());
        }
        _ => said.push("Whether an effect is missing was not asked.".into()),
    }
    if said.is_empty() {
        said.push(ALL_SEEN.into());
    }
    said
}

/// Effects by title, with what each is of: `Backlash of the drive (X Y Z)`.
fn listed(words: &str, ids: &[String]) -> Option<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for id in ids {
        let of = id.split_once(':').map_or(id.as_str(), |(_, of)| of);
        match groups.iter_mut().find(|(title, _)| *title == effect_title(id)) {
            Some((_, all)) => all.push(of),
            None => groups.push((effect_title(id), vec![of])),
        }
    }
    let name = |(title, of): &(&str, Vec<&str>)| format!("{title} ({})", of.join(" "));
    let named = groups.iter().take(MOST_NAMED).map(name);
    let rest = groups.len().saturating_sub(MOST_NAMED);
    let rest = (rest > 0).then(|| format!("{rest} more, listed under \"What was not seen, in full\""));
    let names = named.chain(rest).collect::<Vec<_>>().join("; ");
    (!groups.is_empty()).then(|| format!("{words}: {names}."))
}

const ALL_SEEN: &str = "Everything in the model is observable in these runs.";

/// Every direction and every effect.
pub fn in_full(input: &Comparison) -> String {
    let fit = &input.identification;
    let mut body = String::new();
    let directions: String = fit
        .unobservable
        .iter()
        .map(|row| format!("<li><b>{}</b>: {}</li>", escape(&row.direction), escape(&row.why)))
        .collect();
    if !directions.is_empty() {
        body += &format!("<h3>What these readings leave confounded</h3>\n<ul>{directions}</ul>\n");
    }
    if let Some(diagnosis) = &input.diagnosis {
        for (title, ids) in [
            ("This cycle cannot show", &diagnosis.not_visible),
            ("Out of reach of these runs", &diagnosis.out_of_reach),
        ] {
            if !ids.is_empty() {
                let names: String = ids.iter().map(|id| element("li", &effect_name(id))).collect();
                body += &format!("<h3>{title}</h3>\n<ul class=\"columns\">{names}</ul>\n");
            }
        }
    }
    if body.is_empty() {
        body = element("p", ALL_SEEN);
    }
    format!("<section class=\"page\"><h2>What was not seen, in full</h2>\n{body}</section>\n")
}
