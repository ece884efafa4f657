//! Setting up at the machine in guided steps: directions of the probes, then whether they follow (docs/use/setting-up.md).
//!
//! The service has the devices, so the steps take what it reads while no cycle is measured; `trunnion calibrate-nest` and
//! `trunnion watch --sign-test` do the same without a service.

use crate::board::Board;
use crate::latest::{Latest, Mounted};
use crate::nest_file::{by_hand, write_nest};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use trunnion::nest::NestSteps;
use trunnion::results::{NestCalibrated, SetUpState, SetUpStep, SignFinding};
use trunnion_core::channel::instrument_channels;
use trunnion_core::{Clock, Joint, NestSide, chain};
use trunnion_sync::plan::Plan;
use trunnion_sync::{NestCalibration, Timed};

/// Dwells from which a calibration may succeed: three directions, both ways, and where they began.
const FEWEST_DWELLS: usize = 7;
const STEP_ON: &str = "Step X, Y and Z by 0.1 mm and more, both ways; stand for a second after each step. Twelve steps are good.";
const JOG_ON: &str = "Jog X by 0.1 mm, then Y and Z; wait a second after each.";

/// Shared by the page, which begins steps, and by who reads the devices.
#[derive(Clone)]
pub struct SetUp {
    plan: Option<Arc<Plan>>,
    board: Board,
    inside: Arc<Mutex<Inside>>,
    file: Option<ConfigFile>,
}

/// Where a calibrated nest goes.
#[derive(Clone)]
struct ConfigFile {
    path: PathBuf,
    clock: Arc<dyn Clock>,
    latest: Latest,
}

#[derive(Default)]
struct Inside {
    under_way: Option<UnderWay>,
    /// Calibrated, and not written.
    calibrated: Option<NestCalibrated>,
    /// Directions that were written since the service began.
    written: Option<[[f64; 3]; 3]>,
}

struct UnderWay {
    step: SetUpStep,
    steps: NestSteps,
    nest: NestCalibration,
    seen: usize,
    /// Why the last attempt to finish gave nothing.
    problem: String,
}

/// Why a step cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum NoSetUp {
    /// A ball bar has no nest.
    #[error("the configuration lacks probe-1, probe-2, probe-3, or a cycle that names the machine")]
    NoProbes,
    /// There is nothing to finish.
    #[error("no calibration of the nest is under way")]
    NotUnderWay,
    /// There is nothing to write.
    #[error("no nest was calibrated since the last one was written")]
    NotCalibrated,
    /// The configuration stayed as it was.
    #[error("{0}")]
    NotWritten(String),
}

impl SetUp {
    /// Of the probes as this plan has them.
    pub fn new(board: &Board, plan: Option<&Plan>) -> Self {
        let plan = plan.cloned().map(Arc::new);
        Self { plan, board: board.clone(), inside: Arc::default(), file: None }
    }

    /// The same with the configuration that a calibrated nest is written into; `latest` shows the ball by it then.
    pub fn writing(self, path: PathBuf, clock: Arc<dyn Clock>, latest: Latest) -> Self {
        Self { file: Some(ConfigFile { path, clock, latest }), ..self }
    }

    /// Directions that were written since the service began: the cycles were read before.
    pub fn written(&self) -> Option<[[f64; 3]; 3]> {
        self.lock().written
    }

    /// Writes the calibrated nest into the configuration; the next cycle is measured with it.
    ///
    /// # Errors
    /// Without a calibrated nest, or when the file cannot be written; it stays as it was then.
    pub fn write_nest(&self) -> Result<(), NoSetUp> {
        let file =
            self.file.as_ref().ok_or_else(|| NoSetUp::NotWritten("there is no configuration".into()))?;
        // Taken, so that nobody writes it twice; samples wait for the lock, so the disk must not be waited for under it.
        let nest = self.lock().calibrated.take().ok_or(NoSetUp::NotCalibrated)?;
        let directions = nest.directions(false).ok_or(NoSetUp::NotCalibrated)?;
        let before = write_nest(&file.path, directions, file.clock.wall_ns()).map_err(|failure| {
            self.lock().calibrated = Some(nest.clone());
            NoSetUp::NotWritten(format!("{}; {}", chain(&failure), by_hand(&file.path, directions)))
        })?;
        self.lock().written = Some(directions);
        if let (Some(plan), Some(nest)) = (&self.plan, NestCalibration::along(directions)) {
            file.latest.set_mounted(Mounted { nest, ..Mounted::of(plan) });
        }
        self.board.publish(&SetUpState {
            written: format!("Written into {}; as it was it is {}.", file.path.display(), before.display()),
            nest: Some(nest),
            to_do: "Do the sign test; the next cycle is measured with this nest.".into(),
            ..SetUpState::default()
        });
        Ok(())
    }

    /// Begins a step; another one ends.
    ///
    /// # Errors
    /// Without three probes.
    pub fn begin(&self, step: SetUpStep) -> Result<(), NoSetUp> {
        let plan = self.plan.as_ref().ok_or(NoSetUp::NoProbes)?;
        let channels = instrument_channels(&plan.channels, false).ok_or(NoSetUp::NoProbes)?;
        let side: NestSide = plan.cycle.setups[0].nest;
        let steps = NestSteps::new(plan.machine.clone(), side, &channels);
        let mut inside = self.lock();
        let nest = inside.written.and_then(NestCalibration::along).unwrap_or(plan.nest);
        inside.under_way = Some(UnderWay { step, steps, nest, seen: 0, problem: String::new() });
        drop(inside);
        self.board.publish(&SetUpState {
            step: Some(step),
            to_do: to_do(step).into(),
            ..SetUpState::default()
        });
        Ok(())
    }

    /// Calibrates the nest from the steps so far, or gives the reason why not; the step goes on then.
    ///
    /// # Errors
    /// Without a calibration under way.
    pub fn finish_nest(&self) -> Result<(), NoSetUp> {
        let mut inside = self.lock();
        let now = inside
            .under_way
            .as_mut()
            .filter(|now| now.step == SetUpStep::Nest)
            .ok_or(NoSetUp::NotUnderWay)?;
        let (calibrated, state) = (now.steps.calibrate(false), now.state());
        match calibrated {
            Ok(nest) => {
                (inside.under_way, inside.calibrated) = (None, Some(nest.clone()));
                let to_do = "Write the directions into the configuration, then do the sign test.";
                self.board.publish(&SetUpState {
                    step: None,
                    nest: Some(nest),
                    problem: String::new(),
                    to_do: to_do.into(),
                    ..state
                });
            }
            Err(failure) => {
                now.problem = chain(&failure);
                self.board.publish(&now.state());
            }
        }
        Ok(())
    }

    /// Ends what is under way.
    pub fn stop(&self) {
        self.lock().under_way = None;
        self.board.publish(&SetUpState::default());
    }

    /// Takes what a device read.
    pub(crate) fn take(&self, timed: &Timed) {
        let mut inside = self.lock();
        let Some(now) = inside.under_way.as_mut() else { return };
        match timed {
            Timed::Probe(sample) => now.steps.probe(sample),
            Timed::Axes(sample) => now.steps.axes(sample),
            _ => return,
        }
        if std::mem::replace(&mut now.seen, now.steps.count()) == now.steps.count() {
            return;
        }
        let state = now.state();
        let found = state.sign_test.as_ref().map(|test| test.finding);
        if matches!(found, Some(SignFinding::AsNest | SignFinding::OtherWay)) {
            inside.under_way = None;
            self.board.publish(&SetUpState { step: None, ..state });
        } else {
            self.board.publish(&state);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Inside> {
        self.inside.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl UnderWay {
    fn state(&self) -> SetUpState {
        let dwells = self.steps.count();
        let last = self.steps.last().map_or_else(String::new, |dwell| {
            let [x, y, z] = [Joint::X, Joint::Y, Joint::Z].map(|axis| dwell.position[axis]);
            let [a, b, c] = dwell.probes_mm;
            format!("X {x:.3} Y {y:.3} Z {z:.3} mm, probes {a:.4} {b:.4} {c:.4} mm")
        });
        let sign_test = match self.step {
            SetUpStep::Nest => None,
            SetUpStep::SignTest => self.steps.sign_test(&self.nest),
        };
        let to_do = match (self.step, sign_test.as_ref().map(|test| test.finding)) {
            (SetUpStep::Nest, _) if dwells >= FEWEST_DWELLS => "Step on, or finish.",
            (_, Some(SignFinding::AsNest)) => "Bring the ball to the centre, then begin a cycle.",
            (_, Some(SignFinding::OtherWay | SignFinding::None)) => {
                "Mend what it says, then do the sign test again."
            }
            (step, _) => to_do(step),
        };
        SetUpState {
            step: Some(self.step),
            dwells,
            last,
            sign_test,
            problem: self.problem.clone(),
            to_do: to_do.into(),
            ..SetUpState::default()
        }
    }
}

fn to_do(step: SetUpStep) -> &'static str {
    match step {
        SetUpStep::Nest => STEP_ON,
        SetUpStep::SignTest => JOG_ON,
    }
}
