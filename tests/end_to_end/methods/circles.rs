//! Circles of linear axes through the binary, of the simulator and of files.

use super::{done, hidden, identified, near, simulate_on, value};
use crate::one_line;
use std::path::Path;

/// A table of points with these columns alone.
fn with_columns(text: &str, kept: &[&str]) -> String {
    let heads: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let at: Vec<usize> =
        kept.iter().map(|name| heads.iter().position(|head| head == name).unwrap()).collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        at.iter().map(|&k| cells[k]).collect::<Vec<_>>().join(",") + "\n"
    };
    text.lines().map(row).collect()
}

#[test]
fn circles_name_the_injected_errors_and_leave_what_the_list_lacks() {
    let listed = hidden("squareness:XY", 3e-5, "sign = 1.0")
        + &hidden("linear-scale:X", 2e-5, "sign = 1.0")
        + &hidden("backlash:X", 4e-3, "sign = -1.0")
        + &hidden("servo-lag:Y", 3e-4, "sign = 1.0")
        + &hidden("reversal-spike:Y", 6e-3, "decay = 3.0");
    let folder = tempfile::tempdir().unwrap();
    let run = simulate_on(folder.path(), "three-axis", &listed, "circle-xy");
    let found = identified(&run, "circular");
    near(value(&found, "XY EC0Y"), 30.0, 1.5);
    near(value(&found, "XY scale X−Y"), 20.0, 2.5);
    near(value(&found, "XY backlash X"), -4.0, 0.4);
    near(value(&found, "XY servo X−Y"), -0.3, 0.04);
    near(value(&found, "XY reversal spike Y"), 6.0, 0.5);
    assert!(value(&found, "XY unexplained beyond noise") < 0.12);
    // An S-shaped guide is on no list.
    let bent = hidden(
        "straightness:X",
        5e-3,
        "middle_mm = 0.0, half_length_mm = 150.0, u_bow = 0.0, u_s = 1.0, v_bow = 0.0, v_s = 0.0",
    );
    let folder = tempfile::tempdir().unwrap();
    let run = simulate_on(folder.path(), "three-axis", &(listed + &bent), "circle-xy");
    let found = identified(&run, "circular");
    assert!(value(&found, "XY unexplained beyond noise") > 0.8);
    assert!(value(&found, "XY unexplained share") > 0.1);
    let text = one_line(done(&["identify", &run, "--method", "circular"]).as_bytes());
    assert!(text.contains("something is not on the list"), "{text}");
}

#[test]
fn a_circle_from_a_file_gives_the_same_as_the_run_it_came_from() {
    let listed = hidden("backlash:X", 2e-3, "sign = -1.0") + &hidden("servo-lag:X", 4e-4, "sign = 1.0");
    let folder = tempfile::tempdir().unwrap();
    let run = simulate_on(folder.path(), "three-axis", &listed, "circle-xy");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (points, setup) = (path("points.csv"), path("setup.toml"));
    done(&["export", "csv", &run, "-o", &points]);
    let setups = "format = \"trunnion-points/1\"\nmachine = \"three-axis\"\n\n[[setup]]\nname = \"xy\"\n\
                  instrument = \"ball-bar\"\nball_in_table_mm = [0, 0, 100]\nbar_length_mm = 150\n";
    std::fs::write(&setup, setups).unwrap();
    let text = std::fs::read_to_string(&points).unwrap();
    // A table of another program: positions and readings alone, no time, no speed.
    let bare = path("bare.csv");
    std::fs::write(&bare, with_columns(&text, &["setup", "x_mm", "y_mm", "z_mm", "dr_um"])).unwrap();
    let (back, foreign) = (path("back.mcap"), path("foreign.mcap"));
    done(&["import", &points, "--setup", &setup, "--kind", "on-the-fly", "-o", &back]);
    done(&["import", &bare, "--setup", &setup, "-o", &foreign]);
    // The same with times, imported as if it were static.
    let (timed, by_time) = (path("timed.csv"), path("timed.mcap"));
    std::fs::write(&timed, with_columns(&text, &["setup", "time_s", "x_mm", "y_mm", "z_mm", "dr_um"]))
        .unwrap();
    done(&["import", &timed, "--setup", &setup, "-o", &by_time]);
    for (run, servo, injected) in [
        (&run, "XY servo X−Y", 0.4),
        (&back, "XY servo X−Y", 0.4),
        (&by_time, "XY servo X−Y", 0.4),
        (&foreign, "XY servo X−Y × speed", 6.67),
    ] {
        let found = identified(run, "circular");
        near(value(&found, "XY backlash X"), -2.0, 0.3);
        near(value(&found, servo), injected, 0.07 * injected);
        let names = found["values"].as_array().unwrap().iter().map(|v| v["name"].as_str().unwrap());
        assert!(!names.into_iter().any(|name| name.contains("spike")), "{found}");
    }
}

#[test]
fn a_result_file_of_a_ball_bar_is_no_table_of_points_and_the_way_to_use_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (file, run) = (path("xy.b5r"), path("xy.mcap"));
    std::fs::write(&file, "<T><PLANE TEST_PLANE=\"XY\"/></T>").unwrap();
    let reported = crate::program::refused(&["import", &file, "-o", &run]);
    assert!(reported.contains(&format!("--method circular --against {file}")), "{reported}");
    assert!(!Path::new(&run).exists());
}
