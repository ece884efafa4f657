//! The presets in the guide.

use crate::section::write_or_compare;
use trunnion_protocol::ascii::{PRESETS, Preset, Stamp};

#[test]
fn the_guide_lists_the_presets() {
    let mut table = String::from(
        "| preset | what it is | asks | line speed | not confirmed by a manual |\n|---|---|---|---|---|\n",
    );
    for preset in PRESETS {
        table += &format!(
            "| `{}` | {} | {} | {} {} | {} |\n",
            preset.name,
            preset.about,
            asks(preset),
            preset.baud,
            preset.framing,
            preset.unconfirmed
        );
    }
    write_or_compare("docs/use/connect.md", "presets", &table);
}

/// The request without its line end, a control character by its name.
fn asks(preset: &Preset) -> String {
    let request = match preset.request.trim_end_matches(['\r', '\n']) {
        "" => return "nothing, it talks".into(),
        "\x02" => "STX".into(),
        request => format!("`{}`", request.escape_default()),
    };
    match preset.stamp {
        Stamp::Request => request + "; value latched at the request",
        Stamp::Between | Stamp::Arrival => request,
    }
}
