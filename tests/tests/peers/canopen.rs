//! Our CANopen driver reads python `canopen` nodes behind python-can's slcan, through a pseudo-terminal.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{parse_devices, start};
use trunnion_core::reading::Reading;
use trunnion_service::clock::SystemClock;
use trunnion_tests::peer::PythonPeer;

#[tokio::test]
#[ignore = "a peer test: tests/peers/run"]
async fn our_driver_reads_three_probes_and_an_encoder_of_python_canopen() {
    let peer = PythonPeer::start("canopen_peer.py", &[]);
    let port = peer.port();
    let config = format!(
        "[[device]]\nname = \"can\"\ndriver = \"canopen-slcan\"\nport = \"{port}\"\nsync_ms = 10\nsilence_ms = 5000\n\
         nodes = [{{ id = 1, role = \"probe-1\" }}, {{ id = 2, role = \"probe-2\" }}, {{ id = 3, role = \"probe-3\" }}, \
         {{ id = 4, role = \"bar\" }}]\n"
    );
    let devices = parse_devices("peer.toml", &config).expect("the configuration is good");
    let cancel = CancellationToken::new();
    let mut acquisition = start(devices, Arc::new(SystemClock::start()), cancel.clone(), QUEUE_LENGTH);

    let mut readings: BTreeMap<u16, Vec<f64>> = BTreeMap::new();
    let enough =
        |readings: &BTreeMap<u16, Vec<f64>>| readings.len() == 4 && readings.values().all(|v| v.len() >= 300);
    let all_read = async {
        while !enough(&readings) {
            let message = acquisition.messages.recv().await.expect("the acquisition runs");
            if let Reading::Probe(reading) = message.reading {
                readings.entry(reading.channel).or_default().push(reading.value_mm);
            }
        }
    };
    // Also where the peer has died: the driver goes on to say so, and would be listened to for ever.
    let in_time = tokio::time::timeout(Duration::from_secs(120), all_read).await.is_ok();
    let counts: Vec<(u16, usize)> =
        readings.iter().map(|(channel, values)| (*channel, values.len())).collect();
    assert!(in_time, "300 readings of each of four channels within two minutes, not {counts:?}");
    acquisition.stop().await;
    drop(peer);
    // canopen_peer.py: amplitudes 0.05, 0.04, 0.03 mm around 0 and 0.02 mm around 100 mm, 0.2 Hz.
    for (channel, centre, amplitude) in [(0, 0.0, 0.05), (1, 0.0, 0.04), (2, 0.0, 0.03), (3, 100.0, 0.02)] {
        let values = &readings[&channel];
        let farthest = values.iter().map(|v| (v - centre).abs()).fold(0.0, f64::max);
        assert!(farthest <= amplitude + 1e-9 && farthest > 0.5 * amplitude, "channel {channel}: {farthest}");
    }
}
