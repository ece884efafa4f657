//! A recording as the live run went through it, moment by moment. Whoever shows it decides how fast.

use crate::recorded::plan_of;
use crate::{Error, Form};
use std::path::Path;
use trunnion_core::{Event, Gap, Point};
use trunnion_record::Item;
use trunnion_sync::forming::Forming;
use trunnion_sync::{CycleEvent, EndReason, Progress};

/// One moment of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// When, s since the run began.
    pub time_s: f64,
    /// How far the cycle was.
    pub progress: Progress,
    /// What happened.
    pub what: Happened,
}

/// What happened in a moment.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time, passed on at once")]
pub enum Happened {
    /// Samples came, and nothing followed from them yet.
    Samples,
    /// A point was decided.
    Point(Point),
    /// What the recording says.
    Event(Event),
    /// Samples are missing.
    Gap(Gap),
}

/// Hands over a recording in order of time until `on_moment` says false; its points are formed from the samples, by the changes of
/// `form`, as while it was measured.
///
/// # Errors
/// A file that cannot be read, or that holds no cycle or no samples; an option that the cycle does not take.
pub fn replay(path: &Path, form: &Form, on_moment: &mut dyn FnMut(Moment) -> bool) -> Result<(), Error> {
    let not_read = Error::recording(path);
    let no_samples = || Error::NoSamples { path: path.into() };
    let header = form.changed(trunnion_record::read_header(path).map_err(not_read)?)?;
    let plan = plan_of(&header).ok_or_else(no_samples)?;
    let channels = header.temperature_channels.len();
    let mut forming = Forming::new(&plan, channels).map_err(|_| no_samples())?;
    // What was held then is not known: standing still is not the end.
    forming.set_held(true);
    let (mut formed, mut sampled, mut wanted) = (Vec::new(), false, true);
    let mut pass_on = |formed: &mut Vec<CycleEvent>, now: Moment| {
        let points = formed.drain(..).filter_map(|event| match event {
            CycleEvent::Point { point, .. } => Some(Happened::Point(point)),
            CycleEvent::UnknownDwell { .. } | CycleEvent::Samples { .. } | CycleEvent::Ended { .. } => None,
        });
        let moments: Vec<Happened> = std::iter::once(now.what).chain(points).collect();
        moments.into_iter().all(|what| on_moment(Moment { what, ..now }))
    };
    let now = |forming: &Forming, time_s, what| Moment { time_s, progress: forming.progress(), what };
    trunnion_record::visit(path, &mut |item| {
        let (time_s, what) = match item {
            Item::Probe(sample) => {
                forming.probe(&sample, &mut formed);
                (sample.time_s, Happened::Samples)
            }
            Item::Axes(sample) => {
                forming.axes(&sample, &mut formed);
                (sample.time_s, Happened::Samples)
            }
            Item::Temperature(reading) => {
                forming.temperature(reading.channel.into(), reading.value_degc);
                return true;
            }
            Item::Event(event) => (event.time_s, Happened::Event(event)),
            Item::Gap(gap) => (gap.from_s, Happened::Gap(gap)),
            Item::Point(_) => return true,
        };
        sampled |= what == Happened::Samples;
        wanted = pass_on(&mut formed, now(&forming, time_s, what));
        wanted
    })
    .map_err(not_read)?;
    if !sampled {
        return Err(no_samples());
    }
    if wanted {
        forming.finish(EndReason::Stopped, &mut formed);
        pass_on(&mut formed, now(&forming, forming.newest_s(), Happened::Samples));
    }
    Ok(())
}
