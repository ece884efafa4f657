//! What was found before each effect was added: where the model failed, the residual before next to after, which effect, its rivals, and
//! the fall. It stays in the report as long as the effect is in the model.

use super::{places, spectrum, trial};
use crate::added::as_found;
use crate::markup::{element, escape};
use crate::words::effect_name;
use trunnion_results::{Comparison, Trial};

pub fn section(input: &Comparison) -> String {
    input.added.iter().map(|trial| step(input, trial)).collect()
}

fn step(input: &Comparison, trial: &Trial) -> String {
    let row = input.ladder.added().find(|(effect, _)| *effect == trial.effect);
    let said = row.map_or_else(Vec::new, |(_, row)| as_found(trial, row));
    let said: String = said.iter().map(|sentence| element("p", sentence)).collect();
    let failed = match trial.places.before.is_empty() {
        true => String::new(),
        false => format!(
            "<h3>Where the model failed before it was added</h3>\n{}",
            places::list(&trial.places.before, "")
        ),
    };
    format!(
        "<section><h2>{}</h2>\n{failed}{said}{}{}{}</section>\n",
        escape(&format!("Found and added: {}", effect_name(&trial.effect))),
        trial::clearest_maps(trial),
        spectrum::before_and_after(&trial.spectra),
        trial::size_table(trial)
    )
}
