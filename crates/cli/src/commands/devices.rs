//! `trunnion devices`: what is connected, the lines for the configuration, and what to do where something is wrong.

mod check;
mod show;

use crate::outcome::Outcome;
use crate::terminal;
use anyhow::Context;
use std::path::PathBuf;
use tokio::task::JoinSet;
use trunnion_acquire::discovery::{Look, Place, look, places, servers};
use trunnion_acquire::drivers::DRIVERS;

/// List ports and CAN interfaces, ask what answers there or on the network, and print the lines for the configuration
///
/// Only questions that change nothing are sent; they are listed with the answer. A port that another program uses is
/// left alone. With --config the devices of a configuration are connected as the service connects them.
///
/// Example: trunnion devices --port /dev/ttyUSB0 --url opc.tcp://192.168.1.10:4840
#[derive(clap::Args)]
pub struct Args {
    /// Ask only at this serial port (may be given several times; pseudo-terminals too)
    #[arg(long, value_name = "PATH")]
    port: Vec<String>,
    /// Ask only at this address on the network: http://HOST:PORT (MTConnect), opc.tcp://HOST:PORT, linuxcnc://HOST:PORT, or
    /// a HOST alone, which is asked in all these ways (may be given several times)
    #[arg(long, value_name = "URL")]
    url: Vec<String>,
    /// Ask only as this driver does
    #[arg(long, value_name = "NAME", value_parser = driver_names())]
    driver: Option<String>,
    /// Connect the devices of this configuration and show their first readings
    #[arg(long, value_name = "FILE", conflicts_with_all = ["port", "url", "driver"])]
    config: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

fn driver_names() -> Vec<&'static str> {
    DRIVERS.iter().map(|driver| driver.name).collect()
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    if let Some(path) = &args.config {
        return runtime.block_on(check::run(path, args.json));
    }
    let mut chosen: Vec<Place> = args.port.iter().map(|path| Place::serial_port(path)).collect();
    for address in &args.url {
        chosen.extend(servers(address, args.driver.as_deref())?);
    }
    if chosen.is_empty() {
        chosen = places().context("cannot list the serial ports")?;
    }
    let looks = runtime.block_on(look_at(chosen, args.driver.clone()));
    if args.json {
        terminal::print_json(&show::value(&looks))?
    } else {
        terminal::print(&show::text(&looks))?;
        terminal::print_verbatim(&show::lines_to_paste(&looks))?
    }
    Ok(Outcome::Done)
}

/// All places at once, in the order given.
async fn look_at(places: Vec<Place>, only: Option<String>) -> Vec<Look> {
    let mut tasks = JoinSet::new();
    for (index, place) in places.into_iter().enumerate() {
        let only = only.clone();
        tasks.spawn(async move { (index, look(place, only.as_deref()).await) });
    }
    let mut looks = tasks.join_all().await;
    looks.sort_by_key(|(index, _)| *index);
    looks.into_iter().map(|(_, look)| look).collect()
}
