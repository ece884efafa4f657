//! The experiment that the pairs and the Monte Carlo share: an R-test over 84 poses (S1 §5.3) with 33 parameters.

use nalgebra::{DMatrix, DVector, Point3};
use trunnion_core::axis::iso::{B, C};
use trunnion_core::{AxisValues, InstrumentKind, NestSide, Point, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{Instance, Model};
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, HeldOut, Outliers, Status, Uncertainties, identify};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, shipped};

/// Location errors, ball settings and error motions of both rotary axes.
const MODEL: &str = r#"format = "trunnion-model/1"
machine = "table-bc"
[[effect]]
id = "location-errors"
[[effect]]
id = "ball-setting"
[[effect]]
id = "gravity-sag:B"
[[effect]]
id = "radial-error-motion:C"
shape = [2]
[[effect]]
id = "axial-error-motion:C"
shape = [1]
[[effect]]
id = "tilt-error-motion:C"
shape = [2]
[[effect]]
id = "tilt-error-motion:B"
shape = [1]
[[effect]]
id = "encoder-eccentricity:C"
"#;

pub fn model() -> Model {
    Model::parse("certify", MODEL).expect("a good model")
}

/// B −90…90° and C 0…330° step 30°, nest on the table, two balls in turn; `rounds` times over, every reading zero.
pub fn experiment(rounds: usize) -> Experiment {
    let machine = shipped::machine("table-bc").expect("shipped");
    let setup = |name: &str, x: f64, z: f64| {
        Setup::new(name, InstrumentKind::RTest, NestSide::Table, Point3::new(x, 0.0, z))
    };
    let setups = vec![setup("low", 150.0, 60.0), setup("high", 90.0, 200.0)];
    let poses: Vec<(i32, i32)> = (-3..=3).flat_map(|b| (0..12).map(move |c| (b, c))).collect();
    let point = |i: usize| {
        let (b, c) = poses[i % poses.len()];
        let mut rotary = AxisValues::default();
        (rotary[B], rotary[C]) = (f64::from(30 * b).to_radians(), f64::from(30 * c).to_radians());
        // Every other pose with the other ball, and the other way round on the next row of B.
        let setup = (b + c).rem_euclid(2) as usize;
        let position = machine.follow(&rotary, &setups[setup].ball_in_table_mm).expect("within travel");
        Point {
            state: State { position, setup, ..State::default() },
            reading_mm: [0.0; 3],
            spread_mm: [0.0; 3],
            samples: 0,
            quality: Default::default(),
        }
    };
    let points = (0..rounds * poses.len()).map(point).collect();
    let run =
        Run { name: "certify".into(), machine, kind: RunKind::Static, setups, channels: vec![], points };
    Experiment::of_points(&[run]).expect("points")
}

/// What the fit can determine, under its conventions, and realistic sizes for it.
pub struct Truth {
    /// Indices of the parameters that the fit leaves free: all but one of each direction that is not observable.
    pub seen: Vec<usize>,
    /// Which of `seen` have a number of their own.
    pub with_number: Vec<usize>,
    /// Every parameter, inside units; zero where not determined. Each moves the readings by about 10 µm.
    pub solution: DVector<f64>,
    /// Root mean square of the columns of the determined parameters, mm per inside unit.
    pub reach: DVector<f64>,
}

/// Conventions of the fit and a truth that keeps them.
pub fn truth(experiment: &Experiment) -> Truth {
    let fit = identify(experiment, &model(), &options()).expect("a fit");
    let held_at_zero = |name: &str| fit.unobservable.iter().any(|direction| direction.terms[0].0 == name);
    let seen: Vec<usize> =
        (0..fit.parameters.len()).filter(|&j| !held_at_zero(&fit.parameters[j].name)).collect();
    let with_number =
        (0..seen.len()).filter(|&k| fit.parameters[seen[k]].status == Status::Identified).collect();
    assert_eq!(seen.len(), fit.rank, "one parameter held for each direction");
    let columns = columns(experiment, &model());
    let rms = |j: usize| columns.column(j).norm() / (experiment.rows() as f64).sqrt();
    let reach = DVector::from_iterator(seen.len(), seen.iter().map(|&j| rms(j)));
    let mut solution = DVector::zeros(fit.parameters.len());
    for (k, &j) in seen.iter().enumerate() {
        // Plain irrational sizes of either sign.
        solution[j] = 0.01 / reach[k] * (1.0 + k as f64 * 0.37).sin();
    }
    Truth { seen, with_number, solution, reach }
}

/// Readings by the exact transforms, mm.
pub fn exact_readings(experiment: &Experiment, solution: &DVector<f64>) -> DVector<f64> {
    let instances: Vec<(Instance, Vec<f64>)> = model()
        .effects
        .iter()
        .map(|entry| {
            (
                Instance::from_model_effect(entry, experiment.machine()).expect("an effect"),
                entry.shape.clone(),
            )
        })
        .collect();
    let mut readings = DVector::zeros(experiment.rows());
    for (i, point) in experiment.points.iter().enumerate() {
        let mut errors = Errors::default();
        let mut first = 0;
        for (instance, shape) in &instances {
            instance.motions(&experiment.scene, shape, &point.state, &mut |parameter, site, twist| {
                errors.add(site, twist * solution[first + parameter]);
            });
            first += instance.parameters(&experiment.scene).len();
        }
        let setup = &experiment.setups[point.state.setup];
        let reading = predict(experiment.machine(), setup, &point.state, &errors);
        for (component, row) in experiment.rows_of(i).enumerate() {
            readings[row] = reading[component];
        }
    }
    readings
}

/// Plain least squares: every point kept, nothing else computed.
pub fn options() -> Options {
    Options {
        outliers: Outliers::Keep,
        holdout: HeldOut::Skipped,
        uncertainties: Uncertainties::Clusters,
        ..Options::default()
    }
}

/// All columns of the model, mm per inside unit.
pub fn columns(experiment: &Experiment, model: &Model) -> DMatrix<f64> {
    let blocks: Vec<DMatrix<f64>> = model
        .effects
        .iter()
        .map(|entry| {
            let instance = Instance::from_model_effect(entry, experiment.machine()).expect("an effect");
            experiment.columns(&instance, &entry.shape)
        })
        .collect();
    let width = blocks.iter().map(DMatrix::ncols).sum();
    let mut all = DMatrix::zeros(experiment.rows(), width);
    let mut first = 0;
    for block in blocks {
        all.columns_mut(first, block.ncols()).copy_from(&block);
        first += block.ncols();
    }
    all
}

/// Readings of the experiment replaced, mm, in the order of its rows.
pub fn set_readings(experiment: &mut Experiment, readings_mm: &[f64]) {
    for i in 0..experiment.points.len() {
        for (k, row) in experiment.rows_of(i).enumerate() {
            experiment.points[i].reading_mm[k] = readings_mm[row];
        }
    }
}
