//! The file of a journal: named, created, locked, brought to the disk, and looked for at its place.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Ending of a journal, after the name of the finished file.
pub const JOURNAL_ENDING: &str = ".active";

/// True for the name of a journal.
pub fn is_journal(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == &JOURNAL_ENDING[1..])
}

/// What a journal is written to.
pub trait JournalFile: Write + Seek + Send {}
impl<F: Write + Seek + Send> JournalFile for F {}

/// A file to write to and a second way to it, which brings what was written to the disk.
pub type Opened = (Box<dyn JournalFile>, Box<dyn Fn() -> io::Result<()> + Send>);

/// How journals are opened; tests put a full disk here.
pub type OpenJournal = Box<dyn FnMut(&Path) -> io::Result<Opened> + Send>;

/// Creates a new file that is there after a power cut, and locks it. Bringing it to the disk also looks whether it is still there:
/// [`is_not_there`] of the error when it is not.
pub fn open_locked(path: &Path) -> io::Result<Opened> {
    let file = create_ready(path, |file| file.try_lock().map_err(io::Error::from).and(sync_folder(path)))?;
    let (same, path) = (file.try_clone()?, path.to_owned());
    let (is_unknown, cannot_sync) = (Cell::new(false), Cell::new(false));
    Ok((
        Box::new(file),
        Box::new(move || {
            match same.sync_data() {
                Err(why) if never_syncs(&why) => {
                    if !cannot_sync.replace(true) {
                        let path = path.display();
                        tracing::warn!(
                            "{path} cannot be synced, a power cut may cost more than 0.1 s: {why}"
                        );
                    }
                }
                synced => synced?,
            }
            let found = in_place(&same, &path);
            let unknown = found.as_ref().err().filter(|why| !is_not_there(why));
            let Some(why) = unknown else {
                is_unknown.set(false);
                return found;
            };
            // What was written is on the disk all the same.
            if !is_unknown.replace(true) {
                tracing::warn!("cannot look whether {} is still there: {why}", path.display());
            }
            Ok(())
        }),
    ))
}

/// True of a file system that has no sync (fsync(2)): another file would be refused as well, so recording goes on in this one.
fn never_syncs(why: &io::Error) -> bool {
    matches!(why.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported)
}

/// Creates a new file; one that cannot be made ready goes again.
fn create_ready(path: &Path, make_ready: impl FnOnce(&File) -> io::Result<()>) -> io::Result<File> {
    let file = File::options().write(true).create_new(true).open(path)?;
    if let Err(why) = make_ready(&file) {
        remove_unready(path);
        return Err(why);
    }
    Ok(file)
}

/// Removes a file that could not be begun or ended, or its name would be taken at every further attempt.
pub fn remove_unready(path: &Path) {
    if let Err(left) = std::fs::remove_file(path) {
        tracing::warn!("cannot remove {}: {left}", path.display());
    }
}

/// True where the system says that there is no such file; one that cannot be looked for may be there.
pub fn is_not_there(why: &io::Error) -> bool {
    matches!(why.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

/// Brings the name of a file to the disk.
pub fn sync_folder(file: &Path) -> io::Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match File::open(folder)?.sync_all() {
        // Several file systems on the network have none for folders.
        Err(why) if never_syncs(&why) => Ok(()),
        synced => synced,
    }
}

/// A file that was removed, or whose folder was, takes what is written to it without a word. Only a file without a name that is
/// not the one at its place counts: file systems on the network count names and number files as they like.
fn in_place(file: &File, path: &Path) -> io::Result<()> {
    let (ours, there) = (file.metadata()?, std::fs::metadata(path)?);
    let is_another = ours.nlink() == 0 && ours.ino() != there.ino();
    if is_another { Err(io::ErrorKind::NotFound.into()) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_made_ready_leaves_its_name_free() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.mcap.active");
        let refused = create_ready(&path, |_| Err(io::ErrorKind::StorageFull.into())).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::StorageFull);
        assert!(!path.exists());
        assert!(open_locked(&path).is_ok());
    }

    #[test]
    fn a_file_without_sync_is_no_disk_that_refuses() {
        let (socket, _other) = std::os::unix::net::UnixStream::pair().unwrap();
        let without = File::from(std::os::fd::OwnedFd::from(socket));
        assert!(never_syncs(&without.sync_data().unwrap_err()));
        assert!(!never_syncs(&io::ErrorKind::StorageFull.into()));
        assert!(!never_syncs(&io::Error::from_raw_os_error(5)), "an error of the disk");
    }

    #[test]
    fn a_journal_that_cannot_be_looked_for_is_on_the_disk_and_one_that_is_not_there_is_gone() {
        let place = tempfile::tempdir().unwrap();
        let (folder, other) = (place.path().join("runs"), place.path().join("elsewhere"));
        std::fs::create_dir(&folder).unwrap();
        let (_file, sync) = open_locked(&folder.join("r.mcap.active")).unwrap();
        sync().unwrap();
        std::fs::rename(&folder, &other).unwrap();
        assert!(is_not_there(&sync().unwrap_err()));
        std::fs::write(&folder, "").unwrap();
        assert!(is_not_there(&sync().unwrap_err()), "a file stands where the folder was");
        std::fs::remove_file(&folder).unwrap();
        std::os::unix::fs::symlink(&folder, &folder).unwrap();
        sync().unwrap();
    }
}
