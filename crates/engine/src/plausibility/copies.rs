//! Is anything there twice?

mod stretch;

use super::chance::Displayed;
use super::found::{Implausible, plain};
use super::repeats::{self, FEWEST};
use super::shown::{Shown, would_differ};
use trunnion_core::Point;
use trunnion_cycles::{Run, RunKind};

/// Share of the rows of a setup that equal those of another: of two measurements only a coarse display makes some rows equal,
/// and all where it hides the noise.
const SAME_SHARE: f64 = 0.9;

/// Rows that are named.
const ROWS_SHOWN: usize = 4;

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    let of_run = |run: &Run| {
        let found: Vec<Implausible> = copies(run).into_iter().chain(setups(run)).chain(held(run)).collect();
        if !found.is_empty() {
            return found;
        }
        stretch::copied(run, FEWEST).or_else(|| repeats::copied(run)).into_iter().collect()
    };
    same_run(runs).into_iter().chain(runs.iter().flat_map(of_run)).collect()
}

/// The same in everything that was measured.
fn is_copy(a: &Point, b: &Point) -> bool {
    let (now, then) = (&a.state, &b.state);
    a.reading_mm == b.reading_mm
        && (now.time_s, now.setup, now.target) == (then.time_s, then.setup, then.target)
        && now.position == then.position
}

fn same_run(runs: &[Run]) -> Vec<Implausible> {
    let mut found = Vec::new();
    for b in 1..runs.len() {
        let same = |a: &usize| {
            let (a, b) = (&runs[*a].points, &runs[b].points);
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_copy(a, b))
        };
        if let Some(a) = (0..b).find(same) {
            found.push(plain(
                format!("The runs {} and {} are identical, reading by reading.", runs[a].name, runs[b].name),
                "One recording was given twice, so its repeats prove nothing. Give each recording once.",
            ));
        }
    }
    found
}

/// Points that were measured at different times never agree in every digit of time and readings.
fn copies(run: &Run) -> Option<Implausible> {
    let points = &run.points;
    let with_time = run.has_time();
    let mut order: Vec<usize> = (0..points.len()).collect();
    let count = if with_time {
        order.sort_by(|&a, &b| {
            points[a].state.time_s.partial_cmp(&points[b].state.time_s).unwrap_or(std::cmp::Ordering::Equal)
        });
        order.windows(2).filter(|pair| is_copy(&points[pair[0]], &points[pair[1]])).count()
    } else {
        // Without times a coarse display gives equal rows by itself; a second half that repeats the first is a copy.
        let half = points.len() / 2;
        let doubled = points.len() > FEWEST
            && points.len().is_multiple_of(2)
            && (0..half).all(|k| is_copy(&points[k], &points[half + k]));
        if doubled { half } else { 0 }
    };
    (count > 0).then(|| {
        plain(
            format!(
                "{}: {count} of {} points are copies of others, in time and readings.",
                run.name,
                points.len()
            ),
            "Rows were pasted twice, so their repeats prove nothing. Remove the duplicate rows.",
        )
    })
}

/// Readings that stay the same, in every channel and digit, from one pose to the next, more often than a display does it by chance.
fn held(run: &Run) -> Option<Implausible> {
    if run.kind != RunKind::Static || run.points.iter().any(|point| point.samples > 1) {
        return None;
    }
    (0..run.setups.len()).find_map(|setup| {
        let channels = run.setups[setup].instrument.components().len();
        let is_of_setup =
            |pair: &[Point]| pair.iter().all(|point| point.state.setup == setup && point.is_good());
        let moved = (2..)
            .zip(run.points.windows(2))
            .filter(|(_, pair)| is_of_setup(pair) && pair[0].state.position != pair[1].state.position);
        let (mut count, mut rows) = (0, Vec::new());
        for (row, pair) in moved {
            count += 1;
            if pair[0].reading_mm[..channels] == pair[1].reading_mm[..channels] {
                rows.push(row);
            }
        }
        // One channel rests by itself where it turns round.
        if channels < 2 || rows.len() < FEWEST {
            return None;
        }
        let is_held = Displayed::of(run, setup)?.held().is_no_chance();
        is_held.then(|| held_in(run, setup, &rows, count))
    })
}

fn held_in(run: &Run, setup: usize, rows: &[usize], of: usize) -> Implausible {
    let shown: Vec<String> = rows.iter().take(ROWS_SHOWN).map(usize::to_string).collect();
    let more = if rows.len() > ROWS_SHOWN { ", …" } else { "" };
    plain(
        format!(
            "{}: in {} of {of} rows of setup {} all readings are those of the row before, digit by digit, although the axes had moved (rows {}{more}).",
            run.name,
            rows.len(),
            run.setups[setup].name,
            shown.join(", ")
        ),
        "The readings were not new: they were taken before the probes had sent, or a program held its last values. Measure again, or \
         remove these rows.",
    )
}

/// Two setups whose readings are the same in every digit, row by row.
fn setups(run: &Run) -> Option<Implausible> {
    let of = |setup: usize| run.points.iter().filter(move |point| point.state.setup == setup);
    let pairs = (0..run.setups.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    let mut compared = pairs.map(|(a, b)| {
        let count = of(a).count().min(of(b).count());
        (a, b, count, of(a).zip(of(b)).filter(|(a, b)| a.reading_mm == b.reading_mm).count())
    });
    let is_copy = |(_, _, count, same): &(usize, usize, usize, usize)| {
        *count >= FEWEST && *same as f64 > SAME_SHARE * *count as f64
    };
    let (a, b, count, same) = compared.find(is_copy)?;
    (Shown::of(&run.setups[a], of(a)).is_alive() && would_differ(run, a)).then(|| {
        plain(
            format!(
                "{}: the readings of setup {} are those of setup {} in {same} of {count} points, digit by digit.",
                run.name, run.setups[b].name, run.setups[a].name
            ),
            "One setup was pasted under two names. Give each setup its own readings.",
        )
    })
}
