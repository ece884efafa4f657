//! What to enter into a control, for the terminal.

use super::table::clean;
use crate::compensation::{Signs, format};
use trunnion_results::number::{plain, signed, trimmed};
use trunnion_results::sentences::ALL_CLEAR;
use trunnion_results::{
    Correction, CorrectionJudged, CorrectionValues, Decision, SelfTest, SignVerdict, Verdict,
};

/// What a reading is listed for.
const SIGNS: [&str; 3] = ["without the correction", "with the right sign", "with the wrong sign"];
/// A ball is set by hand to 1 mm, which turns with the table: a reading is known as long as it stays where it was.
const MOUNTED: &str = "\nThese readings hold while ball and instrument stay mounted. After mounting again, the differences between the three hold.\n";

/// What to do, what to check first, what to expect, and how to undo it.
pub fn correction_text(answer: &Correction) -> String {
    let mut out = format!("{}\n\n", first_sentence(answer));
    if let Some(expected) = &answer.expected {
        out += &format!(
            "Expected at the measured poses: {} µm rms now, {} µm with the correction, {} µm with the wrong sign.\n",
            plain(expected.before_um),
            plain(expected.after_um),
            plain(expected.wrong_sign_um)
        );
        if expected.is_no_better() {
            out +=
                "The errors do not fall: what this control takes is too little of them. Do not enter it.\n";
        }
        out += &match expected.tolerance_um.zip(expected.decision) {
            Some((tolerance, decision)) => {
                let say = match decision {
                    Decision::Pass => "is within",
                    Decision::Fail => "is above",
                    Decision::NotDecidable => "is not shown to be within",
                };
                let enough =
                    if decision == Decision::Fail { ": the correction alone is not enough" } else { "" };
                let excluded = expected.excluded.as_ref().filter(|_| decision != Decision::Fail);
                let excluded = excluded.map_or_else(String::new, |excluded| {
                    let largest = plain(excluded.largest_um);
                    format!(
                        " Excluded from the fit: {}, up to {largest} µm at {}.",
                        excluded.count, excluded.at
                    )
                });
                format!(
                    "The largest deviation then, {} µm, {say} the tolerance of the machine file, {} µm{enough}.{excluded}\n",
                    plain(expected.largest_after_um),
                    trimmed(tolerance, 3)
                )
            }
            None => "The machine file states no tolerance (tolerance_um).\n".into(),
        };
    }
    out += &steps("Enter", &answer.enter);
    if holds_errors(answer) {
        out += "  The values are errors (actual − nominal): the control must apply the opposite. Say so where it asks for the sign, or write the \
                file with --corrections.\n";
    }
    if let Some(check) = &answer.check_first {
        out += &format!(
            "\nCheck first (setup {}): zero the instrument at {}, go to {}, and read it:\n",
            clean(&check.setup),
            check.from,
            check.to
        );
        let readings = [&check.without_um, &check.right_um, &check.wrong_um];
        for (with, um) in SIGNS.iter().zip(readings) {
            out += &format!("  {with}: {}\n", named(&check.components, um));
        }
    }
    if let Some(test) = &answer.self_test {
        out += &self_test(test);
    }
    if answer.check_first.is_some() || answer.self_test.is_some() {
        out += MOUNTED;
    }
    out += &steps("Undo", &answer.undo);
    for left_out in &answer.left_out {
        out += &format!("\nNot in it: {}: {}.", clean(&left_out.effect), clean(&left_out.why));
    }
    for confounded in &answer.confounded {
        out += &format!("\nConfounded: {}.", clean(&confounded.sentence()));
    }
    for text in &answer.unconfirmed {
        out += &format!("\nNot confirmed: {text}");
    }
    out + &format!("\nFormat: {}\n", answer.source)
}

fn first_sentence(answer: &Correction) -> String {
    let axes: Vec<&str> = answer.axes.iter().map(|axis| axis.axis.as_str()).collect();
    let model = match answer.verdict {
        Verdict::NoiseFloor => ALL_CLEAR,
        Verdict::Undecided => "Whether the model leaves something is undecided.",
        Verdict::MissingEffect | Verdict::UnnamedStructure => {
            "The model is inadequate: it lacks something, and so does the correction."
        }
        Verdict::NotJudged => "The runs were not judged.",
    };
    format!(
        "{} holds the {} of {} for {}. {model}",
        clean(&answer.written),
        if holds_errors(answer) { "errors" } else { "corrections" },
        axes.join(", "),
        answer.control
    )
}

/// A file of tables, in which either sign may stand, with errors in it.
fn holds_errors(answer: &Correction) -> bool {
    let is_either = format(&answer.control).is_some_and(|format| format.signs == Signs::Either);
    is_either && answer.values == CorrectionValues::Error
}

fn steps(title: &str, steps: &[String]) -> String {
    let mut out = format!("\n{title}:\n");
    for (k, step) in steps.iter().enumerate() {
        out += &format!("  {}. {step}\n", k + 1);
    }
    out
}

fn named(components: &[String], values: &[f64]) -> String {
    let one = |(name, value): (&String, &f64)| format!("{name} {}", signed(*value, 1));
    let all: Vec<String> = components.iter().zip(values).map(one).collect();
    format!("{} µm", all.join(", "))
}

fn self_test(test: &SelfTest) -> String {
    let mut out = format!(
        "\nSelf-test {} (setup {}): measure these poses with the correction, then `--judge` the run. Readings about their mean:\n",
        clean(&test.cycle),
        clean(&test.setup)
    );
    if let Some(program) = &test.program {
        out += &format!("  NC program: {}\n", clean(program));
    }
    for pose in &test.poses {
        let readings = [&pose.without_um, &pose.right_um, &pose.wrong_um];
        let of_sign = |(with, um): (&&str, &Vec<f64>)| format!("{with} {}", named(&test.components, um));
        let all: Vec<String> = SIGNS.iter().zip(readings).map(of_sign).collect();
        out += &format!("  {}: {}\n", pose.pose, all.join("; "));
    }
    out
}

/// What a run measured with the correction says of its sign.
pub fn correction_judged_text(answer: &CorrectionJudged) -> String {
    let words = match answer.verdict {
        SignVerdict::Right => "The correction acts, with the right sign.",
        SignVerdict::NotActive => {
            "The correction does not act. Check that it is switched on, and that the cycle ran with tool centre point control."
        }
        SignVerdict::Wrong => {
            "The sign is wrong: the errors have grown. Undo it, change the sign, and test again."
        }
        SignVerdict::InPart => {
            "The correction acts by another share than all of it. Check that every value was entered, and each once."
        }
        SignVerdict::Unclear if SignVerdict::of(answer.share, answer.u) == SignVerdict::NotActive => {
            "This run cannot say: its positions depart from those of the cycle, and may hold the correction. Record the commanded positions."
        }
        SignVerdict::Unclear => "This run cannot say: the correction is too small against its noise.",
    };
    let positions = match answer.positions {
        Some(positions) if positions.counted => format!(
            "\nThe recorded positions hold it (share {:.2} ± {:.2}): they are those of the drives. Readings and positions were judged together.",
            positions.share, positions.u
        ),
        None if answer.verdict == SignVerdict::NotActive => {
            "\nThe positions must be the commanded ones. Positions of the drives hold the correction, and then no reading shows it.".into()
        }
        _ => String::new(),
    };
    format!(
        "{words}{positions}\n{} µm rms with it, {} µm expected without it. Share of the correction that acts: {:.2} ± {:.2} (1 right, 0 not active, -1 wrong sign).\n",
        plain(answer.rms_um),
        plain(answer.without_um),
        answer.share,
        answer.u
    )
}
