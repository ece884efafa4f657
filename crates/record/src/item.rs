//! What a recording holds: the header of the run and the items that follow.

use trunnion_core::{
    AxisSample, Calibration, Event, Gap, HostTime, Point, ProbeSample, Problems, Role, Setup,
};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::Machine;

/// What is known of a run before its first sample. The texts are kept as attachments, word for word.
#[derive(Clone, Debug, PartialEq)]
pub struct RunHeader {
    /// Name of the run, shown in reports.
    pub name: String,
    /// Static or on the fly.
    pub kind: RunKind,
    /// Name of the machine.
    pub machine_name: String,
    /// The machine file; empty: looked up by name when read.
    pub machine_text: String,
    /// Setups; `Point::state.setup` indexes them.
    pub setups: Vec<Setup>,
    /// Names of the temperature channels; `Temperature::channel` indexes them.
    pub temperature_channels: Vec<String>,
    /// Names of the probe channels; `ProbeSample::channel` indexes them.
    pub probes: Vec<String>,
    /// What each probe channel is for; empty in imports and in recordings of before 0.2.
    pub probe_roles: Vec<Role>,
    /// What the certificates of the sensors say; empty where nobody said it, and in recordings of before 0.2.
    pub calibrations: Vec<Calibration>,
    /// The cycle file; empty when there was none.
    pub cycle_text: String,
    /// The configuration of the program; empty when there was none.
    pub config_text: String,
    /// Version of the program that recorded.
    pub software_version: String,
    /// Wall clock at run time 0, ns since 1970 UTC; a label only.
    pub wall_start_ns: i64,
    /// Host clock at run time 0.
    pub host_start: HostTime,
}

impl RunHeader {
    /// The header of a run of which nothing else is known.
    pub fn new(name: &str, kind: RunKind, machine_name: &str) -> Self {
        Self {
            name: name.into(),
            kind,
            machine_name: machine_name.into(),
            machine_text: String::new(),
            setups: Vec::new(),
            temperature_channels: Vec::new(),
            probes: Vec::new(),
            probe_roles: Vec::new(),
            calibrations: Vec::new(),
            cycle_text: String::new(),
            config_text: String::new(),
            software_version: String::new(),
            wall_start_ns: 0,
            host_start: HostTime::default(),
        }
    }

    /// The header of a run that is already in memory (imported or simulated).
    pub fn of_run(run: &Run, machine_text: &str, software_version: &str, wall_start_ns: i64) -> Self {
        Self {
            machine_text: machine_text.into(),
            setups: run.setups.clone(),
            temperature_channels: run.channels.clone(),
            software_version: software_version.into(),
            wall_start_ns,
            ..Self::new(&run.name, run.kind, &run.machine.name)
        }
    }

    /// The machine as recorded; `None` when the recording only names it.
    ///
    /// # Errors
    /// Every problem of the recorded machine file.
    pub fn machine(&self) -> Option<Result<Machine, Problems>> {
        let file = format!("{}.toml in the recording", self.machine_name);
        (!self.machine_text.is_empty()).then(|| Machine::parse(&self.machine_name, &file, &self.machine_text))
    }
}

/// One thing to record, or one thing read back. Times are run time.
#[expect(clippy::large_enum_variant, reason = "the queue is bounded, and one box a sample would cost more")]
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A displacement.
    Probe(ProbeSample),
    /// Axis positions.
    Axes(AxisSample),
    /// A point.
    Point(Point),
    /// A temperature.
    Temperature(Temperature),
    /// An event.
    Event(Event),
    /// A gap.
    Gap(Gap),
}

/// One reading of a temperature channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Temperature {
    /// When, s since the run began.
    pub time_s: f64,
    /// Index into [`RunHeader::temperature_channels`].
    pub channel: u16,
    /// °C; NaN when the sensor reported an error.
    pub value_degc: f64,
}
