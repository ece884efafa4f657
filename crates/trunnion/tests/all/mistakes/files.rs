//! Mistakes and habits of table files: encodings, separators, units, names.

use super::Files;

/// A mistake of a file: bytes of the points, and the setup.
pub type FileMistake = (&'static str, fn(&mut Files) -> Vec<u8>, Becomes);

/// What becomes of a file.
pub enum Becomes {
    /// The points are those of the good file.
    Read,
    /// The reason holds these words.
    Refused(&'static [&'static str]),
}

pub const FILES: [FileMistake; 24] = [
    (
        "semicolons, decimal commas, CRLF",
        |f| f.text().replace(',', ";").replace('.', ",").replace('\n', "\r\n").into(),
        Becomes::Read,
    ),
    ("tabs", |f| f.text().replace(',', "\t").into(), Becomes::Read),
    (
        "UTF-16 with its mark",
        |f| format!("\u{feff}{}", f.text()).encode_utf16().flat_map(u16::to_le_bytes).collect(),
        Becomes::Read,
    ),
    ("byte-order mark of UTF-8", |f| format!("\u{feff}{}", f.text()).into(), Becomes::Read),
    ("a remark in front", |f| format!("# second shift\n{}", f.text()).into(), Becomes::Read),
    (
        "capitals and blanks in the header",
        |f| {
            f.header.iter_mut().for_each(|name| *name = format!(" {} ", name.to_uppercase()));
            f.text().into()
        },
        Becomes::Read,
    ),
    (
        "µ in the header, in Windows-1252",
        |f| {
            let text = f.text().replace("_um", "_µm");
            text.chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect()
        },
        Becomes::Read,
    ),
    (
        "sep=; in front, and a row of separators at the end",
        |f| format!("sep=;\r\n{};;;;;;;;;;;;\n", f.text().replace(',', ";")).into(),
        Becomes::Read,
    ),
    (
        "a row of units under the header",
        |f| f.text().replacen('\n', "\n,[s],[mm],mm,mm,°,deg,,,µm,um,um,°C\n", 1).into(),
        Becomes::Read,
    ),
    (
        "a comma at the end of every row",
        |f| {
            f.rows.iter_mut().for_each(|row| row.push(String::new()));
            f.text().into()
        },
        Becomes::Read,
    ),
    (
        "a row of other units under the header",
        |f| f.text().replacen('\n', "\n,s,m,m,m,deg,deg,,,um,um,um,°C\n", 1).into(),
        Becomes::Refused(&["points.csv:2:4: the unit \"m\" under x_mm", "unit of the name"]),
    ),
    (
        "a point of thousands between decimal commas",
        |f| {
            f.rows[4][9] = "1.021".into();
            let rows = f.rows.iter().enumerate().map(|(k, row)| {
                let row = row.join(";");
                if k == 4 { row } else { row.replace('.', ",") }
            });
            format!("{}\n{}\n", f.header.join(";"), rows.collect::<Vec<_>>().join("\n")).into()
        },
        Becomes::Refused(&["points.csv:6", "in a table with decimal commas", "may mark thousands"]),
    ),
    (
        "another program's header",
        |f| format!("Aufspannung;Zeit\n{}", f.text()).into(),
        Becomes::Refused(&["points.csv:1:1: this row is not the header", "[columns]"]),
    ),
    (
        "a workbook under the name of a table",
        |_| b"PK\x03\x04\x14\x00".to_vec(),
        Becomes::Refused(&["a workbook (.xlsx", "save its sheet as CSV"]),
    ),
    (
        "a packed table",
        |_| b"\x1f\x8b\x08\x00".to_vec(),
        Becomes::Refused(&["packed with gzip", "unpack it first"]),
    ),
    (
        "decimal commas between commas",
        |f| {
            let (header, rows) =
                (f.header.join(","), f.rows.iter().map(|row| row.join(",").replace('.', ",")));
            format!("{header}\n{}\n", rows.collect::<Vec<_>>().join("\n")).into()
        },
        Becomes::Refused(&["points.csv:2"]),
    ),
    ("an empty file", |_| Vec::new(), Becomes::Refused(&["points.csv"])),
    (
        "a header alone",
        |f| {
            f.rows.clear();
            f.text().into()
        },
        Becomes::Refused(&["points.csv"]),
    ),
    (
        "a column of readings missing",
        |f| {
            let column = f.column("dz_um");
            f.header.remove(column);
            f.rows.iter_mut().for_each(|row| drop(row.remove(column)));
            f.text().into()
        },
        Becomes::Refused(&["dz_um"]),
    ),
    ("no number in a cell", |f| f.text().replacen("-21.40", "NaN", 1).into(), Becomes::Refused(&["NaN"])),
    (
        "a setup that the setup file lacks",
        |f| f.text().replacen("\nlow,", "\nlov,", 1).into(),
        Becomes::Refused(&["lov", "low"]),
    ),
    (
        "a machine that does not exist",
        |f| {
            f.replace("\"table-bc\"", "\"table-cb\"");
            f.text().into()
        },
        Becomes::Refused(&["setup.toml:2", "table-cb"]),
    ),
    (
        "another machine, which lacks an axis",
        |f| {
            f.replace("\"table-bc\"", "\"table-ac\"");
            f.text().into()
        },
        Becomes::Refused(&["b_deg", "table-ac has no axis B", "another machine"]),
    ),
    (
        "an instrument that does not exist",
        |f| {
            f.replace("\"r-test\"", "\"rtest\"");
            f.text().into()
        },
        Becomes::Refused(&["rtest", "r-test"]),
    ),
];
