//! LinuxCNC moves five axes by our NC program while simulated probes follow its real positions: our service records the
//! cycle, and the location errors hidden in the machine are found.

use crate::linuxcnc_cell::{Followed, Task, measure};
use crate::linuxcnc_process::{Drives, LinuxCnc};
use std::collections::BTreeMap;
use trunnion_cycles::Cycle;
use trunnion_hil_sim::truth::minimum_set;
use trunnion_hil_sim::{Truth, VirtualMachine};
use trunnion_machine::shipped;
use trunnion_tests::{mounted, show_log};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn location_errors_are_found_in_a_cycle_that_linuxcnc_moves() {
    show_log();
    let cycle_text = include_str!("../../../config/cycles/demo-static.toml")
        .replace("step_deg = 30", "step_deg = 90")
        .replace("to_deg = 330", "to_deg = 270");
    let cycle = Cycle::parse("c.toml", &cycle_text).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    let poses = cycle.poses(&machine).unwrap().len();
    let setups = mounted(&cycle);
    let truth = Truth::draw(&machine, &setups, &[], 600.0, 11).unwrap();
    let hidden: BTreeMap<String, f64> =
        minimum_set(&machine).iter().map(|error| (error.name(), error.of(&truth.location))).collect();
    let world = Followed::new(VirtualMachine::new(machine.clone(), truth).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let cnc = LinuxCnc::start(Drives::Direct);
    let task = Task {
        cnc: &cnc,
        drives: Drives::Direct,
        machine: &machine,
        cycle_text: &cycle_text,
        dwell_s: Some(0.5),
        analysed: true,
        transfer_mm_per_s: 100.0,
    };
    let report = measure(folder.path(), world, &task).await.with_extension("identification.json");
    drop(cnc);

    let reported: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&report).unwrap()).unwrap();
    assert_eq!(reported["points"].as_u64(), Some(poses as u64), "every pose is read");
    println!("{poses} poses, rms {} µm", reported["rms_um"]);
    let mut found = 0;
    for parameter in reported["parameters"].as_array().unwrap() {
        let name = parameter["name"].as_str().unwrap();
        let (Some(hidden), Some(value), Some(u)) =
            (hidden.get(name), parameter["value"].as_f64(), parameter["u"].as_f64())
        else {
            continue;
        };
        let hidden = hidden * 1e3 * if name.as_bytes()[1] <= b'C' { 1e3 } else { 1.0 };
        println!("{name}: {value:.2} ± {u:.2}, hidden {hidden:.2}");
        // µm and µrad.
        assert!((value - hidden).abs() <= 4.0 * u + 0.3, "{name}: {value} ± {u} is not {hidden}");
        found += 1;
    }
    assert!(found >= 8, "{found} location errors: {}", reported["parameters"]);
}
