//! Good ball bars, and gross mistakes with them.

use super::Files;
use trunnion::cycles::{Cycle, Pace};
use trunnion_core::Joint;
use trunnion_machine::shipped;

/// A good ball bar: what a cycle visits, with a run-out and scatter of 0.3 µm, shown in steps of 0.1 µm.
pub fn bar(cycle_text: &str) -> Files {
    let cycle = Cycle::parse("bar.toml", cycle_text).unwrap();
    let machine = shipped::machine(&cycle.machine).unwrap();
    let states = cycle.visits(&machine, &Pace { points_per_s: 2.0, ..Pace::default() }).unwrap().states;
    let letters: Vec<Joint> = machine.axes().map(|axis| axis.letter).collect();
    let unit = |axis: &Joint| if axis.is_rotary() { "deg" } else { "mm" };
    let columns = letters.iter().map(|axis| format!("{}_{}", axis.lower(), unit(axis)));
    let header = ["setup".to_string(), "time_s".into()].into_iter().chain(columns).chain(["dr_um".into()]);
    let row = |(k, state): (usize, &trunnion_core::State)| {
        let at = |axis: &Joint| match axis.is_rotary() {
            true => state.position[*axis].to_degrees(),
            false => state.position[*axis],
        };
        let noise = (12.9898 * k as f64).sin() * 43_758.545_3;
        let reading_um = 5.0 * (0.1 * k as f64).sin() + (noise - noise.floor() - 0.5);
        let mut row = vec![cycle.setups[state.setup].name.clone(), format!("{:.3}", state.time_s.unwrap())];
        row.extend(letters.iter().map(|axis| format!("{:.6}", at(axis))));
        row.push(format!("{reading_um:.1}"));
        row
    };
    let mut setup = format!("format = \"trunnion-points/1\"\nmachine = \"{}\"\n", cycle.machine);
    for one in &cycle.setups {
        let ball = one.ball_in_table_mm;
        setup += &format!(
            "[[setup]]\nname = \"{}\"\ninstrument = \"ball-bar\"\nbar_length_mm = {:.1}\nball_in_table_mm = [{:.1}, {:.1}, {:.1}]\n",
            one.name,
            one.bar_length_mm.unwrap(),
            ball.x,
            ball.y,
            ball.z
        );
        if one.calibrated {
            setup += "calibrated = true\n";
        }
    }
    Files { header: header.collect(), rows: states.iter().enumerate().map(row).collect(), setup }
}

const BAR_C: &str = include_str!("../../../../../config/cycles/ball-bar-c.toml");
const BAR_CALIBRATED: &str = include_str!("../../../../../config/cycles/s4-c.toml");
const BAR_OFF_CENTRE: &str = include_str!("../../../../../config/cycles/bk1-b.toml");
const BAR_XY: &str = include_str!("../../../../../config/cycles/circle-xy.toml");

/// What is spoilt of which cycle, and what must be said of it.
pub type BarMistake = (&'static str, &'static str, fn(&mut Files), &'static [&'static str]);

pub const BARS: [BarMistake; 12] = [
    ("constant", BAR_C, |f| f.change("dr_um", |_| 5.0), &["the probe dr reads the same value"]),
    (
        "nanometres",
        BAR_C,
        |f| f.change("dr_um", |v| 1e3 * v - 2e3),
        &["farther than any bar reads", "In nm instead of µm"],
    ),
    (
        "readings that hold the length",
        BAR_C,
        |f| f.change("dr_um", |v| v + 1e5),
        &["hold the length of the bar"],
    ),
    (
        "the zero of its encoder in a calibrated length",
        BAR_CALIBRATED,
        |f| f.change("dr_um", |v| v + 12_500.0),
        &[
            "+12.500 mm from its calibrated length of 100 mm in every pose",
            "zero_mm",
            "3.5 µm are left. Change it?",
        ],
    ),
    (
        "the length in a calibrated length",
        BAR_CALIBRATED,
        |f| f.change("dr_um", |v| v + 1e5),
        &["+100.000 mm from its calibrated length of 100 mm", "column dr"],
    ),
    ("stuck", BAR_C, |f| f.hold("dr_um", 10, 60), &["the probe dr reads the same value"]),
    (
        "x and z exchanged",
        BAR_C,
        |f| f.exchange("x_mm", "z_mm"),
        &["ends of the ball bar", "off its length", "X and Z exchanged"],
    ),
    (
        "inches",
        BAR_C,
        |f| ["x_mm", "y_mm", "z_mm"].into_iter().for_each(|c| f.change(c, |v| v / 25.4)),
        &["inches"],
    ),
    ("sense of B", BAR_OFF_CENTRE, |f| f.change("b_deg", |v| -v), &["sense of B reversed"]),
    (
        "length",
        BAR_XY,
        |f| f.replace("bar_length_mm = 150", "bar_length_mm = 120"),
        &["bar_length_mm, 150.0, not 120.0"],
    ),
    (
        "length, as long as the ball is high",
        BAR_XY,
        |f| f.replace("bar_length_mm = 150", "bar_length_mm = 100"),
        &["bar_length_mm, 150.0, not 100.0"],
    ),
    (
        "ball",
        BAR_XY,
        |f| f.replace("[0.0, 0.0", "[40.0, 0.0"),
        &["position of the ball of setup xy", "at [0.0, "],
    ),
];
