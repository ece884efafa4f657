//! What every parameter does to tool against table at every place of a volume.

use super::Volume;
use crate::NotTabulated;
use crate::axis_errors::{changed_states, differ, size, state_at};
use nalgebra::{DMatrix, Isometry3, Point3, Vector3};
use trunnion_core::{AxisValues, Joint, Slot, State, Twist};
use trunnion_effects::{Instance, Model, Scene};
use trunnion_engine::{Identification, IdentifyError};
use trunnion_machine::propagation::JointFrame;
use trunnion_machine::{JointErrors, Side, Site};

/// Twists that move less are none, mm and rad.
const NOTHING: f64 = 1e-15;

/// The columns of a map.
pub struct Columns {
    /// Axis positions of the places, mm and rad.
    pub positions: Vec<AxisValues<f64>>,
    /// Nominal point of the tool at them, table axes, mm.
    pub in_table_mm: Vec<Point3<f64>>,
    /// Index in the fit of the parameter of each column.
    pub parameters: Vec<usize>,
    /// d e/d parameter, inside units; rows: X Y Z A B C of each place.
    pub by_parameter: DMatrix<f64>,
    /// What is not in it.
    pub left_out: Vec<NotTabulated>,
}

/// An effect at its place in the fit.
struct Placed {
    id: String,
    instance: Instance,
    shape: Vec<f64>,
    first: usize,
}

/// A place, and what turns joint errors into deviations there.
struct Place {
    frames: Vec<(Joint, f64, JointFrame)>,
    table_from_machine: Isometry3<f64>,
    tool_in_machine_mm: Point3<f64>,
}

impl Columns {
    /// Columns over the grid of a volume.
    ///
    /// # Errors
    /// An effect the machine cannot have.
    pub fn new(
        scene: &Scene,
        model: &Model,
        fit: &Identification,
        volume: &Volume,
    ) -> Result<Self, IdentifyError> {
        let mut effects = Vec::new();
        for entry in &model.effects {
            let instance = Instance::from_model_effect(entry, &scene.machine)?;
            let shape = fit.effects.iter().find(|e| e.id == entry.id).map_or(Vec::new(), |e| e.shape.clone());
            let first = fit.parameters.iter().position(|p| p.effect == entry.id);
            effects.extend(first.map(|first| Placed { id: entry.id.clone(), instance, shape, first }));
        }
        let positions = volume.grid();
        let mut full = DMatrix::zeros(6 * positions.len(), fit.parameters.len());
        let mut in_table_mm = Vec::with_capacity(positions.len());
        for (k, position) in positions.iter().enumerate() {
            let place = Place::new(scene, position, volume);
            in_table_mm.push(place.table_from_machine * place.tool_in_machine_mm);
            let state = state_at(scene, |letter| position[letter]);
            for effect in &effects {
                effect.instance.motions(scene, &effect.shape, &state, &mut |parameter, site, twist| {
                    let Site::Joint(letter) = site else { return };
                    let moved = place.deviation(letter, &twist);
                    let mut column = full.column_mut(effect.first + parameter);
                    for i in 0..3 {
                        column[6 * k + i] += moved.translation_mm[i];
                        column[6 * k + 3 + i] += moved.rotation_rad[i];
                    }
                });
            }
        }
        let parameters: Vec<usize> = (0..full.ncols()).filter(|&j| full.column(j).amax() > NOTHING).collect();
        let by_parameter = full.select_columns(&parameters);
        let left_out = effects.iter().filter_map(|effect| effect.left_out(scene, fit)).collect();
        Ok(Self { positions, in_table_mm, parameters, by_parameter, left_out })
    }
}

impl Place {
    fn new(scene: &Scene, position: &AxisValues<f64>, volume: &Volume) -> Self {
        let machine = &scene.machine;
        let nominal = JointErrors::default();
        let sides = [(Side::Table, -1.0), (Side::Tool, 1.0)];
        let frames = sides.into_iter().flat_map(|(side, sign)| {
            let frame = move |letter| Some((letter, sign, machine.joint_frame(letter, position)?));
            machine.from_bed(side).into_iter().filter_map(move |axis| frame(axis.letter)).collect::<Vec<_>>()
        });
        Self {
            frames: frames.collect(),
            table_from_machine: machine.machine_from_table(position, &nominal).inverse(),
            tool_in_machine_mm: machine.machine_from_tool(position, &nominal)
                * Point3::from(Vector3::from(volume.point_in_tool_mm)),
        }
    }

    /// Deviation of tool against table by the error twist of one joint, table axes.
    fn deviation(&self, letter: Joint, twist: &Twist) -> Twist {
        let Some((_, sign, frame)) = self.frames.iter().find(|(joint, ..)| *joint == letter) else {
            return Twist::default();
        };
        let moved_mm = frame.displacement_mm(&self.tool_in_machine_mm, twist);
        let table_from_machine = self.table_from_machine.rotation;
        Twist {
            translation_mm: (table_from_machine * moved_mm) * *sign,
            rotation_rad: (table_from_machine * frame.turned(twist).rotation_rad) * *sign,
        }
    }
}

impl Placed {
    /// Motions of the joints with the numbers found; true when something other than the joints moves.
    fn motions(&self, scene: &Scene, fit: &Identification, state: &State) -> (JointErrors, bool) {
        let (mut joints, mut elsewhere) = (JointErrors::default(), false);
        self.instance.motions(scene, &self.shape, state, &mut |parameter, site, twist| {
            let part = twist * fit.solution[self.first + parameter];
            match site {
                Site::Joint(letter) => joints[letter] += part,
                Site::TableBall | Site::SpindleBall | Site::Reading | Site::Instrument(_) => {
                    elsewhere |= size(&part) > 0.0;
                }
            }
        });
        (joints, elsewhere)
    }

    /// What of the effect the map does not hold.
    fn left_out(&self, scene: &Scene, fit: &Identification) -> Option<NotTabulated> {
        let here = state_at(scene, |letter| {
            let (low, high) = scene.position_range[letter];
            low + 0.61803 * (high - low)
        });
        let (joints, elsewhere) = self.motions(scene, fit, &here);
        let why = |why: String| Some(NotTabulated { effect: self.id.clone(), why, holds_axis_at_rest: None });
        if elsewhere {
            return why("it moves ball, nest or reading, not an axis".into());
        }
        let changes = |state: &State| {
            let (changed, _) = self.motions(scene, fit, state);
            Slot::ALL.into_iter().any(|letter| differ(&changed[letter], &joints[letter]))
        };
        let what = changed_states(scene, &here).into_iter().find(|(_, state)| changes(state))?.0;
        why(format!("it depends on {what}; the map holds it at rest, at the beginning"))
    }
}
