//! Volumetric accuracy through the binary: the map of a measured volume against the virtual machine's own chain.

use nalgebra::{DMatrix, DVector, Vector3};
use serde_json::Value;
use std::path::Path;
use std::process::Output;
use trunnion_core::State;
use trunnion_hil_sim::{Truth, VirtualMachine};
use trunnion_machine::{JointErrors, shipped};

const TRUTH: &str = "config/truths/table-bc-linear.toml";

fn root(path: &str) -> String {
    format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"))
}

fn trunnion(args: &[&str]) -> Output {
    crate::program::command().args(args).output().unwrap()
}

/// Expects exit 0, gives standard output.
fn done(args: &[&str]) -> String {
    let output = trunnion(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn simulate(folder: &Path, cycle: &str) -> String {
    simulate_on(folder, TRUTH, cycle)
}

fn simulate_on(folder: &Path, truth: &str, cycle: &str) -> String {
    let run = folder.join(format!("{cycle}.mcap")).display().to_string();
    done(&["simulate", &root(truth), "--cycle", &root(&format!("config/cycles/{cycle}.toml")), "-o", &run]);
    run
}

/// Deviations that the virtual machine's own chain has at places: what an R-test without setting error reads, µm.
fn true_um(positions_mm: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let truth = Truth::parse(TRUTH, &std::fs::read_to_string(root(TRUTH)).unwrap()).unwrap();
    let faultless = Truth { location: JointErrors::default(), hidden: Vec::new(), ..truth.clone() };
    let machine = |truth| VirtualMachine::new(shipped::machine("table-bc").unwrap(), truth).unwrap();
    let (real, ideal) = (machine(truth), machine(faultless));
    let deviation = |place: &Vector3<f64>| {
        let mut state = State::default();
        state.position.0[..3].copy_from_slice(place.as_slice());
        let read = |machine: &VirtualMachine| Vector3::from(machine.ideal_reading_mm(0, &state));
        (read(&real) - read(&ideal)) * 1e3
    };
    positions_mm.iter().map(deviation).collect()
}

/// Root mean square of vectors after the rigid displacement that fits best is removed, by least squares on six unknowns.
fn rms_without_rigid(places: &[Vector3<f64>], vectors: &[Vector3<f64>]) -> f64 {
    let rigid = DMatrix::from_fn(3 * places.len(), 6, |i, j| {
        let turned = |k: usize| Vector3::ith(k, 1.0).cross(&places[i / 3])[i % 3];
        if j < 3 { f64::from(u8::from(i % 3 == j)) } else { turned(j - 3) }
    });
    let stacked = DVector::from_iterator(3 * vectors.len(), vectors.iter().flat_map(|v| v.iter().copied()));
    let found = rigid.clone().svd(true, true).solve(&stacked, 1e-12).unwrap();
    ((stacked - rigid * found).norm_squared() / vectors.len() as f64).sqrt()
}

/// Columns of an error map by name.
fn columns(csv: &str, names: [&str; 3]) -> Vec<Vector3<f64>> {
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = names
        .map(|name| head.iter().position(|h| *h == name).unwrap_or_else(|| panic!("no {name} in {head:?}")));
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        Vector3::from(at.map(|k| cells[k]))
    };
    lines.map(row).collect()
}

fn value(found: &Value, name: &str) -> (f64, f64) {
    let values = found["values"].as_array().unwrap();
    let one = values.iter().find(|v| v["name"] == name).unwrap_or_else(|| panic!("no {name}"));
    (one["value"].as_f64().unwrap(), one["u"].as_f64().unwrap())
}

#[test]
fn an_r_test_has_a_range_of_its_rotary_axes_and_no_volume_of_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let run = simulate(folder.path(), "r-test-static");
    let found: Value = serde_json::from_str(&done(&["volumetric", &run, "--steps", "5", "--json"])).unwrap();
    let values = found["values"].as_array().unwrap();
    let largest = values.iter().filter_map(|value| value["value"].as_f64()).fold(0.0, f64::max);
    assert!(largest > 1.0, "{found}");
    let text = done(&["volumetric", &run, "--steps", "5"]);
    let words: Vec<&str> = text.split_whitespace().collect();
    assert!(words.join(" ").contains("says nothing of the linear axes"), "{text}");
    let refused = trunnion(&["volumetric", &run, "--volume", "X=-10..10,Y=0,Z=0"]);
    let reported = String::from_utf8(refused.stderr).unwrap();
    let words: Vec<&str> = reported.split_whitespace().collect();
    assert!(!refused.status.success(), "{reported}");
    assert!(words.join(" ").contains("nothing moves tool against table"), "{reported}");
}

/// Scales and the squareness of one plane say nothing across it, and of no turn: what arithmetic leaves there is no error of the machine.
#[test]
fn what_no_effect_of_the_model_moves_is_not_known_and_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let run = simulate_on(folder.path(), "config/truths/three-axis-circles.toml", "circle-xy");
    let model = root("config/models/straight-lines-xy.toml");
    let [csv, page] = ["map.csv", "page.html"].map(|name| folder.path().join(name).display().to_string());
    let args = ["volumetric", &run, "--model", &model, "--steps", "3", "--csv", &csv, "--html", &page];
    let found: Value = serde_json::from_str(&done(&[&args[..], &["--json"]].concat())).unwrap();
    for value in found["values"].as_array().unwrap() {
        let is_known = ["range-x", "range-y", "longest-vector"].iter().any(|name| value["name"] == *name);
        assert_eq!(value["value"].is_f64() && value["u"].as_f64() > Some(0.1), is_known, "{value}");
        assert_eq!(value["to"].as_object().unwrap().is_empty(), !is_known, "{value}");
    }
    let text = done(&["volumetric", &run, "--model", &model, "--steps", "3"]);
    let line = text.lines().find(|line| line.contains("orientation in A")).unwrap();
    assert!(line.contains("not known") && line.contains("no effect of the model"), "{text}");
    assert!(!text.contains("0.00 µ"), "{text}");
    let map = std::fs::read_to_string(csv).unwrap();
    let row: Vec<&str> = map.lines().nth(1).unwrap().split(',').collect();
    assert!(row[3..5].iter().all(|cell| cell.parse::<f64>().is_ok()), "{row:?}");
    assert!(row[5..8].iter().all(|cell| cell.is_empty()) && row.len() == 15, "{row:?}");
    let page = std::fs::read_to_string(page).unwrap();
    assert_eq!(page.matches("<svg").count(), 1, "X and Y alone");
    assert!(page.contains("not known in Z"), "the headline");
    let above = folder.path().join("above.html").display().to_string();
    done(&["volumetric", &run, "--model", &model, "--volume", "Z=0..200", "--steps", "3", "--html", &above]);
    let above = std::fs::read_to_string(above).unwrap();
    assert!(
        above.contains("Plane ZX") && above.contains("not known along Z"),
        "X moves there, Z is not known"
    );
}

#[test]
fn the_map_of_a_tracker_run_is_what_the_machine_does() {
    let folder = tempfile::tempdir().unwrap();
    let run = simulate(folder.path(), "tracker");
    let [csv, page] = ["map.csv", "page.html"].map(|name| folder.path().join(name).display().to_string());
    // Straight lines know the machine's form beforehand, component errors do not.
    for (model, most_um) in [("straight-lines-bc", 0.1), ("volume-bc", 0.3)] {
        let model_file = root(&format!("config/models/{model}.toml"));
        let found =
            done(&["volumetric", &run, "--model", &model_file, "--csv", &csv, "--html", &page, "--json"]);
        let found: Value = serde_json::from_str(&found).unwrap();
        let map = std::fs::read_to_string(&csv).unwrap();
        let places = columns(&map, ["x_mm", "y_mm", "z_mm"]);
        assert_eq!(places.len(), 343);
        let (errors, u) =
            (columns(&map, ["ex_um", "ey_um", "ez_um"]), columns(&map, ["u_ex_um", "u_ey_um", "u_ez_um"]));
        let truth = true_um(&places);
        let off: Vec<Vector3<f64>> = errors.iter().zip(&truth).map(|(e, t)| e - t).collect();
        let (difference, size) = (rms_without_rigid(&places, &off), rms_without_rigid(&places, &truth));
        assert!(difference < most_um && size > 3.0, "{model}: {difference} µm of {size} µm");
        // The uncertainties say how far off the map is.
        let expected = (u.iter().map(Vector3::norm_squared).sum::<f64>() / u.len() as f64).sqrt();
        println!("{model}: rms difference {difference:.4} µm, expected {expected:.4} µm, of {size:.3} µm");
        assert!(
            difference < 2.0 * expected && difference > expected / 3.0,
            "{model}: {difference}, u {expected}"
        );
        // One tool on the line of the spindle does not tell roll; the places of the tool point do not need it.
        assert_eq!(found["format"], "trunnion-volumetric/1");
        let unseen = found["unseen"].as_array().unwrap();
        assert_eq!(found["lower_bound"], !unseen.is_empty());
        assert_eq!(model == "volume-bc", !unseen.is_empty(), "{found}");
        assert!(unseen.iter().all(|u| u["moves"] == serde_json::json!(["C"])), "{found}");
        // The rigid displacement is removed from the map already.
        assert!((rms_without_rigid(&places, &errors) - rms_without_rigid(&places, &truth)).abs() < most_um);
        let ranges = ["range-x", "range-y", "range-z"].map(|name| value(&found, name));
        for (k, (range, u)) in ranges.into_iter().enumerate() {
            let all = || errors.iter().map(|e| e[k]);
            let here = all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min);
            assert!((here - range).abs() < 1e-3 && u > 0.0, "{k}: {range} ± {u}, map {here}");
        }
    }
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.matches("<svg").count() == 3 && !page.contains("NaN") && page.contains("deviations"));
}

#[test]
fn what_no_run_shows_makes_the_figure_a_lower_bound_and_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let tracker = simulate(folder.path(), "tracker");
    let model = root("config/models/straight-lines-bc.toml");
    let with_b = |runs: &[&str]| -> Value {
        let args =
            [&["volumetric"], runs, &["--model", &model, "--volume", "B=-60..60", "--steps", "4", "--json"]]
                .concat();
        serde_json::from_str(&done(&args)).unwrap()
    };
    // B stood still under the tracker: its errors are in no figure.
    let alone = with_b(&[&tracker]);
    let names: Vec<&str> =
        alone["unseen"].as_array().unwrap().iter().filter_map(|u| u["direction"].as_str()).collect();
    assert!(
        alone["lower_bound"] == true && names.contains(&"EX0B") && alone["stood_still"][0] == "B",
        "{alone}"
    );
    // With an R-test of B and C everything that moves the map is seen.
    let r_test = simulate(folder.path(), "r-test-static");
    let both = with_b(&[&tracker, &r_test]);
    assert_eq!(
        (&both["lower_bound"], &both["stood_still"]),
        (&false.into(), &serde_json::json!([])),
        "{both}"
    );
    assert!(value(&both, "range-x").0 > value(&alone, "range-x").0);
    // A range that was not measured is refused with what is allowed.
    for (volume, says) in
        [("X=-300..300", "−240..240"), ("Q=1..2", "allowed: X, Y, Z, B, C"), ("A=0..10", "allowed: ")]
    {
        let output = trunnion(&["volumetric", &tracker, "--model", &model, "--volume", volume]);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(1) && error.contains(says), "{volume}: {error}");
    }
}

#[test]
fn location_errors_in_both_notations() {
    let folder = tempfile::tempdir().unwrap();
    let runs = ["r-test-static", "tracker"].map(|cycle| simulate(folder.path(), cycle));
    let model = root("config/models/straight-lines-bc.toml");
    let located = |notation: &str| -> Value {
        let args = ["identify", &runs[0], &runs[1], "--model", &model, "--notation", notation, "--json"];
        let found: Value = serde_json::from_str(&done(&args)).unwrap();
        found["location_errors"].clone()
    };
    let near = |found: &Value, symbol: &str, expected: f64| {
        let values = found["values"].as_array().unwrap();
        let one = values.iter().find(|v| v["symbol"] == symbol).unwrap_or_else(|| panic!("no {symbol}"));
        let (value, u) = (one["value"].as_f64().unwrap(), one["u"].as_f64().unwrap());
        assert!((value - expected).abs() < 3.0 * u && u < 0.5, "{symbol}: {value} ± {u}, not {expected}");
    };
    // The truth file holds twists of each joint against what carries it: C on B on the bed.
    let relative = located("relative");
    for (symbol, expected) in
        [("α_CB", 40.0), ("δx_CB", -12.0), ("α_BX", 25.0), ("γ_YX", 30.0), ("α_ZY", 25.0)]
    {
        near(&relative, symbol, expected);
    }
    let absolute = located("absolute");
    for (symbol, expected) in
        [("EA0C", 65.0), ("EX0C", -4.0), ("EA0B", 25.0), ("EC0Y", 30.0), ("EB0Z", -20.0)]
    {
        near(&absolute, symbol, expected);
    }
    let text = done(&["identify", &runs[0], &runs[1], "--model", &model, "--notation", "relative"]);
    assert!(text.contains("α_CB") && text.contains("Ibaraki and Knapp 2012, tables 4 and 5"));
}

/// A number in the absolute notation is that of the line in the machine, whatever is zero by convention; what cannot be seen has none.
#[test]
fn an_absolute_location_error_is_right_or_has_no_number() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 1..=4_u64 {
        // Every error of both lines, by a sequence that repeats in no seed.
        let size = |k: usize| ((seed as f64 * 7.3 + k as f64 * 2.9).sin() * 40.0).round();
        let symbols = ["EX0", "EY0", "EZ0", "EA0", "EB0", "EC0"];
        let joint = |axis: usize, k: usize| size(6 * axis + k);
        let lines = ["B", "C"].iter().enumerate().flat_map(|(axis, letter)| {
            symbols.iter().enumerate().map(move |(k, symbol)| {
                let unit = if k < 3 { "um" } else { "urad" };
                format!("{symbol}{letter}_{unit} = {:?}", joint(axis, k))
            })
        });
        let setups = ["low", "high"].map(|name| {
            let height = if name == "low" { 60.0 } else { 160.0 };
            format!(
                "[[setup]]\nname = \"{name}\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [150.0, 0.0, {height:?}]\n\
                 setting_um = [5.0, 8.0, -7.0]\n"
            )
        });
        let text = format!(
            "format = \"trunnion-truth/1\"\nmachine = \"table-bc\"\nseed = \"{seed}\"\nrun_duration_s = 40.0\n[location]\n{}\n\
             [noise]\nwhite_um = 0.3\npass_offset_um = 0.0\ndrift_um = 0.0\ndrift_time_s = 10.0\nrepeatability_urad = 0.0\n\
             natural_motion_um = 0.0\noutlier_share = 0.0\noutlier_um = 0.0\n{}",
            lines.collect::<Vec<_>>().join("\n"),
            setups.concat()
        );
        let [truth, run] = ["toml", "mcap"]
            .map(|kind| folder.path().join(format!("seed-{seed}.{kind}")).display().to_string());
        std::fs::write(&truth, text).unwrap();
        done(&["simulate", &truth, "-o", &run]);
        let answer: Value =
            serde_json::from_str(&done(&["identify", &run, "--notation", "absolute", "--json"])).unwrap();

        let machine = shipped::machine("table-bc").unwrap();
        let through = ["B", "C"].map(|name| machine.axis(machine.joint(name).unwrap()).unwrap().through_mm);
        let lean = Vector3::from_fn(|k, _| joint(0, 3 + k));
        let moved_um = lean.cross(&(through[1] - through[0])) / 1e3;
        let in_machine = |axis: usize, k: usize| match axis {
            0 => joint(0, k),
            _ => joint(0, k) + joint(1, k) + if k < 3 { moved_um[k] } else { 0.0 },
        };
        let mut without = Vec::new();
        for error in answer["location_errors"]["values"].as_array().unwrap() {
            let symbol = error["symbol"].as_str().unwrap();
            let axis = usize::from(symbol.ends_with('C'));
            let k = symbols.iter().position(|one| symbol.starts_with(one)).unwrap();
            match error["value"].as_f64() {
                None => without.push(symbol.to_owned()),
                Some(value) => {
                    let (truth, u) = (in_machine(axis, k), error["u"].as_f64().unwrap());
                    assert!((value - truth).abs() < 4.5 * u, "{seed} {symbol}: {value} ± {u}, true {truth}");
                    assert_eq!(error["without_number"], serde_json::json!([]), "{symbol}");
                }
            }
        }
        // Along B and about B its line has no place; along and about C that of the ball in the table is not known.
        assert_eq!(without, ["EY0B", "EB0B", "EZ0C", "EC0C"], "{seed}");
    }
}
