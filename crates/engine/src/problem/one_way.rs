//! Whether place and time run together: an axis that goes one way while time goes on.

use crate::Experiment;
use std::f64::consts::TAU;
use trunnion_core::Joint;

/// Share of the way of an axis that its positions may step back for noise. An encoder scatters by less than a µm, positions that a
/// controller sends while the axis moves by some hundredths of a mm: a hundredth of a way of a few mm. A judgement, tuned on no data.
const RETREAT: f64 = 0.01;
/// Share of the duration for which an axis may stand at one place: longer, and the course in time is seen there by itself. A judgement,
/// tuned on no data.
const STANDS: f64 = 0.1;

/// The first axis that goes one way, and the same way, in every course of the runs. `None` where it comes back, or stands long enough for
/// a course in time to be seen at one place. A turn brings a rotary axis back.
pub(crate) fn one_way(experiment: &Experiment) -> Option<Joint> {
    let courses = courses(experiment)?;
    let goes_one_way = |joint: &Joint| {
        let ways: Vec<f64> = courses
            .iter()
            .map(|course| {
                let at = |&i: &usize| experiment.points[i].state.position[*joint];
                way(&course.iter().map(|(time_s, i)| (*time_s, at(i))).collect::<Vec<_>>(), *joint)
            })
            .collect();
        ways.iter().all(|way| *way > 0.0) || ways.iter().all(|way| *way < 0.0)
    };
    experiment.machine().joints().into_iter().find(goes_one_way)
}

/// Times and numbers of the points, in order of time. A run that begins after another ended goes on where that one stopped; runs with
/// clocks of their own are courses side by side. `None` where a point has no time.
fn courses(experiment: &Experiment) -> Option<Vec<Vec<(f64, usize)>>> {
    let mut runs: Vec<Vec<(f64, usize)>> = vec![Vec::new(); experiment.runs.len()];
    for (i, (point, run)) in experiment.points.iter().zip(&experiment.run_of_point).enumerate() {
        runs[*run].push((point.state.time_s?, i));
    }
    runs.retain(|run| !run.is_empty());
    runs.iter_mut().for_each(|run| run.sort_by(|a, b| a.0.total_cmp(&b.0)));
    runs.sort_by(|a, b| a[0].0.total_cmp(&b[0].0));
    let mut courses: Vec<Vec<(f64, usize)>> = Vec::new();
    for run in runs {
        let is_before = |course: &&mut Vec<(f64, usize)>| course.last().is_some_and(|last| last.0 < run[0].0);
        match courses.iter_mut().find(is_before) {
            Some(course) => course.extend(run),
            None => courses.push(run),
        }
    }
    Some(courses)
}

/// How far a course of times and positions goes one way; 0 where it comes back or stands.
fn way(course: &[(f64, f64)], joint: Joint) -> f64 {
    let (Some(&(begun_s, first)), Some(&(ended_s, last))) = (course.first(), course.last()) else {
        return 0.0;
    };
    let sense = (last - first).signum();
    let (mut farthest, mut retreat) = (f64::NEG_INFINITY, 0.0_f64);
    for (_, position) in course {
        farthest = farthest.max(sense * position);
        retreat = retreat.max(farthest - sense * position);
    }
    let way = farthest - sense * first;
    let near = RETREAT * way;
    // In one direction, so that each place is a stretch of time.
    let mut longest_s = 0.0_f64;
    let mut from = 0;
    for (time_s, position) in course {
        while (position - course[from].1).abs() > near {
            from += 1;
        }
        longest_s = longest_s.max(time_s - course[from].0);
    }
    let comes_back = retreat > near || joint.is_rotary() && way > TAU - near;
    let stands = longest_s > STANDS * (ended_s - begun_s);
    if comes_back || stands { 0.0 } else { sense * way }
}
