//! `multilateration` on distances that follow from chosen stations and errors, worked from equation 8 of S2.

use nalgebra::{Matrix3x6, Matrix6, Point3, Vector3, Vector6};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use trunnion_core::axis::iso::{X, Y, Z};
use trunnion_core::{InstrumentKind, NestSide, Point, Quality, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::shipped;
use trunnion_methods::Findings;
use trunnion_methods::findings::Cell;
use trunnion_methods::recipes::{self, MethodError, MethodOptions};

const UM: f64 = 1e-3;
/// Stations as a person enters them.
const STATIONS: [[f64; 3]; 4] =
    [[320.0, 320.0, -120.0], [-320.0, 320.0, -120.0], [-320.0, -320.0, -120.0], [330.0, -310.0, 150.0]];

/// Where the reflector really is, mm: scales, squareness and a bow.
fn error_mm(at: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(15e-6 * at.x - 30e-6 * at.y, -10e-6 * at.y, 4e-3 * (at.x / 200.0).powi(2) + 12e-6 * at.z)
}

fn targets() -> Vec<Vector3<f64>> {
    let along = |k: i32| f64::from(k) * 100.0;
    let plane = |z: i32| {
        (-2..=2).flat_map(move |x| (-2..=2).map(move |y| Vector3::new(along(x), along(y), along(z))))
    };
    (0..=2).flat_map(plane).collect()
}

/// Readings from stations 1 mm off and dead paths of 100 to 400 mm.
fn run(stations: &[[f64; 3]], noise_um: f64, seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, noise_um * UM).unwrap();
    let mut points = Vec::new();
    for (k, station) in stations.iter().enumerate() {
        let off = Vector3::new(
            [1.0, -0.7, 0.4, 0.9][k % 4],
            [-0.5, 0.8, 1.1, -0.3][k % 4],
            [0.6, -1.0, 0.2, 0.7][k % 4],
        );
        let (stands, dead_path) = (Vector3::from(*station) + off, 100.0 * (k as f64 + 1.0));
        for target in targets() {
            let mut state = State { setup: k, ..State::default() };
            (state.position[X], state.position[Y], state.position[Z]) = (target.x, target.y, target.z);
            let length = (target + error_mm(&target) - stands).norm() - dead_path + normal.sample(&mut rng);
            points.push(Point {
                reading_mm: [length, 0.0, 0.0],
                state,
                spread_mm: [0.0; 3],
                samples: 1,
                quality: Quality::Good,
            });
        }
    }
    let setup = |(k, at): (usize, &[f64; 3])| {
        Setup::new(format!("s{}", k + 1), InstrumentKind::Tracker, NestSide::Table, Point3::from(*at))
    };
    let setups = stations.iter().enumerate().map(setup).collect();
    let machine = shipped::machine("three-axis").unwrap();
    Run { name: "t".into(), machine, kind: RunKind::Static, setups, channels: vec![], points }
}

fn found(run: Run) -> Result<Findings, MethodError> {
    recipes::find("multilateration").unwrap().apply(&[run], &MethodOptions::default())
}

/// Δ and u of every target, mm.
fn errors_mm(findings: &Findings) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let number = |cell: &Cell| match cell {
        Cell::Number(number) => *number,
        _ => panic!("{cell:?}"),
    };
    let row = |row: &Vec<Cell>| {
        let of = |first: usize| Vector3::from_fn(|k, _| number(&row[first + 2 * k]));
        (of(3), of(4))
    };
    findings.tables[0].rows.iter().map(row).collect()
}

/// The errors of all targets without shift and turn.
fn expected_mm() -> Vec<Vector3<f64>> {
    let all = targets();
    let middle = all.iter().sum::<Vector3<f64>>() / all.len() as f64;
    let motions = |at: &Vector3<f64>| {
        let mut motions = Matrix3x6::identity();
        motions.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(at - middle).cross_matrix());
        motions
    };
    let scatter: Matrix6<f64> = all.iter().map(|at| motions(at).transpose() * motions(at)).sum();
    let moment: Vector6<f64> = all.iter().map(|at| motions(at).transpose() * error_mm(at)).sum();
    let rigid = scatter.try_inverse().unwrap() * moment;
    all.iter().map(|at| error_mm(at) - motions(at) * rigid).collect()
}

#[test]
fn exact_distances_give_the_error_of_every_target_and_the_stations() {
    let findings = found(run(&STATIONS, 0.0, 1)).unwrap();
    for ((off, _), expected) in errors_mm(&findings).iter().zip(expected_mm()) {
        // What a turn of the volume of 30 µrad leaves in second order.
        assert!((off - expected).norm() < 2e-6, "{off} {expected}");
    }
    for (k, length) in [100.0, 200.0, 300.0, 400.0].into_iter().enumerate() {
        let value = findings.value(&format!("station s{} dead path", k + 1)).unwrap();
        assert!((value.value - length).abs() < 1e-5, "{}", value.value);
    }
}

/// 2250 numbers of ten sets of noise; those of one set share four stations, so rms z scatters by a tenth.
#[test]
fn standard_uncertainties_of_targets_are_fair() {
    let (mut squares, mut count, mut largest) = (0.0, 0.0, 0.0f64);
    for seed in 1..=10 {
        let findings = found(run(&STATIONS, 0.3, seed)).unwrap();
        for ((off, u), expected) in errors_mm(&findings).iter().zip(expected_mm()) {
            for k in 0..3 {
                let z = (off[k] - expected[k]) / u[k];
                (squares, count, largest) = (squares + z * z, count + 1.0, largest.max(z.abs()));
            }
        }
    }
    let rms = f64::sqrt(squares / count);
    assert!((0.8..1.2).contains(&rms) && largest < 4.5, "{rms} {largest}");
}

#[test]
fn three_stations_and_stations_in_one_plane_are_refused() {
    let check = |run: Run, expected: &str| {
        let error = found(run).unwrap_err();
        assert!(matches!(error, MethodError::Lacks { .. }), "{error}");
        assert!(error.to_string().contains(expected), "{error}");
    };
    check(run(&STATIONS[..3], 0.3, 1), "3 stations with the reflector");
    let mut flat = STATIONS;
    flat[3][2] = -120.0;
    check(run(&flat, 0.3, 1), "the 4 stations lie in one plane. It needs");
    // Entered off a plane by less than a millimetre, and standing in it.
    for (station, off) in flat.iter_mut().zip([0.6, -1.0, 0.2, 0.7]) {
        station[2] -= off;
    }
    check(run(&flat, 0.3, 1), "the 4 stations lie in one plane within u of their places");
}

/// What normal equations leave of a step where the stations hardly determine it is more than a nanometre and nothing against u.
#[test]
fn stations_hardly_off_a_plane_are_solved() {
    for (height_mm, seed) in
        [2.0, 5.0, 10.0, 20.0, 50.0].into_iter().flat_map(|height| [(height, 1), (height, 2)])
    {
        let mut stations = STATIONS;
        stations[3][2] = -120.0 + height_mm;
        let solved = found(run(&stations, 0.3, seed));
        assert!(solved.is_ok(), "{height_mm} mm, {seed}: {}", solved.unwrap_err());
    }
}

/// Places of one station that did not see all: the others still count.
#[test]
fn a_target_that_three_stations_saw_is_left_out_with_a_sentence() {
    let mut run = run(&STATIONS, 0.0, 1);
    run.points.remove(0);
    let findings = found(run).unwrap();
    assert_eq!(findings.tables[0].rows.len(), targets().len() - 1);
    assert!(
        findings.notes.iter().any(|note| note.contains("1 targets") || note.contains("1 target")),
        "{:?}",
        findings.notes
    );
}
