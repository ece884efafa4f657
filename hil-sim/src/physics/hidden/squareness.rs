//! Two linear axes are not square.
//!
//! The later axis of the chain turns about the third direction: EC0Y for XY, EA0Z for YZ, EB0Z for ZX [S2 table 2].
//! Its travel leans: displacement = angle × travel. Looks like a shear of the volume.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "squareness",
    about: "two linear axes are not square",
    amplitude: "angle, rad",
    places: &[
        Place::Pair(Joint::X, Joint::Y),
        Place::Pair(Joint::Y, Joint::Z),
        Place::Pair(Joint::Z, Joint::X),
    ],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["sign"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    vec![any_sign(rng)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [sign] = numbers(shape);
    let Place::Pair(one, other) = scene.place else { return Disturbance::default() };
    let leaning = one.max(other);
    let about = chain::unit(one).cross(&chain::unit(other));
    // A leaning guide displaces its carriage by angle × travel; the carriage itself need not turn.
    let travel = chain::unit(leaning) * scene.state.position[leaning];
    Disturbance::joint(leaning, Twist::translation(about.cross(&travel) * sign))
}
