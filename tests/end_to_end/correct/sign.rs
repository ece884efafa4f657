//! What is listed to be read at a few poses is what the machine reads there.

use super::NOISE_UM;
use serde_json::Value;

/// A difference of two readings scatters by √2 of one: four times that.
const AS_LISTED_UM: f64 = 4.0 * std::f64::consts::SQRT_2 * NOISE_UM;

/// What a reading is listed for, in the order of the runs: without the correction, with the right sign, with the wrong one.
const LISTED: [&str; 3] = ["without_um", "right_um", "wrong_um"];

/// The two poses that are to be looked at first, in runs of the whole cycle.
pub fn check_first_is_read(answer: &Value, runs: &[String; 3]) {
    let check = &answer["check_first"];
    let pose = |name: &str| vec![pose(&check[name])];
    for (listed, run) in LISTED.iter().zip(runs) {
        let [from, to] =
            ["from", "to"].map(|name| readings_um(run, check["setup"].as_str().unwrap(), &pose(name))[0]);
        same(&check[*listed], std::array::from_fn(|k| to[k] - from[k]), &format!("{listed} {check}"));
    }
}

/// The poses of a self-test, in runs of its cycle, about their mean.
pub fn self_test_is_read(answer: &Value, runs: &[String; 3]) {
    let test = &answer["self_test"];
    let listed_poses = test["poses"].as_array().unwrap();
    let poses: Vec<[f64; 2]> = listed_poses.iter().map(|of| pose(&of["pose"])).collect();
    assert_eq!(poses.len(), 4, "{test}");
    for (listed, run) in LISTED.iter().zip(runs) {
        let read = readings_um(run, test["setup"].as_str().unwrap(), &poses);
        let mean = |k: usize| read.iter().map(|reading| reading[k]).sum::<f64>() / 4.0;
        for (of, reading) in listed_poses.iter().zip(&read) {
            same(&of[*listed], std::array::from_fn(|k| reading[k] - mean(k)), &format!("{listed} {of}"));
        }
    }
}

fn same(listed: &Value, found: [f64; 3], what: &str) {
    let listed: [f64; 3] = std::array::from_fn(|k| listed[k].as_f64().unwrap());
    let off = (0..3).map(|k| (listed[k] - found[k]).abs()).fold(0.0, f64::max);
    assert!(off < AS_LISTED_UM, "{found:?} read: {what}");
}

/// B and C of a pose, degrees.
fn pose(text: &Value) -> [f64; 2] {
    let words = text.as_str().unwrap().split_whitespace();
    let degrees: Vec<f64> = words.filter_map(|word| word.strip_suffix('°')?.parse().ok()).collect();
    degrees.try_into().unwrap()
}

/// The mean reading of one setup at each of these poses.
fn readings_um(run: &str, setup: &str, poses: &[[f64; 2]]) -> Vec<[f64; 3]> {
    let runs = trunnion::open(run).unwrap();
    let points = runs.points();
    let of_pose = |pose: &[f64; 2]| {
        let [b, c] = [trunnion_core::Joint::B, trunnion_core::Joint::C];
        let own: Vec<[f64; 3]> = points
            .points
            .iter()
            .filter(|point| {
                let at = point.state.position;
                let here = (at[b].to_degrees() - pose[0]).abs() + (at[c].to_degrees() - pose[1]).abs() < 0.01;
                here && points.setups[point.state.setup].name == setup
            })
            .map(|point| point.reading_mm)
            .collect();
        assert!(!own.is_empty(), "{pose:?} in {run}");
        std::array::from_fn(|k| own.iter().map(|mm| mm[k] * 1e3).sum::<f64>() / own.len() as f64)
    };
    poses.iter().map(of_pose).collect()
}
