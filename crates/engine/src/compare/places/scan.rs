//! Every box of the grid, by sums over rectangles of a table of partial sums.

use super::found::{Found, Way};
use super::readings::Readings;
use nalgebra::DMatrix;

/// Fewest readings of a place.
const FEWEST: usize = 6;
/// A place with fewer conditions is preferred while it is worth at least this share of the best.
const NEARLY: f64 = 0.93;

/// True when a point is in both boxes.
fn overlap(a: &Found, b: &Found, readings: &Readings) -> bool {
    let both = |point| readings.weight(a, point).is_some() && readings.weight(b, point).is_some();
    a.component == b.component && readings.points.iter().any(both)
}

/// The box worth most, that overlaps none of `chosen`; `None` when none pays its price.
pub fn best(readings: &Readings, chosen: &[Found]) -> Option<Found> {
    let mut ways = vec![Way::All];
    for &letter in &readings.both_ways {
        ways.extend([Way::Forward(letter), Way::Back(letter), Way::Turns(letter)]);
    }
    let setups = (0..readings.setups).map(Some).filter(|_| readings.setups > 1);
    let setups: Vec<Option<usize>> = std::iter::once(None).chain(setups).collect();
    let count = readings.dimensions.len();
    let pairs: Vec<(usize, usize)> = match count {
        0 => vec![],
        1 => vec![(0, 0)],
        _ => (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b))).collect(),
    };
    let mut best = Best { of_conditions: Default::default(), readings, chosen };
    for component in 0..readings.components.len() {
        let Some(spread) = Spread::of(readings, component) else { continue };
        let layers = (setups.len() * ways.len() * readings.components.len()) as f64;
        for &setup in &setups {
            for &way in &ways {
                for &pair in &pairs {
                    let layer = Layer { component, setup, way, pair };
                    layer.scan(&spread, layers, &mut best);
                }
            }
        }
    }
    let best = best.of_conditions;
    let most = best.iter().flatten().map(|found| found.worth).fold(0.0, f64::max);
    best.into_iter().flatten().find(|found| found.worth > 0.0 && found.worth >= NEARLY * most)
}

/// The best box of each number of conditions that overlaps none of `chosen`.
struct Best<'a> {
    of_conditions: [Option<Found>; 5],
    readings: &'a Readings,
    chosen: &'a [Found],
}

impl Best<'_> {
    /// A box of so many conditions; most boxes are worth less than one before them, and are never made.
    fn offer(&mut self, conditions: usize, worth: f64, found: impl FnOnce() -> Found) {
        let slot = &mut self.of_conditions[conditions];
        if slot.as_ref().is_some_and(|other| worth <= other.worth) {
            return;
        }
        let found = found();
        if !self.chosen.iter().any(|other| overlap(&found, other, self.readings)) {
            *slot = Some(found);
        }
    }
}

/// Variance of a component and how its readings cling together: mean size of a cluster, and the share of the mean square by which clusters
/// deviate. The share stands for the intraclass correlation ρ in the design effect 1 + (m − 1) ρ of m readings of a cluster.
struct Spread {
    variance_um2: f64,
    cluster: f64,
    cluster_share: f64,
}

impl Spread {
    fn of(readings: &Readings, component: usize) -> Option<Self> {
        let values: Vec<f64> = readings.points.iter().filter_map(|point| point.value(component)).collect();
        if values.len() < FEWEST {
            return None;
        }
        let variance_um2 = values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
        // Seen in table axes, an error that stays the same in machine axes turns with the table: the machine's view counts.
        let (cluster, cluster_share) = std::iter::once(component)
            .chain(if component < 6 { 0..3 } else { 0..0 })
            .map(|component| readings.clustering(component))
            .fold((0.0, 0.0), |most: (f64, f64), one| (most.0.max(one.0), most.1.max(one.1)));
        Some(Self { variance_um2, cluster, cluster_share })
    }

    /// What a box that takes `share` of each cluster explains by chance, times the ln of `choices`, twice.
    fn price(&self, share: f64, choices: f64) -> f64 {
        let design_effect = 1.0 + (self.cluster * share - 1.0).max(0.0) * self.cluster_share;
        2.0 * choices.ln() * self.variance_um2 * design_effect
    }
}

/// All boxes of one component, setup and way over two dimensions.
struct Layer {
    component: usize,
    setup: Option<usize>,
    way: Way,
    pair: (usize, usize),
}

impl Layer {
    fn scan(&self, spread: &Spread, layers: f64, best: &mut Best<'_>) {
        let readings = best.readings;
        let (a, b) = self.pair;
        let single = a == b;
        let (rows, columns) =
            (readings.dimensions[a].bins.len(), if single { 1 } else { readings.dimensions[b].bins.len() });
        // Doubled, so that a range may go on past the last bin.
        let mut sums = PartialSums::new(2 * rows, 2 * columns);
        let mut count = 0;
        for point in &readings.points {
            if self.setup.is_some_and(|setup| setup != point.setup) {
                continue;
            }
            let Some((value, weight)) = point.value(self.component).zip(readings.way_weight(self.way, point))
            else {
                continue;
            };
            let (i, j) = (point.bins[a], if single { 0 } else { point.bins[b] });
            count += 1;
            for (i, j) in [(i, j), (i + rows, j), (i, j + columns), (i + rows, j + columns)] {
                sums.add(i, j, value * weight);
            }
        }
        if count < FEWEST {
            return;
        }
        sums.accumulate();
        let over_a = ranges(rows, readings.dimensions[a].is_full_turn);
        let over_b = ranges(columns, !single && readings.dimensions[b].is_full_turn);
        let prices = self.prices(spread, layers, readings, [(rows, over_a.len()), (columns, over_b.len())]);
        let layer_conditions = usize::from(self.setup.is_some()) + usize::from(self.way != Way::All);
        for &(from_a, length_a) in &over_a {
            for &(from_b, length_b) in &over_b {
                let (n, sum) = sums.within((from_a, from_a + length_a), (from_b, from_b + length_b));
                let cells = length_a * length_b;
                if n < FEWEST as f64 || (cells < 2 && !single) {
                    continue;
                }
                let explains = sum * sum / n;
                let worth = explains - prices[(length_a, length_b)];
                if worth > 0.0 {
                    let sides = [(a, from_a, length_a, rows), (b, from_b, length_b, columns)];
                    let parts = sides.iter().filter(|(_, _, length, bins)| length < bins);
                    let last = |from: usize, length: usize, bins: usize| (from + length - 1) % bins;
                    best.offer(layer_conditions + parts.clone().count(), worth, || Found {
                        component: self.component,
                        setup: self.setup,
                        way: self.way,
                        ranges: parts
                            .map(|&(d, from, length, bins)| (d, from, last(from, length, bins)))
                            .collect(),
                        readings: n as usize,
                        mean_um: sum / n,
                        explains,
                        worth,
                    });
                }
            }
        }
    }

    /// The price of a box by its lengths in both dimensions, from bins and number of ranges of each: where the box begins plays no part.
    fn prices(
        &self,
        spread: &Spread,
        layers: f64,
        readings: &Readings,
        [(rows, over_a), (columns, over_b)]: [(usize, usize); 2],
    ) -> DMatrix<f64> {
        let (a, b) = self.pair;
        DMatrix::from_fn(rows + 1, columns + 1, |length_a, length_b| {
            let (mut choices, mut share) = (layers, 1.0);
            for (dimension, length, bins, ranges) in
                [(a, length_a, rows, over_a), (b, length_b, columns, over_b)]
            {
                if length < bins {
                    choices *= ranges as f64;
                    if readings.is_fast(dimension) {
                        share = length as f64 / bins as f64;
                    }
                }
            }
            spread.price(share, choices)
        })
    }
}

/// First bin and length of every range; the whole once.
fn ranges(count: usize, is_full_turn: bool) -> Vec<(usize, usize)> {
    let mut ranges = vec![(0, count)];
    for length in 1..count {
        let starts = if is_full_turn { count } else { count - length + 1 };
        ranges.extend((0..starts).map(|from| (from, length)));
    }
    ranges
}

/// Counts and sums of everything above and to the left.
struct PartialSums {
    columns: usize,
    sums: Vec<(f64, f64)>,
}

impl PartialSums {
    fn new(rows: usize, columns: usize) -> Self {
        Self { columns: columns + 1, sums: vec![(0.0, 0.0); (rows + 1) * (columns + 1)] }
    }

    fn add(&mut self, i: usize, j: usize, value: f64) {
        let cell = &mut self.sums[(i + 1) * self.columns + j + 1];
        *cell = (cell.0 + 1.0, cell.1 + value);
    }

    fn accumulate(&mut self) {
        for at in self.columns..self.sums.len() {
            if at.is_multiple_of(self.columns) {
                continue;
            }
            let (up, left, both) =
                (self.sums[at - self.columns], self.sums[at - 1], self.sums[at - self.columns - 1]);
            let cell = &mut self.sums[at];
            *cell = (cell.0 + up.0 + left.0 - both.0, cell.1 + up.1 + left.1 - both.1);
        }
    }

    fn within(&self, (top, bottom): (usize, usize), (left, right): (usize, usize)) -> (f64, f64) {
        let at = |i: usize, j: usize| self.sums[i * self.columns + j];
        let (a, b, c, d) = (at(bottom, right), at(top, right), at(bottom, left), at(top, left));
        (a.0 - b.0 - c.0 + d.0, a.1 - b.1 - c.1 + d.1)
    }
}
