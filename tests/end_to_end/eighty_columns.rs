//! On a terminal of 80 columns no word is broken, and no table loses its columns.

use crate::program::{data, import_and_add, trunnion};
use std::path::Path;

/// Standard output and standard error in so many columns, nothing folded.
fn shown(columns: usize, folder: &Path, args: &[&str]) -> String {
    let mut command = crate::program::command();
    command.args(args).arg("--all").current_dir(folder).env("COLUMNS", columns.to_string());
    let output = command.output().unwrap();
    String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap()
}

#[test]
fn no_id_flag_or_value_is_broken() {
    let folder = tempfile::tempdir().unwrap();
    import_and_add("points-gravity", "gravity-sag:B", folder.path());
    let (circle, bar) = (folder.path().join("circle.mcap"), folder.path().join("bar.mcap"));
    for (truth, cycle, run) in [("three-axis", "circle-xy", &circle), ("table-bc", "bk2-c", &bar)] {
        let config = data("../../config");
        let truth = config.join(format!("truths/{truth}.toml")).display().to_string();
        let cycle = config.join(format!("cycles/{cycle}.toml")).display().to_string();
        trunnion(&["simulate", &truth, "--cycle", &cycle, "-o", run.to_str().unwrap()]);
    }
    let commands: &[&[&str]] = &[
        &["check", "run.mcap"],
        &["identify", "run.mcap"],
        &["identify", "circle.mcap", "--method", "circular"],
        &["identify", "bar.mcap", "--method", "ball-bar"],
        &["diagnose", "run.mcap"],
        &["compare", "run.mcap"],
        &["compare", "run.mcap", "--try", "backlash:C"],
        &["ladder", "--model", "model.toml"],
        &["predict", "run.mcap", "--model", "model.toml"],
        &["plan", "run.mcap"],
        &["volumetric", "run.mcap"],
        &["history", "."],
        // Refused, in words on standard error.
        &["correct", "run.mcap", "--control", "fanuc"],
        &["identify", "run.mcap", "--method", "circular"],
        &["demo", "--hidden", "gravty-sag:B"],
    ];
    let mut hyphens = 0;
    for args in commands {
        let (narrow, wide) = (shown(80, folder.path(), args), shown(4000, folder.path(), args));
        let words = |text: &str| text.split_whitespace().map(String::from).collect::<Vec<_>>();
        assert_eq!(words(&narrow), words(&wide), "{args:?}: the words of 80 columns are those of one line");
        hyphens += words(&wide).iter().filter(|word| word.contains('-')).count();
        for line in narrow.lines() {
            assert!(line.chars().count() <= 80 || !line.trim().contains(' '), "{args:?}: {line}");
        }
    }
    assert!(hyphens > 100, "{hyphens} words that could break");
}

#[test]
fn tables_of_the_main_screens_fit_without_a_wrapped_head_or_a_lone_value() {
    let folder = tempfile::tempdir().unwrap();
    import_and_add("points-gravity", "gravity-sag:B", folder.path());
    let commands: &[(&[&str], &str)] = &[
        (&["identify", "run.mcap"], "parameter"),
        (&["diagnose", "run.mcap"], "candidate"),
        (&["ladder", "--model", "model.toml"], "added"),
        (&["predict", "run.mcap", "--model", "model.toml"], "predicted run"),
    ];
    for (args, head) in commands {
        let wide = shown(4000, folder.path(), args);
        let table: Vec<&str> = wide.lines().skip_while(|line| !line.starts_with(head)).collect();
        let rows = table.iter().take_while(|line| !line.is_empty() && !line.starts_with(' '));
        let rows: Vec<_> = rows.filter(|line| !line.starts_with("Bars:")).collect();
        assert!(rows.len() > 1, "{args:?}: {wide}");
        for row in rows {
            assert!(row.chars().count() <= 80, "{args:?}: {row}");
        }
    }
}
