//! Can the air be so warm, and does every temperature come from its sensor?

use super::found::{Implausible, plain};
use super::readings::FEWEST_POINTS;
use super::sensors;
use trunnion_cycles::Run;

/// Air in which nobody works, °C.
const TOO_HOT_DEGC: f64 = 55.0;
/// Air that is plausible where a unit is proposed, °C: shops without heating in winter, and without cooling in summer. A judgement. Tenths of
/// 19 °C are no °F then (88 °C), and kelvins of it neither (144 °C).
const OF_SHOPS_DEGC: std::ops::RangeInclusive<f64> = 10.0..=45.0;
/// What channels of the air are called.
const AIR: [&str; 3] = ["ambient", "air", "room"];
/// A temperature that falls to zero from so far away between two readings was not read, K. Nothing in a shop cools so fast.
const NOT_READ_K: f64 = 5.0;

/// A unit in which the temperatures may have been written.
struct Written {
    unit: &'static str,
    degc: fn(f64) -> f64,
    /// What becomes of everything that follows a temperature.
    effect: &'static str,
}

const WRITTEN: [Written; 3] = [
    Written {
        unit: "°F",
        degc: |number| (number - 32.0) / 1.8,
        effect: "what follows a temperature would be 1.8 times too small",
    },
    Written {
        unit: "tenths of °C",
        degc: |number| number / 10.0,
        effect: "what follows a temperature would be 10 times too small",
    },
    Written {
        unit: "K",
        degc: |number| number - 273.15,
        effect: "its changes stay right, its zero would be 273 K off",
    },
];

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    let enough = runs.iter().filter(|run| run.good_points().count() >= FEWEST_POINTS);
    let of_sensor = |run: &Run| not_read(run).or_else(|| sensors::implausible(run));
    enough.flat_map(|run| too_hot(run).into_iter().chain(of_sensor(run))).collect()
}

/// Air as hot as its number in another unit.
fn too_hot(run: &Run) -> Option<Implausible> {
    let is_air =
        |name: &str| name.to_lowercase().split(|c: char| !c.is_alphabetic()).any(|word| AIR.contains(&word));
    let channels = run.channels.iter().enumerate().filter(|(_, name)| is_air(name));
    channels.filter_map(|(channel, name)| too_hot_channel(run, channel, name)).next()
}

fn too_hot_channel(run: &Run, channel: usize, name: &str) -> Option<Implausible> {
    let read = || read(run, channel).map(|(_, degc)| degc).filter(|degc| degc.is_finite());
    let coolest = read().fold(f64::INFINITY, f64::min);
    let hottest = read().fold(f64::NEG_INFINITY, f64::max);
    if !(coolest > TOO_HOT_DEGC && coolest.is_finite()) {
        return None;
    }
    let is_plausible = |written: &&Written| {
        [coolest, hottest].iter().all(|&number| OF_SHOPS_DEGC.contains(&(written.degc)(number)))
    };
    let of_units: Vec<&Written> = WRITTEN.iter().filter(is_plausible).collect();
    let finding = format!(
        "{}: the temperature {name} is never below {coolest:.1} °C, which is too hot for air.",
        run.name
    );
    let hypothesis = if of_units.is_empty() {
        "No unit of those tried (°F, tenths of °C, K) makes it plausible. Check the sensor and its channel."
            .into()
    } else {
        let values =
            of_units.iter().map(|written| format!("in {} {:.1} °C", written.unit, (written.degc)(coolest)));
        let effects = of_units.iter().map(|written| match of_units.len() {
            1 => written.effect.to_owned(),
            _ => format!("{} ({})", written.effect, written.unit),
        });
        format!(
            "It would be {}, which is plausible. Check its unit: {}.",
            values.collect::<Vec<_>>().join(", or "),
            effects.collect::<Vec<_>>().join(", or ")
        )
    };
    Some(plain(finding, &hypothesis))
}

/// A temperature of exactly zero in some rows, and far from it in all others.
fn not_read(run: &Run) -> Option<Implausible> {
    run.channels.iter().enumerate().find_map(|(channel, name)| {
        let (zero, others): (Vec<_>, Vec<_>) =
            read(run, channel).filter(|(_, degc)| degc.is_finite()).partition(|(_, degc)| *degc == 0.0);
        let nearest_k = others.iter().map(|(_, degc)| degc.abs()).fold(f64::INFINITY, f64::min);
        let ((first, _), (last, _)) = zero.first().zip(zero.last())?;
        (nearest_k > NOT_READ_K && !others.is_empty()).then(|| {
            let count = zero.len();
            plain(
                format!(
                    "{}: the temperature {name} is exactly 0 °C in {count} of {} points (rows {first} to {last}), and {nearest_k:.1} K or \
                     more from it in all others.",
                    run.name,
                    count + others.len()
                ),
                "Its sensor was not read there. Measure again with the sensor connected, or leave its column out.",
            )
        })
    })
}

/// Rows, counted from 1, with what a channel read there.
fn read(run: &Run, channel: usize) -> impl Iterator<Item = (usize, f64)> {
    let good = (1..).zip(&run.points).filter(|(_, point)| point.is_good());
    good.filter_map(move |(row, point)| Some((row, *point.state.temperature_degc.get(channel)?)))
}
