//! Walks the registry and the catalogue directory: what every effect must keep.

use nalgebra::{Point3, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use trunnion_core::{AxisLetter, AxisValues, State, Twist};
use trunnion_effects::catalogue::{BASE, REGISTRY};
use trunnion_effects::{Instance, Need, Scene, SceneSetup};
use trunnion_machine::{Machine, Site, shipped};

const DIRECTORY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/catalogue");

fn machines() -> Vec<Machine> {
    let other = [
        ("robot", include_str!("../../machine/tests/data/robot.toml")),
        ("two-carriages", include_str!("../../machine/tests/data/two-carriages.toml")),
    ]
    .map(|(name, text)| Machine::parse(name, name, text).expect("a machine of other joints"));
    shipped::FILES.iter().map(|(name, _)| shipped::machine(name).expect("shipped")).chain(other).collect()
}

/// States all over the travels of the machine, at rest and in motion, both ways, with time and a temperature.
fn rich_states(machine: &Machine) -> Vec<State> {
    let place = |i: usize, letter: AxisLetter| {
        let (low, high) = machine.axis(letter).map_or((0.0, 0.0), |axis| axis.travel);
        let golden = (0.5 + (i * (letter.index() + 1)) as f64 * 0.618_033_988_75).fract();
        low + (high - low)
            * if i == 0 {
                0.0
            } else if i == 1 {
                1.0
            } else {
                golden
            }
    };
    // From 60 on at one pose of the rotary axes.
    (0..75)
        .map(|i| {
            let way = if i % 2 == 0 { 1.0 } else { -1.0 };
            let moving = f64::from(u8::from(i % 3 != 0));
            State {
                position: AxisValues::of(machine.joints(), |l| {
                    if l.is_rotary() { place(i.min(60), l) } else { place(i, l) }
                }),
                direction: AxisValues::from_fn(|l| if (l.index()).is_multiple_of(2) { way } else { -way }),
                velocity: AxisValues::from_fn(|l| moving * way * (l.index() + 1) as f64 * 0.1),
                acceleration: AxisValues::from_fn(|l| moving * (i as f64 * 0.7 + l.index() as f64).sin()),
                since_reversal: AxisValues::from_fn(|_| i as f64 * 0.01),
                time_s: Some(i as f64 * 60.0),
                temperature_degc: vec![20.0 + (i as f64 / 10.0).sin()],
                setup: 0,
                target: i % 2,
                deflection_mm: Vector3::new(0.1, -0.05, 0.02) * (i as f64).cos(),
            }
        })
        .collect()
}

fn scene(machine: &Machine, states: &[State]) -> Scene {
    let setup = SceneSetup::r_test("low", Point3::new(150.0, 0.0, 60.0)).with_plate();
    let channels = states[0].temperature_degc.iter().map(|_| "frame".to_string()).collect();
    Scene::new(machine.clone(), vec![setup], channels, states.iter())
}

fn each_motion(
    instance: &Instance,
    scene: &Scene,
    states: &[State],
    mut check: impl FnMut(&[f64], usize, Site, Twist),
) {
    for shape in &instance.shapes(scene).grid {
        for state in states {
            instance.motions(scene, shape, state, &mut |i, site, twist| check(shape, i, site, twist));
        }
    }
}

#[test]
fn every_file_of_the_directory_is_registered_under_its_name() {
    let files: BTreeSet<String> = std::fs::read_dir(DIRECTORY)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().replace('_', "-"))
        .collect();
    let registered: Vec<String> = REGISTRY.iter().map(|effect| effect.phenomenon.into()).collect();
    assert_eq!(files, registered.iter().cloned().collect());
    assert_eq!(files.len(), registered.len(), "an effect is registered twice");
}

#[test]
fn every_effect_says_what_it_is() {
    for effect in REGISTRY {
        let about = &effect.about;
        let texts = [
            about.title,
            about.source,
            about.equation,
            about.symbols,
            about.validity,
            about.typical,
            about.explanation,
            about.cause,
            about.seen_by,
        ];
        assert!(texts.iter().all(|text| text.len() > 2), "{}", effect.phenomenon);
        assert_eq!(BASE.contains(&effect.phenomenon), about.needs.is_empty(), "{}", effect.phenomenon);
        assert!(!about.helps.is_empty(), "{}", effect.phenomenon);
        let file = Path::new(DIRECTORY).join(format!("{}.rs", effect.phenomenon.replace('-', "_")));
        let code = std::fs::read_to_string(file).unwrap();
        let header: String = code.lines().take_while(|line| line.starts_with("//!")).collect();
        assert!(header.contains("Limits:") || header.contains("limits"), "{}", effect.phenomenon);
        assert!(header.contains('['), "{} names no source", effect.phenomenon);
    }
}

#[test]
fn the_catalogue_has_every_id_of_the_design() {
    // DESIGN §3.1, with the axes each belongs to on a machine with tilting B and turning C.
    let (rotary, linear, all) = (["B", "C"], ["X", "Y", "Z"], ["X", "Y", "Z", "B", "C"]);
    let of = |phenomena: &[&str], axes: &[&str]| -> Vec<String> {
        phenomena.iter().flat_map(|p| axes.iter().map(move |axis| format!("{p}:{axis}"))).collect()
    };
    let mut expected: BTreeSet<String> = [
        "location-errors",
        "ball-setting",
        "gravity-sag:B",
        "unbalance:C",
        "thermal-drift",
        "thermal-expansion",
        "spindle-growth",
        "stacked-tilt:C",
        "squareness:YX",
        "squareness:ZX",
        "squareness:ZY",
        "sync-delay",
        "setup-slip",
        "probe-gain",
        "probe-nonlinearity",
        "nest-rotation",
        "ball-form",
        "artefact-form",
        "vibration",
    ]
    .map(String::from)
    .into();
    expected.extend(of(&["backlash", "reversal-spike", "servo-lag", "inertial-deflection"], &all));
    expected.extend(of(&["direction-shift", "encoder-eccentricity", "drive-pitch", "clamp-shift"], &rotary));
    expected.extend(of(&["radial-error-motion", "axial-error-motion", "tilt-error-motion"], &rotary));
    expected.extend(of(
        &["linear-scale", "straightness", "angular-motion", "component-errors", "ballscrew-pitch"],
        &linear,
    ));
    let machine = shipped::machine("table-bc").unwrap();
    let found: BTreeSet<String> = Instance::all(&machine).iter().map(Instance::id).collect();
    assert_eq!(found, expected);
    let machine = shipped::machine("table-ac").unwrap();
    let found: BTreeSet<String> = Instance::all(&machine).iter().map(Instance::id).collect();
    assert!(found.contains("gravity-sag:A") && !found.contains("gravity-sag:B"), "{found:?}");
}

/// Takes something from the state with this number.
type Poorer = &'static dyn Fn(usize, &mut State);

#[test]
fn an_effect_is_out_of_reach_exactly_when_the_data_lack_one_of_its_needs() {
    let poorer: [Poorer; 9] = [
        &|_, _| {},
        &|_, s| s.time_s = None,
        &|_, s| s.temperature_degc = vec![20.0],
        &|_, s| s.direction = AxisValues::from_fn(|_| 1.0),
        &|_, s| s.deflection_mm = Vector3::zeros(),
        &|_, s| s.velocity = AxisValues::default(),
        &|_, s| {
            s.velocity = AxisValues::from_fn(|_| 0.5);
            s.acceleration = AxisValues::default();
        },
        &|_, s| s.position[AxisLetter::B] = 0.3,
        &|i, s| {
            // Each state moves linear axes or rotary axes, never both.
            s.velocity =
                AxisValues::from_fn(|l| if l.is_rotary() == (i % 2 == 0) { s.velocity[l] } else { 0.0 });
        },
    ];
    for machine in machines() {
        for (case, make_poorer) in poorer.iter().enumerate() {
            let mut states = rich_states(&machine);
            states.iter_mut().enumerate().for_each(|(i, state)| make_poorer(i, state));
            let scene = scene(&machine, &states);
            for instance in Instance::all(&machine) {
                let why = instance.out_of_reach(&scene);
                let empty = instance.parameters(&scene).is_empty();
                assert_eq!(why.is_some(), empty, "{} {} case {case}: {why:?}", machine.name, instance.id());
            }
        }
    }
    assert!(Need::ALL.iter().all(|need| need.text().len() > 5));
}

#[test]
fn every_example_is_an_effect_of_the_machine_and_can_be_drawn() {
    let pictures = trunnion_effects::catalogue_pictures();
    assert_eq!(pictures.len(), REGISTRY.len());
    for (effect, picture) in REGISTRY.iter().zip(&pictures) {
        assert_eq!(effect.example.id.split(':').next(), Some(effect.phenomenon));
        let svg = &picture.svg;
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", effect.phenomenon);
        // A flat line of nothing would be no signature: some path leaves its first height.
        assert!(svg.contains("<path") && svg.len() > 1500, "{}", effect.phenomenon);
        for (name, value) in effect.example.values {
            assert!(*value != 0.0, "{}: {name}", effect.phenomenon);
        }
    }
}

#[test]
fn ids_and_parameter_names_are_unique_and_ids_lead_back() {
    for machine in machines() {
        let scene = scene(&machine, &rich_states(&machine));
        let mut ids = BTreeSet::new();
        for instance in Instance::all(&machine) {
            assert!(ids.insert(instance.id()), "{} twice", instance.id());
            assert_eq!(Instance::find(&instance.id(), &machine).unwrap().id(), instance.id());
            let names: Vec<_> = instance.parameters(&scene).into_iter().map(|p| p.name).collect();
            let unique: BTreeSet<_> = names.iter().collect();
            assert_eq!(unique.len(), names.len(), "{} {names:?}", instance.id());
        }
    }
    let unknown = Instance::find("sag", &machines()[0]).unwrap_err().to_string();
    assert!(unknown.contains("gravity-sag:B"), "{unknown}");
}

#[test]
fn motions_are_finite_within_bounds_and_every_parameter_moves_something() {
    for machine in machines() {
        let states = rich_states(&machine);
        let scene = scene(&machine, &states);
        for instance in Instance::all(&machine) {
            let id = instance.id();
            let parameters = instance.parameters(&scene);
            assert!(!parameters.is_empty(), "{} {id}: nothing to fit in a rich scene", machine.name);
            let shapes = instance.shapes(&scene);
            assert!(!shapes.grid.is_empty(), "{id}");
            assert!(shapes.grid.iter().all(|point| point.len() == shapes.names.len()), "{id}");
            let mut moved = BTreeSet::new();
            each_motion(&instance, &scene, &states, |shape, i, site, twist| {
                let all = [twist.translation_mm, twist.rotation_rad];
                assert!(all.iter().all(|v| v.iter().all(|x| x.is_finite())), "{id} {shape:?}");
                assert!(i < parameters.len(), "{id}: parameter {i} of {}", parameters.len());
                match site {
                    Site::Joint(letter) => assert!(machine.axis(letter).is_some(), "{id}"),
                    _ => assert_eq!(twist.rotation_rad, Vector3::zeros(), "{id} turns a point"),
                }
                if all.iter().any(|v| v.norm() > 1e-12) {
                    moved.insert(i);
                }
            });
            assert_eq!(moved.len(), parameters.len(), "{} {id} moves only {moved:?}", machine.name);
        }
    }
}

/// Phenomena with parameters in a scene, out of those the machine can have.
fn in_reach(machine: &Machine, states: &[State]) -> BTreeMap<String, bool> {
    let scene = scene(machine, states);
    Instance::all(machine).iter().map(|i| (i.id(), !i.parameters(&scene).is_empty())).collect()
}

#[test]
fn what_a_scene_cannot_show_is_out_of_reach() {
    let machine = shipped::machine("table-bc").unwrap();
    // Static points without time, temperature or direction; C never moves.
    let states: Vec<State> = (0..5)
        .map(|i| {
            let mut state = State::default();
            state.position[AxisLetter::B] = f64::from(i) * 0.3;
            state.position[AxisLetter::X] = f64::from(i) * 10.0;
            state
        })
        .collect();
    let seen: Vec<String> =
        in_reach(&machine, &states).into_iter().filter(|(_, reach)| *reach).map(|(id, _)| id).collect();
    assert_eq!(
        seen,
        [
            "angular-motion:X",
            "artefact-form",
            "axial-error-motion:B",
            "ball-form",
            "ball-setting",
            "ballscrew-pitch:X",
            "drive-pitch:B",
            "encoder-eccentricity:B",
            "gravity-sag:B",
            "linear-scale:X",
            "location-errors",
            "radial-error-motion:B",
            "straightness:X",
            "tilt-error-motion:B",
        ]
    );
}

#[test]
fn an_effect_needs_its_own_kind_of_evidence() {
    let machine = shipped::machine("table-bc").unwrap();
    let check = |needs: &[&str], poorer: &dyn Fn(&mut State)| {
        let mut states = rich_states(&machine);
        states.iter_mut().for_each(poorer);
        let reach = in_reach(&machine, &states);
        for (id, reach) in reach {
            let phenomenon = id.split(':').next().unwrap();
            assert_eq!(reach, !needs.contains(&phenomenon), "{id}");
        }
    };
    let timed = ["thermal-drift", "spindle-growth", "setup-slip", "vibration"];
    check(&timed, &|s| s.time_s = None);
    check(&timed, &|s| s.time_s = Some(5.0));
    check(&["thermal-expansion"], &|s| s.temperature_degc = vec![20.0]);
    check(&["backlash", "direction-shift", "reversal-spike"], &|s| {
        s.direction = AxisValues::from_fn(|_| 1.0)
    });
    check(&["probe-gain", "probe-nonlinearity", "nest-rotation"], &|s| s.deflection_mm = Vector3::zeros());
    let in_motion =
        ["reversal-spike", "servo-lag", "sync-delay", "inertial-deflection", "clamp-shift", "vibration"];
    check(&in_motion, &|s| {
        s.velocity = AxisValues::default();
        s.acceleration = AxisValues::default();
    });
}

#[test]
fn effects_that_start_at_zero_are_zero_at_the_start() {
    for machine in machines() {
        let mut states = rich_states(&machine);
        states[0] = State { time_s: Some(0.0), temperature_degc: vec![20.0], ..State::default() };
        let scene = scene(&machine, &states);
        for instance in Instance::all(&machine) {
            let id = instance.id();
            let starts_at_zero = [
                "gravity-sag",
                "thermal",
                "spindle-growth",
                "setup-slip",
                "linear-scale",
                "squareness",
                "stacked-tilt",
                "backlash",
                "servo-lag",
                "sync-delay",
                "inertial-deflection",
                "probe",
                "nest",
            ];
            if starts_at_zero.iter().any(|name| id.starts_with(name)) {
                each_motion(&instance, &scene, &states[..1], |shape, i, _, twist| {
                    let size = twist.translation_mm.norm() + twist.rotation_rad.norm();
                    assert!(size < 1e-12, "{id} {shape:?} parameter {i}: {size}");
                });
            }
        }
    }
}

#[test]
fn the_catalogue_document_and_its_pictures_are_current() {
    const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");
    let found = |file: String| std::fs::read_to_string(Path::new(DOCS).join(file)).unwrap_or_default();
    let again = "is not current: cargo run -p trunnion-effects --example catalogue";
    assert!(
        found("catalogue.md".into()) == trunnion_effects::catalogue_markdown(),
        "docs/catalogue.md {again}"
    );
    let pictures = trunnion_effects::catalogue_pictures();
    for picture in &pictures {
        let file = format!("catalogue/{}", picture.file);
        assert!(found(file.clone()) == picture.svg, "docs/{file} {again}");
    }
    let files = std::fs::read_dir(Path::new(DOCS).join("catalogue")).unwrap().count();
    assert_eq!(files, pictures.len(), "docs/catalogue holds pictures of no effect");
}
