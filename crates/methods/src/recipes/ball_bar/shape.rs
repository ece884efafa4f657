//! Mean, setting and shape of each trace by least squares, and what the shapes at several heights say of an axis.

use super::track::{Axis, Kind, Sample, Track, span, whole_turn};
use crate::common::bar::{OFF_TOLERANCE, to_first_order};
use crate::common::feed::is_one_feed;
use crate::common::over_height::{Line, Weights};
use crate::common::shares::Shares;
use crate::common::stations::Stations;
use crate::recipes::{Method, MethodError};
use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use trunnion_core::AxisValues;
use trunnion_core::convert::rad_from_deg;
use trunnion_engine::solve::linear::least_squares;

/// Heights nearer than this count as one, mm.
const APART_MM: f64 = 5.0;

/// Axes that stand nearer than this stand at one place.
const SAME_RAD: f64 = rad_from_deg(0.5);

/// Angle or way around (rad) and deviation (mm).
pub(super) type Contour = Vec<(f64, f64)>;

/// One trace about its centre.
pub(super) struct Shape {
    /// S4's name, e.g. `C-X(−Z)`.
    pub label: String,
    pub setup: String,
    pub kind: Kind,
    pub calibrated: bool,
    /// c: mean of the displacement about the setting, mm, and its standard uncertainty by what the fit leaves.
    pub mean_mm: f64,
    pub u_mean_mm: f64,
    /// What each reading counts in the mean, and in the centre.
    pub shares_of_mean: Shares,
    pub shares_of_centre: [Shares; 2],
    /// S4's mean radial error: c counted tool against table, mm.
    pub mean_reading_mm: f64,
    /// Setting s of the ball; of C-XY the tilts (E_u0, E_v0), rad; of a path the setting is in table axes and not here.
    pub centre: Vector2<f64>,
    pub u_centre: Vector2<f64>,
    /// Range of the contours.
    pub circularity_mm: f64,
    /// Mean over each direction, forward first.
    pub contours: Vec<(f64, Contour)>,
    /// Mean over the directions.
    pub mean_contour: Contour,
    /// Forward mean less backward mean; `None` in one direction alone.
    pub reversal_mm: Option<f64>,
    /// How far the trace goes around, rad.
    pub turned_rad: f64,
    /// Where the other rotary axes stood, rad.
    pub stood_rad: AxisValues<f64>,
    /// Speed of the axis, rad/s; zero where the run does not show it.
    pub feed_rad_per_s: f64,
}

impl Shape {
    /// Every trace about its centre; traces of one axis at common angles.
    ///
    /// # Errors
    /// Readings that do not separate the place of the axis from the setting of the ball.
    pub fn of_all(method: &Method, tracks: &[Track]) -> Result<Vec<Self>, MethodError> {
        let mut shapes: Vec<Self> = Vec::new();
        for track in tracks {
            let of_one_axis = |other: &&Track| match track.kind.axis() {
                Some(axis) => other.kind.axis() == Some(axis),
                None => std::ptr::eq(*other, track),
            };
            let angles: Vec<f64> = tracks
                .iter()
                .filter(of_one_axis)
                .flat_map(|t| t.samples.iter().map(|s| s.angle_rad))
                .collect();
            let turn = whole_turn(&angles);
            let stations = match track.on_the_fly {
                true => Stations::of_sweeps(&angles, turn),
                false => Stations::of_grid(angles.iter().copied(), turn),
            };
            let mut shape = Self::of(method, track, &stations)?;
            shape.label = label(track, tracks);
            if shapes.iter().any(|other| other.label == shape.label) {
                shape.label = format!("{} {}", shape.label, track.setup);
            }
            shapes.push(shape);
        }
        Ok(shapes)
    }

    fn of(method: &Method, track: &Track, stations: &Stations) -> Result<Self, MethodError> {
        let samples = &track.samples;
        let rows: Vec<Vec<f64>> = samples.iter().map(|sample| centring(track.kind, sample)).collect();
        let design = DMatrix::from_fn(samples.len(), rows[0].len(), |i, k| rows[i][k]);
        let moved = moved_mm(track, &design);
        let fit = least_squares(&design, &moved, 1e-6);
        if fit.rank < rows[0].len() && track.kind != Kind::Path {
            let found = format!(
                "in the readings of setup {} the mean is confounded with the setting of the ball",
                track.setup
            );
            return Err(method.lacks(found, "Turn the axis farther, best once around."));
        }
        let left = moved - &design * &fit.x;
        let contour = |direction: f64| -> Contour {
            let of_direction = samples.iter().zip(left.iter()).filter(|(s, _)| s.direction == direction);
            stations.contour(of_direction.map(|(sample, left)| (sample.angle_rad, *left)))
        };
        let contours: Vec<(f64, Contour)> =
            [1.0, -1.0].map(|d| (d, contour(d))).into_iter().filter(|(_, c)| !c.is_empty()).collect();
        let mean_contour = mean_of(&contours, &stations.angles_rad);
        let mean = |contour: &Contour| contour.iter().map(|(_, v)| v).sum::<f64>() / contour.len() as f64;
        let reversal_mm = match &contours[..] {
            [(_, forward), (_, backward)] => Some(mean(forward) - mean(backward)),
            _ => None,
        };
        let read: Vec<Shares> =
            samples.iter().map(|s| Shares::of(s.number, 0, s.moved_per_reading)).collect();
        let mut shares = Shares::of_fit(&design, &fit, &read).into_iter();
        let sign = samples.iter().map(|s| s.reading_mm * s.moved_mm).sum::<f64>();
        let pair = |of: &DVector<f64>| match of.len() {
            3 => Vector2::new(of[1], of[2]),
            _ => Vector2::zeros(),
        };
        Ok(Self {
            label: String::new(),
            setup: track.setup.clone(),
            kind: track.kind,
            calibrated: track.calibrated,
            mean_mm: fit.x[0],
            u_mean_mm: fit.u[0],
            shares_of_mean: shares.next().unwrap_or_default(),
            shares_of_centre: [(); 2].map(|()| shares.next().unwrap_or_default()),
            mean_reading_mm: if sign < 0.0 { -fit.x[0] } else { fit.x[0] },
            centre: pair(&fit.x),
            u_centre: pair(&fit.u),
            circularity_mm: span(contours.iter().flat_map(|(_, c)| c.iter().map(|(_, v)| *v))),
            contours,
            mean_contour,
            reversal_mm,
            turned_rad: span(samples.iter().map(|s| s.angle_rad)),
            stood_rad: track.stood_rad,
            feed_rad_per_s: track.feed_rad_per_s,
        })
    }
}

impl Shape {
    /// Whether the other rotary axes stood where they do in `other`.
    pub fn stands_as(&self, other: &Self) -> bool {
        self.stood_rad.0.iter().zip(&other.stood_rad.0).all(|(a, b)| is_same_angle(*a, *b))
    }

    /// Whether the axis turned as fast as in `other`; not known counts as yes.
    pub fn turns_as_fast(&self, other: &Self) -> bool {
        let (a, b) = (self.feed_rad_per_s, other.feed_rad_per_s);
        a <= 0.0 || b <= 0.0 || is_one_feed(a, b)
    }

    /// Whether both are the same measurement, wherever other axes stood and whatever the feed was.
    pub fn is_same_measurement(&self, other: &Self) -> bool {
        match (self.kind, other.kind) {
            (Kind::Across { axis, k, height_mm }, Kind::Across { axis: a, k: l, height_mm: h }) => {
                axis == a && k == l && (height_mm - h).abs() < APART_MM
            }
            (Kind::Along { axis }, Kind::Along { axis: a }) => axis == a,
            _ => false,
        }
    }
}

/// Whether an axis stands at one place.
pub(super) fn is_same_angle(a_rad: f64, b_rad: f64) -> bool {
    (a_rad - b_rad).abs() < SAME_RAD
}

/// Columns of the fit: the mean first.
fn centring(kind: Kind, sample: &Sample) -> Vec<f64> {
    let (sin, cos) = sample.angle_rad.sin_cos();
    match kind {
        Kind::Across { .. } => vec![1.0, cos, sin],
        Kind::Along { .. } => vec![1.0],
        Kind::Followed { .. } => vec![1.0, sample.across_mm.y, -sample.across_mm.x],
        Kind::Path => {
            let n = sample.bar_mm.normalize();
            vec![1.0, n.x, n.y, n.z]
        }
    }
}

/// Displacements as if the ball sat so little off that it reads as the columns of the centring alone.
fn moved_mm(track: &Track, design: &DMatrix<f64>) -> DVector<f64> {
    let samples = &track.samples;
    let per_reading = DVector::from_iterator(samples.len(), samples.iter().map(|s| s.moved_per_reading));
    let moved = DVector::from_iterator(samples.len(), samples.iter().map(|s| s.moved_mm));
    let bars_mm: Vec<Vector3<f64>> = samples.iter().map(|s| s.bar_mm).collect();
    let off = |read: &DVector<f64>| -> Vec<Vector3<f64>> {
        let x = least_squares(design, &read.component_mul(&per_reading), OFF_TOLERANCE).x;
        samples.iter().map(|sample| off_mm(track.kind, &x, sample)).collect()
    };
    to_first_order(&moved.component_div(&per_reading), &bars_mm, off).component_mul(&per_reading)
}

/// What the tool's ball is off against the table's by the setting of the ball, as far as the trace shows it, in the axes of its bar.
fn off_mm(kind: Kind, x: &DVector<f64>, sample: &Sample) -> Vector3<f64> {
    match kind {
        Kind::Across { k, .. } => {
            let (sin, cos) = sample.angle_rad.sin_cos();
            // The setting turns with the axis: what lies along the bar lay across it a quarter turn ago.
            let (along, across) = (x[1] * cos + x[2] * sin, x[1] * sin - x[2] * cos);
            let carried =
                if k == 0 { Vector3::new(along, across, 0.0) } else { Vector3::new(-across, along, 0.0) };
            carried * (sample.moved_per_reading * sample.bar_mm[k]).signum()
        }
        Kind::Path => Vector3::new(x[1], x[2], x[3]),
        Kind::Along { .. } | Kind::Followed { .. } => Vector3::zeros(),
    }
}

fn mean_of(contours: &[(f64, Contour)], angles_rad: &[f64]) -> Contour {
    let at = |angle: f64| {
        let here =
            || contours.iter().filter_map(|(_, c)| c.iter().find(|(a, _)| *a == angle).map(|(_, v)| *v));
        let count = here().count();
        (count > 0).then(|| (angle, here().sum::<f64>() / count as f64))
    };
    angles_rad.iter().filter_map(|&angle| at(angle)).collect()
}

/// S4's name: axis, bar, and the side of the ball where there are several heights.
fn label(track: &Track, tracks: &[Track]) -> String {
    let Some(axis) = track.kind.axis() else { return format!("path {}", track.setup) };
    let [u, v, w] = axis.frame;
    match track.kind {
        Kind::Across { k, height_mm, .. } => {
            let heights: Vec<f64> = tracks
                .iter()
                .filter_map(|t| match t.kind {
                    Kind::Across { axis: a, height_mm, .. } if a == axis => Some(height_mm),
                    _ => None,
                })
                .collect();
            let middle = heights.iter().sum::<f64>() / heights.len() as f64;
            let side = match height_mm - middle {
                _ if span(heights.iter().copied()) < APART_MM => String::new(),
                off if off < 0.0 => format!("(−{w})"),
                _ => format!("(+{w})"),
            };
            format!("{}-{}{side}", axis.letter, axis.frame[k])
        }
        Kind::Followed { .. } => {
            let [first, second] = if u < v { [u, v] } else { [v, u] };
            format!("{}-{first}{second}", axis.letter)
        }
        _ => format!("{}-{w}", axis.letter),
    }
}

/// What the traces of one axis say together.
pub(super) struct AxisShapes {
    pub axis: Axis,
    /// Place of the axis line over the height along u and v; `None` without two heights.
    pub line: [Option<Line>; 2],
    /// What each reading counts in it: at zero, and in its slope.
    pub shares_of_line: [[Shares; 2]; 2],
    /// All bars across had known lengths.
    pub calibrated: bool,
    /// Radial error motions u, v at the reference point of the axis, axial w, mm; empty when not measured.
    pub translation: [Contour; 3],
    /// Heights at which the radial ones hold: the reference point with two heights, else that height, mm.
    pub radial_at_mm: [Option<f64>; 2],
    /// Tilts about u and v, rad.
    pub tilt: [Contour; 2],
    /// Where the other rotary axes stood, rad.
    pub stood_rad: AxisValues<f64>,
    /// The trace along the axis and where the others stood, where that is elsewhere.
    pub axial_elsewhere: Option<(String, AxisValues<f64>)>,
    /// Further traces of the axis where others stood elsewhere: they are in none of these.
    pub elsewhere: Vec<String>,
}

impl AxisShapes {
    /// One for each axis that turned alone.
    pub fn of_all(shapes: &[Shape]) -> Vec<Self> {
        let mut axes: Vec<Axis> = Vec::new();
        for shape in shapes {
            if let Kind::Across { axis, .. } | Kind::Along { axis } = shape.kind
                && !axes.contains(&axis)
            {
                axes.push(axis);
            }
        }
        axes.into_iter()
            .filter_map(|axis| {
                let own = |shape: &&Shape| shape.kind.axis() == Some(axis) && shape.kind.alone();
                let own: Vec<&Shape> = shapes.iter().filter(own).collect();
                // Where the others stood at most heights, of equals first: what carries the axis is in its errors.
                let mut here: Vec<&Shape> = Vec::new();
                for first in &own {
                    let stand: Vec<&Shape> =
                        own.iter().copied().filter(|shape| shape.stands_as(first)).collect();
                    if here.is_empty() || heights(&stand) > heights(&here) {
                        here = stand;
                    }
                }
                let first = *here.first()?;
                // Along the axis one trace is enough, wherever it was read.
                let is_axial = |shape: &&&Shape| matches!(shape.kind, Kind::Along { .. });
                let axial = here.iter().chain(&own).find(is_axial).copied();
                let elsewhere = own.iter().filter(|shape| !shape.stands_as(first));
                let further =
                    elsewhere.filter(|shape| !axial.is_some_and(|axial| std::ptr::eq(axial, **shape)));
                let further = further.map(|shape| shape.label.clone()).collect();
                Some(Self::of(axis, first, &here, axial, further))
            })
            .collect()
    }

    fn of(
        axis: Axis,
        first: &Shape,
        shapes: &[&Shape],
        axial: Option<&Shape>,
        elsewhere: Vec<String>,
    ) -> Self {
        let across = |wanted: usize| -> Vec<(f64, &Shape)> {
            let of = |shape: &'_ Shape| match shape.kind {
                Kind::Across { axis: a, k, height_mm } if a == axis && k == wanted => Some(height_mm),
                _ => None,
            };
            shapes.iter().filter_map(|shape| Some((of(shape)?, *shape))).collect()
        };
        let along = axial.map(|shape| shape.mean_contour.clone()).unwrap_or_default();
        let axial_elsewhere = axial.filter(|shape| !shape.stands_as(first));
        let mut found = Self {
            axis,
            line: [None, None],
            shares_of_line: Default::default(),
            calibrated: [0, 1].iter().flat_map(|&k| across(k)).all(|(_, shape)| shape.calibrated),
            translation: [Vec::new(), Vec::new(), along],
            radial_at_mm: [None, None],
            tilt: [Vec::new(), Vec::new()],
            stood_rad: first.stood_rad,
            axial_elsewhere: axial_elsewhere.map(|shape| (shape.label.clone(), shape.stood_rad)),
            elsewhere,
        };
        for k in 0..2 {
            let traces = across(k);
            let heights: Vec<f64> = traces.iter().map(|(height, _)| *height).collect();
            if span(heights.iter().copied()) < APART_MM {
                if let Some((height, shape)) = traces.first() {
                    found.translation[k] = shape.mean_contour.clone();
                    found.radial_at_mm[k] = Some(*height);
                }
                continue;
            }
            let over = Weights::of(&heights);
            let means: Vec<f64> = traces.iter().map(|(_, shape)| shape.mean_mm).collect();
            let u: Vec<f64> = traces.iter().map(|(_, shape)| shape.u_mean_mm).collect();
            found.line[k] = Some(over.line(&means, &u));
            let shares: Vec<&Shares> = traces.iter().map(|(_, shape)| &shape.shares_of_mean).collect();
            found.shares_of_line[k] = over.shares(&shares);
            found.radial_at_mm[k] = Some(0.0);
            // u = δ_u + ω_v h, v = δ_v − ω_u h.
            let (tilt, sign) = if k == 0 { (1, 1.0) } else { (0, -1.0) };
            for &(angle, _) in &traces[0].1.mean_contour {
                let at =
                    |shape: &Shape| shape.mean_contour.iter().find(|(a, _)| *a == angle).map(|(_, v)| *v);
                let Some(values) = traces.iter().map(|(_, shape)| at(shape)).collect::<Option<Vec<f64>>>()
                else {
                    continue;
                };
                let line = over.line(&values, &vec![0.0; values.len()]);
                found.translation[k].push((angle, line.at_zero));
                found.tilt[tilt].push((angle, sign * line.slope));
            }
        }
        found
    }
}

/// At how many heights bars lay across the axis: of the direction with more of them, and of both together.
fn heights(shapes: &[&Shape]) -> (usize, usize) {
    let of = |wanted: usize| {
        let mut heights: Vec<f64> = shapes
            .iter()
            .filter_map(|shape| match shape.kind {
                Kind::Across { k, height_mm, .. } if k == wanted => Some(height_mm),
                _ => None,
            })
            .collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|next, kept| *next - *kept < APART_MM);
        heights.len()
    };
    (of(0).max(of(1)), of(0) + of(1))
}
