//! Roundness of circles on a machined or probed surface, for example of the machined cone frustum [NAS 979; ISO 10791-7].
//!
//! Targets on one circle at angles φ, deviation m along the normal n; e the outward radius: radial deviation ρ = m/(n·e). RONt is the width of the
//! minimum zone [ISO 1101; ISO 12181-1: MZCI], and, next to it, the range about the least-squares circle (LSCI). Centre and mean radius are no part of it.
//! Limits: deviations small against the radius; what varies between targets is not seen: 36 targets show up to five waves a turn
//! [ISO 12181-2: seven points a wave]; one reading of each target shows no u.

mod circles;

use super::{Convention, Method, MethodError, MethodOptions, one_machine};
use crate::Findings;
use crate::common::{Mounted, left_out_notes};
use crate::findings::{Chart, Curve, FoundValue, Plot, ValueKind};
use circles::{Round, Traces, circles};
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::Run;
use trunnion_effects::Unit;

pub(super) static METHOD: Method = Method {
    name: "roundness",
    title: "Roundness of circles on a machined or probed surface",
    source: "ISO 1101; ISO 12181-1; NAS 979; ISO 10791-7",
    about: "Deviations along the normals of targets on one circle, such as a height of the machined cone frustum: width of the minimum zone and \
            range about the least-squares circle.",
    takes_axis: false,
    takes_convention: false,
    needs: "a machined or probed surface whose targets, twelve or more at each height, lie on circles about Z of the artefact, with normals",
    gives: "roundness of each circle by minimum zone and by least squares, place of its centre, mean deviation of its radius",
    run,
};

fn run(runs: &[Run], _: &MethodOptions) -> Result<Findings, MethodError> {
    one_machine(runs)?;
    let what = "no setup holds targets on one circle";
    let next = "Run a cycle such as config/cycles/machined-cone.toml.";
    let rounds = Traces::of(&METHOD, runs, (what, next), |mounted: &Mounted<'_>, _| circles(mounted))?;
    let mut findings = METHOD.findings(runs, Convention::RightHanded);
    for round in rounds.all.iter().flatten() {
        findings.values.extend(values(round));
        findings.charts.push(chart(round));
    }
    findings.notes = vec![
        "One reading of each target shows no uncertainty: measure the part twice, or state that of the measuring machine.".into(),
    ];
    findings.notes.extend(left_out_notes(&rounds.left_out));
    Ok(findings)
}

fn values(round: &Round) -> Vec<FoundValue> {
    let value = |what: &str, value_mm: f64| {
        FoundValue::new(format!("{what} of {}", round.name), value_mm, Unit::UM, None)
    };
    let about = |value: FoundValue| value.kind(ValueKind::Summary);
    vec![
        about(value("roundness", round.minimum_zone_mm)).note("roundness by the minimum zone (RONt, MZCI)"),
        about(value("roundness, least squares", round.least_squares_mm))
            .note("roundness about the least-squares circle (LSCI)"),
        value("radius", round.radius_off_mm)
            .kind(ValueKind::Setting)
            .note("mean deviation, with that of the tool"),
        value("centre X", round.centre_mm[0]).kind(ValueKind::Setting).note("along X of the artefact"),
        value("centre Y", round.centre_mm[1]).kind(ValueKind::Setting).note("along Y of the artefact"),
    ]
}

fn chart(round: &Round) -> Chart {
    let left = Curve::new("deviation", round.left.clone());
    Chart {
        group: "Roundness".into(),
        title: format!(
            "{}: roundness {:.1} µm; drawn about the least-squares circle",
            round.name,
            um_from_mm(round.minimum_zone_mm)
        ),
        plot: Plot::Polar { unit: Unit::UM, curves: vec![left] },
    }
}
