//! The factors of the open grammar: how a motion without a name may depend on angle, direction, place and time (DIAGNOSIS §4).
//!
//! A family is one expression with shape numbers (where, how wide, how fast). Only a coarse grid of them is scanned for every carrier;
//! the shape numbers of what does well are then refined, and its kin (the same idea in another form, such as the soft form of a step)
//! are tried as well.

use crate::evidence::Natural;
use std::f64::consts::{PI, TAU};
use trunnion_effects::{Instance, ModelEffect, Scene};
use trunnion_identify::Experiment;
use trunnion_identify::machine_noise::Order;
use trunnion_units::AxisLetter;

/// Harmonics of the slow and of the fast rotary axis.
const SLOW_HARMONICS: usize = 3;
const FAST_HARMONICS: usize = 4;
/// Places of a bump along an axis.
const PLACES: usize = 12;
/// Usual half-width of a bump, rad, and how narrow or wide it may turn out.
const WIDTH_RAD: f64 = 0.37;
const WIDTHS_RAD: (f64, f64) = (0.12, 1.2);
/// Moments of a switch during the run.
const MOMENTS: usize = 13;

/// One way to depend on the state.
#[derive(Clone, Debug)]
pub struct Family {
    /// With parameters p1, p2, … and the shape numbers by name.
    pub expression: String,
    /// The expression as a formula effect of one component.
    pub formula: Instance,
    columns: usize,
    /// Shape numbers.
    pub numbers: Vec<Number>,
    /// Shapes that are scanned: one value for each number.
    pub grid: Vec<Vec<f64>>,
    /// Price of its complexity, ln.
    pub price_ln: f64,
    /// In words.
    pub words: String,
    /// Families of the same idea.
    pub kin: String,
    /// Where it may act.
    pub carriers: Carriers,
    /// Whether it is a repeatable motion of a rotary axis, of which every bearing has some.
    pub natural: Natural,
    /// False: tried only where its kin does well.
    pub scanned: bool,
}

impl Family {
    /// Number of its factors, each with a parameter.
    pub fn factors(&self) -> usize {
        self.columns
    }

    /// Its grid where numbers of the same name are known already.
    pub fn grid_at(&self, known: &[(&str, f64)]) -> Vec<Vec<f64>> {
        let placed = |shape: &Vec<f64>| {
            let of = |(number, value): (&Number, &f64)| {
                known.iter().find(|(name, _)| *name == number.name).map_or(*value, |(_, known)| *known)
            };
            self.numbers.iter().zip(shape).map(of).collect::<Vec<f64>>()
        };
        let mut grid: Vec<Vec<f64>> = self.grid.iter().map(placed).collect();
        grid.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        grid.dedup();
        grid
    }
}

/// A shape number and where it may lie.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    pub name: &'static str,
    pub low: f64,
    pub high: f64,
}

impl Number {
    /// Unit of its value.
    pub fn unit(&self) -> &'static str {
        match self.name {
            "tau" | "when" => "s",
            "rate" => "rad/s",
            "per_mm" => "rad/mm",
            "duty" | "power" => "1",
            _ => "rad",
        }
    }
}

/// Where a family may act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carriers {
    /// Every component at every rotary axis, the ball, and between tool and table.
    All,
    /// Displacements between tool and table in machine axes.
    Ground,
}

/// A family as written below.
struct Draft {
    kin: String,
    columns: Vec<String>,
    numbers: Vec<Number>,
    grid: Vec<Vec<f64>>,
    order: usize,
    words: String,
    carriers: Carriers,
    natural: Natural,
    scanned: bool,
}

impl Draft {
    fn new(kin: impl Into<String>, order: usize, columns: Vec<String>, words: impl Into<String>) -> Self {
        Self {
            kin: kin.into(),
            columns,
            numbers: Vec::new(),
            grid: vec![Vec::new()],
            order,
            words: words.into(),
            carriers: Carriers::All,
            natural: Natural::No,
            scanned: true,
        }
    }

    /// With one more shape number; the grid becomes the product.
    fn with(mut self, name: &'static str, (low, high): (f64, f64), values: &[f64]) -> Self {
        self.numbers.push(Number { name, low, high });
        let grid = std::mem::take(&mut self.grid);
        let longer = |start: &Vec<f64>, value: &f64| start.iter().chain([value]).copied().collect();
        self.grid =
            grid.iter().flat_map(|start| values.iter().map(move |value| longer(start, value))).collect();
        self
    }

    fn ground(self) -> Self {
        Self { carriers: Carriers::Ground, ..self }
    }

    fn natural(self) -> Self {
        Self { natural: Natural::Yes, ..self }
    }

    fn only_for_kin(self) -> Self {
        Self { scanned: false, ..self }
    }
}

/// Every family that makes sense in an experiment.
pub fn families(experiment: &Experiment, order: &Order) -> Vec<Family> {
    let rotary: Vec<AxisLetter> = [order.slow, order.fast].into_iter().flatten().collect();
    let scene = &experiment.scene;
    let mut drafts = Vec::new();
    angles(&rotary, &mut drafts);
    for &letter in &rotary {
        directions(letter, &rotary, scene, &mut drafts);
        places(letter, scene, &mut drafts);
        knees(letter, scene, &mut drafts);
    }
    linear(experiment, &mut drafts);
    moving(&rotary, scene, &mut drafts);
    if let Some(duration_s) = scene.duration_s().filter(|d| *d > 0.0) {
        settling(duration_s, &rotary, &mut drafts);
        switching(duration_s, scene, &mut drafts);
    }
    temperatures(&rotary, scene, &mut drafts);
    drafts.into_iter().filter_map(|draft| family(draft, experiment)).collect()
}

fn family(draft: Draft, experiment: &Experiment) -> Option<Family> {
    let terms = draft.columns.iter().enumerate();
    let expression = terms.map(|(i, factor)| format!("p{}*{factor}", i + 1)).collect::<Vec<_>>().join(" + ");
    let entry = ModelEffect {
        id: "formula:factor".into(),
        site: Some("spindle".into()),
        component: Some("dx".into()),
        expression: Some(expression.clone()),
        shape: draft.grid.first().cloned().unwrap_or_default(),
        ..ModelEffect::default()
    };
    let formula = Instance::from_model_effect(&entry, experiment.machine()).unwrap_or_else(|error| {
        panic!("the grammar writes formulas that can be read: {error:?}: {expression}")
    });
    if formula.parameters(&experiment.scene).is_empty() {
        return None;
    }
    Some(Family {
        expression,
        formula,
        columns: draft.columns.len(),
        numbers: draft.numbers,
        grid: draft.grid,
        price_ln: draft.order as f64,
        words: draft.words,
        kin: draft.kin,
        carriers: draft.carriers,
        natural: draft.natural,
        scanned: draft.scanned,
    })
}

/// `1`, or cos and sin of a harmonic.
fn waves(letter: Option<AxisLetter>, harmonic: usize) -> Vec<String> {
    match (letter, harmonic) {
        (None, _) | (_, 0) => vec!["1".into()],
        (Some(l), 1) => vec![format!("cos({l})"), format!("sin({l})")],
        (Some(l), k) => vec![format!("cos({k}*{l})"), format!("sin({k}*{l})")],
    }
}

fn products(first: &[String], second: &[String]) -> Vec<String> {
    let product = |a: &String, b: &String| match (a.as_str(), b.as_str()) {
        ("1", _) => b.clone(),
        (_, "1") => a.clone(),
        _ => format!("{a}*{b}"),
    };
    first.iter().flat_map(|a| second.iter().map(move |b| product(a, b))).collect()
}

/// Simple companions of direction, speed and time: nothing, or the first harmonic of one axis.
fn companions(rotary: &[AxisLetter]) -> Vec<(usize, Vec<String>, String)> {
    let mut companions = vec![(0, vec!["1".into()], String::new())];
    for &letter in rotary {
        companions.push((1, waves(Some(letter), 1), format!(", once per turn of {letter}")));
    }
    companions
}

fn angles(rotary: &[AxisLetter], drafts: &mut Vec<Draft>) {
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
            let per_turn = |n: usize, letter: Option<AxisLetter>| {
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

fn directions(letter: AxisLetter, rotary: &[AxisLetter], scene: &Scene, drafts: &mut Vec<Draft>) {
    let kin = format!("reversal {letter}");
    for (order, factors, words) in companions(rotary) {
        let columns = products(&[format!("dir{letter}")], &factors);
        let words = format!("changing sign with the direction of {letter}{words}");
        drafts.push(Draft::new(kin.clone(), order + 1, columns, words));
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
    drafts.push(reach(Draft::new(kin.clone(), 2, vec![decay.clone()], words), [0.15, 0.4, 1.0]));
    let words = format!("turning over with the travel after each reversal of {letter}");
    let turning = format!("(dir{letter} - 2*{decay})");
    drafts.push(reach(Draft::new(kin, 2, vec![turning], words), [0.3, 0.7, 1.3]));
}

/// Bumps and steps in one angle.
fn places(letter: AxisLetter, scene: &Scene, drafts: &mut Vec<Draft>) {
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
    let kin = format!("place {letter}");
    let words = format!("switching at an angle of {letter}");
    drafts.push(Draft::new(kin.clone(), 2, vec![format!("step({letter} - at)")], words).with(
        "at",
        (low, high),
        &inside,
    ));
    let words = format!("going over at an angle of {letter}");
    drafts.push(
        Draft::new(kin, 3, vec![format!("1/(1 + exp(-({letter} - at)/width))")], words)
            .with("at", (low, high), &inside)
            .with("width", (0.02, 1.0), &[0.06, 0.3])
            .only_for_kin(),
    );
}

/// What begins beyond an angle: stops, loose clamps, cables that come tight.
fn knees(letter: AxisLetter, scene: &Scene, drafts: &mut Vec<Draft>) {
    let (low, high) = scene.position_range[letter];
    if high - low < 1e-3 {
        return;
    }
    let kin = format!("place {letter}");
    let shares: Vec<f64> = (1..8).map(|i| f64::from(i) / 8.0).collect();
    let inside: Vec<f64> = shares.iter().map(|s| low + s * (high - low)).collect();
    let hinge = |factor: String, order: usize, words: String, knees: &[f64], range: (f64, f64)| {
        Draft::new(kin.clone(), order, vec![factor], words).with("knee", range, knees)
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
        let draft = Draft::new(kin.clone(), 3, vec![soft], words);
        drafts.push(
            draft.with("soft", (0.02, 1.0), &[0.1, 0.4]).with("knee", (low, high), &inside).only_for_kin(),
        );
    }
    for (factor, word) in [("{l} - knee", "above"), ("knee - {l}", "below"), ("abs({l}) - knee", "beyond")] {
        let factor = factor.replace("{l}", letter.as_str());
        let words = format!("{word} an angle of {letter}, with a power of the way");
        drafts.push(
            Draft::new(kin.clone(), 3, vec![format!("max(0, {factor})^power")], words)
                .with("knee", (low, high), &inside)
                .with("power", (0.4, 4.0), &[0.6, 3.0])
                .only_for_kin(),
        );
    }
}

fn linear(experiment: &Experiment, drafts: &mut Vec<Draft>) {
    let letters: Vec<AxisLetter> =
        AxisLetter::LINEAR.into_iter().filter(|&l| experiment.machine().axis(l).is_some()).collect();
    for (i, first) in letters.iter().enumerate() {
        let one = |factor: String, order: usize, words: String| {
            Draft::new("linear", order, vec![factor], words).ground()
        };
        drafts.push(one(format!("dir{first}"), 1, format!("changing sign with the direction of {first}")));
        drafts.push(one(format!("{first}/100"), 1, format!("proportional to {first}")));
        for second in &letters[i..] {
            drafts.push(one(format!("{first}*{second}/10000"), 2, format!("with {first} times {second}")));
        }
        let (low, high) = experiment.scene.position_range[*first];
        let travel = high - low;
        if travel > 1.0 {
            let rates: Vec<f64> = (0..6).map(|i| TAU / travel * (1.0 + 0.75 * f64::from(i))).collect();
            let columns = vec![format!("cos(per_mm*{first})"), format!("sin(per_mm*{first})")];
            drafts.push(
                Draft::new("linear", 2, columns, format!("repeating along {first}"))
                    .with("per_mm", (0.7 * TAU / travel, 6.0 * TAU / travel), &rates)
                    .ground(),
            );
        }
    }
}

/// While axes move: with speed and acceleration.
fn moving(rotary: &[AxisLetter], scene: &Scene, drafts: &mut Vec<Draft>) {
    let fastest = |letter: AxisLetter| scene.speed_range[letter].1;
    for letter in AxisLetter::ALL.into_iter().filter(|&letter| fastest(letter) > 0.0) {
        for (order, factors, words) in companions(rotary) {
            for (factor, how) in [
                (format!("v{letter}"), format!("in proportion to the speed of {letter}")),
                (format!("v{letter}^2"), format!("with the square of the speed of {letter}")),
                (format!("a{letter}"), format!("in proportion to the acceleration of {letter}")),
            ] {
                let columns = products(&[factor], &factors);
                drafts.push(Draft::new(
                    format!("speed {letter}"),
                    order + 1,
                    columns,
                    format!("{how}{words}"),
                ));
            }
        }
    }
}

/// Warming up and wandering.
fn settling(duration_s: f64, rotary: &[AxisLetter], drafts: &mut Vec<Draft>) {
    let limits = (0.04 * duration_s, 2.0 * duration_s);
    for (order, factors, words) in companions(rotary) {
        let columns = products(&[format!("(t/{duration_s:.0} - 0.5)")], &factors);
        drafts.push(Draft::new("time", order + 1, columns, format!("growing with time{words}")));
        let columns = products(&["(1 - exp(-t/tau))".into()], &factors);
        drafts.push(Draft::new("time", order + 2, columns, format!("settling with time{words}")).with(
            "tau",
            limits,
            &[0.06, 0.15, 0.4].map(|share| share * duration_s),
        ));
    }
}

/// Switching once, and coming and going.
fn switching(duration_s: f64, scene: &Scene, drafts: &mut Vec<Draft>) {
    let moments: Vec<f64> = (1..MOMENTS).map(|i| duration_s * i as f64 / MOMENTS as f64).collect();
    drafts.push(Draft::new("clock", 1, vec!["step(t - when)".into()], "switching at one moment").with(
        "when",
        (0.0, duration_s),
        &moments,
    ));
    // Faster than two points a period cannot be told from slower.
    let fastest = scene.time_step_s.map_or(PI * 20.0 / duration_s, |step_s| PI / step_s);
    let rate = |cycles: f64| TAU * cycles / duration_s;
    let rates = |cycles: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        cycles.map(rate).filter(|rate| *rate < fastest).collect()
    };
    let coarse = rates(&mut (0..9).map(|i| 2.0 * 1.35_f64.powi(i)));
    let fine = rates(&mut (3..26).map(|half_cycles| 0.5 * f64::from(half_cycles)));
    if coarse.is_empty() || fine.is_empty() {
        return;
    }
    let limits = (rate(1.2), rate(25.0).min(fastest));
    let wave = || {
        let columns = vec!["cos(rate*t)".into(), "sin(rate*t)".into()];
        Draft::new("clock", 2, columns, "coming and going with time")
    };
    drafts.push(wave().with("rate", limits, &coarse));
    drafts.push(wave().ground().with("rate", limits, &fine));
    let phases: Vec<f64> = (0..8).map(|i| TAU * f64::from(i) / 8.0).collect();
    let square = "step(sin(rate*t + phase) - duty)".to_string();
    drafts.push(
        Draft::new("clock", 3, vec![square], "switching on and off at regular times")
            .with("rate", limits, &coarse)
            .with("phase", (0.0, TAU), &phases)
            .with("duty", (-0.95, 0.95), &[-0.5, 0.0, 0.5])
            .only_for_kin(),
    );
}

fn temperatures(rotary: &[AxisLetter], scene: &Scene, drafts: &mut Vec<Draft>) {
    for channel in &scene.channels {
        for (order, factors, words) in companions(rotary) {
            let columns = products(&[format!("T_{channel}")], &factors);
            let words = format!("with the temperature {channel}{words}");
            drafts.push(Draft::new("temperature", order + 1, columns, words));
        }
    }
}
