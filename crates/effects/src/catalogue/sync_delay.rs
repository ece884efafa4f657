//! Delay between the axis positions and the readings.
//!
//! e = −T v on the positioning error of every axis at once       [METHODS §9; DESIGN §4: latency between control and probes]
//! The reading belongs to where the machine was T earlier. Limits: on the fly; hidden where the motion keeps the distance of ball and nest.

use crate::{About, Effect, Emit, Parameter, Scene, Shapes, Subject, Unit};
use trunnion_machine::{Site, State};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "sync-delay",
    about: About {
        title: "Delay between control and probes",
        source: "METHODS §9; S4 §2 (synchronisation error)",
        equation: "e = −T v on the positioning error of every axis",
        validity: "Read on the fly; one delay for the whole experiment.",
        typical: "1–10 ms: 21 µm per ms at 360°/min on R 200 mm",
        explanation: "Positions and readings were not taken at the same instant.",
        cause: "Time on the way through control, network and probe electronics; not an error of the machine.",
        seen_by: "Both directions of travel at two feeds, on a motion that changes the distance of ball and nest.",
    },
    subjects: |_| vec![Subject::Whole],
    parameters: |scene, _| {
        if scene.on_the_fly { vec![Parameter::new("delay", Unit::MS)] } else { Vec::new() }
    },
    shapes: |_, _| Shapes::none(),
    motions,
};

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    for axis in scene.machine.axes() {
        emit(0, Site::Joint(axis.letter), axis.positioning_twist() * -state.velocity[axis.letter]);
    }
}
