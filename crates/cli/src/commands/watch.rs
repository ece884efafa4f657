//! `trunnion watch`: what is read at this moment.

use super::setting_up::{Connected, SettingUp};
use crate::outcome::Outcome;
use crate::terminal;
use anyhow::{Context, bail};
use std::path::PathBuf;
use std::time::Duration;
use tokio::time::MissedTickBehavior;
use trunnion::report::{live_line, live_screen, sign_test_text};
use trunnion::results::SignFinding;

/// Show live readings: probes with their ranges, the ball from the centre of the nest, axes, temperatures, devices
///
/// On a terminal the screen is drawn again every second, else a line is printed. `[nest]` may be missing; then the place of the ball is not
/// known. Control-C ends it. With --sign-test the machine is to be jogged by 0.02 to 5 mm along X, then along Y and Z: the probes must
/// follow as the nest says; a probe that is turned or exchanged is named. It ends when nothing is left open; exit code 1 when the probes do
/// not follow as the nest says.
///
/// Example: trunnion watch --config config/trunnion.toml
#[derive(clap::Args)]
pub struct Args {
    /// Configuration: devices, nest, cycle
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// End after so many seconds
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
    /// Jog the machine and see whether the probes follow
    #[arg(long)]
    sign_test: bool,
    /// Print JSON (format trunnion-live/1, one line a second; trunnion-sign-test/1, one line a jog)
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let setting_up = SettingUp::read(&args.config)?;
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    runtime.block_on(async {
        let mut connected = setting_up.connect(args.seconds);
        let ended = match args.sign_test {
            true => sign_test(&setting_up, &mut connected, args.json).await,
            false => watch(&mut connected, args.json).await,
        };
        connected.stop().await;
        ended
    })
}

/// Shows everything once a second until it is over.
async fn watch(connected: &mut Connected, json: bool) -> anyhow::Result<Outcome> {
    let mut second = tokio::time::interval(Duration::from_secs(1));
    second.set_missed_tick_behavior(MissedTickBehavior::Delay);
    second.tick().await;
    loop {
        tokio::select! {
            biased;
            _ = second.tick() => {
                let live = connected.latest.snapshot();
                match json {
                    true => terminal::print_json_line(&live)?,
                    false => terminal::redraw(&live_screen(&live), &live_line(&live))?,
                }
            }
            message = connected.message() => if message.is_none() { return Ok(Outcome::Done) },
        }
    }
}

/// Follows jogs until they say how the probes stand.
async fn sign_test(setting_up: &SettingUp, connected: &mut Connected, json: bool) -> anyhow::Result<Outcome> {
    let mounted = setting_up
        .mounted()
        .context("the configuration has no [nest]; `trunnion calibrate-nest` finds it")?;
    let mut steps = setting_up.steps()?;
    terminal::remark("jog X by 0.1 mm, then Y and Z; wait a second after each");
    let (mut seen, mut last) = (0, None);
    while let Some(message) = connected.message().await {
        connected.step(&message, &mut steps);
        if std::mem::replace(&mut seen, steps.count()) == steps.count() {
            continue;
        }
        let Some(test) = steps.sign_test(&mounted.nest) else { continue };
        if last.as_ref() == Some(&test) {
            continue;
        }
        match json {
            true => terminal::print_json_line(&test)?,
            false => terminal::print(&sign_test_text(&test))?,
        }
        match test.finding {
            SignFinding::AsNest => return Ok(Outcome::Done),
            SignFinding::OtherWay => bail!("the probes do not follow as the nest says"),
            SignFinding::Open | SignFinding::None => last = Some(test),
        }
    }
    match last {
        None => bail!("no jog was seen: {}", connected.latest.snapshot().say),
        Some(test) => bail!("the sign test was not finished: {}", test.say),
    }
}
