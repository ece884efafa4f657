//! What was found, for people and for programs.

use serde_json::{Value, json};
use trunnion_acquire::discovery::{Look, Roles};

/// Places with their answers, then the lines to paste.
pub fn text(looks: &[Look]) -> String {
    if looks.is_empty() {
        return "No serial port and no CAN interface. Plug an adapter in; `dmesg` says what the system makes of it. Controllers on the \
                network are looked for with --url HOST.\n"
            .into();
    }
    let mut text = String::new();
    for look in looks {
        text += &heading(look);
        if let Some((driver, found)) = &look.found {
            text += &format!("  {driver}: {}\n", found.identity);
        }
        if let Some(trouble) = &look.trouble {
            text += &format!("  {trouble}\n");
        }
        if look.found.is_none() && !look.asked.is_empty() {
            text += &format!("  asked {}\n", look.asked.join("; "));
        }
    }
    let tables: Vec<String> = tables(looks).into_iter().flatten().collect();
    if !tables.is_empty() {
        text +=
            "\nFor the configuration (see which probe is which by moving it; fill in where there is a ?):\n";
        for table in tables {
            text += &format!("\n{table}");
        }
    }
    text
}

fn heading(look: &Look) -> String {
    let place = &look.place;
    let mut heading = place.address.clone();
    if place.device != place.address {
        heading += &format!(" ({})", place.device);
    }
    if !place.about.is_empty() {
        heading += &format!(", {}", place.about);
    }
    heading + "\n"
}

/// `{"format": "trunnion-devices/1", "places": […]}`
pub fn json(looks: &[Look]) -> Value {
    let tables = tables(looks);
    let place = |(look, table): (&Look, Option<String>)| {
        json!({
            "address": look.place.address,
            "device": look.place.device,
            "about": look.place.about,
            "driver": look.found.as_ref().map(|(driver, _)| driver),
            "identity": look.found.as_ref().map(|(_, found)| &found.identity),
            "config": table,
            "trouble": look.trouble,
            "asked": look.asked,
        })
    };
    let places: Vec<Value> = looks.iter().zip(tables).map(place).collect();
    json!({ "format": "trunnion-devices/1", "places": places })
}

/// The lines to paste of each place.
fn tables(looks: &[Look]) -> Vec<Option<String>> {
    let mut roles = Roles::default();
    looks.iter().map(|look| look.found.as_ref().map(|(driver, found)| roles.table(driver, found))).collect()
}
