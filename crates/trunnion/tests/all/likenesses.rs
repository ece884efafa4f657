//! What fits nearly as well as the truth is not offered as if it were it, whatever the machine and the size of its errors.

use crate::mistakes::{Files, READINGS};
use std::path::Path;
use trunnion::results::{Check, DoubtReason};
use trunnion_core::Joint;
use trunnion_core::convert::{mm_from_um, um_from_mm};
use trunnion_instruments::predict;
use trunnion_machine::Errors;

const SETS: [&str; 3] = ["points-gravity", "points-nothing-hidden", "points-backlash-and-drift"];

fn said(files: &Files) -> String {
    let found = files.open().check().plausibility;
    found.iter().map(|one| format!("{} {}", one.finding, one.hypothesis)).collect::<Vec<_>>().join(" ")
}

/// Senses counted the other way, and what a user is led to who takes the linear axis, or the probe, for the cause.
#[test]
fn a_machine_in_a_mirror_is_asked_about_at_every_step() {
    let of_bc: [(&[&str], &str); 3] = [
        (&["c_deg"], "the sense of C reversed (sign −1), or the sense of Y"),
        (&["y_mm"], "the sense of C reversed (sign −1), or the sense of Y"),
        (&["c_deg", "y_mm"], "or the senses of C, and of Y, reversed together"),
    ];
    let of_ac: [(&[&str], &str); 3] = [
        (&["a_deg", "c_deg"], "the senses of A and C reversed (sign −1), or the sense of Y"),
        (&["y_mm"], "the senses of A and C reversed (sign −1), or the sense of Y"),
        (&["a_deg", "c_deg", "y_mm"], "or the senses of A and C, and of Y, reversed together"),
    ];
    for set in SETS {
        let bc = || Files::committed(set);
        let ac = || {
            let mut files = bc();
            files.on_a_table_ac();
            files
        };
        assert_eq!(said(&ac()), "", "{set}");
        let all = of_bc.iter().map(|step| (step, bc())).chain(of_ac.iter().map(|step| (step, ac())));
        for ((columns, expected), mut files) in all {
            files.reverse(columns);
            let said = said(&files);
            assert!(said.contains(expected), "{set}, {columns:?}: {expected} in: {said}");
            assert!(said.contains("cannot distinguish these") && said.contains("jog +"), "{set}: {said}");
        }
    }
}

/// One nest turned by any angle, and raw readings of inclined probes, are named with the angle.
#[test]
fn a_turned_nest_of_one_setup_and_raw_readings_are_named_at_every_angle() {
    for deg in [-150, -75, -35, 40, 100, 160] {
        let mut files = Files::committed("points-nothing-hidden");
        files.second_turned(f64::from(deg));
        let shown = if deg < 0 { format!("−{}°", -deg) } else { format!("+{deg}°") };
        let expected = format!("turned by {shown} about its z axis (setup high alone)");
        let text = said(&files);
        assert!(text.contains(&expected), "{expected} in: {text}");
        let mut files = Files::committed("points-nothing-hidden");
        files.raw_of_inclined(f64::from(deg));
        let text = said(&files);
        assert!(text.contains("inclined by 54.7° to z"), "{deg}: {text}");
    }
}

/// Of two setups only the ratio is seen: either may be the one in another unit.
#[test]
fn of_one_setup_ten_times_the_other_either_may_be_wrong() {
    for set in ["points-gravity", "points-nothing-hidden"] {
        let mut files = Files::committed(set);
        for row in files.second() {
            READINGS.iter().for_each(|name| files.set(row, name, 10.0 * files.number(row, name), 2));
        }
        let text = said(&files);
        assert!(text.contains("(setup high alone), or those of setup low multiplied by 10"), "{set}: {text}");
    }
}

/// A guess that leaves what would itself be gross is no correction: two mistakes at once.
#[test]
fn what_leaves_several_repeatabilities_is_no_full_explanation() {
    let mut files = Files::committed("points-nothing-hidden");
    files.second_turned(60.0);
    files.readings(|[x, y, z]| [x, 1.25 * y, z]);
    let text = said(&files);
    assert!(text.contains("no full explanation") && !text.contains("Change it?"), "{text}");
}

/// A ball that was mounted again at the same place is no copied block.
#[test]
fn a_ball_mounted_again_at_one_place_raises_no_doubt() {
    for set in SETS {
        let mut files = Files::committed(set);
        let half = files.rows.len() / 2;
        let first = files.rows[..half].to_vec();
        let columns = READINGS.map(|name| files.column(name));
        for (row, from) in (half..files.rows.len()).zip(first) {
            let time = files.rows[row][1].clone();
            files.rows[row] = from;
            files.rows[row][0] = "high".into();
            files.rows[row][1] = time;
            // Another setting of the ball, and other noise.
            for (channel, &column) in columns.iter().enumerate() {
                let value: f64 = files.rows[row][column].parse().unwrap();
                let noise = 0.3 * ((row * 3 + channel) as f64 * 12.9898).sin();
                files.rows[row][column] = format!("{:.2}", value + 4.0 * channel as f64 + noise);
            }
        }
        files.replace("160.0]", "60.0]");
        let text = said(&files);
        assert!(!text.contains("the same ball_in_table_mm"), "{set}: {text}");
    }
}

/// Found in two runs given together.
fn together(first: &Files, second: &Files) -> Check {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, files: &Files| {
        let own = folder.path().join(name);
        std::fs::create_dir(&own).unwrap();
        std::fs::write(own.join("points.csv"), files.text()).unwrap();
        std::fs::write(own.join("setup.toml"), &files.setup).unwrap();
        own.join("points.csv")
    };
    let paths = [write("before", first), write("after", second)];
    trunnion::open_all(paths.iter().map(AsRef::<Path>::as_ref)).unwrap().check()
}

/// A day later, with every reading as many times larger.
fn later(set: &str, factor: f64) -> Files {
    let mut files = Files::committed(set);
    files.change("time_s", |s| s + 86_400.0);
    files.readings(|reading| reading.map(|um| factor * um));
    files
}

#[test]
fn runs_before_and_after_a_correction_are_not_fitted_together_in_silence() {
    for factor in [0.05, 0.1, 0.15] {
        let set = "points-nothing-hidden";
        let mut after = later(set, factor);
        for row in 0..after.rows.len() {
            for (channel, name) in READINGS.iter().enumerate() {
                let noise = 0.3 * ((row * 3 + channel) as f64 * 12.9898).sin();
                after.set(row, name, after.number(row, name) + noise, 2);
            }
        }
        let found = together(&Files::committed(set), &after).plausibility;
        let text = format!("{found:?}");
        assert!(text.contains("not of one state of the machine"), "{factor}: {text}");
        assert!(text.contains("Was a correction entered between them?"), "{factor}: {text}");
    }
}

#[test]
fn days_of_a_machine_that_warms_belong_together() {
    for factor in [0.6, 0.8, 1.3, 1.6] {
        let set = "points-nothing-hidden";
        let check = together(&Files::committed(set), &later(set, factor));
        assert_eq!((check.plausibility, check.doubts), (Vec::new(), Vec::new()), "{factor}");
    }
}

#[test]
fn runs_as_unlike_as_those_of_two_machines_are_said_to_be_so() {
    let check =
        together(&Files::committed("points-nothing-hidden"), &Files::committed("points-backlash-and-drift"));
    assert_eq!(check.plausibility, []);
    let [doubt] = &check.doubts[..] else { panic!("{:?}", check.doubts) };
    assert_eq!(doubt.reason, DoubtReason::UnlikeRuns);
    assert!(doubt.words.contains("all 8 location errors that both determine differ"), "{}", doubt.words);
    assert!(doubt.words.contains("Are both of one machine, in one state?"), "{}", doubt.words);
}

/// Every second pose, from `first` on, of a machine whose lines of B and C moved by these µm and µrad since.
fn other_poses(first: usize, moved: [f64; 4]) -> Files {
    let mut files = Files::committed("points-nothing-hidden");
    let run = files.open().runs()[0].clone();
    let mut errors = Errors::default();
    let [exb_um, eab_urad, exc_um, eyc_um] = moved;
    errors.joints[Joint::B].translation_mm.x = mm_from_um(exb_um);
    errors.joints[Joint::B].rotation_rad.x = eab_urad * 1e-6;
    errors.joints[Joint::C].translation_mm.x = mm_from_um(exc_um);
    errors.joints[Joint::C].translation_mm.y = mm_from_um(eyc_um);
    for (row, point) in run.points.iter().enumerate() {
        let setup = &run.setups[point.state.setup];
        let of = |errors: &Errors| predict(&run.machine, setup, &point.state, errors);
        let by_mm = of(&errors) - of(&Errors::default());
        for (k, name) in READINGS.iter().enumerate() {
            // Mounted again, with a noise of its own.
            let noise = 0.3 * ((row * 3 + k) as f64 * 12.9898 + first as f64).sin();
            let value =
                files.number(row, name) + um_from_mm(by_mm[k]) + 7.0 * k as f64 * first as f64 + noise;
            files.set(row, name, value, 2);
        }
    }
    files.change("time_s", |s| s + 86_400.0 * first as f64);
    let mut row = 0;
    files.rows.retain(|_| {
        row += 1;
        (row - 1) % 2 == first
    });
    files
}

/// Some location errors changed by 20 to 50 µm between cycles of other poses; or by what a day changes.
#[test]
fn runs_of_other_poses_between_which_the_machine_changed_are_doubted_and_days_are_not() {
    let before = other_poses(0, [0.0; 4]);
    for (moved, expected) in [
        ([0.0, 0.0, 35.0, -25.0], true),
        ([20.0, 40.0, -30.0, 0.0], true),
        ([0.0; 4], false),
        ([5.0, -6.0, 4.0, 6.0], false),
    ] {
        let check = together(&before, &other_poses(1, moved));
        assert_eq!(check.plausibility, [], "{moved:?}");
        let changed =
            check.doubts.iter().any(|doubt| doubt.words.contains("the machine changed between the runs"));
        assert_eq!(changed, expected, "{moved:?}: {:?}", check.doubts);
        assert_eq!(check.doubts.len(), usize::from(expected), "{moved:?}: {:?}", check.doubts);
    }
}
