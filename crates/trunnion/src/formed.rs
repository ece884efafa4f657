//! Settings under which the samples of a recording are formed into points again.
//!
//! `settle.window_s=0.3` changes a key of the recorded cycle, `nest.probe_1=[1, 0, 0]` one of the recorded configuration. The recording stays
//! as it is.

use crate::{Error, Experiment, files, recording};
use std::path::Path;
use toml_edit::{DocumentMut, Item, Table, Value};
use trunnion_record::RunHeader;
use trunnion_sync::blocks::Limits;

/// What is changed before points are formed.
#[derive(Clone, Debug, Default)]
pub struct Form {
    changes: Vec<(String, Value)>,
}

impl Form {
    /// From `KEY=VALUE`, the value as TOML writes it; text needs no quotes.
    ///
    /// # Errors
    /// An option without a key.
    pub fn parse(options: &[String]) -> Result<Self, Error> {
        let change = |option: &String| {
            let (key, value) = option.split_once('=').filter(|(key, _)| !key.trim().is_empty())?;
            let value = value.trim();
            Some((key.trim().to_owned(), value.parse().unwrap_or_else(|_| Value::from(value))))
        };
        let changes = options
            .iter()
            .map(|option| change(option).ok_or_else(|| Error::FormOption { option: option.clone() }));
        Ok(Self { changes: changes.collect::<Result<_, _>>()? })
    }

    /// The header of a recording with the changes made.
    pub(crate) fn changed(&self, header: RunHeader) -> Result<RunHeader, Error> {
        let mut header = header;
        for (key, value) in &self.changes {
            let text = match key.starts_with("nest.") {
                true => &mut header.config_text,
                false => &mut header.cycle_text,
            };
            *text = with_key(text, key, value).ok_or_else(|| Error::FormOption { option: key.clone() })?;
        }
        if !header.cycle_text.is_empty() {
            trunnion_cycles::Cycle::parse("the recorded cycle, changed", &header.cycle_text)?;
        }
        Ok(header)
    }
}

/// The text with one more key, `table.key`; `None` where it cannot have it.
fn with_key(text: &str, key: &str, value: &Value) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    let mut parts: Vec<&str> = key.split('.').collect();
    let last = parts.pop()?;
    let mut table = document.as_table_mut();
    for part in parts {
        table = table.entry(part).or_insert(Item::Table(Table::new())).as_table_mut()?;
    }
    table.insert(last, Item::Value(value.clone()));
    Some(document.to_string())
}

/// Opens a recording with its points formed again from its samples, at rest as well as on the fly.
///
/// # Errors
/// As [`crate::open_with`]; an option that the cycle does not take; a recording without cycle or samples.
pub fn open_formed(path: &Path, limits: Limits, form: &Form) -> Result<Experiment, Error> {
    let not_read = Error::recording(path);
    let header = form.changed(trunnion_record::read_header(path).map_err(not_read)?)?;
    let machine = |name: &str| files::machine(name).ok();
    let formed = recording::read_again(path, header, &machine, Some(limits)).map_err(not_read)?;
    let formed = formed.ok_or_else(|| Error::NoSamples { path: path.into() })?;
    Experiment::of_recordings(vec![(path.to_owned(), formed)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_changed_or_added_and_the_rest_stays() {
        let form = Form::parse(&["settle.window_s = 0.3".into(), "nest.probe_1=[0, 1, 0]".into()]).unwrap();
        let [(window, seconds), (probe, direction)] = &form.changes[..] else { panic!("{form:?}") };
        let text = with_key("# my cycle\n[settle]\nwindow_s = 0.5 # long\n", window, seconds).unwrap();
        assert!(
            text.contains("# my cycle") && text.contains("window_s = 0.3") && !text.contains("0.5"),
            "{text}"
        );
        assert_eq!(with_key("", probe, direction).unwrap(), "[nest]\nprobe_1 = [0, 1, 0]\n");
        assert!(with_key("settle = 1\n", window, seconds).is_none());
        for option in ["settle.window_s", "=3"] {
            assert!(Form::parse(&[option.into()]).is_err(), "{option}");
        }
    }
}
