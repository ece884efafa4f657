//! The hybrid machine of S3 through the binary: simulated by the simulator's own kinematics, identified and diagnosed with the
//! program's.

use crate::program::{json, output};
use std::path::{Path, PathBuf};
/// A leg whose scale is 50 µm/m long, and location errors of A and C.
const TRUTH: &str = r#"format = "trunnion-truth/1"
machine = "hybrid-exechon"
seed = "5"
run_duration_s = 2000.0
[location]
EX0A_um = 12.0
EB0A_urad = 40.0
EC0A_urad = -25.0
EY0C_um = 9.0
[noise]
white_um = 0.2
pass_offset_um = 0
drift_um = 0
drift_time_s = 600
repeatability_urad = 0
natural_motion_um = 0
outlier_share = 0
outlier_um = 0
[[setup]]
name = "low"
instrument = "r-test"
nest = "table"
ball_in_table_mm = [60, 20, -40]
setting_um = [5, -4, 3]
[[setup]]
name = "high"
instrument = "r-test"
nest = "table"
ball_in_table_mm = [-50, -30, 40]
setting_um = [0, 0, 0]
[[hidden]]
id = "linear-scale:Y"
amplitude = 0.00005
[hidden.shape]
sign = 1
"#;

fn cycle() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/cycles/hybrid-static.toml")
}

#[test]
fn a_scale_error_of_a_leg_is_found_with_its_size_and_the_location_errors_with_it() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = |name: &str| dir.path().join(name).to_str().expect("a path").to_string();
    let (truth, run, model) = (path("truth.toml"), path("run.mcap"), path("model.toml"));
    std::fs::write(&truth, TRUTH).expect("a writable folder");
    json(&["simulate", &truth, "--cycle", cycle().to_str().expect("a path"), "-o", &run, "--json"]);

    let diagnosis = json(&["diagnose", &run, "--json"]);
    assert_eq!(diagnosis["candidates"][0]["effect"], "linear-scale:Y", "{diagnosis}");
    json(&["add", "linear-scale:Y", &run, "--model", &model, "--json"]);
    let fit = json(&["identify", &run, "--model", &model, "--json"]);
    assert!(fit["rms_um"].as_f64().expect("a number") < 0.22, "{}", fit["rms_um"]);
    // EC0A = −25 µrad is zero by convention: what stands for it is what moves it by 28.85 µrad for each µm of EX0A, and EB0A by −16.66 (A 60 mm
    // from C).
    let moved_um = 25.0 / 28.85;
    let expected = [
        ("scale", 50.0),
        ("EY0C", 9.0),
        ("EB0A", 40.0 - 16.66 * moved_um),
        ("EX0A", 12.0 - moved_um),
        ("EA0A", 0.0),
        ("EX0C", 0.0),
    ];
    for (name, injected) in expected {
        let all = fit["parameters"].as_array().expect("parameters");
        let parameter = all.iter().find(|parameter| parameter["name"] == name).expect("identified");
        let number = |key: &str| parameter[key].as_f64().expect("a number");
        let off = (number("value") - injected) / number("u");
        assert!(off.abs() < 4.0, "{name}: {} ± {} against {injected}", number("value"), number("u"));
    }
}

#[test]
fn an_nc_program_for_strokes_of_legs_is_refused() {
    let (good, _, err) = output(&["nc-program", cycle().to_str().expect("a path"), "--dialect", "siemens"]);
    assert!(!good && err.contains("legs in parallel"), "{err}");
}
