//! One part: what must be known of it before it is joined, and its items in the time of the first.

use crate::Error;
use crate::recorded::plan_of;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trunnion_core::{Quality, Stamp};
use trunnion_record::{Item, RunHeader};

/// Source of the axes' gaps.
const CONTROLLER: &str = "controller";

/// A part, looked through once.
pub(super) struct Part {
    pub(super) path: PathBuf,
    pub(super) header: RunHeader,
    /// Good points.
    pub(super) good: usize,
    /// First and last sample of every channel and of the axes, s in the time of the part.
    pub(super) first_s: BTreeMap<String, f64>,
    pub(super) last_s: BTreeMap<String, f64>,
    last_epoch: u32,
}

impl Part {
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let failed = Error::recording(path);
        let header = trunnion_record::read_header(path).map_err(failed)?;
        let mut part = Self {
            path: path.into(),
            header,
            good: 0,
            first_s: BTreeMap::new(),
            last_s: BTreeMap::new(),
            last_epoch: 0,
        };
        trunnion_record::visit(path, &mut |item| {
            match item {
                Item::Probe(sample) => {
                    let name = part.header.probes.get(usize::from(sample.channel)).cloned();
                    part.saw(name.unwrap_or_default(), sample.time_s, sample.stamp.epoch);
                }
                Item::Axes(sample) => part.saw(CONTROLLER.into(), sample.time_s, sample.stamp.epoch),
                Item::Point(point) => part.good += usize::from(point.quality == Quality::Good),
                Item::Temperature(_) | Item::Event(_) | Item::Gap(_) => {}
            }
            true
        })
        .map_err(failed)?;
        match part.first_s.is_empty() {
            true => Err(Error::NotJoined { path: path.into(), why: "it holds no samples".into() }),
            false => Ok(part),
        }
    }

    fn saw(&mut self, source: String, time_s: f64, epoch: u32) {
        let first_s = self.first_s.entry(source.clone()).or_insert(time_s);
        *first_s = first_s.min(time_s);
        let last_s = self.last_s.entry(source).or_insert(time_s);
        *last_s = last_s.max(time_s);
        self.last_epoch = self.last_epoch.max(epoch);
    }

    pub(super) fn name(&self) -> String {
        self.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    pub(super) fn begins_s(&self) -> f64 {
        self.first_s.values().copied().fold(f64::INFINITY, f64::min)
    }

    pub(super) fn ends_s(&self) -> f64 {
        self.last_s.values().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// What is added to its times to get those of the first part, s.
    pub(super) fn shift_s(&self, first: &Self) -> f64 {
        (self.header.wall_start_ns - first.header.wall_start_ns) as f64 * 1e-9
    }

    /// Connections in it, at most: epochs count from zero.
    pub(super) fn epochs(&self) -> u32 {
        self.last_epoch + 1
    }

    /// Where its temperature channels are among those of all parts.
    pub(super) fn temperature_channels(&self, all: &RunHeader) -> Vec<Option<u16>> {
        let of = |name: &String| {
            let index = all.temperature_channels.iter().position(|known| known == name)?;
            u16::try_from(index).ok()
        };
        self.header.temperature_channels.iter().map(of).collect()
    }

    /// Whether it can be the next part of the cycle of `first`, after `before`; why it cannot.
    pub(super) fn follows(&self, before: &Self, first: &Self) -> Result<(), String> {
        let (mine, other) = (&self.header, &first.header);
        let nest = |header: &RunHeader| plan_of(header).map(|plan| plan.nest);
        let same = [
            (
                "machine file",
                mine.machine_text == other.machine_text && mine.machine_name == other.machine_name,
            ),
            ("cycle file", mine.cycle_text == other.cycle_text),
            ("channels", mine.probes == other.probes && mine.probe_roles == other.probe_roles),
            ("[nest]", nest(mine) == nest(other)),
        ];
        if let Some((what, _)) = same.iter().find(|(_, same)| !same) {
            return Err(format!("its {what} is not that of {}", first.name()));
        }
        let (ended_s, begins_s) =
            (before.ends_s() + before.shift_s(first), self.begins_s() + self.shift_s(first));
        if begins_s < ended_s {
            return Err(format!(
                "it begins {:.1} s before {} ends; give the parts in order of time, and look whether the clock of the computer was set",
                ended_s - begins_s,
                before.name()
            ));
        }
        Ok(())
    }
}

/// An item in the time of the first part; `None` for a temperature of no channel.
pub(super) fn shifted(item: Item, by_s: f64, epochs: u32, channels: &[Option<u16>]) -> Option<Item> {
    let stamp =
        |stamp: Stamp| Stamp { epoch: stamp.epoch + epochs, arrival_s: stamp.arrival_s + by_s, ..stamp };
    Some(match item {
        Item::Probe(mut sample) => {
            (sample.time_s, sample.stamp) = (sample.time_s + by_s, stamp(sample.stamp));
            Item::Probe(sample)
        }
        Item::Axes(mut sample) => {
            (sample.time_s, sample.stamp) = (sample.time_s + by_s, stamp(sample.stamp));
            Item::Axes(sample)
        }
        Item::Temperature(mut reading) => {
            reading.channel = (*channels.get(usize::from(reading.channel))?)?;
            reading.time_s += by_s;
            Item::Temperature(reading)
        }
        Item::Event(mut event) => {
            event.time_s += by_s;
            Item::Event(event)
        }
        Item::Gap(mut gap) => {
            (gap.from_s, gap.to_s) = (gap.from_s + by_s, gap.to_s + by_s);
            Item::Gap(gap)
        }
        Item::Point(point) => Item::Point(point),
    })
}
