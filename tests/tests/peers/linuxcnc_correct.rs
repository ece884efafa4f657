//! The errors of a machine fall when LinuxCNC applies what `correct` writes.
//!
//! LinuxCNC runs a cycle on a simulated machine with hidden location errors, sag and a cyclic error. They are identified; the component
//! is compiled by halcompile and loaded; the cycle runs again through the same ports. Four poses catch a component with the wrong
//! sign; one command restores the machine.

use crate::linuxcnc_cell::{Followed, Task, measure};
use crate::linuxcnc_process::{Drives, LinuxCnc};
use std::path::{Path, PathBuf};
use std::process::Command;
use trunnion::Corrected;
use trunnion::report::compensation::format;
use trunnion::report::findings_html;
use trunnion::results::{
    AxisName, Chart, CorrectionJudged, CorrectionValues, Curve, Findings, Plot, SignVerdict, Verdict,
};
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::Cycle;
use trunnion_hil_sim::{HiddenChoice, Truth, VirtualMachine};
use trunnion_machine::{Machine, shipped};
use trunnion_tests::{mounted, show_log, workspace_root};

const MODEL: &str = "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[effect]]\nid = \"location-errors\"\n[[effect]]\nid = \"ball-setting\"\n\
                     [[effect]]\nid = \"gravity-sag:B\"\n[[effect]]\nid = \"encoder-eccentricity:C\"\n";

/// Long enough for the probes to settle and be read, s.
const DWELL_S: f64 = 0.8;

/// The simulated drives follow any speed, mm/s.
const TRANSFER_MM_PER_S: f64 = 400.0;

/// The component of LinuxCNC, installed; taken away with this.
struct Installed;

impl Installed {
    /// The file must have the name of the component.
    fn new(folder: &Path, text: &str) -> Self {
        let path = folder.join("trunnion_correction.comp");
        std::fs::write(&path, text).unwrap();
        let output = Command::new("halcompile")
            .arg("--install")
            .arg(&path)
            .output()
            .expect("linuxcnc-uspace-dev is installed by tests/peers/run");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Self
    }
}

impl Drop for Installed {
    fn drop(&mut self) {
        drop(std::fs::remove_file("/usr/lib/linuxcnc/modules/trunnion_correction.so"));
    }
}

/// The cycle, as the service measures and analyses it.
fn whole<'a>(cnc: &'a LinuxCnc, drives: Drives, machine: &'a Machine, cycle_text: &'a str) -> Task<'a> {
    let (dwell_s, transfer_mm_per_s) = (Some(DWELL_S), TRANSFER_MM_PER_S);
    Task { cnc, drives, machine, cycle_text, dwell_s, analysed: true, transfer_mm_per_s }
}

/// Four poses, too few to be analysed.
fn four<'a>(cnc: &'a LinuxCnc, machine: &'a Machine, cycle_text: &'a str) -> Task<'a> {
    Task { dwell_s: None, analysed: false, ..whole(cnc, Drives::Corrected, machine, cycle_text) }
}

fn judged(corrected: &Corrected, run: &Path) -> CorrectionJudged {
    let answer = corrected.judge(&trunnion::open(run).unwrap()).unwrap();
    println!(
        "{:?}: share {:.3} ± {:.3}, {:.2} µm rms",
        answer.verdict, answer.share, answer.u, answer.rms_um
    );
    answer
}

/// Readings of a run about the mean of their setup, by point: the length, µm.
fn lengths_um(run: &Path) -> Vec<[f64; 2]> {
    let runs = trunnion::open(run).unwrap();
    let points = &runs.points().points;
    let length = |i: usize| {
        let own: Vec<[f64; 3]> = points
            .iter()
            .filter(|other| other.state.setup == points[i].state.setup)
            .map(|other| other.reading_mm)
            .collect();
        let mean = |k: usize| own.iter().map(|reading| reading[k]).sum::<f64>() / own.len() as f64;
        let square = |k: usize| (points[i].reading_mm[k] - mean(k)).powi(2);
        um_from_mm((0..3).map(square).sum::<f64>().sqrt())
    };
    (0..points.len()).map(|i| [(i + 1) as f64, length(i)]).collect()
}

/// Before and after in one picture, next to what the tests build.
fn draw(before: &Path, after: &Path) {
    let curve = |name: &str, run: &Path| Curve { name: name.into(), points: lengths_um(run) };
    let axis = |name: &str, unit: &str| AxisName { name: name.into(), unit: unit.into() };
    let chart = Chart {
        group: "Readings of the cycle".into(),
        title: "Length of the reading about the mean of its setup".into(),
        plot: Plot::Xy {
            x: axis("point of the cycle", ""),
            y: axis("reading", "µm"),
            curves: vec![curve("before", before), curve("with the correction", after)],
        },
    };
    let findings = Findings {
        method: "correct --control linuxcnc".into(),
        machine: "table-bc".into(),
        charts: vec![chart],
        ..Findings::default()
    };
    let page = workspace_root().join("target/peers-correct.html");
    std::fs::write(&page, findings_html(&findings, "LinuxCNC runs the cycle")).unwrap();
    println!("picture: {}", page.display());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn errors_fall_by_nine_tenths_when_linuxcnc_applies_the_correction() {
    show_log();
    let cycle_text = include_str!("../../../config/cycles/demo-static.toml")
        .replacen("step_deg = 30", "step_deg = 45", 1)
        .replace("step_deg = 30", "step_deg = 90")
        .replace("to_deg = 330", "to_deg = 270")
        .replace("passes = [\"+\", \"-\"]", "passes = [\"+\"]");
    let cycle = Cycle::parse("c.toml", &cycle_text).unwrap();
    let machine = shipped::machine("table-bc").unwrap();
    let hidden =
        ["gravity-sag:B", "encoder-eccentricity:C"].map(|id| HiddenChoice { id: id.into(), sigma: 1.0 });
    let mut truth = Truth::draw(&machine, &mounted(&cycle), &hidden, 600.0, 11).unwrap();
    // Small motions without a name stay in every machine; here the question is what becomes of those with one.
    truth.noise.natural_motion_mm = 0.0;
    let hidden = VirtualMachine::new(machine.clone(), truth).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| -> PathBuf { folder.path().join(name) };

    let cnc = LinuxCnc::start(Drives::Sampled);
    let before = measure(
        &at("before"),
        Followed::new(hidden.clone()),
        &whole(&cnc, Drives::Sampled, &machine, &cycle_text),
    )
    .await;
    drop(cnc);
    let runs = trunnion::open(&before).unwrap();
    let model = trunnion::Model::parse("model.toml", MODEL.into()).unwrap();
    let fit = runs.fit(&model).unwrap();
    let verdict = fit.verdict();
    println!("{verdict:?}, residual {:.3} µm", um_from_mm(fit.identification().rms_mm));
    let control = format("linuxcnc").unwrap();
    let corrected = fit.correction(control, CorrectionValues::Error, verdict.0).unwrap();
    let expected = corrected.results(String::new()).expected.unwrap();
    let (_, four_poses) = corrected.self_test().unwrap();
    println!("expected: {expected:?}");

    let wrong = corrected.text().replace("#define SIGN (-1.0)", "#define SIGN (+1.0)");
    assert_ne!(wrong, corrected.text());
    {
        let _component = Installed::new(folder.path(), &wrong);
        let cnc = LinuxCnc::start(Drives::Corrected);
        cnc.switched("1");
        let task = four(&cnc, &machine, &four_poses);
        let run = measure(&at("wrong"), Followed::new(hidden.clone()), &task).await;
        assert_eq!(judged(&corrected, &run).verdict, SignVerdict::Wrong);
    }

    let _component = Installed::new(folder.path(), corrected.text());
    let cnc = LinuxCnc::start(Drives::Corrected);
    cnc.switched("1");
    let right = whole(&cnc, Drives::Corrected, &machine, &cycle_text);
    let after = measure(&at("after"), Followed::new(hidden.clone()), &right).await;
    let found = judged(&corrected, &after);
    println!("{:.2} µm before, {:.2} µm after", expected.before_um, found.rms_um);
    assert_eq!(found.verdict, SignVerdict::Right);
    draw(&before, &after);
    assert!(found.rms_um < 0.1 * expected.before_um, "{found:?}, {expected:?}");

    // One command restores.
    cnc.switched("0");
    let restored = four(&cnc, &machine, &four_poses);
    let restored = measure(&at("restored"), Followed::new(hidden), &restored).await;
    assert_eq!(judged(&corrected, &restored).verdict, SignVerdict::NotActive);
    assert_ne!(verdict.0, Verdict::MissingEffect);
}
