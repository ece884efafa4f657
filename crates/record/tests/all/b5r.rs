//! Result files of a QC20-W. The file here is made by hand from the public names; none of the maker's is at hand.

use trunnion_record::b5r::{BarResult, BarResultError, Feature};

const FILE: &str = r#"<?xml version="1.0"?>
<REPORT>
  <TEST_SPEC NAME="XY 150 mm"><PLANE TEST_PLANE="XY"/></TEST_SPEC>
  <OPERATOR>N. N.</OPERATOR><DATE_STARTED>2026-03-04 10:11</DATE_STARTED>
  <MACHINE_TESTED NAME="Mill 4"/><SERIAL_NUMBER>A1</SERIAL_NUMBER><LAST_CALIBRATED>2026-01-02</LAST_CALIBRATED>
  <SOMETHING_ELSE><FEATURE/></SOMETHING_ELSE>
  <FEATURE NAME="AF_CIRCULARITY" DT="UT_LENGTH_MM">0.0086</FEATURE>
  <FEATURE NAME="AF_SQUARENESS" DT="UT_SQUARENESS">-29.4</FEATURE>
  <FEATURE NAME="AF_BACKLASH_A_POS" DT="UT_LENGTH_UM">2.1</FEATURE>
</REPORT>"#;

#[test]
fn header_and_features_are_read_wherever_they_stand() {
    let feature = |name: &str, value, unit| Feature { name: name.into(), value, unit };
    let text = |text: &str| Some(text.to_string());
    let expected = BarResult {
        test: text("XY 150 mm"),
        operator: text("N. N."),
        begun: text("2026-03-04 10:11"),
        machine: text("Mill 4"),
        serial_number: text("A1"),
        calibrated: text("2026-01-02"),
        plane: text("XY"),
        features: vec![
            feature("AF_CIRCULARITY", 8.6, "µm"),
            feature("AF_SQUARENESS", -29.4, "µm/m"),
            feature("AF_BACKLASH_A_POS", 2.1, "µm"),
        ],
    };
    assert_eq!(BarResult::parse(FILE).unwrap(), expected);
}

#[test]
fn a_file_of_another_kind_or_cut_short_says_why_nothing_is_read() {
    let wrong = |text: &str| BarResult::parse(text).unwrap_err();
    assert!(matches!(wrong("<MTConnectStreams/>"), BarResultError::NoFeature));
    assert!(matches!(wrong(&FILE[..FILE.len() / 2]), BarResultError::NoFeature | BarResultError::Xml { .. }));
    assert!(matches!(wrong("<A></B>"), BarResultError::Xml { .. }));
    let unknown = wrong(&FILE.replace("UT_LENGTH_UM", "UT_FURLONG")).to_string();
    assert!(unknown.contains("AF_BACKLASH_A_POS") && unknown.contains("UT_FURLONG"), "{unknown}");
    assert!(wrong(&FILE.replace("-29.4", "many")).to_string().contains("many"));
}
