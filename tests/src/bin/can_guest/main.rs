//! Runs on an emulated computer with a kernel that has SocketCAN (tests/peers/can_machine.sh): the real driver against
//! simulated nodes on the same bus, or against python nodes behind the kernel's own slcan driver.
//!
//! `bus` puts the simulator's nodes on an interface, `way` and `flood` disturb it, `session` is our program's side, `faults` what must
//! follow from each fault, `observer` watches SYNC with a socket of its own, `errors` compares times with the truth.

mod bus;
mod errors;
mod faults;
mod flood;
mod observer;
mod seen;
mod session;
mod way;

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
    // A node that is exchanged shows by its serial number.
    let nodes = NODES.replace("role = \"probe-3\"", "role = \"probe-3\", serial = 1003");
    let mut session = Session::start("vcan0", 10, &nodes);
    session.read_syncs(600, 4).await?;
    println!("FIGURES vcan {}", observer.stop()?);

    // Values go on while the wall clock is set.
    command("date", &["-s", "2031-05-05 05:05:05"])?;
    session.until_log("wall clock was set").await?;
    session.read_syncs(100, 4).await?;
    let reported = "the wall clock was set by … s; stamps of vcan0 in that moment may be some ms off";
    println!("FAULT | wall clock of the computer set | Streaming | none |  | {reported} |");

    let again = faults::matrix(bus, &mut session).await?;
    session.stop().await;
    again.stop()
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

/// Longest wait for anything: a wrong device is asked again after a minute, and an emulated processor is slow.
const LIMIT: Duration = Duration::from_secs(150);
