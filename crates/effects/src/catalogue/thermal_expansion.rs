//! Displacement of the tool side that follows a temperature channel.
//!
//! u = Σ_channels a_channel (T_channel − T_channel,first) for x, y, z in machine axes           [METHODS §9]
//! Limits: proportional, without lag; only channels whose temperature changes take part.

use crate::subjects::whole_tool_side;
use crate::{About, Effect, Emit, Parameter, Scene, Shapes, Subject, Unit};
use nalgebra::Vector3;
use trunnion_machine::State;
use trunnion_units::Twist;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "thermal-expansion",
    about: About {
        title: "Expansion with a measured temperature",
        source: "METHODS §9; ISO 230-3",
        equation: "u = Σ a·(T − T_first) for x, y, z and each temperature channel",
        validity: "Proportional to the channel, no lag between sensor and structure.",
        typical: "1–10 µm/K",
        explanation: "The tool wanders with the temperature of a measured spot of the machine.",
        cause: "Expansion of structure, scales or screws; compensation off or with a wrong coefficient.",
        seen_by: "Temperatures recorded with the points, and a temperature that goes up and down.",
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
};

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let name = |channel: usize, direction: &str| {
        Parameter::new(format!("{}.{direction}", scene.channels[channel]), Unit::UM_PER_K)
    };
    scene.varying_channels().into_iter().flat_map(|i| ["x", "y", "z"].map(|k| name(i, k))).collect()
}

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let site = whole_tool_side(&scene.machine);
    for (i, channel) in scene.varying_channels().into_iter().enumerate() {
        let Some(&temperature_degc) = state.temperature_degc.get(channel) else { continue };
        let change_k = temperature_degc - scene.first_temperature_degc[channel];
        for k in 0..3 {
            emit(3 * i + k, site, Twist::translation(Vector3::ith(k, change_k)));
        }
    }
}
