//! Location errors in the two notations of the review [S2 §2.1, tables 1–5], and conversion both ways.
//!
//! Absolute [ISO 230-1; S2 tables 2 and 3]: place and direction of each axis average line in the machine coordinate system, E_X0C ….
//! Relative [Inasaki, S2 table 4]: those of the line against that of the axis that carries it, δx_CA, β_CA …; of the first axis on
//! the bed against the X axis, which (with Y in the XY plane) is the datum.
//!
//! With a neighbour n below the axis k, both at zero of all axes, o the nominal point of the line:
//! ω_k = ω_kn + ω_n,   δ_k = δ_kn + δ_n + ω_n × (o_k − o_n)     [β_CA = E_B0C − E_B0A, S2 §2.1; δy_CA = E_Y0C − E_Y0A, table 5]
//! A linear axis has a direction only, so that an axis on it has its place in the machine. The linear axes: γ_YX, β_ZX, α_ZY.
//! In table 5 the review prints α_CA for β_CA, and in tables 4 and 5 α_YX for what it calls squareness of Z to Y, here α_ZY.
//!
//! The model's own parameters are twists of each joint against what carries it: relative for rotary axes in a row; a rotary axis on
//! linear ones is against their carriages, which squareness does not turn. Limits: small angles; axes in series (strokes of
//! legs have no line of their own here); errors that the model lacks are zero.

use nalgebra::{DMatrix, DVector, Vector3};
use trunnion_core::Joint;
use trunnion_effects::{Role, Unit};
use trunnion_engine::{Identification, Status, Unobservable};
use trunnion_machine::{Axis, Machine, Side};

/// A sum changes along a direction by more than this share of its terms: more is no rounding.
const SAME: f64 = 1e-6;

/// Which way location errors are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// Lines in the machine coordinate system.
    Absolute,
    /// Lines against the axis that carries them.
    Relative,
}

impl Notation {
    /// Names on the command line.
    pub const NAMES: [(&'static str, Self); 2] = [("absolute", Self::Absolute), ("relative", Self::Relative)];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Absolute => "absolute",
            Self::Relative => "relative",
        }
    }
}

/// One component of the location of one line.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// The axis.
    pub axis: Joint,
    /// The axis it is against in relative notation; `None` where it is the datum of the machine coordinate system itself.
    pub against: Joint,
    /// Direction: X Y Z of a place, A B C of an angle.
    pub direction: Joint,
}

/// What a notation says of one component.
#[derive(Clone, Debug, PartialEq)]
pub struct LocationError {
    /// Symbol in the notation, e.g. `E_B0C` as `EB0C`, or `β_CA`.
    pub symbol: String,
    /// The component.
    pub component: Component,
    /// Value, mm or rad; `None` when it depends on what the runs do not see.
    pub value: Option<f64>,
    /// Standard uncertainty, mm or rad; `None` when all of it is held, zero by convention, or not in the model.
    pub u: Option<f64>,
    /// Parameters that these runs give no number to and on which it depends.
    pub without_number: Vec<String>,
}

/// The components of a machine, and how its notations hang together.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Components, from the table to the tool.
    pub components: Vec<Component>,
    /// absolute = A · joint twists.
    absolute_from_joints: DMatrix<f64>,
    /// relative = B · joint twists.
    relative_from_joints: DMatrix<f64>,
}

impl LocationError {
    /// Unit on screens.
    pub fn unit(&self) -> Unit {
        if self.component.direction.is_rotary() { Unit::URAD } else { Unit::UM }
    }
}

impl Component {
    /// Name of the model's parameter.
    pub fn parameter(&self) -> String {
        format!("E{}0{}", self.direction, self.axis)
    }

    /// Symbol in a notation.
    pub fn symbol(&self, notation: Notation) -> String {
        match notation {
            Notation::Absolute => self.parameter(),
            Notation::Relative => {
                let what = ["δx", "δy", "δz", "α", "β", "γ"][self.direction.index()];
                format!("{what}_{}{}", self.axis, self.against)
            }
        }
    }
}

impl Layout {
    /// The components of a machine.
    pub fn new(machine: &Machine) -> Self {
        let mut components = Vec::new();
        let six =
            |axis: Joint, against: Joint| Joint::ALL.map(|direction| Component { axis, against, direction });
        let mut lower = Joint::X;
        for axis in machine.from_bed(Side::Table).into_iter().filter(|axis| axis.is_rotary()) {
            components.extend(six(axis.letter, lower));
            lower = axis.letter;
        }
        let has = |letter: Joint| machine.axis(letter).is_some() && !machine.is_leg(letter);
        let (x, y, z) = (Joint::X, Joint::Y, Joint::Z);
        for (axis, against, direction) in [(y, x, Joint::C), (z, x, Joint::B), (z, y, Joint::A)] {
            if has(axis) && has(against) {
                components.push(Component { axis, against, direction });
            }
        }
        let mut lower = Joint::X;
        for axis in machine.from_bed(Side::Tool) {
            if axis.is_rotary() {
                components.extend(six(axis.letter, lower));
            }
            if !machine.is_leg(axis.letter) {
                lower = axis.letter;
            }
        }
        let mut layout = Self {
            absolute_from_joints: DMatrix::identity(components.len(), components.len()),
            relative_from_joints: DMatrix::identity(components.len(), components.len()),
            components,
        };
        layout.fill(machine);
        layout
    }

    fn at(&self, axis: Joint, direction: Joint) -> Option<usize> {
        self.components.iter().position(|c| c.axis == axis && c.direction == direction)
    }

    fn fill(&mut self, machine: &Machine) {
        for side in [Side::Table, Side::Tool] {
            let rotary: Vec<&Axis> =
                machine.from_bed(side).into_iter().filter(|axis| axis.is_rotary()).collect();
            for (i, axis) in rotary.iter().enumerate() {
                for lower in &rotary[..i] {
                    self.carried(axis, lower);
                }
            }
            // The lowest rotary axis on a linear one is against its line, which may lean.
            for (i, component) in self.components.clone().iter().enumerate() {
                let lowest = rotary.first().is_some_and(|axis| axis.letter == component.axis);
                let below = self.at(component.against, component.direction);
                if let Some(j) = below.filter(|_| lowest && component.direction.is_rotary()) {
                    self.relative_from_joints[(i, j)] -= 1.0;
                }
            }
        }
    }

    /// Adds what the joint of `lower` does to the line of `axis` in the machine.
    fn carried(&mut self, axis: &Axis, lower: &Axis) {
        let arm_mm = axis.through_mm - lower.through_mm;
        for (k, letter) in Joint::ALL.into_iter().enumerate() {
            let Some(from) = self.at(lower.letter, letter) else { continue };
            let Some(to) = self.at(axis.letter, letter) else { continue };
            self.absolute_from_joints[(to, from)] += 1.0;
            if !letter.is_rotary() {
                continue;
            }
            let moved_mm = Vector3::ith(k - 3, 1.0).cross(&arm_mm);
            for (i, direction) in Joint::LINEAR.into_iter().enumerate() {
                if let Some(to) = self.at(axis.letter, direction) {
                    self.absolute_from_joints[(to, from)] += moved_mm[i];
                }
            }
        }
    }

    /// Matrix from the joint twists of the model to a notation.
    pub fn from_joints(&self, notation: Notation) -> &DMatrix<f64> {
        match notation {
            Notation::Absolute => &self.absolute_from_joints,
            Notation::Relative => &self.relative_from_joints,
        }
    }

    /// Values and covariance of one notation in another. Both in the order of [`Self::components`], mm and rad.
    pub fn convert(
        &self,
        from: Notation,
        to: Notation,
        values: &DVector<f64>,
        covariance: &DMatrix<f64>,
    ) -> (DVector<f64>, DMatrix<f64>) {
        // Unit triangular up to the order of the rows: always solvable.
        let inverse = self.from_joints(from).clone().try_inverse();
        let to_from = inverse.map_or_else(
            || DMatrix::identity(values.len(), values.len()),
            |inverse| self.from_joints(to) * inverse,
        );
        (&to_from * values, &to_from * covariance * to_from.transpose())
    }

    /// The location errors of a fit in a notation; components that nothing of the model is part of are left out.
    pub fn of_fit(&self, fit: &Identification, notation: Notation) -> Vec<LocationError> {
        let in_fit: Vec<Option<usize>> = self
            .components
            .iter()
            .map(|component| {
                fit.parameters.iter().position(|p| p.name == component.parameter() && of_location(&p.effect))
            })
            .collect();
        let matrix = self.from_joints(notation);
        let row = |i: usize| {
            let parts: Vec<(usize, f64)> = (0..matrix.ncols())
                .filter(|&j| matrix[(i, j)] != 0.0)
                .filter_map(|j| Some((in_fit[j]?, matrix[(i, j)])))
                .collect();
            in_fit[i]?;
            let sum: f64 = parts.iter().map(|&(j, c)| c * fit.parameters[j].value.unwrap_or(0.0)).sum();
            let variance: f64 = parts
                .iter()
                .flat_map(|&(i, a)| parts.iter().map(move |&(j, b)| (i, j, a * b)))
                .map(|(i, j, ab)| ab * fit.covariance[(i, j)])
                .sum();
            let numbers = parts.iter().any(|&(j, _)| fit.parameters[j].observable());
            let without_number = without_number(fit, &parts);
            let known = numbers && without_number.is_empty();
            Some(LocationError {
                symbol: self.components[i].symbol(notation),
                component: self.components[i].clone(),
                value: known.then_some(sum),
                u: (known && variance > 0.0).then(|| variance.sqrt()),
                without_number,
            })
        };
        (0..self.components.len()).filter_map(row).collect()
    }
}

/// Parameters without a number on which a sum of parameters depends: those not seen, and of each null direction along which the sum changes, the
/// one that is zero by convention. Where the sum stays the same along all of them, the convention does not matter.
fn without_number(fit: &Identification, parts: &[(usize, f64)]) -> Vec<String> {
    let name = |j: usize| fit.parameters[j].name.clone();
    let is_unseen = |j: usize| fit.parameters[j].status == Status::Unobservable;
    let unseen = parts.iter().filter(|(j, _)| is_unseen(*j)).map(|(j, _)| name(*j));
    let changes = |direction: &&Unobservable| {
        let terms: Vec<f64> = direction
            .inside
            .iter()
            .flat_map(|(j, d)| parts.iter().filter(move |part| part.0 == *j).map(move |part| part.1 * d))
            .collect();
        terms.iter().sum::<f64>().abs() > SAME * terms.iter().map(|term| term.abs()).sum::<f64>()
    };
    let zero = |direction: &Unobservable| {
        let terms = direction.inside.iter().map(|(j, _)| *j);
        terms.filter(|j| fit.parameters[*j].status == Status::ZeroByConvention).map(name).collect::<Vec<_>>()
    };
    let mut names: Vec<String> =
        unseen.chain(fit.unobservable.iter().filter(changes).flat_map(zero)).collect();
    names.sort();
    names.dedup();
    names
}

fn of_location(effect: &str) -> bool {
    trunnion_effects::catalogue::effect(effect).is_some_and(|effect| effect.role == Role::Location)
}

#[cfg(test)]
mod tests;
