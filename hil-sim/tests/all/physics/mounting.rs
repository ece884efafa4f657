//! The same machine with other setups.

use super::{low_and_high, setup, table_bc};
use trunnion_hil_sim::{NestOn, Truth};

#[test]
fn a_setup_of_the_truth_keeps_its_setting_in_run_0_and_is_mounted_again_later() {
    let truth = Truth::draw(&table_bc(), &low_and_high(), &[], 1700.0, 5).unwrap();
    let mut wanted = low_and_high();
    wanted.push(setup("low", NestOn::Table, [150.0, 0.0, 61.0]));
    let first = truth.mounted(&wanted, 0);
    assert_eq!(first.setups[..2], truth.setups[..]);
    let drawn = first.setups[2].setting_mm;
    assert!(drawn.norm() > 1e-3 && drawn.norm() < 0.1, "{drawn}");
    assert_eq!(truth.mounted(&wanted, 0), first);
    let later = truth.mounted(&wanted, 1);
    for (placed, before) in later.setups.iter().zip(&first.setups) {
        assert_eq!(placed.setup, before.setup);
        assert!((placed.setting_mm - before.setting_mm).norm() > 1e-4);
    }
    assert_eq!((later.location, &later.hidden, later.noise), (truth.location, &truth.hidden, truth.noise));
}
