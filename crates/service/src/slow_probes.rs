//! Probes that are read so slowly that a program of the cycle does not stand long enough for a point.

use std::time::Duration;
use trunnion::cycles::{CourseRules, Motion};
use trunnion_acquire::DeviceConfig;
use trunnion_sync::StaticRules;
use trunnion_sync::plan::Plan;

/// What to say of the slowest probe before a cycle at rest; `None` where every pose has time enough.
pub fn too_slow(devices: &[DeviceConfig], plan: &Plan) -> Option<String> {
    let (Motion::Static { settle, .. } | Motion::Line { settle, .. }) = &plan.cycle.motion else {
        return None;
    };
    let asked =
        devices.iter().filter_map(|device| Some((device.device.asked_every()?, device.name.as_str())));
    let (every, name) = asked.max()?;
    said(&StaticRules::new(*settle), every, name).map(|said| format!("cycle {}: {said}", plan.cycle.name))
}

fn said(rules: &StaticRules, every: Duration, name: &str) -> Option<String> {
    let course = CourseRules::default();
    let (window_s, stands_s) = (rules.window_s(every.as_secs_f64()), course.dwell_of(rules.settle.window_s));
    let most_s = stands_s - course.pace.settle_s;
    (window_s > most_s).then(|| {
        let longest_ms = (1e3 * most_s / (window_s / every.as_secs_f64())).floor();
        format!(
            "{name} is read every {} ms, so that a point takes {window_s:.1} s at rest, and a program of nc-program stands {stands_s:.1} s at a \
             pose: read it every {longest_ms} ms (poll_ms, sync_ms), or write the program with --dwell-s {:.0}; before that poses may stay \
             without a reading",
            every.as_millis(),
            course.dwell_of(window_s).ceil(),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion::cycles::Cycle;

    #[test]
    fn what_is_too_slow_is_said_with_what_to_set() {
        let text = include_str!("../../../config/cycles/r-test-static.toml");
        let cycle = Cycle::parse("c.toml", text).unwrap();
        let Motion::Static { settle, .. } = &cycle.motion else { panic!("{cycle:?}") };
        let rules = StaticRules::new(*settle);
        let at = |ms: u64| said(&rules, Duration::from_millis(ms), "gauge");
        assert_eq!((at(1), at(100), at(160)), (None, None, None));
        let slow = at(1000).unwrap();
        for words in
            ["gauge is read every 1000 ms", "takes 6.0 s", "stands 2.5 s", "every 166 ms", "--dwell-s 14"]
        {
            assert!(slow.contains(words), "{slow}");
        }
    }
}
