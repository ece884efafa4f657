//! Pass or fail of a run: of what a control can be given, whatever the tolerance, with what was excluded next to it.

use crate::mistakes::Files;
use trunnion::report::compensation::format;
use trunnion::results::{Conformity, CorrectionValues, Decision, Verdict};
use trunnion::{Experiment, Fit};

fn with_added(run: &Experiment, effect: &str) -> Fit {
    run.fit(&run.base_model()).unwrap().add(effect).unwrap().fit().clone()
}

fn judged(fit: &Fit, tolerance_um: f64) -> Conformity {
    fit.conformity(tolerance_um, "given with the command").unwrap()
}

/// A backlash is no function of a position: no table of an axis holds it.
#[test]
fn what_no_table_of_an_axis_holds_is_left_in_what_a_correction_is_expected_to_leave() {
    let run = Files::committed("points-backlash-and-drift").open();
    let fit = with_added(&run, "backlash:C");
    let conformity = judged(&fit, 20.0);
    let tables = format("csv").unwrap();
    let correction = fit.correction(tables, CorrectionValues::default(), Verdict::NoiseFloor).unwrap();
    let expected = correction.results(String::new()).expected.unwrap();
    assert_eq!(conformity.corrected.largest_um, expected.largest_after_um, "one answer");
    let left: Vec<&str> = conformity.not_corrected.iter().map(|left| left.effect.as_str()).collect();
    assert_eq!(left, ["backlash:C"]);
    let residuals = fit.compare().results().residuals.points;
    let sizes_um = residuals.iter().map(|of| of.residual_um.iter().map(|um| um * um).sum::<f64>().sqrt());
    let explained_um = sizes_um.fold(0.0, f64::max);
    assert!(conformity.corrected.largest_um > explained_um + 1.0, "{conformity:?}, {explained_um}");
}

#[test]
fn an_excluded_point_stands_next_to_one_largest_deviation_and_no_tolerance_passes_it() {
    let mut files = Files::committed("points-nothing-hidden");
    let dx = files.column("dx_um");
    let wrong = files.rows[40][dx].parse::<f64>().unwrap() + 60.0;
    files.rows[40][dx] = wrong.to_string();
    let run = files.open();
    let fit = run.fit(&run.base_model()).unwrap();
    let expected = [(20.0, Decision::NotDecidable), (50.0, Decision::NotDecidable), (100.0, Decision::Pass)];
    for (tolerance_um, decision) in expected {
        let corrected = judged(&fit, tolerance_um).corrected;
        assert_eq!(corrected.decision, decision, "{tolerance_um}: {corrected:?}");
        assert!(corrected.largest_um < 3.0, "{tolerance_um}: {corrected:?}");
        let excluded = corrected.excluded.unwrap();
        assert!(excluded.count == 1 && (excluded.largest_um - 60.0).abs() < 3.0, "{excluded:?}");
    }
}
