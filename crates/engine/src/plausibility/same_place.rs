//! Two setups with the same balls by their setup file: a block that was copied, or a ball that was mounted again.
//!
//! A ball that was mounted again at the same place sees the same location errors. At another height they act with other levers: the readings
//! fit only with location errors of each setup.

use super::exchanged::BELIEVED;
use super::fitted::columns;
use super::found::{Implausible, plain};
use super::looked::Looked;
use trunnion_core::Setup;
use trunnion_core::convert::um_from_mm;
use trunnion_cycles::Run;

pub(super) fn implausible(run: &Run) -> Option<Implausible> {
    let setups = &run.setups;
    let pairs = (0..setups.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    let mut same = pairs.filter(|&(a, b)| is_same(&setups[a], &setups[b])).peekable();
    same.peek()?;
    let looked = Looked::at(run)?;
    let columns = columns(&looked.experiment)?;
    let readings_mm = looked.experiment.readings_mm();
    let left_mm = looked.model.rms_mm(&readings_mm);
    same.find_map(|(a, b)| {
        let mut own = columns.clone();
        for (at, point) in looked.experiment.points.iter().enumerate() {
            let share = f64::from(u8::from(point.state.setup == b));
            looked.experiment.rows_of(at).for_each(|row| own.row_mut(row).scale_mut(share));
        }
        let apart_mm = looked.model.rms_with_mm(&own, &readings_mm);
        (BELIEVED * apart_mm < left_mm).then(|| {
            let [left_um, apart_um] = [left_mm, apart_mm].map(um_from_mm);
            let [a, b] = [a, b].map(|setup| setups[setup].name.as_str());
            plain(
                format!(
                    "{}: the setups {a} and {b} have the same ball_in_table_mm and ball_in_tool_mm, but their readings are not of one place: together they \
                     leave {left_um:.1} µm, each with its own location errors {apart_um:.1} µm.",
                    run.name
                ),
                "Was the block [[setup]] copied and the height, or the length of the tool, not changed? Correct it, and X, Y and Z where they were computed from it.",
            )
        })
    })
}

fn is_same(a: &Setup, b: &Setup) -> bool {
    a.instrument.components().len() == 3
        && a.instrument == b.instrument
        && a.nest == b.nest
        && (a.ball_in_table_mm, a.ball_in_tool_mm) == (b.ball_in_table_mm, b.ball_in_tool_mm)
}
