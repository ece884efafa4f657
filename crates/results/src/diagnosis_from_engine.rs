//! The answer of a diagnosis from what the engine found.

use crate::complete::Complete;
use crate::diagnosis::{
    Candidate, Diagnosis, DiagnosisFormat, FormulaProposal, NextCycle, Residual, ShapeNumber, Together,
};
use crate::doubt::Doubt;
use crate::identification::{LeftOut, Parameter};
use crate::number::{finite, value_and_u};
use crate::sentences::{doubts_of, why};
use crate::spectrum::Period;
use trunnion_engine as engine;

impl From<&engine::Diagnosis> for Diagnosis {
    fn from(diagnosis: &engine::Diagnosis) -> Self {
        let residual = Residual {
            rms_um: diagnosis.residual.rms_um,
            holdout_rms_um: diagnosis.residual.holdout_rms_um.and_then(finite),
            holdout_unit: diagnosis.residual.holdout_unit.map(LeftOut::from),
            noise_um: diagnosis.residual.noise_um.and_then(finite),
            noise_readings: diagnosis.residual.noise_readings.and_then(finite),
            unexplained_fraction: finite(diagnosis.residual.unexplained_fraction),
        };
        Self {
            format: DiagnosisFormat::V1,
            model: diagnosis.model.clone(),
            candidates: diagnosis.candidates.iter().map(|c| Candidate::of(c, &residual)).collect(),
            residual,
            verdict: diagnosis.verdict,
            why: diagnosis.why.clone(),
            noise: diagnosis.noise,
            noticeable_um: diagnosis.noticeable_um.and_then(finite),
            undecided: diagnosis.undecided.clone(),
            set: diagnosis.set.iter().map(|entry| entry.id.clone()).collect(),
            together: diagnosis.together.as_ref().map(Together::from),
            formula: diagnosis.formula.as_ref().map(FormulaProposal::from),
            next_cycle: diagnosis.next_cycle.as_ref().map(NextCycle::from),
            not_visible: diagnosis.not_visible.clone(),
            out_of_reach: diagnosis.out_of_reach.clone(),
            complete: Complete::default(),
        }
    }
}

impl Candidate {
    fn of(candidate: &engine::Candidate, residual: &Residual) -> Self {
        let doubts: Vec<Doubt> = candidate.doubts.iter().map(Doubt::from).collect();
        let mut result = Self {
            effect: candidate.effect.clone(),
            evidence: candidate.evidence,
            rms_um_after: candidate.rms_um_after,
            holdout_rms_um_after: candidate.holdout_rms_um_after.and_then(finite),
            explains_fraction: candidate.explains_fraction,
            parameters: candidate.parameters.iter().map(Parameter::from).collect(),
            confused_with: candidate.confused_with.clone(),
            separate_by: candidate.separate_by.clone(),
            adequate: candidate.adequate(),
            explains_all: candidate.explains_all,
            period: candidate.period.as_ref().map(Period::from),
            remarks: candidate
                .remarks
                .iter()
                .cloned()
                .chain(seen_together(candidate))
                .chain(doubts_of(&doubts))
                .collect(),
            why: String::new(),
        };
        result.why = why(&result, residual);
        result
    }
}

/// Sizes of a candidate of which no parameter has a number.
fn seen_together(candidate: &engine::Candidate) -> Option<String> {
    let said = |seen: &engine::Combination| {
        let (value, u) = value_and_u(Some(seen.value), Some(seen.u), seen.unit);
        format!("{} = {value}, u = {u}", seen.text)
    };
    let said: Vec<String> = candidate.seen_together.iter().map(said).collect();
    (!said.is_empty()).then(|| format!("Seen only together: {}.", said.join("; ")))
}

impl From<&engine::CandidateParameter> for Parameter {
    fn from(p: &engine::CandidateParameter) -> Self {
        Self {
            name: p.name.clone(),
            effect: p.effect.clone(),
            value: p.value.and_then(finite),
            unit: p.unit.clone(),
            u: p.u.and_then(finite),
            u_another_run: None,
            observable: p.value.is_some(),
            note: String::new(),
            at_rest: Vec::new(),
        }
    }
}

impl From<&engine::Together> for Together {
    fn from(together: &engine::Together) -> Self {
        Self {
            rms_um_after: together.rms_um,
            holdout_rms_um_after: together.holdout_rms_um.and_then(finite),
            explains_fraction: together.explains_fraction,
            parameters: together.parameters.iter().map(Parameter::from).collect(),
            adequate: together.adequate,
            explains_all: together.explains_all,
        }
    }
}

impl From<&engine::FormulaProposal> for FormulaProposal {
    fn from(formula: &engine::FormulaProposal) -> Self {
        let number = |n: &engine::ShapeNumber| ShapeNumber {
            name: n.name.clone(),
            value: n.value,
            unit: n.unit.into(),
        };
        Self {
            name: formula.name.clone(),
            site: formula.site.clone(),
            component: formula.component.clone(),
            expression: formula.expression.clone(),
            shape: formula.shape.iter().map(number).collect(),
            also: formula.entries.iter().skip(1).map(|entry| entry.id.clone()).collect(),
            components: formula.entries.iter().filter_map(|entry| entry.component.clone()).collect(),
            evidence: formula.evidence,
            rms_um_after: formula.rms_um_after,
            holdout_rms_um_after: formula.holdout_rms_um_after.and_then(finite),
            explains_fraction: formula.explains_fraction,
            location: formula.location.clone(),
            resembles: formula.resembles.clone(),
        }
    }
}

impl From<&engine::NextCycle> for NextCycle {
    fn from(next: &engine::NextCycle) -> Self {
        Self { suggestion: next.suggestion.clone(), cycle: next.cycle.clone() }
    }
}
