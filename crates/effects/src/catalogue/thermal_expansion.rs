//! Displacement of the tool side that follows a temperature channel, with a lag.
//!
//! u = Σ_channels a_channel (θ_channel − θ_channel,first),  τ dθ/dt = T_channel − θ           [docs/design/physics.md §9.12; ISO 230-3; ISO/TR 16015]
//! for x, y, z in machine axes; τ one shape number for all channels, 0 follows at once. See `History` for the filter.
//! Limits: proportional; the structure is soaked at the first point of each run; only channels that change take part;
//! without time stamps no lag.

use super::thermal_drift::TAU_OF_DURATION;
use crate::subjects::whole_tool_side;
use crate::{
    About, Effect, Emit, Example, Golden, Limit, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit,
    View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "thermal-expansion",
    role: Role::CAUSE,
    about: About {
        title: "Expansion with a measured temperature",
        source: "docs/design/physics.md §9.12; ISO 230-3; ISO/TR 16015",
        equation: "u = Σ a·(θ − θ_first) for x, y, z and each temperature channel, τ dθ/dt = T − θ",
        symbols: "T temperature of the channel, K; θ temperature of the structure, which follows with time constant τ, s (shape number tau_s, 0 = at once); a displacement of the tool side in machine axes, µm/K",
        validity: "Proportional to θ; the structure is soaked at the first point; one lag for all channels; without time stamps no lag.",
        typical: "1–10 µm/K, τ 5–60 min",
        explanation: "The tool wanders with the temperature of a measured spot of the machine, at once or some time later.",
        cause: "Expansion of structure, scales or screws; compensation off or with a wrong coefficient.",
        seen_by: "Temperatures recorded with the points, and a temperature that goes up and down.",
        needs: &[Need::Temperature],
        helps: &[Need::TimeStamps, Need::Return],
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes,
    motions,
    example: Example {
        id: "thermal-expansion",
        shape: &[1200.0],
        values: &[("frame.x", 2.0), ("frame.z", 5.0)],
        view: View::Time(7200.0),
    },
    golden: Golden {
        source: "ISO 3650 (steel: 11.5 µm/(m·K))",
        derivation: "A column of 500 mm of steel grows 5.75 µm/K: 11.5 µm when it is 2 K warmer.",
        id: "thermal-expansion",
        shape: &[0.0],
        values: &[("frame.z", 5.75)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { time_s: 60.0, frame_degc: 22.0, read_um: Some([0.0, 0.0, 11.5]), ..Moment::AT_REST },
        ],
        within_um: 0.05,
    },
};

/// Expansion of aluminium, µm/(mm·K); steel has half of it [ISO 3650].
const ALUMINIUM: f64 = 24e-3;

/// The way from tool to table goes along every linear axis there and back: no machine expands more than aluminium over that.
fn expansion(scene: &Scene) -> Limit {
    let travel_mm: f64 = scene
        .machine
        .axes()
        .filter(|axis| !axis.letter.is_rotary())
        .map(|axis| axis.travel.1 - axis.travel.0)
        .sum();
    Limit {
        largest: ALUMINIUM * 2.0 * travel_mm,
        beyond: "no material expands so much on a machine of this size; the temperatures do not show what warms: sensors that \
                 rise together, or none at the source",
        resembles: false,
    }
}

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let name = |channel: usize, direction: &str| {
        Parameter::new(format!("{}.{direction}", scene.channels[channel]), Unit::UM_PER_K)
            .at_most(expansion(scene))
    };
    scene.varying_channels().into_iter().flat_map(|i| ["x", "y", "z"].map(|k| name(i, k))).collect()
}

fn shapes(scene: &Scene, _: Subject) -> Shapes {
    let duration_s = scene.duration_s().filter(|duration_s| *duration_s > 0.0);
    let lags_s =
        duration_s.into_iter().flat_map(|duration_s| TAU_OF_DURATION.map(|share| share * duration_s));
    Shapes::one("tau_s", std::iter::once(0.0).chain(lags_s), duration_s.is_some())
}

fn motions(scene: &Scene, _: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let &[tau_s] = shape else { return };
    let (site, into_site) = whole_tool_side(&scene.machine, state);
    for (i, channel) in scene.varying_channels().into_iter().enumerate() {
        let Some(felt_degc) = scene.lagged_temperature_degc(channel, tau_s, state) else { continue };
        let change_k = felt_degc - scene.first_temperature_degc[channel];
        for k in 0..3 {
            emit(3 * i + k, site, Twist::translation(into_site * Vector3::ith(k, change_k)));
        }
    }
}
