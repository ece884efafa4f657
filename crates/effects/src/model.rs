//! The model: the effects in the order they were added. File format of DESIGN §3.4.

/// A model: machine name and effects in the order they were added.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Machine name or path.
    pub machine: String,
    /// Entries in the order they were added.
    pub effects: Vec<ModelEffect>,
}

/// One `[[effect]]` of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelEffect {
    /// Effect id.
    pub id: String,
    /// Shape numbers, where the effect has some; empty: the fit chooses on the grid.
    pub shape: Vec<f64>,
    /// Parameters held at a value (screen units) by name.
    pub fixed: Vec<(String, f64)>,
}

impl Model {
    /// `location-errors` and `ball-setting` alone.
    pub fn base(machine: &str) -> Self {
        let entry = |id: &str| ModelEffect { id: id.into(), ..ModelEffect::default() };
        Self { machine: machine.into(), effects: crate::catalogue::BASE.map(entry).into() }
    }
}
