//! `trunnion open`: recordings on the page, without a service.

use super::daemon::{analyst, asked_to_stop};
use crate::outcome::Outcome;
use crate::terminal;
use anyhow::{Context, bail};
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;
use trunnion::results::Serves;
use trunnion_core::Clock;
use trunnion_service::analysis::AnalysisLimits;
use trunnion_service::board::Board;
use trunnion_service::clock::SystemClock;
use trunnion_service::page;

/// Show recordings on a page for the browser of this computer
///
/// Example: trunnion open run.mcap
///
/// The address is printed; open it in a browser. Effects are added to NAME.model.toml next to the recording. Ctrl-C ends it.
#[derive(clap::Args)]
pub struct Args {
    /// Recordings (.mcap), points (.csv), or one folder of recordings
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Model file of runs that have none of their own; the base model without it
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Address of this computer and port; port 0 takes a free one
    #[arg(long, value_name = "ADDRESS:PORT", default_value = page::USUAL_ADDRESS)]
    listen: String,
    /// Memory that the analyses may take
    #[arg(long, value_name = "MB", value_parser = |text: &str| within(text, AnalysisLimits::MEMORY_MB))]
    memory_mb: Option<f64>,
    /// Time that an analysis may take
    #[arg(long, value_name = "SECONDS", value_parser = |text: &str| within(text, AnalysisLimits::TIME_S))]
    time_s: Option<f64>,
}

fn within(text: &str, allowed: RangeInclusive<f64>) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| allowed.contains(number));
    number.ok_or_else(|| format!("allowed: {}..={}", allowed.start(), allowed.end()))
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let missing = args.runs.iter().find(|run| !run.exists());
    if let Some(run) = missing {
        bail!("there is no {}", run.display());
    }
    let usual = AnalysisLimits::default();
    let limits = AnalysisLimits {
        memory_mb: args.memory_mb.unwrap_or(usual.memory_mb),
        time: args.time_s.map_or(usual.time, Duration::from_secs_f64),
        ..usual
    };
    let analyst = page_analyst(limits)?;
    let runs = match args.runs.as_slice() {
        [folder] if folder.is_dir() => page::Runs::of_folder(folder, args.model.clone(), analyst),
        files => page::Runs::of_files(files.to_vec(), args.model.clone(), analyst),
    };
    let file_name = |run: &PathBuf| run.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = args.runs.iter().filter_map(file_name).collect::<Vec<_>>().join(", ");
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    runtime.block_on(async {
        let shared = page::Shared {
            serves: Serves::Recordings,
            name,
            runs: Arc::new(runs),
            board: Board::default(),
            cycles: Vec::new(),
            set_up: None,
            clock: Arc::new(SystemClock::start()) as Arc<dyn Clock>,
        };
        serve_until_interrupted(listen(&args.listen).await?, shared).await?;
        Ok(Outcome::Done)
    })
}

/// Who analyses for a page: this program, within limits.
pub fn page_analyst(limits: AnalysisLimits) -> anyhow::Result<page::PageAnalyst> {
    Ok(page::PageAnalyst::new(analyst()?, limits, Arc::new(SystemClock::start())))
}

/// Listens on an address of this computer; where the usual one is taken, a free port is.
pub async fn listen(text: &str) -> anyhow::Result<TcpListener> {
    let mut address = page::address(text)?;
    match TcpListener::bind(address).await {
        Ok(listener) => Ok(listener),
        Err(error) if error.kind() == std::io::ErrorKind::AddrInUse && text == page::USUAL_ADDRESS => {
            address.set_port(0);
            TcpListener::bind(address).await.with_context(|| format!("cannot listen on {address}"))
        }
        Err(error) => Err(error).with_context(|| format!("cannot listen on {address}")),
    }
}

/// Prints the address and serves until Ctrl-C or SIGTERM: what analyses ends too.
pub async fn serve_until_interrupted(listener: TcpListener, shared: page::Shared) -> anyhow::Result<()> {
    let asked_to_stop = asked_to_stop()?;
    terminal::print(&format!("The page is at http://{}   (Ctrl-C ends it)\n", listener.local_addr()?))?;
    let cancel = CancellationToken::new();
    let serving =
        tokio::spawn(page::serve(listener, Arc::new(shared), page::Access::this_computer(), cancel.clone()));
    asked_to_stop.await;
    cancel.cancel();
    serving.await.context("the page ended badly")?.context("the page ended")
}
