//! NC programs through the binary: a file in the dialect asked for, and clear words for what cannot be.

use std::path::Path;
use std::process::Output;

fn trunnion(args: &[&str]) -> Output {
    crate::program::command().arg("nc-program").args(args).output().unwrap()
}

fn cycle(name: &str) -> String {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles"));
    folder.join(name).display().to_string()
}

#[test]
fn a_cycle_becomes_a_program_of_the_dialect_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = cycle("r-test-sweep-c.toml");
    for (dialect, begins, ends) in [
        ("fanuc", "%\nO7586 (R-TEST-SWEEP-C)\n", "M30\n%\n"),
        ("siemens", "; TRUNNION r-test-sweep-c\n", "M30\n"),
        ("heidenhain", "0 BEGIN PGM R_TEST_SWEEP_C MM\n", "END PGM R_TEST_SWEEP_C MM\n"),
        ("linuxcnc", "(TRUNNION r-test-sweep-c)\n", "M2\n"),
    ] {
        let path = folder.path().join(dialect).display().to_string();
        let output = trunnion(&[&sweep, "--dialect", dialect, "-o", &path]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let written = std::fs::read_to_string(&path).unwrap();
        assert!(written.starts_with(begins) && written.ends_with(ends), "{dialect}");
    }
}

#[test]
fn json_holds_the_program_and_the_poses_it_must_visit() {
    let output = trunnion(&[&cycle("r-test-static.toml"), "--dialect", "linuxcnc", "--json"]);
    let reported: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(reported["format"], "trunnion-nc-program/1");
    let visits = reported["visits"].as_array().unwrap();
    assert_eq!(visits.len(), 336);
    // Ball at (150, 0, 60) and B −90: X −60, Z 150.
    assert!((visits[0]["b_deg"].as_f64().unwrap() + 90.0).abs() < 1e-9);
    assert!((visits[0]["x_mm"].as_f64().unwrap() + 60.0).abs() < 1e-9);
    assert!(reported["program"].as_str().unwrap().matches("G4 P2.5").count() == 336);
}

#[test]
fn a_program_runs_with_tool_centre_point_control_where_it_is_asked_for() {
    let cycle = cycle("r-test-static.toml");
    for (dialect, on) in
        [("siemens", "\nTRAORI\n"), ("fanuc", "\nG43.4 H1 X"), ("heidenhain", "FUNCTION TCPM")]
    {
        let text = |more: &[&str]| {
            String::from_utf8(trunnion(&[&[&cycle, "--dialect", dialect], more].concat()).stdout).unwrap()
        };
        assert!(text(&["--tcp"]).contains(on) && !text(&[]).contains(on), "{dialect}");
    }
    let output = trunnion(&[&cycle, "--dialect", "linuxcnc", "--tcp"]);
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        reported.contains("linuxcnc has no tool centre point control here: leave --tcp out"),
        "{reported}"
    );
}

#[test]
fn what_cannot_be_written_is_refused_with_what_is_allowed() {
    let refused = |args: &[&str], expected: &str| {
        let output = trunnion(args);
        let reported = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && reported.contains(expected), "{reported}");
    };
    let sweep = cycle("r-test-sweep-c.toml");
    refused(&[&sweep, "--dialect", "mazak"], "possible values: fanuc, heidenhain, linuxcnc, siemens");
    refused(
        &[&sweep, "--dialect", "fanuc", "--chord-um", "0"],
        "--chord-um 0 is not possible; allowed: 0.01..=1000",
    );
    refused(
        &[&sweep, "--dialect", "fanuc", "--clearance-mm", "900"],
        "needs Z at 960, its travel is -400..=400",
    );
    refused(&["no-such.toml", "--dialect", "fanuc"], "cannot read no-such.toml");
}

#[test]
fn screen_and_header_say_the_same_time_and_a_number_is_taken_where_there_are_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let (cycle, path) = (cycle("r-test-static.toml"), folder.path().join("o.nc").display().to_string());
    let output = trunnion(&[&cycle, "--dialect", "fanuc", "--number", "42", "-o", &path]);
    let (said, written) = (
        String::from_utf8(output.stdout).unwrap(),
        std::fs::read_to_string(&path).unwrap().replace("\n", " "),
    );
    let minutes = said.split("about ").nth(1).and_then(|text| text.split(' ').next()).unwrap();
    let header = written.replace(")", "").replace("(", "");
    assert!(header.contains(&format!("ABOUT {minutes} MINUTES")), "{said} {header:.300}");
    assert!(written.starts_with("% O0042 "), "{written:.80}");
    let refused = trunnion(&[&cycle, "--dialect", "siemens", "--number", "42"]);
    let reported = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && reported.contains("leave --number out"), "{reported}");
}
