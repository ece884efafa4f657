//! Numbers of a fit that a person should doubt, and why.

use crate::number::{plain, um, value_and_u, with_unit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_core::Day;
use trunnion_core::number::{fixed, signed};
use trunnion_engine::fit::doubts as engine;
use trunnion_engine::plausibility::{ClockDoubt, Differs, How, Remainders, Rounded, Unlike};

/// Numbers of a fit to doubt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Doubt {
    /// Effect id; left out where the readings themselves are doubted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effect: Option<String>,
    /// Names of its parameters or shape numbers.
    pub names: Vec<String>,
    /// What is wrong with them.
    pub reason: DoubtReason,
    /// The same in words.
    pub words: String,
}

/// What is wrong with fitted numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DoubtReason {
    /// Their temperatures changed together: only what they predict together is determined.
    Collinear,
    /// Larger than the cause allows.
    BeyondPhysical,
    /// A time constant longer than the longest run.
    LongerThanRun,
    /// The readings do not separate the terms of an effect, each with a time constant of its own.
    TermsNotSeparated,
    /// The effect depends on time alone, and an axis goes one way while time goes on.
    PlaceAndTime,
    /// One direction is stated at every point of an axis that went both ways.
    OneDirection,
    /// Readings of one pose scatter more than those of a machining centre in order.
    Scatter,
    /// Every row has one time, or the clock was set.
    Clock,
    /// Positions or readings were rounded when they were written, to more than the noise allows.
    Rounded,
    /// Many single readings lie far from their neighbours and were excluded.
    LoneReadings,
    /// The model names another machine than the runs.
    OtherMachine,
    /// The location errors of two runs are as unlike as those of two machines.
    UnlikeRuns,
    /// A run was measured after a calibration of its sensors had ended.
    CalibrationOutOfDate,
}

impl DoubtReason {
    /// Every reason.
    pub const ALL: [Self; 13] = [
        Self::Collinear,
        Self::BeyondPhysical,
        Self::LongerThanRun,
        Self::TermsNotSeparated,
        Self::PlaceAndTime,
        Self::OneDirection,
        Self::Scatter,
        Self::Clock,
        Self::Rounded,
        Self::LoneReadings,
        Self::OtherMachine,
        Self::UnlikeRuns,
        Self::CalibrationOutOfDate,
    ];
}

impl Doubt {
    /// About a run of which `lone` of `all` points were excluded; `most`: where most of them lie.
    pub fn lone_readings(run: &str, [lone, all]: [u64; 2], most: Option<String>) -> Self {
        let most = most.map_or_else(String::new, |place| format!(", most of them in {place}"));
        let words = format!(
            "{lone} of {all} points of run {run} ({:.1} %) lie far from their neighbours and are excluded{most}. Look for chips and coolant \
             at ball and probes, a loose plug, a display with coarse steps; then measure again.",
            100.0 * lone as f64 / all as f64
        );
        Self { effect: None, names: Vec::new(), reason: DoubtReason::LoneReadings, words }
    }
}

impl Doubt {
    /// About a model file of one machine that is fitted to runs of another.
    pub fn other_machine([of_model, of_runs]: [&str; 2]) -> Self {
        let words = format!(
            "the model file is of machine {of_model}, the runs were measured on machine {of_runs}. Its effects are fitted to these runs; values \
             that it fixes or expects are taken as they stand. Name a model file of {of_runs}, or correct the machine in this one."
        );
        Self { effect: None, names: Vec::new(), reason: DoubtReason::OtherMachine, words }
    }
}

impl Doubt {
    /// About a run that was measured on a day after the calibration of these sensors had ended.
    pub fn calibration(run: &str, sensors: &[&str], until: Day, measured: Day) -> Self {
        let words = format!(
            "the calibration of {} was valid until {until}, and run {run} was measured on {measured}. Have it renewed, or \
             correct [[calibration]] where that was done.",
            sensors.join(", ")
        );
        Self { effect: None, names: Vec::new(), reason: DoubtReason::CalibrationOutOfDate, words }
    }

    /// About two runs that are fitted together.
    pub fn unlike_runs(unlike: &Unlike) -> Self {
        let Unlike { runs: [a, b], how, most } = unlike;
        let most = most.as_ref().map_or_else(String::new, |Differs { name, shown: [in_a, in_b] }| {
            format!("; {name} is {in_a} in {a} and {in_b} in {b}")
        });
        let words = match how {
            How::OfTwoMachines { count, differ_um } => format!(
                "the runs {a} and {b} are as unlike as those of two machines: all {count} location errors that both determine differ, by {} µm rms at \
                 the ball{most}. Are both of one machine, in one state? Fit them one by one: what is fitted to both may hold for neither.",
                fixed(*differ_um, 1)
            ),
            How::Changed(Remainders { together_um, apart_um }) => format!(
                "the machine changed between the runs {a} and {b}: with common location errors they leave {} rms, with their own {}{most}. Was \
                 something corrected, repaired or hit, or did the machine warm up? Fit them one by one, and see with `trunnion history` what \
                 changed: causes found in both together may be invented.",
                um(*together_um),
                um(*apart_um)
            ),
        };
        Self { effect: None, names: Vec::new(), reason: DoubtReason::UnlikeRuns, words }
    }

    /// About numbers that were rounded.
    pub fn rounded(rounded: &Rounded) -> Self {
        let words = format!("{} {}", rounded.finding(), rounded.advice());
        Self { effect: None, names: Vec::new(), reason: DoubtReason::Rounded, words }
    }
}

impl Doubt {
    /// About the times of a run.
    pub fn clock(run: &str, doubt: &ClockDoubt) -> Self {
        let words = match doubt {
            ClockDoubt::OneTime(time_s) => format!(
                "every row of run {run} has the time {time_s} s, so that nothing is known of the course in time: effects that depend on time \
                 are out of reach. Give each row its own time, or leave time_s out."
            ),
            ClockDoubt::SetForward { row, by_s, usual_s } => format!(
                "in run {run} the time goes on by {by_s:.0} s from row {} to row {row}, by {usual_s:.1} s otherwise. Where there was no pause, the \
                 clock was set, and every drift is bent there: put the times on one clock.",
                row - 1
            ),
            ClockDoubt::Slow { span_s, usual_s } => format!(
                "by its times run {run} took {:.0} hours, with {usual_s:.0} s from pose to pose: in milliseconds instead of seconds (factor 1000) it \
                 would be {:.0} s. Check the units of time_s.",
                span_s / 3600.0,
                span_s / 1000.0
            ),
        };
        Self { effect: None, names: Vec::new(), reason: DoubtReason::Clock, words }
    }
}

impl From<&engine::Doubt> for Doubt {
    fn from(doubt: &engine::Doubt) -> Self {
        let names = doubt.names.join(", ");
        let (reason, words) = match doubt.reason {
            engine::DoubtReason::Collinear { condition_index } => (
                DoubtReason::Collinear,
                format!(
                    "{names}: these temperatures changed together (condition index {}), so their coefficients are confounded; \
                     only what they predict together counts. Leave sensors out, or warm one spot alone.",
                    plain(condition_index.round())
                ),
            ),
            engine::DoubtReason::BeyondPhysical { limit, unit } => (
                DoubtReason::BeyondPhysical,
                format!(
                    "{names} exceeds {}: {}.",
                    with_unit(limit.largest.round(), unit.symbol),
                    limit.beyond
                ),
            ),
            engine::DoubtReason::LongerThanRun { tau_s, longest_s } => (
                DoubtReason::LongerThanRun,
                format!(
                    "{names} of {} is longer than the longest run ({}): its course was not seen to the end.",
                    with_unit(tau_s.round(), "s"),
                    with_unit(longest_s.round(), "s")
                ),
            ),
            engine::DoubtReason::TermsNotSeparated { value, u, unit } => {
                let (least_certain, shared) =
                    doubt.names.split_first().map_or((names.as_str(), String::new()), |(first, rest)| {
                        (first.as_str(), rest.join(", "))
                    });
                let (value, u) = value_and_u(Some(value), Some(u), unit.symbol);
                let words = format!(
                    "{least_certain} = {value} has u = {u}: these readings do not separate the terms of the effect. How {shared} share what \
                     they make together is not known; only what they make together counts.",
                );
                (DoubtReason::TermsNotSeparated, words)
            }
            engine::DoubtReason::PlaceAndTime { joint } => (
                DoubtReason::PlaceAndTime,
                format!(
                    "{joint} goes one way while time goes on, so an error along {joint} reads the same as this course in time. Measure there \
                     and back, or return to the first pose."
                ),
            ),
            engine::DoubtReason::OneDirection { joint, stated, contrary: [contrary, all] } => (
                DoubtReason::OneDirection,
                format!(
                    "{names} is always {}, although {joint} moved the opposite way in {contrary} of {all} steps. That is right where every \
                     pose was approached from one side; otherwise give the direction as {joint} moved, or 0.",
                    signed(stated, 0)
                ),
            ),
            engine::DoubtReason::Scatter { noise_um } => (
                DoubtReason::Scatter,
                format!(
                    "the readings of one pose scatter by {}, unusually large for probes at rest on a machining centre. Check the units of \
                     the readings (tenths of a µm?), the ball, the nest and the probes.",
                    um(noise_um)
                ),
            ),
        };
        Self { effect: doubt.effect.clone(), names: doubt.names.clone(), reason, words }
    }
}
