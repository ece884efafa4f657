//! Our OPC UA driver reads asyncua servers: SINUMERIK's node ids without encryption, OPC 40502 by browsing with
//! Basic256Sha256 and a user; and says what to do when a server is wrong, silent, or gone.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::discovery::{look, servers};
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceState, DeviceStatus, parse_devices, start};
use trunnion_core::Joint;
use trunnion_core::axis::iso::{B, C, X, Y, Z};
use trunnion_core::reading::{AxisReading, ControllerReading, Execution, Reading, SourceGap};
use trunnion_service::clock::SystemClock;
use trunnion_tests::page_status::free_port;
use trunnion_tests::peer::PythonPeer;

/// Longest wait for anything; the build machine may be busy.
const LIMIT: Duration = Duration::from_secs(60);
const AXES: [Joint; 5] = [X, Y, Z, B, C];

/// An asyncua server in a process of its own.
fn asyncua(port: u16, layout: &str, security: &str, folder: &Path) -> PythonPeer {
    let port = port.to_string();
    let peer = PythonPeer::start(
        "opcua_server.py",
        &[port.as_ref(), layout.as_ref(), security.as_ref(), folder.as_ref()],
    );
    assert_eq!(peer.reported, "ready");
    peer
}

/// As in opcua_server.py; mm and rad.
fn position(axis: usize, t_s: f64) -> f64 {
    let swing = (0.5 * t_s + axis as f64).sin();
    if axis >= 3 { (10.0 * swing).to_radians() } else { 100.0 + 20.0 * axis as f64 + 5.0 * swing }
}

struct Reader(Acquisition);

impl Reader {
    fn start(port: u16, keys: &str) -> Self {
        let text = format!(
            "[[device]]\nname = \"cnc\"\ndriver = \"opcua\"\nurl = \"opc.tcp://127.0.0.1:{port}/trunnion/\"\n{keys}"
        );
        let devices = parse_devices("peer.toml", &text).expect("the configuration is good");
        let clock = Arc::new(SystemClock::start());
        Self(start(devices, clock, CancellationToken::new(), QUEUE_LENGTH))
    }

    async fn find<T>(&mut self, pick: impl Fn(&Reading) -> Option<T>) -> T {
        let search = async {
            loop {
                let message = self.0.messages.recv().await.expect("the acquisition runs");
                if let Some(found) = pick(&message.reading) {
                    return found;
                }
            }
        };
        match tokio::time::timeout(LIMIT, search).await {
            Ok(found) => found,
            Err(_) => panic!("it does not come; {:?}", self.0.states[0].borrow()),
        }
    }

    async fn axes(&mut self) -> AxisReading {
        self.find(|reading| if let Reading::Axes(axes) = reading { Some(*axes) } else { None }).await
    }

    async fn gap(&mut self) -> SourceGap {
        self.find(|reading| if let Reading::Gap(gap) = reading { Some(gap.clone()) } else { None }).await
    }

    async fn status(&mut self, fits: impl Fn(&DeviceStatus) -> bool) -> DeviceStatus {
        let mut state = self.0.states[0].clone();
        let found = tokio::time::timeout(LIMIT, state.wait_for(|status| fits(status))).await;
        match found {
            Ok(status) => status.expect("the device is looked after").clone(),
            Err(_) => panic!("it does not come; {:?}", self.0.states[0].borrow()),
        }
    }

    /// Positions at their stamps against what the server computed, mm and mrad: farthest; and the largest skew, ms.
    async fn compare(&mut self, count: usize) -> (f64, f64) {
        let (mut farthest, mut skew_ms) = (0.0_f64, 0.0_f64);
        for _ in 0..count {
            let axes = self.axes().await;
            for (k, letter) in AXES.into_iter().enumerate() {
                let off = axes.position[letter] - position(k, axes.stamp_ns as f64 / 1e9);
                farthest = farthest.max(off.abs() * if letter.is_rotary() { 1e3 } else { 1.0 });
            }
            skew_ms = skew_ms.max(axes.skew_ns as f64 / 1e6);
        }
        (farthest, skew_ms)
    }

    async fn program_runs(&mut self) -> ControllerReading {
        let running = |reading: &Reading| match reading {
            Reading::Controller(now) if now.execution == Execution::Active => Some(now.clone()),
            _ => None,
        };
        self.find(running).await
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn sinumerik_nodes_are_read_with_their_own_stamps_and_a_lost_server_is_a_gap() {
    let (port, folder) = (free_port(), tempfile::tempdir().expect("a folder"));
    let mut peer = asyncua(port, "sinumerik", "none", folder.path());
    let mut reader = Reader::start(port, "layout = \"sinumerik\"\naxes = \"XYZBC\"\nsilence_ms = 1500\n");
    let identity = reader.status(|status| !status.identity.is_empty()).await.identity;
    assert_eq!(identity, "OPC UA server asyncua sinumerik, no encryption, axes X Y Z B C");
    let controller = reader.program_runs().await;
    assert_eq!(controller.program, "TRUNNION_1");

    let (farthest, skew_ms) = reader.compare(300).await;
    println!("SINUMERIK: farthest {:.1} µm or µrad, skew up to {skew_ms:.1} ms", farthest * 1e3);
    // The axes are sampled up to 4 ms apart, at 10 ms; a late sampling of the server bends the line between two.
    assert!(farthest < 0.02, "{farthest} mm or mrad");
    assert!(skew_ms > 0.5 && skew_ms < 50.0, "{skew_ms} ms");

    // Standing axes are reported as standing, and no reading is missed.
    peer.order("stand");
    let mut last = reader.axes().await;
    while !last.held {
        last = reader.axes().await;
    }
    let next = reader.axes().await;
    assert!(next.position == last.position && next.stamp_ns > last.stamp_ns, "{last:?} {next:?}");
    peer.order("move");
    let moves = |reading: &Reading| match reading {
        Reading::Axes(axes) if !axes.held && axes.position != last.position => Some(()),
        _ => None,
    };
    reader.find(moves).await;

    // The server's link to the controller is lost, and found again.
    peer.order("bad");
    let silent = reader.status(|status| status.state == DeviceState::Silent).await;
    let end = silent.last_end.expect("it ended").to_string();
    assert!(end.contains("axis C") && end.contains("BadNoCommunication"), "{end}");
    peer.order("good");
    let gap = reader.gap().await;
    assert!(gap.to > gap.from, "{gap:?}");

    reader.axes().await;
    drop(peer);
    reader.status(|status| status.state == DeviceState::Absent).await;
    let _peer = asyncua(port, "sinumerik", "none", folder.path());
    let gap = reader.gap().await;
    assert!(gap.to > gap.from, "{gap:?}");
    reader.status(|status| status.state == DeviceState::Streaming).await;
    reader.0.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn opc_40502_is_found_by_browsing_through_basic256sha256_with_a_user() {
    let (port, folder) = (free_port(), tempfile::tempdir().expect("a folder"));
    let peer = asyncua(port, "opc-40502", "Basic256Sha256", folder.path());
    let ours = folder.path().join("ours");
    let password_file = folder.path().join("password");
    std::fs::write(&password_file, "trunnion\n").expect("the folder takes files");
    let keys = |user: &str| {
        format!(
            "layout = \"opc-40502\"\nsecurity = \"Basic256Sha256\"\ncertificates = '{}'\nuser = \"{user}\"\n\
             password_file = '{}'\nsilence_ms = 1500\n",
            ours.display(),
            password_file.display()
        )
    };
    let mut reader = Reader::start(port, &keys("measure"));
    let identity = reader.status(|status| !status.identity.is_empty()).await.identity;
    assert_eq!(identity, "OPC UA server asyncua opc-40502, Basic256Sha256, axes X Y Z B C");
    assert_eq!(reader.program_runs().await.program, "TRUNNION_1");
    let (farthest, skew_ms) = reader.compare(300).await;
    println!("OPC 40502: farthest {:.1} µm or µrad, skew up to {skew_ms:.1} ms", farthest * 1e3);
    assert!(farthest < 0.02, "{farthest} mm or mrad");
    reader.0.stop().await;

    // A wrong user.
    let mut stranger = Reader::start(port, &keys("nobody"));
    let refused = stranger.status(|status| status.state == DeviceState::Refused).await;
    let end = refused.last_end.expect("it ended").to_string();
    assert!(end.contains("user and password"), "{end}");
    stranger.0.stop().await;

    // No encryption: the server says what it offers.
    let mut open = Reader::start(port, "layout = \"opc-40502\"\n");
    let refused = open.status(|status| status.state == DeviceState::Refused).await;
    let end = refused.last_end.expect("it ended").to_string();
    assert!(end.contains("Basic256Sha256 SignAndEncrypt") && end.contains("`security`"), "{end}");
    open.0.stop().await;

    // Another server takes its place: its certificate is not the one of the first connection.
    drop(peer);
    std::fs::remove_file(folder.path().join("key.pem")).expect("the server's key");
    std::fs::remove_file(folder.path().join("certificate.der")).expect("the server's certificate");
    let _another = asyncua(port, "opc-40502", "Basic256Sha256", folder.path());
    let mut reader = Reader::start(port, &keys("measure"));
    let wrong = reader.status(|status| status.state == DeviceState::WrongDevice).await;
    let end = wrong.last_end.expect("it ended").to_string();
    assert!(end.contains("certificate") && end.contains("remove that file"), "{end}");
    reader.0.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn a_server_is_found_by_its_address_with_its_layout_or_what_it_wants() {
    let cases = [
        ("sinumerik", "none", "no encryption, SINUMERIK with 5 machine axes", "axes = \"?\""),
        ("opc-40502", "none", "no encryption, OPC 40502 with axes X Y Z B C", "layout = \"opc-40502\""),
        ("opc-40502", "Basic256Sha256", "encrypted only", "security = \"Basic256Sha256\""),
    ];
    for (layout, security, words, key) in cases {
        let (port, folder) = (free_port(), tempfile::tempdir().expect("a folder"));
        let _peer = asyncua(port, layout, security, folder.path());
        let url = format!("opc.tcp://127.0.0.1:{port}/trunnion/");
        let place = servers(&url, None).expect("an address that can be asked").remove(0);
        let look = look(place, None).await;
        let (_, found) = look.found.unwrap_or_else(|| panic!("{:?}", look.trouble));
        assert_eq!(found.identity, format!("OPC UA server asyncua {layout}, {words}"));
        assert!(found.keys.iter().any(|line| line.starts_with(key)), "{:?}", found.keys);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a peer test: tests/peers/run"]
async fn a_node_that_is_not_there_is_named_with_what_the_server_has() {
    let (port, folder) = (free_port(), tempfile::tempdir().expect("a folder"));
    let _peer = asyncua(port, "sinumerik", "none", folder.path());
    let cases = [
        ("layout = \"sinumerik\"\naxes = \"XYZABC\"\n", "measPos1[u1,6]"),
        ("layout = \"opc-40502\"\n", "without CncAxisList"),
        ("layout = \"nodes\"\nnodes = { X = \"ns=2;s=/Nowhere\" }\n", "/Nowhere"),
        ("layout = \"nodes\"\nnodes = { X = \"nowhere\" }\n", "ns=2;s="),
    ];
    for (keys, words) in cases {
        let mut reader = Reader::start(port, keys);
        let wrong = reader.status(|status| status.state == DeviceState::WrongDevice).await;
        let end = wrong.last_end.expect("it ended").to_string();
        assert!(end.contains(words), "{words}: {end}");
        println!("{end}");
        reader.0.stop().await;
    }
}
