//! What is missing from a recording is said by every surface: text, page, report to be filed, story.

use std::path::{Path, PathBuf};
use trunnion::{Compared, Filing};
use trunnion_core::{Gap, Point, State};
use trunnion_record::{Item, RunWriter};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity/points.csv");
const NOTHING: &str = "Nothing is missing from the recording";

/// Points of a committed set, a second from one to the next, with these gaps.
fn recording(path: &Path, gaps: &[Gap]) -> PathBuf {
    let run = trunnion::read(Path::new(DATA), None).unwrap().run;
    let cycle = include_str!("../../../../config/cycles/demo-static.toml");
    let header = trunnion_record::RunHeader {
        setups: run.setups.clone(),
        cycle_text: String::new(),
        ..crate::header("holed", cycle)
    };
    let mut writer = RunWriter::create(path, &header).unwrap();
    for (second, point) in run.points.into_iter().enumerate() {
        let time_s = Some(second as f64);
        writer.point(Point { state: State { time_s, ..point.state }, ..point });
    }
    gaps.iter().for_each(|gap| writer.item(Item::Gap(gap.clone()), gap.from_s));
    writer.finish().unwrap();
    path.into()
}

fn gap(from_s: f64, to_s: f64) -> Gap {
    Gap { source: "probe-2".into(), from_s, to_s, lost_samples: Some(48), reason: "unplugged".into() }
}

fn compared(recording: &Path) -> Compared {
    let run = trunnion::open(recording).unwrap();
    run.fit(&run.base_model()).unwrap().compare()
}

/// What each surface says, by name.
fn surfaces(recording: &Path, compared: &Compared) -> Vec<(&'static str, String)> {
    let report = compared.report(&[recording.into()], &Filing::default()).unwrap();
    let filed = trunnion::report::report_html(&report, trunnion::report::Language::English);
    let missing = compared.story().sections.into_iter().find(|section| section.id == "missing").unwrap();
    vec![("text", compared.summary()), ("page", compared.page()), ("filed", filed), ("story", missing.html)]
}

#[test]
fn a_gap_of_a_recording_is_said_by_every_surface() {
    let folder = tempfile::tempdir().unwrap();
    // The first is over before a program can have moved.
    let holed = recording(&folder.path().join("holed.mcap"), &[gap(-1.0, 0.01), gap(10.25, 12.5)]);
    let compared_holed = compared(&holed);
    let said = "probe-2: nothing from 10.25 s to 12.50 s, 48 samples missing (unplugged)";
    assert_eq!(compared_holed.results().losses, [said]);
    for (name, text) in surfaces(&holed, &compared_holed) {
        assert!(text.contains(said) && !text.contains(NOTHING), "{name}: {text}");
    }
    // One list: what is complete holds it too, on every surface that says what is complete.
    let run = trunnion::open(&holed).unwrap();
    let fit = run.fit(&run.base_model()).unwrap();
    let of_diagnosis = fit.diagnose().unwrap().results().complete.losses;
    for complete in [run.check().complete.losses, fit.results().complete.losses, of_diagnosis] {
        assert_eq!(complete, [said]);
    }
    for text in [fit.summary(), trunnion::report::check_text(&run.check())] {
        assert_eq!(text.split_whitespace().collect::<Vec<_>>().join(" ").matches(said).count(), 1, "{text}");
    }
    // What a service knows of the same gap is said once, what else it knows too.
    let known = [said.to_owned(), "the program ran already when the recording began".to_owned()];
    assert_eq!(compared_holed.with_losses(&known).results().losses, known);

    let whole = recording(&folder.path().join("whole.mcap"), &[]);
    let page = compared(&whole).page();
    assert!(page.contains(NOTHING), "{page}");
}

#[test]
fn a_gap_is_said_against_kept_values_too() {
    let folder = tempfile::tempdir().unwrap();
    let holed = trunnion::open(recording(&folder.path().join("holed.mcap"), &[gap(10.25, 12.5)])).unwrap();
    let fit = holed.fit(&holed.base_model()).unwrap();
    let kept = fit.model().with_values(&fit.values("2026-03-01")).unwrap();
    let [loss] = &kept.compare_frozen(&holed).unwrap().losses[..] else { panic!("one gap") };
    assert!(loss.starts_with("probe-2: nothing from 10.25 s"), "{loss}");
}

#[test]
fn what_ends_as_another_loss_is_another() {
    let folder = tempfile::tempdir().unwrap();
    let holed = recording(&folder.path().join("holed.mcap"), &[gap(10.25, 12.5)]);
    let shorter = ["2: nothing from 10.25 s to 12.50 s, 48 samples missing (unplugged)".to_owned()];
    assert_eq!(compared(&holed).with_losses(&shorter).results().losses.len(), 2);
}

#[test]
fn of_several_runs_a_gap_has_the_name_of_its_run() {
    let folder = tempfile::tempdir().unwrap();
    let holed = recording(&folder.path().join("holed.mcap"), &[gap(10.25, 12.5)]);
    let whole = recording(&folder.path().join("whole.mcap"), &[]);
    let both = trunnion::open_all([whole, holed]).unwrap();
    let [loss] = &both.losses()[..] else { panic!("{:?}", both.losses()) };
    assert!(loss.starts_with("holed: probe-2: nothing from 10.25 s"), "{loss}");
}

#[test]
fn the_gap_of_every_file_of_a_run_counts() {
    let folder = tempfile::tempdir().unwrap();
    let whole = recording(&folder.path().join("run.mcap"), &[]);
    let holed = recording(&folder.path().join("run-2.mcap"), &[gap(10.25, 12.5)]);
    let run = trunnion::open_runs(&[vec![whole, holed]]).unwrap();
    assert_eq!(run.runs().len(), 1);
    assert_eq!(
        run.losses(),
        ["probe-2: nothing from 10.25 s to 12.50 s, 48 samples missing (unplugged)".to_owned()]
    );
    assert!(run.gaps()[0].contains("run-2.mcap: probe-2"), "{:?}", run.gaps());
}
