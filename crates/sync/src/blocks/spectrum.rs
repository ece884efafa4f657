//! Noise of a pass, octave by octave, and what the mean of n of its samples is worth.
//!
//! Fourth differences: with ȳ the means of m = 2^j consecutive samples, H(m) = ⟨(ȳ₁ − 4ȳ₂ + 6ȳ₃ − 4ȳ₄ + ȳ₅)²⟩/70.
//! White noise: H(m) = σ²/m; what runs like a cubic over five blocks (kinematics, slow drift) gives nothing. So √H(n) is the
//! standard error of the mean of n samples against a smooth course, whatever the correlation within n; n_eff = scatter² / H(n).
//!
//! What averaging removes is split by octaves with the wavelet of Daubechies with four taps, which a straight line does not touch
//! either: at each level two new values give a = Σ h_k x_k, passed on, and d = Σ (−1)^k h_{3−k} x_k; the mean square of d over 2^{j+1} is the
//! share of octave j in the variance of a sample (orthogonal: the shares add up).
//! Limits: slower than the block (drift, pass offsets) is not noise here: a fit estimates that as its floor.

/// Octaves: the longest means are of 2^17 samples.
const OCTAVES: usize = 18;
/// Differences behind a figure that may be used.
const FEWEST: f64 = 12.0;

/// h_k of the wavelet.
const TAPS: [f64; 4] =
    [0.482_962_913_144_534_1, 0.836_516_303_737_807_9, 0.224_143_868_042_013_4, -0.129_409_522_551_260_4];

/// Sums of one pass.
#[derive(Clone, Debug, Default)]
pub struct Pyramid {
    means: Vec<Means>,
    waves: Vec<Waves>,
}

/// Fourth differences of the means of 2^j samples.
#[derive(Clone, Copy, Debug, Default)]
struct Means {
    /// First half of the next mean.
    half: Option<[f64; 3]>,
    before: [[f64; 3]; 4],
    held: u8,
    sum: Sum,
}

/// Octave j of the wavelet transform.
#[derive(Clone, Copy, Debug, Default)]
struct Waves {
    last: [[f64; 3]; 3],
    held: u8,
    sum: Sum,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    squares: [f64; 3],
    count: f64,
}

impl Pyramid {
    /// Adds a sample.
    pub fn add(&mut self, sample: [f64; 3]) {
        self.add_to_means(sample);
        self.add_to_waves(sample);
    }

    fn add_to_means(&mut self, sample: [f64; 3]) {
        let mut mean = sample;
        for level in 0..OCTAVES {
            if self.means.len() == level {
                self.means.push(Means::default());
            }
            let here = &mut self.means[level];
            let [y1, y2, y3, y4] = here.before;
            if here.held == 4 {
                here.sum
                    .add(std::array::from_fn(|k| y1[k] - 4.0 * y2[k] + 6.0 * y3[k] - 4.0 * y4[k] + mean[k]));
            }
            (here.before, here.held) = ([y2, y3, y4, mean], (here.held + 1).min(4));
            match here.half.take() {
                None => {
                    here.half = Some(mean);
                    return;
                }
                Some(half) => mean = std::array::from_fn(|k| 0.5 * (half[k] + mean[k])),
            }
        }
    }

    fn add_to_waves(&mut self, sample: [f64; 3]) {
        let mut value = sample;
        for level in 0..OCTAVES {
            if self.waves.len() == level {
                self.waves.push(Waves::default());
            }
            let Some((smooth, detail)) = self.waves[level].push(value) else { return };
            self.waves[level].sum.add(detail);
            value = smooth;
        }
    }

    /// The next sample does not follow the last one.
    pub fn interrupt(&mut self) {
        self.means.iter_mut().for_each(|level| (level.half, level.held) = (None, 0));
        self.waves.iter_mut().for_each(|level| level.held = 0);
    }

    /// Adds the sums of another.
    pub fn absorb(&mut self, other: &Self) {
        self.means.resize(self.means.len().max(other.means.len()), Means::default());
        self.waves.resize(self.waves.len().max(other.waves.len()), Waves::default());
        self.means.iter_mut().zip(&other.means).for_each(|(mine, theirs)| mine.sum.absorb(&theirs.sum));
        self.waves.iter_mut().zip(&other.waves).for_each(|(mine, theirs)| mine.sum.absorb(&theirs.sum));
    }

    /// H of means of 1, 2, 4 … samples as far as it is known, mm².
    pub fn variances(&self) -> Vec<[f64; 3]> {
        let known = self.means.iter().take_while(|level| level.sum.count >= FEWEST);
        known.map(|level| level.sum.mean().map(|square| square / 70.0)).collect()
    }

    /// Variance of a sample in the octaves of periods of 2–4, 4–8 … samples as far as it is known, mm².
    pub fn octaves(&self) -> Vec<[f64; 3]> {
        let known = self.waves.iter().take_while(|level| level.sum.count >= FEWEST);
        let share = |(octave, level): (usize, &Waves)| {
            level.sum.mean().map(|square| square / (2u64 << octave) as f64)
        };
        known.enumerate().map(share).collect()
    }
}

impl Waves {
    /// Takes a value; every second one gives a smooth value and a detail.
    fn push(&mut self, value: [f64; 3]) -> Option<([f64; 3], [f64; 3])> {
        let [x0, x1, x2] = self.last;
        self.last = [x1, x2, value];
        if self.held < 3 {
            self.held += 1;
            return None;
        }
        self.held = 2;
        let x = [x0, x1, x2, value];
        let sum = |k: usize, taps: [f64; 4]| (0..4).map(|i| taps[i] * x[i][k]).sum::<f64>();
        let wave = [TAPS[3], -TAPS[2], TAPS[1], -TAPS[0]];
        Some((std::array::from_fn(|k| sum(k, TAPS)), std::array::from_fn(|k| sum(k, wave))))
    }
}

impl Sum {
    fn add(&mut self, value: [f64; 3]) {
        self.count += 1.0;
        self.squares.iter_mut().zip(value).for_each(|(sum, x)| *sum += x * x);
    }

    fn absorb(&mut self, other: &Self) {
        self.count += other.count;
        self.squares.iter_mut().zip(other.squares).for_each(|(sum, x)| *sum += x);
    }

    fn mean(&self) -> [f64; 3] {
        self.squares.map(|sum| sum / self.count)
    }
}

/// Noise of a pass as its blocks need it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Noise {
    /// H of means of 1, 2, 4 … samples, mm².
    pub variances: Vec<[f64; 3]>,
    /// Usual scatter of samples within one block, mm.
    pub scatter_mm: [f64; 3],
}

impl Noise {
    /// Standard error of the mean of `count` consecutive samples, mm; zero when nothing is known.
    pub fn standard_error_mm(&self, k: usize, count: f64) -> f64 {
        let Some(last) = self.variances.len().checked_sub(1) else { return 0.0 };
        let octave = count.max(1.0).log2();
        let at = (octave.floor() as usize).min(last);
        let low = self.variances[at][k].max(f64::MIN_POSITIVE);
        let variance = match self.variances.get(at + 1) {
            Some(next) => low * (next[k].max(f64::MIN_POSITIVE) / low).powf(octave - at as f64),
            // Longer than anything measured: as if white from there on.
            None => low * (at as f64 - octave).exp2(),
        };
        variance.sqrt()
    }
}
