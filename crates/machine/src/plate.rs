//! What a machine file says of the one machine that stands on the floor. No fit asks for it, so that runs of before and after a
//! change of it can be fitted together.

use trunnion_core::Problems;
use trunnion_core::input::{Document, Table};

/// A tolerance outside is a slip of the unit, µm.
pub const TOLERANCE_UM: std::ops::RangeInclusive<f64> = 0.1..=10_000.0;

/// Serial number and tolerance of one machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamePlate {
    /// Serial number.
    pub serial: Option<String>,
    /// How far the tool may be off against the table anywhere in the working volume, µm.
    pub tolerance_um: Option<f64>,
}

impl NamePlate {
    /// Reads them from a machine file; other keys are for `Machine::parse`.
    ///
    /// # Errors
    /// Keys that have no sense, with line, what was found and what is allowed.
    pub fn parse(file: &str, text: &str) -> Result<Self, Problems> {
        let document = Document::parse(file, text)?;
        let plate = Self::read(&document.root());
        document.finish(Some(plate))
    }

    /// This one, filled up from another.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { serial: self.serial.or(other.serial), tolerance_um: self.tolerance_um.or(other.tolerance_um) }
    }

    pub(crate) fn read(root: &Table<'_>) -> Self {
        Self {
            serial: root.optional_string("serial"),
            tolerance_um: root.optional_number("tolerance_um", TOLERANCE_UM),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Machine, shipped};

    #[test]
    fn serial_and_tolerance_are_read_and_change_no_machine() {
        let (_, text) = shipped::FILES.iter().find(|(name, _)| *name == "table-bc").expect("it ships");
        let named = format!("serial = \"SN 17\"\ntolerance_um = 12\n{text}");
        let plate = NamePlate::parse("machine.toml", &named).expect("both are allowed");
        assert_eq!(plate, NamePlate { serial: Some("SN 17".into()), tolerance_um: Some(12.0) });
        let machine = |text: &str| Machine::parse("table-bc", "machine.toml", text).expect("it is a machine");
        assert_eq!(machine(&named), machine(text));
        let in_mm = NamePlate::parse("machine.toml", "tolerance_um = 0.012").expect_err("a slip of the unit");
        assert!(in_mm.to_string().contains("tolerance_um = 0.012"), "{in_mm}");
    }
}
