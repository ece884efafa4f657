use super::*;
use trunnion_core::axis::iso::{B, C, X};
use trunnion_core::{AxisValues, Joint};

fn axes(time_s: f64, values: &[(Joint, f64)]) -> AxisSample {
    let mut position = AxisValues::default();
    for &(letter, value) in values {
        position[letter] = value;
    }
    AxisSample { time_s, position, ..AxisSample::default() }
}

fn probe(channel: u16, time_s: f64, value_mm: f64) -> ProbeSample {
    ProbeSample { channel, time_s, value_mm, ..ProbeSample::default() }
}

enum Input {
    Axes(AxisSample),
    Probe(ProbeSample),
}

/// Gives all samples in order of time.
fn align(mut inputs: Vec<Input>, limits: AlignLimits) -> (Vec<Aligned>, AlignCounts) {
    let time = |input: &Input| match input {
        Input::Axes(sample) => sample.time_s,
        Input::Probe(sample) => sample.time_s,
    };
    inputs.sort_by(|a, b| time(a).total_cmp(&time(b)));
    let mut aligner = Aligner::new(&[0, 1, 2], limits);
    let mut out = Vec::new();
    for input in &inputs {
        match input {
            Input::Axes(sample) => aligner.push_axes(sample, &mut out),
            Input::Probe(sample) => aligner.push_probe(sample, &mut out),
        }
    }
    aligner.finish(&mut out);
    (out, aligner.counts())
}

fn samples(out: &[Aligned]) -> Vec<(AxisState, [f64; 3])> {
    out.iter().filter_map(|step| Some((step.state, step.channels_mm?))).collect()
}

/// C swings as sin, X turns back at 1 s and 2 s, sampled at 50 Hz; three probes at 1 kHz, each with its own phase.
fn swing(probe_of: impl Fn(f64) -> f64) -> Vec<Input> {
    let mut inputs: Vec<Input> = (0..200)
        .map(|i| f64::from(i) * 0.02)
        .map(|t| Input::Axes(axes(t, &[(C, (2.0 * t).sin()), (X, triangle(t))])))
        .collect();
    for k in 0..3u16 {
        let times = (0..3900).map(|i| f64::from(i) * 1e-3 + 0.0003 * f64::from(k));
        inputs.extend(times.map(|t| Input::Probe(probe(k, t, probe_of(t)))));
    }
    inputs
}

/// Up to 10 at 1 s, down to 0 at 2 s, up again.
fn triangle(t: f64) -> f64 {
    10.0 * (1.0 - (t % 2.0 - 1.0).abs())
}

#[test]
fn smooth_motion_is_interpolated_to_the_instant_with_its_derivatives() {
    let (out, counts) = align(swing(|t| 0.1 * t), AlignLimits::default());
    let found = samples(&out);
    assert!(found.len() > 3890 && counts.incomplete <= 2, "{counts:?}");
    for (state, channels_mm) in found.iter().filter(|(state, _)| (0.1..3.8).contains(&state.time_s)) {
        let t = state.time_s;
        // cubic error h⁴/384·|f''''| and slope error h²/6·|f'''| with h = 20 ms
        assert!((state.position[C] - (2.0 * t).sin()).abs() < 2e-6, "{t}");
        assert!((state.velocity[C] - 2.0 * (2.0 * t).cos()).abs() < 1e-3, "{t}");
        assert!((state.acceleration[C] + 4.0 * (2.0 * t).sin()).abs() < 3e-3, "{t}");
        for mm in channels_mm {
            assert!((mm - 0.1 * t).abs() < 1e-12, "{t}");
        }
    }
    assert!(out.windows(2).all(|pair| pair[0].state.time_s <= pair[1].state.time_s));
}

#[test]
fn direction_and_travel_restart_at_a_reversal() {
    let (out, _) = align(swing(|_| 0.0), AlignLimits::default());
    let at = |time_s: f64| samples(&out).into_iter().find(|(s, _)| s.time_s >= time_s).unwrap().0;
    let (up, down, again) = (at(0.5), at(1.5), at(2.5));
    assert_eq!([up, down, again].map(|s| s.direction[X]), [1.0, -1.0, 1.0]);
    for sample in [up, down, again] {
        assert!((sample.since_reversal[X] - 5.0).abs() < 0.02, "{}", sample.since_reversal[X]);
    }
    assert_eq!((up.direction[B], up.since_reversal[B]), (0.0, 0.0));
}

#[test]
fn a_servo_that_overshoots_a_little_has_not_reversed() {
    let mut inputs: Vec<Input> =
        (0..100).map(|i| Input::Axes(axes(f64::from(i) * 0.01, &[(X, f64::from(i.min(50)))]))).collect();
    inputs.push(Input::Axes(axes(1.01, &[(X, 49.998)])));
    let (out, _) = align(inputs, AlignLimits::default());
    let Some(last) = out.last() else { panic!("{out:?}") };
    assert_eq!(last.state.direction[X], 1.0);
}

#[test]
fn an_axis_shown_modulo_a_turn_goes_on_smoothly() {
    let shown = |t: f64| (6.0 + t).rem_euclid(std::f64::consts::TAU);
    let inputs =
        (0..100).map(|i| f64::from(i) * 0.01).map(|t| Input::Axes(axes(t, &[(C, shown(t))]))).collect();
    let (out, _) = align(inputs, AlignLimits::default());
    for Aligned { state, .. } in out {
        assert!(
            (state.velocity[C] - 1.0).abs() < 1e-9 && (state.position[C] - 6.0 - state.time_s).abs() < 1e-9
        );
    }
}

#[test]
fn nothing_is_invented_where_a_source_is_away() {
    let mut inputs = swing(|_| 1.0);
    inputs.retain(|input| match input {
        Input::Axes(sample) => !(1.0..2.0).contains(&sample.time_s),
        Input::Probe(sample) => sample.channel != 1 || !(3.0..3.2).contains(&sample.time_s),
    });
    let (out, counts) = align(inputs, AlignLimits::default());
    let found = samples(&out);
    assert!(found.iter().all(|(state, _)| !(0.99..1.99).contains(&state.time_s)));
    assert!(found.iter().any(|(state, _)| (2.0..2.1).contains(&state.time_s)));
    for (state, channels_mm) in &found {
        let away = (3.01..3.19).contains(&state.time_s);
        assert!(!away || channels_mm[1].is_nan() && channels_mm[2] == 1.0);
    }
    assert!(counts.without_axes > 990 && (190..210).contains(&counts.incomplete), "{counts:?}");
}

#[test]
fn axes_come_out_while_the_probes_are_away_and_order_of_arrival_within_the_wait_does_not_matter() {
    let mut aligner = Aligner::new(&[0, 1, 2], AlignLimits::default());
    let mut states = Vec::new();
    for i in 0..200 {
        aligner.push_axes(&axes(f64::from(i) * 0.02, &[]), &mut states);
    }
    assert!((140..160).contains(&states.len()), "{}", states.len()); // all but the last second
    // The same samples with the axes 0.3 s late.
    let limits = AlignLimits::default();
    let (expected, _) = align(swing(|t| t), limits);
    let mut late = swing(|t| t);
    let due = |input: &Input| match input {
        Input::Axes(sample) => sample.time_s + 0.3,
        Input::Probe(sample) => sample.time_s,
    };
    late.sort_by(|a, b| due(a).total_cmp(&due(b)));
    let mut aligner = Aligner::new(&[0, 1, 2], limits);
    let mut out = Vec::new();
    for input in &late {
        match input {
            Input::Axes(sample) => aligner.push_axes(sample, &mut out),
            Input::Probe(sample) => aligner.push_probe(sample, &mut out),
        }
    }
    aligner.finish(&mut out);
    assert_eq!(samples(&out).len(), samples(&expected).len());
    for (a, b) in samples(&out).iter().zip(samples(&expected)) {
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
    }
}
