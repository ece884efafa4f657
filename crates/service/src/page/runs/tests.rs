use super::*;
use crate::analysis::{AnalysisLimits, Analyst};
use crate::clock::SystemClock;
use trunnion::results::RunRecord;

#[test]
fn an_answer_is_of_every_file_that_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["a.mcap", "a-2.mcap", "b.mcap", "judged.toml", "other.mcap"] {
        std::fs::write(at(name), "").unwrap();
    }
    let record = RunRecord { parts: vec!["a-2.mcap".into()], ..RunRecord::default() };
    run_record::write(&at("a.mcap"), &record).unwrap();
    let analyst = PageAnalyst::new(Analyst::Here, AnalysisLimits::default(), Arc::new(SystemClock::start()));
    let runs = Runs::of_folder(folder.path(), Some(at("judged.toml")), analyst);
    let questions = [
        Asks::Change { earlier: at("a.mcap") },
        Asks::NextDay { recordings: vec![at("a.mcap"), at("b.mcap")] },
    ];
    for asks in questions {
        let now = || runs.stamps(&at("b.mcap"), &asks);
        for (name, is_of) in [
            ("b.mcap", true),
            ("a.mcap", true),
            ("a-2.mcap", true),
            ("a.state.json", true),
            ("a.model.toml", true),
            ("judged.toml", true),
            ("other.mcap", false),
        ] {
            let before = now();
            let text = std::fs::read_to_string(at(name)).unwrap_or_default();
            std::fs::write(at(name), text + " ").unwrap();
            assert_eq!(now() != before, is_of, "{name} of {asks:?}");
        }
    }
}
