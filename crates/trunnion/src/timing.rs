//! How well a recording is known in time: clocks fitted over the whole run, delays from its synchronisation moves, gaps and losses.

use crate::gaps::Gaps;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::Path;
use trunnion_core::number::signed;
use trunnion_core::{AxisSample, AxisValues, Gap, Joint, NestSide, ProbeSample};
use trunnion_cycles::RunKind;
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::{Experiment, IdentifyError};
use trunnion_record::{Item, RecordError, RunHeader, visit_samples};
use trunnion_sync::plan::Plan;
use trunnion_sync::time_quality::{StreamTiming, SyncMove, TimeQuality};
use trunnion_sync::{Retiming, RetimingFit, Stream, SyncMoveFinder, mean_delays};

/// Delays at the start and at the end differ when they do by so many standard uncertainties.
const DIFFERS: f64 = 5.0;
/// Share of the stroke by which a probe may miss what the nest calibration expects of it.
const GAIN_SLACK: f64 = 0.25;

/// What the stamps of a recording show.
pub struct Timing {
    quality: TimeQuality,
    retiming: Retiming,
    /// Delay of each channel against the axes, s.
    delays_s: BTreeMap<u16, f64>,
    usual_delay_s: f64,
}

impl Timing {
    /// The sample at the time it was taken, by the lines of the whole run and the delay of its channel.
    pub fn probe(&self, mut sample: ProbeSample) -> ProbeSample {
        if let Some(time_s) = self.retiming.time_s(Stream::Probe(sample.channel), &sample.stamp) {
            let delay_s = self.delays_s.get(&sample.channel).copied().unwrap_or(self.usual_delay_s);
            sample.time_s = time_s - delay_s;
        }
        sample
    }

    /// For the report, with the gaps of the recording that count.
    pub(crate) fn quality(self, gaps: &[Gap]) -> TimeQuality {
        let mut quality = self.quality;
        share_out(gaps, &mut quality.streams);
        quality
    }

    /// The positions at the time the controller took them.
    pub fn axes(&self, sample: AxisSample) -> AxisSample {
        retimed(sample, &self.retiming)
    }
}

fn retimed(mut sample: AxisSample, retiming: &Retiming) -> AxisSample {
    if let Some(time_s) = retiming.time_s(Stream::Axes, &sample.stamp) {
        sample.time_s = time_s;
    }
    sample
}

/// Reads the stamps of a recording, `None` when it holds none (an import, a simulation, a recording of an older version), and its gaps.
/// `plan` gives what the probes should have seen of a synchronisation move.
///
/// # Errors
/// A file that cannot be read.
pub fn read(path: &Path, plan: Option<&Plan>) -> Result<(Option<Timing>, Gaps), RecordError> {
    let mut fit = RetimingFit::default();
    let (mut gaps, mut stamped) = (Gaps::default(), false);
    let (header, _) = visit_samples(path, &mut |item| {
        match item {
            Item::Probe(sample) => {
                stamped |= !sample.stamp.arrival_s.is_nan();
                fit.probe(&sample);
            }
            Item::Axes(sample) => {
                stamped |= !sample.stamp.arrival_s.is_nan();
                fit.axes(&sample);
            }
            Item::Gap(gap) => gaps.take(gap),
            _ => {}
        }
        true
    })?;
    if !stamped {
        return Ok((None, gaps));
    }
    let (retiming, mut streams) = fit.finish();
    let (sync_moves, at_sync_move) = sync_moves(path, &retiming)?;
    let mut notes = Vec::new();
    let delays = mean_delays(&sync_moves);
    for (stream, timing) in &mut streams {
        timing.name = name(*stream, &header);
        timing.delay_s = match stream {
            Stream::Probe(channel) => delays.get(channel).map(|delay| (delay.delay_s, delay.u_s)),
            Stream::Axes => None,
        };
    }
    for channel in delays.iter().filter(|(_, delay)| delay.birge_ratio > DIFFERS).map(|(channel, _)| *channel)
    {
        notes.push(format!(
            "{}: the delay against the axes is not the same in all synchronisation moves; its uncertainty says by how much.",
            name(Stream::Probe(channel), &header)
        ));
    }
    if header.kind == RunKind::OnTheFly && delays.is_empty() {
        notes.push(
            "No synchronisation move was seen: what readings come later than the axes by is not taken out. Let `trunnion nc-program` write \
             the program; it begins and ends with one."
                .into(),
        );
    }
    if let (Some(plan), Some(sync_move)) = (plan, sync_moves.last()) {
        notes.extend(unexpected_gains(plan, sync_move, &at_sync_move, &header));
    }
    let known: Vec<f64> = delays.values().map(|delay| delay.delay_s).collect();
    let usual_delay_s = known.iter().sum::<f64>() / (known.len() as f64).max(1.0);
    let quality =
        TimeQuality { run: header.name.clone(), streams: streams.into_values().collect(), sync_moves, notes };
    let delays_s = delays.into_iter().map(|(channel, delay)| (channel, delay.delay_s)).collect();
    Ok((Some(Timing { quality, retiming, delays_s, usual_delay_s }), gaps))
}

/// The synchronisation moves, and where the axes were at the last. Times are those of the lines of the whole run, because what is
/// formed with the delays has them: stamps that jitter push such a line to the latest of them, 2 ms at 0.6 ms (rms), and a delay against
/// the times of the live run would leave that in.
fn sync_moves(path: &Path, retiming: &Retiming) -> Result<(Vec<SyncMove>, AxisValues<f64>), RecordError> {
    let (mut found, mut at) = (Vec::new(), AxisValues::default());
    let mut finder = SyncMoveFinder::default();
    visit_samples(path, &mut |item| {
        match item {
            Item::Probe(mut sample) => {
                let stream = Stream::Probe(sample.channel);
                sample.time_s = retiming.time_s(stream, &sample.stamp).unwrap_or(sample.time_s);
                finder.probe(&sample);
            }
            Item::Axes(sample) => {
                let sample = retimed(sample, retiming);
                if let Some(sync_move) = finder.axes(&sample) {
                    at = sample.position;
                    found.push(sync_move);
                }
            }
            _ => {}
        }
        true
    })?;
    Ok((found, at))
}

/// Name of the stream of the axes.
const CONTROLLER: &str = "controller";

fn name(stream: Stream, header: &RunHeader) -> String {
    match stream {
        Stream::Axes => CONTROLLER.into(),
        Stream::Probe(channel) => {
            header.probes.get(usize::from(channel)).cloned().unwrap_or_else(|| format!("channel {channel}"))
        }
    }
}

/// Gaps to the streams they are gaps of; those of no probe are the controller's.
fn share_out(gaps: &[Gap], streams: &mut [StreamTiming]) {
    for gap in gaps {
        let is_of = |timing: &StreamTiming| {
            timing.name == gap.source
                || timing.name.strip_prefix(&gap.source).is_some_and(|rest| rest.starts_with('.'))
        };
        let is_owned = streams.iter().any(&is_of);
        let owners = streams.iter_mut().filter(|timing| match is_owned {
            true => is_of(timing),
            false => timing.name == CONTROLLER,
        });
        for owner in owners {
            owner.gaps.0 += 1;
            owner.gaps.1 += (gap.to_s - gap.from_s).max(0.0);
            owner.lost += gap.lost_samples.unwrap_or(0);
        }
    }
}

/// Probes whose reading moved otherwise than the nest calibration and the machine file say: reversed, or in each other's place.
fn unexpected_gains(
    plan: &Plan,
    sync_move: &SyncMove,
    position: &AxisValues<f64>,
    header: &RunHeader,
) -> Vec<String> {
    let Ok(channels) = trunnion_sync::plan::check(plan) else { return Vec::new() };
    let Some(probes_from_nest) =
        plan.calibration().nest_from_probes.try_inverse().filter(|_| channels.len() == 3)
    else {
        return Vec::new();
    };
    let expected = probes_from_nest * nest_motion(plan, sync_move.axis, position);
    let unexpected = |(k, channel): (usize, &u16)| {
        let seen = sync_move.seen.iter().find(|seen| seen.channel == *channel)?;
        ((seen.gain - expected[k]).abs() > GAIN_SLACK).then(|| {
            format!(
                "{}: moved by {} of the stroke of {} where machine file and nest calibration expect {}; look for a probe \
                 that is reversed or in another's place, and check [nest] in the configuration.",
                name(Stream::Probe(*channel), header),
                signed(seen.gain, 2),
                sync_move.axis,
                signed(expected[k], 2)
            )
        })
    };
    channels.iter().enumerate().filter_map(unexpected).collect()
}

/// Change of the reading in nest axes by a motion of one axis, mm/mm.
fn nest_motion(plan: &Plan, axis: Joint, position: &AxisValues<f64>) -> Vector3<f64> {
    let mut moved = *position;
    moved[axis] += 1.0;
    let none = trunnion_machine::JointErrors::default();
    let in_table = plan.machine.tool_in_table(&moved).0 - plan.machine.tool_in_table(position).0;
    match plan.cycle.setups[0].nest {
        NestSide::Table => in_table,
        NestSide::Spindle => {
            let tool_from_table = plan.machine.machine_from_tool(position, &none).inverse()
                * plan.machine.machine_from_table(position, &none);
            tool_from_table.rotation * -in_table
        }
    }
}

/// What the sweeps of an experiment show of the delay between rotary and linear axes, and of the probes where their motion shows
/// it; `None` at rest. With one feed, or in one direction, a delay looks like backlash or the phase of a once-per-turn error:
/// then it is only said what is missing [docs/design/physics.md §9.8].
///
/// # Errors
/// When the fit fails.
pub fn delay_by_feeds(experiment: &Experiment) -> Result<Option<String>, IdentifyError> {
    let scene = &experiment.scene;
    let turning: Vec<Joint> =
        scene.machine.rotary_joints().into_iter().filter(|&letter| scene.read_in_motion(letter)).collect();
    if !scene.on_the_fly || turning.is_empty() {
        return Ok(None);
    }
    let both_ways = turning.iter().all(|&letter| scene.both_directions(letter));
    let two_feeds = turning.iter().all(|&letter| scene.two_feeds(letter));
    if !(both_ways && two_feeds) {
        let missing = if both_ways { "a second feed" } else { "the other direction of travel" };
        return Ok(Some(format!(
            "The delay between the axes cannot be distinguished from backlash and the phase of a once-per-turn error without {missing}."
        )));
    }
    let mut model = Model::base(&scene.machine.name);
    let joined =
        turning.iter().flat_map(|axis| [format!("backlash:{axis}"), format!("encoder-eccentricity:{axis}")]);
    for id in std::iter::once("sync-delay".to_owned()).chain(joined) {
        model.effects.push(ModelEffect { id, ..ModelEffect::default() });
    }
    let fit = trunnion_engine::identify(experiment, &model, &trunnion_engine::fit::Options::default())?;
    let reported: Vec<String> = fit
        .parameters
        .iter()
        .filter(|parameter| parameter.effect == "sync-delay")
        .filter_map(|parameter| {
            let (value, u) = (parameter.value?, parameter.u?);
            let what = if parameter.name.contains("rotary") {
                "the rotary axes come later than the linear axes"
            } else {
                "the readings come later than the axes"
            };
            let seconds = |inside: f64| inside * parameter.unit.per_inside * 1e-3;
            Some(format!("{what} by {}", trunnion_report::duration_and_u(seconds(value), seconds(u))))
        })
        .collect();
    Ok((!reported.is_empty()).then(|| {
        format!(
            "From both directions at two feeds, distinguished from backlash and once-per-turn error: {}.",
            reported.join("; ")
        )
    }))
}
