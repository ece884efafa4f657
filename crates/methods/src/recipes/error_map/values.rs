//! What the error map reports.

use super::b_errors::BErrors;
use super::c_errors::CErrors;
use super::charts::charts;
use super::components::{Component, components, is_about_itself};
use super::found::Found;
use super::grid::Grid;
use super::location::Locations;
use super::tilting::{self, Motion};
use crate::common::harmonics::{self, Harmonics};
use crate::common::left_out_notes;
use crate::findings::{Cell, Column, Findings, FoundTable, FoundValue};
use crate::recipes::{Method, MethodOptions};
use nalgebra::Vector3;
use trunnion_core::Twist;
use trunnion_core::convert::{deg_from_rad, um_from_mm};
use trunnion_core::number::{fixed, trimmed, um};
use trunnion_cycles::Run;
use trunnion_effects::Unit;
use trunnion_engine::Identification;

pub(super) fn findings(
    method: &Method,
    runs: &[Run],
    found: &Found<'_>,
    options: &MethodOptions,
) -> Findings {
    let convention = options.convention;
    let Found { grid, b_errors, c_errors, locations, joint, calibration } = found;
    let mut values: Vec<FoundValue> = locations
        .rows
        .iter()
        .map(|row| {
            let joint = fixed(row.by_joint_fit * row.unit.per_inside, 2);
            let note = format!("joint fit {joint} {}", row.unit.text());
            FoundValue::new(row.name.clone(), row.by_map, row.unit, Some(row.u_by_map)).note(note)
        })
        .collect();
    let tilting = tilting::motions(grid, b_errors, locations);
    let around = |contours: usize| {
        let one = |motion: &Motion| Some((motion.name.clone(), motion.unit, motion.harmonics(contours)?));
        tilting.iter().filter_map(one).collect::<Vec<_>>()
    };
    // They stand in one table, so 5 % is the chance that noise makes any of them significant.
    let contours = of_turning(grid).len() + around(1).len();
    values.extend(tilting.iter().map(|motion| motion.value(contours, convention)));
    values.extend(left(grid, b_errors, c_errors, joint));
    let mut tables = vec![compared(locations), map_of_tilting(grid, b_errors)];
    tables.push(map_of_turning(grid, c_errors));
    let turning = harmonics_of_turning(grid, c_errors, contours);
    values.extend(turning.iter().map(|(name, unit, of)| {
        let value = of.range_value(name, *unit);
        let off = or_between_nests(grid, name, of);
        let note = format!("mean over {}, without the bias of noise; {}{off}", grid.tilting, value.note);
        value.note(note)
    }));
    values.extend(at_the_tilts(grid, c_errors));
    tables.extend(harmonics::table(&[around(contours), turning].concat()));
    tables.extend(calibration.table.clone());
    let mut notes = notes(grid, b_errors);
    notes.push(calibration.note.clone());
    Findings {
        values,
        tables,
        charts: charts(grid, b_errors, c_errors, options.magnification),
        notes,
        ..method.findings(runs, convention)
    }
}

/// Of each component of the turning axis the tilt that allows the largest range of its waves, and the upper bound there. A range with an
/// uncertainty is given of the mean over the tilts alone: the largest of several is so by its noise too.
fn at_the_tilts(grid: &Grid<'_>, c_errors: &CErrors) -> Vec<FoundValue> {
    let shown = of_turning(grid);
    let contours = grid.tilts_rad.len() * shown.len();
    let largest = |(name, unit, of): &Component| {
        let at = |tilt: usize| {
            let read = grid.turns_rad.iter().zip(&c_errors.at[tilt]);
            let points: Vec<_> =
                read.filter_map(|(turn, twist)| Some((*turn, of(twist.as_ref()?)))).collect();
            Some((tilt, Harmonics::among(&points, contours)?))
        };
        let (tilts, all): (Vec<usize>, Vec<Harmonics>) = (0..grid.tilts_rad.len()).filter_map(at).unzip();
        let (which, most) = Harmonics::largest_at_most(&all)?;
        let angle = trimmed(deg_from_rad(grid.tilts_rad[tilts[which]]), 2);
        let note = format!(
            "at {} = {angle}°, upper bound (95 %) of all {} tilts together; {}",
            grid.tilting,
            tilts.len(),
            all[which].words(*unit)
        );
        Some(FoundValue::new(format!("{name} largest range at most"), most, *unit, None).note(note))
    };
    shown.iter().filter_map(largest).collect()
}

/// Components of the turning axis that the map shows.
fn of_turning(grid: &Grid<'_>) -> Vec<Component> {
    components(grid.turning).into_iter().filter(|(name, ..)| !is_about_itself(name)).collect()
}

/// What else makes a significant wave of the shift along the turning axis once a turn: one nest position that is off the other by d across the axis, the
/// same at all angles in the axes of what carries it, as passes and drift leave it. The line between the nest positions then leans by d/Δz, and
/// the lean moves a nest at the radius ρ by d ρ/Δz along the axis (S1 eq. 16–22). The scatter from angle to angle, in u, knows nothing of d.
fn or_between_nests(grid: &Grid<'_>, name: &str, of: &Harmonics) -> String {
    let along = grid.turning.index() % 3;
    let is_shift_along = components(grid.turning)[along].0 == name;
    let Some(once) = of.order(1).filter(|once| is_shift_along && once.significant) else {
        return String::new();
    };
    let cells = grid.cells.iter().flatten().flatten().flatten();
    let arms: Vec<Vector3<f64>> = cells
        .map(|cell| {
            let arm_mm = cell.nest_in_machine_mm - cell.turning.origin_in_machine_mm;
            cell.turning.machine_from_carrier.inverse() * arm_mm
        })
        .collect();
    let heights = || arms.iter().map(|arm| arm[along]);
    let apart_mm = heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
    let radii = arms.iter().map(|arm| (arm.norm_squared() - arm[along].powi(2)).max(0.0).sqrt());
    let radius_mm = radii.sum::<f64>() / arms.len().max(1) as f64;
    let off_um = um_from_mm(once.amplitude * apart_mm / radius_mm.max(f64::MIN_POSITIVE));
    format!(
        "; once a turn, or one nest position off the other by {} across {}, as passes and drift leave it, which u does not hold: `diagnose` judges both",
        um(off_um),
        grid.turning
    )
}

/// What each step leaves of the readings, rms per component.
fn left(grid: &Grid<'_>, b_errors: &BErrors, c_errors: &CErrors, joint: &Identification) -> Vec<FoundValue> {
    let rms = |residuals: &mut dyn Iterator<Item = Vector3<f64>>| {
        let (sum, count) =
            residuals.fold((0.0, 0.0), |(sum, count), r| (sum + r.norm_squared(), count + 3.0));
        (sum / f64::max(count, 1.0)).sqrt()
    };
    let (tilting, turning) = (grid.tilting, grid.turning);
    let of_b = rms(&mut b_errors.residual_mm.iter().flatten().copied());
    let of_c = rms(&mut c_errors.residual_mm.iter().copied());
    let value = |name: &str, rms, note: String| FoundValue::new(name, rms, Unit::UM, None).note(note);
    vec![
        value(
            "left by location errors",
            joint.rms_mm,
            "joint fit: location errors and settings; single readings".into(),
        ),
        value(
            "left by map of tilting axis",
            of_b,
            format!("{} unknowns over {tilting}; repeats averaged", 6 * grid.tilts_rad.len()),
        ),
        value(
            "left by both maps",
            of_c,
            format!(
                "five more at each pose of {turning} to {} readings: little freedom is left",
                3 * grid.nests.len()
            ),
        ),
    ]
}

fn compared(locations: &Locations) -> FoundTable {
    let head = ["by maps", "u by maps", "by joint fit", "u by joint fit", "difference"];
    let mut columns = vec![Column::plain("location error"), Column::plain("unit")];
    columns.extend(head.map(Column::plain));
    let row = |row: &super::location::Location| {
        let scale = row.unit.per_inside;
        let number = |value: f64| Cell::Number(value * scale);
        vec![
            Cell::Text(row.name.clone()),
            Cell::Text(row.unit.text()),
            number(row.by_map),
            number(row.u_by_map),
            number(row.by_joint_fit),
            row.u_by_joint_fit.map_or(Cell::Missing, number),
            number(row.by_map - row.by_joint_fit),
        ]
    };
    let caption = "Location errors by constants of the map and by the joint fit of the same readings".into();
    FoundTable { caption, columns, rows: locations.rows.iter().map(row).collect() }
}

fn map_of_tilting(grid: &Grid<'_>, b_errors: &BErrors) -> FoundTable {
    let components = components(grid.tilting);
    let mut columns = vec![Column::of(grid.tilting.as_str(), Unit::DEG)];
    columns.extend(components.iter().map(|(name, unit, _)| Column::of(name.clone(), *unit)));
    columns.extend(components.iter().map(|(name, unit, _)| Column::of(format!("u {name}"), *unit)));
    let row = |((angle, twist), u): ((&f64, &Twist), &Twist)| {
        let numbers =
            [twist, u].into_iter().flat_map(|of_row| components.iter().map(move |(.., of)| of(of_row)));
        std::iter::once(*angle).chain(numbers).map(Cell::Number).collect()
    };
    let rows = grid.tilts_rad.iter().zip(&b_errors.at_tilt).zip(&b_errors.u_at_tilt).map(row).collect();
    FoundTable { caption: format!("Errors of {} (S1 Fig. 6)", grid.tilting), columns, rows }
}

/// Of the errors of the turning axis, mean over the tilts; judged among so many contours.
fn harmonics_of_turning(
    grid: &Grid<'_>,
    c_errors: &CErrors,
    contours: usize,
) -> Vec<(String, Unit, Harmonics)> {
    let found = of_turning(grid).into_iter().filter_map(|(name, unit, of)| {
        let mean = |turn: usize| {
            let read: Vec<f64> =
                c_errors.at.iter().filter_map(|of_tilt| of_tilt[turn].as_ref().map(&of)).collect();
            (!read.is_empty()).then(|| read.iter().sum::<f64>() / read.len() as f64)
        };
        let points = grid.turns_rad.iter().enumerate().filter_map(|(k, turn)| Some((*turn, mean(k)?)));
        Some((name, unit, Harmonics::among(&points.collect::<Vec<_>>(), contours)?))
    });
    found.collect()
}

fn map_of_turning(grid: &Grid<'_>, c_errors: &CErrors) -> FoundTable {
    let components = components(grid.turning);
    let shown = || components.iter().filter(|(name, ..)| !is_about_itself(name));
    let mut columns = [grid.tilting, grid.turning].map(|axis| Column::of(axis.as_str(), Unit::DEG)).to_vec();
    columns.extend(shown().map(|(name, unit, _)| Column::of(name.clone(), *unit)));
    columns.extend(shown().map(|(name, unit, _)| Column::of(format!("u {name}"), *unit)));
    let mut rows = Vec::new();
    for ((tilt, of_tilt), u_of_tilt) in grid.tilts_rad.iter().zip(&c_errors.at).zip(&c_errors.u_at) {
        for ((turn, twist), u) in grid.turns_rad.iter().zip(of_tilt).zip(u_of_tilt) {
            let mut row = vec![Cell::Number(*tilt), Cell::Number(*turn)];
            for twist in [twist, u] {
                let cell =
                    |of: fn(&Twist) -> f64| twist.as_ref().map_or(Cell::Missing, |t| Cell::Number(of(t)));
                row.extend(shown().map(|(.., of)| cell(*of)));
            }
            rows.push(row);
        }
    }
    FoundTable { caption: format!("Errors of {} at each pose (S1 Fig. 7)", grid.turning), columns, rows }
}

fn notes(grid: &Grid<'_>, b_errors: &BErrors) -> Vec<String> {
    let (b, c) = (grid.tilting, grid.turning);
    let repeats = match grid.repeat_mm {
        Some(mm) => format!(
            "Readings of one pose and nest repeat to {} (standard deviation; directions of approach included).",
            um(um_from_mm(mm))
        ),
        None => "No pose was read twice, so the repeatability is not known.".into(),
    };
    let offsets = grid.nests.iter().zip(&b_errors.offsets_mm).map(|(nest, offset)| {
        let um = offset * Unit::UM.per_inside;
        format!("{nest} ({}, {}, {}) µm", fixed(um.x, 1), fixed(um.y, 1), fixed(um.z, 1))
    });
    let mut notes = vec![
        format!(
            "{} angles of {b}, {} of {c}, nest positions {}. Errors are in the axes of what carries each axis, actual minus nominal.",
            grid.tilts_rad.len(),
            grid.turns_rad.len(),
            grid.nests.join(", ")
        ),
        format!(
            "The errors of {b} hold what is the same at all {c} of a {b} angle: constant errors of {c} too (S1 §5.3 reads them off as averages). \
             E{c}{c} is taken as zero."
        ),
        repeats,
        format!("Offsets of the zero pose: {}.", offsets.collect::<Vec<_>>().join(", ")),
    ];
    notes.extend(left_out_notes(&grid.left_out));
    notes
}
