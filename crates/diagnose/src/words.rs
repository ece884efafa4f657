//! Sentences of a diagnosis.

use trunnion_effects::Instance;

/// Errors before and after, µm.
pub struct Numbers {
    pub before_um: f64,
    pub after_um: f64,
    pub noise_um: f64,
    pub holdout_before_um: f64,
    pub holdout_after_um: f64,
}

/// What an effect is, its likely cause, and what adding it does.
pub fn why(instance: &Instance, numbers: &Numbers, adequate: bool) -> String {
    let mut sentences = Vec::new();
    if let Some(about) = instance.about() {
        sentences.push(about.explanation.to_string());
        sentences.push(format!("Likely cause: {}", about.cause));
    }
    sentences.push(format!(
        "With it the error falls from {:.2} to {:.2} µm (on data left out of the fit from {:.2} to {:.2} µm; noise floor {:.2} µm).",
        numbers.before_um, numbers.after_um, numbers.holdout_before_um, numbers.holdout_after_um, numbers.noise_um
    ));
    sentences.push(if adequate {
        "Nothing structured remains.".into()
    } else {
        "A part remains that it does not explain.".into()
    });
    sentences.join(" ")
}

/// The measurement that tells an effect from its rivals; empty without rivals.
pub fn separate_by(instance: &Instance, rivals: &[&Instance]) -> String {
    if rivals.is_empty() {
        return String::new();
    }
    let seen_by =
        |instance: &Instance| instance.about().map_or("", |about| about.seen_by).trim_end_matches('.');
    let mut parts = vec![format!("{} shows in: {}", instance.id(), seen_by(instance))];
    parts.extend(rivals.iter().map(|rival| format!("{} in: {}", rival.id(), seen_by(rival))));
    format!("{}.", parts.join("; "))
}

/// Where a phrase of the grammar lives.
pub fn lives(site: &str, components: &[&str], words: &str) -> String {
    let what = |component: &&str| match *component {
        "dx" => "displacement along X",
        "dy" => "displacement along Y",
        "dz" => "displacement along Z",
        "ea" => "rotation about X",
        "eb" => "rotation about Y",
        _ => "rotation about Z",
    };
    let what = components.iter().map(what).collect::<Vec<_>>().join(" and ");
    let place = match site.strip_prefix("axis:") {
        Some(axis) => format!("at axis {axis}, in the axes of what carries it"),
        None if site == "ball" => "of the ball or nest on the table, in table axes".into(),
        None => format!("of the {site}"),
    };
    format!("{what} {place}: {words}")
}
