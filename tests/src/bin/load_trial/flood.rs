//! The trial with its page attacked: one cycle in quiet, the same cycle while others attack the page, side by side.

use crate::attack::Attempts;
use crate::readers::{self, Received};
use crate::table;
use crate::{Order, Trial, severest, trial, verdict};
use anyhow::{Context, bail};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use trunnion_tests::page_status::free_address;
use trunnion_tests::pauses::Pauses;

/// From the start of the program to the first attack, s: the page is there, and its reader reads.
const QUIET_S: f64 = 5.0;

/// The page of a trial.
pub struct Page {
    /// Where it is.
    pub address: String,
    /// Others attack it.
    pub is_attacked: bool,
}

/// What somebody at the page saw.
pub struct AtPage {
    /// A browser that reads its events.
    pub reader: Arc<Received>,
    /// What the attackers got.
    pub attempts: Attempts,
}

/// The page's reader and its attackers while a cycle is measured.
pub struct Visitors {
    reader: Arc<Received>,
    reading: tokio::task::JoinHandle<()>,
    attackers: Option<Child>,
}

impl Visitors {
    /// They come when the program begins, and the attackers go before it ends.
    pub fn start(page: &Page, duration_s: f64) -> anyhow::Result<Self> {
        let reader = Arc::<Received>::default();
        let reading = tokio::spawn(readers::page(page.address.clone(), reader.clone()));
        let seconds = duration_s - 2.0 * QUIET_S;
        let attack = || -> anyhow::Result<Child> {
            let program = std::env::current_exe().context("where is this program?")?;
            let (after, seconds) = (QUIET_S.to_string(), seconds.to_string());
            let mut command = Command::new(program);
            command.args(["attack", &page.address, "--after", &after, "--seconds", &seconds]);
            command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().context("cannot start the attackers")
        };
        let attackers = if page.is_attacked { Some(attack()?) } else { None };
        Ok(Self { reader, reading, attackers })
    }

    /// What they saw.
    pub async fn leave(self) -> anyhow::Result<AtPage> {
        self.reading.abort();
        let attempts = match self.attackers {
            None => Attempts::new(),
            Some(child) => {
                let ended = tokio::task::spawn_blocking(|| child.wait_with_output()).await??;
                if !ended.status.success() {
                    bail!("the attackers failed: {}", ended.status);
                }
                serde_json::from_slice(&ended.stdout).context("the attackers said something else")?
            }
        };
        Ok(AtPage { reader: self.reader, attempts })
    }
}

/// Both cycles; the exit code of the worse one.
pub fn run(seconds: f64, recordings: &Path, markdown: Option<&Path>) -> anyhow::Result<i32> {
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    let one = |is_attacked: bool| -> anyhow::Result<(Trial, i32)> {
        let folder = tempfile::tempdir().context("cannot make a folder for ports")?;
        let place = recordings.join(if is_attacked { "attacked" } else { "quiet" });
        std::fs::create_dir_all(&place).with_context(|| format!("cannot make {}", place.display()))?;
        let (page, pauses) = (Page { address: free_address(), is_attacked }, Pauses::watch());
        let order = Order { seconds, page: Some(&page), ..Order::full(folder.path(), &place) };
        let trial = runtime.block_on(trial(order))?;
        let code = verdict(&trial, pauses.longest());
        Ok((trial, code))
    };
    let ((quiet, before), (attacked, code)) = (one(false)?, one(true)?);
    let text = table::flood(&quiet, &attacked);
    print!("{text}");
    if let Some(path) = markdown {
        std::fs::write(path, &text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(severest(before, code))
}
