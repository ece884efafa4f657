//! The demo for a browser: what is measured while it is measured, then the recordings.

use crate::commands::daemon::asked_to_stop;
use crate::commands::open::{listen, page_analyst};
use anyhow::Context;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use trunnion::Machine;
use trunnion::cycles::Cycle;
use trunnion::results::Serves;
use trunnion_service::analysis::AnalysisLimits;
use trunnion_service::board::Board;
use trunnion_service::clock::SystemClock;
use trunnion_service::page;

/// A page that is served next to the demo.
pub struct DemoPage {
    address: SocketAddr,
    cancel: CancellationToken,
    serving: JoinHandle<std::io::Result<()>>,
}

impl DemoPage {
    /// Serves what `board` gets and the recordings of `folder`.
    pub async fn start(
        folder: &Path,
        machine: &Machine,
        cycles: &[Cycle],
        board: &Board,
    ) -> anyhow::Result<Self> {
        let listener = listen(page::USUAL_ADDRESS).await?;
        let address = listener.local_addr()?;
        let shared = page::Shared {
            serves: Serves::Demo,
            name: "demo".into(),
            runs: Arc::new(page::Runs::of_folder(folder, None, page_analyst(AnalysisLimits::default())?)),
            board: board.clone(),
            cycles: cycles.iter().map(|cycle| page::page_cycle(machine, cycle, "")).collect(),
            set_up: None,
            clock: Arc::new(SystemClock::start()),
        };
        let cancel = CancellationToken::new();
        let serving = tokio::spawn(page::serve(
            listener,
            Arc::new(shared),
            page::Access::this_computer(),
            cancel.clone(),
        ));
        Ok(Self { address, cancel, serving })
    }

    /// Where it is.
    pub fn address(&self) -> String {
        format!("http://{}", self.address)
    }

    /// Goes on until Ctrl-C; `show` prints where.
    pub async fn until_interrupted(self, show: impl Fn(&str) -> anyhow::Result<()>) -> anyhow::Result<()> {
        show(&format!("The page stays at {}   (Ctrl-C ends it)\n", self.address()))?;
        asked_to_stop()?.await;
        self.cancel.cancel();
        self.serving.await.context("the page ended badly")?.context("the page ended")
    }
}
