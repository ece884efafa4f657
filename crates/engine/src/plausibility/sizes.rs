//! Can the readings be so small, so quiet or so restless? Wrong units show there.

use super::found::{Implausible, plain};
use super::positions::FAR_MM;
use super::readings::FEWEST_POINTS;
use super::repeats::{self, TOO_FINE_UM};
use crate::Experiment;
use crate::noise::repeatability::{of_channels_mm, repeatability};
use crate::problem::passes::{Passes, passes};
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::signed;
use trunnion_core::setup::SET_BY_HAND_MM;
use trunnion_core::{Point, statistics};
use trunnion_cycles::{Run, RunKind};

/// Readings that are all smaller: no ball is set so well in its nest, and no probe is worth less than its last digit, µm.
const TOO_SMALL_UM: f64 = 0.5;
/// Repeatability of a reading at rest above which the unit is doubted: a worn machine comes back within some 10 µm, and what is loose is doubted
/// as scatter. 0.1 µm is 100 µm where nanometres are taken for µm.
const TOO_COARSE_UM: f64 = 50.0;

/// Probes of one nest read one ball: one that repeats so many times worse than every other, and worse than [`LOOSE_UM`], is loose.
const LOOSE_TIMES: f64 = 10.0;
const LOOSE_UM: f64 = 2.0;
/// A share of readings that stands for all: single wrong ones are among them.
const MOSTLY: f64 = 0.95;

pub(super) fn implausible(runs: &[Run]) -> Vec<Implausible> {
    let of_readings = |run: &Run| {
        let repeats = || {
            Repeats::of(run).and_then(|repeats| unrepeatable(run, &repeats).or_else(|| loose(run, &repeats)))
        };
        too_small(run).or_else(|| bar_zero(run)).or_else(|| too_large(run)).or_else(repeats)
    };
    let enough = runs.iter().filter(|run| run.good_points().count() >= FEWEST_POINTS);
    enough.filter_map(of_readings).collect()
}

/// True where contact probes read.
fn has_probes(run: &Run) -> bool {
    run.setups.iter().all(|setup| setup.instrument.deflects_probes())
}

/// Readings of calibrated bars that are all off their length by one amount, more than balls set by hand are: the zero of the device is in
/// them. Bars of unlike length may have unlike zeros.
fn bar_zero(run: &Run) -> Option<Implausible> {
    let setup = |point: &Point| &run.setups[point.state.setup];
    let length = |point: &Point| setup(point).bar_length_mm.unwrap_or_default();
    let of_bars: Vec<&Point> =
        run.good_points().filter(|point| setup(point).reads_calibrated_length()).collect();
    let lengths_mm: Vec<f64> = of_bars.iter().map(|point| length(point)).collect();
    lengths_mm.chunk_by(|a, b| a == b).find_map(|of_one| {
        let same_length = of_bars.iter().filter(|point| length(point) == of_one[0]);
        let readings_mm: Vec<f64> = same_length.map(|point| point.reading_mm[0]).collect();
        let zero_mm = statistics::median(&readings_mm)?;
        let off_mm = readings_mm.iter().map(|mm| mm - zero_mm);
        let near: Vec<f64> = off_mm.filter(|mm| mm.abs() < SET_BY_HAND_MM).collect();
        let is_zero = zero_mm.abs() > SET_BY_HAND_MM && near.len() as f64 >= MOSTLY * readings_mm.len() as f64;
        let left_um = um_from_mm(statistics::rms(near)?);
        is_zero.then(|| Implausible {
            finding: format!(
                "{}: the bar reads {} mm from its calibrated length of {} mm in every pose ({} points), farther than balls set \
                 by hand are.",
                run.name,
                signed(zero_mm, 3),
                of_one[0],
                readings_mm.len()
            ),
            hypothesis: format!(
                "With the zero of the bar, {} mm, taken off the readings, {left_um:.1} µm are left. Change it? It is zero_mm of \
                 the device where the bar was read live, else it is in the column dr. Where another bar was in, correct \
                 bar_length_mm; where nobody calibrated it, remove calibrated = true.",
                signed(zero_mm, 3)
            ),
            rms_um_with_it: Some(left_um),
        })
    })
}

/// Readings of a ball bar beyond its range. Where three probes read one ball, positions in the readings are tried as a mistake of their own.
fn too_large(run: &Run) -> Option<Implausible> {
    let of_bars = run.setups.iter().all(|setup| setup.instrument.keeps_bar_length());
    let most_mm =
        run.good_points().flat_map(|point| point.reading_mm).fold(0.0, |most: f64, mm| most.max(mm.abs()));
    (of_bars && most_mm > FAR_MM).then(|| {
        plain(
            format!("{}: the bar grows or shrinks by up to {most_mm:.0} mm, farther than any bar reads.", run.name),
            "In nm instead of µm (factor 1000) it would be plausible, or the readings hold the length of the bar. Check what dr holds.",
        )
    })
}

fn too_small(run: &Run) -> Option<Implausible> {
    let readings = run.good_points().flat_map(|point| point.reading_mm);
    let most_um = um_from_mm(readings.fold(0.0, |most: f64, mm| most.max(mm.abs())));
    (has_probes(run) && most_um < TOO_SMALL_UM).then(|| {
        plain(
            format!(
                "{}: no reading is larger than {most_um:.3} µm, which is too small for a ball set in a nest.",
                run.name
            ),
            "In mm instead of µm (factor 1000) they would be plausible. Check the units of the readings.",
        )
    })
}

/// Probes read at rest, with the passes in which poses come again.
struct Repeats {
    experiment: Experiment,
    passes: Passes,
}

impl Repeats {
    fn of(run: &Run) -> Option<Self> {
        let is_asked = run.kind == RunKind::Static && has_probes(run);
        let experiment = is_asked.then(|| Experiment::of_points(&[run]).ok()).flatten()?;
        let passes = passes(&experiment);
        Some(Self { experiment, passes })
    }
}

/// Readings of a pose that comes again, closer or farther apart than any axis comes back.
fn unrepeatable(run: &Run, repeats: &Repeats) -> Option<Implausible> {
    let sigma_um = um_from_mm(repeatability(&repeats.experiment, &repeats.passes)?.sigma_mm);
    // Equal in every digit they are copies, whatever the unit.
    if sigma_um < TOO_FINE_UM && repeats::copied(run).is_some() {
        return None;
    }
    if sigma_um < TOO_FINE_UM {
        return Some(plain(
            format!(
                "{}: readings of one pose repeat within {sigma_um:.3} µm, which is too small: no axis comes back so well.",
                run.name
            ),
            "In thousandths of an inch or mm instead of µm (factor 25.4 or 1000 too small) they would be plausible. Check the units of the readings, \
             unless the run was simulated without noise.",
        ));
    }
    (sigma_um > TOO_COARSE_UM).then(|| {
        plain(
            format!(
                "{}: readings of one pose repeat within {sigma_um:.0} µm, which is too large: every axis comes back better.",
                run.name
            ),
            "In nm instead of µm (factor 1000 too large) they would be plausible. Check the units of the readings, and that ball, nest and probes are firm.",
        )
    })
}

/// One probe that repeats far worse than the others of its nest.
fn loose(run: &Run, repeats: &Repeats) -> Option<Implausible> {
    let names = run.setups.first()?.instrument.components();
    let all_um: Vec<f64> = of_channels_mm(&repeats.experiment, &repeats.passes)
        .into_iter()
        .collect::<Option<Vec<f64>>>()?
        .into_iter()
        .map(um_from_mm)
        .collect();
    let worst = (0..all_um.len()).max_by(|&a, &b| all_um[a].total_cmp(&all_um[b]))?;
    let others_um =
        all_um.iter().enumerate().filter(|(k, _)| *k != worst).map(|(_, um)| *um).reduce(f64::max)?;
    (all_um[worst] > LOOSE_UM && all_um[worst] > LOOSE_TIMES * others_um).then(|| {
        plain(
            format!(
                "{}: readings of the probe d{} at one pose repeat within {:.1} µm, those of the other probes within {others_um:.1} µm.",
                run.name,
                names.get(worst).copied().unwrap_or_default(),
                all_um[worst]
            ),
            "The probe is loose, dirty or defective, or an axis that moves along it comes back as badly (play, hysteresis). Check the probe, read a pose \
             again from one side, and measure again.",
        )
    })
}
