//! A build without the feature `opcua` says how to get one with it.

use crate::probe::{Answer, Probing};
use crate::session_end::SessionEnd;

/// How to get the driver.
pub(super) const REMEDY: &str =
    "Build with `cargo build --release --features full`; the shipped binary has it.";

/// Asks nothing.
pub(super) fn run(url: &str) -> Probing<'_> {
    let why = format!("the driver `opcua` is not part of this build. {REMEDY}");
    let end = SessionEnd::Refused { address: url.into(), why };
    Box::pin(std::future::ready(Answer::Trouble(end)))
}

#[cfg(test)]
mod tests {
    use crate::discovery::{look, servers};
    use crate::parse_devices;

    #[tokio::test]
    async fn without_the_driver_its_configuration_and_its_address_say_how_to_get_it() {
        let table = "[[device]]\nname = \"cnc\"\ndriver = \"opcua\"\nurl = \"opc.tcp://cnc\"\n\
                     layout = \"sinumerik\"\naxes = \"XYZBC\"\n";
        let refused = parse_devices("trunnion.toml", table).unwrap_err().to_string();
        let place = servers("opc.tcp://cnc", None).unwrap().remove(0);
        let trouble = look(place, None).await.trouble.unwrap();
        for reported in [refused, trouble] {
            assert!(
                reported.contains("not part of this build") && reported.contains("--features full"),
                "{reported}"
            );
        }
    }
}
