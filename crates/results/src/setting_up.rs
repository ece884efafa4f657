//! Answers of setting up at the machine: the calibrated nest, and what a jog says of the probes.

use crate::number::plain;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_sync::jog::{JogAnswer, Standing};
use trunnion_sync::nest::{NestFit, NestStep};

/// `trunnion-nest/1`: directions of the probes from known steps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NestCalibrated {
    /// Format and version.
    pub format: NestFormat,
    /// Dwells that were used.
    pub steps: usize,
    /// The probes in their order.
    pub probes: Vec<CalibratedProbe>,
    /// How much an error of the probes grows in nest axes.
    pub condition: f64,
    /// The table `[nest]` of a configuration.
    pub lines: String,
}

/// Format and version of a calibrated nest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum NestFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-nest/1")]
    V1,
}

/// One probe of a calibrated nest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CalibratedProbe {
    /// Its role, e.g. `probe-1`.
    pub role: String,
    /// Unit direction in which it reads positive, nest axes.
    pub direction: [f64; 3],
    /// Its gain.
    pub gain: f64,
    /// Standard uncertainty of the direction about an axis across it, mrad.
    pub u_direction_mrad: f64,
    /// Standard uncertainty of the gain.
    pub u_gain: f64,
    /// Residual, µm rms.
    pub residual_um: f64,
}

impl NestCalibrated {
    /// Directions for `[nest]`; with gains their lengths are those.
    pub fn directions(&self, with_gains: bool) -> Option<[[f64; 3]; 3]> {
        let of = |probe: &CalibratedProbe| {
            probe.direction.map(|part| part * if with_gains { probe.gain } else { 1.0 })
        };
        match self.probes.as_slice() {
            [first, second, third] => Some([first, second, third].map(of)),
            _ => None,
        }
    }

    /// From a fit to so many steps; the table holds the gains where `with_gains`.
    pub fn new(fit: &NestFit, steps: usize, with_gains: bool) -> Self {
        let row = |k: usize| if with_gains { fit.directions[k] * fit.gains[k] } else { fit.directions[k] };
        let line = |k: usize| {
            let [x, y, z]: [f64; 3] = row(k).into();
            format!("probe_{} = [{x:.7}, {y:.7}, {z:.7}]\n", k + 1)
        };
        let probe = |k: usize| CalibratedProbe {
            role: format!("probe-{}", k + 1),
            direction: fit.directions[k].into(),
            gain: fit.gains[k],
            u_direction_mrad: 1e3 * fit.u_direction_rad[k],
            u_gain: fit.u_gain[k],
            residual_um: 1e3 * fit.residual_rms_mm[k],
        };
        Self {
            format: NestFormat::V1,
            steps,
            probes: [0, 1, 2].map(probe).into(),
            condition: fit.condition,
            lines: format!("[nest]\n{}{}{}", line(0), line(1), line(2)),
        }
    }
}

/// `trunnion-sign-test/1`: what jogs of the machine say of the probes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SignTest {
    /// Format and version.
    pub format: SignTestFormat,
    /// The jogs.
    pub jogs: Vec<Jog>,
    /// What they say.
    pub finding: SignFinding,
    /// The same as a sentence, with what to do.
    pub say: String,
}

/// Format and version of a sign test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SignTestFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-sign-test/1")]
    V1,
}

/// One jog.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Jog {
    /// Displacement of the ball in nest axes, mm.
    pub ball_in_nest_mm: [f64; 3],
    /// What each probe changed by, mm.
    pub read_mm: [f64; 3],
    /// What the nest of the configuration expects, mm.
    pub expected_mm: [f64; 3],
}

/// What jogs say of the probes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SignFinding {
    /// The probes follow as the nest says, and nothing else would explain it.
    AsNest,
    /// They stand in another way, which is known.
    OtherWay,
    /// More jogs are needed.
    #[default]
    Open,
    /// No order and signs of the probes explain the jogs.
    None,
}

impl SignTest {
    /// From the jogs and their answer.
    pub fn new(jogs: &[NestStep], answer: &JogAnswer) -> Self {
        let jog = |(step, expected_mm): (&NestStep, &[f64; 3])| Jog {
            ball_in_nest_mm: step.ball_in_nest_mm.into(),
            read_mm: step.probes_mm,
            expected_mm: *expected_mm,
        };
        let (finding, say) = match answer.agreeing[..] {
            [] => (SignFinding::None, none(jogs)),
            [only] if only == Standing::AS_NEST => {
                (SignFinding::AsNest, "The probes follow as the nest says.".into())
            }
            [only] => (SignFinding::OtherWay, format!("{}.", other_way(only))),
            [first, ..] if first == Standing::AS_NEST => {
                (SignFinding::Open, format!("The probes follow as the nest says. {MORE_JOGS}"))
            }
            ref several => {
                let ways: Vec<String> = several.iter().take(2).map(|way| other_way(*way)).collect();
                (SignFinding::Open, format!("{}. {MORE_JOGS}", ways.join(", or ")))
            }
        };
        let jogs = jogs.iter().zip(&answer.expected_mm).map(jog).collect();
        Self { format: SignTestFormat::V1, jogs, finding, say }
    }
}

/// Some mistakes look alike in one jog.
const MORE_JOGS: &str = "Jog the other linear axes too: one axis alone does not show every exchange.";

fn other_way(standing: Standing) -> String {
    let probes = [1, 2, 3];
    let turned: Vec<String> =
        (0..3).filter(|&k| standing.turned[k]).map(|k| format!("probe-{} is turned", probes[k])).collect();
    let moved: Vec<usize> = (0..3).filter(|&k| standing.order[k] != k).collect();
    let exchanged = (!moved.is_empty()).then(|| {
        let names: Vec<String> = moved.iter().map(|&k| format!("probe-{}", probes[k])).collect();
        format!("{} are exchanged", names.join(" and "))
    });
    let every = standing.turned == [true; 3] && moved.is_empty();
    match every {
        true => {
            "All probes are turned, or the axis counts the other way: check `nest` of the setup and the signs"
                .into()
        }
        false => {
            let parts: Vec<String> = exchanged.into_iter().chain(turned).collect();
            format!("{}: exchange their roles or cables, or calibrate the nest again", parts.join("; "))
        }
    }
}

/// Of jogs that nothing explains: probes that do not move at all are named.
fn none(jogs: &[NestStep]) -> String {
    let ball_mm = jogs.iter().map(|jog| jog.ball_in_nest_mm.norm()).fold(0.0, f64::max);
    let most = |k: usize| jogs.iter().map(|jog| jog.probes_mm[k].abs()).fold(0.0, f64::max);
    // A probe may be across one axis; three that stand still are not touched by the ball.
    if (0..3).all(|k| most(k) < 0.05 * ball_mm) {
        return format!(
            "The probes do not follow: the ball moved by {} mm. Check that it is in the nest and that the readings are live.",
            plain(ball_mm)
        );
    }
    let sum = jogs.iter().map(|jog| Vector3::from(jog.probes_mm)).sum::<Vector3<f64>>();
    format!(
        "The probes follow in another way than the nest says, whatever their order and signs (changes {}, {}, {} mm): calibrate the \
         nest.",
        plain(sum.x),
        plain(sum.y),
        plain(sum.z)
    )
}
