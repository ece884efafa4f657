//! The fault matrix of the driver: each row ends in readings again. Rows of docs/measured/faults.md.

use crate::bus::SimulatedBus;
use crate::command;
use crate::flood::Flood;
use crate::seen::Seen;
use crate::session::Session;
use crate::way::emergency;
use anyhow::{Context, ensure};
use socketcan::errors::{CAN_ERR_ACK, CAN_ERR_BUSOFF, CAN_ERR_CRTL, CAN_ERR_RESTARTED};
use std::time::Duration;
use trunnion_acquire::DeviceState;
use trunnion_acquire::DeviceState::{Absent, Failed, Refused, Silent, Streaming, WrongDevice};
use trunnion_protocol::canopen::network::sync_frame;

/// Readings from the fault on after which it is mended, where nothing else says that it has shown: 0.2 s.
const ENOUGH: usize = 80;
/// Readings before the fault, four channels three times.
const BEFORE: usize = 12;
/// Readings that must follow.
const AFTERWARDS: usize = 200;

/// Values are missed or heartbeats, whichever comes first.
const SILENT: &str = "silent for * ms: node 3 sends no *";

/// What must follow from a fault.
struct Case {
    fault: &'static str,
    /// States; none where values go on.
    course: &'static [DeviceState],
    /// Sessions that end in the first of them before it is mended.
    ends: u64,
    /// Reason of the gap, and whether it counts readings; `*` stands for figures and words of the system.
    gap: Option<(&'static str, Missing)>,
    /// Line of the log; empty for none.
    message: &'static str,
}

enum Missing {
    TimeOnly,
    Counted,
}
use Missing::{Counted, TimeOnly};

/// A fault that ends the session, which gap and message say.
const fn away(fault: &'static str, course: &'static [DeviceState], words: &'static str) -> Case {
    Case { fault, course, ends: 1, gap: Some((words, TimeOnly)), message: words }
}

/// A fault during which values go on.
const fn streaming(fault: &'static str, gap: Option<(&'static str, Missing)>, message: &'static str) -> Case {
    Case { fault, course: &[], ends: 0, gap, message }
}

/// All of them, on an interface without hardware.
pub async fn matrix(bus: SimulatedBus, session: &mut Session) -> anyhow::Result<SimulatedBus> {
    nodes(&bus, session).await?;
    answers(&bus, session).await?;
    traffic(&bus, session).await?;
    interface(bus, session).await
}

/// What happens to nodes.
async fn nodes(bus: &SimulatedBus, session: &mut Session) -> anyhow::Result<()> {
    let again = || {
        bus.restart();
        Ok(())
    };
    let case = away("a node switched off, and on", &[Silent, Streaming], SILENT);
    case.row(
        session,
        || {
            bus.switch_off(3);
            Ok(())
        },
        again,
    )
    .await?;

    let case = away("the cable of a node pulled, and put back", &[Silent, Streaming], SILENT);
    let cut = |node| {
        bus.set_way(|way| way.cut = node);
        Ok(())
    };
    case.row(session, || cut(Some(3)), || cut(None)).await?;

    let case = away("a node begins again by itself", &[Failed, Streaming], "restarted: node 3 is BootUp");
    case.row(
        session,
        || {
            bus.reset(3);
            Ok(())
        },
        || Ok(()),
    )
    .await?;

    let wrong = "wrong device: found node 3 *serial 9999, expected node 3 with serial number 1003*";
    let case = Case {
        gap: Some(("restarted: node 3 is BootUp", TimeOnly)),
        ..away("another node in its place, and the right one back", &[Failed, WrongDevice, Streaming], wrong)
    };
    case.row(
        session,
        || {
            bus.exchange(3, 9999);
            Ok(())
        },
        || {
            bus.exchange(3, 1003);
            Ok(())
        },
    )
    .await?;

    let no_value = Some(("no value: the node reported by an emergency that it cannot measure*", Counted));
    let case = streaming(
        "emergency of a node: it cannot measure, then it can",
        no_value,
        "node 3 emergency 5000h, register 21h: it cannot measure*",
    );
    let send = |code, register| bus.send(&emergency(3, code, register));
    case.row(session, || send(0x5000, 0x21), || send(0, 0)).await?;

    let case =
        streaming("emergency of a node that goes on measuring", None, "node 3 emergency 8110h, register 11h");
    case.row(session, || send(0x8110, 0x11), || send(0, 0)).await
}

/// What happens to answers to SYNC.
async fn answers(bus: &SimulatedBus, session: &mut Session) -> anyhow::Result<()> {
    let lost = |node| {
        bus.set_way(|way| way.lost = node);
        Ok(())
    };
    let case = streaming("values of a node lost for 0.2 s", Some(("node 3 missed SYNCs", Counted)), "");
    case.row(session, || lost(Some(3)), || lost(None)).await?;

    let doubled = |is| {
        bus.set_way(|way| way.doubled = is);
        Ok(())
    };
    let case = streaming("every value comes twice", None, "");
    case.row(session, || doubled(true), || doubled(false)).await?;

    // A little more than from one SYNC to the next.
    let late = |of| {
        bus.set_way(|way| way.late = of);
        Ok(())
    };
    let unknown = "node 3 answered later than the next SYNC*";
    let case = streaming(
        "values of a node come after the next SYNC",
        Some((unknown, Counted)),
        "node 3 answers later than the next SYNC: take a longer sync_ms",
    );
    case.row(session, || late(Some((3, Duration::from_millis(12)))), || late(None)).await
}

/// What others do on the bus.
async fn traffic(bus: &SimulatedBus, session: &mut Session) -> anyhow::Result<()> {
    let case = streaming("somebody else sends SYNC", None, "somebody else sends SYNC on vcan0*");
    let sync = || (0..5).try_for_each(|_| bus.send(&sync_frame(None)));
    case.row(session, sync, || Ok(())).await?;

    let mut flood = None;
    let case = streaming("the bus is full of frames of others for 3 s", None, "");
    let begin = || {
        flood = Some(Flood::start(bus.socket()?, Duration::from_secs(3)));
        Ok(())
    };
    case.row(session, begin, || Ok(())).await?;
    let sent = flood.take().context("a flood")?.join()?;
    ensure!(sent > 3_000, "{sent} frames are no full bus");

    // The second session must end too, although frames come all the time.
    let case = Case {
        ends: 2,
        ..away("a node is silent while the bus is full of frames of others", &[Silent, Streaming], SILENT)
    };
    let begin = || {
        bus.set_way(|way| way.cut = Some(3));
        flood = Some(Flood::start(bus.socket()?, Duration::from_secs(120)));
        Ok(())
    };
    case.row(session, begin, || {
        bus.set_way(|way| way.cut = None);
        Ok(())
    })
    .await?;
    flood.take().context("a flood")?.stop()?;
    Ok(())
}

/// What happens to the controller and the interface.
async fn interface(bus: SimulatedBus, session: &mut Session) -> anyhow::Result<SimulatedBus> {
    let none = || Ok(());
    let case = streaming(
        "the controller reports errors without end (error passive)",
        None,
        "vcan0 reports *; check cable*",
    );
    case.row(session, || bus.report(CAN_ERR_CRTL, [0, 0x20, 0, 0, 0, 0, 0, 0]), none).await?;

    let case = streaming("nobody acknowledges for a moment", None, "vcan0 reports *; no node acknowledges*");
    case.row(session, || bus.report(CAN_ERR_ACK, [0; 8]), none).await?;

    let words = "disconnected: vcan0 is bus-off after too many errors*restart it with `ip link set vcan0 type can restart`*";
    let case = away("bus-off", &[Failed, Streaming], words);
    case.row(session, || bus.report(CAN_ERR_BUSOFF, [0; 8]), none).await?;

    let case =
        streaming("the controller was restarted after bus-off", None, "vcan0 was restarted after bus-off");
    case.row(session, || bus.report(CAN_ERR_RESTARTED, [0; 8]), none).await?;

    let case = away(
        "interface down, and up",
        &[Refused, Streaming],
        "cannot open vcan0: the interface is down; bring it up: ip link set vcan0 up type can bitrate*",
    );
    let down = || command("ip", &["link", "set", "vcan0", "down"]);
    case.row(session, down, || command("ip", &["link", "set", "vcan0", "up"])).await?;

    let case = away(
        "interface gone, as an adapter unplugged, and back",
        &[Absent, Streaming],
        "CAN interface vcan0 is not there; *",
    );
    let mut again = None;
    let add = || {
        command("ip", &["link", "add", "dev", "vcan0", "type", "vcan"])?;
        command("ip", &["link", "set", "vcan0", "up"])?;
        again = Some(SimulatedBus::start("vcan0")?);
        Ok(())
    };
    case.row(session, || command("ip", &["link", "del", "vcan0"]), add).await?;
    bus.stop()?;
    again.context("the bus began again")
}

impl Case {
    /// The fault, until readings follow again; prints its row.
    async fn row(
        &self,
        session: &mut Session,
        begin: impl FnOnce() -> anyhow::Result<()>,
        mend: impl FnOnce() -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        session.read_syncs(50, 4).await.with_context(|| format!("before: {}", self.fault))?;
        let (mut seen, ended) = (session.seen(), session.ends());
        // What is missing is counted from a value of every channel on.
        session.watch(&mut seen, self.fault, |seen, _| seen.readings.len() >= BEFORE).await?;
        begin()?;
        session.watch(&mut seen, self.fault, |seen, ends| self.has_shown(seen, ends - ended)).await?;
        mend()?;
        session.watch(&mut seen, self.fault, |seen, _| self.is_over(seen)).await?;
        let until = seen.readings.len() + AFTERWARDS;
        session.watch(&mut seen, self.fault, |seen, _| seen.readings.len() >= until).await?;
        self.check(&seen).with_context(|| self.fault)?;
        println!("FAULT {}", self.shown(&seen)?);
        Ok(())
    }

    fn has_shown(&self, seen: &Seen, ends: u64) -> bool {
        match self.course {
            [] => seen.readings.len() >= ENOUGH,
            [first @ .., _] => {
                ends >= self.ends && first.iter().all(|state| seen.course.states.contains(state))
            }
        }
    }

    fn is_over(&self, seen: &Seen) -> bool {
        seen.course.states.last() == self.course.last()
            && self.gap.as_ref().is_none_or(|(words, _)| seen.gap(words).is_some())
            && seen.has_reported(self.message)
    }

    fn check(&self, seen: &Seen) -> anyhow::Result<()> {
        let mut states = seen.course.states.clone();
        states.dedup();
        ensure!(states == self.course, "the states are {states:?}, not {:?}", self.course);
        ensure!(self.gap.is_some() || seen.gaps.is_empty(), "nothing should be missing: {:?}", seen.gaps);
        seen.check()
    }

    fn shown(&self, seen: &Seen) -> anyhow::Result<String> {
        let (gap, missing) = match &self.gap {
            None => ("none".into(), ""),
            Some((reason, missing)) => {
                let gap = seen.gap(reason).with_context(|| format!("no gap: {reason}; {:?}", seen.gaps))?;
                let (counts, words) = match missing {
                    TimeOnly => (false, "time only"),
                    Counted => (true, "counted"),
                };
                ensure!(gap.lost_readings.is_some() == counts, "{gap:?}");
                let channel = gap.source.split_once('.').map_or(String::new(), |(_, of)| format!("{of}: "));
                (channel + reason, words)
            }
        };
        let row = format!("| {} | {} | {gap} | {missing} | {} |", self.fault, seen.states(), self.message);
        Ok(row.replace('*', "…"))
    }
}
