//! The residual of every point in the frames and bins that the scan needs.

use super::found::{Found, Way};
use crate::Experiment;
use crate::compare::frames::in_frames;
use nalgebra::{DVector, Matrix3, Vector3};
use std::collections::HashMap;
use trunnion_core::{InstrumentKind, Joint, State, convert};

/// Most bins of one axis.
const MOST_BINS: usize = 13;
/// Bins of time.
const TIME_BINS: usize = 8;
/// A direction counts as measured when at least this share of the points has it.
const LEAST_OF_A_DIRECTION: f64 = 0.1;
/// Two axes that went the same way in this share of the points cannot be separated by their directions.
const SAME_WAY: f64 = 0.97;
/// Longer runs are looked at in every n-th point.
const MOST_POINTS: usize = 20_000;

/// Points with their residual, bins and clusters.
pub struct Readings {
    pub points: Vec<Reading>,
    pub components: Vec<&'static str>,
    /// Axes that move, and time.
    pub dimensions: Vec<Dimension>,
    pub setups: usize,
    /// Axes measured in both directions; of those that always went the same way only the one that moves most often.
    pub both_ways: Vec<Joint>,
    /// Axes that always went the way of another one: (that other one, the axis).
    confounded: Vec<(Joint, Joint)>,
    pub any_direction: bool,
    /// Every n-th point was taken.
    pub every: usize,
    /// Which dimension moves most often.
    fast: Option<usize>,
}

/// One point.
pub struct Reading {
    pub setup: usize,
    /// Signs of travel by the order of [`Readings::both_ways`].
    pub signs: Vec<i8>,
    /// Bin in each dimension.
    pub bins: Vec<usize>,
    /// Points that share a cluster share the slow errors.
    cluster: usize,
    residual: Residual,
}

/// Readings taken one after the other while only the fast axis moved.
#[derive(Default)]
struct Cluster {
    station: Vec<usize>,
    count: f64,
    sum: f64,
    squares: f64,
}

enum Residual {
    /// Machine axes, µm, and the rotation that turns them into table axes.
    Vector { in_machine_um: Vector3<f64>, table_from_machine: Matrix3<f64> },
    /// One component, µm.
    Single(f64),
}

/// An axis or time, cut into bins.
pub struct Dimension {
    /// `None`: time.
    pub letter: Option<Joint>,
    /// First and last value in each bin; degrees, mm or s.
    pub bins: Vec<(f64, f64)>,
    /// The last bin is the neighbour of the first.
    pub is_full_turn: bool,
}

/// Components of readings in three directions.
const COMPONENTS: [&str; 6] = ["X", "Y", "Z", "table X", "table Y", "table Z"];

/// The component of all readings that are not in three directions: of instruments that read different things it is only a reading.
fn single_of(experiment: &Experiment) -> &'static str {
    let kinds = experiment.setups.iter().map(|setup| setup.instrument);
    let mut names = kinds.filter(|kind| kind.components().len() != 3).map(InstrumentKind::reads);
    let first = names.next().unwrap_or("reading");
    if names.all(|name| name == first) { first } else { "reading" }
}

impl Readings {
    pub fn new(experiment: &Experiment, residual_mm: &DVector<f64>, used: &[bool]) -> Self {
        let every = experiment.points.len().div_ceil(MOST_POINTS).max(1);
        let taken: Vec<usize> = (0..experiment.points.len()).filter(|&i| used[i]).step_by(every).collect();
        let state = |i: usize| -> &State { &experiment.points[i].state };
        let mut dimensions = Vec::new();
        let mut bins_of: Vec<Vec<usize>> = Vec::new();
        let mut put = |letter: Option<Joint>, values: Vec<f64>| {
            if let Some((dimension, bins)) = Dimension::new(letter, &values) {
                dimensions.push(dimension);
                bins_of.push(bins);
            }
        };
        let axes: Vec<_> = experiment.machine().axes().map(|axis| axis.letter).collect();
        let moves = |letter: Joint| {
            taken.iter().any(|&i| (state(i).position[letter] - state(taken[0]).position[letter]).abs() > 1e-6)
        };
        // Where rotary axes move, the linear ones only follow them.
        let turning = axes.iter().any(|&letter| letter.is_rotary() && moves(letter));
        for &letter in axes.iter().filter(|letter| letter.is_rotary() == turning) {
            let screen = |x: f64| if letter.is_rotary() { convert::deg_from_rad(x) } else { x };
            put(Some(letter), taken.iter().map(|&i| screen(state(i).position[letter])).collect());
        }
        if experiment.runs.len() == 1 && experiment.scene.time_range_s.is_some() {
            put(None, taken.iter().map(|&i| state(i).time_s.unwrap_or_default()).collect());
        }
        let sign = |i: usize, letter: Joint| -> i8 {
            let direction = state(i).direction[letter];
            if direction > 0.0 { 1 } else { -i8::from(direction < 0.0) }
        };
        let share = |letter: Joint, of: i8| {
            taken.iter().filter(|&&i| sign(i, letter) == of).count() as f64 / taken.len().max(1) as f64
        };
        let mut candidates: Vec<Joint> =
            axes.iter().copied().filter(|&l| share(l, 1).min(share(l, -1)) >= LEAST_OF_A_DIRECTION).collect();
        let steps = |letter: Joint| {
            let position = |i: usize| state(i).position[letter];
            taken.windows(2).filter(|w| (position(w[0]) - position(w[1])).abs() > 1e-6).count()
        };
        candidates.sort_by_key(|&letter| std::cmp::Reverse(steps(letter)));
        let (mut both_ways, mut confounded): (Vec<Joint>, Vec<_>) = Default::default();
        for letter in candidates {
            let follows = |&leader: &Joint| {
                let same = taken.iter().filter(|&&i| sign(i, letter) == sign(i, leader)).count();
                same as f64 >= SAME_WAY * taken.len() as f64
            };
            match both_ways.iter().copied().find(follows) {
                Some(leader) => confounded.push((leader, letter)),
                None => both_ways.push(letter),
            }
        }
        let any_direction = axes.iter().any(|&l| l.is_rotary() == turning && share(l, 0) < 0.5);
        let axis_dimensions = dimensions.iter().take_while(|d| d.letter.is_some()).count();
        let changes = |d: usize| bins_of[d].windows(2).filter(|w| w[0] != w[1]).count();
        let fast = (0..axis_dimensions).max_by_key(|&d| changes(d));
        let mut points: Vec<Reading> = Vec::with_capacity(taken.len());
        for (k, &i) in taken.iter().enumerate() {
            let bins: Vec<usize> = bins_of.iter().map(|of| of[k]).collect();
            let signs: Vec<i8> = both_ways.iter().map(|&l| sign(i, l)).collect();
            let same_cluster = points.last().is_some_and(|last| {
                last.setup == state(i).setup
                    && last.signs == signs
                    && (0..axis_dimensions).all(|d| Some(d) == fast || last.bins[d] == bins[d])
            });
            let cluster = points.last().map_or(0, |last| last.cluster + usize::from(!same_cluster));
            let residual = match in_frames(experiment, residual_mm, i) {
                Some((in_machine, table_from_machine)) => {
                    Residual::Vector { in_machine_um: in_machine * 1e3, table_from_machine }
                }
                None => Residual::Single(residual_mm[experiment.rows_of(i).start] * 1e3),
            };
            points.push(Reading { setup: state(i).setup, signs, bins, cluster, residual });
        }
        Self {
            points,
            components: COMPONENTS.into_iter().chain([single_of(experiment)]).collect(),
            dimensions,
            setups: experiment.setups.len(),
            both_ways,
            confounded,
            any_direction,
            every,
            fast,
        }
    }

    /// µm², machine axes and single readings once each.
    pub fn sum_of_squares(&self) -> f64 {
        self.points
            .iter()
            .map(|point| match &point.residual {
                Residual::Vector { in_machine_um, .. } => in_machine_um.norm_squared(),
                Residual::Single(value) => value * value,
            })
            .sum()
    }

    /// Takes the mean of a place out of the points in it.
    pub fn subtract(&mut self, found: &Found) {
        let inside: Vec<Option<f64>> = self.points.iter().map(|point| self.weight(found, point)).collect();
        for (point, weight) in self.points.iter_mut().zip(inside) {
            let Some(weight) = weight else { continue };
            let shift = found.mean_um * weight;
            match &mut point.residual {
                Residual::Single(value) if found.component == 6 => *value -= shift,
                Residual::Vector { in_machine_um, .. } if found.component < 3 => {
                    in_machine_um[found.component] -= shift;
                }
                Residual::Vector { in_machine_um, table_from_machine } if found.component < 6 => {
                    *in_machine_um -=
                        table_from_machine.transpose() * Vector3::ith(found.component - 3, shift);
                }
                Residual::Single(_) | Residual::Vector { .. } => {}
            }
        }
    }

    /// +1, −1 for a point in the box, `None` outside.
    pub fn weight(&self, found: &Found, point: &Reading) -> Option<f64> {
        if found.holds(&point.bins, point.setup) { self.way_weight(found.way, point) } else { None }
    }

    /// Mean size of the clusters that `component` comes in, and the share of its mean square by which a cluster deviates from
    /// the other clusters at the same stations: what all passes show there is no accident of one of them. Where no
    /// station was visited twice, the share by which clusters deviate from zero.
    pub fn clustering(&self, component: usize) -> (f64, f64) {
        let mut clusters: Vec<Cluster> = Vec::new();
        let slow = |point: &Reading| -> Vec<usize> {
            let axes = self.dimensions.iter().take_while(|d| d.letter.is_some()).count();
            (0..axes).filter(|d| !self.is_fast(*d)).map(|d| point.bins[d]).collect()
        };
        let mut last = None;
        for point in &self.points {
            let Some(value) = point.value(component) else { continue };
            if last != Some(point.cluster) {
                clusters.push(Cluster { station: slow(point), ..Cluster::default() });
                last = Some(point.cluster);
            }
            if let Some(cluster) = clusters.last_mut() {
                cluster.count += 1.0;
                cluster.sum += value;
                cluster.squares += value * value;
            }
        }
        let mut stations: HashMap<&[usize], (f64, f64)> = HashMap::new();
        for cluster in &clusters {
            let station = stations.entry(&cluster.station).or_default();
            *station = (station.0 + cluster.count, station.1 + cluster.sum);
        }
        let (n, k) = (clusters.iter().map(|c| c.count).sum::<f64>(), clusters.len() as f64);
        let squares: f64 = clusters.iter().map(|c| c.squares).sum();
        let of_means: f64 = clusters.iter().map(|c| c.sum * c.sum / c.count).sum();
        let of_stations: f64 = stations.values().map(|(count, sum)| sum * sum / count).sum();
        let size = clusters.iter().map(|c| c.count * c.count).sum::<f64>() / n.max(1.0);
        if n <= k || squares <= 0.0 {
            return (size, 0.0);
        }
        let repeats = k - stations.len() as f64;
        let between = if repeats >= 1.0 { (of_means - of_stations) / repeats } else { of_means / k };
        let within = (squares - of_means) / (n - k);
        let clinging = (between - within) / (n / k);
        (size, (clinging / (squares / n)).clamp(0.0, 1.0))
    }

    /// Whether a dimension varies within a cluster.
    pub fn is_fast(&self, dimension: usize) -> bool {
        self.fast == Some(dimension)
    }

    /// `C`, or `B and C` where both always went the same way.
    pub fn name_of_way(&self, letter: Joint) -> String {
        let followers = self.confounded.iter().filter(|(leader, _)| *leader == letter).map(|(_, axis)| *axis);
        let mut names: Vec<String> = followers.chain([letter]).map(|axis| axis.to_string()).collect();
        names.sort();
        names.join(" and ")
    }

    /// Sign of a way of travel for a point; `None` when the point does not belong to it.
    pub fn way_weight(&self, way: Way, point: &Reading) -> Option<f64> {
        let sign =
            |letter: Joint| self.both_ways.iter().position(|l| *l == letter).map_or(0, |at| point.signs[at]);
        match way {
            Way::All => Some(1.0),
            Way::Forward(letter) => (sign(letter) > 0).then_some(1.0),
            Way::Back(letter) => (sign(letter) < 0).then_some(1.0),
            Way::Turns(letter) => Some(f64::from(sign(letter))).filter(|sign| *sign != 0.0),
        }
    }
}

impl Reading {
    /// Residual of a component, µm.
    pub fn value(&self, component: usize) -> Option<f64> {
        match &self.residual {
            Residual::Single(value) => (component == 6).then_some(*value),
            Residual::Vector { in_machine_um, table_from_machine } => match component {
                0..3 => Some(in_machine_um[component]),
                3..6 => Some((table_from_machine * in_machine_um)[component - 3]),
                _ => None,
            },
        }
    }
}

impl Dimension {
    /// Cuts values into bins: their stations when few, else equal parts. `None` when nothing varies.
    fn new(letter: Option<Joint>, values: &[f64]) -> Option<(Self, Vec<usize>)> {
        let mut stations: Vec<i64> = values.iter().map(|v| (v * 10.0).round() as i64).collect();
        stations.sort_unstable();
        stations.dedup();
        let (low, high) = (*stations.first()? as f64 / 10.0, *stations.last()? as f64 / 10.0);
        if stations.len() < 2 {
            return None;
        }
        let is_axis = letter.is_some();
        let few = is_axis && stations.len() <= MOST_BINS;
        let count = match (few, is_axis) {
            (true, _) => stations.len(),
            (false, true) => MOST_BINS - 1,
            (false, false) => TIME_BINS,
        };
        let width = (high - low) / count as f64;
        let bin = |value: f64| match few {
            true => stations.binary_search(&((value * 10.0).round() as i64)).unwrap_or(0),
            false => (((value - low) / width).max(0.0) as usize).min(count - 1),
        };
        let edges = |k: usize| match few {
            true => (stations[k] as f64 / 10.0, stations[k] as f64 / 10.0),
            false => (low + k as f64 * width, low + (k + 1) as f64 * width),
        };
        let gap = if few { (high - low) / (count - 1) as f64 } else { width };
        let span = if few { high - low + gap } else { high - low };
        let is_full_turn = letter.is_some_and(Joint::is_rotary) && span > 360.0 - 0.6 * gap;
        let dimension = Self { letter, bins: (0..count).map(edges).collect(), is_full_turn };
        Some((dimension, values.iter().map(|&v| bin(v)).collect()))
    }
}
