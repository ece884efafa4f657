//! What several named methods share: readings of a ball bar to first order, readings as displacements, readings of an axis that turns
//! alone, and their means over angle.

pub(crate) mod bar;
pub(crate) mod feed;
pub(crate) mod harmonics;
pub(crate) mod lone;
pub(crate) mod of_few;
pub(crate) mod over_height;
pub(crate) mod relative;
pub(crate) mod rounding;
pub(crate) mod shares;
pub(crate) mod significance;
pub(crate) mod stations;
pub(crate) mod turning;

use crate::recipes::{Method, MethodError};
use trunnion_core::{Point, Setup};
use trunnion_cycles::Run;

/// The good readings of one setup of one run.
pub(crate) struct Mounted<'a> {
    /// Name of the setup, with the number of its run where there are several.
    pub name: String,
    /// Index of the run.
    pub at: usize,
    pub run: &'a Run,
    pub setup: &'a Setup,
    pub points: Vec<&'a Point>,
    /// Number of each among the good readings of all runs, as a joint fit of them has it.
    pub numbers: Vec<usize>,
}

/// Every setup that was read.
pub(crate) fn mounted(runs: &[Run]) -> Vec<Mounted<'_>> {
    let (mut all, mut before) = (Vec::new(), 0);
    for (i, run) in runs.iter().enumerate() {
        for (s, setup) in run.setups.iter().enumerate() {
            let of_setup = (before..).zip(run.good_points()).filter(|(_, p)| p.state.setup == s);
            let (numbers, points): (Vec<usize>, Vec<&Point>) = of_setup.unzip();
            let name = if runs.len() > 1 { format!("{}.{}", i + 1, setup.name) } else { setup.name.clone() };
            all.push(Mounted { name, at: i, run, setup, points, numbers });
        }
        before += run.good_points().count();
    }
    all.retain(|mounted| !mounted.points.is_empty());
    all
}

/// Why parts of the runs were left out, `setup low: read by an R-test`, in one list: a reason of several parts is said once.
pub(crate) fn reasons(left_out: &[String]) -> String {
    let mut once: Vec<(&str, &str, Vec<&str>)> = Vec::new();
    for left in left_out {
        let (part, why) = left.split_once(": ").unwrap_or((left, ""));
        let (noun, name) = part.split_once(' ').unwrap_or((part, ""));
        match once.iter_mut().find(|(of, for_what, _)| *of == noun && *for_what == why) {
            Some((.., names)) => names.push(name),
            None => once.push((noun, why, vec![name])),
        }
    }
    let said = |(noun, why, names): &(&str, &str, Vec<&str>)| {
        let (last, others) = names.split_last().unwrap_or((&"", &[]));
        match others.is_empty() {
            true => format!("{noun} {last}: {why}"),
            false => format!("{noun}s {} and {last}: {why}", others.join(", ")),
        }
    };
    once.iter().map(said).collect::<Vec<_>>().join("; ")
}

/// What a method recognised, setup by setup.
pub(crate) struct Recognised<T> {
    pub all: Vec<T>,
    /// What was left out, one sentence each.
    pub left_out: Vec<String>,
}

impl<T> Recognised<T> {
    /// What `of` makes of every setup that was read; it is given what was recognised before, and says why it takes a setup not.
    /// `what` and `next`: where nothing is recognised, in which words that is reported, and what to do.
    ///
    /// # Errors
    /// Nothing is recognised.
    pub fn of<'a>(
        method: &Method,
        runs: &'a [Run],
        (what, next): (&str, &str),
        of: impl Fn(&Mounted<'a>, &[T]) -> Result<T, String>,
    ) -> Result<Self, MethodError> {
        let mut found = Self { all: Vec::new(), left_out: Vec::new() };
        for mounted in mounted(runs) {
            match of(&mounted, &found.all) {
                Ok(one) => found.all.push(one),
                Err(why) => found.left_out.push(format!("setup {}: {why}", mounted.name)),
            }
        }
        if found.all.is_empty() {
            let why = if found.left_out.is_empty() { "no readings".into() } else { reasons(&found.left_out) };
            return Err(method.lacks(format!("{what} ({why})"), next));
        }
        Ok(found)
    }

    /// For the notes of the findings.
    pub fn left_out_notes(&self) -> impl Iterator<Item = String> + '_ {
        self.left_out.iter().map(|left| format!("Left out: {left}."))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_of_several_setups_is_said_once() {
        let read = "read by an R-test, not by a tracker";
        let left_out =
            [format!("setup low: {read}"), "setup far: nothing moves".into(), format!("setup high: {read}")];
        assert_eq!(reasons(&left_out), format!("setups low and high: {read}; setup far: nothing moves"));
        assert_eq!(reasons(&left_out[..1]), left_out[0]);
    }
}
