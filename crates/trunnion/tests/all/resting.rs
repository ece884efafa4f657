//! Runs in which an axis stands still: what its errors do to the numbers of the other axis is said, and goes into no control.

use crate::mistakes::Files;
use trunnion::report::compensation::FORMATS;
use trunnion::results::{CorrectionValues, Verdict};

/// The truth of these points: EX0C = 3.86 µm, EZ0B = −30.8 µm. With B at −90° the two are one.
#[test]
fn numbers_that_hold_errors_of_a_resting_axis_say_so_and_go_into_no_control() {
    let mut files = Files::committed("points-nothing-hidden");
    let b = files.column("b_deg");
    files.rows.retain(|row| row[b].parse::<f64>().unwrap() == -90.0);
    let run = files.open();
    let fit = run.fit(&run.base_model()).unwrap();
    let found = fit.results();
    let ex0c = found.parameters.iter().find(|parameter| parameter.name == "EX0C").unwrap();
    assert!(ex0c.value.unwrap() < -25.0, "{ex0c:?}");
    assert_eq!(ex0c.note, "contains EZ0B, its axis at rest");
    assert_eq!(ex0c.at_rest, ["EZ0B"]);
    let siemens = FORMATS.iter().find(|format| format.name == "siemens").unwrap();
    let refused = fit.correction(siemens, CorrectionValues::default(), Verdict::NoiseFloor).err().unwrap();
    let why = trunnion::chain(&refused);
    assert!(why.contains("EX0C holds EZ0B as well, whose axis was at rest"), "{why}");
}
