//! ASCII commands and replies.
//!
//! A command is a name and parameters separated by blanks, ended by LF (CR LF is taken too); without parameters it
//! reads the setting. The sensor repeats the command (`ECHO ON`), answers in lines, and ends with a line end and the
//! prompt `->`. A line `Exxx text` refuses, `Wxxx text` warns. Source: manual A 3.1, A 3.3.

use thiserror::Error;

/// What the sensor can put into a block. Names as in `OUTADD_RS422` and `GETOUTINFO_RS422`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum OutputField {
    /// `DIST1`, always the first value.
    Distance,
    /// `SHUTTER`.
    Exposure,
    /// `COUNTER`.
    Counter,
    /// Low word of `TIMESTAMP`.
    TimestampLow,
    /// High word of `TIMESTAMP`.
    TimestampHigh,
    /// `INTENSITY`.
    Intensity,
    /// `STATE`.
    State,
    /// `DIST_RAW`.
    RawDistance,
    /// A name this program does not know; it keeps its place in the block.
    Unknown,
}

impl OutputField {
    pub(super) fn from_name(name: &str) -> Self {
        match name {
            "DIST" | "DIST1" | "DISTANCE" => Self::Distance,
            "SHUTTER" => Self::Exposure,
            "COUNTER" => Self::Counter,
            "TIMESTAMP_LO" | "TIMESTAMP_LOW" => Self::TimestampLow,
            "TIMESTAMP_HI" | "TIMESTAMP_HIGH" => Self::TimestampHigh,
            "INTENSITY" => Self::Intensity,
            "STATE" => Self::State,
            "DIST_RAW" => Self::RawDistance,
            _ => Self::Unknown,
        }
    }
}

/// One command line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command {
    /// Name, upper case.
    pub name: String,
    /// Parameters as written.
    pub parameters: Vec<String>,
}

impl Command {
    /// A command with parameters; none reads the setting.
    pub fn new(name: &str, parameters: &[&str]) -> Self {
        Self {
            name: name.to_ascii_uppercase(),
            parameters: parameters.iter().map(|parameter| (*parameter).to_owned()).collect(),
        }
    }

    /// `GETINFO`: model, serial number, measuring range; see [`SensorInfo`].
    pub fn get_info() -> Self {
        Self::new("GETINFO", &[])
    }

    /// `OUTPUT NONE`: stop streaming.
    pub fn output_none() -> Self {
        Self::new("OUTPUT", &["NONE"])
    }

    /// `OUTPUT RS422`: stream.
    pub fn output_rs422() -> Self {
        Self::new("OUTPUT", &["RS422"])
    }

    /// `OUTADD_RS422 COUNTER TIMESTAMP`: send the device clock with every distance.
    pub fn add_counter_and_timestamp() -> Self {
        Self::new("OUTADD_RS422", &["COUNTER", "TIMESTAMP"])
    }

    /// `GETOUTINFO_RS422`: the values of a block in their order; see [`super::Layout::from_names`].
    pub fn get_output_info() -> Self {
        Self::new("GETOUTINFO_RS422", &[])
    }

    /// `MEASRATE n`: measuring rate in kHz (0.25, 0.5, 1, 2, 4).
    pub fn measuring_rate_khz(rate_khz: f64) -> Self {
        Self::new("MEASRATE", &[&rate_khz.to_string()])
    }

    /// The command on one line, without line end.
    pub fn text(&self) -> String {
        let mut text = self.name.clone();
        for parameter in &self.parameters {
            let quote = if parameter.contains(' ') { "\"" } else { "" };
            text += &format!(" {quote}{parameter}{quote}");
        }
        text
    }

    /// The bytes on the wire, ended by LF.
    pub fn encode(&self) -> Vec<u8> {
        (self.text() + "\n").into_bytes()
    }

    /// Reads a command line (sensor side); `None` when it is empty.
    pub fn parse(line: &str) -> Option<Self> {
        let mut words = Vec::new();
        for (position, piece) in line.trim().split('"').enumerate() {
            if position % 2 == 1 {
                words.push(piece.to_owned()); // between quotation marks
            } else {
                words.extend(piece.split_ascii_whitespace().map(str::to_owned));
            }
        }
        let mut words = words.into_iter();
        Some(Self { name: words.next()?.to_ascii_uppercase(), parameters: words.collect() })
    }
}

/// Splits the sensor's end of the line into commands.
#[derive(Debug, Clone, Default)]
pub struct CommandDecoder {
    line: Vec<u8>,
    overlong_lines: u64,
}

/// Longer than any command of the manual.
const MAX_COMMAND: usize = 256;

impl CommandDecoder {
    /// Takes bytes as read and returns the commands they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Command> {
        let mut commands = Vec::new();
        for &byte in bytes {
            if byte != b'\n' {
                if self.line.len() <= MAX_COMMAND {
                    self.line.push(byte);
                }
                continue;
            }
            let line = std::mem::take(&mut self.line);
            if line.len() > MAX_COMMAND {
                self.overlong_lines += 1;
            } else {
                commands.extend(Command::parse(&String::from_utf8_lossy(&line)));
            }
        }
        commands
    }

    /// Lines thrown away because they were too long.
    pub fn overlong_lines(&self) -> u64 {
        self.overlong_lines
    }
}

/// A refusal (`Exxx`) or warning (`Wxxx`).
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{number:03} {text}")]
pub struct Notice {
    /// The number in the manual's list.
    pub number: u16,
    /// The sensor's words.
    pub text: String,
}

/// A reply without echo and prompt.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Reply {
    /// Lines that are neither echo nor notice, in order, trimmed, none empty.
    pub lines: Vec<String>,
    /// The command was refused.
    pub error: Option<Notice>,
    /// The command was done, but.
    pub warning: Option<Notice>,
}

impl Reply {
    /// Reads the text up to the prompt. Words in front of the echo (a value cut in half when output stopped can
    /// leave some) are dropped with it.
    pub fn parse(text: &str, command: &Command) -> Self {
        let mut reply = Reply::default();
        let echo = command.text();
        let mut lines: Vec<&str> =
            text.split(['\r', '\n']).map(|line| line.trim().trim_start_matches("->").trim()).collect();
        // A read command answers with its own name first, so only a line equal to the whole command is the echo.
        if let Some(position) = lines.iter().position(|line| line.ends_with(&echo)) {
            lines.drain(..=position);
        }
        for line in lines.into_iter().filter(|line| !line.is_empty()) {
            match (notice(line, 'E'), notice(line, 'W')) {
                (Some(error), _) => reply.error = Some(error),
                (None, Some(warning)) => reply.warning = Some(warning),
                (None, None) => reply.lines.push(line.to_owned()),
            }
        }
        reply
    }

    /// True when a reply text repeats one of the commands sent before and not this one: it is late.
    pub fn is_of_another(text: &str, command: &Command, sent: &[Command]) -> bool {
        let lines: Vec<&str> = text.split(['\r', '\n']).map(str::trim).collect();
        let repeats = |command: &Command| {
            let echo = command.text();
            lines.iter().any(|line| line.ends_with(&echo))
        };
        !repeats(command) && sent.iter().any(repeats)
    }

    /// The parameters of a line `<command> <parameter>…`, as a read command answers.
    pub fn parameters(&self, command: &Command) -> Option<Vec<&str>> {
        self.lines.iter().find_map(|line| {
            let mut words = line.split_ascii_whitespace();
            (words.next()? == command.name).then(|| words.collect())
        })
    }

    /// The bytes a sensor sends for this reply, echo and prompt included.
    pub fn encode(&self, command: &Command) -> Vec<u8> {
        let mut text = command.text() + "\r\n";
        for (letter, notice) in [('E', &self.error), ('W', &self.warning)] {
            if let Some(notice) = notice {
                text += &format!("{letter}{notice}\r\n");
            }
        }
        for line in &self.lines {
            text += line;
            text += "\r\n";
        }
        (text + "->").into_bytes()
    }
}

fn notice(line: &str, letter: char) -> Option<Notice> {
    let rest = line.strip_prefix(letter)?;
    let (number, text) = rest.split_at_checked(3)?;
    let ends = text.is_empty() || !text.starts_with(|c: char| c.is_ascii_alphanumeric());
    let digits = number.bytes().all(|byte| byte.is_ascii_digit());
    (ends && digits).then(|| Notice {
        number: number.parse().unwrap_or(0),
        text: text.trim_start_matches([':', ' ']).to_owned(),
    })
}

/// What `GETINFO` says about the sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorInfo {
    /// Model, `ILD1420-10` for example.
    pub name: String,
    /// Serial number.
    pub serial: String,
    /// Measuring range, mm.
    pub range_mm: f64,
    /// Software version.
    pub version: String,
}

/// Why a reply to `GETINFO` does not describe a sensor.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum InfoError {
    /// A line is missing.
    #[error("GETINFO did not report \"{0}\": is this an optoNCDT 1320 or 1420?")]
    Missing(&'static str),
    /// The measuring range is no length in mm.
    #[error("GETINFO gave the measuring range as \"{0}\"; expected a length in mm such as 10.00mm")]
    Range(String),
}

impl SensorInfo {
    /// Reads the reply to `GETINFO`, lines `Name: value`; a comment `//…` behind a value is dropped.
    pub fn parse(reply: &Reply) -> Result<Self, InfoError> {
        let find = |name: &'static str| {
            let mut values = reply.lines.iter().filter_map(|line| line.split_once(':'));
            let value = values.find(|(key, _)| key.trim().eq_ignore_ascii_case(name)).map(|(_, value)| value);
            let value = value.ok_or(InfoError::Missing(name))?;
            Ok(value.split("//").next().unwrap_or(value).trim().to_owned())
        };
        let range = find("Measuring range")?;
        let range_mm = range.strip_suffix("mm").and_then(|number| number.trim().parse::<f64>().ok());
        let range_mm = range_mm.filter(|mm| mm.is_finite() && *mm > 0.0).ok_or(InfoError::Range(range))?;
        Ok(Self { name: find("Name")?, serial: find("Serial")?, range_mm, version: find("Version")? })
    }

    /// The reply a sensor gives to `GETINFO`.
    pub fn reply(&self) -> Reply {
        let Self { name, serial, range_mm, version } = self;
        let lines = vec![
            format!("Name: {name}"),
            format!("Serial: {serial}"),
            "Option: 000".into(),
            format!("Measuring range: {range_mm:.2}mm"),
            format!("Version: {version}"),
        ];
        Reply { lines, ..Reply::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the optoNCDT 1420 manual, A 3.3.2, comments included.
    const GETINFO: &str = "GETINFO\r\nName: ILD1420-10 //Model name sensor, sensor series\r\nSerial: 15030002\r\n\
        Option: 000\r\nArticle: 4120212\r\nCable head: Wire\r\nMeasuring range: 10.00mm //Measuring range of sensor\r\n\
        Version: 001.010\r\nHardware-rev: 00\r\nBoot-version: 001.000\r\n";

    #[test]
    fn the_manuals_getinfo_is_read() {
        let reply = Reply::parse(GETINFO, &Command::get_info());
        let info = SensorInfo::parse(&reply).unwrap();
        assert_eq!(
            info,
            SensorInfo {
                name: "ILD1420-10".into(),
                serial: "15030002".into(),
                range_mm: 10.0,
                version: "001.010".into()
            }
        );
        assert_eq!(SensorInfo::parse(&info.reply()), Ok(info));
    }

    #[test]
    fn refusals_warnings_and_echo_are_distinguished() {
        let command = Command::output_rs422();
        let check = |text: &str, expected: Reply| assert_eq!(Reply::parse(text, &command), expected);
        check("OUTPUT RS422\r\n", Reply::default());
        let error = Some(Notice { number: 210, text: "Unknown command".into() });
        check("x7OUTPUT RS422\r\nE210 Unknown command\r\n", Reply { error, ..Reply::default() });
        let warning = Some(Notice { number: 320, text: "reduced".into() });
        check("W320: reduced\r\n", Reply { warning, ..Reply::default() });
        check("OUTPUT NONE\r\n", Reply { lines: vec!["OUTPUT NONE".into()], ..Reply::default() });
    }

    #[test]
    fn a_reply_that_repeats_another_command_is_late() {
        let (stop, info) = (Command::output_none(), Command::get_info());
        let late = |text: &str| Reply::is_of_another(text, &info, &[stop.clone(), info.clone()]);
        assert!(late("OUTPUT NONE\r\n"));
        assert!(late("x7OUTPUT NONE\r\n"));
        assert!(!late(GETINFO));
        // A sensor without echo is believed.
        assert!(!late("Name: ILD1420-10\r\n"));
    }

    #[test]
    fn the_output_order_is_read_from_the_sensor() {
        use OutputField::{Counter, Distance, TimestampHigh, TimestampLow};
        let command = Command::get_output_info();
        let check = |line: &str| {
            let reply = Reply { lines: vec![line.to_owned()], ..Reply::default() };
            let text = String::from_utf8(reply.encode(&command)).unwrap();
            let reply = Reply::parse(text.strip_suffix("->").unwrap(), &command);
            let layout = crate::optoncdt::Layout::from_reply(&reply).unwrap();
            assert_eq!(layout.fields(), [Distance, Counter, TimestampLow, TimestampHigh]);
        };
        check("GETOUTINFO_RS422 DIST1 COUNTER TIMESTAMP");
        check("DIST1 COUNTER TIMESTAMP_LO TIMESTAMP_HI");
    }

    #[test]
    fn a_sensor_reads_the_commands_of_a_host() {
        let mut decoder = CommandDecoder::default();
        assert_eq!(decoder.push(b"OUTADD_RS422 COUNTER TIME"), []);
        assert_eq!(
            decoder.push(b"STAMP\nmeasrate 4\r\n\nPASSWD \"a b\" c\n"),
            [
                Command::add_counter_and_timestamp(),
                Command::measuring_rate_khz(4.0),
                Command::new("PASSWD", &["a b", "c"]),
            ]
        );
        assert_eq!(Command::new("PASSWD", &["a b", "c"]).encode(), b"PASSWD \"a b\" c\n");
    }
}
