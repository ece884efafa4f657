//! Factors that depend on the angle of a rotary axis and on the side it came from.

use super::draft::{Draft, companions, products, waves};
use std::f64::consts::PI;
use trunnion_core::Joint;
use trunnion_effects::Scene;

/// Harmonics of the slow and of the fast rotary axis.
const SLOW_HARMONICS: usize = 3;
const FAST_HARMONICS: usize = 4;
/// Places of a bump along an axis.
const PLACES: usize = 12;
/// Usual half-width of a bump, rad, and how narrow or wide it may turn out.
const WIDTH_RAD: f64 = 0.37;
const WIDTHS_RAD: (f64, f64) = (0.12, 1.2);
pub(super) fn angles(rotary: &[Joint], drafts: &mut Vec<Draft>) {
    let (slow, fast) = match rotary {
        [fast] => (None, Some(*fast)),
        [slow, fast] => (Some(*slow), Some(*fast)),
        _ => return,
    };
    for k in 0..=(if slow.is_some() { SLOW_HARMONICS } else { 0 }) {
        for m in 0..=FAST_HARMONICS {
            if k + m == 0 {
                continue;
            }
            let per_turn = |n: usize, letter: Option<Joint>| {
                letter.filter(|_| n > 0).map(|letter| format!("{n} per turn of {letter}"))
            };
            let words: Vec<String> = [per_turn(k, slow), per_turn(m, fast)].into_iter().flatten().collect();
            let columns = products(&waves(slow, k), &waves(fast, m));
            drafts.push(Draft::new("waves", k + m, columns, words.join(" and ")).natural());
        }
    }
    if let (Some(slow), Some(fast)) = (slow, fast) {
        for m in 1..=2 {
            let columns = products(&[slow.to_string()], &waves(Some(fast), m));
            drafts.push(Draft::new(
                "waves",
                m + 1,
                columns,
                format!("{m} per turn of {fast}, growing with {slow}"),
            ));
        }
    }
}

pub(super) fn directions(letter: Joint, rotary: &[Joint], scene: &Scene, drafts: &mut Vec<Draft>) {
    let idea = format!("reversal {letter}");
    for (order, factors, words) in companions(rotary) {
        let columns = products(&[format!("dir{letter}")], &factors);
        let words = format!("changing sign with the direction of {letter}{words}");
        drafts.push(Draft::new(idea.clone(), order + 1, columns, words));
    }
    // Hysteresis: what is left of the last reversal dies out with the travel since; at rest the travel is counted from the end of
    // the range that the axis came from.
    let (low, high) = scene.position_range[letter];
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    if half < 1e-6 {
        return;
    }
    let decay = format!("dir{letter}*exp(-(dir{letter}*({letter} - {middle:.4}) + {half:.4})/reach)");
    let reach = |draft: Draft, shares: [f64; 3]| {
        draft.with("reach", (0.1 * half, 2.0 * half), &shares.map(|share| share * half))
    };
    let words = format!("after each reversal of {letter}, fading with its travel");
    drafts.push(reach(Draft::new(idea.clone(), 2, vec![decay.clone()], words), [0.15, 0.4, 1.0]));
    let words = format!("turning over with the travel after each reversal of {letter}");
    let turning = format!("(dir{letter} - 2*{decay})");
    drafts.push(reach(Draft::new(idea, 2, vec![turning], words), [0.3, 0.7, 1.3]));
}

/// Bumps and steps in one angle.
pub(super) fn places(letter: Joint, scene: &Scene, drafts: &mut Vec<Draft>) {
    let (low, high) = scene.position_range[letter];
    if high - low < 1e-3 {
        return;
    }
    let full_turn = high - low > 1.6 * PI;
    let at = |count: usize| -> Vec<f64> {
        (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
    };
    let bump = if full_turn {
        format!("exp((cos({letter} - centre) - 1)/width^2)")
    } else {
        format!("exp(-(({letter} - centre)/width)^2/2)")
    };
    drafts.push(
        Draft::new(format!("place {letter}"), 2, vec![bump], format!("near one angle of {letter}"))
            .with("centre", (low, high), &at(PLACES))
            .with("width", WIDTHS_RAD, &[WIDTH_RAD]),
    );
    let inside: Vec<f64> = at(9)[1..8].into();
    let idea = format!("place {letter}");
    let words = format!("switching at an angle of {letter}");
    drafts.push(Draft::new(idea.clone(), 2, vec![format!("step({letter} - at)")], words).with(
        "at",
        (low, high),
        &inside,
    ));
    let words = format!("going over at an angle of {letter}");
    drafts.push(
        Draft::new(idea, 3, vec![format!("1/(1 + exp(-({letter} - at)/width))")], words)
            .with("at", (low, high), &inside)
            .with("width", (0.02, 1.0), &[0.06, 0.3])
            .only_refined(),
    );
}

/// What begins beyond an angle: stops, loose clamps, cables that come tight.
pub(super) fn knees(letter: Joint, scene: &Scene, drafts: &mut Vec<Draft>) {
    let (low, high) = scene.position_range[letter];
    if high - low < 1e-3 {
        return;
    }
    let idea = format!("place {letter}");
    let shares: Vec<f64> = (1..8).map(|i| f64::from(i) / 8.0).collect();
    let inside: Vec<f64> = shares.iter().map(|s| low + s * (high - low)).collect();
    let hinge = |factor: String, order: usize, words: String, knees: &[f64], range: (f64, f64)| {
        Draft::new(idea.clone(), order, vec![factor], words).with("knee", range, knees)
    };
    for (exponent, how) in [("", "in proportion"), ("^2", "with the square")] {
        let words = format!("above an angle of {letter}, {how}");
        drafts.push(hinge(format!("max(0, {letter} - knee){exponent}"), 2, words, &inside, (low, high)));
        let words = format!("below an angle of {letter}, {how}");
        drafts.push(hinge(format!("max(0, knee - {letter}){exponent}"), 2, words, &inside, (low, high)));
        if low < -0.2 && high > 0.2 {
            let reach = high.min(-low);
            let knees: Vec<f64> = shares.iter().map(|s| s * reach).collect();
            let beyond = format!("max(0, abs({letter}) - knee){exponent}");
            let words = format!("beyond an angle of {letter} on both sides, {how}");
            drafts.push(hinge(beyond.clone(), 2, words, &knees, (0.0, reach)));
            let words = format!("beyond an angle of {letter}, outwards on both sides, {how}");
            drafts.push(hinge(format!("sign({letter})*{beyond}"), 2, words, &knees, (0.0, reach)));
        }
    }
    for (sign, word) in [("", "above"), ("-", "below")] {
        let soft = format!("soft*log(1 + exp({sign}({letter} - knee)/soft))");
        let words = format!("{word} an angle of {letter}, setting in softly");
        let draft = Draft::new(idea.clone(), 3, vec![soft], words);
        drafts.push(
            draft.with("soft", (0.02, 1.0), &[0.1, 0.4]).with("knee", (low, high), &inside).only_refined(),
        );
    }
    for (factor, word) in [("{l} - knee", "above"), ("knee - {l}", "below"), ("abs({l}) - knee", "beyond")] {
        let factor = factor.replace("{l}", letter.as_str());
        let words = format!("{word} an angle of {letter}, with a power of the way");
        drafts.push(
            Draft::new(idea.clone(), 3, vec![format!("max(0, {factor})^power")], words)
                .with("knee", (low, high), &inside)
                .with("power", (0.4, 4.0), &[0.6, 3.0])
                .only_refined(),
        );
    }
}
