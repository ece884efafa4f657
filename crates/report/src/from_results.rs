//! From results to what is shown: the one place where inside units become screen units and poses become pictures.

use crate::{
    CompareInput, IdentificationView, Noise, ParameterRow, Place, PointView, SetupView, UnobservableRow,
};
use nalgebra::{DVector, Isometry3, Matrix3, UnitQuaternion, Vector3};
use trunnion_diagnose::Diagnosis;
use trunnion_identify::{Experiment, Identification, NoiseOrigin};
use trunnion_machine::{JointErrors, Machine};
use trunnion_measurement::{InstrumentKind, NestSide, Point, RunKind, Setup};
use trunnion_units::convert::um_from_mm;

impl CompareInput {
    /// The report of one fit. Label, ladder and losses are the caller's to fill in.
    pub fn new(experiment: &Experiment, fit: &Identification, diagnosis: Option<Diagnosis>) -> Self {
        let mut identification = IdentificationView::from(fit);
        if let (None, Some(diagnosis)) = (identification.noise.rms_um, &diagnosis) {
            let noise_um = diagnosis.residual.noise_um;
            if noise_um > 0.0 {
                let origin = "the diagnosis, from what stays random in the residual".into();
                identification.noise = Noise { rms_um: Some(noise_um), origin };
            }
        }
        Self {
            identification,
            label: String::new(),
            setups: experiment.setups.iter().map(SetupView::from).collect(),
            points: points_of(experiment, &fit.predicted_mm, &fit.used),
            on_the_fly: experiment.kinds.contains(&RunKind::OnTheFly),
            ladder: Vec::new(),
            diagnosis,
            losses: Vec::new(),
        }
    }
}

/// Points with their place; `predicted_mm` has the rows of the experiment, mm, and `used` one entry a point (points beyond
/// its end count as used).
pub fn points_of(experiment: &Experiment, predicted_mm: &DVector<f64>, used: &[bool]) -> Vec<PointView> {
    let view = |(i, point): (usize, &Point)| {
        let setup = &experiment.setups[point.state.setup];
        let mut predicted = [0.0; 3];
        for (k, row) in experiment.rows_of(i).enumerate() {
            predicted[k] = predicted_mm.get(row).copied().unwrap_or(f64::NAN);
        }
        let (in_machine, in_table_plane) = places(experiment.machine(), setup, point);
        PointView {
            setup: point.state.setup,
            position: point.state.position,
            direction: point.state.direction,
            time_s: point.state.time_s,
            measured_mm: point.reading_mm,
            predicted_mm: predicted,
            outlier: !used.get(i).copied().unwrap_or(true),
            in_machine,
            in_table_plane,
        }
    };
    experiment.points.iter().enumerate().map(view).collect()
}

/// Place of the table-side ball or nest in machine axes and in the axes that carry the turning table.
fn places(machine: &Machine, setup: &Setup, point: &Point) -> (Place, Place) {
    let position = &point.state.position;
    let machine_from_table = machine.machine_from_table(position, &JointErrors::default());
    let machine_from_tool = machine.machine_from_tool(position, &JointErrors::default());
    let ball_in_machine = machine_from_table * setup.ball_in_table_mm;
    let shift_from_reading = match (setup.instrument, setup.nest) {
        (InstrumentKind::RTest, NestSide::Table) => -rotation(&machine_from_table),
        (InstrumentKind::RTest, NestSide::Spindle) => rotation(&machine_from_tool),
        (InstrumentKind::BallBar, _) => {
            let along_bar = machine_from_tool.translation.vector - ball_in_machine.coords;
            let along_bar = along_bar.try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
            Matrix3::from_columns(&[-along_bar, Vector3::zeros(), Vector3::zeros()])
        }
    };
    let in_machine = Place { commanded_mm: ball_in_machine.coords, shift_from_reading };
    let turning = machine.table.iter().find(|axis| axis.is_rotary());
    let Some((axis, frame)) =
        turning.and_then(|axis| Some((axis, machine.joint_frame(axis.letter, position)?)))
    else {
        return (in_machine.clone(), in_machine);
    };
    let carrier_from_plane = UnitQuaternion::rotation_between(&Vector3::z(), &axis.direction)
        .unwrap_or_else(UnitQuaternion::identity);
    let plane_from_machine = (frame.machine_from_carrier * carrier_from_plane).inverse();
    let in_table_plane = Place {
        commanded_mm: plane_from_machine * (ball_in_machine - frame.origin_in_machine_mm),
        shift_from_reading: plane_from_machine.to_rotation_matrix().into_inner() * shift_from_reading,
    };
    (in_machine, in_table_plane)
}

fn rotation(pose: &Isometry3<f64>) -> Matrix3<f64> {
    pose.rotation.to_rotation_matrix().into_inner()
}

impl From<&Setup> for SetupView {
    fn from(setup: &Setup) -> Self {
        Self {
            name: setup.name.clone(),
            components: setup.instrument.components().iter().map(|name| (*name).into()).collect(),
            ball_in_table_mm: setup.ball_in_table_mm.coords,
        }
    }
}

impl From<&Identification> for IdentificationView {
    fn from(fit: &Identification) -> Self {
        let parameter = |p: &trunnion_identify::FittedParameter| ParameterRow {
            name: p.name.clone(),
            effect: p.effect.clone(),
            value: p.screen_value(),
            u: p.screen_u(),
            unit: p.unit.symbol.into(),
            note: p.note.clone(),
        };
        let unobservable = |row: &trunnion_identify::Unobservable| UnobservableRow {
            direction: row.direction.clone(),
            why: row.why.clone(),
        };
        Self {
            machine: fit.machine.clone(),
            runs: fit.runs.clone(),
            effects: fit.effects.iter().map(|effect| effect.id.clone()).collect(),
            points: fit.points,
            outliers: fit.outliers.len(),
            rms_um: um_from_mm(fit.rms_mm),
            noise: noise_view(fit.noise),
            holdout_rms_um: fit.holdout_rms_mm().map(um_from_mm),
            parameters: fit.parameters.iter().map(parameter).collect(),
            unobservable: fit.unobservable.iter().map(unobservable).collect(),
        }
    }
}

/// A noise figure taken from the residual itself is no floor: it contains whatever the model lacks.
fn noise_view(noise: trunnion_identify::Noise) -> Noise {
    match noise.origin {
        NoiseOrigin::Repeats => Noise {
            rms_um: Some(um_from_mm(noise.sigma_mm)),
            origin: format!("poses measured more than once, {} degrees of freedom", noise.degrees_of_freedom),
        },
        NoiseOrigin::Residual => Noise {
            rms_um: None,
            origin: "unknown: no pose was measured twice, so nothing separates noise from error".into(),
        },
    }
}
