//! Files that commands write, and findings shown, written as JSON or put on a page.

use crate::terminal;
use anyhow::{Context, bail};
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use trunnion::Error;
use trunnion::report::{findings_html, findings_text};
use trunnion::results::Findings;

/// Refuses outputs, each with its option, that are files the command reads, under whatever name.
///
/// # Errors
/// The first of them.
pub fn not_an_input<'a>(
    outputs: &[(&str, Option<&Path>)],
    inputs: impl IntoIterator<Item = &'a Path> + Clone,
) -> anyhow::Result<()> {
    for &(option, output) in outputs {
        let Some(output) = output else { continue };
        if let Some(input) = inputs.clone().into_iter().find(|input| is_same(input, output)) {
            bail!(
                "{option} {} would take the place of {}, which this command reads: nothing was written. Name another file",
                output.display(),
                input.display()
            );
        }
    }
    Ok(())
}

/// Two names of one file.
fn is_same(one: &Path, other: &Path) -> bool {
    let place = |path: &Path| {
        let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
        Some((about.dev(), about.ino()))
    };
    place(one).is_some_and(|there| place(other) == Some(there))
}

/// Writes a file whole or not at all, and not in the place of a file of another kind that this program reads. A pipe or a device takes what
/// is written as it comes, and so does a file whose folder takes no other next to it.
pub fn write(path: &Path, contents: &(impl AsRef<[u8]> + ?Sized)) -> anyhow::Result<()> {
    let contents = contents.as_ref();
    let in_place =
        || std::fs::write(path, contents).with_context(|| format!("cannot write {}", path.display()));
    // /dev/stdout may lead to a file that is open.
    let is_open = path.starts_with("/dev") || path.starts_with("/proc");
    // A symbolic link stays, and what it leads to is written, there or not yet. A hard link keeps the old text.
    let place = path.canonicalize().ok();
    let is_link_to_nothing = place.is_none() && path.is_symlink();
    let place = place.unwrap_or_else(|| path.into());
    let is_file = std::fs::metadata(&place).map_or(true, |about| about.is_file());
    if is_open || is_link_to_nothing || !is_file {
        return in_place();
    }
    match trunnion::files::write_whole(&place, contents) {
        Err(Error::Write { source, .. }) if place.exists() && is_of_folder(source.kind()) => in_place(),
        written => Ok(written?),
    }
}

/// Why a folder takes no further file: its rights, a file system that is only read, a file that is mounted by itself, a name that
/// would be too long. A full disk is none of these: it would cost the old file too.
fn is_of_folder(refused: ErrorKind) -> bool {
    use ErrorKind::{InvalidFilename, PermissionDenied, ReadOnlyFilesystem, ResourceBusy};
    matches!(refused, InvalidFilename | PermissionDenied | ReadOnlyFilesystem | ResourceBusy)
}

/// Says which page was written, if any.
pub fn report_page(page: Option<&Path>) -> anyhow::Result<()> {
    page.map_or(Ok(()), |page| terminal::print(&format!("page: {}\n", page.display())))
}

/// Prints what a method found as text or JSON, after its page where one is asked for.
pub fn findings(findings: &Findings, page: Option<&Path>, json: bool) -> anyhow::Result<()> {
    if let Some(path) = page {
        write(path, &findings_html(findings, &trunnion::page::label()))?;
    }
    if json {
        return terminal::print_json(findings);
    }
    terminal::print(&findings_text(findings))?;
    report_page(page)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_is_known_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let [run, link, hard, new] = ["run.mcap", "link", "hard", "new"].map(|name| folder.path().join(name));
        std::fs::write(&run, "").unwrap();
        std::os::unix::fs::symlink(&run, &link).unwrap();
        std::fs::hard_link(&run, &hard).unwrap();
        for output in [&run, &link, &hard] {
            let refused = not_an_input(&[("-o", Some(output))], [run.as_path()]).unwrap_err().to_string();
            assert!(refused.starts_with("-o ") && refused.contains("Name another file"), "{refused}");
        }
        not_an_input(&[("-o", Some(&new)), ("--html", None)], [run.as_path()]).unwrap();
        not_an_input(&[("-o", Some(Path::new("/dev/null")))], [Path::new("/dev/null")]).unwrap();
    }

    #[test]
    fn a_file_is_written_whole_and_what_stands_next_to_it_goes() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("page.html"), folder.path().join("link.html"));
        std::fs::write(&file, "old").unwrap();
        let open = std::fs::File::open(&file).unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, "new").unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
        assert!(link.is_symlink(), "the link stays");
        // Whoever reads the old one has all of it.
        assert_eq!(std::io::read_to_string(open).unwrap(), "old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
        let gone = folder.path().join("none/page.html");
        assert!(write(&gone, "new").unwrap_err().to_string().contains("none/page.html"));
    }

    #[test]
    fn a_file_is_written_where_no_other_can_be_made_next_to_it() {
        let folder = tempfile::tempdir().unwrap();
        // Longest name that a file may have [POSIX NAME_MAX of Linux]: a longer one, for the file next to it, is refused.
        let file = folder.path().join("x".repeat(255));
        std::fs::write(&file, "old").unwrap();
        write(&file, "new").unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
    }

    #[test]
    fn a_link_stays_where_it_leads_to_nothing_yet() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("page.html"), folder.path().join("link.html"));
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, "new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
    }

    #[test]
    fn a_pipe_and_a_device_take_the_text() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read_to_string(pipe).unwrap()
        });
        write(&pipe, "a page").unwrap();
        assert_eq!(reader.join().unwrap(), "a page");
        write(Path::new("/dev/null"), "a page").unwrap();
    }
}
