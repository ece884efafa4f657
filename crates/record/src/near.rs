//! A file that is not there, and the one that was meant.

use std::io::{Error, ErrorKind};
use std::path::Path;
use trunnion_core::names::nearest;

/// Why a file cannot be read; where it is not there, with the nearest name of its kind that its folder holds.
pub fn with_nearest(path: &Path, source: Error) -> Error {
    match meant(path).filter(|_| source.kind() == ErrorKind::NotFound) {
        Some(meant) => Error::new(
            source.kind(),
            format!("{source}; did you mean {}?", path.with_file_name(meant).display()),
        ),
        None => source,
    }
}

/// Compared without the endings, which are the same: of a name without one any ending will do.
fn meant(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let of_kind = |there: &Path| {
        path.extension().is_none_or(|ending| there.extension() == Some(ending)) && there.is_file()
    };
    let stem = |path: &Path| Some(path.file_stem()?.to_str()?.to_owned());
    let mut there: Vec<(String, String)> = std::fs::read_dir(folder)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|there| of_kind(there))
        .filter_map(|there| Some((stem(&there)?, there.file_name()?.to_str()?.to_owned())))
        .collect();
    // In the order of names and not of the disk: of two that are as near, always the same.
    there.sort();
    let near = nearest(&stem(path)?, there.iter().map(|(stem, _)| stem.as_str()))?;
    there.iter().find(|(stem, _)| stem == near).map(|(_, name)| name.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_in_the_name_of_a_file_is_answered_with_the_one_that_was_meant() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["r-test-static.toml", "r-test-static.mcap", "circle-xy.toml"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let said = |name: &str| {
            let path = folder.path().join(name);
            with_nearest(&path, std::fs::read(&path).unwrap_err()).to_string()
        };
        let meant = |name: &str| format!("; did you mean {}?", folder.path().join(name).display());
        assert!(said("r-test-statc.toml").ends_with(&meant("r-test-static.toml")));
        assert!(said("r_test_static.mcap").ends_with(&meant("r-test-static.mcap")));
        assert!(said("circle-yx").ends_with(&meant("circle-xy.toml")), "an ending that was left out");
        for none in ["volume.toml", "circle-xy.csv", "gone/circle-xy.toml"] {
            assert!(!said(none).contains("did you mean"), "{none}");
        }
    }
}
