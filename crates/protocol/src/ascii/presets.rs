//! The kinds of indicators known by name: one file each, one line in [`PRESETS`].

mod heidenhain_nd28x;
mod magnescale_lt30;
mod magnescale_mg80;
mod mahr_c1202;
mod mitutoyo_id_h;
mod mitutoyo_usb;
mod sylvac;
mod tesa;

use super::preset::Preset;

/// Every kind known, in the order of the names.
pub static PRESETS: &[&Preset] = &[
    &heidenhain_nd28x::PRESET,
    &magnescale_lt30::PRESET,
    &magnescale_mg80::PRESET,
    &mahr_c1202::PRESET,
    &mitutoyo_id_h::PRESET,
    &mitutoyo_usb::PRESET,
    &sylvac::PRESET,
    &tesa::PRESET,
];

impl Preset {
    /// The preset of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().copied().find(|preset| preset.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::super::decoder::{Decoder, Line, Measured, Unit};
    use super::super::pattern::Number;
    use super::*;

    fn decode(preset: &str, bytes: &[u8]) -> Vec<Line> {
        Decoder::new(Preset::named(preset).unwrap().format()).push(bytes)
    }

    /// The value that a text such as "-5.23" says.
    fn value(text: &str, unit: Unit) -> Vec<Line> {
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len() as u32);
        let digits = text.replace('.', "").parse().unwrap();
        vec![Line::Value(Measured { number: Number { digits, decimals }, unit })]
    }

    #[test]
    fn the_registry_holds_every_preset_file_in_the_order_of_the_names() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/ascii/presets");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().replace('_', "-"))
            .collect();
        files.sort();
        let registered: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        assert_eq!(
            registered, files,
            "left: names of PRESETS in crates/protocol/src/ascii/presets.rs, in their order; right: the files of its folder"
        );
    }

    #[test]
    fn the_lines_of_the_manuals_are_read() {
        for preset in PRESETS {
            for (line, text, unit) in preset.printed {
                let lines = decode(preset.name, format!("{line}\r\n").as_bytes());
                assert_eq!(lines, value(text, *unit), "{} {line:?}", preset.name);
            }
            assert!(
                !preset.printed.is_empty() || !preset.unconfirmed.is_empty(),
                "{}: `printed` needs a line of the manual, or `unconfirmed` says that there is none",
                preset.name
            );
        }
    }

    #[test]
    fn what_a_device_says_instead_of_a_value_has_a_meaning() {
        let check = |preset: &str, line: &[u8], expected: &str| {
            let lines = decode(preset, line);
            let [Line::Error { index, .. }] = lines.as_slice() else { panic!("{preset} {lines:?}") };
            let meaning = Preset::named(preset).unwrap().errors[*index].1;
            assert!(meaning.contains(expected), "{preset} {meaning}");
        };
        check("sylvac", b"ERR3\r", "outside the measuring range");
        check("tesa", b"ERR23\r\n", "lists the number");
        check("mahr-c1202", b"1 ERR6\r", "switched off");
        check("magnescale-lt30", b"A+F2.3456\r\n", "beyond");
        check("magnescale-lt30", b"AE\r\n", "alarm");
        check("heidenhain-nd28x", b"+      0.00 ? \r\n", "fault");
    }

    #[test]
    fn parity_bits_echoes_and_units_that_are_no_length_do_not_become_values() {
        let with_parity =
            b"?\r+01.2345\r".map(|byte| if byte.count_ones() % 2 == 1 { byte | 0x80 } else { byte });
        assert_eq!(decode("sylvac", &with_parity), value("1.2345", Unit::Millimetre));
        assert_eq!(decode("mahr-c1202", b"1 +012.5 deg\r"), [Line::Unit("deg".into())]);
        assert_eq!(decode("sylvac", b"01A+0000.123\r"), [Line::Strange("01A+0000.123".into())]);
    }

    #[test]
    fn every_preset_reads_the_lines_it_writes() {
        for preset in PRESETS {
            let line = preset.line(-1.5) + "\r\n";
            let lines = Decoder::new(preset.format()).push(line.as_bytes());
            let [Line::Value(measured)] = lines.as_slice() else {
                panic!(
                    "{}: {line:?}, written by `pattern`, `width` and `decimals`, is read as {lines:?}",
                    preset.name
                )
            };
            assert_eq!((measured.number.value(), measured.unit), (-1.5, preset.unit), "{}", preset.name);
            assert!(
                !preset.source.is_empty() || !preset.unconfirmed.is_empty(),
                "{}: name the manual in `source`, or what is not known in `unconfirmed`",
                preset.name
            );
        }
    }
}
