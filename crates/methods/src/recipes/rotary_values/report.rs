//! Which signals are judged, and what is reported of them.

use super::contour::{Contour, Signal, Turn};
use crate::common::harmonics::{self, Harmonics};
use crate::common::left_out_notes;
use crate::common::stations::Stations;
use crate::common::turning::{Turned, Turning, TurningSet};
use crate::findings::{
    AxisName, Cell, Chart, Column, Curve, Findings, FoundTable, FoundValue, Plot, ValueKind,
};
use crate::recipes::{Convention, Method, MethodError};
use trunnion_core::number::{MISSING, fixed};
use trunnion_cycles::Run;
use trunnion_effects::Unit;

/// Heights nearer than this give no tilt, mm.
const APART_MM: f64 = 5.0;
/// Share of the stations that a turn must have to count.
const WHOLE: f64 = 0.9;

/// What ISO 230-7 gives a value of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Motion {
    Radial,
    /// Its once-a-turn part is error motion.
    Axial,
    /// Total and asynchronous values are upper bounds.
    Tilt,
}

/// One signal, both directions.
struct Judged {
    motion: Motion,
    /// First part of the names of its values, e.g. `low.radial-x`.
    name: String,
    /// Title of its charts.
    title: String,
    unit: Unit,
    ways: [Option<Contour>; 2],
}

pub(super) fn findings(
    method: &Method,
    turning: &Turning,
    runs: &[Run],
    convention: Convention,
) -> Result<Findings, MethodError> {
    let turn = turning.whole_turn();
    let of_set = |set: &TurningSet| -> Vec<f64> { set.readings.iter().map(|r| r.angle_rad).collect() };
    let stations = match turning.on_the_fly {
        true => Stations::of_sweeps(&of_set(&turning.sets[0]), turn),
        false => Stations::of_grid(turning.sets.iter().flat_map(of_set), turn),
    };
    let judged = judged(turning, &stations);
    if judged.is_empty() {
        let found = format!("no turn of {} is read at {:.0} % of its angles", turning.axis, 100.0 * WHOLE);
        return Err(method.lacks(found, "Run config/cycles/rotary-values-c.toml."));
    }
    Ok(Findings {
        values: judged.iter().flat_map(|signal| values(signal, is_largest(signal, &judged))).collect(),
        tables: std::iter::once(table(&judged)).chain(harmonics::table(&harmonics(&judged))).collect(),
        charts: judged.iter().flat_map(|signal| charts(turning, signal)).collect(),
        notes: notes(turning, &judged, &stations),
        ..method.findings(runs, convention)
    })
}

/// Every signal of every height, and the tilts of the lowest against the highest.
fn judged(turning: &Turning, stations: &Stations) -> Vec<Judged> {
    let mut judged = Vec::new();
    let [u, v, w] = turning.frame;
    for set in &turning.sets {
        let mut judge = |name: String, title: String, motion: Motion, of: &dyn Fn(&Turned) -> f64| {
            let ways = ways(set, stations, of);
            let ways = ways.map(|signal| Some(Contour::of(&stations.angles_rad, &signal?)));
            if ways.iter().any(Option::is_some) {
                let (name, title) = (format!("{}.{name}", set.name), format!("{title}, setup {}", set.name));
                judged.push(Judged { motion, name, title, unit: Unit::UM, ways });
            }
        };
        for (k, letter) in [u, v].into_iter().enumerate() {
            let title = format!("Radial along {letter}");
            judge(format!("radial-{}", letter.lower()), title, Motion::Radial, &|r| r.moved_mm[k]);
        }
        judge("radial-rotating".into(), "Radial, rotating direction".into(), Motion::Radial, &|r| {
            let (sin, cos) = r.turned_rad.sin_cos();
            r.moved_mm.x * cos + r.moved_mm.y * sin
        });
        judge("axial".into(), format!("Axial along {w}"), Motion::Axial, &|r| r.moved_mm.z);
    }
    judged.extend(tilts(turning, stations));
    judged
}

/// Tilts about u and v: every turn of the highest against every turn of the lowest in the same direction.
fn tilts(turning: &Turning, stations: &Stations) -> Vec<Judged> {
    let by_height = |a: &&TurningSet, b: &&TurningSet| a.height_mm.total_cmp(&b.height_mm);
    let Some((low, high)) = turning.sets.iter().min_by(by_height).zip(turning.sets.iter().max_by(by_height))
    else {
        return Vec::new();
    };
    let apart_mm = high.height_mm - low.height_mm;
    if apart_mm < APART_MM {
        return Vec::new();
    }
    let [tilt_u, tilt_v, _] = turning.rotations();
    // ω_u = −(v high − v low)/Δh, ω_v = (u high − u low)/Δh
    let of = |k: usize, sign: f64| {
        let [low, high] = [low, high].map(|set| ways(set, stations, &|r| sign * r.moved_mm[k] / apart_mm));
        let tilt = |way: usize| {
            let (high, low) = high[way].as_ref().zip(low[way].as_ref())?;
            Some(Contour::of(&stations.angles_rad, &high.less(low)))
        };
        [0, 1].map(tilt)
    };
    let judge = |(letter, ways): (trunnion_core::Joint, [Option<Contour>; 2])| {
        ways.iter().any(Option::is_some).then(|| Judged {
            motion: Motion::Tilt,
            name: format!("tilt-{}", letter.lower()),
            title: format!("Tilt {}", turning.symbol(letter, false)),
            unit: Unit::URAD,
            ways,
        })
    };
    [(tilt_u, of(1, -1.0)), (tilt_v, of(0, 1.0))].into_iter().filter_map(judge).collect()
}

/// The turns forward and the turns back, about their centres; a turn with holes is left out.
fn ways(set: &TurningSet, stations: &Stations, of: &dyn Fn(&Turned) -> f64) -> [Option<Signal>; 2] {
    let mut ways: [Vec<Turn>; 2] = Default::default();
    for pass in 0..set.passes {
        let readings = || set.readings.iter().filter(|r| r.pass == pass);
        let turn: Turn = readings().map(|r| (r.angle_rad, of(r))).collect();
        let filled = stations.means(turn.iter().copied()).iter().flatten().count() as f64;
        if filled >= WHOLE * stations.angles_rad.len() as f64 {
            let back = readings().next().is_some_and(|r| r.direction < 0.0);
            ways[usize::from(back)].push(turn);
        }
    }
    ways.map(|turns| Signal::of(stations, &turns))
}

/// The largest total of its motion over heights and directions is what the measurement comes to.
fn is_largest(signal: &Judged, judged: &[Judged]) -> bool {
    let of_motion = judged.iter().filter(|one| one.motion == signal.motion);
    let largest = of_motion.max_by(|a, b| a.total().total_cmp(&b.total()));
    largest.is_some_and(|largest| largest.name == signal.name)
}

impl Judged {
    /// The larger total of both directions.
    fn total(&self) -> f64 {
        self.ways.iter().flatten().map(|contour| contour.total).fold(0.0, f64::max)
    }
}

/// The larger of both directions, and how far they are apart.
fn values(signal: &Judged, is_largest: bool) -> Vec<FoundValue> {
    let number = |value: Option<f64>| {
        let (scale, unit) = (signal.unit.per_inside, signal.unit.text());
        value.map_or(MISSING.into(), |v| format!("{} {unit}", fixed(v * scale, 2)))
    };
    let mut values = Vec::new();
    let mut value = |what: &str, bound: bool, of: &dyn Fn(&Contour) -> Option<f64>| {
        let ways = [0, 1].map(|way| signal.ways[way].as_ref().and_then(of));
        let Some(largest) = ways.into_iter().flatten().max_by(f64::total_cmp) else { return };
        let mut note = format!("forward {}, back {}", number(ways[0]), number(ways[1]));
        if bound {
            note += "; upper bound, the heights were not read at once";
        }
        values
            .push(FoundValue::new(format!("{}.{what}", signal.name), largest, signal.unit, None).note(note));
    };
    let bound = signal.motion == Motion::Tilt;
    value("total", bound, &|c| Some(c.total));
    value("synchronous", false, &|c| c.synchronous);
    value("asynchronous", bound, &|c| c.asynchronous);
    if signal.motion == Motion::Axial {
        value("fundamental", false, &|c| Some(c.fundamental));
    }
    if let [Some(forward), Some(back)] = &signal.ways {
        let name = format!("{}.reversal", signal.name);
        let note = "largest distance of the mean contours of both directions";
        values.push(FoundValue::new(name, forward.apart(back), signal.unit, None).note(note));
    }
    if is_largest && let Some(total) = values.first_mut() {
        total.kind = ValueKind::Summary;
        total.note = format!("{}, total error motion ({})", signal.title, total.note);
    }
    values
}

fn table(judged: &[Judged]) -> FoundTable {
    let names =
        ["error motion", "unit", "direction", "turns", "total", "synchronous", "asynchronous", "once a turn"];
    let mut rows = Vec::new();
    for signal in judged {
        for (contour, way) in signal.ways.iter().zip(["forward", "back"]) {
            let Some(contour) = contour else { continue };
            let number = |value: f64| Cell::Number(value * signal.unit.per_inside);
            rows.push(vec![
                Cell::Text(signal.title.clone()),
                Cell::Text(signal.unit.text()),
                Cell::Text(way.into()),
                Cell::Text(contour.turns.to_string()),
                number(contour.total),
                contour.synchronous.map_or(Cell::Missing, number),
                contour.asynchronous.map_or(Cell::Missing, number),
                number(contour.fundamental),
            ]);
        }
    }
    FoundTable {
        caption: "Error motion values about the least-squares centre, each direction by itself".into(),
        columns: names.map(Column::plain).to_vec(),
        rows,
    }
}

/// Of the mean contour of each signal in each direction.
fn harmonics(judged: &[Judged]) -> Vec<(String, Unit, Harmonics)> {
    let ways: Vec<(&Judged, &Contour, &str)> = judged
        .iter()
        .flat_map(|signal| signal.ways.iter().zip(["forward", "back"]).map(move |way| (signal, way)))
        .filter_map(|(signal, (contour, way))| Some((signal, contour.as_ref()?, way)))
        .collect();
    let of_way = |(signal, contour, way): &(&Judged, &Contour, &str)| {
        // They stand in one table, so 5 % is the chance that noise makes any of them significant.
        let found = Harmonics::among(&contour.mean, ways.len())?;
        Some((format!("{}, {way}", signal.title), signal.unit, found))
    };
    ways.iter().filter_map(of_way).collect()
}

fn charts(turning: &Turning, signal: &Judged) -> Vec<Chart> {
    let mut charts = Vec::new();
    for (contour, way) in signal.ways.iter().zip(["forward", "back"]) {
        let Some(contour) = contour else { continue };
        let mut curves = vec![Curve::new("mean", contour.mean.clone())];
        if contour.turns > 1 {
            curves.push(Curve::new("highest", contour.highest.clone()));
            curves.push(Curve::new("lowest", contour.lowest.clone()));
        }
        charts.push(Chart {
            group: signal.title.clone(),
            title: format!("{}, {} {way}, {} turns", signal.title, turning.axis, contour.turns),
            plot: Plot::Polar { unit: signal.unit, curves },
        });
    }
    let means = signal.ways.iter().zip(["forward", "back"]);
    let means: Vec<Curve> =
        means.filter_map(|(contour, way)| Some(Curve::new(way, contour.as_ref()?.mean.clone()))).collect();
    if means.len() == 2 {
        charts.push(Chart {
            group: signal.title.clone(),
            title: format!("{}, mean contours of both directions", signal.title),
            plot: Plot::Xy {
                x: AxisName { name: turning.axis.to_string(), unit: Unit::DEG },
                y: AxisName { name: String::new(), unit: signal.unit },
                curves: means,
            },
        });
    }
    charts
}

fn notes(turning: &Turning, judged: &[Judged], stations: &Stations) -> Vec<String> {
    let axis = turning.axis;
    let contours =
        || judged.iter().filter(|s| s.motion != Motion::Tilt).flat_map(|s| s.ways.iter().flatten());
    let turns = contours().map(|c| c.turns).min().unwrap_or(0);
    let mut notes = vec![format!(
        "{} stations around {axis}; values are peak to valley, about the least-squares centre, without the noise of the readings taken off.",
        stations.angles_rad.len()
    )];
    if turns < 2 {
        notes.push(
            "A direction has a single turn: synchronous and asynchronous motion are not distinguishable there; only the total is given. \
             Turn twice or more in each direction."
                .into(),
        );
    }
    if !turning.whole_turn() {
        notes.push(format!(
            "{axis} does not go around: the values hold over the arc it turned, and the centre takes more of a slow motion with it than over a whole turn."
        ));
    }
    if judged.iter().all(|signal| signal.motion != Motion::Tilt) {
        notes.push(
            "All balls sit at one height: tilt error motion is not observable. Measure a second height."
                .into(),
        );
    }
    notes.extend(left_out_notes(&turning.left_out));
    notes
}
