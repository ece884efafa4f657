//! Machines and texts from the names and paths that a user gives.

mod holds;
mod text;

use crate::Error;
pub(crate) use holds::{Holds, not_lost};
use std::cell::RefCell;
use std::fs::OpenOptions;
use std::io::Write;
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use trunnion_core::{Problems, names};
use trunnion_machine::{Machine, shipped};

/// A machine file by path, or a shipped machine by name.
///
/// # Errors
/// No such machine, or a machine file with problems.
pub fn machine(name: &str) -> Result<Machine, Error> {
    if Machine::name_of(name) != name {
        return Ok(Machine::parse(Machine::name_of(name), name, &read(Path::new(name))?)?);
    }
    shipped::machine(name).ok_or_else(|| Error::NoSuchMachine {
        name: name.into(),
        allowed: names::allowed(name, shipped::FILES.iter().map(|(name, _)| name)),
    })
}

/// The machine that a file names: by a path from the folder of that file where there is one, else as it is. A name that no shipped machine
/// has is that of a machine file next to the file, as in a cycle that was planned for it.
pub fn next_to(file: &Path, machine: &str) -> String {
    let is_name = Machine::name_of(machine) == machine;
    if is_name && shipped::machine(machine).is_some() {
        return machine.into();
    }
    let near = file.with_file_name(if is_name { format!("{machine}.toml") } else { machine.into() });
    if near.is_file() { near.display().to_string() } else { machine.into() }
}

/// The machine that a file names, and the text of its machine file for the recording.
///
/// # Errors
/// As [`machine()`].
pub fn machine_in(file: &Path, name: &str) -> Result<(Machine, String), Error> {
    let name = next_to(file, name);
    Ok((machine(&name)?, machine_text(&name)?))
}

/// Reads what names its machine in a setup file: a machine file next to that one that is wrong is the error, not a name that nobody knows.
///
/// # Errors
/// The problems of the machine file; else those of what is read.
pub fn with_machines<T>(
    setup: &Path,
    read: impl FnOnce(&dyn Fn(&str) -> Option<Machine>) -> Result<T, Problems>,
) -> Result<T, Error> {
    let wrong = RefCell::new(None);
    let read = read(&|name| match machine(&next_to(setup, name)) {
        Ok(machine) => Some(machine),
        Err(error) => {
            wrong.replace(matches!(error, Error::Problems(_)).then_some(error));
            None
        }
    });
    match wrong.into_inner() {
        Some(error) => Err(error),
        None => Ok(read?),
    }
}

/// The text of a machine by the name or path in a file, for the recording.
///
/// # Errors
/// A file that cannot be read.
pub fn machine_text(name: &str) -> Result<String, Error> {
    match shipped::FILES.iter().find(|(shipped, _)| *shipped == name) {
        Some((_, text)) => Ok((*text).into()),
        None => read(Path::new(name)),
    }
}

/// Reads a text file, UTF-8 or with the mark of UTF-16 at its beginning; the error names it.
///
/// # Errors
/// A file that cannot be read.
pub fn read(path: &Path) -> Result<String, Error> {
    text_of(path, |_| None)
}

/// Reads a table as [`read`]; one in the usual encoding of spreadsheets in Europe (Windows-1252, which has Latin-1 in it) is read too.
///
/// # Errors
/// A file that cannot be read.
pub fn read_table(path: &Path) -> Result<String, Error> {
    text_of(path, text::windows_1252)
}

fn text_of(path: &Path, otherwise: fn(&[u8]) -> Option<String>) -> Result<String, Error> {
    let bytes = std::fs::read(path).map_err(Error::read(path))?;
    text::decoded(bytes, otherwise)
        .map_err(|why| Error::read(path)(std::io::Error::new(std::io::ErrorKind::InvalidData, why)))
}

/// Refuses to write a picture, a PDF or the like in the place of a file that this program reads.
///
/// # Errors
/// Such a file is there.
pub fn may_be_replaced(path: &Path) -> Result<(), Error> {
    not_lost(path, Holds::Other)
}

/// Writes a file whole or not at all: next to it first, then under its name. Whoever could not read the file before can read
/// neither of the two: a configuration may hold a password.
///
/// # Errors
/// A file that cannot be written, or one in its place that this program reads and that is of another kind.
pub fn write_whole(path: &Path, contents: &(impl AsRef<[u8]> + ?Sized)) -> Result<(), Error> {
    let contents = contents.as_ref();
    not_lost(path, Holds::of(contents))?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let unfinished: PathBuf = path.with_file_name(name);
    let write = || {
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(true);
        if let Ok(before) = std::fs::metadata(path) {
            options.mode(before.permissions().mode() & 0o777);
        }
        let mut file = options.open(&unfinished)?;
        file.write_all(contents)?;
        file.sync_all()?;
        std::fs::rename(&unfinished, path)?;
        // The new name is not on the disk before its folder is.
        trunnion_record::sync_folder(path)
    };
    write().map_err(|error| {
        // The half-written file is of no use; the first error is the one to report.
        std::fs::remove_file(&unfinished).ok();
        Error::write(path)(error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_others_cannot_read_stays_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trunnion.toml");
        write_whole(&path, "new").unwrap();
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).unwrap();
        write_whole(&path, "again").unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "again");
    }
}
