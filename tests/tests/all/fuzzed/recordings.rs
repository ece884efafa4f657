//! Small recordings to change: every byte of them is read.

use trunnion_core::{HostTime, ProbeSample};
use trunnion_cycles::Run;
use trunnion_record::{Item, Recorder, RunHeader};

/// Opcodes [MCAP specification, Records].
const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHUNK: u8 = 0x06;
const DATA_END: u8 = 0x0F;
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// A run with some samples, finished or as a kill leaves it; without the texts of its schemas, which nothing reads.
pub fn small(is_finished: bool, run: &Run) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let header = RunHeader { probes: vec!["px".into()], ..RunHeader::of_run(run, "", "0.1.0", 0) };
    let mut recorder = Recorder::create(folder.path(), "run", &header).expect("a recorder");
    for point in run.points.iter().cloned() {
        recorder.append(Item::Point(point), HostTime(0));
    }
    for raw in 0..20 {
        let time_s = raw as f64 * 1e-3;
        let sample = ProbeSample { time_s, raw, value_mm: raw as f64 * 1e-3, ..ProbeSample::default() };
        recorder.append(Item::Probe(sample), HostTime(raw * 1_000_000));
    }
    recorder.flush_aged(HostTime(i64::MAX));
    let name = if is_finished { "run.mcap" } else { "run.mcap.active" };
    if is_finished {
        recorder.finish(HostTime(0)).expect("a finished recording");
    }
    let bytes = std::fs::read(folder.path().join(name)).expect("a recording");
    if is_finished {
        return bytes;
    }
    let whole = records(&bytes).into_iter().map(|(opcode, body)| match opcode {
        SCHEMA => (opcode, without_data(body)),
        _ => (opcode, body.to_vec()),
    });
    let short: Vec<(u8, Vec<u8>)> = whole.collect();
    [MAGIC, &written(short.iter().map(|(opcode, body)| (*opcode, &body[..])))].concat()
}

/// The records of a journal in one chunk, unpacked and without a checksum: a changed byte is not refused before it is read.
pub fn as_chunk(journal: &[u8]) -> Vec<u8> {
    let all = records(journal);
    let inner = written(all.iter().copied().filter(|(opcode, _)| *opcode != HEADER));
    let length = (inner.len() as u64).to_le_bytes();
    let times = [0; 16];
    let no_checksum = [0; 4];
    let no_compression = [0; 4];
    let chunk = [&times[..], &length, &no_checksum, &no_compression, &length, &inner].concat();
    let header = all.iter().find(|(opcode, _)| *opcode == HEADER).expect("it begins with one").1;
    let parts = [(HEADER, header), (CHUNK, &chunk[..]), (DATA_END, &[0; 4][..]), (FOOTER, &[0; 20][..])];
    [MAGIC, &written(parts.into_iter()), MAGIC].concat()
}

/// Opcode and body of each record.
fn records(mut file: &[u8]) -> Vec<(u8, &[u8])> {
    file = file.strip_prefix(MAGIC).expect("a recording");
    let mut found = Vec::new();
    while let Some((head, rest)) = file.split_first_chunk::<9>() {
        let bytes = u64::from_le_bytes(head[1..].try_into().expect("eight bytes")) as usize;
        found.push((head[0], &rest[..bytes]));
        file = &rest[bytes..];
    }
    found
}

fn written<'a>(records: impl Iterator<Item = (u8, &'a [u8])>) -> Vec<u8> {
    records
        .flat_map(|(opcode, body)| [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat())
        .collect()
}

/// Id, name and encoding of a schema, and no data.
fn without_data(body: &[u8]) -> Vec<u8> {
    let length = |at: usize| u32::from_le_bytes(body[at..at + 4].try_into().expect("four bytes")) as usize;
    let encoding = 2 + 4 + length(2);
    let data = encoding + 4 + length(encoding);
    [&body[..data], &[0; 4]].concat()
}
