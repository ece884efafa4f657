//! One writer for each folder: two services would recover each other's journals and tidy each other's runs.

use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Read, Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

const NAME: &str = ".trunnion.lock";
/// Of a file that is there for a moment, to see whether one can be.
const TRIED: &str = ".trunnion.try";

/// Held while this process writes into a folder; released with it, however it ends.
#[derive(Debug)]
pub struct FolderLock {
    /// The lock is held by the open file.
    file: File,
    path: PathBuf,
}

/// Why the folder is not ours.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process writes there.
    #[error(
        "{} is the folder of another trunnion that runs (process {process}); stop it, or give this one a folder of its own", folder.display()
    )]
    Held {
        /// The folder.
        folder: PathBuf,
        /// Its process.
        process: String,
    },
    /// The system refused.
    #[error("cannot write into the folder {} of the recordings", folder.display())]
    Io {
        /// The folder.
        folder: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
}

impl FolderLock {
    /// Makes the folder and takes it.
    ///
    /// # Errors
    /// When another process has it, or it cannot be written.
    pub fn take(folder: &Path) -> Result<Self, LockError> {
        let refused = |source| LockError::Io { folder: folder.into(), source };
        std::fs::create_dir_all(folder).map_err(refused)?;
        let path = folder.join(NAME);
        let open = File::options().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = open.map_err(refused)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut process = String::new();
                file.read_to_string(&mut process).map_err(refused)?;
                return Err(LockError::Held { folder: folder.into(), process: process.trim().into() });
            }
            Err(TryLockError::Error(source)) => return Err(refused(source)),
        }
        // Who holds it is for a person; a full disk does not hinder.
        let note = file
            .set_len(0)
            .and_then(|()| file.rewind())
            .and_then(|()| writeln!(file, "{}", std::process::id()));
        if let Err(error) = note {
            tracing::debug!(%error, "the lock does not name its process");
        }
        Ok(Self { file, path })
    }

    /// False where another file, or none, is at its place: the folder was removed and made again, and another process would find no lock.
    pub fn is_in_place(&self) -> bool {
        let there = std::fs::metadata(&self.path);
        self.file
            .metadata()
            .is_ok_and(|ours| there.is_ok_and(|there| (ours.dev(), ours.ino()) == (there.dev(), there.ino())))
    }
}

/// Makes a file in the folder and removes it: a disk may have become read-only since the folder was taken.
///
/// # Errors
/// When it cannot be written. A full disk is none: how much is free is looked at apart.
pub(crate) fn try_writing(folder: &Path) -> Result<(), LockError> {
    let path = folder.join(TRIED);
    match File::create(&path).and_then(|_| std::fs::remove_file(&path)) {
        Err(source) if !matches!(source.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded) => {
            Err(LockError::Io { folder: folder.into(), source })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_writer_is_refused_until_the_first_has_gone() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("runs");
        let first = FolderLock::take(&folder).unwrap();
        let refused = FolderLock::take(&folder).unwrap_err().to_string();
        assert!(refused.contains(&format!("(process {})", std::process::id())), "{refused}");
        assert!(first.is_in_place());
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(!first.is_in_place(), "it is no lock any more");
        let again = FolderLock::take(&folder).unwrap();
        assert!(again.is_in_place() && !first.is_in_place());
        assert!(FolderLock::take(&folder).is_err());
        drop(again);
        FolderLock::take(&folder).unwrap();
    }
}
