//! The component of LinuxCNC, compiled and run.

use super::{CYCLES, NOISE_UM, Shop, model, quiet_truth};
use std::io::Write;
use std::process::{Command, Stdio};
use trunnion_core::{AxisValues, Joint, State};
use trunnion_hil_sim::physics::grid;
use trunnion_hil_sim::{SimSetup, VirtualMachine};

#[test]
fn the_component_of_linuxcnc_computes_what_takes_the_errors_away() {
    let shop = Shop::new(5);
    let (file, answer) = shop.correct("linuxcnc", &[]);
    let machine = trunnion::files::machine("table-bc").unwrap();
    let virtual_machine = VirtualMachine::new(machine.clone(), shop.truth.clone()).unwrap();
    let placed: Vec<SimSetup> = shop.truth.setups.iter().map(|placed| placed.setup.clone()).collect();
    let states = grid::standard_bc(&machine, &placed);
    let joints = [Joint::B, Joint::C, Joint::X, Joint::Y, Joint::Z];
    let [before, after, wrong] =
        with_the_component(&shop, &file, &virtual_machine, &placed, &states, &joints);
    println!("{before:.3} µm before, {after:.4} after, {wrong:.3} with the wrong sign");
    // What is left is what noise of 0.1 µm put into some thirty parameters found from 1008 readings: 0.1 √(30/1008).
    assert!(after < 0.3 * NOISE_UM, "{before} before, {after} after");
    assert!((wrong / before - 2.0).abs() < 0.01, "{before} before, {wrong} with the wrong sign");
    assert_eq!(answer["undo"][0], "halcmd setp trunnion-correction.enable 0");
}

#[test]
fn the_component_of_linuxcnc_takes_the_errors_of_heads_away() {
    use trunnion_core::axis::iso::{A, B, C, X, Y, Z};
    // Joints from the bed outward, those of the table first, as the component names them.
    let machines = [("head-bc", vec![X, Y, Z, C, B]), ("head-a-table-c", vec![C, X, Y, Z, A])];
    for (name, joints) in machines {
        let cycle_name = format!("r-test-{name}");
        let shop = Shop::measured(quiet_truth(name), Some(&cycle_name), &model(name, &[]));
        let (file, answer) = shop.correct("linuxcnc", &["--although-inadequate"]);
        let machine = trunnion::files::machine(name).unwrap();
        let text = std::fs::read_to_string(format!("{CYCLES}/{cycle_name}.toml")).unwrap();
        let cycle = trunnion_cycles::Cycle::parse(&cycle_name, &text).unwrap();
        let setups: Vec<SimSetup> = cycle.setups.iter().map(SimSetup::from).collect();
        let states = cycle.visits(&machine, &trunnion_cycles::Pace::default()).unwrap().states;
        let virtual_machine = VirtualMachine::new(machine, shop.truth.mounted(&setups, 1)).unwrap();
        let [before, after, wrong] =
            with_the_component(&shop, &file, &virtual_machine, &setups, &states, &joints);
        println!("{name}: {before:.3} µm before, {after:.4} after, {wrong:.3} with the wrong sign");
        assert!(before > 3.0 && after < NOISE_UM, "{name}: {before} before, {after} after: {answer}");
        assert!((wrong / before - 2.0).abs() < 0.02, "{name}: {before} before, {wrong} with the wrong sign");
    }
}

/// What is left of the ideal readings without the component of a file, with it, and with the opposite of it, µm: its C is compiled and asked
/// at every state, with the ball of the state's setup as tool point.
fn with_the_component(
    shop: &Shop,
    file: &str,
    virtual_machine: &VirtualMachine,
    setups: &[SimSetup],
    states: &[State],
    joints: &[Joint],
) -> [f64; 3] {
    let component = std::fs::read_to_string(file).unwrap();
    let core = component.split("/* begin: core */").nth(1).unwrap().split("/* end: core */").next().unwrap();
    let program = format!(
        "#include <math.h>\n#include <stdio.h>\n{core}\nint main(void) {{\n double q[JOINTS], t[3], tool[3];\n \
         while (scanf(\"%lf %lf %lf %lf %lf %lf %lf %lf\", q, q+1, q+2, q+3, q+4, tool, tool+1, tool+2) == 8)\n \
         if (correction(q, tool, t)) printf(\"%.12f %.12f %.12f\\n\", t[0], t[1], t[2]);\n return 0;\n}}\n"
    );
    std::fs::write(shop.path("core.c"), program).unwrap();
    let compiled = Command::new("cc")
        .args(["-Wall", "-Werror", "-std=gnu99", "-o", &shop.path("core"), &shop.path("core.c"), "-lm"])
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let mut core =
        Command::new(shop.path("core")).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let asked = |state: &State| {
        let place = |joint: &Joint| {
            let position = state.position[*joint];
            if joint.is_rotary() { position.to_degrees() } else { position }
        };
        let tool = setups[state.setup].ball_in_tool_mm;
        let numbers = joints.iter().map(place).chain([tool.x, tool.y, tool.z]);
        numbers.map(|number| number.to_string()).collect::<Vec<_>>().join(" ") + "\n"
    };
    let asked: String = states.iter().map(asked).collect();
    core.stdin.take().unwrap().write_all(asked.as_bytes()).unwrap();
    let said = String::from_utf8(core.wait_with_output().unwrap().stdout).unwrap();
    let travels: Vec<Vec<f64>> =
        said.lines().map(|line| line.split(' ').map(|n| n.parse().unwrap()).collect()).collect();
    assert_eq!(travels.len(), states.len());
    [0.0, 1.0, -1.0].map(|share| {
        let moved = states.iter().zip(&travels).map(|(state, travel)| {
            let mut position: AxisValues<f64> = state.position;
            for (k, letter) in Joint::LINEAR.into_iter().enumerate() {
                position[letter] += share * travel[k];
            }
            (state.setup, virtual_machine.ideal_reading_mm(state.setup, &State { position, ..state.clone() }))
        });
        about_mean_um(&moved.collect::<Vec<_>>())
    })
}

/// Rms about the mean of each component in each setup, µm.
fn about_mean_um(readings: &[(usize, [f64; 3])]) -> f64 {
    let mut sum = 0.0;
    let setups = readings.iter().map(|(of, _)| of + 1).max().unwrap_or(0);
    for setup in 0..setups {
        for k in 0..3 {
            let own: Vec<f64> = readings.iter().filter(|(of, _)| *of == setup).map(|(_, r)| r[k]).collect();
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            sum += own.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        }
    }
    1e3 * (sum / (3 * readings.len()) as f64).sqrt()
}
