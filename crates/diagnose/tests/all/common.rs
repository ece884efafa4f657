//! Points files and synthetic runs for tests.

use trunnion_machine::{State, shipped};
use trunnion_measurement::{Point, Quality, Run, RunKind, direction, setup};
use trunnion_units::{AxisLetter, AxisValues};

/// Reads a committed points set (DESIGN §3.2).
pub fn points_set(name: &str) -> Run {
    let folder = format!("{}/../../tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| std::fs::read_to_string(format!("{folder}/{file}")).unwrap();
    let setups = setup::parse_setup_file("setup.toml", &read("setup.toml")).unwrap();
    let text = read("points.csv");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let channels: Vec<String> =
        header.iter().filter_map(|h| h.strip_suffix("_degc")).map(String::from).collect();
    let mut points = Vec::new();
    for line in lines.filter(|line| !line.trim().is_empty()) {
        let fields: Vec<&str> = line.split(',').collect();
        let text = |name: &str| header.iter().position(|h| *h == name).map(|i| fields[i]);
        let number = |name: &str| text(name).map_or(0.0, |t| t.parse::<f64>().unwrap());
        let mut position = AxisValues::default();
        let mut direction = AxisValues::default();
        for letter in AxisLetter::ALL {
            let lower = letter.lower();
            position[letter] = if letter.is_rotary() {
                number(&format!("{lower}_deg")).to_radians()
            } else {
                number(&format!("{lower}_mm"))
            };
            direction[letter] = number(&format!("direction_{lower}"));
        }
        let setup = setups.setups.iter().position(|s| Some(s.name.as_str()) == text("setup")).unwrap();
        let temperature_degc = channels.iter().map(|c| number(&format!("{c}_degc"))).collect();
        let time_s = text("time_s").map(|t| t.parse().unwrap());
        let state = State { position, direction, time_s, temperature_degc, setup, ..State::default() };
        points.push(Point {
            state,
            reading_mm: ["dx_um", "dy_um", "dz_um"].map(|name| number(name) / 1e3),
            spread_mm: [0.0; 3],
            samples: 0,
            quality: Quality::Good,
        });
    }
    let machine = shipped::machine(&setups.machine).unwrap();
    direction::fill_directions(&mut points, &[AxisLetter::X, AxisLetter::Y, AxisLetter::Z]);
    Run { name: name.into(), machine, kind: RunKind::Static, setups: setups.setups, channels, points }
}
