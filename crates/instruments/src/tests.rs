use super::*;
use nalgebra::{Point3, Unit, Vector3};
use trunnion_core::{Artefact, Joint, NestSide, Target};
use trunnion_core::{AxisValues, InstrumentKind, Setup, State, Twist};
use trunnion_machine::{Errors, MOST_INNER, Site, shipped};

/// A setup of this kind with all it needs.
pub(crate) fn setup_of(kind: InstrumentKind) -> Setup {
    let target = |name: &str, at: [f64; 3]| Target {
        name: name.into(),
        at_mm: Vector3::from(at),
        normal: kind.has_normals().then(|| Unit::new_normalize(Vector3::new(1.0, -0.4, 0.3))),
    };
    let artefact = Artefact {
        name: "column".into(),
        turned_rad: Vector3::new(0.3, -0.2, 1.0),
        targets: vec![target("1", [0.0; 3]), target("2", [30.0, -10.0, 50.0])],
    };
    Setup {
        bar_length_mm: kind.keeps_bar_length().then_some(100.0),
        ball_in_tool_mm: Point3::new(0.0, 3.0, -40.0),
        direction: Some(Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5))),
        arms_mm: Some([150.0, 170.0]),
        artefact: kind.has_targets().then_some(artefact),
        ..Setup::new("low", kind, NestSide::Table, Point3::new(150.0, 20.0, 60.0))
    }
}

fn setups() -> Vec<Setup> {
    let spindle = Setup { nest: NestSide::Spindle, ..setup_of(InstrumentKind::RTest) };
    InstrumentKind::NAMES.into_iter().map(|(_, kind)| setup_of(kind)).chain([spindle]).collect()
}

#[test]
fn every_kind_of_instrument_is_registered_once() {
    assert_eq!(
        REGISTRY.len(),
        InstrumentKind::NAMES.len(),
        "a kind without a row of ROWS in crates/core/src/kind.rs"
    );
    for (_, kind) in InstrumentKind::NAMES {
        assert_eq!(
            REGISTRY.iter().filter(|instrument| instrument.kind == kind).count(),
            1,
            "{} must stand once in REGISTRY of crates/instruments/src/registry.rs",
            kind.name()
        );
    }
}

/// Central differences of the exact prediction against the analytic columns: every instrument, every machine,
/// every site.
#[test]
fn columns_are_the_derivatives_of_the_exact_prediction() {
    let step = 1e-4;
    for (name, _) in shipped::FILES {
        let machine = shipped::machine(name).unwrap();
        for setup in setups() {
            let mut q = AxisValues::default();
            (q[Joint::A], q[Joint::B], q[Joint::C]) = (0.5, -0.8, 2.1);
            let mut q = machine.follow(&q, &setup.ball_in_table_mm).unwrap();
            // Apart, so that turning axes show as well.
            q[Joint::X] += 60.0;
            q[Joint::Z] += 80.0;
            let state = State { position: q, target: setup.targets() - 1, ..State::default() };
            let projector = Projector::new(&machine, &setup, &state);
            let sites = [Site::TableBall, Site::SpindleBall, Site::Reading]
                .into_iter()
                .chain((0..MOST_INNER).map(Site::Instrument))
                .chain(machine.joints().into_iter().map(Site::Joint));
            for site in sites {
                for k in 0..6 {
                    if k >= 3 && !matches!(site, Site::Joint(_) | Site::TableBall) {
                        continue;
                    }
                    let mut unit = Twist::default();
                    if k < 3 {
                        unit.translation_mm[k] = 1.0;
                    } else {
                        unit.rotation_rad[k - 3] = 1.0;
                    }
                    let at = |scale: f64| {
                        let mut errors = Errors::default();
                        errors.add(site, unit * scale);
                        predict(&machine, &setup, &state, &errors)
                    };
                    let difference = (at(step) - at(-step)) / (2.0 * step);
                    let column = projector.column(site, &unit);
                    assert!(
                        (difference - column).norm() < 1e-5,
                        "{name} {setup:?} {site:?} {k}: {difference} {column}"
                    );
                }
            }
        }
    }
}

#[test]
fn every_setting_of_a_mounting_has_a_name_of_its_own() {
    for instrument in REGISTRY {
        let settings = (instrument.settings)(&setup_of(instrument.kind));
        let names: std::collections::BTreeSet<&str> = settings.iter().map(|s| s.name).collect();
        assert_eq!(names.len(), settings.len(), "{}", instrument.kind.name());
    }
}

/// Files of instruments against the registry: a forgotten file fails.
#[test]
fn every_instrument_file_is_registered() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/registry");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        let name = stem.replace('_', "-");
        assert!(REGISTRY.iter().any(|i| i.kind.name() == name), "{name} is in no registry line");
    }
}

/// 1 µrad is 1 µm at the end of one metre, by the definition of µm/m.
#[test]
fn a_level_reads_the_turn_about_its_direction_wherever_the_tool_is() {
    let machine = shipped::machine("three-axis").unwrap();
    let about = |direction: [f64; 3]| Setup {
        direction: Some(Unit::new_normalize(Vector3::from(direction))),
        ..Setup::new("pitch", InstrumentKind::Level, NestSide::Table, Point3::origin())
    };
    let mut errors = Errors::default();
    errors.joints[Joint::X].rotation_rad = Vector3::new(0.0, 10e-6, 0.0);
    let mut state = State::default();
    state.position[Joint::Z] = 250.0;
    assert!((predict(&machine, &about([0.0, 1.0, 0.0]), &state, &errors).x - 10e-3).abs() < 1e-12);
    assert!(predict(&machine, &about([1.0, 0.0, 0.0]), &state, &errors).x.abs() < 1e-9);
}

/// Coordinates in the plane of the plate and nothing across it, by the cyclic order of the letters; a plate turned by ψ about its normal reads
/// (u cos ψ + v sin ψ, v cos ψ − u sin ψ).
#[test]
fn a_grid_plate_reads_the_coordinates_of_its_plane() {
    let machine = shipped::machine("three-axis").unwrap();
    let mut state = State::default();
    (state.position[Joint::X], state.position[Joint::Y], state.position[Joint::Z]) = (3.0, 40.0, 500.0);
    for (normal, expected) in
        [([0.0, 0.0, 1.0], [3.0, 40.0]), ([1.0, 0.0, 0.0], [40.0, 500.0]), ([0.0, 1.0, 0.0], [500.0, 3.0])]
    {
        let setup = Setup {
            direction: Some(Unit::new_normalize(Vector3::from(normal))),
            ..Setup::new("plate", InstrumentKind::CrossGrid, NestSide::Table, Point3::origin())
        };
        let read = predict(&machine, &setup, &state, &Errors::default());
        assert!((read - Vector3::new(expected[0], expected[1], 0.0)).norm() < 1e-12, "{normal:?} {read}");
        let (psi, [u, v]) = (0.01f64, expected);
        let mut errors = Errors::default();
        errors.add(Site::Instrument(0), Twist::translation(Vector3::x() * psi));
        let (sin, cos) = psi.sin_cos();
        let turned = Vector3::new(u * cos + v * sin, v * cos - u * sin, 0.0);
        assert!((predict(&machine, &setup, &state, &errors) - turned).norm() < 1e-12);
    }
}

/// Textbook case: arms of 3 and 4 at a right angle reach 5 away.
#[test]
fn a_passive_arm_reads_the_angles_of_the_3_4_5_triangle() {
    let machine = shipped::machine("three-axis").unwrap();
    let setup = Setup {
        arms_mm: Some([300.0, 400.0]),
        ..Setup::new("arm", InstrumentKind::PassiveArm, NestSide::Table, Point3::origin())
    };
    let mut state = State::default();
    state.position[Joint::X] = 500.0;
    let arcs = predict(&machine, &setup, &state, &Errors::default());
    assert!((arcs.y / 400.0 - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert!((arcs.x / 300.0 + (4.0f64 / 3.0).atan()).abs() < 1e-12);
}
