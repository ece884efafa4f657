//! What a fit found, as CSV: its parameters, or the run in one line.

use trunnion_results::{Identification, RunResult};

/// `effect,parameter,value,u,unit,observable`: one line for a parameter; value and u are empty where it has none.
pub fn parameters_csv(fit: &Identification) -> String {
    let mut table = "effect,parameter,value,u,unit,observable\n".to_owned();
    for parameter in &fit.parameters {
        let number = |number: Option<f64>| number.map_or_else(String::new, |number| number.to_string());
        let cells = [
            parameter.effect.clone(),
            parameter.name.clone(),
            number(parameter.value),
            number(parameter.u),
            parameter.unit.clone(),
            u8::from(parameter.observable).to_string(),
        ];
        table += &(cells.map(|cell| quoted(&cell)).join(",") + "\n");
    }
    table
}

/// `effects,verdict,missing_effects,points,outliers,rms_um,repeatability_um,held_out_um,degrees_of_freedom`: one line, with the effects of
/// the model, and those that the kept answer of the run names as missing, separated by spaces. Without such an answer both its cells are
/// empty.
pub fn run_csv(fit: &Identification, kept: Option<&RunResult>) -> String {
    let number = |number: Option<f64>| number.map_or_else(String::new, |number| number.to_string());
    let cells = [
        quoted(&fit.effects.join(" ")),
        kept.map_or_else(String::new, |kept| kept.verdict.as_str().to_owned()),
        kept.map_or_else(String::new, |kept| quoted(&kept.missing_effects.join(" "))),
        fit.points.to_string(),
        fit.outliers.to_string(),
        fit.rms_um.to_string(),
        number(fit.noise_um),
        number(fit.holdout_rms_um),
        fit.degrees_of_freedom.to_string(),
    ];
    let names = "effects,verdict,missing_effects,points,outliers,rms_um,repeatability_um,held_out_um,degrees_of_freedom";
    format!("{names}\n{}\n", cells.join(","))
}

/// A name that a person wrote may hold what separates cells.
pub(crate) fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.into() }
}
