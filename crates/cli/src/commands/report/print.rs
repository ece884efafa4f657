//! A page becomes a PDF by a browser of this computer.

use anyhow::{Context, bail};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// What `--help` says of it.
pub const HELP: &str = "PDF to print from it, with a Chromium or Chrome of this computer\n\n\
    TRUNNION_BROWSER names the program; without it the usual names are looked for on PATH. The page is complete without.";

/// Environment variable that names the browser.
const NAMED_BY: &str = "TRUNNION_BROWSER";
/// Names under which Debian, Fedora, Google and Microsoft install browsers that print without a screen.
const USUAL: [&str; 6] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge"];
/// A page of 1500 readings prints in 3 s on two busy cores; a browser that does not answer for longer waits for something.
const TIMEOUT: Duration = Duration::from_secs(90);
/// How often is asked whether it is done.
const POLL: Duration = Duration::from_millis(50);

/// Prints `page` to `pdf`.
pub fn pdf(page: &Path, pdf: &Path) -> anyhow::Result<()> {
    let browser = browser()?;
    let page = page.canonicalize().with_context(|| format!("cannot find {}", page.display()))?;
    let pdf = std::path::absolute(pdf).with_context(|| format!("cannot write {}", pdf.display()))?;
    let profile = std::env::temp_dir().join(format!("trunnion-print-{}", std::process::id()));
    let printed = print(&browser, &page, &pdf, &profile);
    // The profile is of no use to anybody; where it is not there, the browser made none.
    std::fs::remove_dir_all(&profile).ok();
    printed?;
    if std::fs::metadata(&pdf).map_or(0, |about| about.len()) == 0 {
        bail!("{} wrote no {}; the page {} is complete", browser.display(), pdf.display(), page.display());
    }
    Ok(())
}

fn browser() -> anyhow::Result<PathBuf> {
    if let Some(named) = std::env::var_os(NAMED_BY) {
        return Ok(named.into());
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path)
        .flat_map(|folder| USUAL.map(|name| folder.join(name)))
        .find(|program| program.is_file());
    found.with_context(|| {
        format!(
            "no browser to print with: none of {} is on PATH, and {NAMED_BY} is not set; \
             the page is written, print it from any browser",
            USUAL.join(", ")
        )
    })
}

fn print(browser: &Path, page: &Path, pdf: &Path, profile: &Path) -> anyhow::Result<()> {
    let mut command = Command::new(browser);
    command
        .args(["--headless", "--disable-gpu", "--no-first-run", "--disable-extensions", "--disable-sync"])
        .args(["--disable-background-networking", "--disable-component-update", "--no-pdf-header-footer"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--print-to-pdf={}", pdf.display()))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    // Chromium has no sandbox for root. The page is our own and has no script.
    if std::fs::metadata("/proc/self").is_ok_and(|about| about.uid() == 0) {
        command.arg("--no-sandbox");
    }
    let child = command.arg(page).spawn();
    let mut child = child.with_context(|| format!("cannot start the browser {}", browser.display()))?;
    wait(&mut child, browser)
}

fn wait(child: &mut Child, browser: &Path) -> anyhow::Result<()> {
    let began = Instant::now();
    loop {
        match child.try_wait().context("waiting for the browser")? {
            Some(status) if status.success() => return Ok(()),
            Some(status) => {
                bail!("{} ended with {status}; the page is written, print it by hand", browser.display())
            }
            None if began.elapsed() > TIMEOUT => {
                child.kill().context("ending the browser")?;
                child.wait().context("ending the browser")?;
                bail!(
                    "{} did not print within {} s; the page is written, print it by hand",
                    browser.display(),
                    TIMEOUT.as_secs()
                );
            }
            // std has no wait for a process with a limit.
            None => std::thread::sleep(POLL),
        }
    }
}
