//! Lists longer than the screen are folded behind `--all`; what other programs read is never folded or wrapped.

use crate::program::{data, import, trunnion};

const CYCLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles/touch-probe-column.toml");
const LINES: usize = 20;

/// Standard output and standard error on a screen of so many columns and [`LINES`] lines.
fn on_screen(columns: usize, args: &[&str]) -> (String, String) {
    let mut command = crate::program::command();
    command.args(args).env("COLUMNS", columns.to_string()).env("LINES", LINES.to_string());
    let output = command.output().unwrap();
    (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// How many items a folded list says follow.
fn more(list: &str) -> Option<usize> {
    list.lines().last()?.trim_start().strip_prefix("… and ")?.strip_suffix(" more: --all")?.parse().ok()
}

#[test]
fn a_long_list_of_effects_is_folded_and_all_shows_it() {
    for columns in [80, 200] {
        let (folded, _) = on_screen(columns, &["plan", "--cycle", CYCLE]);
        let (all, _) = on_screen(columns, &["plan", "--all", "--cycle", CYCLE]);
        let (folded, all): (Vec<&str>, Vec<&str>) =
            (folded.split("\n\n").collect(), all.split("\n\n").collect());
        assert_eq!(folded.len(), all.len());
        assert!(folded.iter().any(|list| more(list).is_some()), "{folded:?}");
        for (folded, all) in folded.iter().zip(&all) {
            assert!(more(all).is_none(), "{all}");
            match more(folded) {
                Some(count) => {
                    assert!(folded.lines().count() <= LINES && all.lines().count() > LINES, "{folded}");
                    // A wrapped item takes two lines or more, so the lines left out are at least the items.
                    let (shown, _) = folded.trim_end().rsplit_once('\n').unwrap();
                    let left_out = all.strip_prefix(shown).unwrap().trim().lines().count();
                    assert!(
                        (1..=left_out).contains(&count) && (columns < 200 || count == left_out),
                        "{folded}"
                    );
                }
                None => assert_eq!(folded, all),
            }
        }
    }
}

#[test]
fn a_long_list_of_problems_is_folded_and_all_shows_it() {
    let folder = tempfile::tempdir().unwrap();
    let good = std::fs::read_to_string(data("points-gravity").join("setup.toml")).unwrap();
    let unknown: String =
        ('a'..='z').flat_map(|one| ['p', 'q'].map(|two| format!("key_{one}{two} = 1\n"))).collect();
    let setup = folder.path().join("setup.toml");
    std::fs::write(&setup, unknown + &good).unwrap();
    let points = data("points-gravity").join("points.csv").display().to_string();
    let run = folder.path().join("run.mcap").display().to_string();
    let args = ["import", &points, "--setup", setup.to_str().unwrap(), "-o", &run];
    let (_, folded) = on_screen(1000, &args);
    let (_, all) = on_screen(1000, &[&args[..], &["--all"]].concat());
    assert!(folded.lines().count() <= LINES && more(&folded).is_some(), "{folded}");
    assert!(all.lines().count() > 50 && more(&all).is_none(), "{all}");
}

#[test]
fn what_programs_read_is_neither_folded_nor_wrapped() {
    let json = ["plan", "--cycle", CYCLE, "--json"];
    assert_eq!(on_screen(80, &json).0, on_screen(80, &[&json[..], &["--all"]].concat()).0);
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    let replayed = on_screen(80, &["replay", &run]).0;
    let answers = serde_json::Deserializer::from_str(&replayed).into_iter::<serde_json::Value>();
    assert_eq!(answers.map(Result::unwrap).count(), 2, "identification and diagnosis");
    let sweep = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles/r-test-sweep-c.toml");
    for dialect in ["fanuc", "siemens", "heidenhain", "linuxcnc"] {
        let file = folder.path().join(dialect).display().to_string();
        trunnion(&["nc-program", sweep, "--dialect", dialect, "-o", &file]);
        let shown = on_screen(40, &["nc-program", sweep, "--dialect", dialect]).0;
        assert!(shown == std::fs::read_to_string(&file).unwrap(), "{dialect}");
    }
}
