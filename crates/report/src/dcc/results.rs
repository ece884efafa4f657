//! Method, equipment, temperatures, and every observable parameter of the machine.

use super::administrative::{identification, software};
use super::issuer::DccError;
use super::quantity::{Uncertainty, celsius, quantity};
use super::xml::{holding, plain, stated, text};
use crate::filed::conformity::places;
use crate::words::{about, effect_name, is_setting};
use trunnion_results::{
    Identification, Parameter, Report, RunIdentity, SensorCalibration, TemperatureRange, Verdict,
};

pub fn data(report: &Report) -> Result<String, DccError> {
    if report.comparison.diagnosis.as_ref().is_none_or(|d| d.verdict == Verdict::NotJudged) {
        return Err(DccError::NotJudged);
    }
    let fit = &report.comparison.identification;
    let found: String = certified(fit).iter().map(of_parameter).collect();
    if found.is_empty() {
        return Err(DccError::NoResult);
    }
    let mut results = result("Parameters of the machine, with standard uncertainties", &found);
    let residual = quantity("Residual, rms", fit.rms_um, "um", Uncertainty::None);
    results += &result("What the model does not describe", &residual);
    if let Some(conformity) = &report.conformity {
        let judged = &conformity.as_measured;
        let u = Uncertainty::Expanded(judged.u_um);
        let largest = quantity(
            &format!("Largest deviation, at {}", places(judged).join("; ")),
            judged.largest_um,
            "um",
            u,
        );
        results += &result("Largest deviation of the tool against the table", &largest);
    }
    let runs = &report.identity.runs;
    let body = text("dcc:name", "Errors of the machine tool")
        + &used_method(fit)
        + &holding("dcc:usedSoftware", &software(report))
        + &holding("dcc:measuringEquipments", &runs.iter().flat_map(equipment).collect::<String>())
        + &conditions(runs)
        + &holding("dcc:results", &results);
    Ok(holding("dcc:measurementResults", &holding("dcc:measurementResult", &body)))
}

/// Those of the machine that have a number, each effect with its shape numbers: an amplitude means nothing without its period.
fn certified(fit: &Identification) -> Vec<Parameter> {
    let has_number = |p: &Parameter| p.observable && p.u.is_some() && !is_setting(&p.effect);
    let is_shape =
        |p: &Parameter| fit.shapes.iter().any(|s| s.effect == p.effect && s.names.contains(&p.name));
    let is_certified = |p: &Parameter| match is_shape(p) {
        true => fit.parameters.iter().any(|own| own.effect == p.effect && has_number(own)),
        false => has_number(p),
    };
    fit.listed().into_iter().filter(is_certified).collect()
}

fn of_parameter(parameter: &Parameter) -> String {
    let u = parameter.u.map_or(Uncertainty::None, Uncertainty::Standard);
    let note = if parameter.note.is_empty() { String::new() } else { format!(" ({})", parameter.note) };
    let name = format!("{}: {}{note}", effect_name(&parameter.effect), parameter.name);
    quantity(&name, parameter.value.unwrap_or_default(), &parameter.unit, u)
}

fn result(name: &str, quantities: &str) -> String {
    let list = holding("dcc:list", quantities);
    holding("dcc:result", &(text("dcc:name", name) + &holding("dcc:data", &list)))
}

fn used_method(fit: &Identification) -> String {
    let effects: Vec<String> = fit
        .effects
        .iter()
        .map(|id| about(id).map_or(id.clone(), |about| format!("{} ({id})", about.title)))
        .collect();
    let described =
        format!("All effects are fitted together to {} points: {}.", fit.points, effects.join("; "));
    let body = text("dcc:name", "Identification of a kinematic model by least squares")
        + &text("dcc:description", &described)
        + &plain("dcc:norm", "ISO 230-1")
        + &plain("dcc:norm", "ISO 230-7");
    holding("dcc:usedMethods", &holding("dcc:usedMethod", &body))
}

/// Instruments of a run, then its sensors with their certificates as far as they are recorded.
fn equipment(run: &RunIdentity) -> Vec<String> {
    let directions = stated(Some(run.probe_calibration.join("; ").as_str()));
    let one = |setup: &String| {
        let described = format!("Directions of the probes in nest axes: {directions}");
        let body = text("dcc:name", setup) + &text("dcc:description", &described);
        holding("dcc:measuringEquipment", &body)
    };
    run.setups.iter().map(one).chain(run.calibrations.iter().map(sensor)).collect()
}

fn sensor(of: &SensorCalibration) -> String {
    let [laboratory, date, until] =
        [&of.laboratory, &of.date, &of.valid_until].map(|text| stated(text.as_deref()));
    let described = format!("Laboratory: {laboratory}. Calibrated: {date}. Valid until: {until}.");
    let numbers = [
        ("manufacturer", &of.serial, "Serial number"),
        ("calibrationLaboratory", &of.certificate, "Number of the calibration certificate"),
    ];
    let numbers = numbers.into_iter().filter_map(|(issuer, number, name)| {
        number.as_deref().map(|number| identification(issuer, &stated(Some(number)), name))
    });
    let numbers: String = numbers.collect();
    let identified = if numbers.is_empty() { numbers } else { holding("dcc:identifications", &numbers) };
    let name = format!("Sensor {}", of.sensor);
    holding(
        "dcc:measuringEquipment",
        &(text("dcc:name", &name) + &text("dcc:description", &described) + &identified),
    )
}

fn conditions(runs: &[RunIdentity]) -> String {
    let of = |range: &TemperatureRange| {
        let data = celsius("lowest", range.lowest_degc)
            + &celsius("mean", range.mean_degc)
            + &celsius("highest", range.highest_degc);
        let body = text("dcc:name", &format!("Temperature {}", range.channel)) + &holding("dcc:data", &data);
        holding("dcc:influenceCondition", &body)
    };
    let conditions: String = runs.iter().flat_map(|run| run.temperatures.iter().map(of)).collect();
    if conditions.is_empty() { String::new() } else { holding("dcc:influenceConditions", &conditions) }
}
