//! Samples taken on the fly, reduced to blocks as they are read: a few thousand points instead of millions.
//!
//! A block is a short stretch of path of one pass: consecutive samples of one setup with the same directions of all axes and
//! about the same speed. It keeps
//! - the state at the mean time, and the mean of (reading − nominal reading at each sample's own positions), with the
//!   nominal reading of that state added back, so that averaging loses nothing of the kinematics;
//! - the scatter about its own straight line and what the mean is worth: `spread/√samples` of a block is its standard error with the
//!   correlation of the samples counted in (see [`spectrum`]).
//!
//! Width: as fine as [`Limits::most_blocks`] allows. Blocks begin at ⅛ of a unit of travel (1°, 2 mm, 10 s); whenever there are twice as many
//! as allowed the width doubles and neighbours are merged, which the sums of a block allow exactly. After a reversal
//! of any axis a block ends before the travel since then has doubled. Memory follows the number of blocks, not of samples.
//!
//! Averaging over a width w damps a harmonic n by sinc(n w/2) ≈ 1 − (n w)²/24; `centred` takes that back from the
//! neighbours up to (n w)⁴/640 (60 lobes at 2°: 0.83 becomes 0.93; 30 lobes: 0.995).
//! Nothing is lost without a count: samples excluded, samples without a reading, and the rms of what averaging removes, octave by octave, are
//! in [`Reduction::passes`].
//! Limits: samples of one setup come in order of time; slow against the block width is what a block is; single outliers
//! of one or two samples are excluded, longer ones are kept as structure.

mod cell;
mod outliers;
mod pass;
mod sample;
pub mod spectrum;

use sample::Sample;
pub(crate) use sample::{FINEST, UNIT};

use cell::Cell;
use outliers::Outliers;
use pass::{PassKey, PassSums};
use std::collections::HashMap;
use trunnion_core::convert::um_from_mm;
use trunnion_core::{AxisValues, Point, Slot, State};

pub use pass::{Band, PassSummary};

/// From this width on directions that flicker may be averaged, if nothing else helps, units.
const LAST_RESORT: f64 = 256.0;

/// How finely to reduce.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Blocks of one run.
    pub most_blocks: usize,
    /// Points of one run at rest; beyond they become means of neighbours ([`crate::stations`]).
    pub most_stations: usize,
    /// Samples further apart than this do not belong together, s.
    pub pause_s: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { most_blocks: 2000, most_stations: 10_000, pause_s: 0.25 }
    }
}

/// What samples were reduced to.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// The blocks, in the order they were taken.
    pub points: Vec<Point>,
    /// What each pass held.
    pub passes: Vec<PassSummary>,
    /// Samples read, those left out included.
    pub samples: u64,
    /// Samples without a usable reading.
    pub missing: u64,
    /// Single samples far from their neighbours, excluded.
    pub excluded: u64,
    /// Points read, each of one sample or more.
    pub points_read: u64,
    /// Those of them that were excluded.
    pub points_excluded: u64,
    /// Largest width of a block, in units of 1° or 2 mm of travel.
    pub width_units: f64,
}

/// Reduces samples one by one. `nominal_mm` is the reading of a machine without errors at a state, mm.
pub struct Reducer<F> {
    limits: Limits,
    nominal_mm: F,
    width: f64,
    cells: Vec<Cell>,
    streams: HashMap<usize, Stream>,
    passes: Vec<PassSums>,
    pass_of_key: HashMap<PassKey, usize>,
    top_speed: AxisValues<f64>,
    samples: u64,
    missing: u64,
    excluded: u64,
    points_read: u64,
    points_excluded: u64,
}

/// What is under way in one setup.
#[derive(Default)]
struct Stream {
    outliers: Outliers,
    open: Option<Cell>,
    /// Last sample taken, to see whether the next one goes on from it.
    last: Option<Last>,
}

struct Last {
    time_s: Option<f64>,
    position: AxisValues<f64>,
    pass: usize,
    feed: f64,
}

impl<F: Fn(&State) -> [f64; 3]> Reducer<F> {
    /// An empty reducer.
    pub fn new(limits: Limits, nominal_mm: F) -> Self {
        Self {
            limits,
            nominal_mm,
            width: FINEST,
            cells: Vec::new(),
            streams: HashMap::new(),
            passes: Vec::new(),
            pass_of_key: HashMap::new(),
            top_speed: AxisValues::default(),
            samples: 0,
            missing: 0,
            excluded: 0,
            points_read: 0,
            points_excluded: 0,
        }
    }

    /// Takes one sample; `index` is its place in the order of the run.
    pub fn push(&mut self, index: u64, point: Point) {
        let count = u64::from(point.samples.max(1));
        self.samples += count;
        self.points_read += 1;
        if !point.is_good() || point.reading_mm.iter().any(|mm| !mm.is_finite()) {
            self.missing += count;
            return;
        }
        let nominal_mm = (self.nominal_mm)(&point.state);
        let departure_mm = std::array::from_fn(|k| point.reading_mm[k] - nominal_mm[k]);
        let setup = point.state.setup;
        let stream = self.streams.entry(setup).or_default();
        let ready = stream.outliers.push(Sample { index, point, departure_mm }, self.limits.pause_s);
        self.take(setup, ready);
    }

    fn take(&mut self, setup: usize, judged: Option<outliers::Judged>) {
        match judged {
            None => {}
            Some(outliers::Judged { sample, outlier: true }) => {
                self.excluded += u64::from(sample.point.samples.max(1));
                self.points_excluded += 1;
                let pass =
                    self.streams.get(&setup).and_then(|stream| stream.last.as_ref()).map(|last| last.pass);
                if let Some(pass) = pass {
                    self.passes[pass].excluded += u64::from(sample.point.samples.max(1));
                }
            }
            Some(outliers::Judged { sample, outlier: false }) => self.add(setup, &sample),
        }
    }

    fn add(&mut self, setup: usize, sample: &Sample) {
        let state = &sample.point.state;
        for (letter, v) in state.velocity.iter() {
            self.top_speed[letter] = self.top_speed[letter].max(v.abs());
        }
        let stream = self.streams.entry(setup).or_default();
        let goes_on = stream.last.as_ref().is_some_and(|last| goes_on(last, state, self.limits.pause_s));
        let (key, feed) = pass::key(state, stream.last.as_ref().filter(|_| goes_on).map(|last| last.feed));
        let passes = &mut self.passes;
        let pass = *self.pass_of_key.entry(key).or_insert_with(|| {
            passes.push(PassSums::new(setup, state));
            passes.len() - 1
        });
        let same_pass = goes_on && stream.last.as_ref().is_some_and(|last| last.pass == pass);
        stream.last = Some(Last { time_s: state.time_s, position: state.position, pass, feed });

        let mut one = Cell::of(sample, pass, same_pass);
        let turns = stream.open.as_ref().is_some_and(|open| !open.same_way(&one));
        if !same_pass || turns {
            self.passes[pass].interrupt();
        }
        self.passes[pass].add(sample);
        let joins = |cell: &Cell| same_pass && cell.may_join(&one, self.width, &self.top_speed, false);
        if let Some(open) = stream.open.as_mut().filter(|open| joins(open)) {
            open.merge(&one);
            return;
        }
        one.continues &= stream.open.is_some();
        if let Some(full) = stream.open.replace(one) {
            self.cells.push(full);
        }
        if self.cells.len() >= 2 * self.limits.most_blocks.max(1) {
            self.coarsen(2 * self.limits.most_blocks - 1);
        }
    }

    /// Merges neighbours until at most `most` are left.
    fn coarsen(&mut self, most: usize) {
        self.cells.sort_by_key(|cell| (cell.setup, cell.first));
        while self.cells.len() > most.max(1) {
            let before = self.cells.len();
            self.width *= 2.0;
            let mut merged: Vec<Cell> = Vec::with_capacity(before);
            for cell in self.cells.drain(..) {
                let last_resort = self.width >= LAST_RESORT;
                match merged.last_mut() {
                    Some(last)
                        if cell.continues
                            && last.may_join(&cell, self.width, &self.top_speed, last_resort) =>
                    {
                        last.merge(&cell);
                    }
                    _ => merged.push(cell),
                }
            }
            self.cells = merged;
            if self.width > 1e6 * LAST_RESORT {
                // Every stretch is one block already.
                break;
            }
        }
    }

    /// The blocks and what was in them.
    pub fn finish(mut self) -> Reduction {
        let setups: Vec<usize> = self.streams.keys().copied().collect();
        for setup in setups {
            while let Some(judged) = self.streams.get_mut(&setup).and_then(|stream| stream.outliers.drain()) {
                self.take(setup, Some(judged));
            }
            self.cells.extend(self.streams.get_mut(&setup).and_then(|stream| stream.open.take()));
        }
        self.coarsen(self.limits.most_blocks);
        self.cells.sort_by_key(|cell| (cell.setup, cell.first));
        let corrected = centred(&self.cells);
        for cell in &self.cells {
            self.passes[cell.pass].add_block(cell.scatter_mm(), cell.degrees_of_freedom());
        }
        let noises = pass::noises(&self.passes);
        let mut points: Vec<(u64, Point)> = Vec::with_capacity(self.cells.len());
        for (cell, departure_mm) in self.cells.iter().zip(corrected) {
            let state = cell.state();
            let nominal_mm = (self.nominal_mm)(&state);
            let u_mm = cell.standard_error_mm(&noises[cell.pass]);
            points.push((
                cell.first,
                cell.point(state, std::array::from_fn(|k| departure_mm[k] + nominal_mm[k]), u_mm),
            ));
        }
        points.sort_by_key(|(first, _)| *first);
        let widest = self.cells.iter().map(Cell::width).fold(0.0, f64::max);
        Reduction {
            points: points.into_iter().map(|(_, point)| point).collect(),
            passes: self.passes.iter().map(PassSums::summary).collect(),
            samples: self.samples,
            missing: self.missing,
            excluded: self.excluded,
            points_read: self.points_read,
            points_excluded: self.points_excluded,
            width_units: widest,
        }
    }
}

impl Reduction {
    /// One line for a person: how many samples became how many blocks, what was left out, and how much of the readings was
    /// faster than the blocks.
    pub fn summary(&self) -> String {
        let mut text = format!(
            "{} samples on the fly became {} blocks",
            self.samples,
            self.passes.iter().map(|pass| pass.blocks).sum::<usize>()
        );
        for (count, what) in
            [(self.excluded, "single outliers excluded"), (self.missing, "without a reading")]
        {
            if count > 0 {
                text += &format!(", {count} {what}");
            }
        }
        let loudest = self
            .passes
            .iter()
            .flat_map(|pass| pass.bands.iter())
            .max_by(|a, b| a.largest().total_cmp(&b.largest()));
        let all =
            self.passes.iter().map(|pass| pass.faster_mm().iter().fold(0.0_f64, |most, rms| most.max(*rms)));
        text += &format!("; averaged away up to {:.2} µm rms", um_from_mm(all.fold(0.0, f64::max)));
        if let Some((low, high)) = loudest.and_then(|band| band.hertz) {
            text += &format!(", most of it between {low:.0} and {high:.0} Hz");
        }
        text
    }
}

fn goes_on(last: &Last, state: &State, pause_s: f64) -> bool {
    let in_time = match (last.time_s, state.time_s) {
        (Some(before), Some(now)) => (0.0..=pause_s).contains(&(now - before)),
        _ => true,
    };
    let travelled = |letter: Slot| (state.position[letter] - last.position[letter]).abs() / UNIT[letter];
    in_time && state.position.iter().all(|(letter, _)| travelled(letter) <= 8.0)
}

/// Mean departures as values at the mean time: `f(t̄) = f̄ − f″·var(t)/2`. f″ from the block and both neighbours; the
/// first and the last block of a stretch without reversal borrow it from their neighbour.
fn centred(cells: &[Cell]) -> Vec<[f64; 3]> {
    let joined =
        |i: usize| i > 0 && i < cells.len() && cells[i].continues && cells[i - 1].same_way(&cells[i]);
    let second: Vec<Option<[f64; 3]>> = (0..cells.len())
        .map(|i| {
            (joined(i) && joined(i + 1)).then(|| curvature(&cells[i - 1], &cells[i], &cells[i + 1])).flatten()
        })
        .collect();
    let value = |i: usize| {
        let borrowed = || match (joined(i), joined(i + 1)) {
            (true, false) => second[i - 1],
            (false, true) => second[i + 1],
            _ => None,
        };
        let second = second[i].or_else(borrowed).unwrap_or([0.0; 3]);
        let f = cells[i].departure_mm();
        std::array::from_fn(|k| f[k] - 0.5 * second[k] * cells[i].time_variance())
    };
    (0..cells.len()).map(value).collect()
}

/// Second derivative over time by divided differences; `None` when time does not advance.
fn curvature(before: &Cell, here: &Cell, after: &Cell) -> Option<[f64; 3]> {
    let (back, ahead) = (here.mean_time() - before.mean_time(), after.mean_time() - here.mean_time());
    let [f_before, f, f_after] = [before, here, after].map(Cell::departure_mm);
    let second = |k: usize| {
        let (slope_ahead, slope_back) = ((f_after[k] - f[k]) / ahead, (f[k] - f_before[k]) / back);
        2.0 * (slope_ahead - slope_back) / (back + ahead)
    };
    (back > 0.0 && ahead > 0.0).then(|| std::array::from_fn(second))
}

#[cfg(test)]
mod tests;
