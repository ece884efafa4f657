//! A service whose bar counts from another zero than its configuration says: a doubt with the first points, and no verdict.

use crate::cycle_program::CycleProgram;
use crate::cycles_in_service::{LATER_S, OPERATOR_S, cell, floor, quick};
use crate::service::measured;
use std::path::Path;
use std::sync::Arc;
use trunnion::results::Verdict;
use trunnion_cycles::Cycle;
use trunnion_hil_sim::devices::Later;
use trunnion_hil_sim::devices::canopen::NodeKind;
use trunnion_hil_sim::{Truth, VirtualMachine};
use trunnion_machine::shipped;
use trunnion_tests::mounted;

const CYCLE: &str = include_str!("../../../config/cycles/s4-c.toml");
/// What the encoder shows at the length of the bar; the configuration of the service says 10 mm.
const SHOWN_MM: f64 = 22.5;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_bar_that_counts_from_another_zero_is_doubted_at_once_and_never_judged() {
    // Two setups are enough, at a feed at which a test can wait for them.
    let setups: Vec<&str> = CYCLE.split("[[setup]]").collect();
    let sweep = CYCLE.split_once("[sweep]").unwrap().1.replace("[720]", "[3600]");
    let text = format!("{}[sweep]{sweep}", setups[..3].join("[[setup]]"));
    let cycle = Cycle::parse("c.toml", &text).unwrap();
    assert!(cycle.setups.len() == 2 && cycle.setups.iter().all(|setup| setup.calibrated));
    let machine = shipped::machine(&cycle.machine).unwrap();
    let program = CycleProgram::of(&cycle, &machine, &quick(), OPERATOR_S);
    let duration_s = program.trajectory.duration_s();
    let truth = Truth::draw(&machine, &mounted(&cycle), &[], duration_s, 7).unwrap();
    let world = Arc::new(VirtualMachine::new(machine.clone(), truth).unwrap());
    let shop = |folder: &Path| {
        let mut floor = floor(folder, &cycle, &program, &machine);
        let (bus, _) = floor.can.as_mut().unwrap();
        let NodeKind::BallBar { zero_mm, .. } = &mut bus.nodes[0].kind else { panic!("a ball bar") };
        *zero_mm = SHOWN_MM;
        (Later { world: cell("s4-c", &program, &world), by_s: LATER_S }, floor)
    };
    let (_folder, paths) = measured(&text, 1, shop).await;

    let events = trunnion_record::read_run(&paths[0], &|_| Some(machine.clone())).unwrap().events;
    for setup in &cycle.setups {
        let doubt = format!("Setup {}: the bar reads +12.5", setup.name);
        let said: Vec<_> = events.iter().filter(|event| event.text.starts_with(&doubt)).collect();
        assert!(said.len() == 1 && said[0].kind == "warning", "{doubt}: {said:?}");
        assert!(said[0].text.contains("correct zero_mm"), "{said:?}");
    }
    let check = trunnion::open(&paths[0]).unwrap().check();
    assert_eq!(check.plausibility.len(), 1, "{check:?}");
    let one = &check.plausibility[0];
    assert!(one.finding.contains("+12.5") && one.hypothesis.contains("Change it?"), "{one:?}");
    let found = std::fs::read_to_string(paths[0].with_extension("diagnosis.json")).unwrap();
    let found: trunnion::results::Diagnosis = serde_json::from_str(&found).unwrap();
    assert_eq!(found.verdict, Verdict::NotJudged);
}
