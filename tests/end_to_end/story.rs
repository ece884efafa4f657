//! The story a user reads, through the binary: where the model fails, an effect on trial, the ladder, and taking it back.

use crate::program::{import, import_and_add, json, refused, trunnion};
use serde_json::Value;
#[test]
fn compare_says_in_words_where_the_model_fails_and_blames_no_place_for_noise() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-backlash-and-drift", folder.path());
    let page = folder.path().join("page.html").display().to_string();
    let compared = json(&["compare", &run, "--json", "--html", &page]);
    // Backlash of C, 4 µm at 150 mm: tangential in table axes, turning over with the direction.
    let first = &compared["places"][0];
    assert_eq!(first["component"], "table Y", "{first}");
    assert!(
        first["turns_with"].as_str().unwrap().contains('C') && first["share"].as_f64().unwrap() > 0.5,
        "{first}"
    );
    let words = first["words"].as_str().unwrap();
    assert!(words.contains("forward, +") && words.ends_with("(336 readings)"), "{words}");
    let page = std::fs::read_to_string(page).unwrap();
    // Which of the two leads depends on what passes can prove; both are named, and the places say which is larger.
    let set = compared["diagnosis"]["set"].as_array().unwrap();
    assert!(
        set.iter().any(|id| *id == "backlash:C") && set.iter().any(|id| *id == "thermal-drift"),
        "{set:?}"
    );
    let headline = page.split("<h1>").nth(1).unwrap().split("</h1>").next().unwrap();
    let names = ["together", "(backlash:C)", "(thermal-drift)"];
    assert!(names.iter().all(|name| headline.contains(name)), "the page names both: {headline}");
    let together_um = compared["diagnosis"]["together"]["rms_um_after"].as_f64().unwrap();
    assert!(
        page.contains(&format!("to {together_um:.2} µm rms")),
        "the page says what both leave: {together_um}"
    );
    assert!(page.contains("— after"), "what the best candidate would leave");

    let quiet = tempfile::tempdir().unwrap();
    let run = import("points-nothing-hidden", quiet.path());
    assert!(trunnion(&["compare", &run]).contains("No place stands out from the others."));
}

#[test]
fn an_effect_on_trial_shows_before_and_after_and_leaves_the_model_file_alone() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    let model = folder.path().join("model.toml").display().to_string();
    std::fs::write(
        &model,
        "# mine\nformat = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[effect]]\nid = \"location-errors\"\n\
         [[effect]]\nid = \"ball-setting\"\n",
    )
    .unwrap();
    let text = std::fs::read_to_string(&model).unwrap();
    let page = folder.path().join("trial.html").display().to_string();
    let args = ["compare", &run, "--model", &model, "--try", "gravity-sag:B", "--json", "--html", &page];
    let trial = json(&args);
    let number = |key: &str, when: &str| trial[key][when].as_f64().unwrap();
    assert!(number("holdout_rms_um", "after") < 0.6 * number("holdout_rms_um", "before"), "{trial}");
    assert!(!trial["places"]["before"].as_array().unwrap().is_empty(), "{trial}");
    assert_eq!(trial["places"]["after"].as_array().unwrap().len(), 0, "{trial}");
    assert_eq!(std::fs::read_to_string(&model).unwrap(), text);
    let page = std::fs::read_to_string(page).unwrap();
    assert_eq!(page.matches("— before").count(), page.matches("— after").count());
    assert!(page.contains("What Sag"), "the page names the effect");
}

#[test]
fn the_ladder_reports_what_moved_and_removing_an_effect_undoes_adding_it() {
    let folder = tempfile::tempdir().unwrap();
    let (run, model) = import_and_add("points-backlash-and-drift", "backlash:C", folder.path());
    let with_backlash = std::fs::read_to_string(&model)
        .unwrap()
        .replace("[[effect]]\nid = \"ball", "# set by hand\n[[effect]]\nid = \"ball");
    std::fs::write(&model, &with_backlash).unwrap();
    trunnion(&["add", "thermal-drift", &run, "--model", &model]);
    let both = std::fs::read_to_string(&model).unwrap();
    assert!(both.starts_with(&with_backlash), "adding appends and touches nothing: {both}");

    // Drift over an hour of passes was taken for places of the axes.
    let ladder = json(&["ladder", "--model", &model, "--json"]);
    let moved = ladder["rows"][3]["ladder"]["moved"].as_array().unwrap();
    let far = |m: &&Value| {
        let number = |key: &str| m[key].as_f64().unwrap();
        m["name"].as_str().unwrap().starts_with('E')
            && (number("after") - number("before")).abs() > 2.0 * number("u")
    };
    assert!(moved.iter().any(|m| far(&m)), "{ladder}");
    let text = trunnion(&["ladder", "--model", &model]);
    assert!(
        text.contains(" u\n") && text.contains("Moved by more than 2 u when thermal-drift came in"),
        "{text}"
    );

    trunnion(&["remove", "thermal-drift", &run, "--model", &model]);
    let without = std::fs::read_to_string(&model).unwrap();
    let (left, removal) = without.split_once("\n[[removed]]\n").unwrap();
    assert_eq!(left, with_backlash);
    assert!(removal.starts_with("effect = \"thermal-drift\"\ndate = \""), "{removal}");

    // Taking out a lower rung measures the ones above it again.
    std::fs::write(&model, &both).unwrap();
    trunnion(&["remove", "backlash:C", &run, "--model", &model]);
    let ladder = json(&["ladder", "--model", &model, "--json"]);
    let row = &ladder["rows"][2];
    assert_eq!(row["effect"], "thermal-drift");
    assert!((row["ladder"]["error_before_um"].as_f64().unwrap() - 1.676).abs() < 0.05, "{ladder}");
    assert!(std::fs::read_to_string(&model).unwrap().contains("# set by hand"));

    assert!(refused(&["remove", "backlash:C", &run, "--model", &model]).contains("it holds thermal-drift"));
    assert!(refused(&["remove", "ball-setting", &run, "--model", &model]).contains("in every model"));
}

#[test]
fn a_found_expression_can_be_added_edited_by_hand_and_replaced_by_ones_own() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-unnamed", folder.path());
    let model = folder.path().join("model.toml").display().to_string();
    let proposed = json(&["diagnose", &run, "--json"])["formula"].clone();
    let id = format!("formula:{}", proposed["name"].as_str().unwrap());
    let added = json(&["add", &id, &run, "--model", &model, "--json"]);
    let number = |value: &Value, key: &str| value[key].as_f64().unwrap();
    assert!(number(&added, "error_after_um") < 0.8 * number(&added, "error_before_um"), "{added}");
    let text = std::fs::read_to_string(&model).unwrap();
    let expression = format!("expression = \"{}\"", proposed["expression"].as_str().unwrap());
    assert!(text.contains(&expression), "{text}");

    // An edited expression with parameters of the user's own; the row is measured again when it was deleted.
    // The values of the found expression's own shape numbers go with it.
    let found: Vec<_> = text[..text.find("\n[effect.ladder]").unwrap()]
        .lines()
        .filter(|line| !line.starts_with("shape ="))
        .collect();
    let edited = found.join("\n").replace(
        &expression,
        "expression = \"hang*sin(B) + pull*max(0, B - start)^2\" # hoses\ngrid = { start = [0.0, 0.4] }",
    ) + "\n";
    std::fs::write(&model, &edited).unwrap();
    let again = json(&["add", &id, &run, "--model", &model, "--json"]);
    let names: Vec<_> =
        again["identification"]["parameters"].as_array().unwrap().iter().map(|p| p["name"].clone()).collect();
    assert!(names.contains(&"hang".into()) && names.contains(&"pull".into()), "{names:?}");
    assert!(std::fs::read_to_string(&model).unwrap().contains("# hoses\ngrid"));
    std::fs::write(&model, edited.replace("hang*sin(B)", "hang*sine(B)")).unwrap();
    let error = refused(&["identify", &run, "--model", &model]);
    assert!(error.contains("column 6") && error.contains("sine") && error.contains("allowed"), "{error}");

    let own = ["--site", "axis:B", "--component", "dy", "--expression", "pull*(B - start)"];
    let error = refused(&[&["compare", &run, "--try", "formula:hose"], &own[..]].concat());
    assert!(error.contains("start") && error.contains("grid"), "{error}");
    let own = [
        "--site",
        "axis:B",
        "--component",
        "dy",
        "--expression",
        "pull*exp(B/soft)",
        "--grid",
        "soft=0.3,0.6,1",
    ];
    let trial = trunnion(&[&["compare", &run, "--try", "formula:hose"], &own[..]].concat());
    assert!(trial.contains("dy at axis:B: pull*exp(B/soft)") && trial.contains("pull "), "{trial}");
}
