//! A folder of the program with what was worked out, a file each: `DIGEST.kept`, the digest of what it is of.
//!
//! ```text
//! DIGEST of what it is of, SHA-256 of the text
//! text
//! ```
//!
//! A file that is cut, damaged or of something else is none. Nothing is synced to the disk: a file that a power cut damages is none either.

use crate::identity;
use std::fs::{self, DirBuilder, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;

/// Bytes of all files, at most: some hundred fits of 336 points with what follows from them.
const MOST_BYTES: u64 = 64 << 20;
/// What a process may write before it looks how many there are.
const UNSEEN_BYTES: u64 = MOST_BYTES / 16;
/// Of one file, at most: a fit of 20 000 points.
const LARGEST_BYTES: u64 = MOST_BYTES / 4;

const ENDING: &str = "kept";
/// Ending of a file while it is written.
const UNFINISHED: &str = "tmp";
/// Characters of a digest.
const DIGITS: usize = 64;

pub(super) struct Folder {
    path: PathBuf,
    /// Written by this process since it looked; beyond any bound before the first look.
    unseen: AtomicU64,
    writes: AtomicU64,
}

impl Folder {
    pub fn new(path: &Path) -> Self {
        Self { path: path.into(), unseen: AtomicU64::new(UNSEEN_BYTES), writes: AtomicU64::new(0) }
    }

    /// The text of this, where it is whole.
    pub fn read(&self, of: &str) -> Option<String> {
        let path = self.path_of(of, ENDING);
        let about = fs::metadata(&path).ok()?;
        if !about.is_file() || about.len() > LARGEST_BYTES {
            return None;
        }
        let mut text = fs::read_to_string(path).ok()?;
        let (head, body) = text.split_once('\n')?;
        if head != head_of(of, body) {
            return None;
        }
        let begins = head.len() + 1;
        Some(text.split_off(begins))
    }

    /// Keeps a text; where that is not possible, the log alone says so.
    pub fn keep(&self, of: &str, text: &str) {
        let bytes = text.len() as u64;
        if bytes > LARGEST_BYTES {
            return;
        }
        if let Err(error) = self.write(of, text) {
            tracing::debug!(folder = %self.path.display(), %error, "what was worked out is not kept");
            return;
        }
        if self.unseen.fetch_add(bytes, Ordering::Relaxed) + bytes > UNSEEN_BYTES {
            self.unseen.store(0, Ordering::Relaxed);
            self.make_room();
        }
    }

    /// Whole or not at all; for its owner alone, as recordings are.
    fn write(&self, of: &str, text: &str) -> io::Result<()> {
        DirBuilder::new().recursive(true).mode(0o700).create(&self.path)?;
        let one = self.writes.fetch_add(1, Ordering::Relaxed);
        let unfinished = self.path_of(of, &format!("{}-{one}.{UNFINISHED}", std::process::id()));
        let write = || {
            let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&unfinished)?;
            file.write_all(format!("{}\n{text}", head_of(of, text)).as_bytes())?;
            fs::rename(&unfinished, self.path_of(of, ENDING))
        };
        // A part is of no use; the first error is the one to report.
        write().inspect_err(|_| drop(fs::remove_file(&unfinished)))
    }

    /// Removes what was written first, until three quarters of the bound are taken.
    fn make_room(&self) {
        let Ok(entries) = fs::read_dir(&self.path) else { return };
        let mut own: Vec<(SystemTime, u64, PathBuf)> = entries
            .filter_map(Result::ok)
            .filter(|entry| is_own(&entry.file_name().to_string_lossy()))
            .filter_map(|entry| {
                let about = entry.metadata().ok().filter(fs::Metadata::is_file)?;
                Some((about.modified().ok()?, about.len(), entry.path()))
            })
            .collect();
        own.sort();
        let mut bytes: u64 = own.iter().map(|(_, bytes, _)| bytes).sum();
        if bytes <= MOST_BYTES - UNSEEN_BYTES {
            return;
        }
        for (_, of_one, path) in own {
            if bytes <= MOST_BYTES / 4 * 3 {
                break;
            }
            bytes -= of_one;
            // Another process may have removed it.
            fs::remove_file(path).ok();
        }
    }

    fn path_of(&self, of: &str, ending: &str) -> PathBuf {
        self.path.join(format!("{of}.{ending}"))
    }
}

fn head_of(of: &str, text: &str) -> String {
    format!("{of} {}", identity::sha256_of(text.as_bytes()))
}

/// Files that are there for another purpose are never removed.
fn is_own(name: &str) -> bool {
    let Some((of, ending)) = name.split_once('.') else { return false };
    let is_ending = ending == ENDING || ending.ends_with(&format!(".{UNFINISHED}"));
    of.len() == DIGITS && of.bytes().all(|digit| digit.is_ascii_hexdigit()) && is_ending
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn of(k: usize) -> String {
        format!("{k:064x}")
    }

    #[test]
    fn a_text_that_was_cut_damaged_or_renamed_is_none() {
        let there = tempfile::tempdir().unwrap();
        let folder = Folder::new(&there.path().join("made"));
        assert_eq!(folder.read(&of(1)), None);
        folder.keep(&of(1), "[1.5,2.5]");
        assert_eq!(folder.read(&of(1)).as_deref(), Some("[1.5,2.5]"));
        let path = folder.path_of(&of(1), ENDING);
        fs::rename(&path, folder.path_of(&of(2), ENDING)).unwrap();
        assert_eq!(folder.read(&of(2)), None);
        for damaged in ["", "\n", "[1.5,2.5]", &format!("{}\n[1.5,2.6]", head_of(&of(1), "[1.5,2.5]"))] {
            fs::write(&path, damaged).unwrap();
            assert_eq!(folder.read(&of(1)), None, "{damaged}");
        }
        folder.keep(&of(1), "[1.5,2.5]");
        assert_eq!(folder.read(&of(1)).as_deref(), Some("[1.5,2.5]"));
    }

    #[test]
    fn what_was_written_first_makes_room_and_files_of_others_stay() {
        let there = tempfile::tempdir().unwrap();
        let other = there.path().join("notes.kept");
        fs::write(&other, "mine").unwrap();
        let folder = Folder::new(there.path());
        let text = "x".repeat(LARGEST_BYTES as usize - 1000);
        for k in 0..6 {
            folder.keep(&of(k), &text);
            let written = SystemTime::UNIX_EPOCH + Duration::from_secs(k as u64);
            let file = fs::File::options().write(true).open(folder.path_of(&of(k), ENDING));
            if let Ok(file) = file {
                file.set_modified(written).unwrap();
            }
        }
        let there: Vec<usize> = (0..6).filter(|k| folder.path_of(&of(*k), ENDING).exists()).collect();
        assert!(there.len() < 5 && there.contains(&5) && !there.contains(&0), "{there:?}");
        assert!(other.exists());
    }

    #[test]
    fn a_folder_that_cannot_be_made_keeps_nothing() {
        let there = tempfile::tempdir().unwrap();
        let file = there.path().join("file");
        fs::write(&file, "").unwrap();
        let folder = Folder::new(&file);
        folder.keep(&of(1), "[]");
        assert_eq!(folder.read(&of(1)), None);
    }
}
