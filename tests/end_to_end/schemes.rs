//! Every measurement scheme of the sources, from the command line on files that ship: simulated with one truth, identified, and
//! every number compared with the truth. The table of docs/use/schemes.md is written from these rows.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
/// Deviations allowed, in standard uncertainties: of some 300 numbers none should be farther off.
const ALLOWED_U: f64 = 4.5;
/// What the linear uncertainty leaves out: errors of second order, in the last printed digit.
const SECOND_ORDER: f64 = 0.01;

/// One scheme.
struct Row {
    scheme: &'static str,
    source: &'static str,
    cycle: &'static str,
    truth: &'static str,
    model: Option<&'static str>,
    /// What must be among the numbers.
    identifies: &'static [&'static str],
    /// In words for the table.
    cannot: &'static str,
    /// Amplitudes that the truth does not list by the name of the parameter.
    also: &'static [(&'static str, f64)],
}

const LOCATIONS: &[&str] = &["EX0B", "EZ0B", "EA0B", "EB0B", "EC0B", "EX0C", "EY0C", "EA0C"];
const SQUARE: &[&str] = &["EC0Y", "EB0Z", "EA0Z"];

const ROWS: &[Row] = &[
    Row {
        scheme: "R-test, nest on the table, grid of poses",
        source: "S1",
        cycle: "r-test-static",
        truth: "table-bc",
        model: None,
        identifies: LOCATIONS,
        cannot: "EY0B against EY0C, EB0C against EB0B, EZ0C and EC0C against the setting",
        also: &[],
    },
    Row {
        scheme: "Sphere touched at indexed angles",
        source: "S2 §4.3",
        cycle: "touch-probe",
        truth: "table-bc",
        model: None,
        identifies: LOCATIONS,
        cannot: "as the R-test",
        also: &[],
    },
    Row {
        scheme: "Faces of a column touched at indexed angles",
        source: "S2 §4.3",
        cycle: "touch-probe-column",
        truth: "table-bc",
        model: None,
        identifies: LOCATIONS,
        cannot: "as the R-test; place and turn of the column contain EZ0C and EC0C",
        also: &[],
    },
    Row {
        scheme: "Square column machined at indexed angles",
        source: "S2 §4.5",
        cycle: "machined-column",
        truth: "table-bc",
        model: None,
        identifies: LOCATIONS,
        cannot: "as the R-test; place and turn of the workpiece contain EZ0C and EC0C",
        also: &[],
    },
    Row {
        scheme: "Ball bar, C alone under the bar (C-X, C-Y, C-Z)",
        source: "S4",
        cycle: "s4-c",
        truth: "table-bc-y",
        model: None,
        identifies: &["EX0C", "EY0C", "EA0C", "EB0C"],
        cannot: "B (stationary); heights of the balls",
        also: &[],
    },
    Row {
        scheme: "Ball bar, B alone under the bar (B-X, B-Z, B-Y)",
        source: "S4",
        cycle: "s4-b",
        truth: "table-bc-y",
        model: None,
        identifies: &["EX0B", "EZ0B", "EA0B", "EC0B"],
        cannot: "C (stationary); EY0B against the setting",
        also: &[],
    },
    Row {
        scheme: "BK1: tilting axis with linear axes, three bar directions",
        source: "ISO 10791-6; S2 §4.1",
        cycle: "bk1-b",
        truth: "table-bc",
        model: None,
        identifies: &["EX0B", "EZ0B", "EA0B", "EC0B"],
        cannot: "C (stationary); length of the bar against the setting",
        also: &[],
    },
    Row {
        scheme: "BK2: turning axis with X and Y, three bar directions",
        source: "ISO 10791-6; S4 C-XY",
        cycle: "bk2-c",
        truth: "table-bc",
        model: None,
        identifies: &["EX0C", "EY0C", "EA0C", "EB0C"],
        cannot: "B (stationary); length of the bar against the setting",
        also: &[],
    },
    Row {
        scheme: "BK1 on a table A-C",
        source: "ISO 10791-6",
        cycle: "bk1-a",
        truth: "table-ac",
        model: None,
        identifies: &["EY0A", "EZ0A", "EB0A", "EC0A"],
        cannot: "C (stationary); length of the bar against the setting",
        also: &[],
    },
    Row {
        scheme: "BK2 on a table A-C",
        source: "ISO 10791-6",
        cycle: "bk2-c-of-ac",
        truth: "table-ac",
        model: None,
        identifies: &["EX0C", "EY0C", "EA0C", "EB0C"],
        cannot: "A (stationary); length of the bar against the setting",
        also: &[],
    },
    Row {
        scheme: "Head, tilting axis with linear axes",
        source: "ISO 10791-6",
        cycle: "head-b",
        truth: "head-bc",
        model: None,
        identifies: &["EA0B", "EC0B"],
        cannot: "EX0B, EZ0B against the setting of the ball; length of the bar; C (stationary)",
        also: &[],
    },
    Row {
        scheme: "Head, turning axis with X and Y",
        source: "ISO 10791-6",
        cycle: "head-c",
        truth: "head-bc",
        model: None,
        identifies: &["EA0C", "EB0C"],
        cannot: "EX0C, EY0C against the length of the bar; B (stationary)",
        also: &[],
    },
    Row {
        scheme: "BK4: cone-frustum path, five axes at once",
        source: "NAS 979; ISO 10791-6; S4",
        cycle: "bk4-cone",
        truth: "table-bc",
        model: None,
        identifies: &["EX0B", "EX0C"],
        cannot: "most location errors one by one: a test of acceptance, not of diagnosis",
        also: &[],
    },
    Row {
        scheme: "Circle in XY, ball bar",
        source: "ISO 230-4; S2 §3.1; S4",
        cycle: "circle-xy",
        truth: "three-axis-square",
        model: Some("straight-lines-xy"),
        identifies: &["EC0Y"],
        cannot: "the mean scale against the length of the bar; EB0Z, EA0Z",
        also: &[],
    },
    Row {
        scheme: "Circle in YZ, ball bar",
        source: "ISO 230-4; S4",
        cycle: "circle-yz",
        truth: "three-axis-square",
        model: Some("straight-lines-yz"),
        identifies: &["EA0Z"],
        cannot: "the mean scale against the length of the bar; EC0Y, EB0Z",
        also: &[],
    },
    Row {
        scheme: "Circle in ZX, ball bar",
        source: "ISO 230-4; S4",
        cycle: "circle-zx",
        truth: "three-axis-square",
        model: Some("straight-lines-zx"),
        identifies: &["EB0Z"],
        cannot: "the mean scale against the length of the bar; EC0Y, EA0Z",
        also: &[],
    },
    Row {
        scheme: "Four body diagonals, laser interferometer",
        source: "S2 §3.2, eq. 7",
        cycle: "diagonal",
        truth: "three-axis-square",
        model: Some("straight-lines"),
        identifies: SQUARE,
        cannot: "each scale (only their sum); tilt of the beam (second order)",
        also: &[],
    },
    Row {
        scheme: "Step diagonals, flat mirror",
        source: "S2 §3.2",
        cycle: "step-diagonal",
        truth: "three-axis-square",
        model: Some("straight-lines"),
        identifies: SQUARE,
        cannot: "each scale against the tilts of the mirrors (only their sum)",
        also: &[],
    },
    Row {
        scheme: "Ball plate in five placements",
        source: "S2 §3.3",
        cycle: "ball-plate",
        truth: "three-axis-square",
        model: Some("volume"),
        identifies: &["EC0Y", "EB0Z", "EA0Z", "EXX.P1", "EYY.P1", "EZZ.P1", "EAX.P1", "EBX.P1", "ECX.P1"],
        cannot: "angular errors of Z and the roll of Y with one length of tool",
        also: &[("EXX.P1", 2.4), ("EYY.P1", -1.6)],
    },
    Row {
        scheme: "The same plate uncalibrated: self-calibration",
        source: "S2 §3.3",
        cycle: "ball-plate-self",
        truth: "three-axis-square",
        model: Some("self-calibration"),
        identifies: SQUARE,
        cannot: "each scale (the size of the plate is unknown; only their differences); form as far as it is a placement",
        also: &[],
    },
    Row {
        scheme: "Passive serial link, two arms",
        source: "S2 §3.4",
        cycle: "passive-arm",
        truth: "table-bc-linear",
        model: Some("straight-lines-xy-bc"),
        identifies: &["EC0Y"],
        cannot: "each scale against the lengths of the arms (only their difference); Z",
        also: &[],
    },
    Row {
        scheme: "Passive parallel link, laser ball bar on three feet",
        source: "S2 §3.4",
        cycle: "laser-ball-bar",
        truth: "table-bc-linear",
        model: Some("straight-lines-bc"),
        identifies: &[
            "EC0Y",
            "EB0Z",
            "EA0Z",
            "linear-scale:X.scale",
            "linear-scale:Y.scale",
            "linear-scale:Z.scale",
        ],
        cannot: "rotary axes (stationary)",
        also: &[],
    },
    Row {
        scheme: "Tracking interferometer, four stations, two lengths of tool: 21 errors",
        source: "S2 §3.5, eq. 8",
        cycle: "tracker",
        truth: "table-bc-linear",
        model: Some("volume-bc"),
        identifies: &[
            "EC0Y", "EB0Z", "EA0Z", "EXX.P1", "EYY.P1", "EZZ.P1", "EYX.P2", "EZX.P2", "EAX.P1", "EBX.P1",
            "ECX.P1", "EXY.P2", "EZY.P2", "EAY.P1", "EBY.P1", "EXZ.P2", "EYZ.P2", "EAZ.P1", "EBZ.P1",
        ],
        cannot: "roll of Z and yaw of Y (no tool off the spindle line); rotary axes (stationary)",
        also: &[("EXX.P1", 3.6), ("EYY.P1", -2.4)],
    },
];

fn trunnion(folder: &Path, args: &[&str]) -> String {
    let output =
        Command::new(env!("CARGO_BIN_EXE_trunnion")).current_dir(folder).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn config(kind: &str, name: &str) -> String {
    format!("{ROOT}/config/{kind}/{name}.toml")
}

/// True values by parameter name, screen units.
fn truth(row: &Row) -> BTreeMap<String, f64> {
    let text = std::fs::read_to_string(config("truths", row.truth)).unwrap();
    let file: toml::Table = text.parse().unwrap();
    let number = |value: &toml::Value| value.as_float().unwrap();
    let mut truth = BTreeMap::new();
    for (key, value) in file["location"].as_table().unwrap() {
        truth.insert(key.split('_').next().unwrap().to_string(), number(value));
    }
    for hidden in file.get("hidden").and_then(|h| h.as_array()).into_iter().flatten() {
        let size = number(&hidden["amplitude"]) * 1e6 * hidden["shape"].get("sign").map_or(1.0, number);
        let id = hidden["id"].as_str().unwrap();
        let name = match id {
            "squareness:XY" => "EC0Y".into(),
            "squareness:ZX" => "EB0Z".into(),
            "squareness:YZ" => "EA0Z".into(),
            _ => format!("{id}.scale"),
        };
        truth.insert(name, size);
    }
    truth.extend(row.also.iter().map(|(name, value)| (name.to_string(), *value)));
    truth
}

/// Names as sentences use them: `scale` alone says nothing.
fn name_of(parameter: &Value) -> String {
    let name = parameter["name"].as_str().unwrap();
    if name == "scale" { format!("{}.scale", parameter["effect"].as_str().unwrap()) } else { name.into() }
}

/// What was found against the injected values.
struct Outcome {
    points: u64,
    rms_um: f64,
    numbers: usize,
    worst_u: f64,
    /// The wanted numbers with their standard uncertainties.
    wanted: Vec<(String, f64, String)>,
}

fn run(row: &Row, folder: &Path, wrong: &mut Vec<String>) -> Outcome {
    let recording = format!("{}.mcap", row.cycle);
    let (truth_file, cycle) = (config("truths", row.truth), config("cycles", row.cycle));
    trunnion(folder, &["simulate", &truth_file, "--cycle", &cycle, "-o", &recording]);
    let model = row.model.map(|model| config("models", model));
    let mut args = vec!["identify", recording.as_str(), "--json"];
    if let Some(model) = &model {
        args.extend(["--model", model]);
    }
    let found: Value = serde_json::from_str(&trunnion(folder, &args)).unwrap();
    let truth = truth(row);
    let true_value = |name: &str| truth.get(name).copied().unwrap_or(0.0);
    // A parameter that convention sets to zero is carried by the others of its direction.
    let carried = |name: &str| -> f64 {
        let of_direction = |direction: &Value| {
            let terms = direction["terms"].as_array().unwrap();
            let term =
                |k: usize| (terms[k]["name"].as_str().unwrap(), terms[k]["coefficient"].as_f64().unwrap());
            let own = (1..terms.len()).map(term).find(|(other, _)| *other == name)?;
            Some(-true_value(term(0).0) * own.1)
        };
        found["unobservable"].as_array().unwrap().iter().filter_map(of_direction).sum()
    };
    let (mut numbers, mut worst_u, mut wanted) = (0, 0f64, Vec::new());
    for parameter in found["parameters"].as_array().unwrap() {
        let name = name_of(parameter);
        let number = parameter["value"].as_f64().zip(parameter["u"].as_f64());
        if parameter["effect"] == "ball-setting" || parameter["effect"] == "artefact-form" {
            continue;
        }
        if let Some((value, u)) = number {
            let off = (value - true_value(&name) - carried(&name)).abs();
            worst_u = worst_u.max((off - SECOND_ORDER).max(0.0) / u);
            numbers += 1;
            if off > ALLOWED_U * u + SECOND_ORDER {
                let (own, carried) = (true_value(&name), carried(&name));
                wrong.push(format!("{}: {name} = {value} ± {u}, injected {own} + {carried}", row.scheme));
            }
            if row.identifies.contains(&name.as_str()) {
                wanted.push((name, u, parameter["unit"].as_str().unwrap().to_string()));
            }
        }
    }
    for name in row.identifies {
        if !wanted.iter().any(|(found, _, _)| found == name) {
            wrong.push(format!("{}: {name} has no number", row.scheme));
        }
    }
    Outcome {
        points: found["points"].as_u64().unwrap(),
        rms_um: found["rms_um"].as_f64().unwrap(),
        numbers,
        worst_u,
        wanted,
    }
}

/// One line of the table.
fn line(row: &Row, outcome: &Outcome) -> String {
    let model = row.model.map_or(String::new(), |model| format!(" --model config/models/{model}.toml"));
    let command = format!(
        "`trunnion simulate config/truths/{}.toml --cycle config/cycles/{}.toml -o run.mcap`<br>`trunnion identify run.mcap{model}`",
        row.truth, row.cycle
    );
    let largest = |unit: &str| {
        outcome
            .wanted
            .iter()
            .filter(|w| w.2 == unit)
            .map(|w| w.1)
            .fold(None, |most: Option<f64>, u| Some(most.map_or(u, |most| most.max(u))))
    };
    let u: Vec<String> = [("um", "µm"), ("urad", "µrad"), ("um/m", "µm/m")]
        .into_iter()
        .filter_map(|(unit, shown)| Some(format!("u ≤ {:.2} {shown}", largest(unit)?)))
        .collect();
    format!(
        "| {} | {} | {command} | {} | {} | {} numbers of the machine, all within {ALLOWED_U} u of the injected value, worst {:.1} u | {}; {} points, rms {:.2} µm |\n",
        row.scheme,
        row.source,
        row.identifies.join(", "),
        row.cannot,
        outcome.numbers,
        outcome.worst_u,
        u.join(", "),
        outcome.points,
        outcome.rms_um,
    )
}

const BEGIN: &str = "<!-- rows written by the test `schemes` -->\n";
const END: &str = "<!-- end of rows -->\n";

#[test]
fn every_scheme_finds_what_was_put_in_and_names_what_it_cannot_see() {
    let folder = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    let rows: String = ROWS.iter().map(|row| line(row, &run(row, folder.path(), &mut wrong))).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let path = format!("{ROOT}/docs/use/schemes.md");
    let document = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = document.split_once(BEGIN).unwrap();
    let (table, after) = rest.split_once(END).unwrap();
    if std::env::var_os("TRUNNION_WRITE_DOCS").is_some() {
        std::fs::write(&path, format!("{before}{BEGIN}{rows}{END}{after}")).unwrap();
        return;
    }
    // Figures may differ in the last digit between processors; all else must be current.
    let words = |table: &str| -> Vec<String> {
        table.lines().map(|line| line.split('|').take(6).collect::<Vec<_>>().join("|")).collect()
    };
    assert_eq!(words(table), words(&rows), "docs/use/schemes.md: run this test with TRUNNION_WRITE_DOCS=1");
}

/// Stations a millimetre off their places bend the prediction by more than the noise: no excuse to claim an effect.
#[test]
fn a_volume_that_the_model_describes_shows_nothing_missing() {
    let folder = tempfile::tempdir().unwrap();
    let (truth, cycle) = (config("truths", "table-bc-linear"), config("cycles", "tracker"));
    trunnion(folder.path(), &["simulate", &truth, "--cycle", &cycle, "-o", "t.mcap"]);
    let model = config("models", "volume-bc");
    let text = trunnion(folder.path(), &["diagnose", "t.mcap", "--model", &model, "--json"]);
    let answer: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(answer["verdict"], "noise-floor", "{text}");
}
