//! Places of an axis that was read in many poses.

use nalgebra::Point3;
use trunnion_core::{Joint, State};
use trunnion_effects::{Scene, SceneSetup};
use trunnion_machine::shipped;

/// Five targets, ten visits each, off by up to 20 µm and 50 µrad; wherever the targets lie, also on multiples of any length.
#[test]
fn scatter_makes_no_places() {
    let machine = shipped::machine("table-bc").unwrap();
    for first_mm in [0.0, 0.0125, 0.025, 0.0375] {
        let states: Vec<State> = (0..50)
            .map(|i| {
                let off = f64::from(i / 5) / 4.5 - 1.0;
                let mut state = State::default();
                state.position[Joint::X] = first_mm + 80.0 * f64::from(i % 5) + 20e-3 * off;
                state.position[Joint::C] = 0.5e-3 + 50e-6 * off;
                state
            })
            .collect();
        let setups = vec![SceneSetup::r_test("ball", Point3::origin())];
        let scene = Scene::new(machine.clone(), setups, Vec::new(), states.iter());
        assert_eq!(scene.places_at_one_pose[Joint::X], 5, "from {first_mm} mm");
    }
}
