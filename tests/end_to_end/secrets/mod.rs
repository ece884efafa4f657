//! No password, token or key is in anything that the program writes: log, screens, recordings, reports, page, MQTT, command lines.
//!
//! A service with a secret of each kind records a cycle, analyses it, shows and publishes it, with everything logged; commands and
//! mistakes follow. Then every byte that came of it is searched.

mod encryption;
mod page;
mod search;

use super::broker::Broker;
use super::page_status::free_port;
use super::program::output;
use super::shop::{self, Floor, Service, files, floor, journal, record, until};
use page::Page;
use search::Secrets;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use trunnion_hil_sim::devices::cell::CellConfig;
use trunnion_hil_sim::scenario::Pace;

const OWN: &str = "x-trunnion: test\r\nContent-Type: application/json\r\n";

/// Letters and digits of each secret; the passwords have signs around them that files, addresses and pages write in other ways.
const MQTT: &str = "mq7Rk2vXw9Lt";
const MQTT_BEFORE: &str = "wr4Np8sYz1Qe";
const MQTT_FILE: &str = "fi6Kt3hGd5Xo";
const AGENT: &str = "ag5Hd3jBc6Fu";
const LINUXCNC: &str = "lc9Vn1gTm7Ko";
const OPCUA: &str = "ua8Fs5nJe2Rb";
const TOKEN: &str = "tk2Wb6yPx8Zs4Ja0Mi";

fn mqtt_password() -> String {
    format!("p/%&<\u{fc}{MQTT}\"' ")
}

/// The configuration and its files in `etc`, what the service writes in `data`, ports in `ports`.
struct Folders(tempfile::TempDir);

impl Folders {
    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.at(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.at(name), text).unwrap();
    }
}

/// With everything logged, to a file, by a shell whose files everybody may read; the password of the broker is a credential of systemd.
fn start(folders: &Folders) -> Service {
    let mut command = Command::new("sh");
    command.args(["-c", "umask 022; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_trunnion")]);
    command.args(["daemon", "--config", &folders.text("etc/trunnion.toml")]).env("RUST_LOG", "trace");
    command.env("CREDENTIALS_DIRECTORY", folders.at("credentials"));
    let file = |name: &str| std::fs::File::create(folders.at(name)).unwrap();
    Service::start_by(command.stdout(file("out.txt")).stderr(file("log.txt")))
}

fn agent_password() -> String {
    format!("{AGENT}:&%/\u{fc}")
}

fn agent(url: &str, password: &str) -> String {
    format!("{}user = \"cell\"\n{password}\n", shop::agent(url))
}

fn config(folders: &Folders, url: &str, broker: u16, page: u16) -> String {
    let controller = agent(url, &format!("password = '{}'  # {AGENT}", agent_password()));
    let tables = format!(
        "[mqtt]\nhost = \"127.0.0.1\"\nport = {broker}\nuser = \"cell\"\npassword_file = \"mqtt\"\n\
         [mqtt.tls]\nca = \"page.crt\"\ncertificate = \"client.crt\"\nkey_file = \"client.key\"\n\
         [page]\nlisten = \"127.0.0.1:{page}\"\nnames = [\"cell-4.lan\"]\ncertificate = \"page.crt\"\n\
         key_file = \"page.key\"\ntoken_file = \"token\"\n"
    );
    format!(
        "# The password of the broker is {MQTT}, that of the agent {AGENT}, of OPC UA {OPCUA}; the token is {TOKEN}\n"
    ) + &shop::config(&folders.at("ports"), "../data", &controller, &tables)
}

/// What was written to screens and sockets: where, and the bytes.
#[derive(Default)]
struct Heard(Vec<(String, Vec<u8>)>);

impl Heard {
    /// Runs a command; what it said.
    fn command(&mut self, args: &[&str]) -> String {
        let (_, stdout, stderr) = output(args);
        let said = stdout + &stderr;
        self.0.push((args.join(" "), said.clone().into_bytes()));
        said
    }

    /// Makes a call of the page; its status.
    fn call(&mut self, page: &Page, line: &str, headers: &str, body: &str) -> u16 {
        let (status, answer) = page.call(line, headers, body).unwrap();
        self.0.push((format!("{line} {body}"), answer.into_bytes()));
        status
    }
}

/// Command lines and environments of this program, which others of the computer can read.
fn processes() -> Vec<u8> {
    let of = |entry: std::fs::DirEntry| {
        let read = |file: &str| std::fs::read(entry.path().join(file)).unwrap_or_default();
        let line = read("cmdline");
        String::from_utf8_lossy(&line).contains("trunnion").then(|| [line, read("environ")].concat())
    };
    std::fs::read_dir("/proc").unwrap().flatten().filter_map(of).flatten().collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_secret_is_in_anything_that_is_logged_shown_recorded_or_published() {
    let folders = Folders(tempfile::tempdir().unwrap());
    for name in ["etc", "data", "ports", "credentials"] {
        std::fs::create_dir(folders.at(name)).unwrap();
    }
    let certificates = Path::new(env!("CARGO_MANIFEST_DIR")).join("../service/tests/data");
    for name in ["page.crt", "page.key", "client.crt", "client.key"] {
        std::fs::copy(certificates.join(name), folders.at("etc").join(name)).unwrap();
    }
    let login = |floor: &mut CellConfig| {
        floor.controller.as_mut().unwrap().0.login = Some(("cell".into(), agent_password()));
    };
    let pace = Pace { move_s: 0.1, dwell_s: 0.3 };
    let Floor { cell, url, cycle } = floor(&folders.at("ports"), 90, pace, login).await;
    folders.write("etc/c.toml", &cycle);
    tokio::task::spawn_blocking(move || searched(&folders, &url)).await.unwrap();
    cell.shutdown().await;
}

fn searched(folders: &Folders, url: &str) {
    let encryption = encryption::of_broker(&folders.at("etc"));
    let broker = Broker::start_encrypted("cell", mqtt_password(), encryption);
    let page = Page::at(free_port(), &folders.at("etc/page.crt"));
    folders.write("etc/trunnion.toml", &config(folders, url, broker.port, page.port));
    // The file of the configuration is not the one that counts.
    folders.write("etc/mqtt", &format!("{MQTT_FILE}\n"));
    folders.write("credentials/mqtt", &format!("{MQTT_BEFORE}\n"));
    folders.write("etc/token", &format!("{TOKEN}-/+ \n"));
    let mut heard = Heard::default();
    let (cookie, before) = serve(folders, &broker, &page, &mut heard);
    commands(folders, url, &mut heard);
    mistakes(folders, url, &mut heard);
    heard.0.push(("MQTT".into(), broker.sent()));

    let part = |line: &str| line.split(['+', '/', '=']).max_by_key(|part| part.len()).unwrap().to_owned();
    let key = |name: &str| part(std::fs::read_to_string(folders.at(name)).unwrap().lines().nth(1).unwrap());
    let secrets = Secrets::of(&[
        ("password of the broker", MQTT),
        ("password that the broker refused", MQTT_BEFORE),
        ("password in the file that a credential replaces", MQTT_FILE),
        ("password of the agent", AGENT),
        ("password of LinuxCNC", LINUXCNC),
        ("token of the page", TOKEN),
        ("cookie of the page", &cookie),
        ("password of OPC UA", OPCUA),
        ("key of the page", &key("etc/page.key")),
        ("key for the broker", &key("etc/client.key")),
    ]);
    let mut written = search::files(&folders.at("data"));
    let readable = |path: &&PathBuf| path.metadata().unwrap().permissions().mode() & 0o027 != 0;
    let readable: Vec<&PathBuf> = written.iter().filter(readable).collect();
    assert!(readable.is_empty(), "others may read or write {readable:?}");
    written.extend(["out.txt", "log.txt"].map(|name| folders.at(name)));
    let kinds = ["mcap", "html", "json", "txt"];
    for kind in kinds {
        assert!(written.iter().any(|path| path.extension().is_some_and(|ending| ending == kind)), "{kind}");
    }
    let of_files =
        written.iter().filter_map(|path| Some((path.display().to_string(), secrets.in_file(path)?)));
    let of_screens =
        heard.0.iter().filter_map(|(name, bytes)| Some((name.clone(), secrets.in_bytes(bytes)?)));
    let found: Vec<_> = of_files.chain(of_screens).collect();
    assert!(found.is_empty(), "{found:#?}");
    assert_eq!(search::files(&folders.at("etc")).len(), before, "no copy of a configuration");
    assert!(heard.0.iter().all(|(_, bytes)| !bytes.is_empty()), "each said something");
}

/// The service from its start to its end; the cookie of its page, and how many files its configuration has.
fn serve(folders: &Folders, broker: &Broker, page: &Page, heard: &mut Heard) -> (String, usize) {
    let before = search::files(&folders.at("etc")).len();
    let service = start(folders);
    until("a password that the broker refuses", || (broker.counts().1 > 0).then_some(()));
    folders.write("credentials/mqtt", &format!("{}\n", mqtt_password()));
    let data = folders.at("data");
    let journal = journal(&data, 10_000);
    if let Ok(bytes) = std::fs::read(&journal) {
        heard.0.push(("journal".into(), bytes));
    }
    let mut has_report = |path: PathBuf| {
        let record = record(&path)?;
        let now = processes();
        if heard.0.last().is_none_or(|(_, before)| *before != now) {
            heard.0.push(("processes".into(), now));
        }
        record.state.has_report().then_some(path)
    };
    let state = until("a report", || files(&data, ".state.json").into_iter().find_map(&mut has_report));
    until("a broker that lets us in", || (broker.counts().0 > 0).then_some(()));

    let bearer = format!("Authorization: Bearer {TOKEN}-/+\r\n");
    let (status, answer) =
        page.call("POST /api/login", OWN, &format!("{{\"token\":\"{TOKEN}-/+\"}}")).unwrap();
    assert_eq!(status, 200, "{answer}");
    let cookie = answer.split("trunnion=").nth(1).unwrap().split(';').next().unwrap().to_owned();
    heard.0.push(("login".into(), answer.replace(&cookie, "").into_bytes()));
    for body in [
        format!("\"{TOKEN}-/+\""),
        format!("{TOKEN}-/+"),
        format!("{{\"{TOKEN}-/+\":1}}"),
        format!("{{\"token\":[\"{TOKEN}-/+\"]}}"),
        format!("{{\"token\":\"{TOKEN}-/ \"}}"),
    ] {
        assert!((400..500).contains(&heard.call(page, "POST /api/login", OWN, &body)), "{body}");
    }
    let run = state.file_name().unwrap().to_str().unwrap().strip_suffix(".state.json").unwrap().to_owned();
    for call in ["/api/status", "/api/runs", "/api/history", "/", &format!("/api/runs/{run}")] {
        assert_eq!(heard.call(page, &format!("GET {call}"), &bearer, ""), 200, "{call}");
    }
    for call in ["identification", "diagnosis", "comparison", "ladder", "linear", "methods", "report"] {
        heard.call(page, &format!("GET /api/runs/{run}/{call}"), &bearer, "");
    }
    for call in ["GET /api/runs/none", "POST /api/run-command"] {
        assert_eq!(heard.call(page, call, &format!("{bearer}{OWN}"), ""), 404, "{call}");
    }
    heard.command(&["cycle", "status", "--config", &folders.text("etc/trunnion.toml")]);
    service.stop();
    let log = std::fs::read_to_string(folders.at("log.txt")).unwrap();
    for level in ["TRACE", "DEBUG", "INFO", "WARN"] {
        assert!(log.contains(level), "no {level} in the log");
    }
    assert!(log.contains("it does not let this user in; check `user` and `password_file`"), "{log}");
    (cookie, before)
}

/// What a person asks of the recording and of the devices.
fn commands(folders: &Folders, url: &str, heard: &mut Heard) {
    let config = folders.text("etc/trunnion.toml");
    let recordings = files(&folders.at("data"), ".mcap");
    let run = recordings.first().unwrap().display().to_string();
    let recorded = trunnion_record::read_header(recordings.first().unwrap()).unwrap().config_text;
    for words in ["user = \"cell\"", "password = \"left out\"", "password_file = \"mqtt\""] {
        assert!(recorded.contains(words), "{words} in {recorded}");
    }
    let said = heard.command(&["check-config", &config]);
    assert!(said.contains("holds a password that every user of this computer can read"), "{said}");
    heard.command(&["check", &run]);
    heard.command(&["check", &run, "--json"]);
    heard.command(&["diagnose", &run, "--json"]);
    heard.command(&["scrub", &run]);
    heard.command(&["export", "csv", &run, "--what", "every-point"]);
    heard.command(&["history", "--folder", &folders.text("data")]);
    let watched = heard.command(&["watch", "--config", &config, "--seconds", "4", "--json"]);
    assert!(watched.contains("\"cnc\""), "{watched}");
    let said = heard.command(&["devices", "--config", &config]);
    assert!(said.contains("axes X Y Z B C"), "{said}");
    let said = heard.command(&["devices", "--url", url]);
    assert!(said.contains("give `user` and `password_file`"), "{said}");
}

/// What a person does wrong.
fn mistakes(folders: &Folders, url: &str, heard: &mut Heard) {
    // Devices alone: a wrong password, a file that is not there, and a server that repeats what it is asked.
    let echo = repeats_what_it_is_asked();
    folders.write("etc/linuxcnc", &format!("{LINUXCNC}\n"));
    folders.write("etc/agent", &format!("{MQTT_BEFORE}\n"));
    let linuxcnc = format!(
        "[[device]]\nname = \"cnc\"\ndriver = \"linuxcnc\"\nhost = \"127.0.0.1\"\nport = {echo}\njoints = \"XYZBC\"\n\
         password_file = \"linuxcnc\"\n"
    );
    let opcua = |password: &str| {
        format!(
            "[[device]]\nname = \"cnc\"\ndriver = \"opcua\"\nurl = \"opc.tcp://127.0.0.1:{}\"\nlayout = \"sinumerik\"\n\
             axes = \"XYZBC\"\nuser = \"cell\"\n{password}\n",
            free_port()
        )
    };
    folders.write("etc/opcua", &format!("{OPCUA}\n"));
    for password in [&format!("password = \"{OPCUA}\""), "password_file = \"opcua\""] {
        folders.write("etc/devices.toml", &opcua(password));
        let said = heard.command(&["devices", "--config", &folders.text("etc/devices.toml")]);
        // A build of this crate alone has no OPC UA; that of the workspace has.
        assert!(
            ["is not there", "not part of this build"].iter().any(|words| said.contains(words)),
            "{said}"
        );
    }
    folders.write("etc/devices.toml", &opcua(&format!("password = [\"{OPCUA}\"]")));
    heard.command(&["devices", "--config", &folders.text("etc/devices.toml")]);
    for (device, words) in [
        (
            agent(url, "password_file = \"agent\""),
            "the agent refuses user cell: check `user` and `password_file`",
        ),
        (agent(url, "password_file = \"gone\""), "gone cannot be read"),
        (linuxcnc, "found something that repeats the password"),
    ] {
        folders.write("etc/devices.toml", &device);
        let said = heard.command(&["devices", "--config", &folders.text("etc/devices.toml")]);
        assert!(said.contains(words), "{said}");
    }

    // A password that is written in a wrong way.
    let good = std::fs::read_to_string(folders.at("etc/trunnion.toml")).unwrap();
    for wrong in [
        format!("password = {MQTT}"),
        format!("password = \"{MQTT}"),
        format!("password = [\"{MQTT}\"]"),
        format!("password = {{ {MQTT} = 1 }}"),
        format!("password = \"\\q{MQTT}\""),
        format!("password = \"{MQTT}\"\npassword_file = \"mqtt\""),
        format!("passwort = \"{MQTT}\""),
        format!("password = \"{MQTT}\"\npassword = \"{MQTT}\""),
        format!("password_file = \"mqtt\"\nport = \"{MQTT}\""),
    ] {
        folders.write("etc/wrong.toml", &good.replacen("password_file = \"mqtt\"", &wrong, 1));
        let said = heard.command(&["check-config", &folders.text("etc/wrong.toml")]);
        assert!(said.contains("wrong.toml"), "{wrong}: {said}");
    }
    for wrong in [format!("http://cell:{AGENT}@127.0.0.1:1"), format!("http://cell:{AGENT}/@127.0.0.1:1")] {
        folders.write("etc/wrong.toml", &good.replacen(url, &wrong, 1));
        let said = heard.command(&["check-config", &folders.text("etc/wrong.toml")]);
        assert!(said.contains("url holds a user or a password"), "{said}");
    }
    let host = format!("host = \"cell:{MQTT}@127.0.0.1\"");
    folders.write("etc/wrong.toml", &good.replacen("host = \"127.0.0.1\"", &host, 1));
    let said = heard.command(&["check-config", &folders.text("etc/wrong.toml")]);
    assert!(said.contains("host holds a user or a password"), "{said}");
    folders.write("etc/wrong.toml", &good.replacen("token_file = \"token\"", "token_file = \"gone\"", 1));
    let said = heard.command(&["check-config", &folders.text("etc/wrong.toml")]);
    assert!(said.contains("gone cannot be read"), "{said}");
    folders.write("etc/wrong.toml", &good.replacen("key_file = \"client.key\"", "key_file = \"mqtt\"", 1));
    let said = heard.command(&["check-config", &folders.text("etc/wrong.toml")]);
    assert!(said.contains("`key_file` holds no private key"), "{said}");
    for name in ["devices.toml", "wrong.toml", "linuxcnc", "agent", "opcua"] {
        std::fs::remove_file(folders.at("etc").join(name)).unwrap();
    }
}

/// A server of another kind, which says what it does not understand; its port.
fn repeats_what_it_is_asked() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let mut lines = BufReader::new(stream);
            let mut line = String::new();
            while lines.read_line(&mut line).is_ok_and(|count| count > 0) {
                if write!(lines.get_mut(), "500 unknown: {}\r\n", line.trim()).is_err() {
                    break;
                }
                line.clear();
            }
        }
    });
    port
}
