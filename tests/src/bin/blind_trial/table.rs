//! The tables of `docs/measured/blind-trial.md`.

use crate::Args;
use crate::baseline_table;
use crate::cases::{Group, SIZES, Visible};
use crate::coverage::Covered;
use crate::noise::Kind as NoiseKind;
use crate::score::{EQUIVALENT, Outcome};
use crate::trial::Trial;

/// A column of a table: heading, the answers counted, the goal at a size.
type Column = (&'static str, &'static [Outcome], fn(f64) -> &'static str);

const NO_GOAL: fn(f64) -> &'static str = |_| "";

/// What is counted for each group, with the goals.
fn columns(group: Group) -> &'static [Column] {
    match group {
        Group::Null => &[
            ("claims something", &[Outcome::Claim], |_| "≤ 1 %"),
            ("undecided", &[Outcome::Undecided], |_| "< 25 %"),
        ],
        Group::Single => &[
            ("exact", &[Outcome::Exact], |size| if size < 1.0 { "≥ 95 %" } else { "≥ 99 %" }),
            ("equivalent", &[Outcome::Equivalent], NO_GOAL),
            ("undecided", &[Outcome::Undecided], NO_GOAL),
            ("all clear", &[Outcome::Missed], NO_GOAL),
            ("more than it", &[Outcome::Extra], NO_GOAL),
            ("unnamed", &[Outcome::Unnamed], NO_GOAL),
            ("wrong name", &[Outcome::Wrong], |_| "≤ 0.5 %"),
            ("wrong, doubted", &[Outcome::Doubted], NO_GOAL),
        ],
        Group::Pair => &[
            ("exact", &[Outcome::Exact], |size| if size < 1.0 { "" } else { "≥ 95 %" }),
            ("equivalent", &[Outcome::Equivalent], NO_GOAL),
            ("undecided", &[Outcome::Undecided], NO_GOAL),
            ("all clear", &[Outcome::Missed], NO_GOAL),
            ("one of two", &[Outcome::Fewer], NO_GOAL),
            ("more than both", &[Outcome::Extra], NO_GOAL),
            ("unnamed", &[Outcome::Unnamed], NO_GOAL),
            ("wrong", &[Outcome::Wrong], NO_GOAL),
            ("wrong, doubted", &[Outcome::Doubted], NO_GOAL),
        ],
        Group::TakenOut => &[
            ("said to be outside", &[Outcome::Unnamed], NO_GOAL),
            ("equivalent", &[Outcome::Equivalent], NO_GOAL),
            ("undecided", &[Outcome::Undecided], NO_GOAL),
            ("all clear", &[Outcome::Missed], NO_GOAL),
            ("wrongly confirmed", &[Outcome::Wrong], |_| "≤ 2 %"),
            ("wrong, doubted", &[Outcome::Doubted], NO_GOAL),
        ],
        Group::Unnamed => &[
            ("said to be outside", &[Outcome::Unnamed], |size| if size < 2.0 { "" } else { "≥ 90 %" }),
            ("equivalent", &[Outcome::Equivalent], NO_GOAL),
            ("undecided", &[Outcome::Undecided], NO_GOAL),
            ("all clear", &[Outcome::Missed], NO_GOAL),
            ("wrongly confirmed", &[Outcome::Wrong], |_| "≤ 5 %"),
            ("wrong, doubted", &[Outcome::Doubted], NO_GOAL),
        ],
    }
}

fn title(group: Group) -> &'static str {
    match group {
        Group::Null => "Nothing hidden",
        Group::Single => "One effect of the catalogue",
        Group::Pair => "Two effects of the catalogue",
        Group::TakenOut => "An effect taken out of the catalogue",
        Group::Unnamed => "A shape that is in no catalogue",
    }
}

/// What must be known to read a group's table; empty for most.
fn remark(group: Group) -> &'static str {
    match group {
        Group::Unnamed => {
            "The grammar has forms of most of these shapes (bumps, steps, stops, loops, duty cycles), and those of Dahl loops and duty \
             cycles were added by people who knew the simulator's equations: the table says how well such shapes are found by \
             expression, not how a shape fares that nobody thought of.\n\n"
        }
        _ => "",
    }
}

/// The whole file.
pub fn document(args: &Args, visible: &Visible, trials: &[Trial], coverage: &[Covered]) -> String {
    let mut text = introduction(args, visible);
    for group in Group::ALL {
        let of_group: Vec<&Trial> = trials.iter().filter(|trial| trial.case.group == group).collect();
        if of_group.is_empty() {
            continue;
        }
        text += &format!("\n## {}\n\n{}{}", title(group), remark(group), group_table(group, &of_group));
        if group != Group::Null {
            text += &format!("\n{}", effect_table(group, &of_group));
        }
    }
    text.push_str(&baseline_table::section(trials));
    if !coverage.is_empty() {
        text.push_str(&coverage_table(coverage));
    }
    if !trials.is_empty() {
        let mut seconds: Vec<f64> = trials.iter().map(|trial| trial.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        text += &format!(
            "\nOne diagnosis of 336 points took {:.2} s (median; longest {:.2} s), two at a time; goal: ≤ 1 s.\n",
            median(&seconds),
            seconds[seconds.len() - 1]
        );
    }
    text
}

fn introduction(args: &Args, visible: &Visible) -> String {
    let mut command =
        format!("cargo run --release -p trunnion-tests --bin blind-trial -- --seeds {}", args.seeds);
    if args.first_seed != 0 {
        command += &format!(" --first-seed {}", args.first_seed);
    }
    if !args.only.is_empty() {
        command += &format!(" --only \"{}\"", args.only);
    }
    if let Some(most) = args.most {
        command += &format!(" --most {most}");
    }
    if args.coverage_only {
        command.push_str(" --coverage-only");
    }
    command.push_str(" --markdown docs/measured/blind-trial.md");
    format!(
        "# Blind trial\n\n\
        The simulator hides physics in a five-axis machine and measures it with an R-test on the S1 grid: two heights, both \
        directions, 336 points. The program gets the recording and nothing else. Simulator and program share no line of error \
        physics. Written by\n\n    {command}\n\n\
        - **Size**: a hidden effect is scaled so that its rms after ordinary least squares with the base model (location errors, \
        ball settings) is the given multiple of σ = 0.3 µm, the white noise of one reading; under every kind of noise the same \
        σ. Draws of which the base model swallows more than 93 % are drawn again. Each of two effects has the size by itself.\n\
        - **Noise**: *white* is σ alone; *real* adds slow drift, an offset for every pass, re-positioning scatter, small natural error \
        motions of both rotary axes and 1 % outliers; *foreign* is in no bank of noise models: heavy tails (Student, 4 degrees of \
        freedom) of a size that grows with the tilt, a random walk with jumps, a slow sine.\n\
        - **Exact**: the effects named are those hidden and no others. **Equivalent**: other names, no more of them, that remove \
        at least {:.0} % of what is hidden when fitted without noise, on this grid and on the unseen one. \
        **Unnamed**: the verdict is `unnamed-structure`. **Wrong** (wrongly confirmed): another name without a \
        remark; **doubted**: another name with the remark that a part remains.\n\
        - **Captured**: share of the hidden signal's surviving variance that base model and found set, fitted to the trial, \
        remove on an *unseen* cycle of the same machine (heights 85 and 135 mm instead of 60 and 160, B shifted by 15°, C by 7.5°, no noise, base model \
        fitted again). Of runs in which something was found.\n\
        - **Ladder end**: rms after base model and found set over the rms of the same readings without the \
        hidden part after the base model.\n\
        - Cells: count of runs (share).\n\n\
        Hidden from the catalogue: {}. In no catalogue: {}.{}\n",
        100.0 * EQUIVALENT,
        visible.catalogued.join(", "),
        visible.uncatalogued.join(", "),
        if visible.invisible.is_empty() {
            String::new()
        } else {
            format!(" Not visible on this grid, so not asked: {}.", visible.invisible.join(", "))
        }
    )
}

/// Counts by noise and size.
fn group_table(group: Group, trials: &[&Trial]) -> String {
    let sizes: &[f64] = if group == Group::Null { &[0.0] } else { &SIZES };
    let is_null = group == Group::Null;
    let mut heading = vec!["noise".to_string()];
    if !is_null {
        heading.push("size".into());
    }
    heading.push("runs".into());
    for (name, _, goal) in columns(group) {
        heading.push((*name).into());
        if sizes.iter().any(|&size| !goal(size).is_empty()) {
            heading.push("goal".into());
        }
    }
    if !is_null {
        let goal = if group == Group::Unnamed { "; goal ≥ 80 %" } else { "" };
        heading.push(format!("captured, median{goal}"));
        heading.extend(["captured ≥ 80 %", "ladder end, median (worst); goal ≤ 1.03"].map(String::from));
    }
    let mut rows = Vec::new();
    for noise in NoiseKind::ALL {
        for &size in sizes {
            let here: Vec<&&Trial> =
                trials.iter().filter(|trial| trial.case.noise == noise && trial.case.size == size).collect();
            if here.is_empty() {
                continue;
            }
            let mut row = vec![noise.name().to_string()];
            if !is_null {
                row.push(format!("{size} σ"));
            }
            row.push(here.len().to_string());
            for (_, outcomes, goal) in columns(group) {
                let count = here.iter().filter(|trial| outcomes.contains(&trial.outcome)).count();
                row.push(counted(count, here.len()));
                if sizes.iter().any(|&size| !goal(size).is_empty()) {
                    row.push(goal(size).into());
                }
            }
            if !is_null {
                row.extend(quality(&here));
            }
            rows.push(row);
        }
    }
    markdown(&heading, &rows)
}

/// Captured and ladder end of the runs in which something was found.
fn quality(trials: &[&&Trial]) -> [String; 3] {
    let mut captured: Vec<f64> = trials.iter().filter_map(|trial| trial.captured).collect();
    captured.sort_by(f64::total_cmp);
    let mut ladder: Vec<f64> = trials.iter().filter_map(|trial| trial.ladder_end).collect();
    ladder.sort_by(f64::total_cmp);
    let most = captured.iter().filter(|share| **share >= 0.8).count();
    let empty = "–".to_string();
    [
        if captured.is_empty() { empty.clone() } else { format!("{:.1} %", 100.0 * median(&captured)) },
        if captured.is_empty() { empty.clone() } else { counted(most, captured.len()) },
        match ladder.last() {
            Some(worst) => format!("{:.3} ({worst:.3})", median(&ladder)),
            None => empty,
        },
    ]
}

/// Good answers of each hidden effect, by noise and size.
fn effect_table(group: Group, trials: &[&Trial]) -> String {
    let mut hidden: Vec<String> = trials.iter().map(|trial| trial.case.hidden.join(" + ")).collect();
    hidden.dedup();
    let good = match group {
        Group::Null | Group::Single | Group::Pair => "exact or equivalent",
        Group::TakenOut | Group::Unnamed => "said to be outside, or equivalent",
    };
    let asked = |noise, size| move |trial: &&&Trial| trial.case.noise == noise && trial.case.size == size;
    let kinds = NoiseKind::ALL.into_iter().flat_map(|noise| SIZES.map(|size| (noise, size)));
    let kinds: Vec<_> =
        kinds.filter(|&(noise, size)| trials.iter().any(|t| asked(noise, size)(&t))).collect();
    let mut heading = vec![format!("hidden ({good})")];
    heading.extend(kinds.iter().map(|(noise, size)| format!("{} {size} σ", noise.name())));
    let row = |name: &String| {
        let of_name: Vec<&&Trial> =
            trials.iter().filter(|trial| trial.case.hidden.join(" + ") == *name).collect();
        let mut row = vec![name.clone()];
        row.extend(kinds.iter().map(|&(noise, size)| {
            let here: Vec<_> = of_name.iter().copied().filter(asked(noise, size)).collect();
            let good = here.iter().filter(|trial| trial.outcome.is_good(group)).count();
            format!("{good} of {}", here.len())
        }));
        row
    };
    markdown(&heading, &hidden.iter().map(row).collect::<Vec<_>>())
}

/// Coverage by kind of noise.
fn coverage_table(coverage: &[Covered]) -> String {
    let heading: Vec<String> =
        ["noise", "parameters", "intervals", "hold the truth", "goal", "rms pull"].map(String::from).into();
    let mut rows = Vec::new();
    for noise in NoiseKind::ALL {
        let of_noise = || coverage.iter().filter(move |covered| covered.noise == noise);
        let pulls = |of: fn(&Covered) -> &Vec<(String, f64)>| -> Vec<f64> {
            of_noise().flat_map(|covered| of(covered).iter().map(|(_, pull)| *pull)).collect()
        };
        for (name, pulls) in
            [("location errors", pulls(|c| &c.location)), ("of the effect", pulls(|c| &c.effect))]
        {
            if pulls.is_empty() {
                continue;
            }
            let hold = pulls.iter().filter(|pull| Covered::holds(**pull)).count();
            let squares: f64 = pulls.iter().map(|pull| pull * pull).sum();
            rows.push(vec![
                noise.name().into(),
                name.into(),
                pulls.len().to_string(),
                counted(hold, pulls.len()),
                "93–97 %".into(),
                format!("{:.2}", (squares / pulls.len() as f64).sqrt()),
            ]);
        }
    }
    let left_out: usize = coverage.iter().map(|covered| covered.left_out).sum();
    format!(
        "\n## Intervals of uncertainty\n\n\
        One effect hidden, identified with the right model: how many intervals value ± 1.96 u hold the truth. Truth of a \
        location error: as drawn. Truth of the effect's own parameters: what the right model says of the same machine without noise, if \
        it then leaves nothing. {left_out} parameters have no single truth (the effect as drawn contains a part of a location \
        error, the catalogue's form is a little different, or noise chose another time constant) and do not count.\n\n{}",
        markdown(&heading, &rows)
    )
}

/// One line for every interval that does not hold the truth.
pub fn missed_intervals(coverage: &[Covered]) -> String {
    let mut text = String::new();
    for covered in coverage {
        for (name, pull) in covered.location.iter().chain(&covered.effect) {
            if !Covered::holds(*pull) {
                text += &format!("{}: {name} is {pull:.1} u off\n", covered.label);
            }
        }
    }
    text
}

/// One line for every answer that is not right.
pub fn failures(trials: &[Trial]) -> String {
    let mut text = String::new();
    for trial in trials.iter().filter(|trial| !trial.outcome.is_good(trial.case.group)) {
        let number = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.3}"));
        text += &format!(
            "{} #{}: {} {} [{}] formula {} captured {} (these poses {}) ladder {}{}\n",
            trial.case.label(),
            trial.case.seed,
            trial.outcome.name(),
            trial.verdict.as_str(),
            trial.found.join(", "),
            trial.expression.as_deref().unwrap_or("–"),
            number(trial.captured),
            number(trial.captured_here),
            number(trial.ladder_end),
            trial.trouble.as_ref().map_or(String::new(), |trouble| format!(" TROUBLE {trouble}")),
        );
    }
    text
}

pub fn counted(count: usize, of: usize) -> String {
    format!("{count} ({:.1} %)", 100.0 * count as f64 / of.max(1) as f64)
}

/// Of sorted numbers; the upper one of two middles.
fn median(sorted: &[f64]) -> f64 {
    sorted[sorted.len() / 2]
}

pub fn markdown(heading: &[String], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule: Vec<String> = heading.iter().map(|_| "---".into()).collect();
    [line(heading), line(&rule)].into_iter().chain(rows.iter().map(|row| line(row))).collect()
}
