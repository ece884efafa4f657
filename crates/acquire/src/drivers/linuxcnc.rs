//! LinuxCNC through linuxcncrsh (TCP). Keys: `host`, `port` (5007), `joints` (axis letters in the order of the joints, as
//! in `COORDINATES` of the INI file: `joints = "XYZBC"`), `rate_hz` (250: how often positions are asked for), `password`
//! or `password_file` (`EMC`; option -w of linuxcncrsh), `server` (its name, option -n, where it must not be another).
//!
//! Only values are asked for; the connection is never enabled and cannot move the machine. linuxcncrsh has no clock of
//! its own: the stamp of a position is the middle between request and answer on the host's clock. It shows a new position
//! once in `[TASK] CYCLE_TIME` (10 ms unless shortened); while the axes move, only an answer that differs from the last
//! is sent on, with the middle of the two requests between which it appeared, so that repeated answers do not look like
//! standing. Answers that stay the same for longer than three such cycles are a stand.

mod exchange;
mod probe;

use crate::credentials;
use crate::driver::{Device, Driver, Session};
use crate::execution::LINUXCNC;
use crate::link::Link;
use crate::session_end::SessionEnd;
use exchange::{Answered, Exchange, PASSWORD, PORT, unexpected};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::MissedTickBehavior;
use trunnion_core::input::Table;
use trunnion_core::reading::{AxisReading, ControllerReading, Execution, Reading};
use trunnion_core::{AxisValues, HostTime, Joint, Role, Secret};
use trunnion_protocol::linuxcncrsh::{Item, JointUnit, Reply};

/// Registry entry.
pub const DRIVER: Driver = Driver {
    name: "linuxcnc",
    about: "LinuxCNC through linuxcncrsh (TCP)",
    default_silence_ms: 1000.0,
    read,
    probe: Some(probe::PROBE),
};

/// The same answer for so long means that the axes stand, s.
const STANDS_AFTER: Duration = Duration::from_millis(30);
/// Positions of standing axes are sent so often.
const STAND_PERIOD: Duration = Duration::from_millis(20);
/// The program is asked for so often.
const PROGRAM_PERIOD: Duration = Duration::from_millis(50);

#[derive(Debug)]
struct LinuxCnc {
    host: String,
    port: u16,
    address: String,
    joints: Vec<Joint>,
    period: Duration,
    password: Option<Secret>,
    server: Option<String>,
}

fn read(table: &Table<'_>) -> Option<Arc<dyn Device>> {
    let host = Secret::read_address(table, "host");
    let port = table.optional_number("port", 1.0..=65_535.0).unwrap_or(f64::from(PORT)) as u16;
    let joints = table.string("joints").and_then(|text| {
        let letters: Vec<_> = text.split_whitespace().flat_map(str::chars).collect();
        let axes: Option<Vec<_>> =
            letters.iter().map(|letter| Joint::parse(&letter.to_string())).collect();
        if axes.as_ref().is_none_or(Vec::is_empty) {
            let advice = "Copy COORDINATES of [TRAJ] in the INI file; where an axis has two joints, its letter comes twice.";
            table.problem("joints", format!("= \"{text}\""), "letters of X, Y, Z, A, B, C", advice);
            return None;
        }
        axes
    });
    let rate_hz = table.optional_number("rate_hz", 10.0..=1000.0).unwrap_or(250.0);
    let password = Secret::read(table);
    let server = table.optional_string("server");
    let host = host?;
    let address = format!("{host}:{port}");
    let period = Duration::from_secs_f64(1.0 / rate_hz);
    Some(Arc::new(LinuxCnc { host, port, address, joints: joints?, period, password, server }))
}

impl Device for LinuxCnc {
    fn channels(&self) -> Vec<(String, Role)> {
        Vec::new()
    }

    fn address(&self) -> &str {
        &self.address
    }

    fn session<'a>(&'a self, link: &'a mut Link) -> Session<'a> {
        Box::pin(self.run(link))
    }
}

impl LinuxCnc {
    async fn run(&self, link: &mut Link) -> Result<Infallible, SessionEnd> {
        let mut exchange = Exchange::open(&self.host, self.port, &self.address, link.silence).await?;
        let password = self.password.as_ref().map_or(Ok(PASSWORD.into()), credentials::value);
        let refused = |why| SessionEnd::Refused { address: self.address.clone(), why };
        let (server, version) = exchange.hello(&password.map_err(refused)?, link).await?;
        if let Some(expected) = self.server.as_ref().filter(|expected| **expected != server) {
            let (found, expected) = (format!("LinuxCNC server {server}"), expected.clone());
            return Err(SessionEnd::WrongDevice { found, expected });
        }
        let units = self.units(&mut exchange, link).await?;
        let letters: Vec<&str> = self.joints.iter().map(|letter| letter.as_str()).collect();
        link.identified(format!("linuxcncrsh {server} {version}, joints {}", letters.join(" ")));

        let mut polls = tokio::time::interval(self.period);
        polls.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let mut track = Track::default();
        let mut program = Program::default();
        loop {
            polls.tick().await;
            let answered = exchange.positions(self.joints.len(), link).await?;
            if let Some(reading) = track.take(self.position(&answered, &units)?, &answered, self.present()) {
                link.reading(reading, answered.arrival);
            }
            if let Some(reading) = program.ask(&mut exchange, link).await? {
                link.reading(reading, answered.arrival);
            }
            (link.counters.dropped_bytes, link.counters.damaged) =
                (exchange.dropped_bytes(), exchange.repeated());
            link.report_counters(answered.arrival);
        }
    }

    /// Size of a unit of each joint in mm or rad.
    async fn units(&self, exchange: &mut Exchange, link: &Link) -> Result<Vec<f64>, SessionEnd> {
        let answered = exchange.get(Item::JointUnits, link).await?;
        let Reply::JointUnits(units) = answered.reply else { return Err(unexpected(&answered)) };
        let wrong = |found: String, letter: Joint| SessionEnd::WrongDevice {
            found,
            expected: format!("axis {letter} there, by `joints`; compare with COORDINATES of its INI file"),
        };
        let size = |(joint, &letter): (usize, &Joint)| {
            let unit = units
                .get(joint)
                .ok_or_else(|| wrong(format!("LinuxCNC with {} joints", units.len()), letter))?;
            let kind = |unit: &JointUnit| format!("LinuxCNC whose joint {joint} is in {}", unit.word());
            if unit.is_angle() != Some(letter.is_rotary()) {
                return Err(wrong(kind(unit), letter));
            }
            unit.in_mm_or_rad().ok_or_else(|| wrong(kind(unit), letter))
        };
        self.joints.iter().enumerate().map(size).collect()
    }

    fn position(&self, answered: &Answered, units: &[f64]) -> Result<AxisValues<f64>, SessionEnd> {
        let Reply::JointPos(numbers) = &answered.reply else { return Err(unexpected(answered)) };
        let mut position = AxisValues::default();
        // The first joint of an axis with two stands last here, so that it counts.
        for (joint, &letter) in self.joints.iter().enumerate().rev() {
            let number = numbers.get(joint).ok_or_else(|| unexpected(answered))?;
            position[letter] = number * units[joint];
        }
        Ok(position)
    }

    fn present(&self) -> AxisValues<bool> {
        AxisValues::of(self.joints.iter().copied(), |_| true)
    }
}

/// Answers to positions: which are new, and since when.
#[derive(Default)]
struct Track {
    last: Option<AxisValues<f64>>,
    /// Middle of the last request and its answer.
    last_middle: HostTime,
    changed: HostTime,
    sent: HostTime,
    sequence: u64,
}

impl Track {
    fn take(
        &mut self,
        position: AxisValues<f64>,
        answered: &Answered,
        present: AxisValues<bool>,
    ) -> Option<Reading> {
        let (middle, before) = (answered.middle(), self.last_middle);
        self.last_middle = middle;
        let changed = self.last.replace(position) != Some(position);
        let stood = middle - self.changed;
        let stamp = if changed {
            self.changed = middle;
            // It appeared between two requests; after a stand its beginning lies close before the second.
            if self.sequence == 0 || stood > STANDS_AFTER { middle } else { before + (middle - before) / 2 }
        } else if stood > STANDS_AFTER && middle - self.sent >= STAND_PERIOD {
            middle
        } else {
            return None;
        };
        self.sent = middle;
        self.sequence += 1;
        Some(Reading::Axes(AxisReading {
            stamp_ns: stamp.0,
            arrival: answered.arrival,
            position,
            present,
            sequence: self.sequence,
            held: false,
            skew_ns: 0,
        }))
    }
}

/// The program as last reported.
#[derive(Default)]
struct Program {
    asked: Option<HostTime>,
    reported: Option<(Execution, String, u32)>,
}

impl Program {
    /// A reading when it is time to ask and something has changed.
    async fn ask(&mut self, exchange: &mut Exchange, link: &Link) -> Result<Option<Reading>, SessionEnd> {
        if self.asked.is_some_and(|asked| link.now() - asked < PROGRAM_PERIOD) {
            return Ok(None);
        }
        self.asked = Some(link.now());
        let answered = exchange.get(Item::ProgramStatus, link).await?;
        let Reply::ProgramStatus(status) = answered.reply else { return Err(unexpected(&answered)) };
        let execution = LINUXCNC.execution(status.word());
        let line = exchange.get(Item::ProgramLine, link).await?;
        let Reply::ProgramLine(line) = line.reply else { return Err(unexpected(&line)) };
        let name = exchange.get(Item::Program, link).await?;
        let Reply::Program(name) = name.reply else { return Err(unexpected(&name)) };
        let now = (execution, name.unwrap_or_default(), line);
        if self.reported.as_ref() == Some(&now) {
            return Ok(None);
        }
        let (execution, program, line) = self.reported.insert(now).clone();
        Ok(Some(Reading::Controller(ControllerReading {
            execution,
            program,
            block: line.to_string(),
            signal: None,
            stamp_ns: answered.middle().0,
            arrival: answered.arrival,
        })))
    }
}
