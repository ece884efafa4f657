//! An effect on trial: the residual before and after in pairs of maps on one colour scale.

use super::maps::{self, Grid, Map};
use super::places as place_list;
use crate::markup::{element, escape, table};
use crate::number::{justified, um_or_dash, unit_on_screen, value_and_u};
use crate::svg::{Bar, Mark, Series, XyChart, bars, end_above, legend, xy_chart};
use crate::views::{Axes, component_name, component_names, residuals_um, thinned};
use crate::words::{NO_PLACE, about, bars_legend, effect_name, trial_verdict, units};
use std::collections::HashSet;
use trunnion_core::convert::s_from_min;
use trunnion_results::sentences::noise_origin;
use trunnion_results::{Moved, Parameter, ResidualPoint, Trial};

/// Pairs shown on the compare page.
const MOST_PAIRS: usize = 2;

/// The top of a trial page.
pub fn headline(trial: &Trial, label: &str) -> String {
    let fit = &trial.identification;
    let explained = about(&trial.effect)
        .map_or(String::new(), |about| format!(" {} Likely cause: {}", about.explanation, about.cause));
    let formula = match trial.expression.as_str() {
        "" => String::new(),
        text => format!("<p class=\"formula\"><code>{}</code></p>\n", escape(text)),
    };
    let model = format!(
        "Machine {}; run {}; model: {}; the model file stays as it is. {}",
        fit.machine,
        fit.runs.join(", "),
        trial.model.join(" + "),
        label
    );
    let steps = [
        ("before".into(), trial.rms_um.before, trial.holdout_rms_um.before),
        (format!("with {}", trial.effect), trial.rms_um.after, trial.holdout_rms_um.after),
    ]
    .map(|(name, fit_um, holdout_um)| Bar {
        name,
        fit_um: fit_um.unwrap_or(f64::NAN),
        holdout_um,
        noise_um: None,
        remark: String::new(),
    });
    let chart = bars(
        "Error before and after",
        &bars_legend(&units(trial.identification.holdout_unit), trial.noise_um),
        &steps,
        trial.noise_um,
    );
    format!(
        "<header><p class=\"soft\">Trunnion: an effect on trial</p>\n<h1>{}</h1>\n{formula}<p class=\"lead\">{}</p>\n\
         <p class=\"soft\">{}</p></header>\n<section>{chart}</section>\n",
        escape(&format!("What {} would do", effect_name(&trial.effect))),
        escape(&(trial_verdict(trial) + &explained)),
        escape(&model),
    )
}

/// Where the model fails most, before and after.
pub fn places(trial: &Trial) -> String {
    let [before, after] =
        [&trial.places.before, &trial.places.after].map(|places| place_list::list(places, NO_PLACE));
    format!(
        "<section><h2>Where the model fails most</h2>\n<div class=\"plots\"><div><h3>before</h3>{before}</div>\
         <div><h3>after</h3>{after}</div></div></section>\n"
    )
}

/// Every pair of maps.
pub fn all_maps(trial: &Trial) -> String {
    let body = match pairs(trial) {
        Some((grid, pairs, limit_um)) => {
            let drawn = pairs.iter().map(|pair| drawn(&grid, pair, limit_um));
            key(limit_um) + &drawn.collect::<String>()
        }
        None => charts(trial),
    };
    format!("<section class=\"page\"><h2>Residual before and after</h2>\n{body}</section>\n")
}

/// The pairs in which most falls away, for the compare page.
pub fn clearest_maps(trial: &Trial) -> String {
    let (first, rest) = match pairs(trial) {
        Some((grid, mut pairs, limit_um)) => {
            let falls = |pair: &[Map; 2]| pair[0].mean_square() - pair[1].mean_square();
            pairs.sort_by(|a, b| falls(b).total_cmp(&falls(a)));
            // One pair a component: the same picture for the other direction says nothing new.
            let mut components = HashSet::new();
            pairs.retain(|[before, _]| components.insert(before.component.clone()));
            let (first, rest) = pairs.split_at(pairs.len().min(1));
            let rest = &rest[..rest.len().min(MOST_PAIRS - 1)];
            let drawn = |pairs: &[[Map; 2]]| -> String {
                pairs.iter().map(|pair| drawn(&grid, pair, limit_um)).collect()
            };
            (key(limit_um) + &drawn(first), drawn(rest))
        }
        None => (charts(trial), String::new()),
    };
    // On paper heading and scale stay with the first maps.
    format!(
        "<div class=\"together\"><h3>Residual before and after {}</h3>\n{first}</div>\n{rest}",
        escape(&trial.effect)
    )
}

/// How big the effect is.
pub fn size_table(trial: &Trial) -> String {
    let row = |p: &Parameter| {
        let (value, u) = value_and_u(p.value, p.u, &p.unit);
        vec![p.name.clone(), value, u, p.note.clone()]
    };
    let rows: Vec<_> = trial.parameters.iter().map(row).collect();
    let caption = format!("How big {} is alone, with its standard uncertainty", trial.effect);
    table(&caption, &["parameter", "value", "uncertainty", "remark"], &[1, 2], &rows)
}

/// Parameters of the effect and those it moves.
pub fn tables(trial: &Trial) -> String {
    let moved = clearly(trial.moved.as_deref().unwrap_or_default());
    let moved = if moved.is_empty() {
        element("p", "No other parameter moves by more than 2 u.")
    } else {
        moved_table("Other parameters that it moves by more than 2 u", &moved)
    };
    format!(
        "<section><h2>How big it is</h2>\n{}{moved}<p class=\"soft\">Repeatability {} ({}).</p></section>\n",
        size_table(trial),
        um_or_dash(trial.noise_um),
        escape(&noise_origin(&trial.identification))
    )
}

/// Those that moved by more than 2 u.
pub fn clearly(moved: &[Moved]) -> Vec<Moved> {
    moved.iter().filter(|m| m.in_u() > 2.0).cloned().collect()
}

/// Parameters that moved, most moved first.
pub fn moved_table(caption: &str, moved: &[Moved]) -> String {
    let row = |m: &Moved| {
        let unit = unit_on_screen(&m.unit);
        vec![
            m.name.clone(),
            format!("{} {unit}", justified(m.before, m.u)),
            format!("{} {unit}", justified(m.after, m.u)),
            format!("{:.1} u", m.in_u()),
        ]
    };
    let rows: Vec<_> = moved.iter().map(row).collect();
    table(caption, &["parameter", "before", "after", "moved by"], &[1, 2, 3], &rows)
}

/// The same maps before and after, and a limit above all of them; `None` unless two rotary axes moved.
fn pairs(trial: &Trial) -> Option<(Grid<'_>, Vec<[Map; 2]>, f64)> {
    let grid = Grid::of(&trial.residuals.before)?;
    let [before, after] =
        [&trial.residuals.before, &trial.residuals.after].map(|residuals| maps::maps(residuals, &grid));
    let limit_um = maps::limit_um(&before).max(maps::limit_um(&after));
    let pairs = before.into_iter().zip(after).map(|(before, after)| [before, after]).collect();
    Some((grid, pairs, limit_um))
}

fn key(limit_um: f64) -> String {
    format!("<div class=\"key\">{}</div>\n", legend(limit_um))
}

fn drawn(grid: &Grid<'_>, [before, after]: &[Map; 2], limit_um: f64) -> String {
    format!(
        "<div class=\"pair\">{}{}</div>\n",
        before.figure(grid, limit_um, &format!("{} — before", before.title)),
        after.figure(grid, limit_um, &format!("{} — after", after.title))
    )
}

/// Without a grid: one chart a component over the turning axis, or over time, before and after.
fn charts(trial: &Trial) -> String {
    let states = [&trial.residuals.before, &trial.residuals.after];
    let turning = Axes::of(states[0]).turning;
    let x = |p: &ResidualPoint| match turning {
        Some(axis) => p.position[axis.index],
        None => p.time_s.map_or(f64::NAN, |t| t / s_from_min(1.0)),
    };
    let x_name = turning.map_or("time (min)".into(), |axis| format!("{} (°)", axis.name));
    let series = |k: usize, component: &str, name: &str, mark: Mark| {
        let residuals = states[k];
        let of_point = |p| residuals_um(residuals, p).map(move |(j, r)| (p, j, r));
        let mut places: Vec<(f64, f64)> = residuals
            .points
            .iter()
            .flat_map(of_point)
            .filter(|(p, j, _)| component_name(residuals, p, *j) == component)
            .map(|(p, _, r)| (x(p), r))
            .filter(|(x, _)| x.is_finite())
            .collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        Series { name: name.into(), mark, points: thinned(&places) }
    };
    let of_component =
        |name: &str| [series(0, name, "before", Mark::Triangle), series(1, name, "after", Mark::Dot)];
    let components: Vec<_> =
        component_names(states[0]).into_iter().map(|name| (name, of_component(name))).collect();
    let all = components.iter().flat_map(|(_, series)| series).flat_map(|s| &s.points);
    let y_limit = end_above(all.fold(0.0, |limit: f64, p| limit.max(p.1.abs())));
    let chart = |(component, series): &(&str, [Series; 2])| {
        let title = format!("Component {component}, before and after");
        xy_chart(&XyChart {
            title: &title,
            x_name: &x_name,
            y_name: "µm",
            series,
            y: (-y_limit, y_limit),
            marks_on_x: &[],
        })
    };
    format!("<div class=\"plots\">{}</div>\n", components.iter().map(chart).collect::<String>())
}
