//! The sentences of a snapshot: what is wrong, where, how large, what to do.

use trunnion::results::number::signed;
use trunnion::results::{BallOffset, LiveDevice, LiveProbe, Zone};

/// No nest is known.
pub(super) const NO_NEST: &str =
    "The directions of the probes are not known: `trunnion calibrate-nest` finds them.";
/// No range is known.
pub(super) const NO_RANGE: &str =
    "The centre of the probes is not known: give their range, `travel_mm`, in the configuration.";
/// A device whose number does not change.
pub(super) const STUCK: &str = "a number does not change any more; see its probes";
const CHECK_STUCK: &str = "check that it moves freely and that its display is not held";
/// Offsets are shown to hundredths of a millimetre: what is less is none.
const SHOWN_MM: f64 = 0.01;

/// Of a probe: where it stands in its range. `value` is its value with the centre of its range, mm; `stuck` since when its
/// number is the same, s, and which channel trembles meanwhile; `why` it has no value.
pub(super) fn probe(
    zone: Zone,
    value: Option<(f64, f64)>,
    stuck: Option<(f64, &str)>,
    why: Option<&str>,
) -> String {
    let off = signed(value.map_or(0.0, |(value_mm, centre_mm)| value_mm - centre_mm), 2);
    match zone {
        Zone::Stuck => stuck.map_or_else(
            || STUCK.into(),
            |(kept_s, other)| {
                format!(
                    "its number has not changed for {kept_s:.0} s while that of {other} did; {CHECK_STUCK}"
                )
            },
        ),
        Zone::NoValue => why.map_or_else(|| "no value".into(), str::to_owned),
        Zone::Unknown => "its range is not known".into(),
        Zone::Centre => format!("{off} mm from its centre"),
        Zone::Inside => format!("{off} mm from its centre; a cycle may leave its range"),
        Zone::NearEnd => format!("{off} mm from its centre, near the end of its range; centre the ball"),
        Zone::Out => format!("{off} mm from its centre, out of its range; centre the ball"),
    }
}

/// Of the ball; `known` when the rotary axes are.
pub(super) fn ball(ball: &BallOffset, known: bool) -> String {
    let along = |(letter, mm): (&str, f64)| {
        let sign = if mm < 0.0 { '−' } else { '+' };
        (mm.abs() >= SHOWN_MM).then(|| format!("{:.2} mm too far in {sign}{letter}", mm.abs()))
    };
    let parts: Vec<String> =
        [("X", ball.x), ("Y", ball.y), ("Z", ball.z)].into_iter().filter_map(along).collect();
    let place = match parts.is_empty() {
        true => "Ball at the centre of the nest".to_owned(),
        false => format!("Ball {}", parts.join(", ")),
    };
    match known {
        true => place + ".",
        false => place + " (axes of the nest: the controller reports no positions).",
    }
}

/// Of everything: what the readings put in doubt, devices that do not read, probes that are not ready, the ball.
pub(super) fn sentences(
    doubt: Option<&str>,
    devices: &[LiveDevice],
    probes: &[LiveProbe],
    ball: Option<String>,
) -> String {
    let device = |device: &LiveDevice| Some(format!("{}: {}.", device.name, device.remedy.as_deref()?));
    let probe = |probe: &LiveProbe| format!("{}: {}.", probe.name, probe.say);
    let of_devices = devices.iter().filter_map(device);
    // What was said of its device is not said of a probe again.
    let is_said =
        |probe: &LiveProbe| devices.iter().any(|device| device.remedy.as_deref() == Some(&probe.say));
    let of_probes = probes.iter().filter(|one| !one.zone.is_good() && !is_said(one)).map(probe);
    let doubt = doubt.map(str::to_owned);
    doubt.into_iter().chain(of_devices).chain(of_probes).chain(ball).collect::<Vec<_>>().join(" ")
}
