//! A report to be filed, and a certificate, through the binary.

use crate::program::{data, import, import_and_add, json, output, trunnion};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

/// What `trunnion` does with this environment: standard error and exit code.
fn with_browser(browser: &Path, args: &[&str]) -> (String, Option<i32>) {
    let mut command = crate::program::command();
    let ran = command.args(args).env("COLUMNS", "1000").env("TRUNNION_BROWSER", browser).output().unwrap();
    (String::from_utf8(ran.stderr).unwrap(), ran.status.code())
}

#[test]
fn a_report_says_which_recording_it_is_of_and_whether_the_tolerance_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (run, model) = import_and_add("points-gravity", "gravity-sag:B", folder.path());
    let page = folder.path().join("filed.html").display().to_string();
    let written = json(&[
        "report",
        &run,
        "--model",
        &model,
        "-o",
        &page,
        "--tolerance-um",
        "12",
        "--operator",
        "Ada",
        "--serial",
        "SN 7",
        "--language",
        "de",
        "--json",
    ]);
    let digest = written["identity"]["runs"][0]["sha256"].as_str().unwrap();
    let expected = Command::new("sha256sum").arg(&run).output().unwrap();
    assert!(String::from_utf8(expected.stdout).unwrap().starts_with(digest), "{digest}");

    // Location errors of tens of µm: far outside 12 µm as measured; the model leaves noise of 0.3 µm.
    let conformity = &written["conformity"];
    assert_eq!(conformity["as_measured"]["decision"], "fail", "{conformity}");
    assert_eq!(conformity["corrected"]["decision"], "pass", "{conformity}");
    let table = folder.path().join("c.csv").display().to_string();
    let correct = ["correct", &run, "--model", &model, "--control", "csv", "-o", &table, "--json"];
    let expected = &json(&correct)["expected"]["largest_after_um"];
    assert_eq!(&conformity["corrected"]["largest_um"], expected, "one answer");

    let page = std::fs::read_to_string(page).unwrap();
    for part in [digest, "SN 7", "Ada", "nicht bestanden", "Seriennummer", "gravity-sag:B"] {
        assert!(page.contains(part), "{part}");
    }
    let identity = json(&["identify", &run, "--model", &model, "--json"]);
    assert_eq!(written["comparison"]["identification"]["rms_um"], identity["rms_um"], "one answer");
}

#[test]
fn a_report_of_an_added_effect_shows_what_was_found_before_it_was_added() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    let file = |name: &str| folder.path().join(name).display().to_string();
    let (model, page) = (file("run.model.toml"), file("report.html"));
    let before = json(&["compare", &run, "--json"]);
    trunnion(&["add", "gravity-sag:B", &run, "--model", &model, "--by", "Ada"]);
    trunnion(&["report", &run, "--model", &model, "-o", &page]);
    let page = std::fs::read_to_string(page).unwrap();
    let (_, found) = page.split_once("<h2>Found and added: ").expect("what was found has its section");
    let (found, after) = found.split_once("</section>").unwrap();
    for part in [
        "(gravity-sag:B)</h2>",
        "Where the model failed before it was added</h3>\n<ol>",
        "Likely cause:",
        "It is significant: more than a million to one",
        "Added by Ada on ",
        "With it the residual falls from 0.94 µm to 0.34 µm rms.",
        "Residual before and after gravity-sag:B",
        "— before",
        "— after",
    ] {
        assert!(found.contains(part), "{part}: {found}");
    }
    assert!(
        after.find("Ladder: what was added so far") < after.find("Where the model fails most"),
        "the fall follows"
    );
    let best = &before["diagnosis"]["candidates"][0];
    let kept = std::fs::read_to_string(&model).unwrap();
    let separates = best["separate_by"].as_str().unwrap();
    assert!(separates.is_empty() || kept.contains(separates) && found.contains(separates), "{kept}");

    // A model file of before says nothing of evidence and rivals; the maps are those of the runs.
    let older: String =
        kept.lines().filter(|line| !line.starts_with("evidence")).map(|line| format!("{line}\n")).collect();
    std::fs::write(&model, older).unwrap();
    trunnion(&["report", &run, "--model", &model, "-o", &file("older.html")]);
    let page = std::fs::read_to_string(file("older.html")).unwrap();
    assert!(page.contains("Residual before and after gravity-sag:B") && !page.contains("It is significant"));
}

#[test]
fn a_report_says_what_the_service_knows_to_be_missing_and_the_recording_does_not_say() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-nothing-hidden", folder.path());
    let lost = "7 samples could not be written to disk";
    let state = serde_json::json!({
        "format": "trunnion-run/1", "state": "done", "at": "", "cycle": "", "parts": [], "tries": 0, "why": "", "losses": [lost],
    });
    std::fs::write(folder.path().join("run.state.json"), state.to_string()).unwrap();
    let answer = json(&["report", &run, "--json"]);
    assert_eq!(answer["comparison"]["losses"][0], lost);
    let page = std::fs::read_to_string(folder.path().join("run.report.html")).unwrap();
    assert!(page.contains(lost), "the page of the service says it");
}

#[test]
fn serial_and_tolerance_are_those_of_the_machine_file_and_no_tolerance_is_no_decision() {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/machines/table-bc.toml"));
    let machine = folder.path().join("mill.toml");
    let text = std::fs::read_to_string(source).unwrap();
    std::fs::write(&machine, format!("serial = \"SN 99\"\ntolerance_um = 200\n{text}")).unwrap();
    let set = data("points-gravity");
    let setup = std::fs::read_to_string(set.join("setup.toml")).unwrap();
    let setup = setup.replace("\"table-bc\"", &format!("'{}'", machine.display()));
    let file = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(file("setup.toml"), setup).unwrap();
    let points = set.join("points.csv").display().to_string();
    trunnion(&["import", &points, "--setup", &file("setup.toml"), "-o", &file("run.mcap")]);
    let written = json(&["report", &file("run.mcap"), "--json"]);
    assert_eq!(written["identity"]["serial"], "SN 99");
    assert_eq!(written["conformity"]["as_measured"]["decision"], "pass", "{}", written["conformity"]);
    assert!(Path::new(&file("run.report.html")).exists(), "next to the recording");

    let other = tempfile::tempdir().unwrap();
    let run = import("points-gravity", other.path());
    assert!(json(&["report", &run, "--json"])["conformity"].is_null());
}

/// A bar along X on the line of C: no error of an axis moves its readings by itself.
#[test]
fn a_bar_that_shows_no_error_of_an_axis_asks_for_nothing_to_be_entered_and_says_what_was_not_seen() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    let config = |name: &str| format!("{}/../../config/{name}", env!("CARGO_MANIFEST_DIR"));
    let (run, page) = (file("bar.mcap"), file("bar.html"));
    let (truth, cycle) = (config("truths/table-bc.toml"), config("cycles/ball-bar-c.toml"));
    trunnion(&["simulate", &truth, "--cycle", &cycle, "-o", &run]);
    let answer = json(&["report", &run, "-o", &page, "--json"]);
    let comparison = &answer["comparison"];
    assert_eq!(comparison["diagnosis"]["verdict"], "noise-floor");
    let parameters = comparison["identification"]["parameters"].as_array().unwrap();
    let of_axes = parameters.iter().filter(|p| p["effect"] == "location-errors");
    assert!(of_axes.clone().count() > 0 && of_axes.clone().all(|p| p["value"].is_null()), "{parameters:?}");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(!page.contains("Enter the errors of the axes"), "nothing is known that could be entered");
    let first = &page[..page.find("Machine and measurement").unwrap()];
    for part in [
        "Enter nothing into the control: these runs give a number to no error of an axis.",
        "place of axis C along X/Y/Z",
        "This cycle cannot show",
        "Nothing significant was found in the residual",
    ] {
        assert!(first.contains(part), "{part} in {first}");
    }
    let correct = ["correct", run.as_str(), "--control", "csv", "-o", &file("c.csv")];
    let (done, _, error) = output(&correct);
    assert!(!done && error.contains("determine none of its numbers"), "the command agrees: {error}");
}

#[test]
fn without_a_browser_the_page_is_written_and_the_command_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-nothing-hidden", folder.path());
    let file = |name: &str| folder.path().join(name).display().to_string();
    let args = ["report", run.as_str(), "-o", &file("page.html"), "--pdf", &file("page.pdf")];
    let (error, code) = with_browser(&folder.path().join("no-browser"), &args);
    assert_eq!(code, Some(1), "{error}");
    assert!(error.contains("cannot start the browser") && error.contains("no-browser"), "{error}");
    assert!(std::fs::read_to_string(file("page.html")).unwrap().ends_with("</html>\n"));
    // One that ends well and writes nothing.
    let (error, code) = with_browser(Path::new("/bin/true"), &args);
    assert!(code == Some(1) && error.contains("wrote no"), "{code:?} {error}");
}

/// Chromium ends with 0 where the disk was full, and leaves what it had written.
#[test]
fn a_pdf_that_ends_early_is_refused_and_names_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-nothing-hidden", folder.path());
    let file = |name: &str| folder.path().join(name).display().to_string();
    let browser = |name: &str, printed: &str| {
        let writes =
            "for a in \"$@\"; do case $a in --print-to-pdf=*) cp \"$PRINTED\" \"${a#*=}\";; esac; done";
        std::fs::write(file(&format!("{name}.printed")), printed).unwrap();
        let script = format!("#!/bin/sh\nPRINTED='{}'\n{writes}\n", file(&format!("{name}.printed")));
        std::fs::write(file(name), script).unwrap();
        std::fs::set_permissions(file(name), PermissionsExt::from_mode(0o755)).unwrap();
        folder.path().join(name)
    };
    let report = |pdf: &str| ["report", &run, "-o", &file("page.html"), "--pdf", pdf].map(str::to_owned);
    let print =
        |browser: &Path, pdf: &str| with_browser(browser, &report(pdf).each_ref().map(String::as_str));
    let whole = browser("whole", "%PDF-1.4\nall of it\n%%EOF\n");
    assert_eq!(print(&whole, &file("page.pdf")).1, Some(0));
    let (error, code) = print(&browser("cut", "%PDF-1.4\nhalf of"), &file("page.pdf"));
    assert!(
        code == Some(1) && error.contains("MB are free in") && error.contains("page is written"),
        "{error}"
    );
    let kept = std::fs::read_to_string(file("page.pdf")).unwrap();
    assert!(kept.ends_with("%%EOF\n"), "the earlier one stays: {kept}");
    // Room for the browser, none where the PDF is kept.
    let (error, code) = print(&whole, "/dev/full");
    assert!(code == Some(1) && error.contains("/dev/full: No space left"), "{code:?} {error}");
}

#[test]
fn a_certificate_needs_a_country_and_a_day() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-nothing-hidden", folder.path());
    let file = |name: &str| folder.path().join(name).display().to_string();
    let dcc = file("dcc.xml");
    let (done, _, error) = output(&["report", &run, "--dcc", &dcc]);
    assert!(!done && error.contains("--country"), "{error}");
    assert!(!folder.path().join("run.report.html").exists(), "refused before anything is fitted or written");
    for no_country in ["XK", "QM", "ZZ", "de"] {
        let (done, _, error) = output(&["report", &run, "--dcc", &dcc, "--country", no_country]);
        assert!(!done && error.contains("such as DE or JP"), "{no_country}: {error}");
    }
    let (done, _, error) = output(&["report", &run, "--dcc", &dcc, "--country", "JP"]);
    assert!(!done && error.contains("--measured"), "{error}");
    let (done, _, error) = output(&["report", &run, "--dcc", &dcc, "--measured", "2026-02-30"]);
    assert!(!done && error.contains("allowed: a day"), "{error}");
    trunnion(&["report", &run, "--dcc", &dcc, "--measured", "2026-02-28", "--country", "JP"]);
    let xml = std::fs::read_to_string(&dcc).unwrap();
    assert!(xml.contains("<dcc:beginPerformanceDate>2026-02-28<") && xml.contains("schemaVersion=\"3.3.0\""));
}

#[test]
fn what_was_found_is_not_among_what_the_cycle_cannot_show() {
    let folder = tempfile::tempdir().unwrap();
    let diagnosis = json(&["diagnose", &import("points-gravity", folder.path()), "--json"]);
    let found = &diagnosis["candidates"][0]["effect"];
    assert_eq!(found, "gravity-sag:B");
    let hidden = diagnosis["not_visible"].as_array().unwrap();
    assert!(!hidden.is_empty() && !hidden.contains(found), "{hidden:?}");
}
