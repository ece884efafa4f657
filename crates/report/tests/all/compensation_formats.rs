//! Compensation files as text, and their registry.

use crate::section::write_or_compare;
use trunnion_report::compensation::FORMATS;
use trunnion_results::{AxisErrors, AxisTable, CompensationValues, LeftOutEffect};

#[test]
fn the_registry_holds_every_format_file_and_nothing_else() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/compensation");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    files.retain(|name| name != "format");
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
fn the_guide_lists_the_formats() {
    let mut table = String::from("| format | file | read by |\n|---|---|---|\n");
    for format in FORMATS {
        table += &format!("| `{}` | {} | {} |\n", format.name, format.about, format.readers);
    }
    write_or_compare("docs/use/compensation.md", "formats", &table);
}

#[test]
fn every_format_says_sign_units_range_and_what_is_missing() {
    for format in FORMATS {
        let text = (format.write)(&errors(), CompensationValues::Error);
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
        let corrections = (format.write)(&errors(), CompensationValues::Correction);
        assert!(corrections.contains("values = correction (-error"), "{}", format.name);
        assert!(text.contains(" 0.002") || text.contains(",0.002"), "{text}");
        assert!(corrections.contains("-0.002") && !corrections.contains("-0.000000000000"), "{corrections}");
    }
}

#[test]
fn the_bodies_are_laid_out_as_the_controllers_describe_them() {
    let body = |name: &str| {
        let format = FORMATS.iter().find(|format| format.name == name).unwrap();
        let text = (format.write)(&errors(), CompensationValues::Error);
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
