//! Who keeps the share of two things that the poses cannot distinguish: the location error, whatever is added to it.
//!
//! A number is honest when its parameter takes part in no null direction of all columns together, formed here by a singular value
//! decomposition of its own, except those that end in another's zero by a rule: location errors and settings may contain
//! what was added to them.

use crate::common::{point, run};
use nalgebra::{DMatrix, Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::Twist;
use trunnion_core::axis::iso::{A, B, C};
use trunnion_core::{AxisValues, InstrumentKind, Joint, NestSide, Setup, State};
use trunnion_cycles::Run;
use trunnion_effects::{Instance, Model, ModelEffect, Role, catalogue};
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, Identification, IdentifyError, Status, identify};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Site, shipped};

/// Scaled singular value below which a direction is null, and share from which a parameter takes part in it.
const NULL: f64 = 1e-9;
const TAKES_PART: f64 = 1e-5;

/// How a cycle visits poses.
struct Visits {
    machine: &'static str,
    tilts_deg: &'static [f64],
    heights_mm: &'static [f64],
    both_ways: bool,
}

const CYCLES: [Visits; 4] = [
    Visits {
        machine: "table-bc",
        tilts_deg: &[-90.0, -45.0, 0.0, 45.0],
        heights_mm: &[60.0, 160.0],
        both_ways: true,
    },
    Visits { machine: "table-bc", tilts_deg: &[0.0], heights_mm: &[60.0], both_ways: false },
    Visits { machine: "table-ac", tilts_deg: &[-60.0, 0.0, 30.0], heights_mm: &[80.0], both_ways: true },
    Visits { machine: "head-bc", tilts_deg: &[-30.0, 0.0, 30.0], heights_mm: &[60.0], both_ways: true },
];

/// Readings of a machine with location errors of 20 µm and 50 µrad, a mounting off by 0.3 mm, noise of `noise_um` and linear axes that
/// stop off their place by `scatter_um` and say so.
fn measured(visits: &Visits, noise_um: f64, scatter_um: f64, seed: u64) -> Experiment {
    let machine = shipped::machine(visits.machine).expect("shipped");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut errors = Errors::default();
    for axis in machine.rotary() {
        let shift = Vector3::from_fn(|_, _| 20e-3 * normal());
        let tilt = Vector3::from_fn(|_, _| 50e-6 * normal());
        errors.add(Site::Joint(axis.letter), Twist::translation(shift));
        errors.add(Site::Joint(axis.letter), Twist::rotation(tilt));
    }
    errors.add(Site::TableBall, Twist::translation(Vector3::from_fn(|_, _| 0.3 * normal())));
    let tilting = if machine.axis(A).is_some() { A } else { B };
    let (mut setups, mut points) = (Vec::new(), Vec::new());
    for (setup, height) in visits.heights_mm.iter().enumerate() {
        let ball = Point3::new(150.0, 0.0, *height);
        setups.push(Setup::new(format!("h{setup}"), InstrumentKind::RTest, NestSide::Table, ball));
        for direction in if visits.both_ways { &[1.0, -1.0][..] } else { &[1.0] } {
            for tilt_deg in visits.tilts_deg {
                for k in 0..12 {
                    let mut position = AxisValues::default();
                    position[tilting] = tilt_deg.to_radians();
                    position[C] = (f64::from(k) * 30.0).to_radians();
                    let position = machine.follow(&position, &ball).expect("three linear axes");
                    let mut position = position;
                    Joint::LINEAR.into_iter().for_each(|axis| position[axis] += 1e-3 * scatter_um * normal());
                    let mut state = State { position, setup, ..State::default() };
                    state.time_s = Some(4.0 * points.len() as f64);
                    Joint::ALL.into_iter().for_each(|joint| state.direction[joint] = *direction);
                    let exact = predict(&machine, &setups[setup], &state, &errors);
                    let reading = std::array::from_fn(|i| exact[i] + 1e-3 * noise_um * normal());
                    points.push(point(state, reading));
                }
            }
        }
    }
    let run: Run = run("grid", machine, setups, points);
    Experiment::new(&[run]).expect("points")
}

fn with(effects: &[String], machine: &str) -> Model {
    let mut model = Model::base(machine);
    model.effects.extend(effects.iter().map(|id| ModelEffect { id: id.clone(), ..ModelEffect::default() }));
    model
}

fn keeps_shares(id: &str) -> bool {
    catalogue::effect(id).is_some_and(|effect| matches!(effect.role, Role::Location | Role::Setting))
}

/// Parameters that take part in a null direction of the columns of the fitted model, once the zeros of the datum are out.
fn unseen(experiment: &Experiment, fit: &Identification) -> Vec<bool> {
    let columns: Vec<DMatrix<f64>> = fit
        .effects
        .iter()
        .map(|effect| {
            let instance = Instance::find(&effect.id, experiment.machine()).expect("of the catalogue");
            experiment.columns(&instance, &effect.shape)
        })
        .collect();
    let width = columns.iter().map(DMatrix::ncols).sum();
    let mut all = DMatrix::zeros(experiment.rows().max(width), width);
    let mut first = 0;
    for part in columns {
        all.view_mut((0, first), part.shape()).copy_from(&part);
        first += part.ncols();
    }
    for (mut column, parameter) in all.column_iter_mut().zip(&fit.parameters) {
        let norm = if parameter.status == Status::ZeroByConvention { 0.0 } else { column.norm() };
        column.scale_mut(if norm > 0.0 { norm.recip() } else { 0.0 });
    }
    let svd = all.svd(false, true);
    let (sigma, v_t) = (svd.singular_values, svd.v_t.expect("asked for"));
    let null: Vec<usize> = (0..width).filter(|&i| sigma[i] < NULL * sigma.amax()).collect();
    (0..width).map(|j| null.iter().any(|&i| v_t[(i, j)].abs() > TAKES_PART)).collect()
}

#[test]
fn an_added_effect_takes_no_number_from_the_location_errors_and_has_none_it_cannot_have() {
    let mut confounded = 0;
    for (seed, visits) in CYCLES.iter().enumerate() {
        let experiment = measured(visits, 0.2, 2.0, seed as u64);
        let base = identify(&experiment, &with(&[], visits.machine), &Options::quick()).expect("a fit");
        let ids = Instance::all(experiment.machine()).into_iter().map(|instance| instance.id());
        for id in ids.filter(|id| !keeps_shares(id)) {
            let model = with(std::slice::from_ref(&id), visits.machine);
            let fit = match identify(&experiment, &model, &Options::quick()) {
                Err(IdentifyError::OutOfReach { .. }) => continue,
                fit => fit.unwrap_or_else(|error| panic!("{} {id}: {error}", visits.machine)),
            };
            for before in &base.parameters {
                let after =
                    fit.parameters.iter().find(|p| p.effect == before.effect && p.name == before.name);
                let after = after.expect("a parameter of both");
                assert_eq!(after.status, before.status, "{} next to {id}", before.name);
            }
            let unseen = unseen(&experiment, &fit);
            for (parameter, unseen) in fit.parameters.iter().zip(unseen) {
                let number = parameter.status == Status::Identified;
                if number && parameter.effect == id {
                    assert!(!unseen, "{id}.{} = {:?}", parameter.name, parameter.screen_value());
                } else if number && unseen {
                    assert!(!parameter.stands_alone(), "{} next to {id} contains others", parameter.name);
                }
                confounded += usize::from(unseen && !number && parameter.effect == id);
            }
        }
    }
    // Error motions of one lobe, scales and gains; a cycle in which nothing is confounded would show nothing.
    assert!(confounded > 40, "{confounded} parameters without a number");
}

#[test]
fn the_gain_that_all_probes_share_is_not_seen_without_known_steps() {
    for (noise_um, scatter_um) in [(0.001, 0.0), (0.2, 2.0)] {
        let experiment = measured(&CYCLES[0], noise_um, scatter_um, 9);
        let fit = |effects: &[String]| {
            identify(&experiment, &with(effects, "table-bc"), &Options::default()).expect("a fit")
        };
        let (base, gained) = (fit(&[]), fit(&["probe-gain".into()]));
        for p in gained.parameters.iter().filter(|p| p.effect == "probe-gain") {
            assert_eq!(p.status, Status::Unobservable, "{} {:?}", p.name, p.screen_value());
        }
        for before in base.parameters.iter().filter(|p| p.effect == "location-errors") {
            let after = gained.parameter(&before.name).expect("a parameter of both");
            let (Some(value), Some(u)) = (after.screen_value(), after.screen_u()) else { continue };
            let moved = (value - before.screen_value().expect("it had a number")).abs();
            assert!(moved < 4.0 * u, "{}: moved by {moved}, u {u}", before.name);
            assert!(after.note.ends_with("probe-gain"), "{}: {}", before.name, after.note);
        }
        // What differs from probe to probe is seen.
        let differences: Vec<&str> = gained.seen_together.iter().map(|sum| sum.text.as_str()).collect();
        let is_difference = |text: &&str| text.contains(" - ");
        assert!(differences.len() == 2 && differences.iter().all(is_difference), "{differences:?}");
    }
}
