//! Values of the error motions of an axis that turns alone.

use crate::empty_runs::empty;
use trunnion_methods::findings::ValueKind;
use trunnion_methods::recipes::{self, MethodOptions};

const UM: f64 = 1e-3;

#[test]
fn the_largest_totals_are_what_the_measurement_comes_to() {
    let method = recipes::find("rotary-values").unwrap();
    let found = method.apply(&[empty("rotary-values-c", 3)], &MethodOptions::default()).unwrap();
    let first: Vec<_> = found.values.iter().filter(|value| value.kind == ValueKind::Summary).collect();
    let largest = |motion: &str| {
        let totals = found.values.iter().filter(|v| v.name.contains(motion) && v.name.ends_with(".total"));
        totals.map(|v| v.value).fold(0.0, f64::max)
    };
    let sizes: Vec<f64> = first.iter().map(|value| value.value).collect();
    for motion in ["radial", "axial", "tilt"] {
        assert!(sizes.contains(&largest(motion)), "{motion}: {first:?}");
    }
    assert_eq!(first.len(), 3, "{first:?}");
    assert!(first.iter().all(|value| value.note.contains("total error motion")), "{first:?}");
}

/// A total value is a largest distance: one wrong reading would be all of it.
#[test]
fn single_wrong_readings_count_in_no_value_and_are_named() {
    let good = empty("rotary-values-c", 3);
    let mut wrong = good.clone();
    let spiked = [40, 121, 230];
    for (k, &i) in spiked.iter().enumerate() {
        wrong.points[i].reading_mm[k] += 25.0 * UM;
    }
    for name in ["rotary-values", "two-height"] {
        let found = [&good, &wrong].map(|run| {
            let method = recipes::find(name).unwrap();
            method
                .apply(std::slice::from_ref(run), &MethodOptions::default())
                .unwrap_or_else(|error| panic!("{error}"))
        });
        let [of_good, of_wrong] = &found;
        assert_eq!((of_good.excluded, of_wrong.excluded), (0, spiked.len()), "{name}");
        assert!(of_wrong.notes[0].contains("(row 41 to row 231) lie far"), "{name}: {:?}", of_wrong.notes);
        for (a, b) in of_good.values.iter().zip(&of_wrong.values) {
            let off = (a.value - b.value).abs();
            assert!(off < 0.3 * UM, "{name}, {}: {} and {}", a.name, a.value, b.value);
        }
    }
}
