//! What is hidden: the list of all trials.

use crate::noise::Kind as NoiseKind;
use crate::stage::{RUN_S, Stage, rms};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trunnion_hil_sim::physics::hidden;
use trunnion_hil_sim::physics::hidden::{Hidden, KINDS, SeenIn};
use trunnion_hil_sim::{HiddenChoice, Truth};

/// Surviving sizes in units of the white noise.
pub const SIZES: [f64; 3] = [0.5, 1.0, 2.0];
/// Runs with nothing hidden for each seed and noise: a rate of one in a hundred wants many.
const NULL_RUNS_A_SEED: u64 = 20;
/// A draw of which the base model swallows more than all but this share (of the rms) is drawn again.
const LEAST_SURVIVING: f64 = 0.07;
/// Draws before an effect counts as not visible on this grid.
const MOST_DRAWS: u64 = 40;

/// What kind of question a trial asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Nothing is hidden.
    Null,
    /// One effect of the catalogue.
    Single,
    /// Two effects of the catalogue.
    Pair,
    /// One effect of the catalogue, which the catalogue under test lacks.
    TakenOut,
    /// A shape that is in no catalogue.
    Unnamed,
}

impl Group {
    pub const ALL: [Self; 5] = [Self::Null, Self::Single, Self::Pair, Self::TakenOut, Self::Unnamed];

    pub fn name(self) -> &'static str {
        match self {
            Self::Null => "null",
            Self::Single => "single",
            Self::Pair => "pair",
            Self::TakenOut => "taken-out",
            Self::Unnamed => "unnamed",
        }
    }
}

/// One trial.
#[derive(Clone, Debug)]
pub struct Case {
    pub group: Group,
    /// Ids of the hidden physics, as the simulator calls them.
    pub hidden: Vec<String>,
    pub noise: NoiseKind,
    /// Surviving rms of each hidden effect in units of the white noise.
    pub size: f64,
    pub seed: u64,
}

impl Case {
    /// Everything but the seed, e.g. `pair gravity-sag:B+backlash:C real 1`.
    pub fn label(&self) -> String {
        let (group, noise) = (self.group.name(), self.noise.name());
        match self.group {
            Group::Null => format!("{group} {noise}"),
            _ => format!("{group} {} {noise} {}", self.hidden.join("+"), self.size),
        }
    }

    /// Seed of this trial alone: FNV-1a of the label, then the number.
    pub fn own_seed(&self) -> u64 {
        let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        let hash = self.label().bytes().fold(0xcbf2_9ce4_8422_2325, step);
        self.seed.to_le_bytes().into_iter().fold(hash, step)
    }
}

/// Two at once, of different phenomena.
const PAIRS: [[&str; 2]; 14] = [
    ["gravity-sag:B", "backlash:C"],
    ["gravity-sag:B", "thermal-drift"],
    ["gravity-sag:B", "encoder-eccentricity:C"],
    ["backlash:C", "thermal-drift"],
    ["backlash:B", "encoder-eccentricity:C"],
    ["encoder-eccentricity:C", "thermal-drift"],
    ["tilt-error-motion:C", "backlash:B"],
    ["radial-error-motion:C", "thermal-drift"],
    ["axial-error-motion:C", "backlash:C"],
    ["unbalance:C", "backlash:B"],
    ["unbalance:C", "setup-slip"],
    ["straightness:Z", "backlash:C"],
    ["squareness:ZX", "thermal-drift"],
    ["drive-pitch:C", "gravity-sag:B"],
];

/// What the grid can see of the simulator's physics, and what it cannot.
pub struct Visible {
    pub catalogued: Vec<String>,
    pub uncatalogued: Vec<String>,
    pub invisible: Vec<String>,
}

/// Sorts everything that shows at rest on this machine.
pub fn visible(stage: &Stage) -> Visible {
    let mut visible = Visible { catalogued: vec![], uncatalogued: vec![], invisible: vec![] };
    for kind in KINDS.into_iter().filter(|kind| kind.seen_in == SeenIn::StaticGrid) {
        for id in hidden::ids() {
            let Ok((of, place)) = hidden::find(&id) else { continue };
            if of.name != kind.name || !hidden::fits(&stage.machine, place) {
                continue;
            }
            let list = match draw(stage, &id, 1.0, 0) {
                None => &mut visible.invisible,
                Some(_) if kind.catalogued => &mut visible.catalogued,
                Some(_) => &mut visible.uncatalogued,
            };
            list.push(id);
        }
    }
    visible
}

/// Hidden physics of which `size` σ survive the base model; `None` when the base model swallows every draw.
pub fn draw(stage: &Stage, id: &str, size: f64, seed: u64) -> Option<Hidden> {
    let choice = HiddenChoice { id: id.into(), sigma: 1.0 };
    for stream in 0..MOST_DRAWS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(2000 + stream);
        let setups = &stage.trial.setups;
        let mut hidden = Hidden::draw(&choice, &stage.machine, setups, RUN_S, &mut rng)
            .expect("ids are of the registry and fit the machine");
        let mut truth = Truth::perfect(&stage.machine.name, setups, RUN_S);
        truth.hidden = vec![hidden.clone()];
        let signal = stage.trial.hidden_mm(&truth);
        let surviving_mm = rms(&stage.trial.surviving(&signal));
        if surviving_mm > LEAST_SURVIVING * rms(&signal) {
            hidden.amplitude *= size * crate::stage::SIGMA_MM / surviving_mm;
            return Some(hidden);
        }
    }
    None
}

/// All trials of which the label contains every word of `only`.
pub fn cases(visible: &Visible, seeds: std::ops::Range<u64>, only: &str) -> Vec<Case> {
    let mut cases = Vec::new();
    for group in Group::ALL {
        let hidden: Vec<Vec<String>> = match group {
            Group::Null => vec![Vec::new()],
            Group::Single | Group::TakenOut => visible.catalogued.iter().map(|id| vec![id.clone()]).collect(),
            Group::Pair => PAIRS.iter().map(|pair| pair.map(String::from).into()).collect(),
            Group::Unnamed => visible.uncatalogued.iter().map(|id| vec![id.clone()]).collect(),
        };
        let is_null = group == Group::Null;
        let sizes: &[f64] = if is_null { &[0.0] } else { &SIZES };
        let runs_a_seed = if is_null { NULL_RUNS_A_SEED } else { 1 };
        let numbers = seeds.start * runs_a_seed..seeds.end * runs_a_seed;
        for hidden in hidden {
            for noise in NoiseKind::ALL {
                for &size in sizes {
                    let case = |seed| Case { group, hidden: hidden.clone(), noise, size, seed };
                    cases.extend(numbers.clone().map(case));
                }
            }
        }
    }
    cases.retain(|case| only.split_whitespace().all(|word| case.label().contains(word)));
    cases
}
