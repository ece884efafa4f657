//! Compensation files as text, and their registry.

use crate::section::write_or_compare;
use trunnion_report::compensation::FORMATS;
use trunnion_report::compensation::Signs;
use trunnion_results::{AxisErrors, AxisTable, Chain, ChainJoint, CorrectionValues, LeftOutEffect};

#[test]
fn the_registry_holds_every_format_file_and_nothing_else() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/compensation");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    // What several of them share.
    files.retain(|name| !["format", "lines", "taken"].contains(&name.as_str()));
    files.sort();
    let registered: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
    assert_eq!(
        registered, files,
        "left: names of FORMATS in crates/report/src/compensation.rs, in their order; right: the files of its folder"
    );
    for format in FORMATS {
        assert!(format.source.len() > 5 && format.readers.len() > 5, "{} is undocumented", format.name);
    }
}

#[test]
fn the_guide_lists_the_formats_with_what_to_do_and_what_is_unconfirmed() {
    let mut table = String::from("| `--control` | file | read by |\n|---|---|---|\n");
    for format in FORMATS {
        table += &format!("| `{}` | {} | {} |\n", format.name, format.about, format.readers);
    }
    write_or_compare("docs/use/correct.md", "formats", &table);
    let mut text = String::new();
    for format in FORMATS {
        text += &format!("### {}\n\nSource: {}.\n\n", format.name, format.source);
        for step in format.enter {
            text += &format!("1. {step}\n");
        }
        for step in format.undo {
            text += &format!("\nUndo: {step}\n");
        }
        for what in format.unconfirmed {
            text += &format!("\nNot confirmed: {what}\n");
        }
        text += "\n";
    }
    write_or_compare("docs/use/correct.md", "controls", &text);
}

#[test]
fn every_format_says_sign_units_range_and_what_is_missing() {
    for format in FORMATS.iter().filter(|format| format.signs == Signs::Either) {
        let text = (format.write)(&chain(), &errors(), CorrectionValues::Error);
        for expected in [
            "values = error (actual - nominal); the control must apply correction = -error",
            "offsets mm, angles rad; arguments: X Y Z in mm, A B C in degrees",
            "axis X: measured from -10 to 10 mm, not valid beyond",
            "axis C: a whole turn, periodic",
            "holds: location-errors, linear-scale:X",
            "does not hold backlash:C: it depends on the direction of C",
        ] {
            assert!(text.contains(expected), "{}: {expected} in\n{text}", format.name);
        }
        let corrections = (format.write)(&chain(), &errors(), CorrectionValues::Correction);
        assert!(corrections.contains("values = correction (-error"), "{}", format.name);
        assert!(text.contains(" 0.002") || text.contains(",0.002"), "{text}");
        assert!(corrections.contains("-0.002") && !corrections.contains("-0.000000000000"), "{corrections}");
    }
}

#[test]
fn the_bodies_are_laid_out_as_the_controllers_describe_them() {
    let body = |name: &str| {
        let format = FORMATS.iter().find(|format| format.name == name).unwrap();
        let text = (format.write)(&chain(), &errors(), CorrectionValues::Error);
        let kept = text.lines().filter(|line| !line.starts_with("//") && !line.starts_with("# "));
        kept.map(|line| format!("{line}\n")).collect::<String>()
    };
    // Beckhoff TF5280: position errors, a break, then the argument and the component errors.
    assert_eq!(
        body("isg").lines().take(6).collect::<Vec<_>>(),
        [
            "X0C A0C",
            "0.012000000000 -0.000050000000",
            "#",
            "C EXC EYC EZC EAC EBC ECC",
            "0 0.000000000000 0.001000000000 0.000000000000 0.000000000000 0.000000000000 0.000003000000",
            "180 0.000000000000 -0.001000000000 0.000000000000 0.000000000000 0.000000000000 0.000000000000",
        ]
    );
    // Beckhoff TF5280: a block for each parameter.
    let etalon = body("etalon");
    assert!(etalon.starts_with(
        "[X0C]\nVALUE = 0.012000000000\n[A0C]\nVALUE = -0.000050000000\n[EXC]\nGridpoints = {\n"
    ));
    assert!(
        etalon.contains("[EXX]\nGridpoints = {\n-10 -0.002000000000\n10 0.002000000000\n} // end of EXX\n"),
        "{etalon}"
    );
    let csv = body("csv");
    assert!(
        csv.starts_with(
            "parameter,axis,argument,argument_unit,value,value_unit\nEX0C,C,,,0.012000000000,mm\n"
        )
    );
    assert!(csv.contains("\nECC,C,0,deg,0.000003000000,rad\n"), "{csv}");
}

#[test]
fn every_control_takes_what_it_can_and_names_the_rest() {
    for format in FORMATS {
        let taken = (format.takes)(&chain(), &errors());
        let text = (format.write)(&chain(), &taken, CorrectionValues::Error);
        assert!(!format.enter.is_empty() && !format.undo.is_empty(), "{}", format.name);
        for left_out in &taken.left_out {
            let line = format!("does not hold {}: {}", left_out.effect, left_out.why);
            let line = if format.name == "fanuc" { line.replace('(', "[").replace(')', "]") } else { line };
            assert!(text.contains(&line), "{}: {line} in\n{text}", format.name);
        }
    }
    let left_out = |name: &str| -> Vec<String> {
        let format = FORMATS.iter().find(|format| format.name == name).unwrap();
        (format.takes)(&chain(), &errors()).left_out.into_iter().map(|left| left.effect).collect()
    };
    assert_eq!(left_out("csv"), ["backlash:C"]);
    assert_eq!(left_out("siemens"), ["backlash:C", "EYC"], "B turns the axes in which C runs out");
    assert_eq!(left_out("heidenhain"), ["backlash:C", "EXX"], "X carries the tool");
    assert_eq!(left_out("fanuc"), ["backlash:C", "EYC, ECC", "EA0C", "EXX"]);
}

/// Worked by hand: C stands 12 µm in +X and leans by −50 µrad about X, which moves its line through (0, 0, 0) nowhere and turns
/// its direction (0, 0, 1) by (0, +50 µrad, 0).
#[test]
fn the_vectors_point_to_where_the_axis_is() {
    let body = |name: &str| {
        let format = FORMATS.iter().find(|format| format.name == name).unwrap();
        (format.write)(&chain(), &(format.takes)(&chain(), &errors()), CorrectionValues::Error)
    };
    let siemens = body("siemens");
    for line in [
        "$MC_TRAFO5_JOINT_OFFSET_1[0]=$MC_TRAFO5_JOINT_OFFSET_1[0]+0.012000000000",
        "$MC_TRAFO5_PART_OFFSET_1[0]=$MC_TRAFO5_PART_OFFSET_1[0]-0.012000000000",
        "$MC_TRAFO5_AXIS2_1[1]=$MC_TRAFO5_AXIS2_1[1]+_SIGN*(0.000050000000)",
        // A positive value moves the axis back: the error itself. 3 µrad are 0.000172°.
        "$AA_ENC_COMP[0,0,C1]=0.000171887339",
        "$AA_ENC_COMP[0,0,X1]=-0.002000000000",
        "$AA_ENC_COMP_IS_MODULO[0,C1]=1",
    ] {
        assert!(siemens.lines().any(|found| found == line), "{line} in\n{siemens}");
    }
    assert!(!siemens.contains("BASE_TOOL"), "B stands where it should");
    assert!(body("fanuc").contains("\nN19703 R[PRM[19703]+0.012000000000]\n"));
    let heidenhain = body("heidenhain");
    for line in ["EX0C Trans X 0.012000000000 -", "EA0C Trans A -0.002864788976 -", "EYC Trans Y - C..C2"] {
        assert!(heidenhain.lines().any(|found| found == line), "{line} in\n{heidenhain}");
    }
}

/// Worked by hand, for a tool of 100 mm under a head C-B with its spindle C1: B stands 10 µm in +X of its place, the spindle another 14 and leans by
/// 50 µrad about X, which moves the point of the tool (0, 0, −100) by 5 µm in Y. From there C is at (−24, −5), B at (−14, −5) µm. EB0B of 20 µrad shifts
/// the zero of B by 0.001146° and moves no line; the lean about X has no place.
#[test]
fn the_vectors_of_a_head_begin_at_the_tool() {
    let joint = |axis: &str, direction: [f64; 3], spindle: bool| ChainJoint {
        axis: axis.into(),
        rotary: true,
        spindle,
        direction,
        sense: 1.0,
        ..ChainJoint::default()
    };
    let (y, z) = ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let chain = Chain {
        machine: "head-bc-spindle".into(),
        tool: vec![joint("C", z, false), joint("B", y, false), joint("C1", z, true)],
        measured_in_tool_mm: [0.0, 0.0, -100.0],
        ..Chain::default()
    };
    let axis = |axis: &str, location: [f64; 6]| AxisTable {
        axis: axis.into(),
        rotary: true,
        location,
        ..AxisTable::default()
    };
    let errors = AxisErrors {
        axes: vec![
            axis("B", [0.010, 0.0, 0.0, 0.0, 20e-6, 0.0]),
            axis("C1", [0.014, 0.0, 0.0, 50e-6, 0.0, 0.0]),
        ],
        ..AxisErrors::default()
    };
    let written = |name: &str, errors: &AxisErrors| {
        let format = FORMATS.iter().find(|format| format.name == name).unwrap();
        let taken = (format.takes)(&chain, errors);
        let lean = taken.left_out.iter().find(|left| left.effect.starts_with("lean of the tool")).cloned();
        ((format.write)(&chain, &taken, CorrectionValues::Error), lean)
    };
    let (siemens, lean) = written("siemens", &errors);
    for line in [
        "$MC_TRAFO5_BASE_TOOL_1[0]=$MC_TRAFO5_BASE_TOOL_1[0]-0.014000000000",
        "$MC_TRAFO5_BASE_TOOL_1[1]=$MC_TRAFO5_BASE_TOOL_1[1]-0.005000000000",
        "$MC_TRAFO5_JOINT_OFFSET_1[0]=$MC_TRAFO5_JOINT_OFFSET_1[0]-0.010000000000",
        "$MC_TRAFO5_PART_OFFSET_1[0]=$MC_TRAFO5_PART_OFFSET_1[0]+0.024000000000",
        "$MC_TRAFO5_PART_OFFSET_1[1]=$MC_TRAFO5_PART_OFFSET_1[1]+0.005000000000",
        "$AA_ENC_COMP[0,0,B1]=0.001145915590",
        "$AA_ENC_COMP[0,1,B1]=0.001145915590",
    ] {
        assert!(siemens.lines().any(|found| found == line), "{line} in\n{siemens}");
    }
    assert!(!siemens.contains("JOINT_OFFSET_1[1]"), "both lines are as far from the tool in Y: {siemens}");
    let lean = lean.unwrap();
    assert_eq!(lean.effect, "lean of the tool, 50 µrad");
    assert!(lean.why.contains("a tool of 100 mm"), "{}", lean.why);
    let (fanuc, _) = written("fanuc", &errors);
    for line in [
        "N19709 R[PRM[19709]-0.014000000000]",
        "N19710 R[PRM[19710]-0.005000000000]",
        "N19712 R[PRM[19712]-0.010000000000]",
    ] {
        assert!(fanuc.lines().any(|found| found == line), "{line} in\n{fanuc}");
    }
    assert!(!fanuc.contains("N19713"), "{fanuc}");
}

/// B and C under the workpiece, X Y Z under the tool.
fn chain() -> Chain {
    let joint = |axis: &str, direction: [f64; 3]| ChainJoint {
        axis: axis.into(),
        rotary: ["B", "C"].contains(&axis),
        direction,
        sense: 1.0,
        ..ChainJoint::default()
    };
    Chain {
        machine: "table-bc".into(),
        table: vec![joint("B", [0.0, 1.0, 0.0]), joint("C", [0.0, 0.0, 1.0])],
        tool: vec![joint("X", [1.0, 0.0, 0.0]), joint("Y", [0.0, 1.0, 0.0]), joint("Z", [0.0, 0.0, 1.0])],
        ..Chain::default()
    }
}

/// EX0C 12 µm, EA0C −50 µrad, a little EYC and ECC, 200 µm/m of scale in X.
fn errors() -> AxisErrors {
    let turn = |eyc: f64, ecc: f64| [0.0, eyc, 0.0, 0.0, 0.0, ecc];
    let along_x = |exx: f64| [exx, 0.0, 0.0, 0.0, 0.0, 0.0];
    AxisErrors {
        machine: "table-bc".into(),
        runs: vec!["monday".into()],
        axes: vec![
            AxisTable {
                axis: "C".into(),
                rotary: true,
                location: [0.012, 0.0, 0.0, -50e-6, 0.0, 0.0],
                positions: vec![0.0, 180.0, 360.0],
                errors: vec![turn(1e-3, 3e-6), turn(-1e-3, 0.0), turn(1e-3, 3e-6)],
                whole_turn: true,
            },
            AxisTable {
                axis: "X".into(),
                positions: vec![-10.0, 10.0],
                errors: vec![along_x(-2e-3), along_x(2e-3)],
                ..AxisTable::default()
            },
        ],
        effects: vec!["location-errors".into(), "linear-scale:X".into()],
        left_out: vec![LeftOutEffect {
            effect: "backlash:C".into(),
            why: "it depends on the direction of C".into(),
        }],
        ..AxisErrors::default()
    }
}
