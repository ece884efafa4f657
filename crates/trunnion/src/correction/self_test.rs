//! Four poses that show the sign of a correction: the corners of the measured range that the errors separate most.

use super::nest_cycle::cycle;
use super::shown::seen_mm;
use super::sign::{Signs, pose};
use crate::{Error, Experiment, Fit};
use nalgebra::Vector3;
use trunnion_core::convert;
use trunnion_core::{Joint, State};
use trunnion_cycles::cycle::{GridAxis, Pose};
use trunnion_results::{AxisErrors, SelfTest, SelfTestPose};

/// Positions of an axis that are looked at: pairs of 13 are 78, of two axes some 6000.
const MOST_POSITIONS: usize = 13;
/// Poses of the cycle.
const POSES: usize = 4;
/// Changes that are smaller show no sign: a tenth of the step of a usual probe, 0.1 µm.
const LEAST_CHANGE_MM: f64 = 1e-5;

/// The number of a setup with its grid of candidates.
struct Candidates {
    index: usize,
    axes: Vec<GridAxis>,
    /// What the errors change at each place, the last axis fastest, mm.
    changes: Vec<Vector3<f64>>,
}

pub(super) fn self_test(fit: &Fit, errors: &AxisErrors) -> Result<(SelfTest, String), Error> {
    let runs = fit.experiment();
    let points = runs.points();
    let all = (0..points.setups.len()).filter_map(|setup| candidates(runs, setup, errors));
    let best = all
        .filter_map(|candidates| {
            let (stations, spread) = best_stations(&candidates)?;
            Some((candidates.index, stations, spread))
        })
        .max_by(|a, b| a.2.total_cmp(&b.2));
    let refused = |why: &str| Error::NoCorrection { why: why.into() };
    let (index, axes, spread) =
        best.ok_or_else(|| refused("a self-test turns a rotary axis that these runs turned"))?;
    if spread.sqrt() < LEAST_CHANGE_MM {
        return Err(refused("no pose of these runs shows the correction"));
    }
    let setup = &points.setups[index];
    let cycle = cycle(runs, setup, axes);
    let poses = cycle.poses(points.machine()).ok_or_else(|| refused("the machine cannot follow the ball"))?;
    let begin = &points.scene;
    let state = |pose: &Pose| State {
        position: pose.position,
        direction: pose.direction,
        time_s: begin.time_range_s.map(|(first, _)| first),
        temperature_degc: begin.first_temperature_degc.clone(),
        setup: index,
        target: pose.target,
        ..State::default()
    };
    let signs = Signs::at(fit, errors, &poses.iter().map(state).collect::<Vec<_>>())?;
    let mean = Signs::mean(&signs);
    let components = setup.instrument.components();
    let of_pose = |(place, signs): (&Pose, &Signs)| {
        let [without_um, right_um, wrong_um] = signs.about(&mean).um(components.len());
        SelfTestPose { pose: pose(points.machine(), &place.position), without_um, right_um, wrong_um }
    };
    let answer = SelfTest {
        setup: setup.name.clone(),
        poses: poses.iter().zip(&signs).map(of_pose).collect(),
        components: components.iter().map(ToString::to_string).collect(),
        cycle: String::new(),
        program: None,
    };
    Ok((answer, cycle.to_text()))
}

/// The positions of up to two rotary axes that this setup was measured at.
fn candidates(runs: &Experiment, index: usize, errors: &AxisErrors) -> Option<Candidates> {
    let points = runs.points();
    let setup = &points.setups[index];
    let of_axis = |letter: Joint| {
        let own = points.points.iter().filter(|point| point.state.setup == index);
        let mut stations: Vec<f64> =
            own.map(|point| tenth_of_a_degree(point.state.position[letter])).collect();
        stations.sort_by(f64::total_cmp);
        stations.dedup();
        let step = stations.len().div_ceil(MOST_POSITIONS).max(1);
        let stations: Vec<f64> = stations.into_iter().step_by(step).collect();
        (stations.len() > 1).then_some(GridAxis { letter, stations })
    };
    let axes: Vec<GridAxis> =
        points.machine().rotary_joints().into_iter().filter_map(of_axis).take(2).collect();
    if axes.is_empty() {
        return None;
    }
    let cycle = cycle(runs, setup, axes.clone());
    let changes = cycle.poses(points.machine())?.into_iter().map(|pose| {
        let state = State { position: pose.position, ..State::default() };
        seen_mm(points.machine(), setup, &state, errors)
    });
    Some(Candidates { index, changes: changes.collect(), axes })
}

/// Rounded, so that positions that scatter about one stand are one.
fn tenth_of_a_degree(rad: f64) -> f64 {
    convert::rad_from_deg((convert::deg_from_rad(rad) * 10.0).round() / 10.0)
}

/// The four places whose changes scatter most, and that scatter squared.
fn best_stations(candidates: &Candidates) -> Option<(Vec<GridAxis>, f64)> {
    let spread = |places: &[usize]| {
        let changes = places.iter().map(|&k| candidates.changes[k]);
        let mean = changes.clone().sum::<Vector3<f64>>() / places.len() as f64;
        changes.map(|change| (change - mean).norm_squared()).sum::<f64>()
    };
    let at = |axis: &GridAxis, chosen: &[usize]| GridAxis {
        letter: axis.letter,
        stations: chosen.iter().map(|&k| axis.stations[k]).collect(),
    };
    let pairs = |count: usize| (0..count).flat_map(move |i| (i + 1..count).map(move |j| [i, j]));
    match &candidates.axes[..] {
        [slow, fast] => {
            let width = fast.stations.len();
            let all = pairs(slow.stations.len()).flat_map(|b| pairs(width).map(move |c| (b, c)));
            let (b, c, best) = all
                .map(|(b, c)| {
                    let places = b.map(|b| c.map(|c| b * width + c)).concat();
                    (b, c, spread(&places))
                })
                .max_by(|one, other| one.2.total_cmp(&other.2))?;
            Some((vec![at(slow, &b), at(fast, &c)], best))
        }
        [only] => {
            let count = only.stations.len().min(POSES);
            let last = only.stations.len() - 1;
            let chosen: Vec<usize> = (0..count).map(|k| k * last / (count - 1)).collect();
            Some((vec![at(only, &chosen)], spread(&chosen)))
        }
        _ => None,
    }
}
