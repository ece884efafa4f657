//! Runs given together between which the machine was corrected: no fit holds for both.
//!
//! Days of one machine differ, and may differ by all that warming makes of it. But what a day changes has no direction towards zero: that m location errors
//! come out smaller by a factor r all together has, for two days of the same variance, the chance P(F(m, m) > r²) [Fisher]. A correction does
//! just that.
//! Limits: a correction that left more than a quarter, or of fewer errors, looks like one day and the next. Runs as unlike as those of two machines are
//! said to be so and judged all the same: a machine may have changed so far.

use super::changed::{BEYOND_DAYS_UM, Remainders, changed};
use super::found::{Implausible, plain};
use crate::fit::Options;
use crate::{Experiment, HeldOut, Identification, identify};
use std::collections::BTreeMap;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::signed;
use trunnion_core::statistics::rms;
use trunnion_cycles::Run;
use trunnion_effects::catalogue::LOCATION_ERRORS;
use trunnion_effects::{Model, Unit};

/// How many times smaller the location errors are after a correction, root mean square, and of how many: P(F(7, 7) > 16) < 10⁻³ [Fisher].
const TIMES: f64 = 4.0;
const FEWEST: usize = 7;
/// Smaller ones before it are those of a machine that needs no correction, µm rms.
const NEEDED_UM: f64 = super::exchanged::GROSS_UM;

/// Errors of two machines are independent: the square of their differences is, on average, the sum of their squares. Of one machine they
/// differ by what changed alone; half of that sum are errors at 60° to each other.
const INDEPENDENT: f64 = 0.5;
/// Each of them differs by so many standard uncertainties: one in 16 000 of equal ones does [normal distribution].
const SURE: f64 = 4.0;

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    of_neighbours(runs, corrected)
}

/// Two runs that are not of one state of one machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Unlike {
    /// Names of the runs.
    pub runs: [String; 2],
    /// How that shows.
    pub how: How,
    /// The location error that differs most of those that both determine, if any.
    pub most: Option<Differs>,
}

/// How it shows that two runs are not of one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum How {
    /// Location errors are as unlike as those of two machines.
    OfTwoMachines {
        /// How many both determine; all differ.
        count: usize,
        /// By how much, root mean square at the ball, µm.
        differ_um: f64,
    },
    /// Each has its own, and they have none in common.
    Changed(Remainders),
}

/// A location error with its value in each of two runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Differs {
    /// Its name.
    pub name: String,
    /// The values.
    pub shown: [String; 2],
}

/// Neighbouring runs of one machine that are not of one state of it.
pub fn unlike(runs: &[Run]) -> Vec<Unlike> {
    of_neighbours(runs, unlike_pair)
}

fn of_neighbours<T>(
    runs: &[Run],
    of_pair: impl Fn([&Run; 2], [&Identification; 2], f64) -> Option<T>,
) -> Vec<T> {
    if runs.len() < 2 || runs.iter().any(|run| run.machine != runs[0].machine) {
        return Vec::new();
    }
    let fits: Vec<Option<Identification>> = runs.iter().map(alone).collect();
    let lever_mm = runs.iter().map(lever_mm).fold(0.0, f64::max);
    let of_pair =
        |k: usize| of_pair([&runs[k], &runs[k + 1]], [fits[k].as_ref()?, fits[k + 1].as_ref()?], lever_mm);
    (0..runs.len() - 1).filter_map(of_pair).collect()
}

fn alone(run: &Run) -> Option<Identification> {
    let experiment = Experiment::new(std::slice::from_ref(run)).ok()?;
    let options = Options { holdout: HeldOut::Skipped, ..Options::default() };
    identify(&experiment, &Model::base(&run.machine.name), &options).ok()
}

/// At which angles move a ball.
fn lever_mm(run: &Run) -> f64 {
    run.setups.iter().map(|setup| setup.ball_in_table_mm.coords.norm()).fold(0.0, f64::max)
}

/// A location error that both runs know.
struct Known<'a> {
    name: &'a str,
    /// What they move a ball by, µm.
    moves_um: [f64; 2],
    u_um: f64,
    shown: [String; 2],
}

impl Known<'_> {
    fn differs_um(&self) -> f64 {
        (self.moves_um[1] - self.moves_um[0]).abs()
    }
}

fn unlike_pair(runs: [&Run; 2], fits: [&Identification; 2], lever_mm: f64) -> Option<Unlike> {
    let known = known(fits, lever_mm);
    let how = of_two_machines(&known).or_else(|| changed(runs).map(How::Changed))?;
    let sure = known.iter().filter(|one| one.differs_um() > SURE * one.u_um);
    let most = sure.max_by(|a, b| a.differs_um().total_cmp(&b.differs_um()));
    Some(Unlike {
        runs: runs.map(|run| run.name.clone()),
        how,
        most: most.map(|most| Differs { name: most.name.into(), shown: most.shown.clone() }),
    })
}

fn of_two_machines(known: &[Known<'_>]) -> Option<How> {
    let differ_um = rms(known.iter().map(Known::differs_um))?;
    let sizes_um = rms(known.iter().map(|one| one.moves_um[0].hypot(one.moves_um[1])))?;
    let all_differ = known.iter().all(|one| one.differs_um() > SURE * one.u_um);
    let is_unlike = known.len() >= FEWEST
        && all_differ
        && differ_um > BEYOND_DAYS_UM
        && differ_um.powi(2) > INDEPENDENT * sizes_um.powi(2);
    is_unlike.then_some(How::OfTwoMachines { count: known.len(), differ_um })
}

fn corrected(runs: [&Run; 2], fits: [&Identification; 2], lever_mm: f64) -> Option<Implausible> {
    let known = known(fits, lever_mm);
    if known.len() < FEWEST {
        return None;
    }
    let rms_um = [0, 1].map(|k| rms(known.iter().map(|one| one.moves_um[k])).unwrap_or(0.0));
    let u_um = rms(known.iter().map(|one| one.u_um)).unwrap_or(0.0);
    let (large, small) = (rms_um[0].max(rms_um[1]), rms_um[0].min(rms_um[1]));
    if large < NEEDED_UM || large < TIMES * small.max(u_um) {
        return None;
    }
    let most = known.iter().max_by(|a, b| a.differs_um().total_cmp(&b.differs_um()))?;
    Some(plain(
        format!(
            "The runs {0} and {1} are not of one state of the machine: {2} is {3} in {0} and {4} in {1}, and all location errors together are {5:.0} times \
             smaller in {6}.",
            runs[0].name,
            runs[1].name,
            most.name,
            most.shown[0],
            most.shown[1],
            large / small,
            if rms_um[1] < rms_um[0] { &runs[1].name } else { &runs[0].name },
        ),
        "Was a correction entered between them? Fit them one by one: what is fitted to both holds for neither.",
    ))
}

/// Of the same meaning in both: what stands for others does so in both.
fn known<'a>(fits: [&'a Identification; 2], lever_mm: f64) -> Vec<Known<'a>> {
    let of_fit = |fit: &'a Identification| {
        let own = fit.parameters.iter().filter(|one| one.effect == LOCATION_ERRORS);
        own.map(|one| ((one.name.as_str(), one.note.as_str()), one)).collect::<BTreeMap<_, _>>()
    };
    let [first, second] = fits.map(of_fit);
    let both = first.into_iter().filter_map(|(key, a)| Some((key.0, [a, *second.get(&key)?])));
    both.filter_map(|(name, pair)| {
        let [a, b] = pair.map(|one| Some((one.value?, one.u?)));
        let (values, u) = ([a?.0, b?.0], a?.1.hypot(b?.1));
        let unit = pair[0].unit;
        let mm = if unit == Unit::URAD { lever_mm } else { 1.0 };
        let shown = values.map(|value| format!("{} {}", signed(value * unit.per_inside, 1), unit.text()));
        Some(Known {
            name,
            moves_um: values.map(|value| um_from_mm(mm * value)),
            u_um: um_from_mm(mm * u),
            shown,
        })
    })
    .collect()
}
