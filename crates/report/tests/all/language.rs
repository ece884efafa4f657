//! What the engine and the catalogue say of an answer is said in the language of the report.

use trunnion_effects::catalogue::REGISTRY;
use trunnion_effects::{Instance, Scene, SceneSetup};
use trunnion_report::Language;

const OTHERS: [Language; 2] = [Language::German, Language::Japanese];

/// Sentences as they stand in a report; no piece of them stays English.
fn check(texts: impl IntoIterator<Item = impl AsRef<str>>) {
    let lacks = |(language, text): (Language, &str)| match language.say(text) {
        None => Some(format!("{language:?} has no entry for: {text}")),
        Some(said) => {
            let english = [" the ", " is ", " of ", " than ", " and ", " with ", " shows ", " not "];
            let stays = english.iter().any(|word| format!(" {said} ").contains(word));
            stays.then(|| format!("{language:?} keeps English in: {text}\n{said}"))
        }
    };
    let of_text = |text: &str| OTHERS.map(|language| lacks((language, text)));
    let missing: Vec<String> = texts.into_iter().flat_map(|text| of_text(text.as_ref())).flatten().collect();
    assert!(missing.is_empty(), "crates/report/src/language/table:\n{}", missing.join("\n"));
}

#[test]
fn what_the_catalogue_says_of_an_effect_is_said_in_every_language() {
    check(REGISTRY.iter().flat_map(|effect| {
        let about = &effect.about;
        [
            format!("{} (an:ID): {}", about.title, about.explanation),
            format!("Likely cause: {}", about.cause),
            format!("an:ID shows in: {} other:ID shows in: {}", about.seen_by, about.seen_by),
        ]
    }));
}

/// On every machine that ships, all axes moving.
#[test]
fn what_a_sign_says_of_the_machine_is_said_in_every_language() {
    let mut said = Vec::new();
    for (name, _) in trunnion_machine::shipped::FILES {
        let machine = trunnion_machine::shipped::machine(name).unwrap();
        let state = |i: usize| trunnion_core::State {
            position: trunnion_core::AxisValues::of(machine.joints(), |joint| {
                (i * (joint.index() + 2) % 7) as f64
            }),
            ..trunnion_core::State::default()
        };
        let states: Vec<trunnion_core::State> = (0..40).map(state).collect();
        let setup = SceneSetup::r_test("low", nalgebra::Point3::new(150.0, 0.0, 60.0));
        let scene = Scene::new(machine.clone(), vec![setup], Vec::new(), states.iter());
        for instance in Instance::all(&machine) {
            for parameter in instance.parameters(&scene) {
                let of_signs = [1.0, -1.0].map(|value| parameter.said_by_sign(&instance.id(), value));
                said.extend(of_signs.into_iter().flatten());
            }
        }
    }
    assert!(said.len() >= 4, "tables and heads sag, with two signs each: {said:?}");
    check(said);
}

#[test]
fn what_is_left_open_and_what_has_no_value_is_said_in_every_language() {
    check([
        "Something speaks for backlash:B, gravity-sag:B, but no more than offsets of passes and small patterns may do. Too few poses were measured \
         twice, so the repeatability is not known.",
        "Repeat this pass: the same poses once more, in the opposite direction too.",
        "To separate backlash:B, gravity-sag:B, measure turn: B every 30° from 15°, C every 25° from 11°. The odds between the hardest pair \
         rise from 10^0.3 to 10^4.5 in 12 minutes.",
        "To separate a:B, b:B, measure turn: C turns both ways at two feeds, two heights. It settles a part in 12 minutes. It leaves a:B and b:B \
         open; fine would separate them. No cycle considered separates a:B and c:B.",
        "The noise of the present data allows to separate inertial-deflection:Y, vibration: odds of 10^134.9 are expected between the hardest \
         pair. No further cycle is needed for that. Where they are found confounded, something else differs from all of them: add the first and \
         diagnose again.",
        "It looks like a displacement along X, Y and Z with rotation about Z at axis B, in the axes of what carries it: above 77° of B, in \
         proportion. An expression for it leaves 0.37 µm rms, so a part remains even then. The named effect closest to it is Axial error motion \
         (axial-error-motion:B), which does not fit fully.",
        "To separate a:B, b:B, measure turn: C every 25° from 11°. The odds between the hardest pair rise from 10^0.0 to above 10^100 in 12 \
         minutes.",
        "This was found while the model held Axial error motion (axial-error-motion:B); windup:C too, taken out since.",
        "with centre = 77.21°, width = 35.79°",
        "In addition, axes have location errors: axis C, as B stands, lies 9.00 µm off along Y; axis C, as A and B stand, leans 64.9 µrad about X \
         (6.49 µm over 100 mm); axis C, as B stands, lies −4.02 µm off along X.",
        ": not observable: EX0B and ball-setting.low.x, ball-setting.high.x together move no reading of these runs; none of them gets a number",
        ": not observable: EC0Y moves no reading of these runs",
        ": not observable: axis B is at rest in these runs; taken as 0, and contained, as B stands, in EX0C",
        ": EZ0C is confounded with ball-setting.low.z, ball-setting.high.z in these runs; by convention EZ0C = 0; ball-setting.low.z, \
         ball-setting.high.z is not observable for another reason",
        "contains EC0C, EC0B, its axis at rest",
        "Nothing significant was found in the residual; repeatability 0.22 µm, of means of 2.6 readings.",
        "Seen only together: EAX.P2 + ECX.P1 = −9.81 µrad, u = 0.35 µrad.",
        "Component r, before and after",
    ]);
}

/// Of every mistake in the table of docs/measured, which a test of `trunnion` holds against the program.
#[test]
fn what_is_not_plausible_is_said_in_every_language() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/measured/mistakes.md");
    let document = std::fs::read_to_string(path).unwrap();
    let rows = document.lines().filter_map(|line| {
        let mut cells = line.strip_prefix("| ")?.strip_suffix(" |")?.split(" | ").skip(1);
        let becomes = cells.next()?;
        ["named", "doubted"].contains(&becomes).then_some(cells.next()?)
    });
    let rows: Vec<&str> = rows.collect();
    assert!(rows.len() > 50, "{} rows", rows.len());
    check(rows);
}
