//! Cells that many devices share.

use super::matrix::{Case, Cell, GapOf, Trouble};
use trunnion_acquire::DeviceState;
use trunnion_acquire::DeviceState::{Absent, Failed, Silent, Streaming, Stuck, WrongDevice};
use trunnion_hil_sim::devices::Fault;

/// Times of the faults, s.
const UNPLUGGED_S: f64 = 1.5;
const STUCK_S: f64 = 4.0;
const OUT_S: f64 = 0.8;

/// What a device has in common with others.
#[derive(Clone, Copy)]
pub enum Kind {
    /// A measuring device on a serial port, without counter and clock.
    Serial,
    /// A controller's axes over the network; so its address stands in messages.
    Controller { address: &'static str },
}

impl Kind {
    /// The common cell, if there is one.
    pub fn cell(self, trouble: Trouble) -> Option<Cell> {
        let cannot = |why| Some(Cell::Cannot(why));
        match (self, trouble) {
            (Self::Serial, Trouble::AbsentAtStart) => {
                some(Case::absent("PORT is not there; plug it in or correct the port"))
            }
            (Self::Serial, Trouble::Unplugged) => some(Case::unplugged("disconnected: *")),
            (Self::Serial, Trouble::CounterJump) => {
                cannot("it does not count its measurements; missing answers are counted")
            }
            (Self::Serial, Trouble::Restarted) => {
                cannot("it has no program to restart; switched off and on it is silent for a while")
            }
            (Self::Serial, Trouble::ControllerGone) => cannot("there is no controller behind it"),
            (Self::Controller { address }, Trouble::AbsentAtStart) => {
                some(Case::absent(&format!(
                    "{address} (*) is not there; check that it is switched on and its server runs, cable and network, and \
                     the address in the configuration"
                )))
            }
            (Self::Controller { .. }, Trouble::StuckValue) => some(Case {
                fault: Some(Fault::StuckValue { duration_s: STUCK_S }),
                course: &[Stuck, Streaming],
                gap: GapOf::away("axis positions were stuck while the program went on", 2.5),
                message: "the program went on by * blocks in * s but no axis moved; check that the controller's positions \
                          are live (adapter, machine lock, dry run)"
                    .into(),
                ..Case::default()
            }),
            (Self::Controller { .. }, Trouble::OutOfRange) => cannot("an axis has no measuring range"),
            (Self::Controller { .. }, Trouble::CounterJump) => cannot("it does not count its positions"),
            (_, Trouble::ClockJump) => cannot("it has no clock; the computer's stamps its answers"),
            (_, Trouble::BusOff) => cannot("it hangs on no bus"),
            _ => None,
        }
    }
}

/// A cell that is run.
pub fn some(case: Case) -> Option<Cell> {
    Some(Cell::Case(case))
}

/// Nothing happens to a device that has been read for a moment.
impl Default for Case {
    fn default() -> Self {
        Self {
            fault: None,
            after_s: 0.3,
            after_readings: 1,
            course: &[],
            perhaps: None,
            gap: None,
            message: String::new(),
        }
    }
}

impl Case {
    /// The device was away, and what is reported of that is the reason of the gap.
    pub fn away(fault: Fault, course: &'static [DeviceState], reason: &str, at_least_s: f64) -> Self {
        let gap = GapOf::away(reason, at_least_s);
        Self { fault: Some(fault), course, gap, message: reason.into(), ..Self::default() }
    }

    /// It is switched on only after the program has found it absent.
    pub fn absent(reason: &str) -> Self {
        let gap = GapOf::away(reason, 0.0);
        Self { course: &[Absent, Streaming], gap, message: reason.into(), ..Self::default() }
    }

    pub fn unplugged(reason: &str) -> Self {
        let fault = Fault::Unplug { duration_s: UNPLUGGED_S };
        Self::away(fault, &[Failed, Absent, Streaming], reason, 0.8 * UNPLUGGED_S)
    }

    pub fn silent(duration_s: f64, reason: &str) -> Self {
        let fault = Fault::Silence { duration_s };
        Self::away(fault, &[Silent, Streaming], reason, 0.8 * duration_s)
    }

    /// The server or agent goes and comes back at once.
    pub fn restarted(reason: &str) -> Self {
        Self::away(Fault::AgentRestart, &[Failed, Streaming], reason, 0.1)
    }

    /// Another device takes its place: the session ends so, and the next one says so.
    pub fn another(course: &'static [DeviceState], reason: &str, message: &str) -> Self {
        debug_assert!(course.last() == Some(&WrongDevice), "a wrong device is not asked again at once");
        Self { message: message.into(), ..Self::away(Fault::WrongIdentity, course, reason, 0.1) }
    }

    /// Readings are missing, and counted.
    pub fn lost(fault: Fault, reason: &str) -> Self {
        Self { fault: Some(fault), gap: GapOf::counted(reason), ..Self::default() }
    }

    /// A channel shows one value, after it was seen to tremble at rest.
    pub fn stuck(channel: Option<&'static str>, after_readings: u64) -> Self {
        Self {
            fault: Some(Fault::StuckValue { duration_s: STUCK_S }),
            after_s: 6.5,
            after_readings,
            course: &[Stuck, Streaming],
            perhaps: None,
            gap: GapOf::without_value(channel, "stuck at *", 3.0),
            message: format!(
                "{} is stuck: it has sent * for * s although it trembled before; check that the probe moves freely and \
                 that its display is not held",
                source(channel)
            ),
        }
    }

    /// A channel has no value, because.
    pub fn out_of_range(channel: Option<&'static str>, why: &str) -> Self {
        Self {
            fault: Some(Fault::OutOfRange { duration_s: OUT_S }),
            gap: GapOf::without_value(channel, &format!("no value: {why}"), 0.5),
            message: format!("{} has no value: {why}", source(channel)),
            ..Self::default()
        }
    }
}

fn source(channel: Option<&str>) -> String {
    channel.map_or_else(|| "it".into(), |channel| format!("it.{channel}"))
}
