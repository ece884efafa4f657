//! What a scene cannot show is out of reach, and what it can show is not.

use crate::scenes::{machines, rich_states, scene};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use trunnion_core::{AxisValues, Joint, State};
use trunnion_effects::{Instance, Need};
use trunnion_machine::{Machine, shipped};

/// Takes something from the state with this number.
type Poorer = &'static dyn Fn(usize, &mut State);

#[test]
fn an_effect_is_out_of_reach_exactly_when_the_data_lack_one_of_its_needs() {
    let poorer: [Poorer; 9] = [
        &|_, _| {},
        &|_, s| s.time_s = None,
        &|_, s| s.temperature_degc = vec![20.0],
        &|_, s| s.direction = AxisValues::from_fn(|_| 1.0),
        &|_, s| s.deflection_mm = Vector3::zeros(),
        &|_, s| s.velocity = AxisValues::default(),
        &|_, s| {
            s.velocity = AxisValues::from_fn(|_| 0.5);
            s.acceleration = AxisValues::default();
        },
        &|_, s| s.position[Joint::B] = 0.3,
        &|i, s| {
            // Each state moves linear axes or rotary axes, never both.
            s.velocity =
                AxisValues::from_fn(|l| if l.is_rotary() == (i % 2 == 0) { s.velocity[l] } else { 0.0 });
        },
    ];
    for machine in machines() {
        for (case, make_poorer) in poorer.iter().enumerate() {
            let mut states = rich_states(&machine);
            states.iter_mut().enumerate().for_each(|(i, state)| make_poorer(i, state));
            let scene = scene(&machine, &states);
            for instance in Instance::all(&machine) {
                let why = instance.out_of_reach(&scene);
                let empty = instance.parameters(&scene).is_empty();
                assert_eq!(why.is_some(), empty, "{} {} case {case}: {why:?}", machine.name, instance.id());
            }
        }
    }
    assert!(Need::ALL.iter().all(|need| need.text().len() > 5));
}

/// Phenomena with parameters in a scene, out of those the machine can have.
fn in_reach(machine: &Machine, states: &[State]) -> BTreeMap<String, bool> {
    let scene = scene(machine, states);
    Instance::all(machine).iter().map(|i| (i.id(), !i.parameters(&scene).is_empty())).collect()
}

#[test]
fn what_a_scene_cannot_show_is_out_of_reach() {
    let machine = shipped::machine("table-bc").unwrap();
    // Static points without time, temperature or direction; C never moves.
    let states: Vec<State> = (0..5)
        .map(|i| {
            let mut state = State::default();
            state.position[Joint::B] = f64::from(i) * 0.3;
            state.position[Joint::X] = f64::from(i) * 10.0;
            state
        })
        .collect();
    let reach = in_reach(&machine, &states);
    let of = |ids: &[&str], within: bool| {
        for id in ids {
            assert_eq!(reach[*id], within, "{id}");
        }
    };
    of(
        &[
            "location-errors",
            "ball-setting",
            "artefact-form",
            "ball-form",
            "straightness:X",
            "linear-scale:X",
        ],
        true,
    );
    of(&["gravity-sag:B", "encoder-eccentricity:B", "drive-pitch:B", "radial-error-motion:B"], true);
    of(&["straightness:Y", "linear-scale:Y", "component-errors:X", "unbalance:C", "drive-pitch:C"], false);
    of(&["backlash:B", "direction-shift:B", "thermal-drift", "thermal-expansion", "spindle-growth"], false);
    of(&["servo-lag:X", "sync-delay", "clamp-shift:B", "probe-gain", "nest-rotation", "vibration"], false);
}

#[test]
fn an_effect_needs_its_own_kind_of_evidence() {
    let machine = shipped::machine("table-bc").unwrap();
    let check = |lacking: &[Need], poorer: &dyn Fn(&mut State)| {
        let mut states = rich_states(&machine);
        states.iter_mut().for_each(poorer);
        let scene = scene(&machine, &states);
        let mut lost = 0;
        for instance in Instance::all(&machine) {
            let needs = instance.about().unwrap().needs;
            let lacks = needs.iter().any(|need| lacking.contains(need));
            assert_eq!(instance.parameters(&scene).is_empty(), lacks, "{} {lacking:?}", instance.id());
            lost += usize::from(lacks);
        }
        assert!(lost > 0, "nothing needs {lacking:?}");
    };
    check(&[Need::TimeStamps], &|s| s.time_s = None);
    check(&[Need::TimeStamps], &|s| s.time_s = Some(5.0));
    check(&[Need::Temperature], &|s| s.temperature_degc = vec![20.0]);
    check(&[Need::BothDirections], &|s| s.direction = AxisValues::from_fn(|_| 1.0));
    check(&[Need::Deflection], &|s| s.deflection_mm = Vector3::zeros());
    check(&[Need::OnTheFly, Need::ChangingSpeed, Need::RestAndMotion, Need::DelayShows], &|s| {
        s.velocity = AxisValues::default();
        s.acceleration = AxisValues::default();
    });
}
