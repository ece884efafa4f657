//! Pages of a small grid run: well-formed, without outside assets, and in the right order.

use nalgebra::Point3;
use trunnion_core::{InstrumentKind, Joint, NestSide, Point, Quality, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{LadderRow, Model, ModelEffect, Moved};
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, identify};
use trunnion_machine::shipped;
use trunnion_methods::recipes;
use trunnion_methods::recipes::MethodOptions;
use trunnion_report::{
    compare_html, compare_text, findings_html, findings_text, ladder_html, ladder_text, trial_html,
    trial_text,
};
use trunnion_results::{Comparison, Complete, Excluded, Findings, FoundValue, Ladder, Trial, ValueKind};

/// Two heights, B every 45°, C every 45° forth and back; the tool reads 2.5 µm further along Z with C going forward, and
/// as much less with C going back. Where a pass begins, C comes from the other side.
fn run() -> Run {
    let setup = |name: &str, z: f64| {
        Setup::new(name, InstrumentKind::RTest, NestSide::Table, Point3::new(150.0, 0.0, z))
    };
    let machine = shipped::machine("table-bc").unwrap();
    let mut points = Vec::new();
    for index in 0..2 * 2 * 5 * 8_usize {
        let (setup, way, b, c) = (index / 80, index / 40 % 2, index / 8 % 5, index % 8);
        let mut state = State { setup, time_s: Some(5.0 * index as f64), ..State::default() };
        let turned = if way == 0 { c } else { 7 - c };
        state.position[Joint::B] = (-90.0 + 45.0 * b as f64).to_radians();
        state.position[Joint::C] = (45.0 * turned as f64).to_radians();
        let forward = (way == 0) != (index % 80 == 0);
        state.direction[Joint::C] = if forward { 1.0 } else { -1.0 };
        state.direction[Joint::B] = 1.0;
        let along_z_um = if forward { 2.5 } else { -2.5 };
        let scatter = |k: usize| ((index * 7919 + k * 104_729) % 1000) as f64 / 1000.0 - 0.5;
        let in_machine = nalgebra::Vector3::new(scatter(1), scatter(2), along_z_um + scatter(3)) * 1e-3;
        let machine_from_table = machine.machine_from_table(&state.position, &Default::default());
        let reading = machine_from_table.rotation.inverse() * in_machine;
        let reading_mm = [reading.x, reading.y, reading.z];
        points.push(Point { state, reading_mm, spread_mm: [0.0; 3], samples: 0, quality: Quality::Good });
    }
    Run {
        name: "grid <&\"'".into(),
        machine,
        kind: RunKind::Static,
        setups: vec![setup("low <b>", 60.0), setup("high", 160.0)],
        channels: Vec::new(),
        points,
    }
}

fn entry() -> ModelEffect {
    let moved = Moved { name: "EX0C".into(), before: -3.2, after: -1.1, u: 0.26, unit: "um".into() };
    ModelEffect {
        id: "backlash:B".into(),
        ladder: Some(LadderRow {
            date: "2026-03-01".into(),
            by: Some("Ada".into()),
            with: None,
            run: "grid".into(),
            error_before_um: 2.0,
            error_after_um: 1.0,
            holdout_before_um: Some(2.4),
            holdout_after_um: Some(1.2),
            holdout_unit: Some("pass".into()),
            noise_um: Some(0.5),
            moved: vec![moved],
            ..LadderRow::default()
        }),
        ..ModelEffect::default()
    }
}

pub fn fitted() -> (Experiment, Comparison) {
    let experiment = Experiment::new(&[run()]).unwrap();
    let fit = identify(&experiment, &Model::base("table-bc"), &Options::default()).unwrap();
    let input = Comparison::new(&experiment, &fit, None);
    (experiment, input)
}

pub fn model() -> Model {
    let mut model = Model::base("table-bc");
    model.effects.push(entry());
    model
}

pub fn check_page(page: &str) {
    let mut reader = quick_xml::Reader::from_str(page);
    loop {
        match reader.read_event() {
            Ok(quick_xml::events::Event::Eof) => break,
            Ok(_) => {}
            Err(error) => panic!("at {}: {error}", reader.error_position()),
        }
    }
    for outside in ["http:", "https:", "src=", "url(", "<script", "@import", "<link"] {
        assert!(!page.contains(outside), "the page asks for something outside: {outside}");
    }
    assert!(!page.contains("low <b>") && !page.contains("NaN"), "names are escaped, holes are no numbers");
    assert!(!page.contains("></th>"), "a screen reader has nothing to say of a column");
}

#[test]
fn every_page_is_well_formed_and_needs_nothing_from_outside() {
    let (experiment, mut input) = fitted();
    input.ladder = Ladder::from(&model());
    let before = identify(&experiment, &Model::base("table-bc"), &Options::default()).unwrap();
    let entry = ModelEffect { id: "gravity-sag:B".into(), ..ModelEffect::default() };
    let mut with = Model::base("table-bc");
    with.effects.push(entry.clone());
    let after = identify(&experiment, &with, &Options::default()).unwrap();
    let trial = Trial::new(&experiment, &entry, std::slice::from_ref(&entry), [&before, &after], None);
    for page in
        [compare_html(&input, "<test>"), trial_html(&trial, ""), ladder_html("mill <1>", &input.ladder)]
    {
        check_page(&page);
    }
    let text = trial_text(&trial);
    assert!(text.contains("held-out after") && text.contains("Where the model fails most, after"), "{text}");
}

#[test]
fn the_page_of_a_named_method_shows_values_charts_and_tables() {
    let method = recipes::find("error-map").unwrap();
    let mut run = run();
    for point in &mut run.points {
        let ball = run.setups[point.state.setup].ball_in_table_mm;
        point.state.position = run.machine.follow(&point.state.position, &ball).unwrap();
        // The line of B lies 20 µm off: what stands out of the ±2.5 µm by which the passes differ.
        let table = run.machine.machine_from_table(&point.state.position, &Default::default());
        let moved = table.rotation.inverse() * nalgebra::Vector3::new(20e-3, 0.0, 0.0);
        point.reading_mm.iter_mut().zip(moved.iter()).for_each(|(reading, moved)| *reading += moved);
    }
    let findings = Findings::from(&method.apply(&[run], &MethodOptions::default()).unwrap());
    let page = findings_html(&findings, "Trunnion <test>");
    let (verdict, source) =
        (page.find(" moves the tool most: ").unwrap(), page.find("Method and source").unwrap());
    assert!(
        verdict < page.find("<table").unwrap() && source > page.rfind("<table").unwrap(),
        "the verdict first, the source last"
    );
    let first = page.split("<h1>").nth(1).unwrap().split("</h1>").next().unwrap();
    assert!(
        first.contains("error-map: The ") && first.ends_with(")."),
        "words first, the symbol last: {first}"
    );
    check_page(&page);
    let order = [
        "<h1>",
        "What to do",
        "Errors of B over B",
        "Values with",
        "Places of the nest",
        "<h2>Tables",
        "Location errors by",
    ];
    let places: Vec<_> = order.iter().map(|heading| page.find(heading).unwrap()).collect();
    assert!(places.is_sorted(), "{places:?}");
    assert_eq!(page.matches("<svg").count(), findings.charts.len());
    let text = findings_text(&findings);
    assert!(text.contains("error-map") && text.contains("EX0B") && text.contains("−90.0"), "{text}");
}

#[test]
fn the_page_goes_from_the_verdict_over_the_places_to_the_tables() {
    let (_, mut input) = fitted();
    input.ladder = Ladder::from(&model());
    let page = compare_html(&input, "");
    let order = ["<h1>", "Ladder", "Where the model fails most", "What is missing", "Residual over B and C"];
    let places: Vec<_> = order.iter().map(|heading| page.find(heading).unwrap()).collect();
    assert!(places.is_sorted(), "{places:?}");
    // No model without directions takes any of it.
    let words: Vec<&String> = input.places.iter().map(|place| &place.words).collect();
    assert!(words[0].starts_with("Z, both setups, +2.5 µm with C forward, −2.5 µm with C back"), "{words:?}");
    assert!(compare_text(&input).contains("1. Z, both setups, +2.5 µm"));
}

#[test]
fn that_every_point_was_read_stands_in_no_warning() {
    let (_, mut input) = fitted();
    let excluded = Excluded { count: 4, reason: "the fit leaves too much".into() };
    input.identification.complete =
        Complete { planned: Some(336), read: 336, excluded: vec![excluded], ..Complete::default() };
    let page = compare_html(&input, "");
    assert!(
        page.contains("<p>All 336 planned points were read.</p><ul class=\"warn\"><li>4 points are excluded")
    );
    input.identification.complete.read = 330;
    assert!(compare_html(&input, "").contains("<ul class=\"warn\"><li>330 of 336 planned points were read."));
}

#[test]
fn poses_of_turning_round_make_no_maps_of_their_own() {
    let (_, input) = fitted();
    let page = compare_html(&input, "");
    // 2 setups × 2 passes × 3 components, and one map for each place.
    assert_eq!(page.matches("B down, C across").count(), 12 + input.places.len());
}

#[test]
fn every_row_of_a_comparison_fits_eighty_columns() {
    let (_, input) = fitted();
    let text = compare_text(&input);
    let table = text.lines().skip_while(|line| !line.starts_with("residual by"));
    let rows: Vec<&str> = table.take_while(|line| !line.is_empty()).collect();
    assert!(rows.len() > 5 && rows.iter().any(|row| row.contains("########")), "{text}");
    for row in rows {
        assert!(row.chars().count() <= 80, "{row}");
    }
}

#[test]
fn the_ladder_shows_fit_held_out_noise_and_what_moved() {
    let text = ladder_text(&Ladder::from(&model()), None);
    let rung = text.lines().find(|line| line.starts_with("+ backlash:B")).unwrap();
    assert!(rung.contains("#####|####") && rung.contains('o') && rung.contains("0.50 µm"), "{rung}");
    let moved = text.split_once("Moved by more than 2 u when backlash:B came in\n").unwrap().1;
    let moved = moved.lines().find(|line| line.starts_with("EX0C")).unwrap();
    assert!(["−3.20", "−1.10", "µm", "8.1 u"].iter().all(|part| moved.contains(part)), "{moved}");
    for line in text.lines().filter(|line| !line.starts_with("Bars:")) {
        assert!(line.chars().count() <= 80, "{line}");
    }
    let page = ladder_html("mill", &Ladder::from(&model()));
    assert!(page.contains("EX0C −3.20 → −1.10 µm, 8 u"));
    assert!(page.contains("<h1>Machine mill: one effect took the error from"), "the verdict first");
}

#[test]
fn a_method_is_summed_up_and_names_first_what_moves_the_tool_most() {
    let value = |name: &str, value, unit: &str, u| FoundValue {
        name: name.into(),
        value: Some(value),
        unit: unit.into(),
        u: Some(u),
        ..FoundValue::default()
    };
    let findings = Findings {
        values: vec![
            FoundValue {
                u: None,
                note: "bidirectional circular deviation".into(),
                kind: ValueKind::Summary,
                ..value("XY G(b)", 6.6, "um", 0.0)
            },
            FoundValue { kind: ValueKind::Setting, ..value("setting.low.x", 200.0, "um", 0.1) },
            // 0.05 µm over 100 mm, 500 standard uncertainties; 6 µm over 100 mm, 12; 4 µm, 40.
            value("EA0B", 0.5, "urad", 0.001),
            value("XY EC0Y", 60.0, "urad", 5.0),
            value("EX0C", 4.0, "um", 0.1),
        ],
        ..Findings::default()
    };
    let text = findings_text(&findings).split_whitespace().collect::<Vec<_>>().join(" ");
    let summary = text.find("Bidirectional circular deviation: 6.6").unwrap_or_else(|| panic!("{text}"));
    let largest = text
        .find("In XY, the direction of axis Y about Z moves the tool most: 60")
        .unwrap_or_else(|| panic!("{text}"));
    assert!(text.contains("What to do: 1. Ask what is behind it"), "{text}");
    assert!(summary < largest && text.contains("µm over 100 mm), standard uncertainty"), "{text}");
    assert!(findings_html(&findings, "").contains("<h1>Machine , : Bidirectional circular deviation: 6.6"));

    // Of a delay it is not known how far it moves the tool.
    let delay = Findings { values: vec![value("delay", 2.0, "ms", 0.1)], ..Findings::default() };
    let text = findings_text(&delay).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("delay is significant: 2.0") && !text.contains("moves the tool"), "{text}");
}
