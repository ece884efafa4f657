//! What the readings of each height, and all heights together, say of the axis.

use super::circle::{Circle, Through};
use crate::common::over_height::{Line, Weights};
use crate::common::shares::Shares;
use crate::common::stations::Stations;
use crate::common::turning::{Turned, Turning, TurningSet};
use crate::recipes::{Method, MethodError};
use nalgebra::{Vector2, Vector3};
use trunnion_core::number::fixed;
use trunnion_core::statistics;

/// Heights nearer than this count as one, mm.
const APART_MM: f64 = 5.0;
/// Passes with fewer readings are not judged alone.
const LEAST_READINGS: usize = 6;

/// What all heights gave.
pub(super) struct Heights {
    /// One for each setup, the lowest first.
    pub sets: Vec<HeightFit>,
    /// Place of the axis line over the height.
    pub centre: [Line; 2],
    /// What each reading counts in it: at zero, and in its slope.
    pub shares_of_centre: [[Shares; 2]; 2],
    /// Degrees of freedom of the u of these lines, at zero and of the slope; `None` where a height has a single pass.
    pub freedom: Option<[[usize; 2]; 2]>,
    /// Angles of the error motions.
    pub angles_rad: Vec<f64>,
    /// Radial u, radial v, axial w, mm, at each angle.
    pub translation_mm: Vec<Vector3<f64>>,
    /// Tilts about u and v, rad, at each angle.
    pub tilt_rad: Vec<Vector2<f64>>,
    /// Standard uncertainty of one value of `translation_mm` and `tilt_rad`; `None` with a single pass.
    pub u_translation_mm: Option<Vector3<f64>>,
    /// The same of the tilts.
    pub u_tilt_rad: Option<Vector2<f64>>,
}

/// One setup.
pub(super) struct HeightFit {
    /// Name of the setup.
    pub name: String,
    /// Height, mm.
    pub height_mm: f64,
    /// Setting s and centre c from all passes.
    pub all: Circle,
    /// The same from each pass alone, with its direction.
    pub passes: Vec<(f64, Circle)>,
    /// Standard uncertainty of setting and centre; by the scatter of the passes, else by the residual.
    pub u: Circle,
    /// What each reading counts in the centre.
    pub shares_of_centre: [Shares; 2],
    /// The error motion at each reading: its number, and what it makes of its components, mm.
    pub motion_of_readings_mm: Vec<(usize, Vector3<f64>)>,
    /// True when `u` comes from the scatter of passes.
    pub repeated: bool,
    /// Mean place over angle as measured, u v w, mm; `None` at angles without readings.
    pub measured_mm: Vec<Option<Vector3<f64>>>,
    /// Error motion components: what setting and centre leave, mean over the passes.
    pub motion_mm: Vec<Option<Vector3<f64>>>,
    /// Standard uncertainty of one of them; `None` with a single pass.
    pub u_motion_mm: Option<Vector3<f64>>,
    /// Angles of these.
    pub angles_rad: Vec<f64>,
}

impl Heights {
    /// Fits every setup, then the line over the heights.
    pub fn of(method: &Method, turning: &Turning) -> Result<Self, MethodError> {
        let turn = turning.whole_turn();
        let of_set = |set: &TurningSet| -> Vec<f64> { set.readings.iter().map(|r| r.angle_rad).collect() };
        let stations = if turning.on_the_fly {
            Stations::of_sweeps(&of_set(&turning.sets[0]), turn)
        } else {
            Stations::of_grid(turning.sets.iter().flat_map(of_set), turn)
        };
        let mut sets: Vec<HeightFit> =
            turning.sets.iter().map(|set| HeightFit::of(method, set, &stations)).collect::<Result<_, _>>()?;
        sets.sort_by(|a, b| a.height_mm.total_cmp(&b.height_mm));
        let (low, high) = (sets[0].height_mm, sets[sets.len() - 1].height_mm);
        if high - low < APART_MM {
            let heights: Vec<_> =
                sets.iter().map(|s| format!("{} at {} mm", s.name, fixed(s.height_mm, 1))).collect();
            return Err(method.lacks(
                format!("every ball sits at the same height along {} ({})", turning.axis, heights.join(", ")),
                format!("Measure a second height {APART_MM} mm or more away (100 mm is good); several recordings may be given together."),
            ));
        }
        let over_height = Weights::of(&sets.iter().map(|s| s.height_mm).collect::<Vec<_>>());
        let centre = [0, 1].map(|k| {
            over_height.line(
                &sets.iter().map(|s| s.all.centre_mm[k]).collect::<Vec<_>>(),
                &sets.iter().map(|s| s.u.centre_mm[k]).collect::<Vec<_>>(),
            )
        });
        let shares_of_centre = [0, 1]
            .map(|k| over_height.shares(&sets.iter().map(|s| &s.shares_of_centre[k]).collect::<Vec<_>>()));
        let of_set: Vec<usize> = sets.iter().map(|set| set.passes.len().saturating_sub(1)).collect();
        let freedom = sets.iter().all(|set| set.repeated).then(|| {
            let u = |k: usize| sets.iter().map(|set| set.u.centre_mm[k]).collect::<Vec<_>>();
            [0, 1].map(|k| over_height.freedom(&u(k), &of_set))
        });
        Ok(Self { freedom, shares_of_centre, ..Self::of_motions(sets, centre, &over_height, stations) })
    }

    /// Error motions at the angles that every height has.
    fn of_motions(sets: Vec<HeightFit>, centre: [Line; 2], over: &Weights, stations: Stations) -> Self {
        let mut heights = Self {
            centre,
            shares_of_centre: Default::default(),
            freedom: None,
            angles_rad: Vec::new(),
            translation_mm: Vec::new(),
            tilt_rad: Vec::new(),
            u_translation_mm: None,
            u_tilt_rad: None,
            sets,
        };
        let lines = |of: &dyn Fn(&HeightFit) -> Option<Vector3<f64>>| -> Option<[Line; 3]> {
            let values: Vec<Vector3<f64>> = heights.sets.iter().map(of).collect::<Option<_>>()?;
            let scatter: Vec<Vector3<f64>> =
                heights.sets.iter().map(|s| s.u_motion_mm.unwrap_or_else(Vector3::zeros)).collect();
            Some([0, 1, 2].map(|k| {
                let column = |of: &[Vector3<f64>]| of.iter().map(|v| v[k]).collect::<Vec<_>>();
                over.line(&column(&values), &column(&scatter))
            }))
        };
        let mut found = Vec::new();
        for (i, &angle) in stations.angles_rad.iter().enumerate() {
            let Some([u, v, _]) = lines(&|set| set.motion_mm[i]) else { continue };
            let axial = heights.sets.iter().filter_map(|s| s.motion_mm[i]).map(|m| m.z).sum::<f64>();
            let axial = axial / heights.sets.len() as f64;
            found.push((angle, Vector3::new(u.at_zero, v.at_zero, axial), Vector2::new(-v.slope, u.slope)));
        }
        if heights.sets.iter().all(|set| set.u_motion_mm.is_some())
            && let Some([u, v, _]) = lines(&|set| set.u_motion_mm)
        {
            let count = heights.sets.len() as f64;
            let axial = heights.sets.iter().filter_map(|s| s.u_motion_mm).map(|m| m.z.powi(2)).sum::<f64>();
            heights.u_translation_mm = Some(Vector3::new(u.u_at_zero, v.u_at_zero, axial.sqrt() / count));
            heights.u_tilt_rad = Some(Vector2::new(v.u_slope, u.u_slope));
        }
        heights.angles_rad = found.iter().map(|(angle, ..)| *angle).collect();
        heights.translation_mm = found.iter().map(|(_, translation, _)| *translation).collect();
        heights.tilt_rad = found.iter().map(|(.., tilt)| *tilt).collect();
        heights
    }
}

impl HeightFit {
    fn of(method: &Method, set: &TurningSet, stations: &Stations) -> Result<Self, MethodError> {
        let of_pass = |pass: usize| -> Vec<Turned> {
            set.readings.iter().filter(|r| r.pass == pass).copied().collect()
        };
        let Some(Through { circle: all, u: u_residual, shares_of_centre }) = Circle::through(&set.readings)
        else {
            return Err(method.lacks(
                format!("setup {} has {} readings", set.name, set.readings.len()),
                "Read more angles; a pose every 30° is the least that shows an error motion.",
            ));
        };
        let alone: Vec<Option<Circle>> = (0..set.passes)
            .map(of_pass)
            .map(|readings| (readings.len() >= LEAST_READINGS).then(|| Circle::through(&readings))?)
            .map(|fit| fit.map(|through| through.circle))
            .collect();
        let direction =
            |pass: usize| set.readings.iter().find(|r| r.pass == pass).map_or(0.0, |r| r.direction);
        let passes: Vec<(f64, Circle)> =
            alone.iter().enumerate().filter_map(|(i, c)| Some((direction(i), (*c)?))).collect();
        let repeated = passes.len() > 1;
        let u = if repeated { Circle::scatter_of_mean(&passes) } else { u_residual };
        let mut sums = vec![PerPass::default(); stations.angles_rad.len()];
        for pass in 0..set.passes {
            // Each pass is judged about its own circle, so that what shifts a pass as a whole is no error motion.
            let readings = of_pass(pass);
            let circle = alone[pass].unwrap_or(all);
            let axial = mean(readings.iter().map(|r| r.moved_mm.z));
            for reading in &readings {
                let Some(i) = stations.at(reading.angle_rad) else { continue };
                sums[i].add(
                    pass,
                    reading.moved_mm - circle.at(reading.turned_rad).push(axial),
                    reading.turned_rad,
                );
            }
        }
        let axial_mm = mean(set.readings.iter().map(|r| r.moved_mm.z));
        let axial = mean(sums.iter().filter_map(PerPass::mean).map(|m| m.z));
        let motion_mm: Vec<_> =
            sums.iter().map(|s| s.mean().map(|m| m - Vector3::new(0.0, 0.0, axial))).collect();
        let at = |reading: &Turned| motion_mm[stations.at(reading.angle_rad)?];
        let of_reading =
            |reading: &Turned| Some((reading.number, reading.moved_per_reading.transpose() * at(reading)?));
        let motion_of_readings_mm = set.readings.iter().filter_map(of_reading).collect();
        let measured_mm = motion_mm
            .iter()
            .zip(&sums)
            .map(|(m, s)| m.map(|m| m + all.at(s.turned_rad).push(axial + axial_mm)))
            .collect();
        Ok(Self {
            name: set.name.clone(),
            height_mm: set.height_mm,
            all,
            passes,
            u,
            shares_of_centre,
            motion_of_readings_mm,
            repeated,
            measured_mm,
            u_motion_mm: PerPass::u_of_mean(&sums),
            motion_mm,
            angles_rad: stations.angles_rad.clone(),
        })
    }
}

/// Readings of one station, pass by pass.
#[derive(Clone, Debug, Default)]
struct PerPass {
    passes: Vec<(usize, Vector3<f64>, f64)>,
    turned_rad: f64,
}

impl PerPass {
    fn add(&mut self, pass: usize, value: Vector3<f64>, turned_rad: f64) {
        self.turned_rad = turned_rad;
        match self.passes.iter_mut().find(|(p, ..)| *p == pass) {
            Some((_, sum, count)) => {
                *sum += value;
                *count += 1.0;
            }
            None => self.passes.push((pass, value, 1.0)),
        }
    }

    fn of_passes(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.passes.iter().map(|(_, sum, count)| sum / *count)
    }

    /// Mean over the passes; every pass counts alike.
    fn mean(&self) -> Option<Vector3<f64>> {
        (!self.passes.is_empty()).then(|| self.of_passes().sum::<Vector3<f64>>() / self.passes.len() as f64)
    }

    /// Standard uncertainty of the mean of a station, by the scatter of the passes over all stations.
    fn u_of_mean(stations: &[Self]) -> Option<Vector3<f64>> {
        let (mut squares, mut freedom, mut passes, mut used) = (Vector3::zeros(), 0.0, 0.0, 0.0);
        for station in stations {
            let Some(mean) = station.mean() else { continue };
            squares += station.of_passes().map(|v| (v - mean).map(|d| d * d)).sum::<Vector3<f64>>();
            freedom += station.passes.len() as f64 - 1.0;
            passes += station.passes.len() as f64;
            used += 1.0;
        }
        (freedom > 0.0).then(|| squares.map(|square: f64| (square / freedom / (passes / used)).sqrt()))
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    statistics::mean(values).unwrap_or(0.0)
}
