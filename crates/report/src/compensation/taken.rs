//! Which of the errors of an axis a control takes, and what to say of the rest.

use trunnion_core::Joint;
use trunnion_results::{AxisErrors, AxisTable, Chain, LeftOutEffect};

/// Errors of less are none, mm and rad.
const NOTHING: f64 = 1e-12;

/// Why a component of an axis is not taken; `None` when it is.
pub(super) type Why<'a> = &'a dyn Fn(&AxisTable, Component) -> Option<String>;

/// One component of the errors of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    /// A location error, by direction X Y Z A B C.
    Location(usize),
    /// A component error, by direction.
    Table(usize),
}

/// The errors for which `why` has nothing to say; the others are named, with the reason.
pub(super) fn taken(errors: &AxisErrors, why: Why<'_>) -> AxisErrors {
    let mut kept = errors.clone();
    for table in &mut kept.axes {
        let whole = table.clone();
        let mut reasons: Vec<(String, Vec<String>)> = Vec::new();
        let mut left_out = |name: String, reason: String| match reasons.iter_mut().find(|(r, _)| *r == reason)
        {
            Some((_, names)) => names.push(name),
            None => reasons.push((reason, vec![name])),
        };
        for k in 0..6 {
            if whole.location[k].abs() > NOTHING
                && let Some(reason) = why(&whole, Component::Location(k))
            {
                left_out(format!("E{}0{}", Joint::ALL[k], whole.axis), reason);
                table.location[k] = 0.0;
            }
            if whole.errors.iter().any(|row| row[k].abs() > NOTHING)
                && let Some(reason) = why(&whole, Component::Table(k))
            {
                left_out(format!("E{}{}", Joint::ALL[k], whole.axis), reason);
                table.errors.iter_mut().for_each(|row| row[k] = 0.0);
            }
        }
        if table.errors.iter().flatten().all(|value| value.abs() <= NOTHING) {
            (table.positions, table.errors, table.whole_turn) = (Vec::new(), Vec::new(), false);
        }
        let named = |(why, names): (String, Vec<String>)| LeftOutEffect { effect: names.join(", "), why };
        kept.left_out.extend(reasons.into_iter().map(named));
    }
    kept.axes.retain(|table| !table.errors.is_empty() || table.location.iter().any(|v| v.abs() > NOTHING));
    kept
}

/// True for a spindle that is a joint.
pub(super) fn is_spindle(chain: &Chain, axis: &str) -> bool {
    chain.tool.iter().any(|joint| joint.spindle && joint.axis == axis)
}

/// True where the axis carries the workpiece.
pub(super) fn on_table(chain: &Chain, axis: &str) -> bool {
    chain.table.iter().any(|joint| joint.axis == axis)
}

/// The rotary axis that carries this one, if any.
pub(super) fn carrier<'a>(chain: &'a Chain, axis: &str) -> Option<&'a str> {
    let side = if on_table(chain, axis) { &chain.table } else { &chain.tool };
    let before = side.iter().take_while(|joint| joint.axis != axis);
    before.filter(|joint| joint.rotary).last().map(|joint| joint.axis.as_str())
}
