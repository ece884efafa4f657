//! The adapter for agents of MTConnect over TCP: what is sent when, and what is refused.

use serde_json::json;
use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::CancellationToken;
use trunnion_service::board::Board;
use trunnion_service::config::Config;
use trunnion_service::mtconnect::{MtConnectConfig, serve};

const LIMIT: Duration = Duration::from_secs(20);

struct Agent(BufReader<TcpStream>);

impl Agent {
    async fn connect(address: SocketAddr) -> Self {
        Self(BufReader::new(TcpStream::connect(address).await.unwrap()))
    }

    /// The next line without its time; `None` at the end.
    async fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        let bytes = tokio::time::timeout(LIMIT, self.0.read_line(&mut line)).await.expect("a line comes");
        let line = line.trim_end();
        (bytes.ok()? > 0).then(|| line.split_once("Z|").map_or(line, |(_, item)| item).to_owned())
    }

    async fn lines(&mut self, count: usize) -> Vec<String> {
        let mut lines = Vec::new();
        for _ in 0..count {
            lines.push(self.line().await.expect("a line"));
        }
        lines
    }

    async fn send(&mut self, text: &str) {
        self.0.get_mut().write_all(text.as_bytes()).await.unwrap();
    }
}

fn status(cycle: &str) -> serde_json::Value {
    json!({ "state": "online", "reason": null, "devices": {}, "chosen": null,
        "cycle": { "state": cycle, "run": "r-1" }, "health": { "state": "good", "parts": {} } })
}

async fn served(board: &Board) -> (SocketAddr, CancellationToken) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let (address, cancel) = (listener.local_addr().unwrap(), CancellationToken::new());
    let config = MtConnectConfig { listen: address, agents: Vec::new() };
    tokio::spawn(serve(listener, config, board.clone(), cancel.clone()));
    (address, cancel)
}

#[tokio::test]
async fn an_agent_gets_everything_once_then_what_changes_then_that_nothing_is_available() {
    let board = Board::default();
    board.set("status", &status("measuring"));
    let (address, cancel) = served(&board).await;
    let mut agent = Agent::connect(address).await;
    assert_eq!(
        agent.lines(6).await,
        [
            "avail|AVAILABLE",
            "errors|UNAVAILABLE",
            "execution|ACTIVE",
            "program|r-1",
            "system|NORMAL||||",
            "verdict||UNAVAILABLE"
        ]
    );
    agent.send("* PI").await;
    agent.send("NG\r\n").await;
    assert_eq!(agent.line().await.unwrap(), "* PONG 10000");
    // Other topics change often; what an agent has is not sent again.
    board.set("live", &json!({ "at": "now" }));
    board.set("status", &status("done"));
    assert_eq!(agent.line().await.unwrap(), "execution|PROGRAM_COMPLETED");
    cancel.cancel();
    let last = agent.lines(4).await;
    assert!(
        last.contains(&"avail|UNAVAILABLE".into()) && last.contains(&"system|UNAVAILABLE||||".into()),
        "{last:?}"
    );
    assert_eq!(agent.line().await, None);
}

#[tokio::test]
async fn a_fifth_agent_and_one_that_talks_are_let_go_and_the_others_stay() {
    let board = Board::default();
    board.set("status", &status("ready"));
    let (address, _cancel) = served(&board).await;
    let mut agents = Vec::new();
    for _ in 0..4 {
        let mut agent = Agent::connect(address).await;
        agent.lines(6).await;
        agents.push(agent);
    }
    assert_eq!(Agent::connect(address).await.line().await, None, "the fifth");
    agents[0].send(&"x".repeat(10_000)).await;
    let mut rest = Vec::new();
    // What was sent and not read makes the end of the connection a reset.
    tokio::time::timeout(LIMIT, agents[0].0.read_to_end(&mut rest)).await.unwrap().ok();
    assert_eq!(rest, b"");
    board.set("status", &status("measuring"));
    assert_eq!(agents[1].line().await.unwrap(), "execution|ACTIVE");
}

#[test]
fn other_computers_are_let_in_by_address_alone() {
    let refusal = |table: &str| {
        let text = include_str!("../../../../config/trunnion.toml");
        let text = format!("{text}\n[mtconnect]\n{table}\n");
        let parsed = Config::parse(Path::new("../../config/trunnion.toml"), &text);
        parsed.map(|config| config.mtconnect).map_err(|problems| problems.to_string())
    };
    let of_network = refusal("listen = \"0.0.0.0:7878\"").unwrap_err();
    assert!(of_network.contains("other computers") && of_network.contains("agents"), "{of_network}");
    assert!(refusal("listen = \"here\"").unwrap_err().contains("no address"));
    assert!(refusal("agents = [\"agent.plant\"]").unwrap_err().contains("no address"));
    let named = refusal("listen = \"0.0.0.0:7878\"\nagents = [\"192.168.1.20\"]").unwrap().unwrap();
    assert_eq!(named.agents, ["192.168.1.20".parse::<std::net::IpAddr>().unwrap()]);
    let usual = refusal("").unwrap().unwrap();
    assert!(usual.listen.ip().is_loopback() && usual.agents.is_empty(), "{usual:?}");
}
