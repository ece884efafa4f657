//! A page becomes a PDF by a browser of this computer.

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
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

/// Why there is no PDF; the page it would be printed from is there.
#[derive(Debug, thiserror::Error)]
pub enum PrintError {
    /// None is named, and none is where they usually are.
    #[error(
        "no browser to print with: none of {} is on PATH, and {NAMED_BY} is not set; the page is written, print it from any browser",
        USUAL.join(", ")
    )]
    NoBrowser,
    /// A file that cannot be found, or a program that cannot be started.
    #[error("cannot {what} {}", path.display())]
    Io {
        /// What was being done.
        what: &'static str,
        /// To what.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// It failed.
    #[error("{} ended with {status}; the page is written, print it by hand", browser.display())]
    Ended {
        /// The browser.
        browser: PathBuf,
        /// How.
        status: ExitStatus,
    },
    /// It does not answer.
    #[error("{} did not print within {} s; the page is written, print it by hand", browser.display(), TIMEOUT.as_secs())]
    TooSlow {
        /// The browser.
        browser: PathBuf,
    },
    /// The program that asked for it ends.
    #[error("the program ends, and the PDF is not printed")]
    Stopped,
    /// It ended well and wrote nothing.
    #[error("{} wrote no {}; the page is complete", browser.display(), pdf.display())]
    Nothing {
        /// The browser.
        browser: PathBuf,
        /// What it was to write.
        pdf: PathBuf,
    },
}

/// Prints `page` to `pdf`, unless `is_stopped` before it is done.
///
/// # Errors
/// No browser on this computer, or one that does not print.
pub fn pdf(page: &Path, pdf: &Path, is_stopped: &dyn Fn() -> bool) -> Result<(), PrintError> {
    let browser = browser()?;
    let page = page.canonicalize().map_err(io("find", page))?;
    let pdf = std::path::absolute(pdf).map_err(io("write", pdf))?;
    let profile = std::env::temp_dir().join(format!("trunnion-print-{}", std::process::id()));
    let printed = print(&browser, &page, &pdf, &profile, is_stopped);
    // The profile is of no use to anybody; where it is not there, the browser made none.
    std::fs::remove_dir_all(&profile).ok();
    printed?;
    match std::fs::metadata(&pdf).map_or(0, |about| about.len()) {
        0 => Err(PrintError::Nothing { browser, pdf }),
        _ => Ok(()),
    }
}

fn io(what: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> PrintError {
    let path = path.to_owned();
    move |source| PrintError::Io { what, path, source }
}

fn browser() -> Result<PathBuf, PrintError> {
    if let Some(named) = std::env::var_os(NAMED_BY) {
        return Ok(named.into());
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path)
        .flat_map(|folder| USUAL.map(|name| folder.join(name)))
        .find(|program| program.is_file());
    found.ok_or(PrintError::NoBrowser)
}

fn print(
    browser: &Path,
    page: &Path,
    pdf: &Path,
    profile: &Path,
    is_stopped: &dyn Fn() -> bool,
) -> Result<(), PrintError> {
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
    let mut child = command.arg(page).spawn().map_err(io("start the browser", browser))?;
    wait(&mut child, browser, is_stopped)
}

fn wait(child: &mut Child, browser: &Path, is_stopped: &dyn Fn() -> bool) -> Result<(), PrintError> {
    let began = Instant::now();
    loop {
        let ended = child.try_wait().map_err(io("wait for", browser))?;
        let why = match ended {
            Some(status) if status.success() => return Ok(()),
            Some(status) => return Err(PrintError::Ended { browser: browser.into(), status }),
            None if began.elapsed() > TIMEOUT => PrintError::TooSlow { browser: browser.into() },
            None if is_stopped() => PrintError::Stopped,
            None => {
                // std has no wait for a process with a limit.
                std::thread::sleep(POLL);
                continue;
            }
        };
        child.kill().and_then(|()| child.wait()).map_err(io("end", browser))?;
        return Err(why);
    }
}
