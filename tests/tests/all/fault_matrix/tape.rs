//! The recording of a cell: a real file, written as the service writes it and read back.

use super::bench::SinceStart;
use std::path::Path;
use std::sync::Arc;
use trunnion_core::{Clock, Event, Gap};
use trunnion_cycles::RunKind;
use trunnion_record::{Item, Recorder, RecorderHandle, RunHeader, Temperature};
use trunnion_sync::Timed;

/// Items that wait for the disk.
const QUEUE: usize = 4096;

/// A recording under way.
pub struct Tape {
    recorder: RecorderHandle,
    clock: Arc<SinceStart>,
}

impl Tape {
    /// Run time 0 is host time 0.
    pub fn start(directory: &Path, clock: Arc<SinceStart>) -> Result<Self, String> {
        let header = RunHeader::new("faults", RunKind::OnTheFly, "none");
        let recorder = Recorder::create(directory, "faults", &header).map_err(|error| error.to_string())?;
        let recorder =
            RecorderHandle::spawn(recorder, QUEUE, clock.clone()).map_err(|error| error.to_string())?;
        Ok(Self { recorder, clock })
    }

    pub fn record(&self, timed: &Timed) {
        let item = match timed.clone() {
            Timed::Probe(sample) => Item::Probe(sample),
            Timed::Axes(sample) => Item::Axes(sample),
            Timed::Gap(gap) => Item::Gap(gap),
            Timed::Event(event) => Item::Event(event),
            Timed::Temperature { degc, time_s, .. } => {
                Item::Temperature(Temperature { time_s, channel: 0, value_degc: degc })
            }
        };
        // What the recorder cannot take it counts, and the end says so.
        self.recorder.try_send(item, self.clock.now());
    }

    /// Ends the recording; gaps and events of the file.
    pub fn read_back(self) -> Result<(Vec<Gap>, Vec<Event>), String> {
        let finished = self.recorder.finish().map_err(|error| error.to_string())?;
        if finished.lost_samples > 0 {
            return Err(format!("the recorder lost {} samples", finished.lost_samples));
        }
        let (mut gaps, mut events) = (Vec::new(), Vec::new());
        for file in &finished.files {
            let visited = trunnion_record::visit(&file.path, &mut |item| {
                match item {
                    Item::Gap(gap) => gaps.push(gap),
                    Item::Event(event) => events.push(event),
                    _ => {}
                }
                true
            });
            if let (_, Some(damage)) = visited.map_err(|error| error.to_string())? {
                return Err(format!("the recording is damaged: {damage:?}"));
            }
        }
        Ok((gaps, events))
    }
}
