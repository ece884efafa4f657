//! What the certificates of calibrated sensors say. The `[[calibration]]` tables of a configuration and of a setup file
//! (docs/design/contracts.md §2).

use crate::Day;
use crate::input::Table;

/// What the certificate of one sensor says; what is `None` is not recorded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Calibration {
    /// Name of the sensor: that of its channel, in a setup file any.
    pub sensor: String,
    /// Serial number of the sensor.
    pub serial: Option<String>,
    /// Number of the certificate.
    pub certificate: Option<String>,
    /// Who calibrated it.
    pub laboratory: Option<String>,
    /// Day of the calibration.
    pub date: Option<Day>,
    /// Last day on which it holds.
    pub valid_until: Option<Day>,
}

impl Calibration {
    /// True where it no longer holds on a day.
    pub fn is_out_of_date(&self, on: Day) -> bool {
        self.valid_until.is_some_and(|last| last < on)
    }
}

/// Reads the `[[calibration]]` tables of a file; the list may be empty. `sensors`: those that a file may name, where it knows them.
pub fn read_calibrations(root: &Table<'_>, sensors: Option<&[&str]>) -> Option<Vec<Calibration>> {
    let tables = root.tables("calibration");
    let mut calibrations: Vec<Calibration> = Vec::new();
    for table in &tables {
        let Some(calibration) = read_calibration(table, sensors) else { continue };
        if calibrations.iter().any(|other| other.sensor == calibration.sensor) {
            let found = format!("= \"{}\" appears twice", calibration.sensor);
            table.problem("sensor", found, "each sensor once", "");
        }
        calibrations.push(calibration);
    }
    (calibrations.len() == tables.len()).then_some(calibrations)
}

fn read_calibration(table: &Table<'_>, sensors: Option<&[&str]>) -> Option<Calibration> {
    let sensor = match sensors {
        Some(sensors) => table.one_of("sensor", sensors),
        None => table.string("sensor"),
    };
    let text = |key: &str| table.optional_string(key).filter(|text| !text.trim().is_empty());
    let calibration = Calibration {
        sensor: sensor.unwrap_or_default(),
        serial: text("serial"),
        certificate: text("certificate"),
        laboratory: text("laboratory"),
        date: table.optional_day("date"),
        valid_until: table.optional_day("valid_until"),
    };
    if let (Some(date), Some(until)) = (calibration.date, calibration.valid_until)
        && until < date
    {
        let found = format!("= {until} is before the calibration of {date}");
        table.problem("valid_until", found, "a day after date", "");
    }
    table.no_other_keys();
    (!calibration.sensor.is_empty()).then_some(calibration)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Problems;
    use crate::input::Document;

    fn read(text: &str) -> Result<Vec<Calibration>, Problems> {
        let document = Document::parse("t.toml", text).unwrap();
        let root = document.root();
        let calibrations = read_calibrations(&root, Some(&["probe-1", "probe-2"]));
        drop(root);
        document.finish(calibrations)
    }

    const GOOD: &str = r#"
[[calibration]]
sensor = "probe-1"
serial = "1702"
certificate = "K-2026-081"
date = 2026-05-12
valid_until = "2027-05-12"
"#;

    #[test]
    fn a_calibration_holds_until_the_end_of_its_last_day() {
        let [calibration] = &read(GOOD).unwrap()[..] else { panic!("one calibration") };
        assert_eq!(calibration.serial.as_deref(), Some("1702"));
        let days = ["2026-12-01", "2027-05-12", "2027-05-13"].map(|day| Day::parse(day).unwrap());
        assert_eq!(days.map(|day| calibration.is_out_of_date(day)), [false, false, true]);
    }

    #[test]
    fn every_problem_is_reported_with_its_line() {
        let wrong = GOOD.replace("2027-05-12", "2025-05-12");
        let wrong = wrong + &GOOD.replace("2026-05-12", "\"12.05.2026\"").replace("serial", "serail");
        let shown = read(&(wrong + &GOOD.replace("probe-1", "probe-3"))).unwrap_err().to_string();
        for expected in [
            "t.toml:7:15: calibration[0].valid_until = 2025-05-12 is before the calibration of 2026-05-12",
            "t.toml:13:8: calibration[1].date = \"12.05.2026\"; allowed: a day such as 2026-11-23",
            "calibration[1].serail is not known here",
            "calibration[1].sensor = \"probe-1\" appears twice",
            "calibration[2].sensor = \"probe-3\"",
        ] {
            assert!(shown.contains(expected), "{expected:?} not in:\n{shown}");
        }
    }
}
