//! What was found, for people and for programs.

use trunnion::results::{DevicePlace, DevicesFormat, DevicesFound};
use trunnion_acquire::discovery::{Look, Roles};

/// Places with their answers, and what to do with [`lines_to_paste`], which follow.
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
    if looks.iter().any(|look| look.found.is_some()) {
        text +=
            "\nFor the configuration (see which probe is which by moving it; fill in where there is a ?):\n";
    }
    text
}

/// The tables of what was found, as a configuration takes them: a line that is broken is another.
pub fn lines_to_paste(looks: &[Look]) -> String {
    tables(looks).into_iter().flatten().map(|table| format!("\n{table}")).collect()
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

/// The same as a value.
pub fn value(looks: &[Look]) -> DevicesFound {
    let place = |(look, config): (&Look, Option<String>)| DevicePlace {
        address: look.place.address.clone(),
        device: look.place.device.clone(),
        about: look.place.about.clone(),
        driver: look.found.as_ref().map(|(driver, _)| (*driver).into()),
        identity: look.found.as_ref().map(|(_, found)| found.identity.clone()),
        config,
        trouble: look.trouble.clone(),
        asked: look.asked.iter().map(|&question| question.into()).collect(),
    };
    let places = looks.iter().zip(tables(looks)).map(place).collect();
    DevicesFound { format: DevicesFormat::V1, places }
}

/// The lines to paste of each place.
fn tables(looks: &[Look]) -> Vec<Option<String>> {
    let mut roles = Roles::default();
    looks.iter().map(|look| look.found.as_ref().map(|(driver, found)| roles.table(driver, found))).collect()
}
