//! What a compensation file claims to remove is gone when a controller applies it, and twice as large with the wrong sign.
//!
//! Through the binary: a machine whose truth is known is measured, identified and exported; the simulated controller, which
//! shares no code with the estimator, reads the file back and moves its axes; the machine is measured again.

use crate::program::{output, trunnion};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trunnion_report::compensation::{FORMATS, Signs};

/// White noise of the readings of both truths, µm.
const NOISE_UM: f64 = 0.1;

/// A machine with its truth and the model of it.
struct Shop {
    folder: tempfile::TempDir,
    truth: String,
    model: String,
}

impl Shop {
    fn new(name: &str) -> Self {
        let data = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/end_to_end/compensation"));
        let file = |kind: &str| data.join(format!("{name}.{kind}.toml")).display().to_string();
        Self { folder: tempfile::tempdir().unwrap(), truth: file("truth"), model: file("model") }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Measures the machine, with its controller compensating or not.
    fn measure(&self, name: &str, compensation: Option<&str>) -> String {
        let path = self.path(&format!("{name}.mcap"));
        if path.exists() {
            std::fs::remove_file(&path).unwrap();
        }
        let run = path.display().to_string();
        let mut args = vec!["simulate", &self.truth, "-o", &run];
        if let Some(file) = compensation {
            args.extend(["--compensation", file]);
        }
        trunnion(&args);
        run
    }

    /// Exports the model of a run; gives the file and what the program says of it.
    fn export(&self, run: &str, format: &str, more: &[&str]) -> (String, Value) {
        let file = self.path(&format!("{format}{}.txt", more.concat())).display().to_string();
        let mut args =
            vec!["compensation", run, "--model", &self.model, "--format", format, "-o", &file, "--json"];
        args.extend(more);
        let reported = serde_json::from_str(&trunnion(&args)).unwrap();
        (file, reported)
    }

    /// The same file with errors called corrections: a controller that applies it has the sign wrong.
    fn wrong_sign(&self, file: &str) -> String {
        let text = std::fs::read_to_string(file).unwrap();
        assert_eq!(text.matches("values = error").count(), 1);
        let wrong = self.path("wrong.txt").display().to_string();
        std::fs::write(&wrong, text.replace("values = error", "values = correction")).unwrap();
        wrong
    }
}

/// Tables for other programs; controls are in `correct`.
fn tables() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().filter(|format| format.signs == Signs::Either).map(|format| format.name)
}

/// Rms of the readings about their mean in each setup (the setting of the ball is not the machine's), µm.
pub fn rms_um(run: &str) -> f64 {
    let table = trunnion(&["export", "csv", run]);
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut groups: BTreeMap<(String, String), Vec<f64>> = BTreeMap::new();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        for (name, cell) in
            names.iter().zip(&cells).filter(|(name, _)| ["dx_um", "dy_um", "dz_um"].contains(name))
        {
            groups.entry((cells[0].into(), (*name).into())).or_default().push(cell.parse().unwrap());
        }
    }
    let count: usize = groups.values().map(Vec::len).sum();
    let square = |values: &Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
    };
    (groups.values().map(square).sum::<f64>() / count as f64).sqrt()
}

fn value(identified: &Value, name: &str) -> f64 {
    let parameters = identified["parameters"].as_array().unwrap();
    parameters.iter().find(|p| p["name"] == name).unwrap()["value"].as_f64().unwrap()
}

#[test]
fn rotary_errors_exported_in_any_format_are_gone_when_applied_and_double_with_the_wrong_sign() {
    let shop = Shop::new("rotary");
    let before = shop.measure("before", None);
    let before_um = rms_um(&before);
    assert!(before_um > 10.0, "{before_um}");
    for format in tables() {
        for more in [&[][..], &["--corrections"]] {
            let (file, reported) = shop.export(&before, format, more);
            let after_um = rms_um(&shop.measure("after", Some(&file)));
            println!("{format} {more:?}: {before_um:.3} µm before, {after_um:.3} µm after");
            assert!(after_um < 1.05 * NOISE_UM, "{format}: {before_um} before, {after_um} after");
            assert_eq!(reported["left_out"][1]["effect"], "ball-setting", "{reported}");
        }
        let (file, _) = shop.export(&before, format, &[]);
        let wrong_um = rms_um(&shop.measure("wrong", Some(&shop.wrong_sign(&file))));
        println!("{format}: {wrong_um:.3} µm with the wrong sign");
        assert!((wrong_um / before_um - 2.0).abs() < 0.01, "{format}: {before_um} before, {wrong_um} wrong");
    }
}

#[test]
fn errors_of_linear_axes_are_gone_and_backlash_is_named_and_stays() {
    let shop = Shop::new("linear");
    let before = shop.measure("before", None);
    let identify = |run: &str| -> Value {
        serde_json::from_str(&trunnion(&["identify", run, "--model", &shop.model, "--json"])).unwrap()
    };
    let found = identify(&before);
    for format in tables() {
        let (file, reported) = shop.export(&before, format, &[]);
        let left_out = reported["left_out"].as_array().unwrap();
        let backlash = left_out.iter().find(|left| left["effect"] == "backlash:C").unwrap();
        assert_eq!(backlash["why"], "it depends on the direction of C");
        assert!(std::fs::read_to_string(&file).unwrap().contains("does not hold backlash:C"));
        let after = identify(&shop.measure("after", Some(&file)));
        for (name, was, left) in [
            ("scale", 50.0, 0.1),
            ("EXY.P3", 2.4, 0.01),
            ("EZY.P2", 3.2, 0.01),
            ("EB0Z", 40.0, 0.1),
            ("EX0C", 12.0, 0.01),
            ("EA0C", -50.0, 0.1),
        ] {
            assert!((value(&found, name) / was - 1.0).abs() < 0.01, "{name} {}", value(&found, name));
            assert!(value(&after, name).abs() < left, "{format}: {name} {} stays", value(&after, name));
        }
        assert!((value(&after, "h") - value(&found, "h")).abs() < 0.05, "backlash is not in the table");
    }
}

#[test]
fn a_table_that_does_not_say_its_sign_or_is_no_table_is_refused() {
    let shop = Shop::new("rotary");
    let before = shop.measure("before", None);
    let (file, _) = shop.export(&before, "isg", &[]);
    let text = std::fs::read_to_string(&file).unwrap();
    let refused = |from: &str, to: &str, expected: &str| {
        assert!(text.contains(from));
        let broken = shop.path("broken.txt").display().to_string();
        std::fs::write(&broken, text.replacen(from, to, 1)).unwrap();
        let run = shop.path("refused.mcap").display().to_string();
        let (done, _, reported) = output(&["simulate", &shop.truth, "--compensation", &broken, "-o", &run]);
        assert!(!done && reported.contains(expected), "{reported}");
    };
    refused("values = error", "values", "does not say whether it holds errors or corrections");
    refused(
        "values = error",
        "values = residual",
        "allowed: a remark \"values = error\" or \"values = correction\"",
    );
    refused("C EXC", "C EQC", "EQC; allowed: a component error such as EXC");
    refused("\n-85 ", "\n-85 0.1 ", "8 numbers; allowed: as many numbers as names in the header");
    refused("\n-85 ", "\n-95 ", "two or more rows with rising arguments");
    let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
    let (done, _, reported) = output(&["compensation", &before, "--format", "xml"]);
    assert!(!done && reported.contains(&format!("possible values: {}", names.join(", "))), "{reported}");
}
