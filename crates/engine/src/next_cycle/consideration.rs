//! The utility of one candidate cycle: can the machine run it, how long does it take, what would it separate.

use super::answer::Considered;
use super::candidates::Candidate;
use super::design::CycleDesign;
use super::knowledge::Knowledge;
use super::options::{HOPELESS_LN, Options, PlanError};
use super::utility::Utility;
use trunnion_core::{Setup, State};
use trunnion_cycles::Pace;
use trunnion_cycles::{Cycle, RunKind};
use trunnion_machine::Machine;

impl CycleDesign<'_> {
    /// One candidate cycle; `None` when the machine cannot run it.
    pub(super) fn consider(
        &self,
        candidate: &Candidate,
        knowledge: &Knowledge,
        options: &Options,
    ) -> Result<Option<Considered>, PlanError> {
        let cycle = &candidate.cycle;
        let machine = self.present.experiment.machine();
        let Ok(visits) = cycle.visits(machine, &options.pace) else { return Ok(None) };
        if !within_feeds(machine, &visits.states, &options.pace) {
            return Ok(None);
        }
        let states = thinned(visits.states, options.most_points);
        let utility = self.after(&cycle.setups, &states, cycle.run_kind(), knowledge)?;
        Ok(Some(self.row(&candidate.what, Some(cycle), visits.duration_s, utility)))
    }

    /// The same cycle measured once more: the baseline.
    pub(super) fn again(&self, knowledge: &Knowledge, options: &Options) -> Result<Considered, PlanError> {
        let states = self.present.last_states();
        let times = || states.iter().filter_map(|state| state.time_s);
        let duration_s = times().fold(f64::NEG_INFINITY, f64::max) - times().fold(f64::INFINITY, f64::min);
        let duration_s = if duration_s.is_finite() { duration_s } else { 4.0 * states.len() as f64 };
        let setups = self.present.last_setups();
        let utility = self.after(setups, &states, self.present.last_kind(), knowledge)?;
        Ok(self.row("the same once more", None, duration_s + options.pace.mount_s, utility))
    }

    fn after(
        &self,
        setups: &[Setup],
        states: &[State],
        kind: RunKind,
        knowledge: &Knowledge,
    ) -> Result<Utility, PlanError> {
        let both = self.present.with(setups, states, kind, self.instances)?;
        Ok(self.utility(&both, knowledge))
    }

    fn row(&self, what: &str, cycle: Option<&Cycle>, duration_s: f64, utility: Utility) -> Considered {
        let pairs = utility.pairs();
        let hardest = pairs.iter().min_by(|a, b| a.2.total_cmp(&b.2));
        let id = |i: usize| self.entries[i].id.clone();
        let ids =
            |test: &dyn Fn(usize) -> bool| (0..self.entries.len()).filter(|&i| test(i)).map(id).collect();
        let apart = |pair: &&(usize, usize, f64)| pair.2 >= self.separated_ln;
        Considered {
            name: cycle.map_or("again".into(), |cycle| cycle.name.clone()),
            what: what.into(),
            minutes: duration_s / 60.0,
            separation_ln: hardest.map_or(utility.seen_ln[0], |pair| pair.2),
            hardest: hardest.map_or([id(0), id(0)], |&(a, b, _)| [id(a), id(b)]),
            apart: pairs.iter().filter(apart).map(|&(a, b, _)| [id(a), id(b)]).collect(),
            gain: self.gain(&utility),
            shows: ids(&|i| utility.seen_ln[i] > HOPELESS_LN),
            separates: ids(&|i| utility.discriminated_ln(i) > HOPELESS_LN),
            cycle: cycle.cloned(),
        }
    }
}

/// Every so many-th state, at most `most`.
pub(super) fn thinned(states: Vec<State>, most: usize) -> Vec<State> {
    let stride = states.len().div_ceil(most).max(1);
    states.into_iter().step_by(stride).collect()
}

/// True when no axis has to follow faster than it can.
pub(super) fn within_feeds(machine: &Machine, states: &[State], pace: &Pace) -> bool {
    machine.axes().all(|axis| {
        let usual = if axis.is_rotary() { pace.rotary_rad_per_s } else { pace.linear_mm_per_s };
        // A limit that the machine file gives is exact, the usual one is not.
        let limit = axis.facts.feed_limit.unwrap_or(1.5 * usual);
        states.iter().all(|state| state.velocity[axis.letter].abs() <= limit * (1.0 + 1e-9))
    })
}
