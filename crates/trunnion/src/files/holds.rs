//! What a file that is there holds, as far as this program reads such files: no output takes its place.

use crate::Error;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;
use trunnion_record::{foxglove, points_csv};

/// What is looked at of a file. A cycle that was planned has its reason before its first key, a few sentences.
const BEGINNING: u64 = 16_384;

/// First bytes of every MCAP file [MCAP specification, "Magic"].
const MCAP: &[u8] = b"\x89MCAP0\r\n";

/// The hand-written formats (docs/design/contracts.md), and what is said of them.
const BY_HAND: [(&str, &str); 6] = [
    ("trunnion-config", "a configuration"),
    ("trunnion-cycle", "a cycle file"),
    ("trunnion-machine", "a machine file"),
    ("trunnion-model", "a model file"),
    ("trunnion-points", "a setup file"),
    ("trunnion-truth", "a truth file"),
];

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holds {
    /// A run that was measured or imported.
    Recording,
    /// One of [`BY_HAND`].
    ByHand(&'static str),
    /// Points as `import` takes them.
    Points,
    /// Anything else.
    Other,
}

impl Holds {
    /// Judged by how it begins.
    pub fn of(beginning: &[u8]) -> Self {
        if beginning.starts_with(MCAP) {
            // What is drawn for a viewer is drawn again from its recording.
            return if foxglove::begins(beginning) { Self::Other } else { Self::Recording };
        }
        let text = String::from_utf8_lossy(beginning);
        let value = |line: &str| {
            Some(line.strip_prefix("format")?.trim_start().strip_prefix('=')?.trim_start().to_owned())
        };
        let format = text.lines().find_map(value).unwrap_or_default();
        let is_of = |name: &str| format.trim_start_matches(['"', '\'']).starts_with(name);
        if let Some((_, what)) = BY_HAND.iter().find(|(name, _)| is_of(name)) {
            return Self::ByHand(what);
        }
        if points_csv::begins(&text) { Self::Points } else { Self::Other }
    }

    fn what(self) -> &'static str {
        match self {
            Self::Recording => "a recording",
            Self::ByHand(what) => what,
            Self::Points => "a table of points",
            Self::Other => "another file",
        }
    }
}

/// Refuses to put `new` in the place of a file that this program reads, unless it is of the same kind: an earlier output.
///
/// # Errors
/// Such a file is there, or one that cannot be read.
pub(crate) fn not_lost(path: &Path, new: Holds) -> Result<(), Error> {
    // A pipe would wait for somebody who writes.
    if !std::fs::metadata(path).is_ok_and(|about| about.is_file()) {
        return Ok(());
    }
    let mut beginning = Vec::new();
    match File::open(path).and_then(|file| file.take(BEGINNING).read_to_end(&mut beginning)) {
        // Whoever may write a file and not read it decides by what he may.
        Err(why) if why.kind() == ErrorKind::PermissionDenied => return Ok(()),
        read => read.map_err(Error::read(path))?,
    };
    match Holds::of(&beginning) {
        Holds::Other => Ok(()),
        there if there == new => Ok(()),
        there => Err(Error::WouldBeLost { path: path.into(), holds: there.what() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_how_it_begins() {
        let check = |beginning: &str, expected: Holds| {
            assert_eq!(Holds::of(beginning.as_bytes()), expected, "{beginning}");
        };
        check("", Holds::Other);
        check("<!doctype html>", Holds::Other);
        check("format = \"trunnion-points/1\"\n", Holds::ByHand("a setup file"));
        check("# why: it separates the two\n\nformat=\"trunnion-cycle/1\"\n", Holds::ByHand("a cycle file"));
        check("{\n  \"format\": \"trunnion-diagnosis/1\"", Holds::Other);
        check("setup,time_s,b_deg,dx_um\nlow,0,0,1\n", Holds::Points);
        check("\u{feff}Setup;B_deg;DX_um\n", Holds::Points);
        check("effect,parameter,value_um\n", Holds::Other);
        assert_eq!(Holds::of(b"\x89MCAP0\r\n\x01\x20"), Holds::Recording);
    }
}
