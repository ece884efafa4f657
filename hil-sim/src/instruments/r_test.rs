//! R-test, nest on the table: `table_from_machine·p_tool − nominal nest + setting`, table axes [docs/design/physics.md §1, S1 eq. 4];
//! nest in the spindle: `p_table − p_tool`, machine axes [S0].

use super::virtual_instrument::VirtualInstrument;
use crate::truth::{NestOn, PlacedSetup};
use trunnion_core::InstrumentKind;

pub(super) static INSTRUMENT: VirtualInstrument = VirtualInstrument {
    kinds: &[InstrumentKind::RTest],
    mounted: |setup, setting_mm, _| PlacedSetup::new(setup, setting_mm),
    reading: |seen| match seen.placed.setup.nest {
        NestOn::Table => {
            let poses = seen.poses;
            let tool_in_table =
                poses.machine_from_table.inverse() * (seen.tool_in_machine - poses.table_in_machine_mm);
            // The setting is that of the ball against the nest.
            (tool_in_table - seen.placed.setup.ball_in_table_mm + seen.setting).into()
        }
        NestOn::Spindle => (-seen.apart).into(),
    },
};
