//! What `correct` expects of a control is what the simulated control does, and the wrong sign is caught.
//!
//! Through the binary, over drawn machines: measure, identify, write for a control; the simulated control reads the file by the signs of
//! its manual; measure again. What LinuxCNC computes is compiled and run as it stands in the component.

mod component;
mod sign;

use crate::compensation::rms_um;
use crate::program::{json, output, refused, trunnion};
use serde_json::Value;
use std::path::Path;
use trunnion_core::{Joint, Twist};
use trunnion_hil_sim::truth::Noise;
use trunnion_hil_sim::{HiddenChoice, Instrument, NestOn, SimSetup, Truth};
use trunnion_machine::JointErrors;

/// White noise of the readings, µm.
const NOISE_UM: f64 = 0.1;
/// A residual of N readings scatters by 1/√(2N) of itself, 2 % for 1008; twice that.
const AS_EXPECTED: f64 = 0.04;

const MODEL: &str = "format = \"trunnion-model/1\"\nmachine = \"table-bc\"\n[[effect]]\nid = \"location-errors\"\n[[effect]]\nid = \"ball-setting\"\n\
                     [[effect]]\nid = \"gravity-sag:B\"\n[[effect]]\nid = \"encoder-eccentricity:C\"\n";

const CYCLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles");

/// A drawn machine, measured.
struct Shop {
    folder: tempfile::TempDir,
    truth: Truth,
    /// The cycle that it measures; the standard grid without one.
    cycle: Option<String>,
}

impl Shop {
    fn new(seed: u64) -> Self {
        let hidden = ["gravity-sag:B", "encoder-eccentricity:C"];
        Self::measured(drawn("table-bc", &[60.0, 160.0], &hidden, seed), None, MODEL)
    }

    fn measured(truth: Truth, cycle: Option<&str>, model: &str) -> Self {
        let cycle = cycle.map(|name| format!("{CYCLES}/{name}.toml"));
        let shop = Self { folder: tempfile::tempdir().unwrap(), truth, cycle };
        std::fs::write(shop.path("truth.toml"), shop.truth.to_toml()).unwrap();
        std::fs::write(shop.path("model.toml"), model).unwrap();
        shop.measure("before", &[]);
        shop
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn measure(&self, name: &str, more: &[&str]) -> String {
        let run = self.path(&format!("{name}.mcap"));
        if Path::new(&run).exists() {
            std::fs::remove_file(&run).unwrap();
        }
        let truth = self.path("truth.toml");
        let mut args = vec!["simulate", &truth, "-o", &run];
        if let Some(cycle) = self.cycle.as_deref().filter(|_| !more.contains(&"--cycle")) {
            args.extend(["--cycle", cycle]);
        }
        trunnion(&[&args[..], more].concat());
        run
    }

    /// Writes for a control; the file, and what the program says of it.
    fn correct(&self, control: &str, more: &[&str]) -> (String, Value) {
        let file = self.path(control);
        let (run, model) = (self.path("before.mcap"), self.path("model.toml"));
        let args = ["correct", &run, "--model", &model, "--control", control, "-o", &file, "--json"];
        (file.clone(), json(&[&args, more].concat()))
    }

    fn judge(&self, control: &str, after: &str) -> Value {
        let (run, model) = (self.path("before.mcap"), self.path("model.toml"));
        json(&["correct", &run, "--model", &model, "--control", control, "--json", "--judge", after])
    }

    /// The file with every value negated; steps stay.
    fn with_the_wrong_sign(&self, file: &str) -> String {
        let text = std::fs::read_to_string(file).unwrap();
        let wrong: Vec<String> = text
            .lines()
            .map(|line| if line.contains("STEP") { line.into() } else { negated(line) })
            .collect();
        assert_ne!(wrong.join("\n"), text);
        let path = self.path("wrong");
        std::fs::write(&path, wrong.join("\n")).unwrap();
        path
    }
}

/// A machine with white noise alone, balls at these heights.
fn drawn(machine: &str, heights_mm: &[f64], hidden: &[&str], seed: u64) -> Truth {
    let setup = |z: &f64| {
        let name = if *z < 100.0 { "low" } else { "high" };
        SimSetup::new(name, NestOn::Table, [150.0, 0.0, *z].into(), Instrument::R_TEST)
    };
    let setups: Vec<SimSetup> = heights_mm.iter().map(setup).collect();
    let hidden: Vec<HiddenChoice> =
        hidden.iter().map(|id| HiddenChoice { id: (*id).into(), sigma: 1.0 }).collect();
    let machine = trunnion::files::machine(machine).unwrap();
    let mut truth = Truth::draw(&machine, &setups, &hidden, 1682.0, seed).unwrap();
    truth.noise = Noise { white_mm: NOISE_UM * 1e-3, ..Noise::NONE };
    truth
}

fn model(machine: &str, effects: &[&str]) -> String {
    let effects = ["location-errors", "ball-setting"].iter().chain(effects);
    let entries: String = effects.map(|id| format!("[[effect]]\nid = \"{id}\"\n")).collect();
    format!("format = \"trunnion-model/1\"\nmachine = \"{machine}\"\n{entries}")
}

/// A line with the sign of every number of twelve decimals turned.
fn negated(line: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    let (mut out, mut rest) = (String::new(), line);
    while let Some(start) = rest.find(is_number) {
        let length = rest[start..].find(|c| !is_number(c)).unwrap_or(rest.len() - start);
        let (before, number) = (&rest[..start], &rest[start..start + length]);
        let is_value = number.split_once('.').is_some_and(|(_, decimals)| decimals.len() == 12);
        out += &match before.chars().last() {
            Some('-') if is_value => format!("{}+", &before[..before.len() - 1]),
            Some('+') if is_value => format!("{}-", &before[..before.len() - 1]),
            _ if is_value => format!("{before}-"),
            _ => before.into(),
        };
        out += number;
        rest = &rest[start + length..];
    }
    out + rest
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn what_a_control_leaves_is_what_was_expected_and_the_wrong_sign_is_caught() {
    for seed in [3, 8, 21] {
        let shop = Shop::new(seed);
        let before_um = rms_um(&shop.path("before.mcap"));
        for control in ["fanuc", "heidenhain", "siemens"] {
            let sign = shop.path("sign.toml");
            let (file, answer) = shop.correct(control, &["--although-not-better", "--self-test", &sign]);
            let expected = &answer["expected"];
            let (after_um, wrong_um) = (number(&expected["after_um"]), number(&expected["wrong_sign_um"]));
            let with_it = shop.measure("after", &["--compensation", &file]);
            let after = rms_um(&with_it);
            println!("{seed} {control}: {before_um:.2} µm, expected {after_um:.3}, found {after:.3}");
            assert!(
                (after / after_um - 1.0).abs() < AS_EXPECTED,
                "{seed} {control}: {after_um} expected, {after}"
            );
            let wrong = shop.with_the_wrong_sign(&file);
            let with_wrong = shop.measure("doubled", &["--compensation", &wrong]);
            let doubled = rms_um(&with_wrong);
            assert!(
                (doubled / wrong_um - 1.0).abs() < AS_EXPECTED,
                "{control}: {wrong_um} expected, {doubled}"
            );
            sign::check_first_is_read(&answer, &[shop.path("before.mcap"), with_it, with_wrong]);
            let signs = [(None, "not-active"), (Some(&file), "right"), (Some(&wrong), "wrong")];
            let four_poses = signs.map(|(compensation, verdict)| {
                let mut more = vec!["--cycle", sign.as_str()];
                if let Some(file) = compensation {
                    more.extend(["--compensation", file]);
                }
                let run = shop.measure(verdict, &more);
                let judged = shop.judge(control, &run);
                assert_eq!(judged["verdict"], verdict, "{seed} {control}: {judged}");
                run
            });
            sign::self_test_is_read(&answer, &four_poses);
        }
        // Nothing of these errors is on the side of the tool.
        let (_, answer) = shop.correct("heidenhain", &[]);
        assert!(number(&answer["expected"]["after_um"]) < 1.05 * NOISE_UM, "{answer}");
    }
}

#[test]
fn positions_of_the_drives_are_judged_like_commanded_ones() {
    let shop = Shop::new(3);
    let sign = shop.path("sign.toml");
    let (file, answer) = shop.correct("siemens", &["--although-not-better", "--self-test", &sign]);
    let program = format!("trunnion nc-program {sign} --dialect siemens --tcp");
    assert_eq!(answer["self_test"]["program"], program.as_str(), "{answer}");
    let wrong = shop.with_the_wrong_sign(&file);
    let measured = |file: Option<&String>| {
        let more: Vec<&str> = file.map_or(vec![], |file| vec!["--compensation", file.as_str()]);
        trunnion::open(shop.measure("sign", &[&["--cycle", sign.as_str()], &more[..]].concat())).unwrap()
    };
    let without = measured(None);
    for (file, verdict, share) in
        [(Some(&file), "right", 1.0), (None, "not-active", 0.0), (Some(&wrong), "wrong", -1.0)]
    {
        let run = as_the_drives_stand(
            &measured(file),
            &without,
            &shop.folder.path().join(format!("drives-{verdict}")),
        );
        let judged = shop.judge("siemens", &run);
        assert_eq!(judged["verdict"], verdict, "{judged}");
        let positions = &judged["positions"];
        assert!((number(&positions["share"]) - share).abs() < 0.1, "{judged}");
        assert_eq!(positions["counted"], share != 0.0, "{judged}");
    }
}

/// The points of a run with what the correction does added to the positions of the linear axes: what the readings differ by from those without it.
fn as_the_drives_stand(run: &trunnion::Experiment, without: &trunnion::Experiment, folder: &Path) -> String {
    let (points, without) = (run.points(), without.points());
    let mut csv =
        String::from("setup,time_s,x_mm,y_mm,z_mm,b_deg,c_deg,direction_b,direction_c,dx_um,dy_um,dz_um\n");
    let setup = &points.setups[points.points[0].state.setup];
    for (i, (point, other)) in points.points.iter().zip(&without.points).enumerate() {
        let at = point.state.position;
        let moved_mm = std::array::from_fn::<f64, 3, _>(|k| point.reading_mm[k] - other.reading_mm[k]);
        let table = points.machine().machine_from_table(&at, &JointErrors::default()).rotation;
        let moved_mm = table * nalgebra::Vector3::from(moved_mm);
        let linear: String = (0..3).map(|k| format!("{:.4},", at[Joint::LINEAR[k]] + moved_mm[k])).collect();
        let readings = point.reading_mm.map(|mm| format!(",{:.3}", mm * 1e3)).concat();
        let [b, c] = [Joint::B, Joint::C].map(|joint| at[joint].to_degrees());
        csv += &format!("{},{},{linear}{b:.4},{c:.4},1,1{readings}\n", setup.name, 5 * i);
    }
    let [x, y, z]: [f64; 3] = setup.ball_in_table_mm.coords.into();
    let setup = format!(
        "format = \"trunnion-points/1\"\nmachine = \"table-bc\"\n\n[[setup]]\nname = \"{}\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [{x:?}, {y:?}, {z:?}]\n",
        setup.name
    );
    std::fs::create_dir(folder).unwrap();
    std::fs::write(folder.join("setup.toml"), setup).unwrap();
    let path = folder.join("points.csv");
    std::fs::write(&path, csv).unwrap();
    let run = folder.join("run.mcap").display().to_string();
    trunnion(&["import", &path.display().to_string(), "-o", &run]);
    run
}

#[test]
fn confounded_errors_are_entered_through_one_of_them_and_leave_nothing() {
    // At one ball, what turns once with C in the table may be its encoder, or two lobes of its place or tilt.
    let hidden = ["encoder-eccentricity:C", "radial-error-motion:C", "tilt-error-motion:C"];
    for seed in [7, 12, 31] {
        let mut truth = drawn("table-bc", &[60.0], &hidden, seed);
        let lobes = truth.hidden.iter_mut().skip(1).filter_map(|of| of.shape.first_mut());
        lobes.for_each(|lobes| *lobes = 2.0);
        let shop = Shop::measured(truth, None, &model("table-bc", &hidden));
        let before_um = rms_um(&shop.path("before.mcap"));
        let (file, answer) = shop.correct("csv", &["--although-inadequate"]);
        let after_um = rms_um(&shop.measure("after", &["--compensation", &file]));
        println!("{seed}: {before_um:.2} µm before, {after_um:.3} µm after");
        assert!(after_um < 1.1 * NOISE_UM, "{seed}: {before_um} before, {after_um} after");
        assert!(!answer["confounded"].as_array().unwrap().is_empty(), "{answer}");
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains("may be wrong at others"), "{text}");
    }
}

#[test]
fn machines_with_a_head_are_corrected_as_tables_are() {
    for (machine, cycle) in [("head-bc", "r-test-head-bc"), ("head-a-table-c", "r-test-head-a-table-c")] {
        for seed in [3, 8, 21] {
            let truth = drawn(machine, &[60.0, 160.0], &[], seed);
            let shop = Shop::measured(truth, Some(cycle), &model(machine, &[]));
            let before_um = rms_um(&shop.path("before.mcap"));
            for format in ["csv", "etalon", "isg"] {
                let (file, answer) = shop.correct(format, &["--although-inadequate"]);
                let after_um = rms_um(&shop.measure("after", &["--compensation", &file]));
                println!("{machine} {seed} {format}: {before_um:.2} µm before, {after_um:.3} µm after");
                assert!(
                    before_um > 3.0 && after_um < 1.1 * NOISE_UM,
                    "{machine} {seed} {format}: {after_um} {answer}"
                );
            }
        }
    }
}

/// White noise of 0.1 µm in place of the shipped one: what a control leaves is then seen.
fn quiet_truth(name: &str) -> Truth {
    let text = std::fs::read_to_string(format!("{CYCLES}/../truths/{name}.toml")).unwrap();
    let mut truth = Truth::parse("truth.toml", &text).unwrap();
    truth.noise = Noise { white_mm: NOISE_UM * 1e-3, ..Noise::NONE };
    truth
}

#[test]
fn a_control_of_a_head_turns_about_lines_that_begin_at_the_tool() {
    // Most that the control leaves, µm: Siemens the lean of the tool over half the difference of two lengths of tool, Fanuc in addition all directions,
    // Heidenhain all that is on the side of the tool (of a head with both axes everything, so nothing is written).
    let controls: [(&str, &[(&str, f64)]); 3] = [
        ("head-bc", &[("siemens", 1.0), ("fanuc", 2.6)]),
        ("head-a-table-c", &[("siemens", 1.0), ("fanuc", 3.5), ("heidenhain", 2.5)]),
        ("head-bc-spindle", &[("siemens", 1.5), ("fanuc", 2.8)]),
    ];
    for (machine, controls) in controls {
        let truth = quiet_truth(machine);
        let shop = Shop::measured(truth, Some(&format!("r-test-{machine}")), &model(machine, &[]));
        for &(control, leaves_um) in controls {
            let (file, answer) = shop.correct(control, &["--although-inadequate"]);
            let [before_um, expected_um, wrong_um] =
                ["before_um", "after_um", "wrong_sign_um"].map(|name| number(&answer["expected"][name]));
            // Without the settings, of which the ball off the line of its spindle goes round.
            let measured_um = |name: &str, file: &str| {
                number(&shop.judge(control, &shop.measure(name, &["--compensation", file]))["rms_um"])
            };
            let after_um = measured_um("after", &file);
            println!(
                "{machine} {control}: {before_um:.2} µm, expected {expected_um:.3}, found {after_um:.3}"
            );
            assert!((after_um / expected_um - 1.0).abs() < AS_EXPECTED, "{machine} {control}: {answer}");
            assert!(after_um < leaves_um, "{machine} {control}: {before_um} µm before, {after_um} after");
            // A lean of the last axis is a table, which replaces; the vectors are added.
            if machine == "head-bc" && control == "siemens" {
                let text = std::fs::read_to_string(&file).unwrap();
                let head: String = text.lines().filter(|line| line.starts_with(';')).collect();
                assert!(head.contains("values of $MC_ are added to what stands"), "{head}");
                assert!(
                    head.contains("the tables $AA_ENC_COMP replace those that stand in the control"),
                    "{head}"
                );
                assert!(answer["enter"].to_string().contains("a table of the builder acts"), "{answer}");
            }
            let wrong = shop.with_the_wrong_sign(&file);
            let doubled_um = measured_um("doubled", &wrong);
            assert!(
                (doubled_um / wrong_um - 1.0).abs() < AS_EXPECTED,
                "{machine} {control}: {doubled_um}, {answer}"
            );
        }
    }
}

#[test]
fn nothing_is_written_for_a_control_whose_share_of_the_errors_makes_it_no_better() {
    // Between the balls the tilt takes back what the place does: the place alone, all that Fanuc takes, makes it worse.
    let mut truth = drawn("table-bc", &[60.0, 160.0], &[], 3);
    truth.location = JointErrors::default();
    truth.location[Joint::C] =
        Twist::translation([11e-3, 0.0, 0.0].into()) + Twist::rotation([0.0, -100e-6, 0.0].into());
    let shop = Shop::measured(truth, None, &model("table-bc", &[]));
    let (run, by, file) = (shop.path("before.mcap"), shop.path("model.toml"), shop.path("file"));
    let base = ["correct", &run, "--model", &by, "--control", "fanuc", "-o", &file, "--although-inadequate"];
    let reported = refused(&base);
    assert!(reported.contains("nothing was written, because the errors do not fall"), "{reported}");
    assert!(!Path::new(&file).exists());
    let (_, stdout, _) = output(&[&base[..], &["--although-not-better"]].concat());
    assert!(stdout.contains("Do not enter it") && Path::new(&file).exists(), "{stdout}");
}

#[test]
fn nothing_is_written_from_an_inadequate_model_unless_asked_for() {
    let shop = Shop::new(3);
    let (run, file) = (shop.path("before.mcap"), shop.path("file"));
    let base = ["correct", &run, "--control", "siemens", "-o", &file];
    let reported = refused(&base);
    assert!(
        reported.contains("nothing was written, because the model is inadequate. It lacks "),
        "{reported}"
    );
    assert!(!Path::new(&file).exists());
    let (_, stdout, _) = output(&[&base[..], &["--although-inadequate"]].concat());
    assert!(stdout.contains("The model is inadequate: it lacks something"), "{stdout}");
    assert!(Path::new(&file).exists());
    let reported = refused(&[&base[..], &["--corrections"]].concat());
    assert!(reported.contains("--corrections is for tables"), "{reported}");
}
