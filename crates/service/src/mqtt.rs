//! Plant status over MQTT: plain JSON topics with retained state and a last will (docs/design/protocols.md §5).
//!
//! One task polls the connection. Publishing never waits for the broker: each topic keeps its latest value, and every
//! latest value is sent again after each CONNACK, because a broker that forgot the session drops what
//! was pending. History lives in the recording, not here.

mod tls;

pub use tls::MqttTls;

use crate::board::{Board, offline};
use rumqttc::{
    AsyncClient, ConnectReturnCode, ConnectionError, Event, EventLoop, LastWill, MqttOptions, Packet, QoS,
};
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use tracing::{info, warn};
use trunnion_acquire::credentials;
use trunnion_core::Secret;

/// How to reach the broker.
#[derive(Clone, Debug, PartialEq)]
pub struct MqttConfig {
    /// Host name or address.
    pub host: String,
    /// TCP port.
    pub port: u16,
    /// Machine name in the topics.
    pub machine: String,
    /// User, and password if the broker asks for one.
    pub login: Option<(String, Option<Secret>)>,
    /// Encryption; none without.
    pub tls: Option<MqttTls>,
}

/// First and longest wait before connecting again.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(30));
/// How long the farewell may take.
const FAREWELL: Duration = Duration::from_secs(2);
/// Messages the client may hold; only latest values are queued, so this bounds the number of topics.
const QUEUE: usize = 64;

/// Runs until `cancel`; connects, keeps the retained topics current, reconnects with back-off.
pub async fn run(config: MqttConfig, board: Board, cancel: CancellationToken) {
    let mut failures = Failures::default();
    let mut wait = BACK_OFF.0;
    board.set_connection("broker", "not reached yet");
    let (client, mut events) = loop {
        match connect(&config) {
            Ok(connection) => break connection,
            Err(why) => {
                failures.tell(&config, false, &why);
                board.set_connection("broker", &why);
            }
        }
        tokio::select! {
            () = cancel.cancelled() => return,
            () = tokio::time::sleep(wait) => wait = (wait * 2).min(BACK_OFF.1),
        }
    };
    let mut connected = false;
    loop {
        tokio::select! {
            biased;
            () = cancel.cancelled() => break,
            event = events.poll() => match event {
                Ok(Event::Incoming(Packet::ConnAck(_))) => {
                    info!(host = config.host, port = config.port, "connected to the MQTT broker");
                    (connected, wait, failures) = (true, BACK_OFF.0, Failures::default());
                    board.set_connection("broker", "");
                    board.forget_what_was_sent();
                    if let Err(error) = client.try_subscribe(choose_topic(&config), QoS::AtLeastOnce) {
                        warn!(%error, "the broker was not asked for choices of a cycle");
                    }
                    publish_news(&client, &config, &board);
                }
                // A retained choice was meant for a cycle that is long over.
                Ok(Event::Incoming(Packet::Publish(choice)))
                    if choice.topic == choose_topic(&config) && !choice.retain =>
                {
                    let cycle = String::from_utf8_lossy(&choice.payload);
                    info!(?cycle, "the operator chose");
                    board.operator().choose(&cycle);
                }
                // An acknowledgement frees the queue for what did not fit.
                Ok(Event::Incoming(Packet::PubAck(_))) => publish_news(&client, &config, &board),
                Ok(_) => {}
                Err(error) => {
                    // The file of a password or a certificate may have been mended.
                    let why = log_in(&config, &mut events.mqtt_options).err().unwrap_or_else(|| cause(&error));
                    failures.tell(&config, connected, &why);
                    board.set_connection("broker", &why);
                    connected = false;
                    tokio::select! {
                        () = cancel.cancelled() => break,
                        () = tokio::time::sleep(wait) => wait = (wait * 2).min(BACK_OFF.1),
                    }
                }
            },
            () = board.changed(), if connected => publish_news(&client, &config, &board),
        }
    }
    if connected
        && tokio::time::timeout(FAREWELL, farewell(&client, &mut events, &config, &board)).await.is_err()
    {
        warn!("the MQTT broker did not take the farewell in time; its last will says offline");
    }
}

/// What was logged of a broker that cannot be reached: each cause once.
#[derive(Default)]
struct Failures {
    last: Option<String>,
}

impl Failures {
    fn tell(&mut self, config: &MqttConfig, was_connected: bool, why: &str) {
        if self.last.as_deref() == Some(why) {
            return;
        }
        let (host, port) = (&config.host, config.port);
        let what = if was_connected { "lost the MQTT broker" } else { "cannot reach the MQTT broker" };
        warn!(host, port, "{what}: {why}; measuring goes on, status is sent when it is there");
        self.last = Some(why.into());
    }
}

/// The failure in words, with what to do where a person can do something.
fn cause(error: &ConnectionError) -> String {
    match error {
        ConnectionError::Tls(error) => tls::cause(error),
        ConnectionError::ConnectionRefused(
            ConnectReturnCode::BadUserNamePassword | ConnectReturnCode::NotAuthorized,
        ) => "it does not let this user in; check `user` and `password_file` of [mqtt], and the rights of the user".into(),
        ConnectionError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

fn connect(config: &MqttConfig) -> Result<(AsyncClient, EventLoop), String> {
    let mut options = MqttOptions::new(
        format!("trunnion-{}-{}", config.machine, std::process::id()),
        &config.host,
        config.port,
    );
    options.set_keep_alive(Duration::from_secs(10));
    options.set_last_will(LastWill::new(status_topic(config), offline("lost"), QoS::AtLeastOnce, true));
    log_in(config, &mut options)?;
    Ok(AsyncClient::new(options, QUEUE))
}

/// Who we are, as the files say now.
fn log_in(config: &MqttConfig, options: &mut MqttOptions) -> Result<(), String> {
    if let Some((user, password)) = &config.login {
        options.set_credentials(user, password.as_ref().map_or(Ok(String::new()), credentials::value)?);
    }
    if let Some(tls) = &config.tls {
        options.set_transport(tls.transport()?);
    }
    Ok(())
}

/// Queues every value the broker does not have; what does not fit waits for the next change or connection.
fn publish_news(client: &AsyncClient, config: &MqttConfig, board: &Board) {
    for (name, topic) in board.lock().iter_mut().filter(|(_, topic)| !topic.sent) {
        let full = format!("trunnion/{}/{name}", config.machine);
        match client.try_publish(full, QoS::AtLeastOnce, true, topic.stamped.clone()) {
            Ok(()) => topic.sent = true,
            Err(error) => {
                warn!(%error, topic = name, "MQTT queue is full; the latest value is kept and sent later");
                return;
            }
        }
    }
}

async fn farewell(client: &AsyncClient, events: &mut EventLoop, config: &MqttConfig, board: &Board) {
    let mut under_way = 0;
    for (name, value) in board.farewell() {
        let topic = format!("trunnion/{}/{name}", config.machine);
        if client.try_publish(topic, QoS::AtLeastOnce, true, value).is_err() {
            return;
        }
        under_way += 1;
    }
    while let Ok(event) = events.poll().await {
        under_way -= usize::from(matches!(event, Event::Incoming(Packet::PubAck(_))));
        if under_way == 0 {
            break;
        }
    }
    if client.try_disconnect().is_ok() {
        while events.poll().await.is_ok() {}
    }
}

fn choose_topic(config: &MqttConfig) -> String {
    format!("trunnion/{}/choose", config.machine)
}

fn status_topic(config: &MqttConfig) -> String {
    format!("trunnion/{}/status", config.machine)
}
