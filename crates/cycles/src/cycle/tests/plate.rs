//! Circles under a head over a grid plate.

use super::*;

/// It has half a millimetre to the plate: not even the strokes of the synchronisation move may use it.
#[test]
fn a_head_over_a_grid_plate_keeps_its_distance_on_the_whole_course() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles");
    for (name, normal) in [
        ("cross-grid-circle-xy", Joint::Z),
        ("cross-grid-circle-yz", Joint::X),
        ("cross-grid-circle-zx", Joint::Y),
        ("cross-grid-small", Joint::Z),
    ] {
        let text = std::fs::read_to_string(format!("{folder}/{name}.toml")).unwrap();
        let cycle = Cycle::parse(name, &text).unwrap();
        let machine = shipped::machine(&cycle.machine).unwrap();
        let mut strokes = 0;
        for step in cycle.course(&machine, &CourseRules::default()).unwrap() {
            let places: Vec<AxisValues<f64>> = match step {
                course::Step::SyncMove { pieces, .. } => {
                    strokes += pieces.len();
                    pieces.into_iter().map(|(end, _)| end).collect()
                }
                course::Step::Transfer { pieces } => pieces.into_iter().map(|(end, _)| end).collect(),
                course::Step::Sweep { ends, .. } => ends,
                _ => Vec::new(),
            };
            assert!(places.iter().all(|at| at[normal].abs() < 1e-9), "{name}");
        }
        assert!(strokes > 0, "{name}");
    }
}

#[test]
fn a_circle_has_its_own_radius_and_its_feed_along_it() {
    let text = include_str!("../../../../../config/cycles/cross-grid-small.toml");
    let cycle = Cycle::parse("c.toml", text).unwrap();
    let visits = cycle.visits(&shipped::machine(&cycle.machine).unwrap(), &Pace::default()).unwrap();
    for state in &visits.states {
        let (place, speed) = (&state.position, &state.velocity);
        assert!((place[Joint::X].hypot(place[Joint::Y]) - 1.0).abs() < 1e-12);
        assert!((speed[Joint::X].hypot(speed[Joint::Y]) - 100.0 / 60.0).abs() < 1e-6);
    }
    let without = text.replace("radius_mm = 1\n", "");
    let shown = Cycle::parse("c.toml", &without).unwrap_err().to_string();
    assert!(shown.contains("has no radius") && shown.contains("radius_mm of a circle"), "{shown}");
}

/// Every target once, in order of time, the tool's tip on it and the tool's axis in the surface.
#[test]
fn a_cone_is_cut_circle_by_circle_through_its_targets() {
    let cycle =
        Cycle::parse("c.toml", include_str!("../../../../../config/cycles/machined-cone.toml")).unwrap();
    let machine = shipped::machine(&cycle.machine).unwrap();
    let visits = cycle.visits(&machine, &Pace::default()).unwrap();
    let (setup, none) = (&cycle.setups[0], JointErrors::default());
    let artefact = setup.artefact.as_ref().unwrap();
    assert_eq!(visits.states.len(), artefact.targets.len());
    for (k, state) in visits.states.iter().enumerate() {
        assert_eq!(state.target, k);
        let table = machine.machine_from_table(&state.position, &none);
        let tool = machine.machine_from_tool(&state.position, &none);
        let tip = table.inverse() * (tool * setup.ball_in_tool_mm);
        assert!((tip - setup.target_in_table_mm(k)).norm() < 1e-6, "{k} {tip}");
        let along = table.rotation.inverse() * (tool.rotation * Vector3::z());
        assert!(along.dot(&artefact.normal_in_table(k).unwrap()).abs() < 1e-6, "{k}");
    }
    let times: Vec<f64> = visits.states.iter().map(|state| state.time_s.unwrap()).collect();
    assert!(times.windows(2).all(|pair| pair[1] > pair[0]));
}
