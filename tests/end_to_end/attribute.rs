//! Which axis made the deviation, through the binary: on the simulator, and S3's example on the hybrid machine.

use crate::program::{json, output, refused, trunnion, written};
use nalgebra::{Point3, Vector3};
use serde_json::Value;
use std::path::{Path, PathBuf};
use trunnion_core::axis::iso::{A, Y};
use trunnion_core::{AxisSample, AxisValues};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::shipped;
use trunnion_record::{RunHeader, write_run_with_axes};

const TRUTH: &str = r#"format = "trunnion-truth/1"
machine = "MACHINE"
seed = "5"
run_duration_s = 100.0
[location]
EA0C_urad = 40.0
[noise]
white_um = 0.3
pass_offset_um = 0.1
drift_um = 0.1
drift_time_s = 600
repeatability_urad = 0
natural_motion_um = 0.2
outlier_share = 0
outlier_um = 0
[[setup]]
name = "low"
instrument = "r-test"
nest = "table"
ball_in_table_mm = [BALL]
setting_um = [3, -2, 1]
[[hidden]]
id = "ID"
amplitude = AMPLITUDE
[hidden.shape]
SHAPE
"#;

fn shipped_cycle(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/cycles").join(format!("{name}.toml"))
}

fn attribute(run: &Path, more: &[&str]) -> Value {
    let run = run.to_str().expect("a path");
    let (good, out, err) = output(&[&["attribute", run, "--json"], more].concat());
    assert!(good, "{err}");
    serde_json::from_str(&out).expect("JSON")
}

/// Axis and peak (µm) of the largest share, and of the next one.
fn peaks(findings: &Value) -> Vec<(String, f64)> {
    let peak = |value: &Value| {
        let name = value["name"].as_str().expect("a name").trim_start_matches("peak by ").to_string();
        (name, value["value"].as_f64().expect("a number"))
    };
    let values = findings["values"].as_array().expect("values").iter();
    values.filter(|value| value["kind"] != "summary").map(peak).collect()
}

/// A row of the table of shares: rms X Y Z, peak X Y Z (µm), tool turns rms, peak (µrad).
fn row(findings: &Value, axis: &str) -> Vec<f64> {
    let rows = findings["tables"][0]["rows"].as_array().expect("rows");
    let row = rows.iter().find(|row| row[0] == axis).expect("the axis has a row");
    row.as_array().expect("cells")[2..].iter().map(|cell| cell.as_f64().expect("a number")).collect()
}

fn simulate(dir: &Path, cycle: &str, replace: &[(&str, &str)]) -> PathBuf {
    let text = replace.iter().fold(TRUTH.to_string(), |text, (from, to)| text.replace(from, to));
    let (truth, run) = (dir.join("truth.toml"), dir.join("run.mcap"));
    std::fs::write(&truth, text).expect("a writable folder");
    let path = |path: &Path| path.to_str().expect("a path").to_string();
    let (good, _, err) =
        output(&["simulate", &path(&truth), "--cycle", cycle, "--points-per-s", "100", "-o", &path(&run)]);
    assert!(good, "{err}");
    run
}

#[test]
fn the_axis_with_the_hidden_following_error_is_named_with_its_size() {
    let cycle = shipped_cycle("r-test-sweep-c");
    let cycle = cycle.to_str().expect("a path");
    let table = [("MACHINE", "table-bc"), ("BALL", "150.0, 0.0, 60.0")];
    let check = |id: &str, amplitude: &str, shape: &str, axis: &str, peak_um: f64, part: usize| {
        let dir = tempfile::tempdir().expect("a folder");
        let replace = [&table[..], &[("ID", id), ("AMPLITUDE", amplitude), ("SHAPE", shape)]].concat();
        let found = attribute(&simulate(dir.path(), cycle, &replace), &[]);
        let peaks = peaks(&found);
        assert_eq!(peaks[0].0, axis, "{id}: {peaks:?}");
        assert!((peaks[0].1 / peak_um - 1.0).abs() < 0.05, "{id}: {peaks:?}");
        assert!(peaks.get(1).is_none_or(|next| next.1 < 0.05 * peak_um), "{id}: {peaks:?}");
        // Along the axis alone.
        let row = row(&found, axis);
        assert!((row[3 + part].abs() / peak_um - 1.0).abs() < 0.05, "{id}: {row:?}");
        assert!(found["notes"][0].as_str().expect("a note").contains("cycle r-test-sweep-c"), "{found}");
    };
    // 0.5 ms at 150 mm · 60°/s: 78.5 µm. 10 µm at the reversal; the nearest sample is a little after it.
    check("servo-lag:X", "0.0005", "sign = 1", "X", 78.54, 0);
    check("reversal-spike:Y", "0.010", "decay = 0.5", "Y", 10.0, 1);
}

/// A table holds both positions of a row: the way out and back changes nothing, and a path through points a tenth of a second apart, which cannot
/// follow the turn, is no judge.
#[test]
fn a_run_that_went_through_a_table_is_judged_by_its_commanded_positions() {
    let dir = tempfile::tempdir().expect("a folder");
    let setup = "format = \"trunnion-points/1\"\nmachine = \"table-bc\"\n[[setup]]\nname = \"low\"\ninstrument = \"r-test\"\n\
                 nest = \"table\"\nball_in_table_mm = [150, 0, 60]\n";
    let setup = written(dir.path(), "setup.toml", setup);
    let cycle = shipped_cycle("r-test-sweep-c");
    let again = |id: &str, amplitude: &str| {
        let dir = tempfile::tempdir().expect("a folder");
        let table = [("MACHINE", "table-bc"), ("BALL", "150.0, 0.0, 60.0"), ("SHAPE", "sign = 1")];
        let replace = [&table[..], &[("ID", id), ("AMPLITUDE", amplitude)]].concat();
        let run = simulate(dir.path(), cycle.to_str().expect("a path"), &replace);
        let points =
            written(dir.path(), "points.csv", &trunnion(&["export", "csv", run.to_str().expect("a path")]));
        let imported = dir.path().join("imported.mcap").display().to_string();
        trunnion(&["import", &points, "--setup", &setup, "--kind", "on-the-fly", "-o", &imported]);
        (dir, imported)
    };
    let (_exact, exact) = again("backlash:C", "0.00005");
    let found = json(&["attribute", &exact, "--json"]);
    assert_eq!(found["values"][0]["value"], 0.0, "{found}");
    assert!(found["notes"][0].as_str().expect("a note").contains("the same positions twice"), "{found}");
    let error = refused(&["attribute", &exact, "--smooth"]);
    assert!(error.contains("not separated") && error.contains("x_actual_mm"), "{error}");

    let (_late, late) = again("servo-lag:X", "0.0005");
    let late = json(&["attribute", &late, "--json"]);
    let peaks = peaks(&late);
    assert!(peaks.len() == 1 && peaks[0].0 == "X" && (peaks[0].1 / 78.54 - 1.0).abs() < 0.01, "{peaks:?}");
}

/// A circle of X and Y as ISO 230-4 has it: each axis sticks for 8 µm where it turns round.
#[test]
fn a_reversal_spike_on_a_circle_is_given_to_its_axis() {
    let dir = tempfile::tempdir().expect("a folder");
    let cycle = dir.path().join("cycle.toml");
    let text = "format = \"trunnion-cycle/1\"\nname = \"xy-circle\"\nmachine = \"table-bc\"\nkind = \"on-the-fly\"\n\
                [[setup]]\nname = \"low\"\ninstrument = \"ball-bar\"\nbar_length_mm = 100\nball_in_table_mm = [0, 0, 60]\n\
                [circle]\nplane = \"XY\"\nfrom_deg = -180\nto_deg = 540\nfeeds_mm_per_min = [1000]\n";
    std::fs::write(&cycle, text).expect("a writable folder");
    let replace = [
        ("MACHINE", "table-bc"),
        (
            "instrument = \"r-test\"\nnest = \"table\"",
            "instrument = \"ball-bar\"\nlength_mm = 100.0\nnest = \"table\"",
        ),
        ("BALL", "0.0, 0.0, 60.0"),
        ("ID", "reversal-spike:X"),
        ("AMPLITUDE", "0.008"),
        ("SHAPE", "decay = 1.0"),
    ];
    let found = attribute(&simulate(dir.path(), cycle.to_str().expect("a path"), &replace), &[]);
    let peaks = peaks(&found);
    assert!(found["notes"][0].as_str().expect("a note").contains("angle on the curve"), "{found}");
    assert_eq!(peaks[0].0, "X", "{peaks:?}");
    assert!((peaks[0].1 / 8.0 - 1.0).abs() < 0.05, "{peaks:?}");
    assert!(peaks.iter().skip(1).all(|(_, peak_um)| *peak_um < 0.3), "{peaks:?}");
}

/// What no encoder sees is in no share: lost motion behind the encoder.
#[test]
fn backlash_behind_the_encoder_is_in_no_share() {
    let dir = tempfile::tempdir().expect("a folder");
    let cycle = shipped_cycle("r-test-sweep-c");
    let replace = [
        ("MACHINE", "table-bc"),
        ("BALL", "150.0, 0.0, 60.0"),
        ("ID", "backlash:C"),
        ("AMPLITUDE", "0.00005"),
        ("SHAPE", "sign = 1"),
    ];
    let found = attribute(&simulate(dir.path(), cycle.to_str().expect("a path"), &replace), &[]);
    assert!(peaks(&found).iter().all(|(_, peak_um)| *peak_um < 1e-3), "{found}");
}

/// The hybrid machine turns A while the legs follow the ball; leg 2 lags 0.2 ms.
#[test]
fn a_leg_of_the_hybrid_machine_that_lags_is_named() {
    let dir = tempfile::tempdir().expect("a folder");
    let cycle = dir.path().join("cycle.toml");
    let text = "format = \"trunnion-cycle/1\"\nname = \"a-sweep\"\nmachine = \"hybrid-exechon\"\nkind = \"on-the-fly\"\n\
                [[setup]]\nname = \"low\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [10, 5, -20]\n\
                [sweep]\naxis = \"A\"\nfrom_deg = -15\nto_deg = 15\nfeeds_deg_per_min = [300]\nc_deg = 0\n";
    std::fs::write(&cycle, text).expect("a writable folder");
    let replace = [
        ("MACHINE", "hybrid-exechon"),
        ("BALL", "10.0, 5.0, -20.0"),
        ("ID", "servo-lag:Y"),
        ("AMPLITUDE", "0.0002"),
        ("SHAPE", "sign = 1"),
    ];
    let found = attribute(&simulate(dir.path(), cycle.to_str().expect("a path"), &replace), &[]);
    let peaks = peaks(&found);
    assert_eq!(peaks[0].0, "Y", "{peaks:?}");
    assert!(peaks.len() == 1 || peaks[1].1 < 0.02 * peaks[0].1, "{peaks:?}");
    // About three times its own error at the tool, as the Jacobian says (S3 fig. 8), and the tool turns.
    let own = found["tables"][0]["rows"][0][1].as_str().expect("its own peak");
    let own_um: f64 = own.split_whitespace().next().and_then(|n| n.parse().ok()).expect("a number");
    assert!((2.5..4.5).contains(&(peaks[0].1 / own_um.abs())), "{peaks:?} {own}");
    assert!(row(&found, "Y")[7] > 0.0);
}

/// S3 fig. 6–9: a straight line along X at 150 mm/min, tool vertical. By symmetry axis 2 and A turn round in the middle;
/// 10 µm on axis 2 there, and 10.7 µrad on A (3 µm on its arm of 280 mm).
#[test]
fn the_reversal_of_s3_is_given_to_axis_2() {
    let machine = shipped::machine("hybrid-exechon").expect("shipped");
    let feed_mm_per_s = 150.0 / 60.0;
    let mut last = AxisValues::default();
    let samples: Vec<AxisSample> = (0..1601)
        .map(|i| {
            let time_s = f64::from(i) * 0.01;
            let place = Point3::new(feed_mm_per_s * (time_s - 8.0), 0.0, 0.0);
            let mut position = machine.reach(&last, &place, &Vector3::z_axis()).expect("within reach");
            last = position;
            let pulse = |begin_s: f64, long_s: f64| {
                let u = (time_s - begin_s) / long_s;
                if (0.0..1.0).contains(&u) { (std::f64::consts::PI * u).sin() } else { 0.0 }
            };
            position[Y] += 0.010 * pulse(8.0, 0.3);
            position[A] += 0.003 / 280.0 * pulse(7.5, 0.2);
            AxisSample { time_s, position, ..AxisSample::default() }
        })
        .collect();
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("line.mcap");
    let text = shipped::FILES.iter().find(|(name, _)| *name == "hybrid-exechon").expect("shipped").1;
    let run = Run {
        name: "line".into(),
        machine,
        kind: RunKind::OnTheFly,
        setups: Vec::new(),
        channels: Vec::new(),
        points: Vec::new(),
    };
    let header = RunHeader::of_run(&run, text, "test", 0);
    write_run_with_axes(&path, &header, &run, &samples).expect("a writable folder");

    let page = dir.path().join("page.html");
    let found = attribute(&path, &["--html", page.to_str().expect("a path")]);
    let peaks = peaks(&found);
    assert_eq!(peaks[0].0, "Y", "{peaks:?}");
    let of_leg = row(&found, "Y");
    assert!((of_leg[4].abs() - 30.0).abs() < 1.0 && (of_leg[5].abs() - 15.0).abs() < 0.7, "{of_leg:?}");
    let of_a = row(&found, "A");
    assert!((of_a[4].abs() - 3.0).abs() < 0.15 && of_a[5].abs() < 0.5, "{of_a:?}");
    for quiet in ["X", "Z", "C"] {
        assert!(peaks.iter().all(|(axis, peak_um)| axis != quiet || *peak_um < 0.3), "{peaks:?}");
    }
    assert!(found["notes"][0].as_str().expect("a note").contains("smooth path"), "{found}");
    let html = std::fs::read_to_string(&page).expect("the page");
    assert!(html.contains("Shares over time") && html.contains("<svg"));
}

#[test]
fn a_recording_without_axis_positions_says_what_to_do() {
    let dir = tempfile::tempdir().expect("a folder");
    let cycle = shipped_cycle("r-test-static");
    let replace = [
        ("MACHINE", "table-bc"),
        ("BALL", "150.0, 0.0, 60.0"),
        ("ID", "backlash:C"),
        ("AMPLITUDE", "0.00005"),
        ("SHAPE", "sign = 1"),
    ];
    let run = simulate(dir.path(), cycle.to_str().expect("a path"), &replace);
    let (good, _, err) = output(&["attribute", run.to_str().expect("a path")]);
    assert!(!good);
    assert!(err.contains("holds 0 axis positions") && err.contains("on the fly"), "{err}");
}
