//! Model files: what is written is read, what is added comes out again.

use super::*;
use crate::{FittedRun, FittedValue, Removal};

fn formula() -> ModelEffect {
    ModelEffect {
        id: "formula:hose".into(),
        site: Some("axis:B".into()),
        component: Some("ea".into()),
        expression: Some("pull * step(B - start)".into()),
        grid: vec![("start".into(), vec![0.2, 0.4])],
        fixed: vec![("pull".into(), 3.0)],
        ladder: Some(LadderRow {
            date: "2026-03-01".into(),
            with: Some("formula:nozzle".into()),
            run: "tuesday".into(),
            error_before_um: 4.1,
            error_after_um: 1.25,
            holdout_after_um: Some(1.5),
            holdout_unit: Some("pass".into()),
            noise_um: Some(0.9),
            moved: vec![Moved {
                name: "ball-setting.low.x".into(),
                before: -3.2,
                after: -1.1,
                u: 0.26,
                unit: "um".into(),
            }],
            evidence: Some(12.5),
            confused_with: vec!["backlash:B".into(), "cable-drag:B".into()],
            separate_by: "Approach each pose from both sides.".into(),
            found_with: vec!["gravity-sag:B".into()],
            ..LadderRow::default()
        }),
        ..ModelEffect::default()
    }
}

#[test]
fn a_model_survives_its_file() {
    let mut model = Model::base("table-bc");
    model.effects[0].prior = vec![("EA0C".into(), Prior { value: 0.0, u: 20.0 })];
    model.effects.push(ModelEffect { shape: vec![300.0, 1800.0], ..formula() });
    assert_eq!(Model::parse("m.toml", &model.to_text()).unwrap(), model);
}

#[test]
fn appending_keeps_comments_and_hand_edits() {
    let text = "# the blue machine\nformat = \"trunnion-model/1\"\nmachine = \"table-bc\" # C on B\n\n\
                [[effect]]\nid = \"location-errors\"\nfixed = { EX0B = 3 }   # from the builder\n";
    let appended = Model::append(text, &formula()).unwrap();
    assert!(appended.starts_with(text), "{appended}");
    let model = Model::parse("m.toml", &appended).unwrap();
    assert_eq!(model.effects[0].fixed, [("EX0B".to_string(), 3.0)]);
    assert_eq!(model.effects[1], formula());
}

#[test]
fn who_removed_an_effect_and_when_is_kept() {
    let base = Model::base("table-bc").to_text();
    let text = Model::without(&Model::append(&base, &formula()).unwrap(), "formula:hose").unwrap();
    let removal =
        Removal { effect: "formula:hose".into(), date: "2026-03-02".into(), by: Some("Ada".into()) };
    let kept = Model::with_removal(&text, &removal).unwrap();
    let model = Model::parse("m.toml", &kept).unwrap();
    assert_eq!(model.removed, [removal], "{kept}");
    assert_eq!(Model::parse("m.toml", &model.to_text()).unwrap(), model);
    // Entries after it are still the model's.
    let again = Model::parse("m.toml", &Model::append(&kept, &formula()).unwrap()).unwrap();
    assert_eq!((again.effects.len(), again.removed.len()), (3, 1));
}

#[test]
fn taking_an_entry_out_again_leaves_the_file_as_it_was() {
    let text = "# the blue machine\nformat = \"trunnion-model/1\"\nmachine = \"table-bc\"\n\n# always\n[[effect]]\n\
                id = \"location-errors\"   # ISO 230-7\n\n[[effect]]\nid = \"backlash:C\"\n# seen twice\n\
                [effect.ladder]\ndate = \"2026-01-01\"\nrun = \"monday\"\nerror_before_um = 4.0\n\
                error_after_um = 3.0\nnoise_um = 0.5\n";
    let longer = Model::append(text, &formula()).unwrap();
    assert_eq!(Model::without(&longer, "formula:hose").unwrap(), text);
    let shorter = Model::without(&longer, "backlash:C").unwrap();
    assert!(shorter.contains("# ISO 230-7") && !shorter.contains("monday"), "{shorter}");
    let row = LadderRow { date: "2026-02-02".into(), ..LadderRow::default() };
    let measured = Model::with_ladder_row(text, "backlash:C", &row).unwrap();
    assert_eq!(Model::parse("m.toml", &measured).unwrap().effects[1].ladder, Some(row));
    assert!(measured.contains("# always\n[[effect]]\nid = \"location-errors\"   # ISO 230-7"), "{measured}");
}

#[test]
fn values_count_while_the_model_holds_the_effects_they_are_of() {
    let value = |name: &str, correlation: &[f64]| FittedValue {
        effect: "location-errors".into(),
        name: name.into(),
        unit: "um".into(),
        value: -3.2,
        u: (!correlation.is_empty()).then_some(0.26),
        between_runs: correlation.last().map(|_| 0.5),
        correlation: correlation.into(),
    };
    let base = Model::base("table-bc");
    let values = FittedValues {
        date: "2026-03-01".into(),
        runs: vec![FittedRun { name: "tuesday".into(), digest: "crc32:0f3a91c2".into() }],
        effects: ["location-errors", "ball-setting", "backlash:C"].map(String::from).into(),
        shapes: vec![("spindle-growth".into(), vec![300.0])],
        reading_um: 0.42,
        parameters: vec![value("EX0C", &[1.0]), value("EZ0C", &[]), value("EY0C", &[-0.25, 1.0])],
    };
    let entry = ModelEffect { id: "backlash:C".into(), ..ModelEffect::default() };
    let added = Model::append(&base.to_text(), &entry).unwrap();
    let kept = Model::with_values(&added, &values).unwrap();
    let model = Model::parse("m.toml", &kept).unwrap();
    assert_eq!(model.values(), Some(&values), "{kept}");
    assert_eq!(Model::parse("m.toml", &model.to_text()).unwrap(), model);
    let longer = Model::append(&kept, &formula()).unwrap();
    assert_eq!(Model::parse("m.toml", &longer).unwrap().values(), None, "nobody fitted this model");
    assert_eq!(Model::without(&longer, "formula:hose").unwrap(), kept, "the values count again");
    assert_eq!(Model::without(&kept, "backlash:C").unwrap(), base.to_text());
    let cut = kept.replace("correlation = [-0.25, 1.0]", "correlation = [1.0]");
    let problems = Model::parse("m.toml", &cut).unwrap_err().to_string();
    assert!(problems.contains("correlation has 1 numbers"), "{problems}");
}

#[test]
fn every_problem_of_a_model_file_is_named_with_its_line() {
    let text = "format = \"trunnion-model/2\"\nmachine = \"m\"\n[[effect]]\nid = \"a\"\nshap = [1]\n\
                [[effect]]\nid = \"a\"\nsite = \"ball\"\n[[effect]]\nid = \"formula:f\"\nsite = \"ball\"\n\
                component = \"dx\"\n";
    let problems = Model::parse("m.toml", text).unwrap_err();
    let lines: Vec<_> = problems.0.iter().map(|p| p.line).collect();
    assert_eq!(lines, [1, 3, 5, 7, 8, 9], "{problems}");
}

#[test]
fn a_model_file_without_location_errors_is_refused_with_what_to_write() {
    let text = "format = \"trunnion-model/1\"\nmachine = \"m\"\n";
    let refused = |text: &str| Model::parse("m.toml", text).unwrap_err().to_string();
    for said in [refused(text), refused(&format!("{text}[[effect]]\nid = \"ball-setting\"\n"))] {
        assert!(
            said.contains("effect holds no location-errors") && said.contains("Put [[effect]]"),
            "{said}"
        );
    }
    let alone = Model::parse("m.toml", &format!("{text}[[effect]]\nid = \"location-errors\"\n"));
    assert!(alone.is_ok(), "expressions may take the place of a ball's setting");
}

#[test]
fn what_a_machine_cannot_have_is_named_with_its_line() {
    let machine = trunnion_machine::shipped::machine("table-bc").unwrap();
    let text = "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[effect]]\nid = \"location-errors\"\n\
                [[effect]]\nid = \"backlash:Q\"\n\
                [[effect]]\nid = \"formula:f\"\nsite = \"axis:B\"\ncomponent = \"dz\"\nexpression = \"k*sin(2*B\"\n\
                [[effect]]\nid = \"formula:g\"\nsite = \"axis:Q\"\ncomponent = \"dz\"\nexpression = \"k*B\"\n";
    assert!(Model::parse("m.toml", text).is_ok(), "what the file says by itself is in order");
    let problems = Model::check("m.toml", text, &machine).unwrap_err();
    let lines: Vec<_> = problems.0.iter().map(|p| p.line).collect();
    assert_eq!(lines, [6, 11, 14], "{problems}");
    let said = problems.to_string();
    for part in ["\"backlash:Q\" is no effect of machine table-bc", "backlash:C", "column 10", "axis:Q"] {
        assert!(said.contains(part), "{part}: {said}");
    }
}
