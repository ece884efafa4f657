//! Which recording this is: its digest, its machine, how and when it was measured, as far as it says. And which program.

use crate::{Error, moment, page, recorded};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::{Debug, Write};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;
use std::time::UNIX_EPOCH;
use trunnion_core::number::trimmed;
use trunnion_core::{Day, InstrumentKind, Setup};
use trunnion_cycles::{Run, RunKind};
use trunnion_record::RunHeader;
use trunnion_results::{Doubt, RunIdentity, SensorCalibration, TemperatureRange};

/// Bytes of a file in memory at once.
const CHUNK: usize = 1 << 16;

/// A recording.
pub(crate) fn of_run(path: &Path, run: &Run) -> Result<RunIdentity, Error> {
    let header = trunnion_record::read_header(path).map_err(Error::recording(path))?;
    let began = moment::minute(header.wall_start_ns);
    Ok(RunIdentity {
        run: run.name.clone(),
        file: path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        sha256: sha256(path)?,
        day: began.as_ref().map(|began| began.chars().take(10).collect()),
        began,
        cycle: recorded::plan_of(&header).map_or_else(String::new, |plan| plan.cycle.name),
        on_the_fly: run.kind == RunKind::OnTheFly,
        setups: run.setups.iter().map(setup).collect(),
        probes: header.probes.clone(),
        probe_calibration: probe_calibration(&header, &run.setups),
        calibrations: header.calibrations.iter().map(SensorCalibration::from).collect(),
        temperatures: temperatures(run),
        recorded_with: header.software_version,
    })
}

/// Hexadecimal SHA-256 of a file.
///
/// # Errors
/// A file that cannot be read.
pub fn sha256(path: &Path) -> Result<String, Error> {
    let mut file = File::open(path).map_err(Error::read(path))?;
    let (mut digest, mut chunk) = (Sha256::new(), vec![0; CHUNK]);
    loop {
        match file.read(&mut chunk).map_err(Error::read(path))? {
            0 => return Ok(hexadecimal(digest)),
            read => digest.update(&chunk[..read]),
        }
    }
}

/// The same of what is in memory.
pub(crate) fn sha256_of(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new().chain_update(bytes))
}

/// The same of a value as `Debug` shows it: all its fields, numbers to the bit.
pub(crate) fn sha256_of_shown(value: &impl Debug) -> String {
    struct Digested(Sha256);
    impl Write for Digested {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0.update(text);
            Ok(())
        }
    }
    let mut shown = Digested(Sha256::new());
    write!(shown, "{value:?}").expect("a digest takes everything");
    hexadecimal(shown.0)
}

/// The program, build by build: two of one version may differ in a figure. `None` where its file is gone, as after an update.
pub(crate) fn program() -> Option<&'static str> {
    static PROGRAM: OnceLock<Option<String>> = OnceLock::new();
    let build = || {
        let about = std::env::current_exe().and_then(|program| program.metadata()).ok()?;
        let written = about.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some(format!("{}, {} bytes of {}", page::label(), about.len(), written.as_nanos()))
    };
    PROGRAM.get_or_init(build).as_deref()
}

fn hexadecimal(digest: Sha256) -> String {
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

fn setup(setup: &Setup) -> String {
    let [x, y, z] = <[f64; 3]>::from(setup.ball_in_table_mm.coords).map(|mm| trimmed(mm, 3));
    let instrument = setup.instrument.title();
    format!("{}: {instrument}, ball at X {x} mm, Y {y} mm, Z {z} mm", setup.name)
}

/// The doubts about a run that was measured after calibrations of its sensors had ended; none where a run has no day.
pub(crate) fn calibration_doubts(header: &RunHeader) -> Vec<Doubt> {
    let Some(day) = moment::day(header.wall_start_ns).as_deref().and_then(Day::parse) else {
        return Vec::new();
    };
    let mut ended = BTreeMap::<Day, Vec<&str>>::new();
    for calibration in header.calibrations.iter().filter(|calibration| calibration.is_out_of_date(day)) {
        ended.entry(calibration.valid_until.unwrap_or(day)).or_default().push(&calibration.sensor);
    }
    ended.iter().map(|(until, sensors)| Doubt::calibration(&header.name, sensors, *until, day)).collect()
}

/// The directions of the probes of an R-test, as the configuration in the recording has them.
fn probe_calibration(header: &RunHeader, setups: &[Setup]) -> Vec<String> {
    let is_nest = setups.iter().any(|setup| setup.instrument == InstrumentKind::RTest);
    let plan = recorded::plan_of(header).filter(|_| is_nest && header.config_text.contains("[nest]"));
    let Some(from_nest) = plan.and_then(|plan| plan.nest.nest_from_probes.try_inverse()) else {
        return Vec::new();
    };
    let line = |k: usize| {
        let row = from_nest.row(k);
        format!("probe {}: ({:.6}, {:.6}, {:.6})", k + 1, row[0], row[1], row[2])
    };
    (0..3).map(line).collect()
}

/// What every temperature channel read at the points.
pub(crate) fn temperatures(run: &Run) -> Vec<TemperatureRange> {
    let range = |(k, channel): (usize, &String)| {
        let values: Vec<f64> = run
            .points
            .iter()
            .filter_map(|point| point.state.temperature_degc.get(k).copied())
            .filter(|value| value.is_finite())
            .collect();
        let count = values.len() as f64;
        (!values.is_empty()).then(|| TemperatureRange {
            channel: channel.clone(),
            lowest_degc: values.iter().copied().fold(f64::INFINITY, f64::min),
            mean_degc: values.iter().sum::<f64>() / count,
            highest_degc: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    };
    run.channels.iter().enumerate().filter_map(range).collect()
}
