//! Where the OPC UA server may listen. What it serves is read by asyncua (tests/peers/opcua_client.py).

use std::path::Path;
use trunnion_service::config::Config;

#[test]
fn it_is_for_this_computer_alone_and_a_build_without_it_says_so() {
    let read = |table: &str| {
        let text = include_str!("../../../../config/trunnion.toml");
        let parsed =
            Config::parse(Path::new("../../config/trunnion.toml"), &format!("{text}\n[opcua]\n{table}\n"));
        parsed.map(|config| config.opcua).map_err(|problems| problems.to_string())
    };
    if !cfg!(feature = "opcua") {
        assert!(read("").unwrap_err().contains("built without OPC UA"));
        return;
    }
    assert!(read("").unwrap().unwrap().listen.ip().is_loopback());
    assert!(read("listen = \"192.168.1.5:4841\"").unwrap_err().contains("other computers"));
    assert!(read("listen = \"here\"").unwrap_err().contains("no address"));
}
