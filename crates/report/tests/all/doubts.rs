//! Every doubt is said in the language of the report.

use trunnion_report::Language;
use trunnion_results::{Doubt, DoubtReason};

/// What a doubt of each reason says: a new reason does not compile without one.
fn doubts_of(reason: DoubtReason) -> Vec<Doubt> {
    use trunnion_core::axis::iso::C;
    use trunnion_engine::fit::doubts::{Doubt as Found, DoubtReason as Why};
    use trunnion_engine::plausibility::{ClockDoubt, Differs, How, Remainders, Rounded, RoundedWhat, Unlike};
    let found =
        |reason| vec![Doubt::from(&Found { effect: None, names: vec!["a".into(), "b".into()], reason })];
    let rounded = |given: &str, what| {
        Doubt::rounded(&Rounded { run: "day".into(), given: given.into(), hidden_um: 0.3, what })
    };
    let lone = |most| Doubt::lone_readings("day", [7, 90], most);
    match reason {
        DoubtReason::Collinear => found(Why::Collinear { condition_index: 41.0 }),
        DoubtReason::BeyondPhysical => limits()
            .into_iter()
            .flat_map(|(limit, unit)| found(Why::BeyondPhysical { limit, unit }))
            .collect(),
        DoubtReason::LongerThanRun => found(Why::LongerThanRun { tau_s: 5046.0, longest_s: 1682.0 }),
        DoubtReason::TermsNotSeparated => {
            found(Why::TermsNotSeparated { value: 186.0, u: 86.0, unit: trunnion_effects::Unit::S })
        }
        DoubtReason::PlaceAndTime => found(Why::PlaceAndTime { joint: C }),
        DoubtReason::OneDirection => found(Why::OneDirection { joint: C, stated: 1.0, contrary: [3, 40] }),
        DoubtReason::Scatter => found(Why::Scatter { noise_um: 4.0 }),
        DoubtReason::Clock => {
            let set = ClockDoubt::SetForward { row: 141, by_s: 3604.0, usual_s: 4.0 };
            let slow = ClockDoubt::Slow { span_s: 166_586.0, usual_s: 118.0 };
            [ClockDoubt::OneTime(0.0), set, slow].iter().map(|doubt| Doubt::clock("day", doubt)).collect()
        }
        DoubtReason::Rounded => {
            let lengths = RoundedWhat::Lengths { scatter_um: 0.29 };
            let digits = "with no more than 3 significant digits, the largest in steps of 0.1 mm";
            vec![
                rounded("in steps of 0.01° (B, C); 0.01 mm (X, Y)", RoundedWhat::Positions),
                rounded("in steps of 0.001 mm", lengths),
                rounded(digits, lengths),
            ]
        }
        DoubtReason::LoneReadings => vec![lone(None), lone(Some("setup low, component x".into()))],
        DoubtReason::OtherMachine => vec![Doubt::other_machine(["table-bc", "table-ac"])],
        DoubtReason::CalibrationOutOfDate => {
            let day = |text| trunnion_core::Day::parse(text).expect("a day");
            vec![Doubt::calibration("day", &["probe-1", "probe-2"], day("2026-05-12"), day("2026-08-01"))]
        }
        DoubtReason::UnlikeRuns => {
            let most =
                || Some(Differs { name: "EZ0B".into(), shown: ["−30.8 µm".into(), "+11.3 µm".into()] });
            let changed = How::Changed(Remainders { together_um: 23.5, apart_um: 0.41 });
            let all = [
                (How::OfTwoMachines { count: 8, differ_um: 19.8 }, most()),
                (changed, most()),
                (changed, None),
            ];
            let doubt = |(how, most)| {
                let runs = ["monday".into(), "tuesday".into()];
                Doubt::unlike_runs(&Unlike { runs, how, most })
            };
            all.map(doubt).into()
        }
    }
}

/// Every limit of a parameter of the catalogue, each of its words once: on a machine that moves, warms and deflects its probes.
fn limits() -> Vec<(trunnion_effects::Limit, trunnion_effects::Unit)> {
    use trunnion_effects::{Instance, Scene, SceneSetup};
    let machine = trunnion_machine::shipped::machine("table-bc").expect("a machine that ships");
    let state = |i: usize| trunnion_core::State {
        position: trunnion_core::AxisValues::of(machine.joints(), |joint| {
            (i * (joint.index() + 2) % 7) as f64
        }),
        time_s: Some(60.0 * i as f64),
        temperature_degc: vec![20.0 + (i as f64).sin()],
        deflection_mm: nalgebra::Vector3::new(0.1, -0.05, 0.02) * (i as f64).cos(),
        ..trunnion_core::State::default()
    };
    let states: Vec<trunnion_core::State> = (0..40).map(state).collect();
    let setup = SceneSetup::r_test("low", nalgebra::Point3::new(150.0, 0.0, 60.0));
    let scene = Scene::new(machine.clone(), vec![setup], vec!["frame".into()], states.iter());
    let all = Instance::all(&machine);
    let parameters = all.iter().flat_map(|instance| instance.parameters(&scene));
    let mut found = Vec::<(trunnion_effects::Limit, trunnion_effects::Unit)>::new();
    for (limit, unit) in parameters.filter_map(|parameter| Some((parameter.limit?, parameter.unit))) {
        if found.iter().all(|(known, _)| known.beyond != limit.beyond) {
            found.push((limit, unit));
        }
    }
    assert!(found.len() >= 5, "{found:?}");
    found
}

#[test]
fn doubts_and_places_of_a_report_are_of_one_language() {
    let doubts = DoubtReason::ALL.into_iter().flat_map(doubts_of);
    let said = doubts.map(|doubt| format!("Doubt: {}", doubt.words));
    let places = [
        "table Y, C at 150°, both directions, both setups:",
        "X, Y at 100 mm, setup low:",
        "low: R-test, ball at X 150 mm, Y 0 mm, Z 60 mm",
        "bed: 20.1 to 20.9 °C, 20.4 °C on average",
    ];
    for text in said.chain(places.map(String::from)) {
        for language in [Language::German, Language::Japanese] {
            let said = language
                .say(&text)
                .unwrap_or_else(|| panic!("no entry in crates/report/src/language/table: {text}"));
            let english = [" the ", " is ", " at ", " of ", " than ", "table ", "both ", "only "];
            assert!(english.iter().all(|word| !said.contains(word)), "{said}");
        }
    }
}
