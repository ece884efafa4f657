//! The catalogue as a document for people, `docs/design/catalogue.md`, with a picture of each effect in `docs/design/catalogue/`.

use crate::catalogue::{BASE, REGISTRY};
use crate::sources::SOURCES;
use crate::{Effect, Instance, Need, PLACES_OF_A_VOLUME, Parameter, Scene, SceneSetup, Subject};
use nalgebra::Point3;
use std::fmt::Write;
use trunnion_core::{AxisValues, Joint, State};
use trunnion_machine::shipped;

const HEADER: &str = "\
<!-- Generated: cargo run -p trunnion-effects --example catalogue -->

# Catalogue of effects

Everything that Trunnion can name as the cause of an error. R stands for a rotary axis, L for a linear one, K for any
axis, LL for a pair of linear axes. Anything else can be written as a `formula:NAME` effect in a model file (at the end).

Sources: @SOURCES@, ISO standards by number;
all in [references](references.md). Where physics.md is named, the equation is derived in [physics](physics.md).

Each picture shows a typical case as an instrument reads it. Over poses (B and C) and turns it shows the residual of the
effect after a fit of location errors and ball setting: the shape to look for in a residual. Circles are
drawn enlarged around their nominal radius, after centring.
";

const FORMULAS: &str = "
## `formula:NAME`: what has no name

An expression of your own, or one found by `trunnion diagnose`, in the model file:

```toml
[[effect]]
id = \"formula:hose\"
site = \"axis:B\"            # axis:K, ball, spindle, reading
component = \"ea\"           # dx dy dz; at an axis also ea eb ec
expression = \"pull*max(0, B - start)\"
grid = { start = [0.2, 0.4, 0.6] }
```

- **Names of the state:** `A B C` rad, `X Y Z` mm, `vB` velocity and `aB` acceleration (rad/s, rad/s², mm/s, mm/s²), `dirB` direction −1, 0, +1,
  `sinceB` travel since B last turned round (rad, mm), `t` s since the first point, `T_NAME` change of temperature channel NAME, K; `pi`. Angles are in rad: 60° is `60*pi/180`.
- **Functions:** `sin cos tan exp log sqrt abs sign step` of one argument (`step(x)` is 0 below zero, 1 from zero on), `min max` of two; `+ - * / ^`.
- **Parameters:** every other name. One that multiplies a term is fitted, in µm (`dx dy dz`) or µrad (`ea eb ec`) per unit of its factor; every term needs one.
  One inside a function, a power or a divisor is a shape number: give its value as `shape = [..]` or values to try as `grid = { NAME = [..] }`.
";

/// Text of `docs/design/catalogue.md`. Written with its pictures by `cargo run -p trunnion-effects --example catalogue`;
/// a test compares them.
pub fn catalogue_markdown() -> String {
    let sources = SOURCES.map(|source| format!("{} {}", source.key, source.author)).join("; ");
    let mut text = HEADER.replace("@SOURCES@", &sources);
    line(&mut text, format_args!("\n| effect | what it is | typical | needs |\n|---|---|---|---|"));
    for effect in REGISTRY {
        let about = &effect.about;
        let title = format!("{}: {}", pattern(effect), about.title);
        line(
            &mut text,
            format_args!(
                "| [`{}`](#{}) | {} | {} | {} |",
                pattern(effect),
                anchor(&title),
                about.title,
                about.typical,
                texts(about.needs)
            ),
        );
    }
    for effect in REGISTRY {
        section(&mut text, effect);
    }
    text.push_str(FORMULAS);
    line(&mut text, format_args!("\n## Ids by machine\n"));
    for (name, _) in shipped::FILES {
        let machine = shipped::machine(name).expect("shipped machines parse (tested)");
        let ids: Vec<_> =
            Instance::all(&machine).iter().map(|instance| format!("`{}`", instance.id())).collect();
        line(&mut text, format_args!("- **{name}:** {}", ids.join(" ")));
    }
    text
}

fn section(text: &mut String, effect: &Effect) {
    let about = &effect.about;
    line(text, format_args!("\n## `{}`: {}\n\n{}", pattern(effect), about.title, about.explanation));
    if BASE.contains(&effect.phenomenon) {
        line(text, format_args!("Always in the model."));
    }
    line(text, format_args!("\n![{}](catalogue/{}.svg)\n", about.title, effect.phenomenon));
    for (name, content) in [
        ("Likely cause", about.cause),
        ("Typical size", about.typical),
        ("Seen by", about.seen_by),
        ("Needs", &texts(about.needs)),
        ("Separated from similar effects by", &texts(about.helps)),
        ("Equation", about.equation),
        ("Symbols", about.symbols),
        ("Parameters", &parameters(effect)),
        ("Valid", about.validity),
        ("Source", about.source),
        ("Role", effect.role.text()),
        ("Checked against", &format!("{}. {}", effect.golden.source, effect.golden.derivation)),
    ] {
        line(text, format_args!("- **{name}:** {content}"));
    }
}

fn texts(needs: &[Need]) -> String {
    if needs.is_empty() {
        return "any cycle".into();
    }
    needs.iter().map(|need| need.text()).collect::<Vec<_>>().join("; ")
}

/// Names and units of the fitted parameters of the example's instance.
fn parameters(effect: &Effect) -> String {
    let machine = shipped::machine("table-bc").expect("shipped machines parse (tested)");
    let instance =
        Instance::find(effect.example.id, &machine).expect("examples are effects of table-bc (tested)");
    let setup = SceneSetup::r_test("low", Point3::new(150.0, 0.0, 60.0)).with_plate();
    // States that differ in everything, some with the rotary axes standing, so that every effect is within reach.
    let state = |s: f64| State {
        position: AxisValues::from_fn(|_| s),
        direction: AxisValues::from_fn(|_| 2.0 * s - 1.0),
        velocity: AxisValues::from_fn(|_| s),
        acceleration: AxisValues::from_fn(|_| s),
        time_s: Some(s),
        temperature_degc: vec![20.0 + s],
        deflection_mm: nalgebra::Vector3::repeat(s),
        ..State::default()
    };
    let standing = (0..PLACES_OF_A_VOLUME).map(|i| {
        let mut standing = state(1.0);
        for letter in Joint::LINEAR {
            standing.position[letter] = i as f64;
        }
        standing
    });
    let states: Vec<State> = [state(0.0)].into_iter().chain(standing).collect();
    let scene = Scene::new(machine, vec![setup], vec!["frame".into()], states.iter());
    let text = |p: &Parameter| format!("`{}` {}", p.name, p.unit.text());
    let all: Vec<String> = instance.parameters(&scene).iter().map(text).collect();
    format!("{} ({})", all.join(", "), effect.example.id)
}

/// Anchor that GitHub gives a heading.
fn anchor(title: &str) -> String {
    let kept = title.to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect()
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
