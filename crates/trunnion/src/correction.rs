//! Corrections for a control: what a fit gives it, what is expected of it, and whether a run shows that it acts.
//!
//! z = P (y − f₀),  c = P Δ,  P = I − Q Qᵀ, Q an orthonormal basis of the columns of the settings
//! y readings, f₀ exact prediction of the nominal machine with its settings fitted, Δ what the errors in the file change of the readings (to first order).
//! Expected: rms(z) now, rms(z − c) with the correction, rms(z + c) with the wrong sign.
//! A run measured with it has z = o + (1 − k) c + noise, o what the other errors of the model change: k = 1 − (z − o)ᵀc / cᵀc, u(k) = s / |c|, s the rms of what remains.
//! Positions of the drives hold the correction, and readings about them show nothing of it: where they hold it, z is about the commanded ones.
//! Limits: u(k) takes the readings as independent.

mod nest_cycle;
mod positions;
mod self_test;
mod shown;
mod sign;

pub(crate) use shown::Shown;

use crate::{Error, Experiment, Fit};
use nalgebra::Vector3;
use trunnion_core::convert::um_from_mm;
use trunnion_report::compensation::Format;
use trunnion_results as results;

/// Why a hybrid machine gets none.
const LEGS_IN_PARALLEL: &str = "controls move legs in parallel by tables that are not public";

/// A correction for one control.
pub struct Corrected {
    fit: Fit,
    format: &'static Format,
    all: results::AxisErrors,
    taken: results::AxisErrors,
    text: String,
    answer: results::Correction,
}

impl Fit {
    /// What a control could be given from this fit, in short.
    ///
    /// # Errors
    /// A model that does not suit the runs.
    pub fn correctable(&self) -> Result<results::Correctable, Error> {
        if results::Chain::of(self.experiment().machine()).is_none() {
            return Ok(results::Correctable::nothing(LEGS_IN_PARALLEL));
        }
        let (points, model) = (self.experiment().points(), self.model().entries());
        let errors = trunnion_methods::AxisErrors::new(points, model, self.identification())?;
        Ok(results::Correctable::new(&errors, &self.results()))
    }

    /// What to enter into a control, with the verdict of a diagnosis of this fit.
    ///
    /// # Errors
    /// A model that does not suit the runs, nothing that the control could take, legs in parallel.
    pub fn correction(
        &self,
        format: &'static Format,
        values: results::CorrectionValues,
        verdict: results::Verdict,
    ) -> Result<Corrected, Error> {
        let machine = self.experiment().machine();
        let chain =
            results::Chain::of(machine).ok_or(Error::NoCorrection { why: LEGS_IN_PARALLEL.into() })?;
        let chain =
            results::Chain { measured_in_tool_mm: measured_in_tool_mm(self.experiment()).into(), ..chain };
        let all = self.axis_errors()?;
        let taken = (format.takes)(&chain, &all);
        if taken.axes.is_empty() {
            let why = |left: &results::LeftOutEffect| format!("{}: {}", left.effect, left.why);
            let why: Vec<String> = taken.left_out.iter().map(why).collect();
            return Err(Error::NoCorrection { why: why.join("; ") });
        }
        let shown = Shown::new(self, self.experiment(), &all, &taken)?;
        let tolerance_um = self.experiment().plate().tolerance_um;
        let after = self.judged(&shown.sizes_mm(-1.0));
        let expected = results::Expected {
            before_um: um_from_mm(shown.rms_mm(0.0)),
            after_um: um_from_mm(shown.rms_mm(-1.0)),
            wrong_sign_um: um_from_mm(shown.rms_mm(1.0)),
            largest_after_um: after.largest_um,
            tolerance_um,
            decision: tolerance_um.map(|tolerance_um| after.clone().decided(tolerance_um).decision),
            excluded: after.excluded,
        };
        let pair = shown.farthest_pair(self.experiment());
        let own = |texts: &[&str]| texts.iter().map(ToString::to_string).collect();
        let answer = results::Correction {
            machine: taken.machine.clone(),
            runs: taken.runs.clone(),
            control: format.name.into(),
            values,
            verdict,
            holds: taken.effects.clone(),
            left_out: taken.left_out.clone(),
            confounded: taken.confounded.clone(),
            axes: results::Correction::axes_of(&taken),
            expected: shown.is_seen().then_some(expected),
            check_first: pair.map(|pair| sign::check(self, &taken, pair)).transpose()?,
            enter: own(format.enter),
            undo: own(format.undo),
            unconfirmed: own(format.unconfirmed),
            source: format.source.into(),
            ..results::Correction::default()
        };
        let text = (format.write)(&chain, &taken, values);
        Ok(Corrected { fit: self.clone(), format, all, taken, text, answer })
    }
}

/// Mean place of the ball in the tool over the setups.
fn measured_in_tool_mm(runs: &Experiment) -> Vector3<f64> {
    let setups = &runs.points().setups;
    setups.iter().map(|setup| setup.ball_in_tool_mm.coords).sum::<Vector3<f64>>() / setups.len().max(1) as f64
}

impl Corrected {
    /// The file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The answer: `trunnion-correction/1`, for a file at this path.
    pub fn results(&self, written: String) -> results::Correction {
        results::Correction { written, ..self.answer.clone() }
    }

    /// Four poses that show the sign, and the cycle file that visits them.
    ///
    /// # Errors
    /// No rotary axis that moved in the runs, or poses that no reading distinguishes.
    pub fn self_test(&self) -> Result<(results::SelfTest, String), Error> {
        self_test::self_test(&self.fit, &self.taken)
    }

    /// Whether runs measured with the correction show it, and with which sign: `trunnion-correction-judged/1`.
    ///
    /// # Errors
    /// Runs of another machine; settings that cannot be fitted alone.
    pub fn judge(&self, runs: &Experiment) -> Result<results::CorrectionJudged, Error> {
        let machine = self.fit.experiment().machine();
        if let Some(run) = runs.runs().iter().find(|run| run.machine.name != machine.name) {
            return Err(Error::OtherMachine {
                fitted: machine.name.clone(),
                run: run.name.clone(),
                found: run.machine.name.clone(),
            });
        }
        let shown = Shown::new(&self.fit, runs, &self.all, &self.taken)?;
        let positions = shown.in_positions();
        let shown = match positions.is_some_and(|positions| positions.counted) {
            true => shown.about_commanded(),
            false => shown,
        };
        let (share, u) = shown.share();
        Ok(results::CorrectionJudged {
            control: self.format.name.into(),
            runs: runs.points().runs.clone(),
            share,
            u,
            verdict: results::SignVerdict::of_readings(share, u, positions),
            positions,
            rms_um: um_from_mm(shown.rms_mm(0.0)),
            without_um: um_from_mm(shown.without_mm()),
            ..results::CorrectionJudged::default()
        })
    }
}
