//! Tables of many recordings as one Parquet file: machine, serial number, run and its beginning in front of every row.

use crate::{Error, moment};
use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::parser::parse_message_type;
use std::path::Path;
use std::sync::Arc;
use trunnion_machine::NamePlate;

/// Columns that hold text; all others hold numbers. By name and not by what is in them, so that the tables of all runs fit together.
const TEXT: [&str; 15] = [
    "machine",
    "serial",
    "run",
    "began",
    "setup",
    "target",
    "probe",
    "quality",
    "why",
    "effect",
    "parameter",
    "unit",
    "effects",
    "verdict",
    "missing_effects",
];
/// Rows that are compressed together; what Parquet's own tools write.
const ROWS_OF_A_GROUP: usize = 1 << 20;

/// Rows of many recordings. Where one lacks a column of another, it is empty.
pub struct Rows {
    columns: Vec<Column>,
    count: usize,
}

struct Column {
    name: String,
    cells: Cells,
}

/// An empty cell is `None`, or no number.
enum Cells {
    Text(Vec<Option<ByteArray>>),
    Numbers(Vec<f64>),
}

impl Rows {
    /// No rows yet.
    ///
    /// # Errors
    /// A program that was built without Parquet.
    pub fn begin() -> Result<Self, Error> {
        Ok(Self { columns: Vec::new(), count: 0 })
    }

    /// The rows of a table that was exported from a recording.
    ///
    /// # Errors
    /// A recording whose header cannot be read.
    pub fn add(&mut self, recording: &Path, table: &str) -> Result<(), Error> {
        let header = trunnion_record::read_header(recording).map_err(Error::recording(recording))?;
        let plate = NamePlate::parse("machine.toml", &header.machine_text).unwrap_or_default();
        let run = recording.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let began = moment::minute(header.wall_start_ns).unwrap_or_default();
        let of_run = [
            ("machine", header.machine_name),
            ("serial", plate.serial.unwrap_or_default()),
            ("run", run),
            ("began", began),
        ];
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let names = reader.headers().map_err(Error::Table)?.clone();
        let in_front: Vec<usize> = of_run.iter().map(|(name, _)| self.column(name)).collect();
        let places: Vec<usize> = names.iter().map(|name| self.column(name)).collect();
        for row in reader.records() {
            let row = row.map_err(Error::Table)?;
            self.count += 1;
            let cells = places.iter().copied().zip(row.iter());
            for (place, text) in
                in_front.iter().copied().zip(of_run.iter().map(|(_, text)| text.as_str())).chain(cells)
            {
                self.columns[place].cells.push(self.count, text);
            }
        }
        self.columns.iter_mut().for_each(|column| column.cells.fill(self.count));
        Ok(())
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The file that has them.
    ///
    /// # Errors
    /// Rows that do not become a table.
    pub fn file(&self) -> Result<Vec<u8>, Error> {
        let mut file = Vec::new();
        self.write_to(&mut file).map_err(Error::Parquet)?;
        Ok(file)
    }

    fn write_to(&self, file: &mut Vec<u8>) -> Result<(), ParquetError> {
        let fields = self.columns.iter().map(|Column { name, cells }| match cells {
            Cells::Text(_) => format!("OPTIONAL BYTE_ARRAY {name} (UTF8);"),
            Cells::Numbers(_) => format!("OPTIONAL DOUBLE {name};"),
        });
        let schema = parse_message_type(&format!("message trunnion {{ {} }}", fields.collect::<String>()))?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(concat!("trunnion ", env!("CARGO_PKG_VERSION")).into())
            .build();
        let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
        for from in (0..self.count).step_by(ROWS_OF_A_GROUP) {
            let to = self.count.min(from + ROWS_OF_A_GROUP);
            let mut group = writer.next_row_group()?;
            for Column { cells, .. } in &self.columns {
                match cells {
                    Cells::Text(cells) => {
                        write_column::<_, ByteArrayType>(&mut group, cells[from..to].iter().cloned())?;
                    }
                    Cells::Numbers(cells) => {
                        let known = cells[from..to]
                            .iter()
                            .map(|number| Some(*number).filter(|number| !number.is_nan()));
                        write_column::<_, DoubleType>(&mut group, known)?;
                    }
                }
            }
            group.close()?;
        }
        writer.close().map(drop)
    }

    /// Index of the column of this name.
    fn column(&mut self, name: &str) -> usize {
        if let Some(index) = self.columns.iter().position(|column| column.name == name) {
            return index;
        }
        let is_text = TEXT.contains(&name);
        let mut cells = if is_text { Cells::Text(Vec::new()) } else { Cells::Numbers(Vec::new()) };
        cells.fill(self.count);
        self.columns.push(Column { name: name.into(), cells });
        self.columns.len() - 1
    }
}

impl Cells {
    /// The cell of row `count`; the one before it is there.
    fn push(&mut self, count: usize, text: &str) {
        self.fill(count - 1);
        match self {
            Self::Text(cells) => cells.push(Some(text).filter(|text| !text.is_empty()).map(ByteArray::from)),
            Self::Numbers(cells) => cells.push(text.parse().unwrap_or(f64::NAN)),
        }
    }

    fn fill(&mut self, count: usize) {
        match self {
            Self::Text(cells) => cells.resize(count, None),
            Self::Numbers(cells) => cells.resize(count, f64::NAN),
        }
    }
}

/// Cells of the next column of a group.
fn write_column<V, T: DataType<T = V>>(
    group: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>,
    cells: impl Iterator<Item = Option<V>>,
) -> Result<(), ParquetError> {
    let (mut values, mut known) = (Vec::new(), Vec::new());
    for cell in cells {
        known.push(i16::from(cell.is_some()));
        values.extend(cell);
    }
    let mut column = group.next_column()?.ok_or_else(|| ParquetError::General("a column too many".into()))?;
    column.typed::<T>().write_batch(&values, Some(&known), None)?;
    column.close()
}
