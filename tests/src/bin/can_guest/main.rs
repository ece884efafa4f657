//! Runs on an emulated computer with a kernel that has SocketCAN (tests/peers/can_machine.sh): the real driver against
//! simulated nodes on the same bus, or against python nodes behind the kernel's own slcan driver.
//!
//! `bus` puts the simulator's nodes on an interface, `session` is our program's side, `observer` watches SYNC with a
//! socket of its own, `errors` compares times with the truth.

mod bus;
mod errors;
mod observer;
mod session;

use anyhow::{Context, bail, ensure};
use bus::SimulatedBus;
use session::Session;
use std::process::Command;
use std::time::Duration;
use trunnion_acquire::SessionEnd;

fn main() -> anyhow::Result<()> {
    let mode = std::env::args().nth(1).unwrap_or_default();
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    runtime.block_on(async {
        match mode.as_str() {
            "vcan" => vcan().await,
            "kvaser" => kvaser().await,
            "slcan" => slcan().await,
            other => bail!("there is no mode \"{other}\"; allowed: vcan, kvaser, slcan"),
        }
    })
}

/// Four channels of one bus: three probes and a bar.
const NODES: &str = "[{ id = 1, role = \"probe-1\" }, { id = 2, role = \"probe-2\" }, { id = 3, role = \"probe-3\" }, \
                     { id = 5, role = \"bar\" }]";

/// Everything that can happen to an interface, on one without hardware.
async fn vcan() -> anyhow::Result<()> {
    let bus = SimulatedBus::start("vcan0")?;
    let observer = observer::start("vcan0")?;
    let mut session = Session::start("vcan0", 10, NODES);
    session.read_syncs(600, 4).await?;
    println!("FIGURES vcan {}", observer.stop()?);

    // Values go on while the wall clock is set.
    command("date", &["-s", "2031-05-05 05:05:05"])?;
    let reported = session.until_log("wall clock was set").await?;
    session.read_syncs(100, 4).await?;
    println!("FAULT | wall clock of the computer set | none | none | {reported} |");

    bus.switch_off(3);
    let is_silent = |end: &SessionEnd| matches!(end, SessionEnd::Silent { .. });
    let restart = || {
        bus.restart();
        Ok(())
    };
    let end = session.end_and_gap("a node switched off", is_silent, restart).await?;
    ensure!(end.contains("node 3 sends no values"), "{end}");

    bus.report_bus_off()?;
    let is_lost = |end: &SessionEnd| matches!(end, SessionEnd::Disconnected(_));
    let end = session.end_and_gap("bus-off", is_lost, || Ok(())).await?;
    ensure!(end.contains("bus-off") && end.contains("ip link set vcan0 type can restart"), "{end}");

    command("ip", &["link", "set", "vcan0", "down"])?;
    let is_refused = |end: &SessionEnd| matches!(end, SessionEnd::Refused { .. });
    let up = || command("ip", &["link", "set", "vcan0", "up"]);
    let end = session.end_and_gap("interface down", is_refused, up).await?;
    ensure!(end.contains("ip link set vcan0 up type can bitrate"), "{end}");

    command("ip", &["link", "del", "vcan0"])?;
    let is_absent = |end: &SessionEnd| matches!(end, SessionEnd::Absent { .. });
    let mut again = None;
    let add = || {
        command("ip", &["link", "add", "dev", "vcan0", "type", "vcan"])?;
        command("ip", &["link", "set", "vcan0", "up"])?;
        again = Some(SimulatedBus::start("vcan0")?);
        Ok(())
    };
    session.end_and_gap("interface gone, as an adapter unplugged", is_absent, add).await?;
    session.stop().await;
    again.context("the bus began again")?.stop()?;
    Ok(())
}

/// Real controllers and drivers: two cards on one bus.
async fn kvaser() -> anyhow::Result<()> {
    let transport = "CAN interface of the kernel (two emulated Kvaser PCIcan), SYNC stamped by the kernel";
    print!("ALIGNMENT {}", errors::line("can1", "can0", transport).await?);
    let bus = SimulatedBus::start("can1")?;
    let observer = observer::start("can0")?;
    let mut session = Session::start("can0", 10, NODES);
    session.read_syncs(400, 4).await?;
    println!("FIGURES kvaser {}", observer.stop()?);
    // The cable to the nodes is pulled and put back.
    command("ip", &["link", "set", "can1", "down"])?;
    session.end(|end| !matches!(end, SessionEnd::Cancelled)).await?;
    command("ip", &["link", "set", "can1", "up"])?;
    bus.stop()?;
    let again = SimulatedBus::start("can1")?;
    session.until_epoch_after_gap().await?;
    session.stop().await;
    again.stop()
}

/// Nodes of python `canopen`, amplitudes as in `peer_canopen.rs`.
async fn slcan() -> anyhow::Result<()> {
    let observer = observer::start("sl0")?;
    let mut session = Session::start("sl0", 50, &NODES.replace("id = 5", "id = 4"));
    let values = session.read_syncs(150, 4).await?;
    println!("FIGURES slcan {}", observer.stop()?);
    for (channel, centre, amplitude) in [(0, 0.0, 0.05), (1, 0.0, 0.04), (2, 0.0, 0.03), (3, 100.0, 0.02)] {
        let of = values.iter().filter(|value| value.channel == channel);
        let farthest = of.map(|value| (value.value_mm - centre).abs()).fold(0.0, f64::max);
        let expected = 0.5 * amplitude..=amplitude + 1e-9;
        ensure!(expected.contains(&farthest), "channel {channel}: {farthest} of {amplitude}");
    }
    session.stop().await;
    Ok(())
}

fn command(program: &str, arguments: &[&str]) -> anyhow::Result<()> {
    let status =
        Command::new(program).args(arguments).status().with_context(|| format!("running {program}"))?;
    ensure!(status.success(), "{program} {arguments:?}: {status}");
    Ok(())
}

/// Longest wait for anything: an emulated processor is slow.
const LIMIT: Duration = Duration::from_secs(60);
