//! Bad input through the binary: file, line, what was found, what is allowed; exit codes of the contract.

use crate::program::{answer, trunnion, written};
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use trunnion_core::Gap;

pub fn data(file: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity")).join(file)
}

/// The committed points, their rows changed by a function of all of them, imported into a folder: the recording.
pub fn imported(folder: &Path, change: impl FnOnce(&str, Vec<&str>) -> Vec<String>) -> String {
    let path = |name: &str| folder.join(name).display().to_string();
    let points = std::fs::read_to_string(data("points.csv")).unwrap();
    let (head, rows) = points.split_once('\n').unwrap();
    let rows = change(head, rows.lines().collect());
    std::fs::write(path("points.csv"), format!("{head}\n{}\n", rows.join("\n"))).unwrap();
    std::fs::copy(data("setup.toml"), path("setup.toml")).unwrap();
    let output = answer(&["import", &path("points.csv"), "-o", &path("run.mcap")]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    path("run.mcap")
}

/// The same with one column changed row by row.
fn imported_with(folder: &Path, column: &str, change: impl Fn(usize, &str) -> String) -> String {
    imported(folder, |head, rows| {
        let column = head.split(',').position(|name| name == column).unwrap();
        let changed = rows.into_iter().enumerate().map(|(row, line)| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            cells[column] = change(row, &cells[column]);
            cells.join(",")
        });
        changed.collect()
    })
}

/// Expects exit 1 and every one of `words` on standard error.
pub fn check_refused(args: &[&str], words: &[&str]) {
    let output = answer(args);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{args:?}: {error}");
    for word in words {
        assert!(error.contains(word), "{word:?} is missing in: {error}");
    }
}

fn import_with(points: &str, setup: &str, words: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let (points_path, setup_path) = (folder.path().join("points.csv"), folder.path().join("setup.toml"));
    std::fs::write(&points_path, points).unwrap();
    std::fs::write(&setup_path, setup).unwrap();
    let run = folder.path().join("run.mcap");
    let args = ["import", points_path.to_str().unwrap(), "-o", run.to_str().unwrap()];
    check_refused(&args, words);
    assert!(!run.exists(), "nothing is written from refused input");
}

#[test]
fn a_broken_points_file_is_refused_with_line_and_column() {
    let (points, setup) = (
        std::fs::read_to_string(data("points.csv")).unwrap(),
        std::fs::read_to_string(data("setup.toml")).unwrap(),
    );
    import_with(&points.replacen("-21.40", "abc", 1), &setup, &["points.csv:2", "abc", "number"]);
    import_with(&points.replacen("dx_um", "dx_mm", 1), &setup, &["points.csv:1", "dx_mm", "dx_um"]);
    import_with(&points.replacen("\nlow,", "\nmiddle,", 1), &setup, &["points.csv:2", "middle", "low"]);
    import_with(&points, &setup.replace("table-bc", "table-xy"), &["setup.toml:2", "table-xy"]);
}

#[test]
fn no_output_takes_the_place_of_a_file_that_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let run = imported(folder.path(), |_, rows| rows.into_iter().map(str::to_owned).collect());
    let path = |name: &str| folder.path().join(name).display().to_string();
    let model = written(folder.path(), "m.toml", "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n");
    let (points, setup) = (path("points.csv"), path("setup.toml"));
    let correct = ["correct", &run, "--control", "csv", "--although-inadequate", "--although-not-better"];
    let with = |more: &[&'_ str]| [&correct[..], more].concat().iter().map(|arg| arg.to_string()).collect();
    let refusals: [(Vec<String>, &str); 9] = [
        (with(&["-o", &run]), "this command reads"),
        (with(&["--model", &model, "-o", &model]), "this command reads"),
        (strings(&["export", "csv", &run, "-o", &run]), "this command reads"),
        (strings(&["compare", &run, "--html", &run]), "this command reads"),
        (strings(&["volumetric", &run, "--html", &run]), "this command reads"),
        (strings(&["report", &run, "--pdf", &run]), "this command reads"),
        (strings(&["identify", &run, "--method", "two-height", "--html", &run]), "this command reads"),
        (strings(&["compare", &run, "--html", &setup]), "setup.toml is a setup file"),
        (strings(&["plan", &run, "--rivals", "backlash:C,servo-lag:C", "-o", &points]), "a table of points"),
    ];
    let before: Vec<Vec<u8>> =
        [&run, &model, &points, &setup].map(|path| std::fs::read(path).unwrap()).into();
    for (args, why) in &refusals {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        check_refused(&args, &[why, "Name another file"]);
    }
    let after: Vec<Vec<u8>> = [&run, &model, &points, &setup].map(|path| std::fs::read(path).unwrap()).into();
    assert!(before == after, "every file is as it was");
    // An earlier output of its own gives way.
    for _ in 0..2 {
        trunnion(&["export", "csv", &run, "-o", &path("again.csv")]);
        trunnion(&["export", "foxglove", &run, "-o", &path("view.mcap")]);
    }
    check_refused(&["import", &points, "-o", &points], &["ends in .mcap", "points.mcap"]);
}

pub fn strings(args: &[&str]) -> Vec<String> {
    args.iter().map(|arg| arg.to_string()).collect()
}

#[test]
fn a_name_that_nothing_has_is_wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let run = imported(folder.path(), |_, rows| rows.into_iter().map(str::to_owned).collect());
    for (args, words) in [
        (vec!["identify", &run, "--method", "nope"], "two-height"),
        (vec!["identify", &run, "--method", "two-height", "--axis", "Q"], "has no rotary axis"),
        (vec!["history", &run], "--folder"),
    ] {
        let output = answer(&args);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {error}");
        assert!(error.contains(words), "{args:?}: {error}");
    }
}

#[test]
fn a_recording_that_is_cut_says_so_where_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let run = imported(folder.path(), |_, rows| rows.into_iter().map(str::to_owned).collect());
    let bytes = std::fs::read(&run).unwrap();
    std::fs::write(&run, &bytes[..20_000]).unwrap();
    for args in [vec!["check", &run], vec!["diagnose", "--json", &run], vec!["attribute", &run]] {
        check_refused(
            &args,
            &["damaged at byte", "everything after 0.0 s of the run", "copy the file again"],
        );
    }
}

#[test]
fn a_mistyped_effect_gets_the_nearest_names_first() {
    let output = answer(&["demo", "--hidden", "gravty-sag:B"]);
    let error = String::from_utf8(output.stderr).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(error.contains("allowed: gravity-sag:B, "), "{error}");
    assert!(error.contains("(did you mean gravity-sag:B?)") && error.len() < 200, "{error}");
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let cycle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles/touch-probe-column.toml");
    for format in [&["--all"][..], &["--json"]] {
        let mut command = crate::program::command();
        command.args(["plan", "--cycle", cycle]).args(format);
        let mut program = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(program.stdout.take()); // as `| head -0` does
        let ended = program.wait_with_output().unwrap();
        assert_eq!(String::from_utf8_lossy(&ended.stderr), "", "{format:?}");
        assert_eq!(ended.status.code(), Some(0), "{format:?}");
    }
}

#[test]
fn a_broken_configuration_machine_and_model_are_refused_with_their_lines() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| written(folder.path(), name, text);
    let config = include_str!("../../config/trunnion.toml").replace("rate_khz = 1\n", "rate_khz = 99\n");
    check_refused(&["check-config", &write("trunnion.toml", &config)], &["trunnion.toml:", "rate_khz", "99"]);

    let machine =
        include_str!("../../config/machines/table-bc.toml").replace("kind = \"rotary\"", "kind = \"round\"");
    let machine = write("mine.toml", &machine);
    let setup = std::fs::read_to_string(data("setup.toml")).unwrap().replace("table-bc", &machine);
    let setup = write("setup.toml", &setup);
    let run = folder.path().join("run.mcap").display().to_string();
    let points = data("points.csv").display().to_string();
    check_refused(&["import", &points, "--setup", &setup, "-o", &run], &["mine.toml"]);

    let good_setup = data("setup.toml").display().to_string();
    assert!(answer(&["import", &points, "--setup", &good_setup, "-o", &run]).status.success());
    let model = write(
        "model.toml",
        "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[effect]]\nid = \"location-errors\"\n[[effect]]\nid = \"gravity-sag:Q\"\n",
    );
    check_refused(&["identify", &run, "--model", &model], &["gravity-sag:Q", "gravity-sag:B"]);
    let model =
        write("typo.toml", "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[efect]]\nid = \"x\"\n");
    check_refused(&["identify", &run, "--model", &model], &["typo.toml:3", "efect"]);
}

#[test]
fn a_named_method_of_runs_that_are_doubted_says_so_and_exits_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    // A probe that sticks.
    let run =
        imported_with(folder.path(), "dy_um", |row, cell| if row >= 200 { "5.00" } else { cell }.into());
    let method = ["identify", &run, "--method", "error-map", "--html", &path("page.html")];
    let output = answer(&method);
    let page = std::fs::read_to_string(path("page.html")).unwrap();
    for text in [String::from_utf8(output.stdout).unwrap(), page] {
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("not to be relied on") && words.contains("probe dy reads the same"), "{text}");
    }
    assert_eq!(output.status.code(), Some(3));
    let output = answer(&[&method[..4], &["--json"]].concat());
    assert_eq!(output.status.code(), Some(3));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["plausibility"].as_array().unwrap().len(), 1, "{answer}");
}

#[test]
fn a_gap_ends_every_answer_with_3_and_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let whole = super::program::import("points-gravity", folder.path());
    let recording =
        trunnion_record::read_run(Path::new(&whole), &trunnion_machine::shipped::machine).unwrap();
    let holed = folder.path().join("holed.mcap");
    let mut writer = trunnion_record::RunWriter::create(&holed, &recording.header).unwrap();
    recording.run.points.into_iter().for_each(|point| writer.point(point));
    let gap = Gap {
        source: "probe-2".into(),
        from_s: 10.25,
        to_s: 12.5,
        lost_samples: Some(48),
        reason: "unplugged".into(),
    };
    writer.item(trunnion_record::Item::Gap(gap), 10.25);
    writer.finish().unwrap();
    let commands: [&[&str]; 8] = [
        &["check"],
        &["identify"],
        &["compare"],
        &["diagnose"],
        &["report"],
        &["export", "csv"],
        &["export", "csv", "--what", "every-point"],
        &["export", "csv", "--what", "samples"],
    ];
    for command in commands {
        let output = answer(&[command, &[holed.to_str().unwrap()]].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{command:?}: {error}");
        assert!(
            error.contains("holed.mcap: probe-2: nothing from 10.25 s to 12.50 s"),
            "{command:?}: {error}"
        );
    }
    let history = answer(&["history", "--folder", folder.path().to_str().unwrap()]);
    let error = String::from_utf8(history.stderr).unwrap();
    assert_eq!(history.status.code(), Some(3), "{error}");
    assert!(error.contains("holed: probe-2: nothing from 10.25 s to 12.50 s"), "{error}");
    assert_eq!(answer(&["compare", &whole]).status.code(), Some(0));
}

#[test]
fn an_answer_whose_diagnosis_failed_exits_with_3() {
    let folder = tempfile::tempdir().unwrap();
    // Twelve readings for eleven parameters, both axes at several positions.
    let run =
        imported(folder.path(), |_, rows| [0, 43, 88, 128].map(|row: usize| rows[row].to_owned()).into());
    for command in ["compare", "report", "replay"] {
        let output = answer(&[command, &run]);
        let text = String::from_utf8(output.stdout).unwrap();
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(3), "{command}: {text}");
        assert!(text.to_lowercase().contains("the diagnosis failed"), "{command}: {text}");
    }
    // Nothing goes into a control from a model that nobody could judge.
    let file = folder.path().join("file").display().to_string();
    let correct = ["correct", &run, "--control", "csv", "-o", &file, "--although-not-better"];
    check_refused(
        &correct,
        &["nothing was written, because the model was not judged", "The diagnosis failed"],
    );
    assert!(!Path::new(&file).exists());
    let anyway = answer(&[&correct[..], &["--although-inadequate"]].concat());
    assert_eq!(anyway.status.code(), Some(3), "{}", String::from_utf8_lossy(&anyway.stderr));
    assert!(Path::new(&file).exists());
}

#[test]
fn what_a_configuration_names_is_touched_and_what_is_absent_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("c.toml"), include_str!("../../config/cycles/r-test-static.toml")).unwrap();
    let broker = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = broker.local_addr().unwrap().port();
    let controller = super::shop::agent(&format!("http://127.0.0.1:{port}/"));
    let tables =
        format!("[mqtt]\nhost = \"127.0.0.1\"\nport = {port}\nuser = \"cell\"\npassword_file = \"mqtt\"\n");
    let ports = folder.path().join("ports");
    let good = super::shop::config(&ports, "runs", &controller, &tables);
    let check = |text: &str| {
        std::fs::write(path("trunnion.toml"), text).unwrap();
        let output = answer(&["check-config", &path("trunnion.toml")]);
        let said = [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap()).join("\n");
        (output.status.code(), said.split_whitespace().collect::<Vec<_>>().join(" "))
    };

    // The password file is not there: a failure.
    let (code, said) = check(&good);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("[mqtt]: the password file") && said.contains("chmod 640"), "{said}");

    // Ports that are not plugged in are a state; controller and broker answer.
    std::fs::write(path("mqtt"), "secret\n").unwrap();
    let (code, said) = check(&good);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(said.matches("is not there now: No such file").count(), 3, "{said}");
    assert!(
        said.contains("3 things are not there now") && said.contains("the service waits for it"),
        "{said}"
    );
    assert!(!said.contains("the broker") && !said.contains("device cnc"), "{said}");
    let readable = format!("chmod 640 {}", path("mqtt"));
    for (mode, is_said) in [(0o640, false), (0o644, true)] {
        std::fs::set_permissions(path("mqtt"), Permissions::from_mode(mode)).unwrap();
        let (code, said) = check(&good);
        assert_eq!((code, said.contains(&readable)), (Some(0), is_said), "{mode:o}: {said}");
    }
    assert!(!folder.path().join("runs").exists(), "nothing is made");

    // Files of the encryption are read too: one that is not there, one that is no certificate.
    let encrypted = good.replace(&tables, &format!("{tables}[mqtt.tls]\nca = \"ca.pem\"\n"));
    for content in [None, Some("no certificate")] {
        content.into_iter().for_each(|text| std::fs::write(path("ca.pem"), text).unwrap());
        let (code, said) = check(&encrypted);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.contains("[mqtt.tls]:") && said.contains("ca.pem"), "{said}");
    }

    // Controller and broker are off: states too.
    drop(broker);
    let (code, said) = check(&good);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("the broker of [mqtt] at 127.0.0.1") && said.contains("device cnc (mtconnect)"),
        "{said}"
    );

    // Nobody can write there.
    let (code, said) = check(&good.replacen("recordings = \"runs\"", "recordings = \"/proc/nowhere\"", 1));
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("recordings = \"/proc/nowhere\" cannot be made"), "{said}");
}

#[test]
fn a_truncated_recording_is_read_as_far_as_it_goes_and_exits_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run.mcap");
    let (points, setup) = (data("points.csv"), data("setup.toml"));
    let args =
        ["import", points.to_str().unwrap(), "--setup", setup.to_str().unwrap(), "-o", run.to_str().unwrap()];
    assert!(answer(&args).status.success());
    let bytes = std::fs::read(&run).unwrap();
    std::fs::write(&run, &bytes[..bytes.len() - 200]).unwrap();
    let output = answer(&["identify", run.to_str().unwrap()]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{error}");
    std::fs::write(&run, &bytes[..17]).unwrap();
    check_refused(&["identify", run.to_str().unwrap()], &["run.mcap"]);
}

#[test]
fn wrong_usage_exits_with_2() {
    assert_eq!(answer(&["identify"]).status.code(), Some(2));
    assert_eq!(answer(&["no-such-command"]).status.code(), Some(2));
}

#[test]
fn runs_that_cannot_be_what_they_say_are_shown_with_a_doubt_and_not_acted_on() {
    let folder = tempfile::tempdir().unwrap();
    // The sense of C reversed: its column has the opposite sign.
    let run = imported_with(folder.path(), "c_deg", |_, cell| format!("{}", -cell.parse::<f64>().unwrap()));
    let model = folder.path().join("m.toml").display().to_string();

    let words =
        [("check", "Doubt"), ("identify", "Doubt"), ("compare", "Not judged"), ("diagnose", "Not judged")];
    for (command, says) in words {
        let output = answer(&[command, &run]);
        assert_eq!(output.status.code(), Some(3), "{command}");
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.contains(says) && text.contains("reversed"), "{command}: {text}");
    }
    let add = ["add", "gravity-sag:B", &run, "--model", &model];
    let refused = answer(&add);
    let error = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(3), "{error}");
    assert!(error.contains("nothing was done") && !Path::new(&model).exists(), "{error}");
    let anyway = answer(&[&add[..], &["--anyway"]].concat());
    assert_eq!(anyway.status.code(), Some(3), "the doubt remains");
    assert!(Path::new(&model).exists(), "{}", String::from_utf8_lossy(&anyway.stderr));
}
