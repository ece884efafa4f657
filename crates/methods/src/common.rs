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

/// A part of the runs that a method does not take, and why.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LeftOut {
    /// `setup`, or `run`.
    noun: &'static str,
    name: String,
    why: String,
}

impl LeftOut {
    /// `why`: a part of a sentence, `read by an R-test`.
    pub fn setup(name: String, why: impl Into<String>) -> Self {
        Self { noun: "setup", name, why: why.into() }
    }

    /// A whole run.
    pub fn run(name: String, why: impl Into<String>) -> Self {
        Self { noun: "run", name, why: why.into() }
    }
}

/// Why parts of the runs were left out, in one list: a reason of several is said once.
pub(crate) fn reasons(left_out: &[LeftOut]) -> String {
    let mut once: Vec<(&LeftOut, Vec<&str>)> = Vec::new();
    for left in left_out {
        match once.iter_mut().find(|(other, _)| (other.noun, &other.why) == (left.noun, &left.why)) {
            Some((_, names)) => names.push(&left.name),
            None => once.push((left, vec![&left.name])),
        }
    }
    let said = |(LeftOut { noun, name, why }, names): &(&LeftOut, Vec<&str>)| match names.split_last() {
        Some((last, others)) if !others.is_empty() => {
            format!("{noun}s {} and {last}: {why}", others.join(", "))
        }
        _ => format!("{noun} {name}: {why}"),
    };
    match once.is_empty() {
        true => "no readings".into(),
        false => once.iter().map(said).collect::<Vec<_>>().join("; "),
    }
}

/// The same for the notes of findings, one sentence each.
pub(crate) fn left_out_notes(left_out: &[LeftOut]) -> impl Iterator<Item = String> + '_ {
    left_out.iter().map(|LeftOut { noun, name, why }| format!("Left out: {noun} {name}: {why}."))
}

/// What a method recognised, setup by setup.
pub(crate) struct Recognised<T> {
    pub all: Vec<T>,
    pub left_out: Vec<LeftOut>,
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
                Err(why) => found.left_out.push(LeftOut::setup(mounted.name, why)),
            }
        }
        if found.all.is_empty() {
            return Err(method.lacks(format!("{what} ({})", reasons(&found.left_out)), next));
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_of_several_setups_is_said_once() {
        let read = "read by an R-test, not by a tracker";
        let mut left_out = [("low", read), ("far", "nothing moves"), ("high", read)]
            .map(|(setup, why)| LeftOut::setup(setup.into(), why))
            .to_vec();
        assert_eq!(reasons(&left_out), format!("setups low and high: {read}; setup far: nothing moves"));
        left_out.insert(1, LeftOut::run("low".into(), read));
        assert_eq!(
            reasons(&left_out[..3]),
            format!("setup low: {read}; run low: {read}; setup far: nothing moves")
        );
        assert_eq!(reasons(&left_out[..1]), format!("setup low: {read}"));
        assert_eq!(reasons(&[]), "no readings");
    }
}
