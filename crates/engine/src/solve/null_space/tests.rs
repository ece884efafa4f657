use super::*;

const ROWS: usize = 200;
const NOISE_MM: f64 = 0.3e-3;
/// By which the second column differs from the first, forth and back: noise leaves each parameter uncertain by 3 mm, the readings by 0.3 mm.
const DIFFERS: f64 = 7e-6;

/// Whether both of two lengths that the readings show together, and hardly apart, are determined.
fn both_determined(free: &Free) -> bool {
    let differs = |row: usize| if row.is_multiple_of(2) { DIFFERS } else { -DIFFERS };
    let design = DMatrix::from_fn(ROWS, 2, |row, column| 0.1 + if column == 1 { differs(row) } else { 0.0 });
    let parameters = ["first", "second"].map(|name| Parameter::new(name, Unit::UM));
    let nothing = DMatrix::zeros(2, 2);
    let limits =
        Limits { tolerance: 1e-12, off_nominal: &nothing, weakest: 0.0, rows: ROWS, rows_moved: ROWS as f64 };
    let limits = limits.with_noise(NOISE_MM, ROWS);
    datum(&Reduced::from_design(&design), free, &parameters, &[], &limits).determined.len() == 2
}

#[test]
fn what_noise_leaves_uncertain_by_more_than_machines_are_aligned_to_is_null_and_a_cause_is_not_aligned() {
    let (base, added) = (vec![0, 1], vec![0, 1]);
    assert!(!both_determined(&Free { base, added: Vec::new(), settings: Vec::new() }));
    assert!(both_determined(&Free { base: Vec::new(), added, settings: Vec::new() }));
}
