//! What the engine and the catalogue say of an answer is said in the language of the report.

use trunnion_effects::catalogue::REGISTRY;
use trunnion_effects::{Instance, Scene, SceneSetup};
use trunnion_report::Language;

const OTHERS: [Language; 2] = [Language::German, Language::Japanese];

/// A sentence as it stands in a report; no piece of it stays English.
fn check(text: &str) {
    for language in OTHERS {
        let said = language.say(text);
        let said = said
            .unwrap_or_else(|| panic!("no entry in crates/report/src/language/table, {language:?}: {text}"));
        let english = [" the ", " is ", " of ", " than ", " and ", " with ", " shows ", " not "];
        assert!(english.iter().all(|word| !format!(" {said} ").contains(word)), "{text}\n{said}");
    }
}

#[test]
fn what_the_catalogue_says_of_an_effect_is_said_in_every_language() {
    for effect in REGISTRY {
        let about = &effect.about;
        check(&format!("{} (an:ID): {}", about.title, about.explanation));
        check(&format!("Likely cause: {}", about.cause));
        check(&format!("an:ID shows in: {} other:ID shows in: {}", about.seen_by, about.seen_by));
    }
}

/// On every machine that ships, all axes moving.
#[test]
fn what_a_sign_says_of_the_machine_is_said_in_every_language() {
    let mut said = 0;
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
                said += of_signs.iter().flatten().map(|text| check(text)).count();
            }
        }
    }
    assert!(said >= 4, "tables and heads sag, with two signs each: {said}");
}

#[test]
fn what_is_left_open_and_what_has_no_value_is_said_in_every_language() {
    for text in [
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
    ] {
        check(text);
    }
}

/// As the suite of mistakes gets them, one of each.
#[test]
fn what_is_not_plausible_is_said_in_every_language() {
    for text in [
        "run: in 336 of 336 points (rows 1 to 336) the axes do not follow the ball: by their positions, ball and nest are 135.0 mm \
         apart. With the position of the ball of setup low, ball_in_table_mm, at [150.0, 0.0, 60.0], not [15.0, 0.0, 60.0] mm and the \
         position of the ball of setup high, ball_in_table_mm, at [150.0, 0.0, 160.0], not [15.0, 0.0, 160.0] mm they are 0.0 mm \
         apart. Change it?",
        "run: in 308 of 336 points (rows 1 to 336) the axes do not follow the ball: by their positions, ball and nest are 254.1 mm \
         apart. With the columns of the axes B and C exchanged they are 0.0 mm apart. Change it?",
        "run: in rows 1 to 168 the probe dz reads the same value in every digit, while the axes move. The probe is dead, stuck or not \
         connected. Check it and measure again.",
        "run: direction_c is always +1, but C moves the opposite way in 166 of 332 steps, and the readings know the way: play of C by \
         it leaves 1.1 µm instead of 1.7. The directions were never filled in. Give direction_c as the axis moved, or 0 where it is \
         not known.",
        "run: in 288 of 336 points (rows 1 to 336) the axes do not follow the ball: by their positions, ball and nest are 243.1 mm \
         apart. With the sense of B reversed (sign −1) they are 0.0 mm apart. Change it?",
        "run: in 336 of 336 points (rows 1 to 336) the axes do not follow the ball: by their positions, ball and nest are 185.0 mm \
         apart. With lengths given in inches, not in mm they are 0.0 mm apart. Change it?",
        "run: no reading is larger than 0.038 µm, which is too small for a ball set in a nest. In mm instead of µm (factor 1000) they \
         would be plausible. Check the units of the readings.",
        "run: the readings do not fit their positions: 11.6 µm rms are left. With the nest on the table, not on the other side, 0.9 µm \
         are left. Change it?",
        "run: readings of one pose scatter by 19.6 µm, nothing but noise next to the 20.0 µm of all poses. The readings do not depend \
         on the pose. Check that ball, nest and probes are firm, and the file.",
        "run: the readings do not fit their positions: 9.3 µm rms are left. With the sign of the readings dx reversed, or those of dy \
         and dz, 1.7 µm are left. Change it?",
        "run: in 332 of 336 points (rows 1 to 336) the axes do not follow the ball: by their positions, ball and nest are 242.1 mm \
         apart. With another machine, table-bc, not head-bc, or another machine, table-bc-y, not head-bc they are 0.0 mm apart. Change \
         it?",
        "run: the readings do not fit their positions: 5.0 µm rms are left. With the readings shifted one row earlier: they are one \
         pose late, 1.0 µm are left. Change it?",
        "run: the readings do not fit their positions: 10.5 µm rms are left. With the readings dx and dy exchanged (probe inputs), 0.9 \
         µm are left. Change it?",
        "run: in 332 of 336 points (rows 1 to 336) the axes do not follow the ball: by their positions, ball and nest are 242.9 mm \
         apart. With angles given in radians, not in degrees they are 0.0 mm apart. Change it?",
        "run: 336 of 672 points are copies of others, in time and readings. Rows were pasted twice, so their repeats prove nothing. \
         Remove the duplicate rows.",
        "The runs run and run are identical, reading by reading. One recording was given twice, so its repeats prove nothing. Give \
         each recording once.",
        "run: in 280 of 336 points (rows 2 to 335) the axes do not follow the ball: by their positions, ball and nest are 212.1 mm \
         apart. With the sense of C reversed (sign −1), or the sense of Y reversed (sign −1) they are 0.0 mm apart. Positions cannot \
         distinguish these: they are mirror images, and in the wrong one values have the wrong sign. Look at the machine first: jog +C \
         and +Y, compare each with the machine file, and change what differs. Controls often count rotary axes the other way.",
        "run: in 336 of 336 points (rows 1 to 336) the axes do not follow the ball: by their positions, ball and nest are 100.0 mm \
         apart. With the setups high and low exchanged (position of the ball) they are 0.0 mm apart. Change it?",
        "run: in rows 114 to 162 the axes do not follow the ball, elsewhere they do. The position of B and C stays the same there: it \
         was not updated. Read these rows again.",
        "run: by its times the cycle took 19 days, which is too long. In milliseconds instead of seconds (factor 1000) it would be \
         plausible. Check the units of time_s.",
        "run: time runs backward from row to row (334 of 334 steps). The rows stand in reversed order, or the times do. Give the rows \
         in the order in which they were taken.",
        "run: in 336 of 336 points (rows 1 to 336) the axes do not follow the ball: by their positions, ball and nest are 227.4 mm \
         apart. With the columns of the axes X and Z exchanged they are 0.0 mm apart. Change it?",
    ] {
        check(text);
    }
}
