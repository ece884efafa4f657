//! What of the controller begins a cycle of several.

use trunnion_core::input::Table;
use trunnion_sync::cycle_bounds::Pattern;

/// What begins a cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BegunBy {
    /// Every program that no other cycle names.
    Every,
    /// Programs that are named like this.
    Program(Pattern),
    /// The signal with this number.
    Signal(u32),
}

impl BegunBy {
    /// The keys `name` and `signal` of a table `[[program]]`, of which one must be there.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let name = table.optional_string("name");
        let signal = table.optional_count("signal", 1.0..=f64::from(u32::MAX));
        match (name, signal) {
            (Some(name), None) if !table.has("signal") => Some(Self::Program(Pattern::new(&name))),
            (None, Some(number)) => Some(Self::Signal(number as u32)),
            // It was reported.
            (None, None) if table.has("signal") => None,
            (found, _) => {
                let found = if found.is_some() { "is there next to signal" } else { "is missing" };
                table.problem(
                    "name",
                    found,
                    "either name, as the program is called, or signal, its number",
                    "",
                );
                None
            }
        }
    }

    /// For people; empty for every program.
    pub fn shown(&self) -> String {
        match self {
            Self::Every => String::new(),
            Self::Program(name) => name.as_str().into(),
            Self::Signal(number) => format!("signal {number}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use std::path::Path;
    use trunnion_core::HostTime;
    use trunnion_core::reading::{ControllerReading, Execution, Reading};

    fn read(tables: &str) -> Result<Vec<BegunBy>, String> {
        let example = include_str!("../../../config/trunnion.toml");
        let text = example.replace("by = \"execution\"", "by = \"signal\"") + tables;
        let config =
            Config::parse(Path::new("trunnion.toml"), &text).map_err(|problems| problems.to_string())?;
        Ok(config.programs.into_iter().map(|program| program.begun_by).collect())
    }

    #[test]
    fn a_cycle_is_begun_by_a_name_or_by_a_number() {
        let both =
            "[[program]]\nname = \"A*\"\ncycle = \"a.toml\"\n[[program]]\nsignal = 2\ncycle = \"b.toml\"\n";
        assert_eq!(read(both).unwrap(), [BegunBy::Program(Pattern::new("a*")), BegunBy::Signal(2)]);
        for (keys, words) in [
            ("", "name is missing"),
            ("name = \"a\"\nsignal = 2", "name is there next to signal"),
            ("signal = 1.5", "a whole number"),
            ("signal = 0", "signal = 0"),
            ("signal = 2\ncycle = \"a.toml\"\n[[program]]\nsignal = 2", "signal = 2 appears twice"),
        ] {
            let refused = read(&format!("[[program]]\n{keys}\ncycle = \"a.toml\"\n")).unwrap_err();
            assert!(refused.contains(words), "{refused}");
        }
    }

    #[test]
    fn a_counter_cuts_no_cycle_in_two_where_no_number_is_asked_for() {
        let example = include_str!("../../../config/trunnion.toml");
        let text = example.replace("by = \"execution\"", "by = \"signal\"");
        let counted = |tables: &str| {
            let config = Config::parse(Path::new("trunnion.toml"), &(text.clone() + tables)).unwrap();
            let mut bounds = config.cycle_bounds();
            let reading = |number| ControllerReading {
                execution: Execution::Active,
                program: "P".into(),
                block: String::new(),
                signal: Some(number),
                stamp_ns: 0,
                arrival: HostTime(i64::from(number)),
            };
            (0..4).filter(|number| bounds.take(&Reading::Controller(reading(*number))).is_some()).count()
        };
        assert_eq!(counted(""), 1);
        assert_eq!(counted("[[program]]\nsignal = 2\ncycle = \"b.toml\"\n"), 3);
    }

    #[test]
    fn a_number_needs_cycles_that_a_signal_begins() {
        let example = include_str!("../../../config/trunnion.toml");
        let text = format!("{example}[[program]]\nsignal = 2\ncycle = \"a.toml\"\n");
        let refused = Config::parse(Path::new("trunnion.toml"), &text).unwrap_err().to_string();
        assert!(refused.contains("cycle_start begins no cycle by a signal"), "{refused}");
    }
}
