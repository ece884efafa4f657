//! Walks the registry and the catalogue directory: what every effect must keep.

use nalgebra::{DMatrix, Point3, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use trunnion_core::{AxisLetter, AxisValues, State, Twist};
use trunnion_effects::catalogue::{BASE, LOCATION_ERRORS, REGISTRY, effect as effect_of};
use trunnion_effects::{Checked, Instance, Need, Role, Scene, SceneSetup, r_test_reading};
use trunnion_machine::{Errors, JointErrors, Machine, Site, shipped};

const DIRECTORY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/catalogue");

fn machines() -> Vec<Machine> {
    let other = [
        ("robot", include_str!("../../../machine/tests/data/robot.toml")),
        ("two-carriages", include_str!("../../../machine/tests/data/two-carriages.toml")),
    ]
    .map(|(name, text)| Machine::parse(name, name, text).expect("a machine of other joints"));
    shipped::FILES.iter().map(|(name, _)| shipped::machine(name).expect("shipped")).chain(other).collect()
}

/// State of a rich scene from which on the rotary axes stand at one pose.
const AT_ONE_POSE_FROM: usize = 60;

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
    (0..75)
        .map(|i| {
            let way = if i % 2 == 0 { 1.0 } else { -1.0 };
            let moving = f64::from(u8::from(i % 3 != 0));
            State {
                position: AxisValues::of(machine.joints(), |l| {
                    if l.is_rotary() { place(i.min(AT_ONE_POSE_FROM), l) } else { place(i, l) }
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
    let registry: BTreeSet<String> = registered.iter().cloned().collect();
    let missing: Vec<&String> = files.difference(&registry).collect();
    assert!(
        missing.is_empty(),
        "{missing:?}: no line in REGISTRY, or phenomenon is not the name of the file"
    );
    assert_eq!(files, registry);
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
fn the_base_model_is_location_errors_and_setting() {
    let roles = BASE.map(|id| effect_of(id).unwrap().role);
    assert_eq!((BASE[0], roles), (LOCATION_ERRORS, [Role::Location, Role::Setting]));
    let first: Vec<&str> = REGISTRY.iter().take(2).map(|effect| effect.phenomenon).collect();
    assert_eq!(first, BASE, "{first:?}");
    for effect in REGISTRY {
        let price_ln = effect.role.price_ln();
        // Beyond odds of a million no data would ever name it.
        assert!((0.0..14.0).contains(&price_ln), "{}: {price_ln}", effect.phenomenon);
    }
}

#[test]
fn every_effect_has_a_golden_case_and_reads_what_it_says() {
    let bc = Instance::all(&shipped::machine("table-bc").unwrap());
    let mut wrong = Vec::new();
    for effect in REGISTRY {
        let (id, golden) = (effect.phenomenon, &effect.golden);
        let own: Vec<String> = bc
            .iter()
            .filter(|instance| effect_of(&instance.id()).unwrap().phenomenon == id)
            .map(Instance::id)
            .collect();
        if let Some(foreign) = [golden.id, effect.example.id].iter().find(|one| own.iter().all(|o| o != *one))
        {
            wrong.push(format!("{id}: \"{foreign}\" is none of its ids on machine table-bc, {own:?}"));
            continue;
        }
        if golden.source.len() < 3 || golden.derivation.len() < 20 {
            wrong.push(format!("{id}: no source or no derivation"));
        }
        if let Some(flaw) = golden.flaw() {
            wrong.push(format!("{id}: {flaw}"));
            continue;
        }
        let checked = golden.check();
        let largest_um = checked.iter().map(|one| one.expected_um.amax()).fold(0.0, f64::max);
        if largest_um == 0.0 {
            wrong.push(format!("{id}: no moment expects a reading other than zero"));
            continue;
        }
        // A tenth: a case that looser numbers would pass proves no sign and no unit.
        if !(1e-9..=0.1 * largest_um).contains(&golden.within_um) {
            wrong.push(format!("{id}: {largest_um} µm within {} µm is no proof", golden.within_um));
        }
        for (k, Checked { expected_um, found_um }) in checked.iter().enumerate() {
            if (found_um - expected_um).amax() > golden.within_um {
                let [expected_um, found_um] = [expected_um, found_um].map(|v| [v.x, v.y, v.z]);
                wrong.push(format!("{id}, reading {k}: {expected_um:?} µm expected, {found_um:?} found"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn ids_that_model_files_hold_stay_in_the_catalogue() {
    // On a machine with tilting B and turning C. A new effect needs no entry here; docs/design/catalogue.md lists all.
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
    let gone: Vec<&String> = expected.difference(&found).collect();
    assert!(gone.is_empty(), "model files with {gone:?} would not be read any more");
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
    let machine = shipped::machine("table-bc").unwrap();
    let scene = scene(&machine, &rich_states(&machine));
    for (effect, picture) in REGISTRY.iter().zip(&pictures) {
        assert_eq!(effect.example.id.split(':').next(), Some(effect.phenomenon));
        let svg = &picture.svg;
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", effect.phenomenon);
        // A flat line of nothing would be no signature: some path leaves its first height.
        assert!(svg.contains("<path") && svg.len() > 1500, "{}", effect.phenomenon);
        let instance = Instance::find(effect.example.id, &machine).unwrap();
        let names: Vec<String> = instance.parameters(&scene).into_iter().map(|p| p.name).collect();
        for (name, value) in effect.example.values {
            assert!(
                names.iter().any(|known| known == name),
                "{}: {name} is none of {names:?}",
                effect.phenomenon
            );
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
    let unknown = Instance::find("gravity-sga", &machines()[0]).unwrap_err().to_string();
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
    let reach = in_reach(&machine, &states);
    let of = |ids: &[&str], within: bool| {
        for id in ids {
            assert_eq!(reach[*id], within, "{id}");
        }
    };
    of(
        &[
            "location-errors",
            "ball-setting",
            "artefact-form",
            "ball-form",
            "straightness:X",
            "linear-scale:X",
        ],
        true,
    );
    of(&["gravity-sag:B", "encoder-eccentricity:B", "drive-pitch:B", "radial-error-motion:B"], true);
    of(&["straightness:Y", "linear-scale:Y", "component-errors:X", "unbalance:C", "drive-pitch:C"], false);
    of(&["backlash:B", "direction-shift:B", "thermal-drift", "thermal-expansion", "spindle-growth"], false);
    of(&["servo-lag:X", "sync-delay", "clamp-shift:B", "probe-gain", "nest-rotation", "vibration"], false);
}

#[test]
fn an_effect_needs_its_own_kind_of_evidence() {
    let machine = shipped::machine("table-bc").unwrap();
    let check = |lacking: &[Need], poorer: &dyn Fn(&mut State)| {
        let mut states = rich_states(&machine);
        states.iter_mut().for_each(poorer);
        let scene = scene(&machine, &states);
        let mut lost = 0;
        for instance in Instance::all(&machine) {
            let needs = instance.about().unwrap().needs;
            let lacks = needs.iter().any(|need| lacking.contains(need));
            assert_eq!(instance.parameters(&scene).is_empty(), lacks, "{} {lacking:?}", instance.id());
            lost += usize::from(lacks);
        }
        assert!(lost > 0, "nothing needs {lacking:?}");
    };
    check(&[Need::TimeStamps], &|s| s.time_s = None);
    check(&[Need::TimeStamps], &|s| s.time_s = Some(5.0));
    check(&[Need::Temperature], &|s| s.temperature_degc = vec![20.0]);
    check(&[Need::BothDirections], &|s| s.direction = AxisValues::from_fn(|_| 1.0));
    check(&[Need::Deflection], &|s| s.deflection_mm = Vector3::zeros());
    check(&[Need::OnTheFly, Need::ChangingSpeed, Need::RestAndMotion, Need::DelayShows], &|s| {
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

/// What the exact kinematics read: spindle-side against table-side ball in table axes, mm.
fn exact_reading(
    machine: &Machine,
    state: &State,
    [table_ball, spindle_ball]: [Point3<f64>; 2],
    errors: &Errors,
) -> Vector3<f64> {
    let machine_from_table = machine.machine_from_table(&state.position, &errors.joints);
    let machine_from_tool = machine.machine_from_tool(&state.position, &errors.joints);
    let spindle_ball_in_machine = machine_from_tool * (spindle_ball + errors.spindle_ball_mm);
    let apart = machine_from_table.inverse() * spindle_ball_in_machine - table_ball;
    apart - errors.table_ball.translation_mm + errors.reading_mm
}

#[test]
fn columns_match_differences_of_the_exact_kinematics() {
    /// Size of the twists that are put in, mm and rad. Central differences are exact to its square, rounding to 1e-8.
    const STEP: f64 = 1e-5;
    for machine in machines() {
        let states = rich_states(&machine);
        let scene = scene(&machine, &states);
        let table_ball = scene.setups[0].ball_in_table_mm;
        for (instance, state) in Instance::all(&machine)
            .iter()
            .flat_map(|instance| states.iter().step_by(7).map(move |s| (instance, s)))
        {
            // The balls are together, as the nest holds them.
            let none = JointErrors::default();
            let machine_from_table = machine.machine_from_table(&state.position, &none);
            let machine_from_tool = machine.machine_from_tool(&state.position, &none);
            let spindle_ball = machine_from_tool.inverse() * (machine_from_table * table_ball);
            for shape in instance.shapes(&scene).grid.iter().step_by(3) {
                let parameters = instance.parameters(&scene).len();
                let (mut columns, mut twists) =
                    (vec![Vector3::zeros(); parameters], vec![Vec::new(); parameters]);
                r_test_reading(instance, &scene, shape, state, spindle_ball, &mut |i, read| {
                    columns[i] += read
                });
                instance.motions(&scene, shape, state, &mut |i, site, twist| twists[i].push((site, twist)));
                for (column, twists) in columns.iter().zip(&twists) {
                    let size = |twist: &Twist| twist.translation_mm.norm() + twist.rotation_rad.norm();
                    let largest = twists.iter().map(|(_, twist)| size(twist)).fold(0.0, f64::max);
                    if largest == 0.0 {
                        continue;
                    }
                    let read = |way: f64| {
                        let mut errors = Errors::default();
                        twists
                            .iter()
                            .for_each(|(site, twist)| errors.add(*site, *twist * (way * STEP / largest)));
                        exact_reading(&machine, state, [table_ball, spindle_ball], &errors)
                    };
                    let difference = (read(1.0) - read(-1.0)) * (largest / (2.0 * STEP));
                    let off = (column - difference).norm();
                    let size = largest * (1.0 + table_ball.coords.norm() + spindle_ball.coords.norm());
                    assert!(
                        off < 1e-7 * size,
                        "{} {} {shape:?}: {column} by columns, {difference} by differences",
                        machine.name,
                        instance.id()
                    );
                }
            }
        }
    }
}

#[test]
fn the_catalogue_document_and_its_pictures_are_current() {
    const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/design");
    let found = |file: String| std::fs::read_to_string(Path::new(DOCS).join(file)).unwrap_or_default();
    let again = "is not current: cargo run -p trunnion-effects --example catalogue";
    assert!(
        found("catalogue.md".into()) == trunnion_effects::catalogue_markdown(),
        "docs/design/catalogue.md {again}"
    );
    let pictures = trunnion_effects::catalogue_pictures();
    for picture in &pictures {
        let file = format!("catalogue/{}", picture.file);
        assert!(found(file.clone()) == picture.svg, "docs/design/{file} {again}");
    }
    let files = std::fs::read_dir(Path::new(DOCS).join("catalogue")).unwrap().count();
    assert_eq!(files, pictures.len(), "docs/design/catalogue holds pictures of no effect");
}

/// Sine of the largest angle between what two effects leave beyond the base model, below which they are one: of 100 µm of
/// either, 0.1 µm is left, the repeatability of a good probe at rest. Rounding leaves 1e-12; the nearest pair of the
/// catalogue, a reversal spike of 10° and backlash, is 0.3 apart.
const ONE_AND_THE_SAME: f64 = 1e-3;

/// Spindle-side ball of each setup: below the pivot of a head at two tool lengths, once off the line of the spindle.
const SPINDLE_BALLS_IN_TOOL_MM: [Point3<f64>; 3] =
    [Point3::new(0.0, 0.0, -120.0), Point3::new(0.0, 0.0, -220.0), Point3::new(30.0, 20.0, -120.0)];

/// Columns of an instance over all readings of a rich scene, for one shape.
fn columns(instance: &Instance, scene: &Scene, shape: &[f64], states: &[State]) -> DMatrix<f64> {
    let mut columns = DMatrix::zeros(3 * states.len(), instance.parameters(scene).len());
    for (point, state) in states.iter().enumerate() {
        let spindle_ball_in_tool_mm = SPINDLE_BALLS_IN_TOOL_MM[state.setup];
        r_test_reading(instance, scene, shape, state, spindle_ball_in_tool_mm, &mut |i, reading| {
            let mut rows = columns.view_mut((3 * point, i), (3, 1));
            rows += reading;
        });
    }
    columns
}

/// Orthonormal basis of the span of columns, each taken at length 1.
fn span(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    let longest = columns.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
    columns.column_iter_mut().filter(|c| c.norm() > 1e-9 * longest).for_each(|mut c| {
        c.normalize_mut();
    });
    let svd = columns.svd(true, false);
    let kept = svd.singular_values.iter().filter(|s| **s > 1e-6).count();
    svd.u.expect("asked for").columns(0, kept).into_owned()
}

/// Three setups at two heights and two radii, both targets of a plate, rotary and linear axes at rest and in motion, each
/// axis with places, directions, speeds, accelerations and travel since its reversal of its own, temperatures, over time.
fn rich_scene(machine: &Machine) -> (Scene, Vec<State>) {
    // Steps by roots of primes: no two axes, and no two multiples of their angles, ever go together.
    let roots = [2.0f64, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0].map(f64::sqrt);
    let mut states = rich_states(machine);
    for (i, state) in states.iter_mut().enumerate() {
        let share = |letter: AxisLetter, use_of: usize| {
            (0.5 + i as f64 * roots[(letter.index() + use_of) % roots.len()] * (1 + use_of) as f64).fract()
        };
        let way = |letter| if share(letter, 1) < 0.5 { -1.0 } else { 1.0 };
        let speed = |letter| if i % 3 == 0 { 0.0 } else { 0.1 + share(letter, 2) };
        state.setup = i % 4 % 3;
        state.target = i % 5 % 2;
        let stands = i >= AT_ONE_POSE_FROM;
        state.position = AxisValues::of(machine.joints(), |letter| match machine.axis(letter) {
            Some(axis) if !(stands && letter.is_rotary()) => {
                axis.travel.0 + (axis.travel.1 - axis.travel.0) * share(letter, 0)
            }
            _ => state.position[letter],
        });
        state.direction = AxisValues::of(machine.joints(), way);
        state.velocity = AxisValues::of(machine.joints(), |letter| way(letter) * speed(letter));
        state.acceleration =
            AxisValues::of(machine.joints(), |letter| speed(letter) * (share(letter, 3) - 0.5));
        // Just after a reversal and long after it.
        let longest = |letter: AxisLetter| if letter.is_rotary() { 0.3 } else { 10.0 };
        state.since_reversal =
            AxisValues::of(machine.joints(), |letter| longest(letter) * share(letter, 4).powi(3));
    }
    let setups = [("low", [150.0, 0.0, 60.0]), ("high", [150.0, 0.0, 160.0]), ("inner", [40.0, 60.0, 60.0])]
        .map(|(name, ball_mm)| SceneSetup::r_test(name, Point3::from(ball_mm)).with_plate());
    let scene = Scene::new(machine.clone(), setups.into(), vec!["frame".into()], states.iter());
    (scene, states)
}

/// Part of columns that a span does not hold, as an orthonormal basis.
fn beyond(base: &DMatrix<f64>, basis: &DMatrix<f64>) -> DMatrix<f64> {
    let svd = (basis - base * base.tr_mul(basis)).svd(true, false);
    let kept = svd.singular_values.iter().filter(|s| **s > ONE_AND_THE_SAME).count();
    svd.u.expect("asked for").columns(0, kept).into_owned()
}

#[test]
fn no_effect_is_another_by_a_second_name_or_hidden_behind_the_base_model() {
    let mut same = Vec::new();
    for machine in machines() {
        let (scene, states) = rich_scene(&machine);
        let of_base = |id| columns(&Instance::find(id, &machine).unwrap(), &scene, &[], &states);
        let base = BASE.map(of_base);
        let base =
            span(DMatrix::from_columns(&base.iter().flat_map(|b| b.column_iter()).collect::<Vec<_>>()));
        let mut seen: Vec<(String, DMatrix<f64>)> = Vec::new();
        for instance in Instance::all(&machine).into_iter().filter(|instance| !instance.is_base()) {
            for shape in instance.shapes(&scene).grid {
                let all = span(columns(&instance, &scene, &shape, &states));
                let id = format!("{} {shape:?}", instance.id());
                let left = beyond(&base, &all);
                if left.is_empty() {
                    same.push(format!("{}: the base model holds all of {id}", machine.name));
                } else {
                    seen.push((id, left));
                }
            }
        }
        let instance = |id: &str| id.split(' ').next().map(String::from);
        for (k, (one, a)) in seen.iter().enumerate() {
            for (other, b) in &seen[..k] {
                if instance(one) != instance(other) && a.ncols() == b.ncols() {
                    let sine = (a - b * b.tr_mul(a)).svd(false, false).singular_values.max();
                    if sine < ONE_AND_THE_SAME {
                        same.push(format!(
                            "{}: {one} is {other}, sine of their angle {sine:.1e}",
                            machine.name
                        ));
                    }
                }
            }
        }
    }
    assert!(same.is_empty(), "{}", same.join("\n"));
}
