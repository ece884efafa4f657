//! The points that a scan looks at.

use crate::Experiment;
use trunnion_cycles::RunKind;

/// Points on the fly that a scan looks at.
const MOST_POINTS: usize = 700;

/// Every k-th point of what was read on the fly, where there are many: neighbours say the same, and the whole grammar has thousands of
/// columns. Points at rest all stay. One flag for each point; `None` where all stay.
pub fn kept(experiment: &Experiment) -> Option<Vec<bool>> {
    let on_the_fly = |i: usize| experiment.kinds[experiment.run_of_point[i]] == RunKind::OnTheFly;
    let points = experiment.points.len();
    let many = (0..points).filter(|&i| on_the_fly(i)).count();
    let step = many.div_ceil(MOST_POINTS);
    let mut seen = 0;
    let mut keep = |i: usize| {
        seen += usize::from(on_the_fly(i));
        !on_the_fly(i) || seen % step == 1
    };
    (step > 1).then(|| (0..points).map(&mut keep).collect())
}
