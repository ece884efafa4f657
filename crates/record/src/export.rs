//! A recording as tables. The points table is the format that [`crate::points_csv`] imports.

use crate::column::{Column, on_the_fly, readings, spindle_of};
use crate::item::RunHeader;
use trunnion_core::{
    AxisSample, AxisValues, Joint, Lacks, Point, ProbeSample, Quality, ReadingColumn, Setup, convert,
};
use trunnion_cycles::{Run, RunKind};

/// The good points of a run as `points.csv`; unsettled points and those without a reading are left out.
/// Importing it again gives the same points: at rest to the printed digits (0.1 nm, 0.1 µdeg, 1 µs, 0.1 mK), on the fly to the last
/// bit but one.
pub fn points_csv(run: &Run) -> String {
    points_csv_with_axes(run, &[])
}

/// The same with what the encoders read, in order of time: columns of their own where every point has its reading.
pub fn points_csv_with_axes(run: &Run, axes: &[AxisSample]) -> String {
    let columns = columns(run, axes);
    let mut table = Table::with_header(&columns.iter().map(Column::name).collect::<Vec<_>>());
    for point in run.good_points() {
        let actual = point.state.time_s.and_then(|time_s| read_at(axes, time_s));
        table.row(columns.iter().map(|column| cell(run, column, point, actual)));
    }
    table.text()
}

/// Every point of a run, the unsettled and those without a reading too: the columns of [`points_csv`], `quality`, which is `good`,
/// `unsettled` or `no-reading`, and `why`, in words. A reading that is none is empty.
pub fn every_point_csv(run: &Run) -> String {
    let columns = columns(run, &[]);
    let names = columns.iter().map(Column::name).chain(["quality".into(), "why".into()]);
    let mut table = Table::with_header(&names.collect::<Vec<_>>());
    for point in &run.points {
        let cells = columns.iter().map(|column| cell(run, column, point, None));
        let known = cells.map(|cell| if cell == "NaN" { String::new() } else { cell });
        let (quality, why) = match point.quality {
            Quality::Good => ("good", ""),
            Quality::Unsettled => ("unsettled", "the reading never settled within the limits of the cycle"),
            Quality::NoReading(lacks) => ("no-reading", in_words(lacks)),
        };
        table.row(known.chain([quality.into(), why.into()]));
    }
    table.text()
}

/// What a point without a reading lacks.
fn in_words(lacks: Lacks) -> &'static str {
    match lacks {
        Lacks::Unsaid => "not recorded",
        Lacks::Dwell => "the machine did not dwell at this pose",
        Lacks::Value => "the machine stood there and not every probe had values",
        Lacks::End => "the cycle ended before this pose",
    }
}

fn columns(run: &Run, axes: &[AxisSample]) -> Vec<Column> {
    let (joints, moves) = (run.machine.joints(), run.kind == RunKind::OnTheFly);
    let kinds = run.setups.iter().map(|setup| setup.instrument);
    let mut columns = vec![Column::Setup];
    if run.setups.iter().any(|setup| setup.artefact.is_some()) {
        columns.push(Column::Target);
    }
    if run.has_time() {
        columns.push(Column::Time);
    }
    columns.extend(joints.iter().copied().map(Column::Position));
    let turning = joints.iter().copied().filter(|joint| moves || joint.is_rotary());
    columns.extend(turning.map(Column::Direction));
    columns.extend(readings(kinds.clone()).into_iter().map(Column::Reading));
    columns.extend(run.channels.iter().cloned().map(Column::Temperature));
    if moves {
        let read = |point: &Point| point.state.time_s.is_some_and(|time_s| read_at(axes, time_s).is_some());
        let every = !axes.is_empty() && run.good_points().all(read);
        let spindle =
            spindle_of(&joints).filter(|spindle| axes.iter().any(|axes| axes.position[*spindle] != 0.0));
        let recorded = joints.iter().copied().chain(spindle).map(Column::Actual).filter(|_| every);
        let others = on_the_fly(&joints, kinds);
        let of_point = |column: &Column| !matches!(column, Column::Feed | Column::Actual(_));
        columns.extend(recorded.chain(others.into_iter().filter(of_point)));
    }
    columns
}

fn read_at(axes: &[AxisSample], time_s: f64) -> Option<&AxisSample> {
    let at = axes.partition_point(|sample| sample.time_s < time_s);
    axes.get(at).filter(|sample| sample.time_s == time_s)
}

fn cell(run: &Run, column: &Column, point: &Point, actual: Option<&AxisSample>) -> String {
    let (state, setup) = (&point.state, run.setups.get(point.state.setup));
    let number = |value: f64, places: usize| match run.kind {
        RunKind::Static => digits(value, places),
        RunKind::OnTheFly => value.to_string(),
    };
    let of = |values: &AxisValues<f64>, joint: Joint| {
        let value = values[joint];
        number(if joint.is_rotary() { convert::deg_from_rad(value) } else { value }, 7)
    };
    match column {
        Column::Setup => setup.map_or_else(String::new, |setup| setup.name.clone()),
        Column::Target => {
            let target =
                |setup: &Setup| Some(setup.artefact.as_ref()?.targets.get(state.target)?.name.clone());
            setup.and_then(target).unwrap_or_default()
        }
        Column::Time => state.time_s.map_or_else(String::new, |time_s| number(time_s, 6)),
        Column::Position(joint) => of(&state.position, *joint),
        Column::Direction(joint) => digits(state.direction[*joint], 0),
        Column::Reading(column) => {
            let reading = |setup: &Setup| {
                let i = setup.instrument.columns().iter().position(|own| own == column)?;
                let decimals = if matches!(column, ReadingColumn::Deviation(_)) { 4 } else { 7 };
                Some(number(setup.column_from_reading(i, point.reading_mm[i]), decimals))
            };
            setup.and_then(reading).unwrap_or_default()
        }
        Column::Temperature(name) => {
            let channel = run.channels.iter().position(|channel| channel == name);
            let degc = channel.and_then(|channel| state.temperature_degc.get(channel));
            degc.map_or_else(String::new, |&degc| number(degc, 4))
        }
        Column::Feed => String::new(),
        Column::Actual(joint) => actual.map_or_else(String::new, |actual| of(&actual.position, *joint)),
        Column::Speed(joint) => of(&state.velocity, *joint),
        Column::Acceleration(joint) => of(&state.acceleration, *joint),
        Column::SinceReversal(joint) => of(&state.since_reversal, *joint),
        Column::Samples => point.samples.to_string(),
        Column::Spread(component) => {
            let components = setup.map_or(&[][..], |setup| setup.instrument.components());
            let at = components.iter().position(|own| own == component);
            at.map_or_else(String::new, |i| number(convert::um_from_mm(point.spread_mm[i]), 4))
        }
    }
}

/// Probe samples: `time_s,probe,device_ticks,raw,value_um`; an empty value means the device reported an
/// error.
pub fn probe_samples_csv(header: &RunHeader, samples: &[ProbeSample]) -> String {
    let mut table = Table::with_header(&["time_s", "probe", "device_ticks", "raw", "value_um"]);
    for sample in samples {
        let name = header.probes.get(usize::from(sample.channel)).filter(|name| !name.is_empty());
        let name = name.cloned().unwrap_or_else(|| sample.channel.to_string());
        let value = sample.value_mm.is_finite().then(|| digits(convert::um_from_mm(sample.value_mm), 4));
        let (ticks, raw) = (sample.stamp.ticks.to_string(), sample.raw.to_string());
        table.row(&[digits(sample.time_s, 9), name, ticks, raw, value.unwrap_or_default()]);
    }
    table.text()
}

/// Positions of the joints of a machine: `time_s,x_mm,…,c_deg`.
pub fn axis_samples_csv(joints: &[Joint], samples: &[AxisSample]) -> String {
    let names = joints.iter().map(|&joint| Column::Position(joint).name());
    let names: Vec<String> = std::iter::once("time_s".into()).chain(names).collect();
    let mut table = Table::with_header(&names);
    for sample in samples {
        let cells = joints.iter().map(|&letter| {
            let value = sample.position[letter];
            digits(if letter.is_rotary() { convert::deg_from_rad(value) } else { value }, 7)
        });
        table.row(std::iter::once(digits(sample.time_s, 9)).chain(cells));
    }
    table.text()
}

/// Comma-separated text; cells are quoted where they must be.
struct Table(csv::Writer<Vec<u8>>);

impl Table {
    fn with_header(names: &[impl AsRef<[u8]>]) -> Self {
        let mut table = Self(csv::Writer::from_writer(Vec::new()));
        table.row(names);
        table
    }

    fn row(&mut self, cells: impl IntoIterator<Item = impl AsRef<[u8]>>) {
        self.0.write_record(cells).expect("rows of one length go to memory");
    }

    fn text(self) -> String {
        let bytes = self.0.into_inner().expect("memory takes every byte");
        String::from_utf8(bytes).expect("cells are text")
    }
}

/// A number with at most `places` places, without trailing zeros and without minus zero.
fn digits(number: f64, places: usize) -> String {
    let text = format!("{number:.places$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}
