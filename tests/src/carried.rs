//! What a number of an identification should be: the injected value, and what it carries of parameters that convention sets to zero.
//! Tests of other crates take this file in by its path.

use serde_json::Value;

/// What the parameter of that name carries of others: of each direction that is not observable, convention sets the first
/// parameter to zero, and the others stand for it.
///
/// # Panics
/// When this is no identification in JSON.
pub fn carried(identification: &Value, name: &str, true_value: &dyn Fn(&str) -> f64) -> f64 {
    let of_direction = |direction: &Value| {
        let terms = direction["terms"].as_array().unwrap();
        let term = |k: usize| (terms[k]["name"].as_str().unwrap(), terms[k]["coefficient"].as_f64().unwrap());
        let own = (1..terms.len()).map(term).find(|(other, _)| *other == name)?;
        Some(-true_value(term(0).0) * own.1)
    };
    identification["unobservable"].as_array().unwrap().iter().filter_map(of_direction).sum()
}
