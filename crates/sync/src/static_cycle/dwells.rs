//! What the probes read wherever the machine stands, whatever the cycle: for calibrating the nest, and for a jog.

use super::StaticRules;
use super::dwell::Dwell;
use crate::align::{AlignLimits, Aligned, Aligner};
use crate::nest::NestCalibration;
use trunnion_core::{AxisSample, AxisValues, Joint, ProbeSample};

/// One dwell that has settled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DwellReading {
    /// Middle of the window that was read, s.
    pub time_s: f64,
    /// Where the axes stand, mm and rad.
    pub position: AxisValues<f64>,
    /// Readings of the probes, mm.
    pub probes_mm: [f64; 3],
    /// Robust standard deviation of the samples of each, mm.
    pub spread_mm: [f64; 3],
}

/// Reads every dwell once, as soon as it has settled.
#[derive(Clone, Debug)]
pub struct DwellReader {
    aligner: Aligner,
    steps: Vec<Aligned>,
    axes: Vec<Joint>,
    dwell: Dwell,
    served: bool,
}

impl DwellReader {
    /// For the channels of the probes in their order, and the axes that the controller reports.
    pub fn new(channels: &[u16], axes: Vec<Joint>, rules: StaticRules) -> Self {
        Self {
            aligner: Aligner::new(channels, AlignLimits::default()),
            steps: Vec::new(),
            dwell: Dwell::new(&rules),
            axes,
            served: false,
        }
    }

    /// Takes a displacement; a dwell that it settles goes to the end of `out`.
    pub fn probe(&mut self, sample: &ProbeSample, out: &mut Vec<DwellReading>) {
        self.aligner.push_probe(sample, &mut self.steps);
        self.read(out);
    }

    /// Takes axis positions, as [`DwellReader::probe`] takes a displacement.
    pub fn axes(&mut self, sample: &AxisSample, out: &mut Vec<DwellReading>) {
        self.aligner.push_axes(sample, &mut self.steps);
        self.read(out);
    }

    fn read(&mut self, out: &mut Vec<DwellReading>) {
        for step in std::mem::take(&mut self.steps) {
            match step.channels_mm {
                Some(channels_mm) => self.dwell.push_sample(step.state.time_s, channels_mm),
                None => {
                    if self.dwell.is_left_by(&step.state, &self.axes) {
                        (self.dwell, self.served) = (self.dwell.next(), false);
                    }
                    self.dwell.push_axes(&step.state, &self.axes);
                    out.extend(self.settled());
                }
            }
        }
    }

    fn settled(&mut self) -> Option<DwellReading> {
        if self.served || !self.dwell.is_stationary() || !self.dwell.is_settled() {
            return None;
        }
        let position = self.dwell.latest()?.position;
        let read = self.dwell.summary(&NestCalibration::orthogonal())?;
        self.served = true;
        Some(DwellReading {
            time_s: read.time_s,
            position,
            probes_mm: read.reading_mm,
            spread_mm: read.spread_mm,
        })
    }
}
