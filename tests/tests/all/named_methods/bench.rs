//! A truth file, a shipped cycle file, and the run they give.

use trunnion_core::{Point, Quality};
use trunnion_cycles::Pace;
use trunnion_cycles::cycle::Motion;
use trunnion_cycles::{Cycle, Run, RunKind};
use trunnion_hil_sim::physics::{Sampler, VirtualMachine};
use trunnion_hil_sim::{NestOn, SimSetup, Truth};
use trunnion_machine::shipped;
use trunnion_methods::findings::Plot;
use trunnion_methods::recipes::{Convention, MethodError, MethodOptions};
use trunnion_methods::{Findings, recipes};

/// A cycle file of `config/cycles`.
pub fn cycle_text(name: &str) -> String {
    let path = format!("{}/../config/cycles/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// White noise and natural motion in µm; no other noise.
pub fn noise(white_um: f64, natural_um: f64) -> String {
    format!(
        "[noise]\nwhite_um = {white_um:?}\npass_offset_um = 0.0\ndrift_um = 0.0\ndrift_time_s = 600.0\n\
         repeatability_urad = 0.0\nnatural_motion_um = {natural_um:?}\noutlier_share = 0.0\noutlier_um = 0.0\n"
    )
}

/// A setting of a setup of a cycle.
pub struct Set<'a> {
    pub name: &'a str,
    pub setting_um: [f64; 3],
}

/// The truth of a machine with the setups of a cycle; `rest`: location, noise and hidden tables in TOML.
pub fn truth(machine: &str, seed: u64, cycle: &Cycle, settings: &[Set<'_>], rest: &str) -> Truth {
    let mut text = format!(
        "format = \"trunnion-truth/1\"\nmachine = \"{machine}\"\nseed = \"{seed}\"\nrun_duration_s = 600.0\n{rest}"
    );
    for setup in &cycle.setups {
        let sim = SimSetup::from(setup);
        let setting = settings.iter().find(|s| s.name == setup.name).map_or([0.0; 3], |s| s.setting_um);
        let (ball, nest) =
            (sim.ball_in_table_mm, if sim.nest == NestOn::Table { "table" } else { "spindle" });
        text += &format!(
            "\n[[setup]]\nname = \"{}\"\ninstrument = \"r-test\"\nnest = \"{nest}\"\n\
             ball_in_table_mm = [{:?}, {:?}, {:?}]\nsetting_um = {setting:?}\n",
            sim.name, ball.x, ball.y, ball.z
        );
    }
    Truth::parse("truth.toml", &text).unwrap_or_else(|problems| panic!("{problems}"))
}

/// Runs the cycle on the machine of the truth.
pub fn measure(truth: &Truth, cycle: &Cycle) -> Run {
    let machine = shipped::machine(&truth.machine).expect("shipped");
    let visits = cycle.visits(&machine, &Pace::default()).unwrap_or_else(|error| panic!("{error}"));
    let placed: Vec<SimSetup> = cycle.setups.iter().map(SimSetup::from).collect();
    let virtual_machine =
        VirtualMachine::new(machine.clone(), truth.mounted(&placed, 0)).expect("same machine");
    let mut sampler = Sampler::new(&virtual_machine, 0);
    let points = visits.states.into_iter().map(|state| Point {
        reading_mm: sampler.read_mm(&virtual_machine, &state),
        state,
        spread_mm: [0.0; 3],
        samples: 0,
        quality: Quality::Good,
    });
    let kind = match cycle.motion {
        Motion::Static { .. } => RunKind::Static,
        _ => RunKind::OnTheFly,
    };
    let points = points.collect();
    Run { name: cycle.name.clone(), machine, kind, setups: cycle.setups.clone(), channels: vec![], points }
}

pub fn cycle(text: &str) -> Cycle {
    Cycle::parse("cycle.toml", text).unwrap_or_else(|problems| panic!("{problems}"))
}

pub fn by_method(name: &str, run: &Run, convention: Convention) -> Result<Findings, MethodError> {
    let method = recipes::find(name)?;
    method.apply(std::slice::from_ref(run), &MethodOptions { convention, ..MethodOptions::default() })
}

/// Value in inside units.
pub fn value(findings: &Findings, name: &str) -> f64 {
    let found = findings.value(name).unwrap_or_else(|| panic!("no value {name}"));
    found.value
}

/// The curve of this title and name over the angle.
pub fn curve(findings: &Findings, title: &str, name: &str) -> Vec<(f64, f64)> {
    let of =
        findings.charts.iter().filter(|chart| chart.title == title).find_map(|chart| match &chart.plot {
            Plot::Xy { curves, .. } => curves.iter().find(|curve| curve.name == name),
            _ => None,
        });
    of.unwrap_or_else(|| panic!("no curve {name} in {title}")).points.clone()
}
