//! Named methods through the binary: simulate or import, identify by method, text, JSON, page.

mod circles;

use crate::program::answer;
use serde_json::Value;
use std::path::Path;

/// A machine with known errors of C, as a truth file.
const TRUTH: &str = r#"format = "trunnion-truth/1"
machine = "table-bc"
seed = "7"
run_duration_s = 600.0

[location]
EX0C_um = 2.4
EY0C_um = -10.0
EA0C_urad = -16.6
EB0B_urad = 19.2

[noise]
white_um = 0.2
pass_offset_um = 0.1
drift_um = 0.1
drift_time_s = 600.0
repeatability_urad = 0.0
natural_motion_um = 0.0
outlier_share = 0.0
outlier_um = 0.0

[[setup]]
name = "low"
instrument = "r-test"
nest = "spindle"
ball_in_table_mm = [0.0, 0.0, 66.7]
setting_um = [12.0, -7.0, 3.0]

[[hidden]]
id = "radial-error-motion:C"
amplitude = 1e-3
shape = { lobes = 3.0, u_cos = 1.0, u_sin = 0.0, v_cos = 0.0, v_sin = 1.0 }
"#;

/// Expects exit 0, gives standard output.
fn done(args: &[&str]) -> String {
    let output = answer(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    if let Ok(found) = serde_json::from_str::<Value>(&text)
        && found["format"] == "trunnion-findings/1"
    {
        numbers_have_units(&found);
    }
    text
}

/// Values of findings that are plain numbers, by the end of their names.
const PLAIN: [&str; 1] = ["share"];

/// Every value has a unit, and every decimal number of a remark is followed by one.
fn numbers_have_units(found: &Value) {
    for value in found["values"].as_array().unwrap() {
        let name = value["name"].as_str().unwrap();
        assert!(value["unit"] != "1" || PLAIN.iter().any(|end| name.ends_with(end)), "{value}");
        let remark = value["note"].as_str().unwrap();
        assert_eq!(bare_decimals(remark), Vec::<&str>::new(), "{name}: no unit in {remark:?}");
    }
}

/// Decimal numbers of a text without a unit behind them or behind the list that they are in.
fn bare_decimals(text: &str) -> Vec<&str> {
    let units = ["µm", "µrad", "°", "mm", "%", "s", "rad", "Hz"];
    let words: Vec<&str> = text.split([' ', '(', ')', ';', ',']).filter(|word| !word.is_empty()).collect();
    let is_decimal = |word: &&str| {
        word.contains('.') && word.trim_start_matches(['−', '+']).parse::<f64>().is_ok_and(f64::is_finite)
    };
    let is_bare = |(at, word): &(usize, &&str)| {
        let next = words[at + 1..].iter().find(|next| !is_decimal(next) && **next != "±" && **next != "of");
        is_decimal(word) && !next.is_some_and(|next| units.iter().any(|unit| next.starts_with(unit)))
    };
    words.iter().enumerate().filter(is_bare).map(|(_, word)| *word).collect()
}

#[test]
fn a_number_without_a_unit_is_noticed() {
    assert_eq!(bare_decimals("u of one value at most 0.08"), ["0.08"]);
    assert!(bare_decimals("1.2 ± 0.1 µm (0.5 µrad over 100 mm), −3.00 %").is_empty());
}

fn root(path: &str) -> String {
    format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"))
}

/// Simulates a shipped cycle on the machine above.
fn simulate(folder: &Path, cycle: &str) -> String {
    let (truth, run) = (folder.join("truth.toml"), folder.join(format!("{cycle}.mcap")));
    std::fs::write(&truth, TRUTH).unwrap();
    let cycle = root(&format!("config/cycles/{cycle}.toml"));
    done(&["simulate", truth.to_str().unwrap(), "--cycle", &cycle, "-o", run.to_str().unwrap()]);
    run.display().to_string()
}

/// The findings of a method; its page must be a page with pictures.
fn findings(folder: &Path, run: &str, method: &str, more: &[&str]) -> Value {
    let page = folder.join(format!("{method}.html")).display().to_string();
    let mut args = vec!["identify", run, "--method", method, "--html", &page, "--json"];
    args.extend(more);
    let found: Value = serde_json::from_str(&done(&args)).unwrap();
    assert_eq!((&found["format"], &found["method"]), (&"trunnion-findings/1".into(), &method.into()));
    let page = std::fs::read_to_string(page).unwrap();
    assert!(
        page.matches("<svg").count() >= 6 && !page.contains("http://") && !page.contains("NaN"),
        "{method}"
    );
    found
}

fn value(findings: &Value, name: &str) -> f64 {
    let values = findings["values"].as_array().unwrap();
    let found = values.iter().find(|v| v["name"] == name).unwrap_or_else(|| panic!("no value {name}"));
    found["value"].as_f64().unwrap()
}

fn near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within, "{found} is not {expected}");
}

#[test]
fn a_lag_of_the_table_is_the_part_that_grows_with_speed_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let [truth, run, page] = ["truth.toml", "feeds.mcap", "feeds.html"].map(|name| folder.path().join(name));
    // C comes 20 µs later than X and Y.
    let lag = "[[hidden]]\nid = \"sync-delay\"\namplitude = 20e-6\nshape = { sign = 1.0 }\n";
    std::fs::write(&truth, format!("{TRUTH}\n{lag}")).unwrap();
    let [truth, run, page] = [truth, run, page].map(|path| path.display().to_string());
    let cycle = root("config/cycles/r-test-feeds-c.toml");
    done(&["simulate", &truth, "--cycle", &cycle, "-o", &run]);
    let found = done(&["identify", &run, "--method", "quasi-static", "--html", &page, "--json"]);
    let found: Value = serde_json::from_str(&found).unwrap();
    // 20 µs at 7200 °/min on a radius of 150 mm.
    let lag_um = 20e-6 * 7200_f64.to_radians() / 60.0 * 150e3;
    near(value(&found, "ball-setting.low.y part with speed"), -lag_um, 0.25);
    near(value(&found, "EX0C quasi-static part"), 2.4, 0.5);
    near(value(&found, "EX0C part with speed"), 0.0, 0.5);
    near(value(&found, "EY0C quasi-static part"), -10.0, 0.5);
    assert!(std::fs::read_to_string(page).unwrap().contains("Errors over the feed"));
    // Where the ball was mounted is no error of the machine; what grows with the feed is.
    let kind = |name: &str| {
        let values = found["values"].as_array().unwrap();
        values.iter().find(|v| v["name"] == name).unwrap()["kind"].as_str().unwrap().to_string()
    };
    assert_eq!(kind("ball-setting.low.y quasi-static part"), "setting");
    assert_eq!(kind("ball-setting.low.y part with speed"), "error");
    let text = done(&["identify", &run, "--method", "quasi-static"]);
    let headline = text.lines().find(|line| line.contains("moves the tool most")).unwrap();
    assert!(
        headline.trim_start().starts_with("The quasi-static part of the place of axis C along Y"),
        "{headline}"
    );
}

#[test]
fn two_heights_give_location_errors_and_error_motions_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let run = simulate(folder.path(), "two-height-c");
    let found = findings(folder.path(), &run, "two-height", &[]);
    near(value(&found, "EX0C"), 2.4, 0.5);
    near(value(&found, "EY0C"), -10.0, 0.5);
    near(value(&found, "EA0C"), -16.6, 4.0);
    near(value(&found, "EB0C"), 19.2, 4.0);
    near(value(&found, "setting.low.x"), 12.0, 0.2);
    assert!(done(&["identify", &run, "--method", "two-height"]).contains("EB0C"));
    // S0's signs, the axis by name.
    let source = findings(folder.path(), &run, "two-height", &["--convention", "source", "--axis", "C"]);
    assert_eq!(source["convention"], "source");
    near(value(&source, "EA0C"), 16.6, 4.0);
}

#[test]
fn values_of_iso_230_7_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let run = simulate(folder.path(), "rotary-values-c");
    let found = findings(folder.path(), &run, "rotary-values", &[]);
    near(value(&found, "low.radial-x.synchronous"), 2.0, 0.7);
    assert!(value(&found, "low.radial-x.total") > value(&found, "low.radial-x.synchronous"));
}

#[test]
fn an_error_map_from_imported_points() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("points.mcap").display().to_string();
    let data = root("tests/data/points-gravity");
    done(&["import", &format!("{data}/points.csv"), "--setup", &format!("{data}/setup.toml"), "-o", &run]);
    let found = findings(folder.path(), &run, "error-map", &[]);
    assert!(value(&found, "left by map of tilting axis") < 0.4);
    let values = found["values"].as_array().unwrap();
    let sag = values.iter().find(|value| value["name"] == "EZB range at most").unwrap();
    let note = sag["note"].as_str().unwrap();
    let as_read = note.split("as read ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    assert!(as_read.parse::<f64>().unwrap() > 2.0 && sag["u"].is_null(), "{sag}");
}

/// Simulates a cycle on a machine: a shipped truth, hidden errors added.
fn simulate_on(folder: &Path, truth: &str, hidden: &str, cycle: &str) -> String {
    let shipped = std::fs::read_to_string(root(&format!("config/truths/{truth}.toml"))).unwrap();
    let honest = shipped.split("[[hidden]]").next().unwrap();
    let (truth, run) = (folder.join("hidden.toml"), folder.join(format!("{cycle}.mcap")));
    std::fs::write(&truth, format!("{honest}\n{hidden}")).unwrap();
    let cycle = root(&format!("config/cycles/{cycle}.toml"));
    done(&["simulate", truth.to_str().unwrap(), "--cycle", &cycle, "-o", run.to_str().unwrap()]);
    run.display().to_string()
}

/// A hidden error of a truth file.
fn hidden(id: &str, amplitude: f64, shape: &str) -> String {
    format!("[[hidden]]\nid = \"{id}\"\namplitude = {amplitude:e}\nshape = {{ {shape} }}\n\n")
}

/// The findings of a method as JSON.
fn identified(run: &str, method: &str) -> Value {
    serde_json::from_str(&done(&["identify", run, "--method", method, "--json"])).unwrap()
}

#[test]
fn a_ball_bar_gives_the_axes_of_c_and_b_from_two_files() {
    let folder = tempfile::tempdir().unwrap();
    let c = simulate_on(folder.path(), "table-bc-y", "", "s4-c");
    let b = simulate_on(folder.path(), "table-bc-y", "", "s4-b");
    let found = findings(folder.path(), &c, "ball-bar", &[&b]);
    // Of the truth: C carries the errors of B, which stands at zero.
    for (name, injected, within) in [
        ("EX0C", 8.0 - 12.0, 0.2),
        ("EY0C", 9.0, 0.2),
        ("EA0C", 25.0 + 40.0, 1.5),
        ("EB0C", -30.0, 1.5),
        ("EX0B", 8.0, 0.2),
        ("EZ0B", -6.0, 0.2),
        ("EA0B", 25.0, 1.5),
        ("EC0B", 18.0, 1.5),
    ] {
        near(value(&found, name), injected, within);
    }
    let cone = simulate_on(folder.path(), "table-bc", "", "bk4-cone");
    let page = folder.path().join("cone.html").display().to_string();
    let text = done(&["identify", &cone, "--method", "ball-bar", "--html", &page]);
    assert!(text.contains("path cone circularity"), "{text}");
    assert!(std::fs::read_to_string(page).unwrap().contains("Radial error over the path"));
}

#[test]
fn error_motions_are_the_injected_harmonics() {
    let lobed = "[[hidden]]\nid = \"radial-error-motion:C\"\namplitude = 3e-3\n\
                 shape = { lobes = 3.0, u_cos = 1.0, u_sin = 0.0, v_cos = 0.0, v_sin = 0.0 }\n\n";
    let folder = tempfile::tempdir().unwrap();
    let run = simulate_on(folder.path(), "table-bc", lobed, "two-height-c");
    let text = done(&["identify", &run, "--method", "two-height", "--json"]);
    let found: Value = serde_json::from_str(&text).unwrap();
    // 3 µm of cos 3C along X: a range of 6 µm there, nothing along Y.
    near(value(&found, "EXC range"), 6.0, 0.25);
    let names = found["values"].as_array().unwrap().iter().map(|v| v["name"].as_str().unwrap());
    assert!(!names.into_iter().any(|name| name == "EYC range"), "nothing of Y is significant");
    // A tenth of that range bounds what noise hides (95 %).
    assert!(value(&found, "EYC range of one wave at most") < 0.6, "{found}");
    assert!(text.contains("3 a turn: 3.0") || text.contains("3 a turn: 2.9"), "{text}");
    // A bar names the cause of what is significant, and of nothing else.
    let run = simulate_on(folder.path(), "table-bc-y", lobed, "s4-c");
    let text = done(&["identify", &run, "--method", "ball-bar", "--json"]);
    assert!(text.contains("three-lobed ring") && !text.contains("backlash or friction"), "{text}");
    assert!(!text.contains("oval ring"), "{text}");
}

#[test]
fn a_laser_along_x_gives_the_values_of_iso_230_2_of_what_was_put_in() {
    let hidden = "[[hidden]]\nid = \"backlash:X\"\namplitude = 2e-3\nshape = { sign = -1.0 }\n\n\
                  [[hidden]]\nid = \"linear-scale:X\"\namplitude = 2e-5\nshape = { sign = 1.0 }\n\n";
    let folder = tempfile::tempdir().unwrap();
    let run = simulate_on(folder.path(), "three-axis", hidden, "linear-x");
    let text = done(&["identify", &run, "--method", "positioning", "--json"]);
    let found: Value = serde_json::from_str(&text).unwrap();
    // Eleven targets are reached from both sides five times each, over 363 mm, of which 20 µm/m make 7.26 µm; with ½ h on either side 9.26 µm.
    // u of a mean of five at 0.3 µm is 0.13 µm, of the mean reversal of eleven targets 0.06 µm; extremes lie a little outside.
    near(value(&found, "X mean reversal"), -2.0, 4.0 * 0.06);
    near(value(&found, "X M"), 7.26, 0.5);
    near(value(&found, "X E"), 9.26, 0.6);
    let counts: Vec<&Value> =
        found["tables"][0]["rows"].as_array().unwrap().iter().flat_map(|row| [&row[1], &row[4]]).collect();
    assert!(counts.len() == 22 && counts.iter().all(|count| count.as_str() == Some("5")), "{counts:?}");
    assert!(!text.contains("from one side"), "{text}");
    assert!(value(&found, "X A") > value(&found, "X E"));
}

#[test]
fn what_cannot_be_done_is_refused_with_what_can() {
    let folder = tempfile::tempdir().unwrap();
    let run = simulate(folder.path(), "r-test-sweep-b");
    let check = |args: &[&str], code: i32, words: &[&str]| {
        let output = answer(&[&["identify", &run], args].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{error}");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    check(&["--method", "two-hight"], 2, &["two-hight", "two-height", "error-map", "rotary-values"]);
    check(&["--method", "two-height"], 1, &["X, Z", "axis line", "two-height-c.toml"]);
    check(&["--method", "error-map"], 1, &["on the fly", "two nest positions"]);
    // Any joint has a name; which ones turn, the machine of the run says.
    check(&["--method", "two-height", "--axis", "X"], 2, &["no rotary axis \"X\"", "B, C"]);
    check(&["--method", "two-height", "--convention", "left"], 2, &["right-handed", "source"]);
    check(&["--convention", "source"], 2, &["--method"]);
}

/// The virtual machine's tool side grows along X with one time constant; its R-test sees the line of B go the other way.
#[test]
fn a_machine_that_warms_up_is_followed_round_by_round() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (tau_s, final_um) = (1500.0, 20.0);
    let hidden = TRUTH.find("[[hidden]]").unwrap();
    let grows = format!(
        "[[hidden]]\nid = \"thermal-drift\"\namplitude = {}\nshape = {{ fast_s = {tau_s:.1}, slow_s = 9000.0, fast_x = 1.0, fast_y = 0.0, fast_z = 0.0, \
         slow_x = 0.0, slow_y = 0.0, slow_z = 0.0 }}\n",
        final_um * 1e-3
    );
    std::fs::write(path("truth.toml"), format!("{}{grows}", &TRUTH[..hidden])).unwrap();
    let cycle = std::fs::read_to_string(root("config/cycles/r-test-static.toml")).unwrap();
    let cycle = cycle.replace("step_deg = 30", "step_deg = 90");
    let rounds = "\n[rounds]\ncount = 16\nwait_s = 120\ninterleave = true\n";
    std::fs::write(path("cycle.toml"), cycle + rounds).unwrap();
    done(&["simulate", &path("truth.toml"), "--cycle", &path("cycle.toml"), "-o", &path("warm.mcap")]);

    let page = path("thermal.html");
    let identify = ["identify", &path("warm.mcap"), "--method", "thermal", "--html", &page, "--json"];
    let found: Value = serde_json::from_str(&done(&identify)).unwrap();
    let value = |name: &str| {
        let values = found["values"].as_array().unwrap();
        let one = values.iter().find(|value| value["name"] == name).unwrap_or_else(|| panic!("no {name}"));
        (one["value"].as_f64().unwrap(), one["u"].as_f64().unwrap())
    };
    let rows = found["tables"][0]["rows"].as_array().unwrap();
    let time_s = |row: usize| rows[row][0].as_f64().unwrap();
    let gone_um = |row: usize| -final_um * (1.0 - (-time_s(row) / tau_s).exp());
    let (change, u) = value("EX0B change");
    let expected = gone_um(rows.len() - 1) - gone_um(0);
    assert!((change - expected).abs() < 4.5 * u + 0.1, "EX0B {change} ± {u}, true {expected}");
    let (tau, u) = value("EX0B time constant");
    assert!((tau - tau_s).abs() < 4.5 * u, "{tau} ± {u} s, true {tau_s}");
    let (change, u) = value("EA0C change");
    assert!(change.abs() < 4.5 * u, "EA0C {change} ± {u}, true 0");
    assert!(std::fs::read_to_string(&page).unwrap().contains("Place of the axis lines"));
}
