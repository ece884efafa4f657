//! A page becomes a PDF by a browser of this computer.

use crate::storage::free_mb;
use std::fs::DirBuilder;
use std::io::{ErrorKind, Read};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use trunnion::report::Language;

/// What `--help` says of it.
pub const HELP: &str = "PDF to print from it, with a Chromium or Chrome of this computer\n\n\
    TRUNNION_BROWSER names the program; without it the usual names are looked for on PATH. The page is complete without.";

/// Environment variable that names the browser.
const NAMED_BY: &str = "TRUNNION_BROWSER";
/// Names under which Debian, Fedora, Google and Microsoft install browsers that print without a screen.
const USUAL: [&str; 6] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge"];
/// Where Debian has the program itself. `chromium` on PATH is a script there, which ends where /proc/cpuinfo is hidden, as it is from the
/// service (`ProcSubset=pid`).
const OF_DEBIAN: &str = "/usr/lib/chromium/chromium";
/// What lets it print where processes may neither get rights nor namespaces, nor memory that is written and run: no sandbox of its own,
/// no process that forks the others out of one, no compiler of scripts. The page is our own and has no script.
const CONFINED: [&str; 3] = ["--no-sandbox", "--no-zygote", "--js-flags=--jitless"];
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
    #[error(
        "{} wrote no PDF; {free_mb:.0} MB are free in {}, where it writes; the page is complete",
        browser.display(),
        folder.display()
    )]
    Nothing {
        /// The browser.
        browser: PathBuf,
        /// Where it was to write.
        folder: PathBuf,
        /// Free there, MB.
        free_mb: f64,
    },
    /// It ended well and wrote the beginning of a PDF: Chromium does not look at what a write answers.
    #[error(
        "the PDF of {} ends after {bytes} bytes, before its end: {free_mb:.0} MB are free in {}, where it writes; make room there, or set \
         TMPDIR to a folder with more, and print again; the page is written",
        browser.display(),
        folder.display()
    )]
    Cut {
        /// The browser.
        browser: PathBuf,
        /// What is there.
        bytes: usize,
        /// Where.
        folder: PathBuf,
        /// Free there, MB.
        free_mb: f64,
    },
}

/// The PDF of `page`, whole, unless `is_stopped` before it is done. A browser does not say that a disk is full: it writes into a folder of
/// its own, and whoever keeps the PDF learns what became of it from the write.
///
/// # Errors
/// No browser on this computer, or one that does not print.
pub fn pdf(page: &Path, is_stopped: &dyn Fn() -> bool) -> Result<Vec<u8>, PrintError> {
    let is_confined = std::fs::read_to_string("/proc/self/status").is_ok_and(|status| confines(&status));
    let browser = browser(is_confined)?;
    let page = page.canonicalize().map_err(io("find", page))?;
    let profile = std::env::temp_dir().join(format!("trunnion-print-{}", std::process::id()));
    let printed = print_in(&profile, &browser, &page, is_confined, is_stopped);
    // The profile is of no use to anybody; where it is not there, nothing was begun.
    std::fs::remove_dir_all(&profile).ok();
    printed
}

fn print_in(
    profile: &Path,
    browser: &Path,
    page: &Path,
    is_confined: bool,
    is_stopped: &dyn Fn() -> bool,
) -> Result<Vec<u8>, PrintError> {
    // One of another process of this number, or of somebody who guessed the name, is none of ours.
    std::fs::remove_dir_all(profile).ok();
    DirBuilder::new().mode(0o700).create(profile).map_err(io("make", profile))?;
    let pdf = profile.join("printed.pdf");
    let mut command = command(browser, page, &pdf, profile, is_confined);
    let mut child = command.spawn().map_err(io("start the browser", browser))?;
    wait(&mut child, browser, is_stopped)?;
    let printed = match std::fs::read(&pdf) {
        Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
        read => read.map_err(io("read", &pdf))?,
    };
    if is_whole(&printed) {
        return Ok(printed);
    }
    let (browser, folder) = (browser.to_owned(), std::env::temp_dir());
    let free_mb = free_mb(&folder).map_err(io("ask for the room in", &folder))?;
    Err(match printed.len() {
        0 => PrintError::Nothing { browser, folder, free_mb },
        bytes => PrintError::Cut { browser, bytes, folder, free_mb },
    })
}

/// A PDF ends with this mark, with at most a line break behind it [ISO 32000-1, 7.5.5].
fn is_whole(pdf: &[u8]) -> bool {
    pdf.trim_ascii_end().ends_with(b"%%EOF")
}

/// What the PDF of `page` lacks on this computer: characters of its language that the browser has no font for, and draws as boxes.
///
/// # Errors
/// As [`pdf`].
pub fn lacks(page: &Path, is_stopped: &dyn Fn() -> bool) -> Result<Option<String>, PrintError> {
    let text = std::fs::read_to_string(page).map_err(io("read", page))?;
    let is_of = |code: &str| text.contains(&format!("<html lang=\"{code}\">"));
    let language = Language::NAMES.into_iter().find(|(code, _)| is_of(code)).map(|(_, language)| language);
    let Some((name, characters)) = language.and_then(Language::of_other_fonts) else { return Ok(None) };
    Ok((!draws_apart(characters, is_stopped)?).then(|| {
        format!(
            "the browser that prints has no font with {name} characters, and boxes stand in their place; install one (Debian: \
             fonts-noto-cjk) and print again, or print the page where there is one"
        )
    }))
}

/// True where the browser draws two characters differently: without a font for them both are the same box.
fn draws_apart(characters: [char; 2], is_stopped: &dyn Fn() -> bool) -> Result<bool, PrintError> {
    let is_confined = std::fs::read_to_string("/proc/self/status").is_ok_and(|status| confines(&status));
    let browser = browser(is_confined)?;
    let profile = std::env::temp_dir().join(format!("trunnion-font-{}", std::process::id()));
    let mut command = bare_command(&browser, &profile, is_confined);
    command.arg("--dump-dom").arg(probe(characters)).stdout(Stdio::piped());
    let started = command.spawn().map_err(io("start the browser", &browser));
    let said = started.and_then(|mut child| {
        wait(&mut child, &browser, is_stopped)?;
        let mut said = String::new();
        // A page of a few lines fits the pipe.
        let out = child.stdout.take().map(|mut out| out.read_to_string(&mut said));
        out.transpose().map_err(io("read from", &browser))?;
        Ok(said)
    });
    std::fs::remove_dir_all(&profile).ok();
    Ok(!said?.contains("data-same=\"true\""))
}

/// The address of a page that says whether two characters look the same.
fn probe([one, other]: [char; 2]) -> String {
    let page = format!(
        "<body><canvas></canvas><script>const draw=(code)=>{{const on=document.querySelector('canvas').getContext('2d');\
         on.clearRect(0,0,99,99);on.font='40px sans-serif';on.fillText(String.fromCodePoint(code),5,60);\
         return on.getImageData(0,0,99,99).data.join()}};\
         document.body.dataset.same=draw({})===draw({})</script>",
        u32::from(one),
        u32::from(other)
    );
    let escaped: String = page.bytes().map(|byte| format!("%{byte:02X}")).collect();
    format!("data:text/html,{escaped}")
}

fn io(what: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> PrintError {
    let path = path.to_owned();
    move |source| PrintError::Io { what, path, source }
}

/// True of a process that can neither gain rights nor call everything, as under our unit, from what /proc says of it. The sandbox of a
/// browser cannot begin there, and that of the unit holds the browser too.
fn confines(status: &str) -> bool {
    let is = |key: &str, value: &str| {
        status.lines().any(|line| line.strip_prefix(key).is_some_and(|rest| rest.trim() == value))
    };
    is("NoNewPrivs:", "1") && is("Seccomp:", "2")
}

fn browser(is_confined: bool) -> Result<PathBuf, PrintError> {
    if let Some(named) = std::env::var_os(NAMED_BY) {
        return Ok(named.into());
    }
    if is_confined && Path::new(OF_DEBIAN).is_file() {
        return Ok(OF_DEBIAN.into());
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path)
        .flat_map(|folder| USUAL.map(|name| folder.join(name)))
        .find(|program| program.is_file());
    found.ok_or(PrintError::NoBrowser)
}

fn command(browser: &Path, page: &Path, pdf: &Path, profile: &Path, is_confined: bool) -> Command {
    let mut command = bare_command(browser, profile, is_confined);
    command.arg("--no-pdf-header-footer").arg(format!("--print-to-pdf={}", pdf.display())).arg(page);
    command
}

/// What is asked of it comes after.
fn bare_command(browser: &Path, profile: &Path, is_confined: bool) -> Command {
    let mut command = Command::new(browser);
    command
        .args(["--headless", "--disable-gpu", "--no-first-run", "--disable-extensions", "--disable-sync"])
        .args(["--disable-background-networking", "--disable-component-update"])
        .arg(format!("--user-data-dir={}", profile.display()))
        // Reports of its own crashes go with the profile.
        .env("CHROME_CONFIG_HOME", profile)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if is_confined {
        command.args(CONFINED);
    } else if std::fs::metadata("/proc/self").is_ok_and(|about| about.uid() == 0) {
        // Chromium has no sandbox for root.
        command.arg("--no-sandbox");
    }
    command
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_browser_under_the_restrictions_of_the_unit_is_started_without_a_sandbox_of_its_own() {
        let status = |no_new: u8, seccomp: u8| {
            format!("Name:\ttrunnion\nNoNewPrivs:\t{no_new}\nSeccomp:\t{seccomp}\nSeccomp_filters:\t9\n")
        };
        assert!(confines(&status(1, 2)));
        assert!(
            ![(0, 0), (1, 0), (0, 2)].iter().any(|&(no_new, seccomp)| confines(&status(no_new, seccomp)))
        );
        let path = Path::new("x");
        let has = |is_confined, flag: &str| {
            command(path, path, path, path, is_confined).get_args().any(|given| given == flag)
        };
        assert!(CONFINED.iter().all(|flag| has(true, flag)));
        assert!(!has(false, "--no-zygote"));
    }
}
