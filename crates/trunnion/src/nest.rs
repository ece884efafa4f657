//! The nest of an R-test from known steps of the linear axes: the same for a recording and live.

use crate::Error;
use crate::gaps::Missing;
use nalgebra::{Point3, Vector3};
use std::path::Path;
use trunnion_core::channel::instrument_channels;
use trunnion_core::{
    AxisSample, AxisValues, InstrumentKind, Joint, NestSide, Point, ProbeSample, Quality, Setup, Slot, State,
};
use trunnion_cycles::cycle::Settle;
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Machine};
use trunnion_record::Item;
use trunnion_results::{NestCalibrated, SignTest};
use trunnion_sync::jog::judge_jogs;
use trunnion_sync::nest::{NestStep, STEP_MM, calibrate_well};
use trunnion_sync::{DwellReader, DwellReading, NestCalibration, StaticRules};

/// When a dwell is read: as in config/cycles/r-test-static.toml, but a probe may drift by 2 µm, as steps are large.
const SETTLE: Settle = Settle {
    window_s: 0.5,
    drift_mm: 2e-3,
    noise_mm: 2e-3,
    standstill_mm: 2e-3,
    standstill_rad: 1.7e-5,
    timeout_s: 10.0,
};
/// Rotary axes within this stand at one pose, rad: far more than recorded positions scatter, far less than a cycle steps.
const SAME_POSE_RAD: f64 = 1e-4;

/// Dwells of the machine, and the steps of the ball between them.
pub struct NestSteps {
    reader: DwellReader,
    dwells: Vec<DwellReading>,
    machine: Machine,
    setup: Setup,
}

impl NestSteps {
    /// For the channels of the three probes.
    pub fn new(machine: Machine, side: NestSide, channels: &[u16]) -> Self {
        let axes: Vec<Joint> = machine.axes().map(|axis| axis.letter).collect();
        let reader = DwellReader::new(channels, axes, StaticRules::new(SETTLE));
        let setup = Setup::new("nest", InstrumentKind::RTest, side, Point3::origin());
        Self { reader, dwells: Vec::new(), machine, setup }
    }

    /// Takes a displacement.
    pub fn probe(&mut self, sample: &ProbeSample) {
        self.reader.probe(sample, &mut self.dwells);
    }

    /// Takes axis positions.
    pub fn axes(&mut self, sample: &AxisSample) {
        self.reader.axes(sample, &mut self.dwells);
    }

    /// How often the machine has dwelt.
    pub fn count(&self) -> usize {
        self.dwells.len()
    }

    /// The last dwell.
    pub fn last(&self) -> Option<&DwellReading> {
        self.dwells.last()
    }

    /// Directions of the probes from all steps; the lines hold the gains where `with_gains`.
    ///
    /// # Errors
    /// Steps or readings that give no calibration, with the reason.
    pub fn calibrate(&self, with_gains: bool) -> Result<NestCalibrated, Error> {
        let (steps, times_s) = self.at_one_pose();
        let fit = calibrate_well(&steps, &times_s).map_err(|refused| Error::Nest(Box::new(refused)))?;
        Ok(NestCalibrated::new(&fit, steps.len(), with_gains))
    }

    /// What the jogs between the dwells say of a nest; `None` before the first jog.
    pub fn sign_test(&self, nest: &NestCalibration) -> Option<SignTest> {
        let jogs: Vec<NestStep> = self.dwells.windows(2).filter_map(|pair| self.jog(pair)).collect();
        Some(SignTest::new(&jogs, &judge_jogs(nest, &jogs)?))
    }

    fn jog(&self, pair: &[DwellReading]) -> Option<NestStep> {
        let [from, to] = pair else { return None };
        let moved = self.ball_mm(&to.position) - self.ball_mm(&from.position);
        let probes_mm = [0, 1, 2].map(|k| to.probes_mm[k] - from.probes_mm[k]);
        let is_jog = same_pose(&from.position, &to.position) && STEP_MM.contains(&moved.norm());
        (is_jog && probes_mm.iter().all(|mm| mm.is_finite()))
            .then_some(NestStep { ball_in_nest_mm: moved, probes_mm })
    }

    /// The steps at the pose of the rotary axes that has most of them, from the place of its first dwell, with their times.
    fn at_one_pose(&self) -> (Vec<NestStep>, Vec<f64>) {
        let of = |first: &DwellReading| {
            let zero = self.ball_mm(&first.position);
            let here = self.dwells.iter().filter(|dwell| same_pose(&dwell.position, &first.position));
            let step = |dwell: &DwellReading| NestStep {
                ball_in_nest_mm: self.ball_mm(&dwell.position) - zero,
                probes_mm: dwell.probes_mm,
            };
            let steps = here.map(|dwell| (step(dwell), dwell.time_s));
            let reached = steps.filter(|(step, _)| step.ball_in_nest_mm.norm() <= *STEP_MM.end());
            reached.unzip::<NestStep, f64, Vec<_>, Vec<_>>()
        };
        let moved = |steps: &[NestStep]| {
            steps.iter().filter(|step| STEP_MM.contains(&step.ball_in_nest_mm.norm())).count()
        };
        self.dwells.iter().map(of).max_by_key(|(steps, _)| moved(steps)).unwrap_or_default()
    }

    /// Where the axes bring the ball, nest axes, from a place of no meaning, mm.
    fn ball_mm(&self, position: &AxisValues<f64>) -> Vector3<f64> {
        let state = State { position: *position, ..State::default() };
        predict(&self.machine, &self.setup, &state, &Errors::default())
    }
}

fn same_pose(a: &AxisValues<f64>, b: &AxisValues<f64>) -> bool {
    Slot::ALL
        .into_iter()
        .filter(|slot| slot.is_rotary())
        .all(|slot| (a[slot] - b[slot]).abs() <= SAME_POSE_RAD)
}

/// Directions of the probes from a recording in which the linear axes step the ball: from its samples, or from its points, whose
/// readings then stand for the probes; and what is missing from it.
///
/// # Errors
/// A recording that cannot be read; steps or readings that give no calibration.
pub fn calibrate_nest(path: &Path, with_gains: bool) -> Result<(NestCalibrated, Missing), Error> {
    let not_read = Error::recording(path);
    let recording =
        crate::recording::read(path, &|name| crate::files::machine(name).ok(), None).map_err(not_read)?;
    let header = trunnion_record::read_header(path).map_err(not_read)?;
    let missing = Missing::of(path, &recording.gaps, recording.damage.as_ref());
    let run = recording.run;
    let setup = run.setups.iter().find(|setup| setup.instrument == InstrumentKind::RTest);
    let channels =
        crate::recorded::plan_of(&header).and_then(|plan| instrument_channels(&plan.channels, false));
    if let Some((channels, setup)) = channels.zip(setup) {
        let mut steps = NestSteps::new(run.machine.clone(), setup.nest, &channels);
        trunnion_record::visit_samples(path, &mut |item| {
            match item {
                Item::Probe(sample) => steps.probe(&sample),
                Item::Axes(sample) => steps.axes(&sample),
                _ => {}
            }
            true
        })
        .map_err(not_read)?;
        return Ok((steps.calibrate(with_gains)?, missing));
    }
    let dwell = |point: &Point| DwellReading {
        time_s: point.state.time_s.unwrap_or_default(),
        position: point.state.position,
        probes_mm: point.reading_mm,
        spread_mm: point.spread_mm,
    };
    let is_good = |point: &&Point| point.quality == Quality::Good;
    let side = setup.map_or(NestSide::Table, |setup| setup.nest);
    let mut steps = NestSteps::new(run.machine.clone(), side, &[]);
    steps.dwells = run.points.iter().filter(is_good).map(dwell).collect();
    Ok((steps.calibrate(with_gains)?, missing))
}
