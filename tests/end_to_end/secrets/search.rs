//! Whether bytes hold a secret: as it is, or in any of the codings in which a program may write it.

use crate::secret_forms::forms;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader};
use std::path::{Path, PathBuf};

/// What must be nowhere: a name for messages, and what is searched for.
pub struct Secrets(Vec<(String, String)>);

impl Secrets {
    /// Of these names and values. Only letters and digits are sure to be found: every coding of text leaves them as they are, or is
    /// among the forms.
    pub fn of(secrets: &[(&str, &str)]) -> Self {
        let mut all = Vec::new();
        for (name, secret) in secrets {
            assert!(secret.len() >= 8 && secret.chars().all(|sign| sign.is_ascii_alphanumeric()), "{name}");
            all.extend(forms(secret).into_iter().map(|(form, text)| (format!("{name}, {form}"), text)));
        }
        Self(all)
    }

    /// Which secret these bytes hold, and how.
    pub fn in_bytes(&self, bytes: &[u8]) -> Option<&str> {
        // What is no UTF-8 is replaced; the forms are ASCII and stay.
        let text = String::from_utf8_lossy(bytes);
        self.0.iter().find(|(_, form)| text.contains(form.as_str())).map(|(name, _)| name.as_str())
    }

    /// The same of a file; of a recording also what is in its chunks.
    pub fn in_file(&self, path: &Path) -> Option<&str> {
        let bytes = std::fs::read(path).unwrap();
        let inside = || records(&bytes)?.iter().find_map(|record| self.in_bytes(record));
        let name = path.to_string_lossy();
        self.in_bytes(name.as_bytes()).or_else(|| self.in_bytes(&bytes)).or_else(inside)
    }
}

/// Every file below a folder.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Every record of a recording, those in chunks unpacked; `None` of another file. A journal ends anywhere.
fn records(bytes: &[u8]) -> Option<Vec<Vec<u8>>> {
    bytes.strip_prefix(b"\x89MCAP0\r\n")?;
    let (mut reader, mut rest, mut records) = (LinearReader::new(), bytes, Vec::new());
    while let Some(Ok(event)) = reader.next_event() {
        match event {
            LinearReadEvent::ReadRequest(wanted) => {
                let count = wanted.min(rest.len());
                reader.insert(count).copy_from_slice(&rest[..count]);
                reader.notify_read(count);
                rest = &rest[count..];
            }
            LinearReadEvent::Record { data, .. } => records.push(data.to_vec()),
        }
    }
    Some(records)
}

#[test]
fn a_secret_is_found_in_every_coding_and_in_the_chunks_of_a_recording() {
    use base64::Engine;
    use base64::engine::general_purpose::{STANDARD_NO_PAD, URL_SAFE_NO_PAD};
    const SECRET: &str = "mq7Rk2vXw9";
    let secrets = Secrets::of(&[("password", SECRET)]);
    assert_eq!(secrets.in_bytes(b"mq7Rk2vXw8 and nothing else"), None);
    for before in ["", "c", "ce", "cell:", "\u{f6}\u{e4}"] {
        let text = format!("{before}{SECRET}&more");
        for coded in [
            text.clone(),
            STANDARD_NO_PAD.encode(&text),
            URL_SAFE_NO_PAD.encode(&text),
            text.bytes().map(|byte| format!("%{byte:02X}")).collect(),
            format!("{:?}", text.as_bytes()),
            serde_json::to_string(&text.as_bytes()).unwrap(),
        ] {
            assert!(secrets.in_bytes(coded.as_bytes()).is_some(), "{coded}");
        }
    }

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let mut file = std::fs::File::create(&path).unwrap();
    let mut writer = mcap::Writer::new(&mut file).unwrap();
    let channel = writer.add_channel(0, "log", "json", &Default::default()).unwrap();
    let header =
        mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 0, publish_time: 0 };
    // Packed so well that nothing of it is seen from outside.
    writer.write_to_known_channel(&header, SECRET.repeat(500).as_bytes()).unwrap();
    writer.finish().unwrap();
    drop(writer);
    let found = secrets.in_file(&path);
    assert_eq!(found, Some("password, plain"));
    assert_eq!(files(folder.path()), [path]);
}
