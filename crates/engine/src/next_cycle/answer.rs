//! The plan.

use super::design::CycleDesign;
use super::options::{HOPELESS_LN, Options};
use super::planned::{Goal, PlannedCycle};
use super::rivals::Rivals;
use super::utility::Utility;
use std::f64::consts::LN_10;
use trunnion_core::convert;
use trunnion_core::number::odds;
use trunnion_cycles::Cycle;
use trunnion_cycles::Pace;
use trunnion_effects::{Instance, Need};

/// What to measure next, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What the next cycle is for.
    pub goal: Goal,
    /// The effects in question.
    pub effects: Vec<String>,
    /// The effects in question that no cycle considered would show.
    pub never_shown: Vec<String>,
    /// Expected ln Bayes factor of the hardest pair in the present data.
    pub before_ln: f64,
    /// Cycles considered, best first; the first is the choice unless `next` is `None`.
    pub considered: Vec<Considered>,
    /// The cycle to measure next; `None` when no cycle of poses and feeds helps.
    pub next: Option<Cycle>,
    /// What it costs and settles.
    pub planned: Option<PlannedCycle>,
    /// Pairs that are still not separated after the next cycle.
    pub left_open: Vec<LeftOpen>,
    /// The answer in words.
    pub answer: String,
    /// What was assumed of machine time and noise.
    pub assumptions: Vec<String>,
}

/// Two effects that the next cycle does not separate.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOpen {
    /// The two.
    pub pair: [String; 2],
    /// The cheapest cycle considered that would; `None` when none does.
    pub by: Option<String>,
}

/// One cycle that was considered.
#[derive(Clone, Debug, PartialEq)]
pub struct Considered {
    /// Its name.
    pub name: String,
    /// What it does.
    pub what: String,
    /// Machine time with mounting, min.
    pub minutes: f64,
    /// Expected ln Bayes factor of the hardest pair afterwards.
    pub separation_ln: f64,
    /// The hardest pair.
    pub hardest: [String; 2],
    /// Pairs that it distinguishes.
    pub apart: Vec<[String; 2]>,
    /// What the plan makes large per minute.
    pub gain: f64,
    /// Effects it shows.
    pub shows: Vec<String>,
    /// Effects it separates from all others in question.
    pub separates: Vec<String>,
    /// The cycle; `None` for the present one.
    pub cycle: Option<Cycle>,
}

/// Ranks what was considered and chooses.
pub(super) fn answer(
    design: &CycleDesign<'_>,
    before: &Utility,
    mut considered: Vec<Considered>,
    options: &Options,
) -> Plan {
    let separates = matches!(design.rivals, Rivals::Separate(_));
    let goal = if separates { Goal::Separate } else { Goal::Reveal };
    let effects = design.ids();
    let gain_before = design.gain(before);
    let pairs = before.pairs();
    let apart_before = pairs.iter().filter(|pair| pair.2 >= design.separated_ln).count();
    let rate = |row: &Considered| (row.gain - gain_before).max(0.0) / row.minutes.max(0.1);
    let complete = |row: &Considered| row.cycle.is_some() && (!separates || row.apart.len() == pairs.len());
    // What cannot settle all settles first which of the others is not the first rival: the one that leads the diagnosis.
    let of_leader =
        |row: &Considered| row.apart.iter().filter(|pair| separates && pair[0] == effects[0]).count();
    let order = |row: &Considered| (complete(row), of_leader(row));
    considered.sort_by(|a, b| {
        order(b).cmp(&order(a)).then(rate(b).total_cmp(&rate(a))).then(b.gain.total_cmp(&a.gain))
    });
    let helps = |row: &Considered| {
        row.cycle.is_some()
            && if separates { row.apart.len() > apart_before } else { row.gain > gain_before + HOPELESS_LN }
    };
    let chosen = considered.iter().position(helps);
    let next = chosen.and_then(|k| considered[k].cycle.clone()).map(|cycle| named(cycle, design));
    if let Some(k) = chosen {
        let row = considered.remove(k);
        considered.insert(0, row);
    }
    let left_open =
        if separates { left_open(&considered, &pairs, &effects, next.is_some()) } else { Vec::new() };
    let before_ln = pairs.iter().map(|pair| pair.2).fold(f64::INFINITY, f64::min);
    let shown = |id: &String| considered.iter().any(|row| row.shows.contains(id));
    let never_shown = effects.iter().filter(|id| !shown(id)).cloned().collect();
    let answer = match considered.first().filter(|_| next.is_some()) {
        None if separates && before.seen_ln.iter().all(|ln| *ln < design.separated_ln) => {
            too_faint(design, before)
        }
        None if separates => none_separates(design, apart_before == pairs.len(), before_ln, considered.len()),
        best => words(design, best, &left_open, before_ln),
    };
    let before_ln = if before_ln.is_finite() { before_ln } else { 0.0 };
    let planned = next.as_ref().zip(considered.first()).map(|(cycle, row)| planned(cycle, row, before_ln));
    Plan {
        goal,
        effects,
        never_shown,
        before_ln,
        considered,
        next,
        planned,
        left_open,
        answer,
        assumptions: assumptions(&options.pace),
    }
}

fn planned(cycle: &Cycle, row: &Considered, before_ln: f64) -> PlannedCycle {
    PlannedCycle {
        name: cycle.name.clone(),
        what: row.what.clone(),
        minutes: row.minutes,
        separation_before: Some(before_ln / LN_10),
        separation: Some(row.separation_ln / LN_10),
        separates: row.apart.clone(),
        file: cycle.to_text(),
    }
}

/// Pairs that the choice does not separate, each with the cheapest cycle that would.
fn left_open(
    considered: &[Considered],
    pairs: &[(usize, usize, f64)],
    effects: &[String],
    found: bool,
) -> Vec<LeftOpen> {
    let ids = pairs.iter().map(|&(a, b, _)| [effects[a].clone(), effects[b].clone()]);
    ids.filter(|pair| !found || !considered[0].apart.contains(pair))
        .map(|pair| {
            let would = considered.iter().filter(|row| row.cycle.is_some() && row.apart.contains(&pair));
            let by = would.min_by(|a, b| a.minutes.total_cmp(&b.minutes)).map(|row| row.name.clone());
            LeftOpen { pair, by }
        })
        .collect()
}

fn named(cycle: Cycle, design: &CycleDesign<'_>) -> Cycle {
    let name = match design.rivals {
        Rivals::Separate(_) => format!("{}: {}", cycle.name, design.ids().join(" or ")),
        Rivals::Reveal(_) => cycle.name.clone(),
    };
    Cycle { name, ..cycle }
}

fn words(
    design: &CycleDesign<'_>,
    best: Option<&Considered>,
    left_open: &[LeftOpen],
    before_ln: f64,
) -> String {
    let ids = design.ids().join(", ");
    match (design.rivals, best) {
        (Rivals::Separate(_), Some(best)) => {
            let mut text = format!("To separate {ids}, measure {}: {}.", best.name, best.what);
            text += &if left_open.is_empty() {
                format!(
                    " The odds between the hardest pair rise from {} to {} in {:.0} minutes.",
                    odds(before_ln / LN_10),
                    odds(best.separation_ln / LN_10),
                    best.minutes
                )
            } else {
                format!(" It settles a part in {:.0} minutes.", best.minutes)
            };
            text + &left_open_words(design, left_open)
        }
        (Rivals::Reveal(_), Some(best)) => format!(
            "{} effects are not observable in the present cycle. The best cycle for these is {}: {}. In {:.0} minutes it would \
             show {} of them and separate {} from all others.",
            design.entries.len(),
            best.name,
            best.what,
            best.minutes,
            best.shows.len(),
            best.separates.len()
        ),
        (_, None) => {
            format!("No cycle considered shows more than the present one. Still not observable: {ids}.")
        }
    }
}

/// Why there is no cycle to choose: the present data separate the rivals as they are, no cycle of this machine and these setups was considered,
/// or none of those considered separates more. `considered` counts the present one too.
fn none_separates(design: &CycleDesign<'_>, all_apart: bool, before_ln: f64, considered: usize) -> String {
    let ids = design.ids().join(", ");
    let why = match (all_apart, considered.saturating_sub(1)) {
        (true, _) => {
            return format!(
                "The noise of the present data allows to separate {ids}: odds of {} are expected between the hardest pair. No further \
                 cycle is needed for that. Where they are found confounded, something else differs from all of them: add the first and \
                 diagnose again.",
                odds(before_ln / LN_10)
            );
        }
        (false, 0) => format!(
            "No cycle is known to the planner that separates {ids} on this machine with these setups."
        ),
        (false, count) => {
            format!("None of the {count} cycles considered separates more of {ids} than the present data do.")
        }
    };
    why + &load_words(design, &design.ids())
}

/// Where there is hardly anything to explain, no cycle can say what explains it.
fn too_faint(design: &CycleDesign<'_>, before: &Utility) -> String {
    let best_ln = before.seen_ln.iter().copied().fold(0.0, f64::max);
    format!(
        "The present data hold too little of {} for any cycle considered to separate them. The largest Bayes factor of one of \
         them against noise only is {}.",
        design.ids().join(", "),
        odds(best_ln / LN_10)
    )
}

fn left_open_words(design: &CycleDesign<'_>, left_open: &[LeftOpen]) -> String {
    let mut text = String::new();
    for open in left_open {
        let pair = open.pair.join(" and ");
        text += &match &open.by {
            Some(by) => format!(" It leaves {pair} open; {by} would separate them."),
            None => {
                format!(" No cycle considered separates {pair}.{}", load_words(design, &open.pair))
            }
        };
    }
    text
}

/// What only another load can show, and what else the catalogue knows.
fn load_words(design: &CycleDesign<'_>, ids: &[String]) -> String {
    let named = || design.instances.iter().filter(|instance| ids.contains(&instance.id()));
    let load =
        |instance: &Instance| instance.about().is_some_and(|about| about.helps.contains(&Need::AnotherLoad));
    let mut text = String::new();
    if named().any(load) {
        text += " Only another load separates them: put a known weight on the table, or a heavier tool into a tilting head, and measure the present cycle again.";
    }
    for instance in named() {
        if let Some(about) = instance.about() {
            text += &format!(" {} shows in: {}", instance.id(), about.seen_by);
        }
    }
    text
}

pub(super) fn assumptions(pace: &Pace) -> Vec<String> {
    vec![
        format!(
            "Machine time: feed limits of the machine file, else {:.0} m/min and {:.0}°/min; {:.1} s to settle in addition to the \
             window of the cycle; {:.0} min to mount each setup.",
            pace.linear_mm_per_s * 0.06,
            convert::deg_from_rad(pace.rotary_rad_per_s) * 60.0,
            pace.settle_s,
            pace.mount_s / 60.0
        ),
        "Noise: as in the present runs (the worst of white, re-positioning and drift that explains them); the ball \
         is mounted again."
            .into(),
        "Effects that the present data do not show are taken at a typical size.".into(),
    ]
}
