//! What a URL asks of the agent.

use std::time::Duration;

/// A request the agent understands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Request {
    Probe,
    Current,
    Sample(Sample),
}

/// `/sample`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sample {
    /// First sequence number; from the beginning of the buffer when not given.
    pub from: Option<u64>,
    /// Most observations in a document.
    pub count: usize,
    /// Stream with this pause between documents; one document when not given.
    pub interval: Option<Duration>,
    /// Longest pause before an empty document shows that the agent lives.
    pub heartbeat: Duration,
}

/// Error code and text of the agent.
pub(super) type Refusal = (&'static str, String);

impl Request {
    /// Reads `[/device]/probe`, `[/device]/current`, `[/device]/sample?…`.
    pub fn parse(path: &str, query: &str, device: &str) -> Result<Self, Refusal> {
        let mut words: Vec<&str> = path.split('/').filter(|word| !word.is_empty()).collect();
        if let [first, ..] = words[..]
            && first == device
        {
            words.remove(0);
        } else if words.len() > 1 {
            return Err(("NO_DEVICE", format!("Could not find the device '{}'", words[0])));
        }
        match words[..] {
            [] | ["probe"] => Ok(Self::Probe),
            ["current"] => no_parameters(query).map(|()| Self::Current),
            ["sample"] => Sample::parse(query).map(Self::Sample),
            _ => Err(("INVALID_URI", format!("'{path}' is none of /probe, /current, /sample"))),
        }
    }
}

impl Sample {
    fn parse(query: &str) -> Result<Self, Refusal> {
        let mut sample = Self { from: None, count: 100, interval: None, heartbeat: Duration::from_secs(10) };
        for (name, value) in parameters(query) {
            let refused =
                || ("INVALID_REQUEST", format!("{name} = '{value}' is no whole number in its range"));
            let number = value.parse::<u64>().map_err(|_| refused());
            match name {
                "from" => sample.from = Some(number?),
                "count" => {
                    let count = usize::try_from(number?).map_err(|_| refused())?;
                    sample.count = if count == 0 { return Err(refused()) } else { count };
                }
                "interval" => sample.interval = Some(Duration::from_millis(number?)),
                "heartbeat" => sample.heartbeat = Duration::from_millis(number?.max(1)),
                _ => return Err(unsupported(name)),
            }
        }
        Ok(sample)
    }
}

fn no_parameters(query: &str) -> Result<(), Refusal> {
    parameters(query).next().map_or(Ok(()), |(name, _)| Err(unsupported(name)))
}

fn unsupported(name: &str) -> Refusal {
    ("UNSUPPORTED", format!("the parameter '{name}' is not supported"))
}

fn parameters(query: &str) -> impl Iterator<Item = (&str, &str)> {
    query.split('&').filter(|part| !part.is_empty()).map(|part| part.split_once('=').unwrap_or((part, "")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_with_and_without_a_device() {
        let sample = Request::parse("/VMC/sample", "from=5&interval=100&count=1000", "VMC").unwrap();
        let expected = Sample {
            from: Some(5),
            count: 1000,
            interval: Some(Duration::from_millis(100)),
            heartbeat: Duration::from_secs(10),
        };
        assert_eq!(sample, Request::Sample(expected));
        assert_eq!(Request::parse("/", "", "VMC"), Ok(Request::Probe));
        assert_eq!(Request::parse("/current", "", "VMC"), Ok(Request::Current));
        let code = |path, query| Request::parse(path, query, "VMC").unwrap_err().0;
        assert_eq!(code("/other/probe", ""), "NO_DEVICE");
        assert_eq!(code("/asset", ""), "INVALID_URI");
        assert_eq!(code("/sample", "count=0"), "INVALID_REQUEST");
        assert_eq!(code("/sample", "from=-1"), "INVALID_REQUEST");
        assert_eq!(code("/sample", "path=//Axes"), "UNSUPPORTED");
    }
}
