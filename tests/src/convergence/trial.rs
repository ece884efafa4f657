//! One trial: draw, measure, fit, judge.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{Joint, Point, Quality, Setup, State};
use trunnion_cycles::{Cycle, Pace, Run};
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, FittedParameter, Identification, Status, identify};
use trunnion_hil_sim::physics::{Sampler, VirtualMachine};
use trunnion_hil_sim::truth::{Noise, PlacedSetup};
use trunnion_hil_sim::{SimSetup, Truth};
use trunnion_machine::{Machine, shipped};
use trunnion_methods::recipes::{self, MethodError, MethodOptions};

/// A shipped cycle and the model that docs/measured/schemes.md fits to it; the base model without one.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// File in `config/cycles`.
    pub cycle: &'static str,
    /// File in `config/models`.
    pub model: Option<&'static str>,
}

const fn base(cycle: &'static str) -> Case {
    Case { cycle, model: None }
}

const fn with(cycle: &'static str, model: &'static str) -> Case {
    Case { cycle, model: Some(model) }
}

/// Every instrument and every way of measuring that ships.
pub const CASES: [Case; 53] = [
    base("ball-bar-c"),
    with("ball-plate", "volume"),
    with("ball-plate-self", "self-calibration"),
    base("bk1-a"),
    base("bk1-b"),
    base("bk2-c"),
    base("bk2-c-of-ac"),
    base("bk3-bc"),
    base("bk4-cone"),
    with("circle-xy", "straight-lines-xy"),
    with("circle-yz", "straight-lines-yz"),
    with("circle-zx", "straight-lines-zx"),
    with("cross-grid-circle-xy", "straight-lines-xy"),
    with("cross-grid-circle-yz", "straight-lines-yz"),
    with("cross-grid-circle-zx", "straight-lines-zx"),
    with("cross-grid-small", "straight-lines-xy"),
    with("cross-grid-xy", "plane-xy"),
    with("cross-grid-yz", "plane-yz"),
    with("cross-grid-zx", "plane-zx"),
    base("demo-static"),
    base("demo-sweep-c"),
    with("diagonal", "straight-lines"),
    with("face-diagonal", "straight-lines"),
    base("head-b"),
    base("head-c"),
    base("hybrid-static"),
    with("laser-ball-bar", "straight-lines-bc"),
    with("level", "volume"),
    with("linear-x", "straight-line-x"),
    base("machined-column"),
    base("machined-cone"),
    with("passive-arm", "straight-lines-xy-bc"),
    base("r-test-feeds-c"),
    base("r-test-head-a-table-c"),
    base("r-test-head-bc"),
    base("r-test-head-bc-spindle"),
    base("r-test-interleaved"),
    base("r-test-static"),
    base("r-test-sweep-b"),
    base("r-test-sweep-c"),
    base("r-test-table-bc-spindle"),
    base("r-test-warm-up"),
    base("rotary-values-c"),
    base("s4-b"),
    base("s4-c"),
    with("scale-bar", "straight-lines"),
    with("step-diagonal", "straight-lines"),
    base("touch-probe"),
    base("touch-probe-column"),
    with("tracker", "volume-bc"),
    base("two-height-b"),
    base("two-height-c"),
    base("two-height-c-static"),
];

/// What a trial found wrong.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Kind, for counting.
    pub kind: &'static str,
    /// What was seen.
    pub what: String,
}

/// Largest scatter of recorded positions, standard deviation, mm.
const MOST_SCATTER_MM: f64 = 5e-3;
/// Scatter of a rotary axis for each mm of a linear one: 5 µm seen from 500 mm, the encoder of a good rotary axis.
const RAD_PER_MM: f64 = 2e-3;
/// Points on the fly each second: a cycle becomes some hundreds of points.
const POINTS_PER_S: f64 = 4.0;
/// The ball, station or artefact stands this far from its usual place, mm.
const MOST_MOVED_MM: f64 = 15.0;
/// Machines are up to this much worse or better than usual, and mountings likewise.
const MOST_TIMES: f64 = 10.0;
/// Numbers off by more than this many u are wrong: one in 10⁹ of a normal distribution, some 10⁴ numbers.
const ALLOWED_U: f64 = 6.0;
/// Errors of second order that no linear uncertainty knows, share of the largest error.
const SECOND_ORDER: f64 = 0.01;
/// No error of a machine is larger, mm or rad.
const ABSURD: f64 = 10.0;

fn text(kind: &str, name: &str) -> String {
    let path = crate::workspace_root().join(format!("config/{kind}/{name}.toml"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A cycle on a machine and in a mounting that were drawn.
struct Drawn {
    cycle: Cycle,
    machine: Machine,
    model: Model,
    states: Vec<State>,
    virtual_machine: VirtualMachine,
}

impl Drawn {
    fn new(case: Case, seed: u64, rng: &mut ChaCha8Rng) -> Self {
        let mut cycle =
            Cycle::parse(case.cycle, &text("cycles", case.cycle)).unwrap_or_else(|e| panic!("{e}"));
        let machine = shipped::machine(&cycle.machine).expect("shipped");
        let states = moved(&mut cycle, &machine, rng);
        let model = case.model.map_or_else(
            || Model::base(&machine.name),
            |name| Model::parse(name, &text("models", name)).unwrap_or_else(|e| panic!("{e}")),
        );
        let truth = draw(&machine, &cycle.setups, seed, rng);
        let virtual_machine = VirtualMachine::new(machine.clone(), truth).expect("of this machine");
        Self { cycle, machine, model, states, virtual_machine }
    }

    fn measured(&self, states: &[State]) -> Run {
        run(&self.cycle, &self.machine, &self.virtual_machine, states)
    }
}

/// The fit of the trial without scatter, and the truth.
///
/// # Panics
/// A fit that fails.
pub fn fit_without_scatter(case: Case, seed: u64) -> (Identification, Truth) {
    let drawn = Drawn::new(case, seed, &mut ChaCha8Rng::seed_from_u64(seed));
    let run = drawn.measured(&drawn.states);
    let experiment = Experiment::new(std::slice::from_ref(&run)).unwrap_or_else(|e| panic!("{e}"));
    let fit = identify(&experiment, &drawn.model, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    (fit, drawn.virtual_machine.truth().clone())
}

/// Draws machine, mounting and scatter from the seed; measures, fits and judges.
pub fn trial(case: Case, seed: u64) -> Vec<Failure> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let drawn = Drawn::new(case, seed, &mut rng);
    let scatter_mm = rng.random_range(0.0..MOST_SCATTER_MM);
    let off = scattered(&drawn.machine, &drawn.states, scatter_mm, &mut rng);
    let (exact, recorded) = (drawn.measured(&drawn.states), drawn.measured(&off));

    let mut failures = Vec::new();
    let mut fail = |kind, what: String| failures.push(Failure { kind, what });
    let fitted = |run: &Run| {
        let experiment = Experiment::new(std::slice::from_ref(run)).map_err(|e| e.to_string())?;
        identify(&experiment, &drawn.model, &Options::default()).map_err(|e| e.to_string())
    };
    match (fitted(&exact), fitted(&recorded)) {
        (Ok(exact), Ok(recorded)) => compare(&exact, &recorded, &mut fail),
        (Err(why), _) => fail("not fitted at commanded positions", why),
        (_, Err(why)) => fail("not fitted with scatter", why),
    }
    for method in recipes::REGISTRY {
        let options = MethodOptions::default();
        let both = [&exact, &recorded].map(|run| method.apply(std::slice::from_ref(run), &options));
        match both {
            [Ok(_), Err(why)] => fail("method fails with scatter", format!("{}: {why}", method.name)),
            [Err(MethodError::Fit(why)), _] => fail("method not fitted", format!("{}: {why}", method.name)),
            [_, Ok(found)] => {
                // A station of a tracker, as its dead path, is a setting of hundreds of millimetres.
                let is_setting = |name: &str| name.starts_with("station ");
                for value in
                    found.values.iter().filter(|value| absurd(value.value) && !is_setting(&value.name))
                {
                    fail("method absurd", format!("{} {} = {:e}", method.name, value.name, value.value));
                }
            }
            _ => {}
        }
    }
    failures
}

/// States of the cycle with its setups moved; back at their places where the machine cannot reach.
fn moved(cycle: &mut Cycle, machine: &Machine, rng: &mut ChaCha8Rng) -> Vec<State> {
    let pace = Pace { points_per_s: POINTS_PER_S, ..Pace::default() };
    let places: Vec<_> = cycle.setups.iter().map(|setup| setup.ball_in_table_mm).collect();
    let by = Vector3::from_fn(|_, _| rng.random_range(-MOST_MOVED_MM..MOST_MOVED_MM));
    for setup in &mut cycle.setups {
        setup.ball_in_table_mm += by;
    }
    cycle.visits(machine, &pace).map_or_else(
        |_| {
            cycle.setups.iter_mut().zip(&places).for_each(|(setup, place)| setup.ball_in_table_mm = *place);
            cycle.visits(machine, &pace).unwrap_or_else(|error| panic!("{error}")).states
        },
        |visits| visits.states,
    )
}

/// A machine with white noise whose errors, and whose mounting, are up to ten times larger or smaller than usual.
fn draw(machine: &Machine, setups: &[Setup], seed: u64, rng: &mut ChaCha8Rng) -> Truth {
    let setups: Vec<SimSetup> = setups.iter().map(SimSetup::from).collect();
    let mut times = || MOST_TIMES.powf(rng.random_range(-1.0..1.0));
    let (worse, farther) = (times(), times());
    let mut truth =
        Truth::draw(machine, &setups, &[], 1200.0, seed).expect("nothing hidden").mounted(&setups, 1);
    truth.noise = Noise::WHITE;
    for joint in machine.joints() {
        let twist = truth.location[joint];
        truth.location[joint] = twist * worse;
    }
    for PlacedSetup { setting_mm, own, .. } in &mut truth.setups {
        *setting_mm *= farther;
        own.turn_rad *= farther;
        own.beam_rad *= farther;
        own.mirror_rad *= farther;
    }
    truth
}

/// The states with every axis off its position by chance.
fn scattered(machine: &Machine, states: &[State], scatter_mm: f64, rng: &mut ChaCha8Rng) -> Vec<State> {
    let mut off = states.to_vec();
    for state in &mut off {
        for joint in machine.joints() {
            let draw: f64 = StandardNormal.sample(rng);
            let unit: f64 = if Joint::is_rotary(joint) { RAD_PER_MM } else { 1.0 };
            state.position[joint] += draw * scatter_mm * unit;
        }
    }
    off
}

fn run(cycle: &Cycle, machine: &Machine, virtual_machine: &VirtualMachine, states: &[State]) -> Run {
    let mut sampler = Sampler::new(virtual_machine, 0);
    let point = |state: &State| Point {
        reading_mm: sampler.read_mm(virtual_machine, state),
        state: state.clone(),
        spread_mm: [0.0; 3],
        samples: 0,
        quality: Quality::Good,
    };
    Run {
        name: cycle.name.clone(),
        machine: machine.clone(),
        kind: cycle.run_kind(),
        setups: cycle.setups.clone(),
        channels: Vec::new(),
        points: states.iter().map(point).collect(),
    }
}

/// Scatter changes neither what is observable nor any number beyond its uncertainty, and both fits are as good as the noise.
fn compare(exact: &Identification, recorded: &Identification, fail: &mut dyn FnMut(&'static str, String)) {
    let names = |fit: &Identification| {
        fit.parameters.iter().map(|p| (p.effect.clone(), p.name.clone())).collect::<Vec<_>>()
    };
    if names(exact) != names(recorded) {
        return fail(
            "parameters",
            format!("{} became {}", exact.parameters.len(), recorded.parameters.len()),
        );
    }
    let numbers =
        |fit: &Identification| fit.parameters.iter().filter(|p| p.status == Status::Identified).count();
    if numbers(exact) == 0 {
        fail("nothing identified", format!("{} of {}", exact.parameters.len(), exact.machine));
    }
    if exact.rank != recorded.rank {
        fail("rank", format!("{} became {}", exact.rank, recorded.rank));
    }
    let rms = |fit: &Identification| 1e3 * fit.rms_mm;
    if rms(recorded) > 2.0 * rms(exact) + 0.1 {
        fail("residual", format!("{:.3} µm with scatter, {:.3} without", rms(recorded), rms(exact)));
    }
    let largest = exact.parameters.iter().filter_map(|p| p.value).fold(0.0, |most: f64, v| most.max(v.abs()));
    for (a, b) in exact.parameters.iter().zip(&recorded.parameters) {
        if a.status != b.status {
            let with_u = |p: &FittedParameter| match p.u {
                Some(u) => format!("{:?} (u {u:.1e})", p.status),
                None => format!("{:?}", p.status),
            };
            let what = format!("{}.{}: {} became {}", a.effect, a.name, with_u(a), with_u(b));
            fail("observability", what);
            continue;
        }
        let Some(((x, u), (y, v))) = a.value.zip(a.u).zip(b.value.zip(b.u)) else { continue };
        // The dead path of an interferometer is a setting of hundreds of millimetres.
        let setting = b.effect == "ball-setting";
        if absurd(y) && !setting {
            fail("absurd", format!("{}.{} = {y:e}", b.effect, b.name));
        } else if (x - y).abs() > ALLOWED_U * u.hypot(v) + SECOND_ORDER * largest {
            fail("number", format!("{}.{}: {x:e} ± {u:e} became {y:e} ± {v:e}", a.effect, a.name));
        }
    }
}

/// Also what is no number.
fn absurd(value: f64) -> bool {
    value.is_nan() || value.abs() >= ABSURD
}
