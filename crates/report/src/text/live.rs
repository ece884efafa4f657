//! What is read at this moment, on a screen that is drawn again and as a line.

use super::table::{clean, columns, paragraph};
use crate::number::{plain, unit_on_screen};
use trunnion_core::number::signed;
use trunnion_results::{CalibratedProbe, Live, LiveAxis, LiveProbe, NestCalibrated, SignTest};

/// Characters of a range.
const WIDTH: usize = 33;

/// Everything, one thing a line; each probe with its range, the centre zone between the colons.
pub fn live_screen(live: &Live) -> String {
    let mut out = format!("{}\n", clean(&live.at));
    let probe = |p: &LiveProbe| vec![p.name.clone(), range_bar(p), value(p), p.say.clone()];
    out += &columns(&live.probes.iter().map(probe).collect::<Vec<_>>(), &[2]);
    out += &paragraph(&live.say);
    if let Some(cycle) = &live.cycle {
        out += &paragraph(&format!("{} {}: {} of {}", cycle.name, cycle.state, cycle.done, cycle.planned));
    }
    let axes: Vec<String> = live.axes.iter().map(axis).collect();
    let temperatures: Vec<String> = temperatures(live);
    for line in [axes, temperatures].into_iter().filter(|line| !line.is_empty()) {
        out += &paragraph(&line.join("  "));
    }
    for device in &live.devices {
        let remedy = device.remedy.as_ref().map(|remedy| format!(": {remedy}")).unwrap_or_default();
        out += &paragraph(&format!("{} {}{remedy}", device.name, device.state));
    }
    out
}

/// The same on one line.
pub fn live_line(live: &Live) -> String {
    let probe = |probe: &LiveProbe| format!("{} {}", probe.name, value(probe));
    let parts: Vec<String> = live.probes.iter().map(probe).chain(live.axes.iter().map(axis)).collect();
    let parts = parts.into_iter().chain(temperatures(live)).collect::<Vec<_>>().join("  ");
    clean(&format!("{}  {parts}  {}", live.at, live.say)) + "\n"
}

/// A calibrated nest: what was found, how sure, the lines for the configuration.
pub fn nest_text(nest: &NestCalibrated) -> String {
    let head = ["", "x", "y", "z", "u", "gain", "u", "residual"].map(String::from).to_vec();
    let row = |probe: &CalibratedProbe| {
        let [x, y, z] = probe.direction.map(|part| signed(part, 4));
        let u = format!("{} mrad", plain(probe.u_direction_mrad));
        let (gain, u_gain) = (format!("{:.4}", probe.gain), format!("{:.4}", probe.u_gain));
        vec![probe.role.clone(), x, y, z, u, gain, u_gain, format!("{} µm", plain(probe.residual_um))]
    };
    let rows: Vec<_> = std::iter::once(head).chain(nest.probes.iter().map(row)).collect();
    let table = columns(&rows, &[1, 2, 3, 4, 5, 6, 7]);
    format!(
        "Directions of the probes from {} dwells (an error of a probe grows by up to {} in nest axes):\n{table}\n{}",
        nest.steps,
        plain(nest.condition),
        nest.lines
    )
}

/// What jogs say of the probes.
pub fn sign_test_text(test: &SignTest) -> String {
    let mut out = String::new();
    if let Some(jog) = test.jogs.last() {
        let head = ["", "read", "expected"].map(String::from).to_vec();
        let mm = |mm: f64| format!("{} mm", signed(mm, 4));
        let row = |k: usize| vec![format!("probe-{}", k + 1), mm(jog.read_mm[k]), mm(jog.expected_mm[k])];
        let [x, y, z] = jog.ball_in_nest_mm.map(|mm| signed(mm, 3));
        out += &format!("Ball moved by {x}, {y}, {z} mm (nest axes)\n");
        out += &columns(&[head, row(0), row(1), row(2)], &[1, 2]);
    }
    out + &paragraph(&test.say)
}

fn value(probe: &LiveProbe) -> String {
    probe.value_mm.map_or_else(|| "no value".into(), |mm| format!("{} mm", signed(mm, 4)))
}

fn axis(axis: &LiveAxis) -> String {
    let unit = unit_on_screen(&axis.unit);
    let blank = if unit == "°" { "" } else { " " };
    format!("{} {:.4}{blank}{unit}", axis.name, axis.value)
}

fn temperatures(live: &Live) -> Vec<String> {
    let value = |degc: Option<f64>| degc.map_or_else(|| "no value".into(), |degc| format!("{degc:.2} °C"));
    live.temperatures.iter().map(|t| format!("{} {}", t.name, value(t.value_degc))).collect()
}

/// The range from end to end, the centre zone between colons, the value as `#`; a value beyond is at the end.
fn range_bar(probe: &LiveProbe) -> String {
    let mut cells = ['.'; WIDTH];
    (cells[WIDTH / 4], cells[WIDTH / 2], cells[WIDTH - 1 - WIDTH / 4]) = (':', '|', ':');
    if let Some((value_mm, [from_mm, to_mm])) = probe.value_mm.zip(probe.range_mm) {
        let share = (value_mm - from_mm) / (to_mm - from_mm);
        cells[(share * (WIDTH - 1) as f64).round().clamp(0.0, (WIDTH - 1) as f64) as usize] = '#';
    }
    format!("[{}]", cells.iter().collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_shows_centre_zone_and_value() {
        let bar = |value_mm: f64| {
            let probe =
                LiveProbe { value_mm: Some(value_mm), range_mm: Some([0.0, 2.0]), ..LiveProbe::default() };
            range_bar(&probe)
        };
        assert_eq!(bar(1.0), "[........:.......#.......:........]");
        assert_eq!(bar(2.1), "[........:.......|.......:.......#]");
        assert_eq!(bar(0.25), "[....#...:.......|.......:........]");
        assert_eq!(range_bar(&LiveProbe::default()), "[........:.......|.......:........]");
    }
}
