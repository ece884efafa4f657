//! A recording as tables. The points table is the format that [`crate::points_csv`] imports.

use crate::item::RunHeader;
use trunnion_core::{
    AxisLetter, AxisSample, InstrumentKind, Point, ProbeSample, Quality, ReadingColumn, Setup, convert,
};
use trunnion_cycles::Run;

/// The good points of a run as `points.csv`; unsettled points and those without a reading are left out.
/// Importing it again gives the same points to the printed digits (0.1 nm, 0.1 µdeg, 1 µs, 0.1 mK).
pub fn points_csv(run: &Run) -> String {
    let (axes, rotary) = (run.machine.joints(), run.machine.rotary_joints());
    let columns = reading_columns(run.setups.iter().map(|setup| setup.instrument));
    let targets = run.setups.iter().any(|setup| setup.artefact.is_some());

    let mut names = vec!["setup".to_string()];
    names.extend(targets.then(|| "target".into()));
    names.extend(run.has_time().then(|| "time_s".into()));
    names.extend(axes.iter().copied().map(position_column));
    names.extend(rotary.iter().map(|letter| format!("direction_{}", letter.lower())));
    names.extend(columns.iter().map(|column| column.name().into()));
    names.extend(run.channels.iter().map(|channel| format!("{channel}_degc")));

    let mut table = Table::with_header(&names);
    for point in run.good_points() {
        let state = &point.state;
        let setup = run.setups.get(state.setup);
        let mut cells = vec![setup.map_or_else(String::new, |setup| setup.name.clone())];
        if targets {
            let target =
                |setup: &Setup| Some(setup.artefact.as_ref()?.targets.get(state.target)?.name.clone());
            cells.push(setup.and_then(target).unwrap_or_default());
        }
        if run.has_time() {
            cells.push(state.time_s.map_or_else(String::new, |time_s| digits(time_s, 6)));
        }
        cells.extend(axes.iter().map(|&letter| position(point, letter)));
        cells.extend(rotary.iter().map(|&letter| digits(state.direction[letter], 0)));
        let reading = |column: &ReadingColumn| {
            let setup = setup?;
            let i = setup.instrument.columns().iter().position(|own| own == column)?;
            let decimals = if matches!(column, ReadingColumn::Deviation(_)) { 4 } else { 7 };
            Some(digits(setup.column_from_reading(i, point.reading_mm[i]), decimals))
        };
        cells.extend(columns.iter().map(|column| reading(column).unwrap_or_default()));
        cells.extend(state.temperature_degc.iter().map(|&degc| digits(degc, 4)));
        table.row(&cells);
    }
    table.text()
}

/// The columns that hold the readings of these instruments, each once, in the order of the kinds.
pub(crate) fn reading_columns(kinds: impl Iterator<Item = InstrumentKind> + Clone) -> Vec<ReadingColumn> {
    let mut columns: Vec<ReadingColumn> = Vec::new();
    for (_, kind) in InstrumentKind::NAMES {
        if kinds.clone().any(|other| other == kind) {
            columns
                .extend(kind.columns().iter().filter(|column| !columns.contains(column)).collect::<Vec<_>>());
        }
    }
    columns
}

/// How many points of the run [`points_csv`] leaves out.
pub fn points_left_out(run: &Run) -> usize {
    run.points.iter().filter(|point| point.quality != Quality::Good).count()
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

/// Column of the position of a joint: `x_mm`, `j1_deg`.
pub(crate) fn position_column(joint: AxisLetter) -> String {
    format!("{}_{}", joint.lower(), if joint.is_rotary() { "deg" } else { "mm" })
}

/// Positions of the joints of a machine: `time_s,x_mm,…,c_deg`.
pub fn axis_samples_csv(joints: &[AxisLetter], samples: &[AxisSample]) -> String {
    let names = joints.iter().copied().map(position_column);
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

fn position(point: &Point, letter: AxisLetter) -> String {
    let value = point.state.position[letter];
    digits(if letter.is_rotary() { convert::deg_from_rad(value) } else { value }, 7)
}

/// A number with at most `places` places, without trailing zeros and without minus zero.
fn digits(number: f64, places: usize) -> String {
    let text = format!("{number:.places$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}
