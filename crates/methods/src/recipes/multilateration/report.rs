//! What a reader gets: ranges of the volumetric error, stations, a table of the targets, maps of the fullest layers.

use super::observed::{Group, Observed};
use super::solve::Solved;
use crate::Findings;
use crate::common::left_out_notes;
use crate::findings::{Cell, Chart, Column, FoundTable, FoundValue, MapPlace, Plot, ValueKind};
use crate::recipes::{Convention, Method, MethodOptions};
use nalgebra::Vector3;
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::Run;
use trunnion_effects::Unit;

/// Targets whose coordinates differ by less are in one layer, mm.
const ONE_LAYER_MM: f64 = 0.5;
const NAMES: [&str; 3] = ["X", "Y", "Z"];

pub(super) fn findings(
    method: &Method,
    runs: &[Run],
    options: &MethodOptions,
    observed: &Observed,
    solved: &[Solved],
) -> Findings {
    let mut findings = method.findings(runs, Convention::RightHanded);
    let several = observed.groups.len() > 1;
    for (group, solved) in observed.groups.iter().zip(solved) {
        let suffix = if several { format!(" at {}", group.place()) } else { String::new() };
        findings.values.extend(values(group, solved, &suffix));
        findings.tables.push(table(group, solved));
        findings.charts.extend(charts(group, solved, &suffix, options.magnification));
    }
    findings.notes = notes(observed, several);
    findings
}

fn values(group: &Group, solved: &Solved, suffix: &str) -> Vec<FoundValue> {
    let mut values = Vec::new();
    for (k, name) in NAMES.into_iter().enumerate() {
        let of = |one: &(Vector3<f64>, Vector3<f64>)| (one.0[k], one.1[k]);
        let all = || solved.targets.iter().map(of);
        let (Some(high), Some(low)) =
            (all().max_by(|a, b| a.0.total_cmp(&b.0)), all().min_by(|a, b| a.0.total_cmp(&b.0)))
        else {
            continue;
        };
        let name = format!("range of Δ{name}{suffix}");
        let range = FoundValue::new(name, high.0 - low.0, Unit::UM, Some(high.1.hypot(low.1)));
        values.push(range.kind(ValueKind::Summary).note("largest less smallest error over the targets"));
    }
    let noise = FoundValue::new(format!("noise of a reading{suffix}"), solved.noise_mm, Unit::UM, None);
    values.push(noise.kind(ValueKind::Summary).note(format!(
        "by the residuals of {} readings, {} more than unknowns",
        group.distances.len(),
        group.freedom()
    )));
    for (station, found) in group.stations.iter().zip(&solved.stations) {
        for (k, name) in NAMES.into_iter().enumerate() {
            let name = format!("station {} {name}", station.name);
            values.push(
                FoundValue::new(name, found.at_mm[k], Unit::MM, Some(found.u_mm[k])).kind(ValueKind::Setting),
            );
        }
        let name = format!("station {} dead path", station.name);
        let dead_path = FoundValue::new(name, found.dead_path_mm, Unit::MM, Some(found.dead_path_u_mm));
        values.push(dead_path.kind(ValueKind::Setting));
    }
    values
}

fn table(group: &Group, solved: &Solved) -> FoundTable {
    let mut columns: Vec<Column> = NAMES.map(|name| Column::of(name, Unit::MM)).into();
    for name in NAMES {
        columns
            .extend([Column::of(format!("Δ{name}"), Unit::UM), Column::of(format!("u(Δ{name})"), Unit::UM)]);
    }
    let row = |k: usize| {
        let (off_mm, u_mm) = solved.targets[k];
        let commanded = group.targets[k].nominal_mm.iter().copied();
        let found = (0..3).flat_map(|k| [off_mm[k], u_mm[k]]);
        commanded.chain(found).map(Cell::Number).collect()
    };
    FoundTable {
        caption: format!("Volumetric error at each target, reflector at {}, table axes", group.place()),
        columns,
        rows: (0..solved.targets.len()).map(row).collect(),
    }
}

/// Of each plane, the layer with most targets.
fn charts(group: &Group, solved: &Solved, suffix: &str, magnification: Option<f64>) -> Vec<Chart> {
    let of_plane = |out: usize| {
        let [right, up] = [(out + 1) % 3, (out + 2) % 3];
        let nominal_mm = |k: usize| group.targets[k].nominal_mm;
        let in_layer = |middle_mm: f64| {
            (0..group.targets.len()).filter(move |&k| (nominal_mm(k)[out] - middle_mm).abs() < ONE_LAYER_MM)
        };
        let middle_mm = (0..group.targets.len())
            .map(|k| nominal_mm(k)[out])
            .max_by_key(|&middle_mm| in_layer(middle_mm).count())?;
        let place = |k: usize| MapPlace {
            commanded_mm: [nominal_mm(k)[right], nominal_mm(k)[up]],
            measured_off_mm: [solved.targets[k].0[right], solved.targets[k].0[up]],
            simulated_off_mm: None,
        };
        let largest_um =
            in_layer(middle_mm).map(|k| um_from_mm(solved.targets[k].0.norm())).fold(0.0, f64::max);
        Some(Chart {
            group: format!("Volumetric error{suffix}"),
            title: format!(
                "{}{} at {} {middle_mm:.0} mm, largest {largest_um:.1} µm",
                NAMES[right], NAMES[up], NAMES[out]
            ),
            plot: Plot::plane_map(
                [right, up].map(|k| NAMES[k].to_string()),
                in_layer(middle_mm).map(place).collect(),
                magnification,
            ),
        })
    };
    [2, 0, 1].into_iter().filter_map(of_plane).collect()
}

fn notes(observed: &Observed, several: bool) -> Vec<String> {
    let mut notes = vec![
        "Δ is the place of the reflector against the table, actual minus commanded, in table axes. Place and turn of these axes are those that fit the \
         targets best: a shift or a turn of the whole volume is not observable."
            .to_string(),
        "u is by the residuals: what changes from one station to the next (drift, warming up) shows in them in part only.".into(),
    ];
    if several {
        notes.push(
            "Each place of the reflector is solved by itself, with place and turn of its own. The joint fit takes all of them together and gives \
             the errors of each axis."
                .into(),
        );
    }
    notes.extend(left_out_notes(&observed.left_out));
    notes.extend(observed.seen_by_few.iter().map(|targets| format!("Left out: {targets}.")));
    notes
}
