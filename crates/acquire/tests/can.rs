//! CAN sessions against the virtual bus, and what is told where there is none.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceState, DeviceStatus, SessionEnd, parse_devices, start};
use trunnion_units::{Clock, HostTime};

/// Longest wait for anything; the build machine may be busy.
const LIMIT: Duration = Duration::from_secs(30);

struct SinceStart(Instant);

impl Clock for SinceStart {
    fn now(&self) -> HostTime {
        HostTime(self.0.elapsed().as_nanos() as i64)
    }

    fn wall_ns(&self) -> i64 {
        0
    }
}

fn run(text: &str) -> Acquisition {
    let devices = parse_devices("trunnion.toml", text).unwrap();
    start(devices, Arc::new(SinceStart(Instant::now())), CancellationToken::new(), QUEUE_LENGTH)
}

async fn state(acquisition: &Acquisition, fits: impl Fn(&DeviceStatus) -> bool) -> DeviceStatus {
    let mut state = acquisition.states[0].clone();
    let found = timeout(LIMIT, state.wait_for(fits)).await.expect("the state in time");
    found.expect("the supervisor runs").clone()
}

#[tokio::test(flavor = "multi_thread")]
async fn without_a_can_interface_the_message_says_what_to_do_and_another_attempt_follows() {
    let text = "[[device]]\nname = \"bus\"\ndriver = \"canopen-socketcan\"\ninterface = \"can77\"\n\
                nodes = [{ id = 1, role = \"probe-1\" }]\n";
    let acquisition = run(text);
    let status = state(&acquisition, |status| status.ends.iter().sum::<u64>() >= 2).await;
    match (status.state, status.last_end.clone().unwrap()) {
        // A kernel without AF_CAN.
        (DeviceState::Refused | DeviceState::Connecting, SessionEnd::Refused { address, why }) => {
            assert_eq!(address, "can77");
            assert!(why.contains("modprobe can_raw") && why.contains("canopen-slcan"), "{why}");
        }
        (DeviceState::Absent, SessionEnd::Absent(who)) => assert!(who.contains("ip -br link"), "{who}"),
        other => panic!("{other:?}"),
    }
    acquisition.stop().await;
}
