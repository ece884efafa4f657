//! Slips in the names that a command line or a file holds.

use crate::bad_input::{data, imported, strings};
use crate::program::{output, written};

#[test]
fn a_slip_in_a_name_is_answered_with_the_name_that_was_meant() {
    let folder = tempfile::tempdir().unwrap();
    let run = imported(folder.path(), |_, rows| rows.into_iter().map(str::to_owned).collect());
    let path = |name: &str| folder.path().join(name).display().to_string();
    let cycles = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles");
    let points = std::fs::read_to_string(data("points.csv")).unwrap().replacen("\nlow,", "\nlwo,", 1);
    let points = written(folder.path(), "typo.csv", &points);
    let base =
        "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[effect]]\nid = \"location-errors\"\n";
    let model = written(folder.path(), "m.toml", &format!("{base}[[effect]]\nid = \"gravity-sag:B\"\n"));
    let truth = written(
        folder.path(),
        "truth.toml",
        "format = \"trunnion-truth/1\"\nmachine = \"table-bc\"\n[[hidden]]\nid = \"gravty-sag:B\"\n",
    );
    let formula = |more: [&'static str; 4]| {
        let formula = ["compare", &run, "--try", "formula:x", "--expression", "k*sin(B)"];
        strings(&[&formula[..], &more].concat())
    };
    let slips: [(Vec<String>, &str); 14] = [
        (strings(&["histroy"]), "'history'"),
        (strings(&["simulate", &truth, "-o", &path("o.mcap")]), "did you mean gravity-sag:B?"),
        (strings(&["identify", &run, "--method", "eror-map"]), "did you mean error-map?"),
        (strings(&["identify", &run, "--notation", "absolut"]), "did you mean absolute?"),
        (strings(&["correct", &run, "--control", "simens"]), "'siemens'"),
        (strings(&["compare", &run, "--try", "gravty-sag:B"]), "did you mean gravity-sag:B?"),
        (strings(&["plan", &run, "--rivals", "gravty-sag:B,backlash:C"]), "did you mean gravity-sag:B?"),
        (strings(&["remove", "gravty-sag:B", &run, "--model", &model]), "did you mean gravity-sag:B?"),
        (formula(["--site", "axs:B", "--component", "ea"]), "did you mean axis:B?"),
        (strings(&["volumetric", &run, "--datum", "modell"]), "did you mean model?"),
        (strings(&["history", "--folder", &path(""), "--since", "rnu"]), "did you mean run?"),
        (
            strings(&["import", &points, "--setup", &path("setup.toml"), "-o", &path("o.mcap")]),
            "did you mean low?",
        ),
        (strings(&["check", &path("rnu.mcap")]), "run.mcap?"),
        (
            strings(&[
                "nc-program",
                &format!("{cycles}/r-test-statc.toml"),
                "--dialect",
                "fanuc",
                "-o",
                &path("o.nc"),
            ]),
            "r-test-static.toml?",
        ),
    ];
    for (args, meant) in &slips {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let (done, _, error) = output(&args);
        assert!(!done && error.contains(meant), "{args:?}: {error}");
    }
}

#[test]
fn a_model_file_among_recordings_is_answered_with_the_option_that_takes_it() {
    let folder = tempfile::tempdir().unwrap();
    let model = written(folder.path(), "m.toml", MODEL);
    for args in [&["predict", &model, "--fitted", &model, "--model", &model][..], &["identify", &model]] {
        let (done, _, error) = output(args);
        let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            !done && error.ends_with("is a model file, no recording; a model file goes with --model"),
            "{error}"
        );
    }
}

#[test]
fn effects_of_a_model_file_of_another_machine_are_named_where_the_answer_has_no_room_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let run = imported(folder.path(), |_, rows| rows.into_iter().map(str::to_owned).collect());
    let path = |name: &str| folder.path().join(name).display().to_string();
    let other = written(folder.path(), "other.toml", &MODEL.replace("table-bc", "table-ac"));
    let export = ["export", "csv", &run, "--model", &other, "--what", "residuals", "-o", &path("r.csv")];
    for args in [
        &["volumetric", &run, "--model", &other][..],
        &["report", &run, "--model", &other, "-o", &path("r.html")],
        &export,
    ] {
        let (done, _, error) = output(args);
        let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
        let named = "the model file is of machine table-ac, the runs were measured on machine table-bc.";
        assert!(done && error.contains(named), "{args:?}: {error}");
    }
}

const MODEL: &str = "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[effect]]\nid = \"location-errors\"\n\n[[effect]]\nid = \"ball-setting\"\n";
