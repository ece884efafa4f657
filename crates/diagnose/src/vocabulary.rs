//! The open grammar: shapes without a name that duel with the catalogue.
//!
//! component of a joint or of the ball × factor(state)                                             [DIAGNOSIS §4]
//! Factors: cos/sin kS · cos/sin mF (S, F the slow and the fast rotary axis) × {1, direction, t, 1 − e^(−t/τ)}, monomials of
//! X Y Z, steps and waves in time, local bumps, hinges and steps in an angle, hysteresis. Each is written as the text of a
//! `formula:` effect and evaluated by the formula reader, so that what is found can be added as it stands.
//! Price: ln(number of groups) + 1 per order.

use crate::evidence::{Entry, Library};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use trunnion_effects::{Instance, ModelEffect};
use trunnion_identify::Experiment;
use trunnion_identify::machine_noise::{Order, ground_joint, modulated, unit_columns};
use trunnion_machine::Site;
use trunnion_units::AxisLetter;

/// Names of the components in formulas.
const COMPONENTS: [&str; 6] = ["dx", "dy", "dz", "ea", "eb", "ec"];
/// Carriers that coincide up to a sign beyond this cosine are one.
const SAME_CARRIER: f64 = 0.9999;

/// The grammar on one experiment.
pub struct Vocabulary {
    /// Columns of all groups.
    pub library: Library,
    /// What each group says.
    pub phrases: Vec<Phrase>,
}

/// One group: a carrier and a family of factors.
#[derive(Clone, Debug, PartialEq)]
pub struct Phrase {
    /// Site as in a formula, e.g. `axis:B`.
    pub site: String,
    /// Component as in a formula.
    pub component: &'static str,
    /// The factors of each variant: one text for each column.
    pub variants: Vec<Vec<String>>,
    /// Where and when it is at work, in words.
    pub words: String,
}

impl Phrase {
    /// The expression of one variant with parameters p1, p2, ….
    pub fn expression(&self, variant: usize) -> String {
        let terms = self.variants[variant].iter().enumerate();
        terms.map(|(i, factor)| format!("p{}*{factor}", i + 1)).collect::<Vec<_>>().join(" + ")
    }
}

struct Family {
    order: usize,
    variants: Vec<Vec<String>>,
    words: String,
    carriers: Carriers,
    /// Repeatable motion of a rotary axis.
    natural: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Carriers {
    All,
    /// Displacements between tool and table in machine axes.
    Ground,
}

struct Carrier {
    site: Site,
    component: usize,
    column: DVector<f64>,
    is_ground: bool,
}

/// Builds the grammar for an experiment.
pub fn vocabulary(experiment: &Experiment, order: &Order) -> Vocabulary {
    let carriers = carriers(experiment);
    let (mut groups, mut phrases) = (Vec::new(), Vec::new());
    for family in families(experiment, order) {
        let Some(values) =
            family.variants.iter().map(|v| factor_values(experiment, v)).collect::<Option<Vec<_>>>()
        else {
            continue;
        };
        for carrier in &carriers {
            if family.carriers == Carriers::Ground && !carrier.is_ground {
                continue;
            }
            let part = |factors: &Vec<Vec<f64>>| {
                let columns: Vec<DVector<f64>> = factors
                    .iter()
                    .map(|values| modulated(experiment, &carrier.column, |i| values[i]))
                    .collect();
                DMatrix::from_columns(&columns)
            };
            groups.push(Entry {
                parts: values.iter().map(part).collect(),
                prior_ln: -(family.order as f64),
                natural: family.natural,
            });
            phrases.push(Phrase {
                site: site_text(carrier.site),
                component: COMPONENTS[carrier.component],
                variants: family.variants.clone(),
                words: family.words.clone(),
            });
        }
    }
    let price = (groups.len().max(1) as f64).ln();
    for group in &mut groups {
        group.prior_ln -= price;
    }
    Vocabulary { library: Library::new(experiment.rows(), groups), phrases }
}

/// Site as written in a formula.
fn site_text(site: Site) -> String {
    match site {
        Site::Joint(letter) => format!("axis:{letter}"),
        Site::TableBall => "ball".into(),
        Site::SpindleBall => "spindle".into(),
        Site::Reading => "reading".into(),
    }
}

fn carriers(experiment: &Experiment) -> Vec<Carrier> {
    let machine = experiment.machine();
    let mut wanted: Vec<(Site, usize)> = Vec::new();
    for axis in machine.rotary() {
        wanted.extend((0..6).map(|k| (Site::Joint(axis.letter), k)));
    }
    wanted.extend((0..3).map(|k| (Site::TableBall, k)));
    wanted.extend((0..3).map(|k| (ground_joint(machine), k)));
    let ground: Vec<DVector<f64>> =
        (0..3).map(|k| unit_columns(experiment, ground_joint(machine), k)).collect();
    let mut carriers: Vec<Carrier> = Vec::new();
    for (site, component) in wanted {
        let column = unit_columns(experiment, site, component);
        let same =
            |other: &DVector<f64>| column.dot(other).abs() > SAME_CARRIER * column.norm() * other.norm();
        if column.norm() > 1e-9 && !carriers.iter().any(|carrier| same(&carrier.column)) {
            let is_ground = ground.iter().any(&same);
            carriers.push(Carrier { site, component, column, is_ground });
        }
    }
    carriers
}

/// Values of the factors of one variant at every point, through the formula reader; `None` where out of reach.
fn factor_values(experiment: &Experiment, factors: &[String]) -> Option<Vec<Vec<f64>>> {
    let machine = experiment.machine();
    let expression = factors.iter().enumerate().map(|(i, factor)| format!("p{}*{factor}", i + 1));
    let entry = ModelEffect {
        id: "formula:factor".into(),
        site: Some("spindle".into()),
        component: Some("dx".into()),
        expression: Some(expression.collect::<Vec<_>>().join(" + ")),
        ..ModelEffect::default()
    };
    let formula = Instance::from_model_effect(&entry, machine)
        .unwrap_or_else(|error| panic!("the grammar writes formulas that can be read: {error:?}"));
    if formula.parameters(&experiment.scene).is_empty() {
        return None;
    }
    let mut values = vec![vec![0.0; experiment.points.len()]; factors.len()];
    for (i, point) in experiment.points.iter().enumerate() {
        formula.motions(&experiment.scene, &[], &point.state, &mut |parameter, _, twist| {
            values[parameter][i] = twist.translation_mm.x;
        });
    }
    Some(values)
}

fn families(experiment: &Experiment, order: &Order) -> Vec<Family> {
    let mut families = Vec::new();
    let rotary: Vec<AxisLetter> = [order.slow, order.fast].into_iter().flatten().collect();
    angles(&rotary, &mut families);
    for &letter in &rotary {
        directions(letter, &rotary, experiment, &mut families);
        places(letter, experiment, &mut families);
    }
    linear(experiment, &mut families);
    if let Some(duration_s) = experiment.scene.duration_s().filter(|d| *d > 0.0) {
        times(duration_s, &rotary, &mut families);
    }
    families
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

fn angles(rotary: &[AxisLetter], families: &mut Vec<Family>) {
    let (slow, fast) = match rotary {
        [fast] => (None, Some(*fast)),
        [slow, fast] => (Some(*slow), Some(*fast)),
        _ => return,
    };
    for k in 0..=(if slow.is_some() { 3 } else { 0 }) {
        for m in 0..=4 {
            if k + m == 0 {
                continue;
            }
            let mut words = Vec::new();
            if let Some(letter) = slow.filter(|_| k > 0) {
                words.push(format!("{k} per turn of {letter}"));
            }
            if let Some(letter) = fast.filter(|_| m > 0) {
                words.push(format!("{m} per turn of {letter}"));
            }
            let variants = vec![products(&waves(slow, k), &waves(fast, m))];
            families.push(Family {
                order: k + m,
                variants,
                words: words.join(" and "),
                carriers: Carriers::All,
                natural: true,
            });
        }
    }
    if let (Some(slow), Some(fast)) = (slow, fast) {
        for m in 1..=2 {
            let variants = vec![products(&[slow.to_string()], &waves(Some(fast), m))];
            let words = format!("{m} per turn of {fast}, growing with {slow}");
            families.push(Family { order: m + 1, variants, words, carriers: Carriers::All, natural: false });
        }
    }
}

/// Simple companions of direction and time: nothing, or the first harmonic of one axis.
fn companions(rotary: &[AxisLetter]) -> Vec<(usize, Vec<String>, String)> {
    let mut companions = vec![(0, vec!["1".into()], String::new())];
    for &letter in rotary {
        companions.push((1, waves(Some(letter), 1), format!(", once per turn of {letter}")));
    }
    companions
}

fn directions(
    letter: AxisLetter,
    rotary: &[AxisLetter],
    experiment: &Experiment,
    families: &mut Vec<Family>,
) {
    for (order, factors, words) in companions(rotary) {
        let variants = vec![products(&[format!("dir{letter}")], &factors)];
        let words = format!("changing sign with the direction of {letter}{words}");
        families.push(Family { order: order + 1, variants, words, carriers: Carriers::All, natural: false });
    }
    // Hysteresis: what is left of the last reversal dies out with the travel since.
    let (low, high) = experiment.scene.position_range[letter];
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let decay = |reach: f64| {
        vec![format!("dir{letter}*exp(-(dir{letter}*({letter} - {middle:.4}) + {half:.4})/{reach:.4})")]
    };
    let variants = [0.15, 0.4, 1.0].map(|share| decay(share * half.max(1e-3))).into();
    let words = format!("after each reversal of {letter}, fading with its travel");
    families.push(Family { order: 2, variants, words, carriers: Carriers::All, natural: false });
}

fn linear(experiment: &Experiment, families: &mut Vec<Family>) {
    let letters: Vec<AxisLetter> =
        AxisLetter::LINEAR.into_iter().filter(|&l| experiment.machine().axis(l).is_some()).collect();
    for (i, first) in letters.iter().enumerate() {
        let dir = vec![vec![format!("dir{first}")]];
        let words = format!("changing sign with the direction of {first}");
        families.push(Family { order: 1, variants: dir, words, carriers: Carriers::Ground, natural: false });
        let line = vec![vec![format!("{first}/100")]];
        let words = format!("proportional to {first}");
        families.push(Family { order: 1, variants: line, words, carriers: Carriers::Ground, natural: false });
        for second in &letters[i..] {
            let variants = vec![vec![format!("{first}*{second}/10000")]];
            let words = format!("with {first} times {second}");
            families.push(Family { order: 2, variants, words, carriers: Carriers::Ground, natural: false });
        }
    }
}

/// Bumps, hinges and steps in one angle.
fn places(letter: AxisLetter, experiment: &Experiment, families: &mut Vec<Family>) {
    let (low, high) = experiment.scene.position_range[letter];
    if high - low < 1e-3 {
        return;
    }
    let full_turn = high - low > 1.6 * PI;
    let at = |share: f64| low + share * (high - low);
    let bump = |centre: f64| {
        if full_turn {
            vec![format!("exp((cos({letter} - {centre:.4}) - 1)/0.14)")]
        } else {
            vec![format!("exp(-(({letter} - {centre:.4})/0.35)^2/2)")]
        }
    };
    let variants = (0..12).map(|i| bump(at(f64::from(i) / 11.0))).collect();
    let words = format!("near one angle of {letter}");
    families.push(Family { order: 2, variants, words, carriers: Carriers::All, natural: false });
    let shares: Vec<f64> = (1..8).map(|i| f64::from(i) / 8.0).collect();
    for (exponent, how) in [("", "in proportion"), ("^2", "with the square")] {
        let above = |share: &f64| vec![format!("max(0, {letter} - {:.4}){exponent}", at(*share))];
        let words = format!("above an angle of {letter}, {how}");
        let variants = shares.iter().map(above).collect();
        families.push(Family { order: 2, variants, words, carriers: Carriers::All, natural: false });
        let below = |share: &f64| vec![format!("max(0, {:.4} - {letter}){exponent}", at(*share))];
        let words = format!("below an angle of {letter}, {how}");
        let variants = shares.iter().map(below).collect();
        families.push(Family { order: 2, variants, words, carriers: Carriers::All, natural: false });
        if low < -0.2 && high > 0.2 {
            let reach = high.min(-low);
            let beyond =
                |share: &f64| vec![format!("max(0, abs({letter}) - {:.4}){exponent}", share * reach)];
            let words = format!("on both sides beyond an angle of {letter}, {how}");
            let variants = shares.iter().map(beyond).collect();
            families.push(Family { order: 2, variants, words, carriers: Carriers::All, natural: false });
        }
    }
    let step = |share: &f64| vec![format!("step({letter} - {:.4})", at(*share))];
    let words = format!("switching at an angle of {letter}");
    let variants = shares.iter().map(step).collect();
    families.push(Family { order: 2, variants, words, carriers: Carriers::All, natural: false });
}

fn times(duration_s: f64, rotary: &[AxisLetter], families: &mut Vec<Family>) {
    for (order, factors, words) in companions(rotary) {
        let line = vec![products(&[format!("(t/{duration_s:.0} - 0.5)")], &factors)];
        let linear_words = format!("growing with time{words}");
        families.push(Family {
            order: order + 1,
            variants: line,
            words: linear_words,
            carriers: Carriers::All,
            natural: false,
        });
        let decays = [0.06, 0.15, 0.4];
        let warming = |share: &f64| products(&[format!("(1 - exp(-t/{:.1}))", share * duration_s)], &factors);
        let variants = decays.iter().map(warming).collect();
        let words = format!("settling with time{words}");
        families.push(Family { order: order + 2, variants, words, carriers: Carriers::All, natural: false });
    }
    let step = |i: i32| vec![format!("step(t - {:.1})", duration_s * f64::from(i) / 13.0)];
    let words = "switching at one moment".into();
    families.push(Family {
        order: 1,
        variants: (1..13).map(step).collect(),
        words,
        carriers: Carriers::All,
        natural: false,
    });
    let wave = |i: i32| {
        let rate = 2.0 * PI * 1.35_f64.powi(i) * 2.0 / duration_s;
        vec![format!("cos({rate:.6}*t)"), format!("sin({rate:.6}*t)")]
    };
    let words = "coming and going with time".into();
    families.push(Family {
        order: 2,
        variants: (0..7).map(wave).collect(),
        words,
        carriers: Carriers::All,
        natural: false,
    });
}
