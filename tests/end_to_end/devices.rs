//! `trunnion devices` through the binary, against virtual devices on pseudo-terminals and servers on the network.

use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::Output;
use std::sync::Arc;
use std::time::Instant;
use trunnion_acquire::parse_devices;
use trunnion_core::AxisValues;
use trunnion_hil_sim::devices::ascii::{IndicatorConfig, Sees};
use trunnion_hil_sim::devices::canopen::BusConfig;
use trunnion_hil_sim::devices::{
    CycleState, DeviceClock, Fault, TimeOrigin, World, ascii, canopen, keyence, linuxcncrsh, optoncdt,
};
use trunnion_protocol::ascii::{PRESETS, Preset};

struct Still;

impl World for Still {
    fn axes(&self, _t_s: f64) -> AxisValues<f64> {
        AxisValues::default()
    }

    fn probe_readings_mm(&self, _t_s: f64) -> [f64; 3] {
        [0.1, 0.2, 0.3]
    }

    fn bar_reading_mm(&self, _t_s: f64) -> f64 {
        0.4
    }

    fn temperature_degc(&self, _t_s: f64) -> f64 {
        21.0
    }

    fn cycle(&self, _t_s: f64) -> CycleState {
        CycleState { program: "O1".into(), block: 1, running: false }
    }
}

fn trunnion(args: &[&str]) -> Output {
    crate::program::command().args(args).output().unwrap()
}

fn places(folder: &Path, names: &[&str]) -> Vec<Value> {
    let ports: Vec<String> =
        names.iter().map(|name| folder.join(name).to_str().unwrap().to_owned()).collect();
    asked(ports.iter().flat_map(|port| ["--port", port]))
}

fn asked<'a>(at: impl IntoIterator<Item = &'a str>) -> Vec<Value> {
    let args: Vec<&str> = ["devices", "--json"].into_iter().chain(at).collect();
    let output = trunnion(&args);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["format"], "trunnion-devices/1");
    json["places"].as_array().unwrap().clone()
}

#[tokio::test(flavor = "multi_thread")]
async fn what_answers_is_named_and_its_lines_are_a_configuration_that_reads() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (world, origin): (Arc<dyn World>, _) = (Arc::new(Still), TimeOrigin(Instant::now().into()));
    let clock = DeviceClock::steady(1.0, 10.0);
    let probe = optoncdt::ProbeConfig { streams_at_start: true, ..optoncdt::ProbeConfig::new(0, clock) };
    let _probe = optoncdt::spawn(world.clone(), probe, &at("probe"), origin, &[]).unwrap();
    let gauges = keyence::BoxConfig { amplifiers: 2, ..keyence::BoxConfig::three_gauges() };
    let _box = keyence::spawn(world.clone(), gauges, &at("box"), origin, &[]).unwrap();
    let bus = BusConfig::ball_bar(clock);
    let _bus = canopen::spawn(world.clone(), &bus, &at("can"), origin, &[]).unwrap();
    let asked = PRESETS.iter().filter(|preset| preset.may_be_asked);
    let names: Vec<&str> = asked.map(|preset| preset.name).collect();
    let mut indicators = Vec::new();
    for &name in &names {
        let config = IndicatorConfig::new(Sees::Bar, *Preset::named(name).unwrap());
        indicators.push(ascii::spawn(world.clone(), config, &at(name), origin, &[]).unwrap());
    }

    let check = |place: &Value, driver: &str, identity: &str| {
        assert_eq!(place["driver"], driver, "{place:#}");
        assert!(place["identity"].as_str().unwrap().contains(identity), "{place:#}");
    };
    let found = places(folder.path(), &["probe", "box", "can"]);
    check(&found[0], "optoncdt", "ILD1420-2 serial 21050001 range 2 mm");
    check(&found[1], "keyence-dl-rs1a", "2 amplifiers GT2-70");
    check(&found[2], "canopen-slcan", "slcan CAN adapter, version 1013, serial number T001; node 5 ");
    assert!(found[2]["config"].as_str().unwrap().contains("nodes = [{ id = 5, role = "), "{:#}", found[2]);
    for (place, name) in places(folder.path(), &names).iter().zip(&names) {
        check(place, "ascii", Preset::named(name).unwrap().about);
        assert!(place["config"].as_str().unwrap().contains(&format!("preset = \"{name}\"")), "{place:#}");
    }

    let pasted: String = found[..2].iter().map(|place| place["config"].as_str().unwrap()).collect();
    assert_eq!(parse_devices("pasted", &pasted).unwrap().len(), 2);
    let file = folder.path().join("devices.toml");
    std::fs::write(&file, &pasted).unwrap();
    let output = trunnion(&["devices", "--config", file.to_str().unwrap()]);
    let shown = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{shown}");
    for words in ["probe-1 = 1.1000 mm", "keyence-dl-rs1a-2.head-2 = 0.2000 mm", "Streaming"] {
        assert!(shown.contains(words), "{words:?} is missing in:\n{shown}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn linuxcnc_is_named_and_reads_once_its_joints_are_filled_in() {
    let (world, origin): (Arc<dyn World>, _) = (Arc::new(Still), TimeOrigin(Instant::now().into()));
    let config = linuxcncrsh::ServerConfig::default();
    let server = linuxcncrsh::spawn(world.clone(), config, origin, &[]).await.unwrap();
    let secret =
        linuxcncrsh::ServerConfig { password: "secret".into(), ..linuxcncrsh::ServerConfig::default() };
    let closed = linuxcncrsh::spawn(world, secret, origin, &[]).await.unwrap();
    let (url, closed) =
        (format!("linuxcnc://{}", server.address()), format!("linuxcnc://{}", closed.address()));

    let found = asked(["--url", &url, "--url", &closed]);
    assert_eq!(found[0]["driver"], "linuxcnc", "{:#}", found[0]);
    let identity = found[0]["identity"].as_str().unwrap();
    assert_eq!(identity, "linuxcncrsh EMCNETSVR 1.1, joints in MM MM MM DEG DEG MM");
    let trouble = found[1]["trouble"].as_str().unwrap();
    assert!(trouble.contains("the connection password is wrong"), "{trouble}");

    let lines = found[0]["config"].as_str().unwrap();
    // On a screen that is narrower than they are they are the same, to be pasted.
    assert!(lines.lines().any(|line| line.len() > 80), "{lines}");
    let mut command = crate::program::command();
    let output = command.args(["devices", "--url", &url]).env("COLUMNS", "80").output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let pasted = &printed[printed.find("[[device]]").unwrap()..];
    assert_eq!(parse_devices("pasted", &pasted.replace('?', "XYZBC")).unwrap().len(), 1, "{printed}");
    assert_eq!(pasted, lines);
    let unfilled = parse_devices("pasted", lines).unwrap_err().to_string();
    assert!(unfilled.contains("COORDINATES"), "{unfilled}");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("devices.toml");
    std::fs::write(&file, lines.replace('?', "XYZBC")).unwrap();
    let output = trunnion(&["devices", "--config", file.to_str().unwrap()]);
    let shown = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && shown.contains("C = 0.0000°"), "{shown}");
}

#[tokio::test(flavor = "multi_thread")]
async fn every_trouble_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (world, origin): (Arc<dyn World>, _) = (Arc::new(Still), TimeOrigin(Instant::now().into()));
    let spawn = |name: &str| {
        let config = keyence::BoxConfig::three_gauges();
        keyence::spawn(world.clone(), config, &at(name), origin, &[]).unwrap()
    };
    let (garbled, silent, used) = (spawn("garbled"), spawn("silent"), spawn("used"));
    garbled.inject(Fault::GarbleBytes { count: 1_000_000 }).unwrap();
    silent.inject(Fault::Silence { duration_s: 1000.0 }).unwrap();
    let hold = std::fs::OpenOptions::new().read(true).write(true).open(at("used")).unwrap();
    hold.lock().unwrap();
    std::fs::write(at("file"), "").unwrap();

    let found = places(folder.path(), &["garbled", "silent", "used", "gone", "file"]);
    let check = |place: &Value, words: &[&str]| {
        let trouble = place["trouble"].as_str().unwrap();
        assert!(words.iter().all(|word| trouble.contains(word)), "{words:?} in {trouble}");
    };
    check(&found[0], &["bytes came that make no sense at any line speed asked"]);
    check(&found[1], &["nothing answers", "switched on"]);
    check(&found[2], &["uses it; close that program"]);
    check(&found[3], &["is not there", "plug it in"]);
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    for scheme in ["http", "linuxcnc", "opc.tcp"] {
        let url = format!("{scheme}://{free}");
        let found = &asked(["--url", &url])[0];
        // A build of this crate alone has no OPC UA; that of the workspace has.
        let left_out = scheme == "opc.tcp" && found["trouble"].as_str().unwrap().contains("--features full");
        if !left_out {
            check(found, &[&url, "is not there", "switched on", "the address"]);
        }
    }
    let unknown = trunnion(&["devices", "--url", "ftp://cnc"]);
    let reported = String::from_utf8(unknown.stderr).unwrap();
    assert!(!unknown.status.success() && reported.contains("opc.tcp://HOST:PORT"), "{reported}");
    check(&found[4], &["cannot open", "is it a serial port?"]);
    assert!(
        found[1]["asked"].as_array().unwrap().iter().any(|asked| asked.as_str().unwrap().contains("GETINFO"))
    );
    drop(used);
}

/// The address of a server that gives this answer to every question.
fn answers(status: &'static str, body: String) -> String {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let mut lines = BufReader::new(stream);
            let mut line = String::from("more");
            while !line.trim().is_empty() {
                line.clear();
                lines.read_line(&mut line).unwrap();
            }
            let length = body.len();
            // One that does not read it all is answered in its own report.
            write!(lines.get_mut(), "HTTP/1.1 {status}\r\nContent-Length: {length}\r\n\r\n{body}").ok();
        }
    });
    url
}

#[test]
fn an_answer_that_is_not_taken_is_reported_with_the_reason() {
    let header = "<Header instanceId=\"1\" sender=\"a\"/>";
    let devices = |devices: &str| format!("<MTConnectDevices>{header}{devices}</MTConnectDevices>");
    for (status, body, words) in [
        // More than any machine has: it is not read to its end.
        ("200 OK", devices(&"<a/>".repeat(600_000)), "more than 500000 elements and attributes"),
        ("200 OK", devices(""), "<MTConnectDevices> has no <Devices>"),
        ("200 OK", devices("<Devices><Device/></Devices>"), "<Device> has no id"),
        ("200 OK", "<html><body/></html>".into(), "<html> is not an MTConnect devices"),
        ("200 OK", "Hello.".into(), "reading a document"),
        ("404 Not Found", "<html>".into(), "the server answers 404 Not Found"),
        (
            "400 Bad Request",
            format!(
                "<MTConnectError>{header}<Errors><Error errorCode=\"NO_DEVICE\">none here</Error></Errors></MTConnectError>"
            ),
            "NO_DEVICE: none here",
        ),
    ] {
        let url = answers(status, body);
        let found = &asked(["--url", &url])[0];
        let trouble = found["trouble"].as_str().unwrap();
        assert!(trouble.contains(words) && found["driver"].is_null(), "{words:?} is not in {trouble:?}");
    }
}

#[test]
fn an_address_with_a_password_is_refused_without_being_shown() {
    let output = trunnion(&["devices", "--url", "http://ada:geheim@127.0.0.1:9"]);
    let shown = [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap()).concat();
    assert_eq!(output.status.code(), Some(1), "{shown}");
    assert!(!shown.contains("ada") && !shown.contains("geheim"), "{shown}");
    assert!(
        shown.split_whitespace().collect::<Vec<_>>().join(" ").contains("user and password_file"),
        "{shown}"
    );
}
