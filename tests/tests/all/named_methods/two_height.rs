//! S0's experiments on the simulator.

use super::bench::{Set, by_method, curve, cycle, cycle_text, measure, noise, truth, value};
use trunnion_cycles::Cycle;
use trunnion_methods::recipes::{Convention, MethodOptions};
use trunnion_methods::{Findings, recipes};

const UM: f64 = 1e-3;
const URAD: f64 = 1e-6;

/// Three harmonic error motions of one axis: radial of 3 lobes, axial of 2, tilt of 2.
fn motions(axis: &str) -> String {
    format!(
        "[[hidden]]\nid = \"radial-error-motion:{axis}\"\namplitude = 1e-3\n\
         shape = {{ lobes = 3.0, u_cos = 0.8, u_sin = 0.3, v_cos = -0.5, v_sin = 0.9 }}\n\
         [[hidden]]\nid = \"axial-error-motion:{axis}\"\namplitude = 0.5e-3\nshape = {{ lobes = 2.0, phase_rad = 0.7 }}\n\
         [[hidden]]\nid = \"tilt-error-motion:{axis}\"\namplitude = 4e-6\n\
         shape = {{ lobes = 2.0, u_cos = 1.0, u_sin = 0.2, v_cos = -0.4, v_sin = 0.6 }}\n"
    )
}

const LOCATION: &str = "[location]\nEX0C_um = 4.0\nEY0C_um = -10.0\nEA0C_urad = -16.0\nEB0B_urad = 20.0\nEX0B_um = 3.0\nEZ0B_um = -5.0\n\
     EA0B_urad = 12.0\nEC0B_urad = -9.0\n";

fn two_height(cycle: &Cycle, seed: u64, settings: &[Set<'_>], rest: &str) -> Findings {
    let run = measure(&truth(&cycle.machine, seed, cycle, settings, rest), cycle);
    by_method("two-height", &run, Convention::RightHanded).unwrap_or_else(|error| panic!("{error}"))
}

fn near(found: f64, expected: f64, within: f64, what: &str) {
    assert!((found - expected).abs() <= within, "{what}: {found:e}, put in {expected:e}");
}

/// The largest difference of two curves over the same angles.
fn apart(one: &[(f64, f64)], other: &[(f64, f64)]) -> f64 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max)
}

fn check_recovers(cycle_name: &str) {
    let cycle = cycle(&cycle_text(cycle_name));
    let settings = [
        Set { name: "low", setting_um: [12.0, -7.0, 3.0] },
        Set { name: "high", setting_um: [-150.0, 90.0, 0.0] },
    ];
    let found = two_height(&cycle, 1, &settings, &format!("{LOCATION}{}{}", noise(0.0, 0.0), motions("C")));
    let v = |name: &str| value(&found, name);
    // What carries C adds its own: EX0C + EX0B, EA0C + EA0B, EB0B.
    near(v("EX0C"), 7.0 * UM, 2e-5, "EX0C");
    near(v("EY0C"), -10.0 * UM, 2e-5, "EY0C");
    near(v("EA0C"), -4.0 * URAD, 0.1 * URAD, "EA0C");
    near(v("EB0C"), 20.0 * URAD, 0.1 * URAD, "EB0C");
    near(v("setting.high.x"), -150.0 * UM, 2e-5, "setting");
    near(v("setting.low.y"), -7.0 * UM, 2e-5, "setting");
    for (angle, exc) in curve(&found, "EXC", "EXC") {
        let t = angle;
        near(exc, UM * (0.8 * (3.0 * t).cos() + 0.3 * (3.0 * t).sin()), 3e-5, "EXC");
    }
    for (t, eyc) in curve(&found, "EYC", "EYC") {
        near(eyc, UM * (-0.5 * (3.0 * t).cos() + 0.9 * (3.0 * t).sin()), 3e-5, "EYC");
    }
    for (t, ezc) in curve(&found, "EZC", "EZC") {
        near(ezc, 0.5 * UM * (2.0 * t + 0.7).sin(), 3e-5, "EZC");
    }
    for (t, eac) in curve(&found, "EAC", "EAC") {
        near(eac, 4.0 * URAD * ((2.0 * t).cos() + 0.2 * (2.0 * t).sin()), 0.15 * URAD, "EAC");
    }
    for (t, ebc) in curve(&found, "EBC", "EBC") {
        near(ebc, 4.0 * URAD * (-0.4 * (2.0 * t).cos() + 0.6 * (2.0 * t).sin()), 0.15 * URAD, "EBC");
    }
}

#[test]
fn what_was_put_into_c_is_found_at_rest_and_on_the_fly() {
    check_recovers("two-height-c-static");
    check_recovers("two-height-c");
}

#[test]
fn b_is_recognised_and_found_too() {
    let cycle = cycle(&cycle_text("two-height-b"));
    let found = two_height(&cycle, 1, &[], &format!("{LOCATION}{}", noise(0.0, 0.0)));
    near(value(&found, "EX0B"), 3.0 * UM, 2e-5, "EX0B");
    near(value(&found, "EZ0B"), -5.0 * UM, 2e-5, "EZ0B");
    near(value(&found, "EA0B"), 12.0 * URAD, 0.1 * URAD, "EA0B");
    near(value(&found, "EC0B"), -9.0 * URAD, 0.1 * URAD, "EC0B");
}

#[test]
fn an_a_axis_is_found_by_the_same_recipe() {
    let text = cycle_text("two-height-b")
        .replace("machine = \"table-bc\"", "machine = \"table-ac\"")
        .replace("axis = \"B\"", "axis = \"A\"")
        .replace("[0.0, 60.0, 0.0]", "[60.0, 0.0, 0.0]")
        .replace("[0.0, 160.0, 0.0]", "[160.0, 0.0, 0.0]");
    let rest = format!(
        "[location]\nEY0A_um = 6.0\nEZ0A_um = -2.0\nEB0A_urad = 15.0\nEC0A_urad = -25.0\n{}",
        noise(0.0, 0.0)
    );
    let found = two_height(&cycle(&text), 1, &[], &rest);
    near(value(&found, "EY0A"), 6.0 * UM, 2e-5, "EY0A");
    near(value(&found, "EZ0A"), -2.0 * UM, 2e-5, "EZ0A");
    near(value(&found, "EB0A"), 15.0 * URAD, 0.1 * URAD, "EB0A");
    near(value(&found, "EC0A"), -25.0 * URAD, 0.1 * URAD, "EC0A");
}

#[test]
fn a_nest_on_the_table_reports_the_same_as_one_in_the_spindle() {
    let spindle = cycle(&cycle_text("two-height-c-static"));
    let table = cycle(&cycle_text("two-height-c-static").replace("nest = \"spindle\"", "nest = \"table\""));
    let rest = format!("{LOCATION}{}{}", noise(0.0, 0.0), motions("C"));
    let [one, other] = [spindle, table].map(|cycle| two_height(&cycle, 1, &[], &rest));
    for name in ["EX0C", "EY0C"] {
        near(value(&one, name), value(&other, name), 1e-5, name);
    }
    for name in ["EA0C", "EB0C"] {
        near(value(&one, name), value(&other, name), 0.05 * URAD, name);
    }
    assert!(apart(&curve(&one, "EXC", "EXC"), &curve(&other, "EXC", "EXC")) < 1e-5);
}

/// S0 §4.3, Fig. 18–19: 0.2 mm in X, Y, −X, −Y change the error motion components by less than 1 µm.
#[test]
fn setting_errors_of_two_tenths_change_the_error_motion_by_less_than_a_micrometre() {
    let cycle = cycle(&cycle_text("two-height-c-static"));
    let components = |setting_um: [f64; 3], noise: &str| -> Vec<Vec<(f64, f64)>> {
        let settings = [Set { name: "low", setting_um }, Set { name: "high", setting_um }];
        let found = two_height(&cycle, 5, &settings, &format!("{LOCATION}{noise}{}", motions("C")));
        let at = |title| ["low", "high"].map(|height| curve(&found, title, height));
        ["Component X", "Component Y"].iter().flat_map(|title| at(title)).collect()
    };
    let worst = |noise: &str| {
        let without = components([0.0; 3], noise);
        let with = [[200.0, 0.0], [0.0, 200.0], [-200.0, 0.0], [0.0, -200.0]].map(|[x, y]| {
            let moved = components([x, y, 0.0], noise);
            moved.iter().zip(&without).map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
        });
        with.into_iter().fold(0.0, f64::max)
    };
    // Noise-free: what is left is of second order (location errors turn the setting a little).
    assert!(worst(&noise(0.0, 0.5)) < 0.02 * UM, "{}", worst(&noise(0.0, 0.5)));
    // With 0.3 µm of white noise, the same in every run, as S0 saw it: below 1 µm.
    assert!(worst(&noise(0.3, 0.5)) < 1.0 * UM);
}

/// S0 table 1: B tilted by −0.01, −0.02, −0.03° moves EB0C by −0.0098, −0.0198, −0.0295° and nothing else by more than 1 µm.
#[test]
fn a_tilt_of_b_is_found_as_the_tilt_of_c() {
    let cycle = cycle(&cycle_text("two-height-c"));
    let at_tilt = |tilt_deg: f64, seed| {
        let rest = format!(
            "[location]\nEX0C_um = 2.4\nEY0C_um = -10.0\nEA0C_urad = 16.6\nEB0B_urad = {:?}\n{}",
            (0.0011 + tilt_deg).to_radians() / URAD,
            noise(0.3, 0.5)
        );
        two_height(&cycle, seed, &[], &rest)
    };
    let upright = at_tilt(0.0, 11);
    for (tilt_deg, s0_deg) in [(-0.01, -0.0098), (-0.02, -0.0198), (-0.03, -0.0295)] {
        let tilted = at_tilt(tilt_deg, 11);
        let moved_deg = (value(&tilted, "EB0C") - value(&upright, "EB0C")).to_degrees();
        near(moved_deg, tilt_deg, 1e-4, "EB0C against the command, degrees");
        near(moved_deg, s0_deg, 1e-3, "EB0C against S0, degrees");
        for name in ["EX0C", "EY0C"] {
            near(value(&tilted, name), value(&upright, name), UM, name);
        }
    }
}

#[test]
fn the_source_convention_turns_the_signs_of_s0() {
    let cycle = cycle(&cycle_text("two-height-c-static"));
    let run = measure(
        &truth("table-bc", 3, &cycle, &[], &format!("{LOCATION}{}{}", noise(0.0, 0.0), motions("C"))),
        &cycle,
    );
    let [right, source] = [Convention::RightHanded, Convention::Source].map(|convention| {
        by_method("two-height", &run, convention).unwrap_or_else(|error| panic!("{error}"))
    });
    let sign = |name: &str| value(&source, name) / value(&right, name);
    assert_eq!(["EA0C", "EB0C", "EX0C", "EY0C"].map(sign), [-1.0, 1.0, 1.0, 1.0]);
    for (name, sign) in [("EXC", -1.0), ("EYC", -1.0), ("EZC", -1.0), ("EAC", 1.0), ("EBC", 1.0)] {
        let (right, source) = (curve(&right, name, name), curve(&source, name, name));
        assert!(right.iter().zip(&source).all(|(a, b)| b.1 == sign * a.1), "{name}");
    }
}

/// Standard deviations of the injected values in u, four passes at each height in white noise.
#[test]
fn uncertainties_cover_the_errors() {
    let cycle = cycle(&cycle_text("two-height-c-static"));
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in 0..30 {
        let found = two_height(&cycle, 100 + seed, &[], &format!("{LOCATION}{}", noise(0.3, 0.0)));
        for (name, injected) in
            [("EX0C", 7.0 * UM), ("EY0C", -10.0 * UM), ("EA0C", -4.0 * URAD), ("EB0C", 20.0 * URAD)]
        {
            let u = found.value(name).and_then(|v| v.u).expect("four passes");
            squares += ((value(&found, name) - injected) / u).powi(2);
            count += 1.0;
        }
    }
    // Place and lean of a line go together: 60 of the 120 are independent. 1 ± 3 standard deviations.
    let rms = f64::sqrt(squares / count);
    assert!((0.73..1.27).contains(&rms), "rms of errors over u: {rms}");
}

#[test]
fn two_recordings_of_one_height_each_give_the_same() {
    let cycle = cycle(&cycle_text("two-height-c"));
    let both = measure(&truth("table-bc", 3, &cycle, &[], &format!("{LOCATION}{}", noise(0.1, 0.5))), &cycle);
    let apart = [0, 1].map(|setup| {
        let mut run = both.clone();
        run.points.retain(|point| point.state.setup == setup);
        run
    });
    let method = recipes::find("two-height").expect("registered");
    let [together, apart] = [std::slice::from_ref(&both), &apart[..]]
        .map(|runs| method.apply(runs, &MethodOptions::default()).unwrap_or_else(|error| panic!("{error}")));
    let errors = |of: &Findings| -> Vec<String> {
        let names = of.values.iter().map(|value| value.name.clone());
        names.filter(|name| name.starts_with('E')).collect()
    };
    assert_eq!(errors(&together), errors(&apart));
    for name in errors(&together) {
        near(value(&together, &name), value(&apart, &name), 1e-12, &name);
    }
}

#[test]
fn readings_at_one_height_are_refused_with_what_to_do() {
    let text = cycle_text("two-height-c-static").replace("146.8", "66.7");
    let cycle = cycle(&text);
    let run =
        measure(&truth("table-bc", 3, &cycle, &[], &format!("[location]\n{}", noise(0.0, 0.0))), &cycle);
    let error = by_method("two-height", &run, Convention::RightHanded).unwrap_err().to_string();
    assert!(error.contains("same height") && error.contains("second height"), "{error}");
    let grid = super::bench::cycle(&cycle_text("r-test-sweep-c"));
    let run = measure(&truth("table-bc", 3, &grid, &[], &format!("[location]\n{}", noise(0.0, 0.0))), &grid);
    let error = by_method("two-height", &run, Convention::RightHanded).unwrap_err().to_string();
    assert!(error.contains("X, Y") && error.contains("axis line"), "{error}");
}
