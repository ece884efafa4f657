//! The page writes figures as the program does: its script against crates/results/src/number.rs, with Node where there is one. Where `CI` is set it
//! must be there.

use serde_json::{Value, json};
use std::io::Write;
use std::process::{Command, Stdio};
use trunnion::results::number::{MISSING, fixed, justified, plain, value_and_u};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../service/src/page/assets/dom.js");

/// Reads `[value, u]` pairs, prints what the page makes of each.
const ASK: &str = "\
    const { plain, justified, withU, decimal } = await import(process.argv[1]);\n\
    const cases = JSON.parse(require('fs').readFileSync(0, 'utf8'));\n\
    console.log(JSON.stringify(cases.map(([v, u]) => [plain(v), justified(v, u), ...withU(v, u), decimal(v, 0), decimal(v, 3)])));";

/// What the page is given; `null` is what JSON makes of a number that is not finite.
fn cases() -> Vec<(Option<f64>, Option<f64>)> {
    let sizes = [1.0, 1.5, 2.25, 2.5, 3.125, 4.0, 5.0, 9.5, 9.949, 9.95, 9.951, 9.995, 9.999];
    let scales = (-7..=7).map(|power| 10_f64.powi(power));
    let mut values: Vec<f64> = scales.flat_map(|scale| sizes.map(|size| size * scale)).collect();
    // In the middle between two digits, exactly.
    values.extend([
        0.125,
        0.375,
        0.5,
        10.25,
        10.75,
        100.5,
        101.5,
        0.0625,
        1.25e6,
        1.35e6,
        9.95e6,
        2.5_f64.powi(-3),
        0.0,
    ]);
    let signed = values.into_iter().flat_map(|value| [value, -value]);
    let us = [
        None,
        Some(0.0),
        Some(-1.0),
        Some(3e-9),
        Some(1e-3),
        Some(0.0213),
        Some(0.1),
        Some(0.25),
        Some(1.0),
        Some(25.0),
        Some(1e4),
    ];
    let known = signed.flat_map(|value| us.map(|u| (Some(value), u)));
    known.chain([(None, None), (None, Some(1.0))]).collect()
}

#[test]
fn the_page_writes_numbers_as_the_program_does() {
    // Node takes a file for a module by its ending.
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("dom.mjs");
    std::fs::copy(SCRIPT, &script).unwrap();
    let program = Command::new("node")
        .args(["--input-type=commonjs", "-e", &format!("(async () => {{ {ASK} }})()")])
        .arg(&script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn();
    let Ok(mut node) = program else {
        assert!(std::env::var_os("CI").is_none(), "there is no Node on this computer");
        return eprintln!("not judged: there is no Node on this computer");
    };
    let cases = cases();
    let asked = json!(cases).to_string();
    node.stdin.take().unwrap().write_all(asked.as_bytes()).unwrap();
    let output = node.wait_with_output().unwrap();
    assert!(output.status.success());
    let shown: Vec<[String; 6]> = serde_json::from_slice(&output.stdout).unwrap();
    assert!(cases.len() > 3000 && shown.len() == cases.len());
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let mut wrong = Vec::new();
    for ((value, u), shown) in cases.into_iter().zip(shown) {
        // Where a value is not known, the tables of the page say so themselves.
        let [with, of_u] = match value {
            Some(_) => <[String; 2]>::from(value_and_u(value, u, "1")),
            None => [plain(f64::NAN), plain(f64::NAN)],
        };
        let [whole, thousandths] =
            [0, 3].map(|decimals| value.map_or(MISSING.into(), |value| fixed(value, decimals)));
        let of_both = justified(number(value), number(u));
        let expected = [plain(number(value)), of_both, with, of_u, whole, thousandths];
        if expected != shown {
            wrong.push(format!("{value:?} u {u:?}: {expected:?}, on the page {shown:?}"));
        }
    }
    assert!(wrong.is_empty(), "{} differ:\n{}", wrong.len(), wrong[..wrong.len().min(20)].join("\n"));
    assert!(matches!(json!(f64::NAN), Value::Null), "as the page gets it");
}
