//! A calibrated nest in the configuration: whole or not at all, and the file as it was stays next to it.

use crate::clock::file_stamp;
use std::path::{Path, PathBuf};

/// Why the configuration stayed as it was.
#[derive(Debug, thiserror::Error)]
pub enum NestFileError {
    /// It cannot be read, or not be copied.
    #[error("cannot keep {} as it was", path.display())]
    Kept {
        /// The configuration.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is no TOML any more.
    #[error("cannot edit {}", path.display())]
    Edited {
        /// The configuration.
        path: PathBuf,
        /// Why.
        source: toml_edit::TomlError,
    },
    /// The new one cannot be written.
    #[error(transparent)]
    Written(Box<trunnion::Error>),
}

/// Writes these directions into the configuration; where it stays as it was.
///
/// # Errors
/// When it cannot be read, edited or written.
pub fn write_nest(config: &Path, directions: [[f64; 3]; 3], wall_ns: i64) -> Result<PathBuf, NestFileError> {
    // What a link leads to is edited, not the link.
    let kept = |source| NestFileError::Kept { path: config.into(), source };
    let path = config.canonicalize().map_err(kept)?;
    let text = std::fs::read_to_string(&path).map_err(kept)?;
    let edited = with_nest(&text, directions);
    let edited = edited.map_err(|source| NestFileError::Edited { path: config.into(), source })?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".before-{}", file_stamp(wall_ns)));
    let before = path.with_file_name(name);
    std::fs::copy(&path, &before).map_err(kept)?;
    let allowed = std::fs::metadata(&path).map_err(kept)?.permissions();
    trunnion::files::write_whole(&path, &edited).map_err(|error| NestFileError::Written(Box::new(error)))?;
    std::fs::set_permissions(&path, allowed).map_err(kept)?;
    Ok(before)
}

/// What a person does where the service may not write its configuration, as the installed one may not.
pub fn by_hand(config: &Path, directions: [[f64; 3]; 3]) -> String {
    // An empty text is TOML.
    let lines = with_nest("", directions).unwrap_or_default();
    format!(
        "write these lines into {} as root, in place of its table [nest], then start the service again (systemctl restart trunnion):\n{}",
        config.display(),
        lines.trim_end()
    )
}

/// A configuration with these directions of its probes; whatever else a person wrote in it stays.
///
/// # Errors
/// A text that is no TOML.
pub fn with_nest(text: &str, directions: [[f64; 3]; 3]) -> Result<String, toml_edit::TomlError> {
    let mut document: toml_edit::DocumentMut = text.parse()?;
    let nest = document.entry("nest").or_insert(toml_edit::Item::Table(toml_edit::Table::new()));
    for (k, direction) in directions.into_iter().enumerate() {
        let rounded = direction.map(|part| (part * 1e7).round() / 1e7);
        nest[&format!("probe_{}", k + 1)] = toml_edit::value(toml_edit::Array::from_iter(rounded));
    }
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# of machine 1\nname = \"m\"\n\n# measured in May\n[nest]\nprobe_1 = [1, 0, 0] # front\nprobe_2 = [0, 1, 0]\n\
                        probe_3 = [0, 0, 1]\n\n[cycle_start]\nby = \"execution\"\n";

    #[test]
    fn the_nest_is_written_and_what_a_person_wrote_stays() {
        let up = 1.0 / 3.0_f64.sqrt();
        let text = with_nest(TEXT, [[up, up, up], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).expect("it is TOML");
        assert!(text.contains("probe_1 = [0.5773503, 0.5773503, 0.5773503]"), "{text}");
        for kept in ["# of machine 1", "# measured in May", "[cycle_start]"] {
            assert!(text.contains(kept), "{text}");
        }
        let without = with_nest("name = \"m\"\n", [[1.0, 0.0, 0.0]; 3]).expect("it is TOML");
        assert!(without.contains("[nest]\nprobe_1 = [1.0, 0.0, 0.0]"), "{without}");
    }

    #[test]
    fn a_configuration_that_cannot_be_written_gets_its_lines_by_hand() {
        let directions = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        // procfs takes no file, whoever asks.
        let config = Path::new("/proc/trunnion.toml");
        assert!(write_nest(config, directions, 0).is_err());
        let words = by_hand(config, directions);
        let (what, lines) = words.split_once('\n').unwrap();
        assert!(
            what.contains("/proc/trunnion.toml as root") && what.contains("systemctl restart trunnion"),
            "{what}"
        );
        assert_eq!(lines, with_nest("", directions).unwrap().trim_end());
        assert!(lines.starts_with("[nest]\nprobe_1 = [0.0, 1.0, 0.0]"), "{lines}");
    }

    #[test]
    fn the_configuration_gets_the_directions_and_stays_next_to_itself() {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("trunnion.toml");
        let old =
            "name = \"m\" # ours\n[nest]\nprobe_1 = [1, 0, 0]\nprobe_2 = [0, 1, 0]\nprobe_3 = [0, 0, 1]\n";
        std::fs::write(&config, old).unwrap();
        let before = write_nest(&config, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], 0).unwrap();
        let text = std::fs::read_to_string(&config).unwrap();
        assert!(text.contains("# ours") && text.contains("probe_1 = [0.0, 1.0, 0.0]"), "{text}");
        assert_eq!(before.file_name().unwrap(), "trunnion.toml.before-19700101T000000Z");
        assert_eq!(std::fs::read_to_string(before).unwrap(), old);
        std::fs::write(&config, "name =").unwrap();
        assert!(matches!(write_nest(&config, [[0.0; 3]; 3], 1), Err(NestFileError::Edited { .. })));
        assert_eq!(std::fs::read_to_string(&config).unwrap(), "name =", "half a file is none");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
