//! A machine file of one's own: named by its path from the file that names it, wherever the program is started.

use super::one_line;
use super::program::{answer, json, trunnion, written};
use std::path::Path;

/// The shipped machine, truth and cycle as files of one's own, with joints under these names.
fn own(folder: &Path, joints: [(&str, &str); 3], machine: &str) -> [String; 2] {
    let renamed = |text: &str| {
        joints.iter().fold(text.to_owned(), |text, (shipped, own)| {
            text.replace(&format!("\"{shipped}\""), &format!("\"{own}\""))
                .replace(&format!("axis.{shipped}]"), &format!("axis.{own}]"))
                .replace(&format!("0{shipped}_"), &format!("0{own}_"))
                .replace(&format!(":{shipped}\""), &format!(":{own}\""))
                .replace(&format!("{shipped} = "), &format!("{own} = "))
        })
    };
    std::fs::create_dir(folder.join("own")).unwrap();
    written(&folder.join("own"), "own.toml", &renamed(include_str!("../../config/machines/table-bc.toml")));
    let of =
        |text: &str| renamed(text).replace("machine = \"table-bc\"", &format!("machine = \"{machine}\""));
    let truth =
        written(&folder.join("own"), "truth.toml", &of(include_str!("../../config/truths/table-bc.toml")));
    let cycle =
        written(&folder.join("own"), "cycle.toml", &of(include_str!("../../config/cycles/demo-static.toml")));
    [truth, cycle]
}

fn check(joints: [(&str, &str); 3], machine: &str) {
    let folder = tempfile::tempdir().unwrap();
    let [truth, cycle] = own(folder.path(), joints, machine);
    let run = folder.path().join("run.mcap").display().to_string();
    trunnion(&["simulate", &truth, "--cycle", &cycle, "-o", &run]);
    let found = json(&["identify", &run, "--json"]);
    assert_eq!(found["machine"], "own");
    let program = ["nc-program", &cycle, "--dialect", "linuxcnc"];
    if joints[0].1 == "X" {
        trunnion(&program);
    } else {
        let said = one_line(&answer(&program).stderr);
        assert!(said.contains("its machine has linear joints other than X, Y and Z"), "{said}");
    }
    let grid = folder.path().join("grid.mcap").display().to_string();
    trunnion(&["simulate", &truth, "-o", &grid]);
}

#[test]
fn a_machine_file_is_found_next_to_truth_and_cycle_by_path_and_by_name() {
    let same = [("X", "X"), ("Y", "Y"), ("C", "C")];
    check(same, "own.toml");
    check(same, "own");
}

#[test]
fn an_own_machine_has_joints_of_any_name() {
    check([("X", "U"), ("Y", "V"), ("C", "C")], "own.toml");
    check([("X", "j1"), ("Y", "j2"), ("C", "j3")], "own.toml");
}

#[test]
fn two_machine_files_of_one_name_are_no_one_machine() {
    let folder = tempfile::tempdir().unwrap();
    let [truth, cycle] = own(folder.path(), [("X", "X"), ("Y", "Y"), ("C", "C")], "own.toml");
    let other = include_str!("../../config/machines/table-bc.toml").replacen(
        "screw_lead_mm = ",
        "screw_lead_mm = 1",
        1,
    );
    written(folder.path(), "own.toml", &other);
    let elsewhere = written(folder.path(), "cycle.toml", &std::fs::read_to_string(cycle).unwrap());
    let run = folder.path().join("run.mcap").display().to_string();
    let said = one_line(&answer(&["simulate", &truth, "--cycle", &elsewhere, "-o", &run]).stderr);
    assert!(said.contains("two machine files own, which differ; name the same file in both"), "{said}");
}
