//! The catalogue as a document for people, `docs/catalogue.md`.

use crate::catalogue::{BASE, REGISTRY};
use crate::{Effect, Instance, Subject};
use std::fmt::Write;
use trunnion_machine::shipped;

/// Text of `docs/catalogue.md`. Written by `cargo run -p trunnion-effects --example catalogue > docs/catalogue.md`;
/// a test compares the two.
pub fn catalogue_markdown() -> String {
    let mut text = String::from(
        "<!-- Generated: cargo run -p trunnion-effects --example catalogue > docs/catalogue.md -->\n\n\
         # Catalogue of effects\n\n\
         Everything that Trunnion can name as the cause of an error. R stands for a rotary axis, L for a linear one, \
         K for any axis. Sources: S0 Kenno 2020, S1 Oyama, S2 Ibaraki & Knapp 2012, S3 Hayashi 2021, \
         S4 Ibaraki (ball bar DBB5), METHODS (the methods document), ISO standards by number. \
         Anything else can be written as a `formula:NAME` effect in a model file.\n\n\
         | effect | what it is | typical |\n|---|---|---|\n",
    );
    for effect in REGISTRY {
        let about = &effect.about;
        line(&mut text, format_args!("| `{}` | {} | {} |", pattern(effect), about.title, about.typical));
    }
    for effect in REGISTRY {
        let about = &effect.about;
        line(&mut text, format_args!("\n## `{}`: {}\n\n{}", pattern(effect), about.title, about.explanation));
        if BASE.contains(&effect.phenomenon) {
            line(&mut text, format_args!("Always in the model."));
        }
        for (name, content) in [
            ("Likely cause", about.cause),
            ("Seen by", about.seen_by),
            ("Equation", about.equation),
            ("Valid", about.validity),
            ("Typical", about.typical),
            ("Source", about.source),
        ] {
            let gap = if name == "Likely cause" { "\n" } else { "" };
            line(&mut text, format_args!("{gap}- **{name}:** {content}"));
        }
    }
    line(&mut text, format_args!("\n## Ids by machine\n"));
    for (name, _) in shipped::FILES {
        let machine = shipped::machine(name).expect("shipped machines parse (tested)");
        let ids: Vec<_> =
            Instance::all(&machine).iter().map(|instance| format!("`{}`", instance.id())).collect();
        line(&mut text, format_args!("- **{name}:** {}", ids.join(" ")));
    }
    text
}

/// `gravity-sag:R` for an effect of axes, from its instances on the shipped machines.
fn pattern(effect: &Effect) -> String {
    let mut letter = None;
    for (name, _) in shipped::FILES {
        let machine = shipped::machine(name).expect("shipped machines parse (tested)");
        for subject in (effect.subjects)(&machine) {
            letter = match (subject, letter) {
                (Subject::Whole, _) => return effect.phenomenon.into(),
                (Subject::Pair(..), _) => Some("LL"),
                (Subject::Axis(axis), Some("R")) if !axis.is_rotary() => Some("K"),
                (Subject::Axis(axis), Some("L")) if axis.is_rotary() => Some("K"),
                (Subject::Axis(_), Some(known)) => Some(known),
                (Subject::Axis(axis), None) => Some(if axis.is_rotary() { "R" } else { "L" }),
            };
        }
    }
    format!("{}:{}", effect.phenomenon, letter.unwrap_or("R"))
}

fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    writeln!(text, "{arguments}").expect("a String takes everything");
}
