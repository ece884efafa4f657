//! LinuxCNC as a process without a screen, its HAL file, and conversations with it.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use trunnion_core::axis::iso::{B, C, X, Y, Z};
use trunnion_core::{AxisValues, Joint, convert};
use trunnion_tests::workspace_root;

/// LinuxCNC's port here; its other parts allow one of it on a computer anyway.
pub const PORT: u16 = 5079;
/// Order of the joints in five-axis.ini.
pub const JOINTS: [Joint; 5] = [X, Y, Z, B, C];
/// Longest wait for LinuxCNC to do as commanded.
pub const LIMIT: Duration = Duration::from_secs(60);
/// An order without effect for so long was lost: linuxcncrsh mixes up requests of connections that speak at the same moment.
const LOST_AFTER: Duration = Duration::from_secs(5);

/// A running LinuxCNC; shut down with this.
pub struct LinuxCnc {
    process: Child,
    folder: tempfile::TempDir,
}

/// How the drives get their commands.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Drives {
    /// As LinuxCNC commands; linuxcncrsh says where they are.
    Direct,
    /// The same, with the commands of the drives sampled.
    Sampled,
    /// Through the component `trunnion_correction`, with its commands sampled.
    Corrected,
}

impl LinuxCnc {
    /// As an unprivileged user with a home of its own: it refuses nothing, but neither does it belong to root.
    pub fn start(drives: Drives) -> Self {
        let folder = tempfile::Builder::new().prefix("linuxcnc").tempdir().unwrap();
        let source = workspace_root().join("tests/peers/linuxcnc");
        let text = |name: &str| std::fs::read_to_string(source.join(name)).unwrap();
        let put = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let ini = put("five-axis.ini", &text("five-axis.ini").replace("PORT\n", &format!("{PORT}\n")));
        put("five-axis.hal", &hal(&text("five-axis.hal"), drives));
        put("five-axis.tbl", "T1 P1 Z0 D0\n");
        put("five-axis.var", "");
        if is_root() {
            let owned = Command::new("chown").args(["-R", "nobody"]).arg(folder.path()).status().unwrap();
            assert!(owned.success());
        }
        let log = std::fs::File::create(folder.path().join("linuxcnc.log")).unwrap();
        let process = unprivileged("linuxcnc")
            .arg(ini)
            .env("HOME", folder.path())
            .stdin(Stdio::null())
            .stdout(log.try_clone().unwrap())
            .stderr(log)
            .spawn()
            .expect("linuxcnc-uspace is installed by tests/peers/run");
        Self { process, folder }
    }

    /// Puts a program where LinuxCNC reads it.
    pub fn put(&self, program: &str) -> PathBuf {
        let path = self.folder.path().join("trunnion-cycle.ngc");
        std::fs::write(&path, program).unwrap();
        path
    }

    /// The correction on ("1") or off ("0"), once LinuxCNC runs.
    pub fn switched(&self, on: &str) {
        drop(reach());
        let mut command = unprivileged("halcmd");
        command.args(["setp", "trunnion-correction.enable", on]).env("HOME", self.folder.path());
        assert!(command.status().unwrap().success(), "halcmd setp trunnion-correction.enable {on}");
    }
}

fn is_root() -> bool {
    Command::new("id").arg("-u").output().unwrap().stdout == b"0\n"
}

pub fn unprivileged(program: &str) -> Command {
    if !is_root() {
        return Command::new(program);
    }
    let mut command = Command::new("setpriv");
    command.args(["--reuid=nobody", "--regid=nogroup", "--clear-groups", program]);
    command
}

/// The HAL file with its drives; commands are sampled every 10 ms.
fn hal(text: &str, drives: Drives) -> String {
    if drives == Drives::Direct {
        return text.into();
    }
    let names = JOINTS.map(Joint::lower);
    let corrected = drives == Drives::Corrected;
    let mut out = String::new();
    for line in text.lines() {
        let joint =
            line.strip_prefix("net joint").and_then(|rest| rest.split(' ').next()?.parse::<usize>().ok());
        match joint {
            Some(k) if corrected => {
                let (name, component) = (&names[k], "trunnion-correction");
                out += &format!("net place{k} joint.{k}.pos-cmd => {component}.{name}-pos\n");
                out += &match JOINTS[k].is_rotary() {
                    true => format!("{line} sampler.0.pin.{k}\n"),
                    false => format!(
                        "net command{k} joint.{k}.motor-pos-cmd => {component}.{name}-cmd\n\
                         net drive{k} {component}.{name}-out => {component}.{name}-fb-in sampler.0.pin.{k}\n\
                         net back{k} {component}.{name}-fb => joint.{k}.motor-pos-fb\n"
                    ),
                };
            }
            Some(k) => out += &format!("{line} sampler.0.pin.{k}\n"),
            None => out += &format!("{line}\n"),
        }
        if line.starts_with("loadrt [EMCMOT]") {
            out += "loadrt threads name1=sampling period1=10000000\nloadrt sampler depth=4000 cfg=fffff\n";
            out += if corrected { "loadrt trunnion_correction\n" } else { "" };
        }
        if line.starts_with("addf motion-controller") {
            out += if corrected { "addf trunnion-correction servo-thread\n" } else { "" };
            out += "addf sampler.0 sampling\n";
        }
    }
    out
}

impl Drop for LinuxCnc {
    fn drop(&mut self) {
        if let Ok(mut operator) = Conversation::open() {
            operator.say("set enable EMCTOO");
            operator.say("shutdown");
        } else {
            println!("LinuxCNC is gone already");
        }
        self.process.wait().unwrap();
    }
}

/// Lines to and from linuxcncrsh.
pub struct Conversation {
    stream: TcpStream,
    bytes: Vec<u8>,
}

impl Conversation {
    pub fn open() -> std::io::Result<Self> {
        let stream = TcpStream::connect(("127.0.0.1", PORT))?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(LIMIT))?;
        let mut conversation = Self { stream, bytes: Vec::new() };
        conversation.answer("hello EMC test 1.1", "HELLO");
        conversation.say("set echo off");
        conversation.answer("get echo", "ECHO");
        Ok(conversation)
    }

    /// Says something that has no answer of its own.
    pub fn say(&mut self, line: &str) {
        self.stream.write_all(format!("{line}\r\n").as_bytes()).unwrap();
    }

    /// What follows the word in the answer. linuxcncrsh mixes up requests of connections that speak at the same moment:
    /// what it refuses is asked again.
    pub fn answer(&mut self, line: &str, word: &str) -> String {
        self.say(line);
        let mut refused = 0;
        loop {
            if let Some(end) = self.bytes.iter().position(|byte| *byte == b'\n') {
                let text = String::from_utf8(self.bytes.drain(..=end).collect()).unwrap();
                let reported = text.trim().split_once(' ').filter(|(first, _)| *first == word);
                match reported.filter(|_| !text.contains("NAK")) {
                    Some((_, rest)) => return rest.trim().to_owned(),
                    None if text.trim().is_empty()
                        || text.starts_with("set ")
                        || text.starts_with("get ") => {}
                    None => {
                        refused += 1;
                        assert!(refused < 20, "{line}: {text}");
                        self.say(line);
                    }
                }
                continue;
            }
            let mut bytes = [0; 1024];
            let count = self.stream.read(&mut bytes).unwrap();
            assert!(count > 0, "LinuxCNC closed the connection");
            self.bytes.extend_from_slice(&bytes[..count]);
        }
    }

    /// Says an order until it is done. One that is only slow is not said again: LinuxCNC would keep "A file is already open" as its error.
    pub fn until(&mut self, order: &str, ask: &str, word: &str, wanted: &str) {
        let begun = Instant::now();
        let mut said: Option<Instant> = None;
        while self.answer(ask, word) != wanted {
            assert!(begun.elapsed() < LIMIT, "{order}: not {wanted}");
            if said.is_none_or(|said| said.elapsed() > LOST_AFTER) {
                self.say(order);
                said = Some(Instant::now());
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Lets this connection give orders. Said once, it may be taken for the word of another connection, and no order would be obeyed.
    pub fn enable(&mut self) {
        self.until("set enable EMCTOO", "get enable", "ENABLE", "ON");
    }

    pub fn axes(&mut self) -> AxisValues<f64> {
        let reported = self.answer("get joint_pos", "JOINT_POS");
        let numbers: Vec<f64> = reported.split(' ').map(|number| number.parse().unwrap()).collect();
        axes_of(&numbers)
    }
}

/// Positions in the order of the joints, mm and degrees.
pub fn axes_of(numbers: &[f64]) -> AxisValues<f64> {
    let mut axes = AxisValues::default();
    for (letter, &number) in JOINTS.into_iter().zip(numbers) {
        axes[letter] = if letter.is_rotary() { convert::rad_from_deg(number) } else { number };
    }
    axes
}

/// Waits until linuxcncrsh listens.
pub fn reach() -> Conversation {
    let begun = Instant::now();
    loop {
        match Conversation::open() {
            Ok(conversation) => return conversation,
            Err(error) => assert!(begun.elapsed() < LIMIT, "LinuxCNC does not start: {error}"),
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}
