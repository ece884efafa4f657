//! A connection to the broker that is kept: back-off, what is logged of a failure, and the last words.
//!
//! One task polls the connection. Publishing never waits for the broker: what it has no room for is sent later, as its value is then. A
//! connection counts once the broker has answered what we say: one that lets us in and then reads nothing has none of our values.

use super::broker::Broker;
use super::tls;
use crate::board::Board;
use rumqttc::{
    AsyncClient, ConnectReturnCode, ConnectionError, Event, EventLoop, LastWill, MqttOptions, Packet,
    Publish, StateError,
};
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use tracing::{info, warn};
use trunnion_acquire::credentials;

/// First and longest wait before connecting again.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(250), Duration::from_secs(30));
/// How long the farewell may take.
const FAREWELL: Duration = Duration::from_secs(2);
/// Messages the client may hold; only latest values are queued, so this bounds the number of topics.
const QUEUE: usize = 256;
/// Largest message either way, bytes. The library's own limit of 10 kB is less than the status of a machine with many devices, and ends
/// the connection.
const MOST_BYTES: usize = 1 << 20;

/// What is said over a connection.
pub(super) trait Speaker {
    /// The part of the service's health that says how this connection does.
    const PART: &'static str;
    /// Who we are for the broker.
    fn client_id(&self) -> String;
    /// What the broker says when we are lost; for one CONNECT.
    fn last_will(&mut self) -> LastWill;
    /// The broker has nothing of us: subscribes.
    fn connected(&mut self, client: &AsyncClient);
    /// Takes what the broker sends.
    fn received(&mut self, message: &Publish);
    /// Takes an answer of the broker to what we said: whether it shows that the broker reads us.
    fn answered(&mut self, answer: &Packet) -> bool;
    /// Queues what the broker does not have; what does not fit waits for the next answer, change or connection.
    fn publish(&mut self, client: &AsyncClient);
    /// Queues the last words; how many acknowledgements are then to come, `None` when they do not fit.
    fn farewell(&mut self, client: &AsyncClient) -> Option<usize>;
}

/// Keeps a connection until `cancel`.
pub(super) async fn keep<S: Speaker>(
    broker: &Broker,
    mut speaker: S,
    board: &Board,
    cancel: &CancellationToken,
) {
    let mut connection = Connection { part: S::PART, stage: Stage::Down, last: None };
    let mut wait = BACK_OFF.0;
    board.set_connection(S::PART, "not reached yet");
    let (client, mut events) = loop {
        match begin(broker, &mut speaker) {
            Ok(begun) => break begun,
            Err(why) => connection.failed(broker, board, &why),
        }
        tokio::select! {
            () = cancel.cancelled() => return,
            () = tokio::time::sleep(wait) => wait = (wait * 2).min(BACK_OFF.1),
        }
    };
    let mut changes = board.changes();
    loop {
        tokio::select! {
            biased;
            () = cancel.cancelled() => break,
            event = events.poll() => match event {
                Ok(Event::Incoming(Packet::ConnAck(_))) => {
                    connection.stage = Stage::LetIn;
                    speaker.connected(&client);
                    speaker.publish(&client);
                }
                Ok(Event::Incoming(Packet::Publish(message))) => {
                    speaker.received(&message);
                    speaker.publish(&client);
                }
                // An acknowledgement frees the queue for what did not fit.
                Ok(Event::Incoming(answer @ (Packet::PubAck(_) | Packet::SubAck(_)))) => {
                    if speaker.answered(&answer) && connection.stage != Stage::Answers {
                        wait = BACK_OFF.0;
                        connection.succeeded(broker, board);
                    }
                    speaker.publish(&client);
                }
                Ok(_) => {}
                Err(error) => {
                    if connection.stage != Stage::Down || may_have_sent_connect(&error) {
                        events.mqtt_options.set_last_will(speaker.last_will());
                    }
                    // The file of a password or a certificate may have been mended.
                    let mended = log_in(broker, &mut events.mqtt_options);
                    let why = mended.err().unwrap_or_else(|| cause(&error, connection.stage));
                    connection.failed(broker, board, &why);
                    tokio::select! {
                        () = cancel.cancelled() => break,
                        () = tokio::time::sleep(wait) => wait = (wait * 2).min(BACK_OFF.1),
                    }
                }
            },
            // The board is ours: its changes do not end.
            _ = changes.changed(), if connection.stage != Stage::Down => speaker.publish(&client),
        }
    }
    if connection.stage != Stage::Down
        && tokio::time::timeout(FAREWELL, farewell(&client, &mut events, &mut speaker)).await.is_err()
    {
        warn!("the MQTT broker did not take the farewell in time; its last will says offline");
    }
}

/// How far we are with the broker.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// No connection.
    Down,
    /// It let us in (CONNACK).
    LetIn,
    /// It answered what we said.
    Answers,
}

/// How far it is, and what was logged of a broker that cannot be reached: each cause once.
struct Connection {
    part: &'static str,
    stage: Stage,
    last: Option<String>,
}

impl Connection {
    fn succeeded(&mut self, broker: &Broker, board: &Board) {
        info!(host = broker.host, port = broker.port, part = self.part, "connected to the MQTT broker");
        board.set_connection(self.part, "");
        (self.stage, self.last) = (Stage::Answers, None);
    }

    fn failed(&mut self, broker: &Broker, board: &Board, why: &str) {
        board.set_connection(self.part, why);
        let was_up = std::mem::replace(&mut self.stage, Stage::Down) == Stage::Answers;
        if self.last.as_deref() == Some(why) {
            return;
        }
        let (host, port, part) = (&broker.host, broker.port, self.part);
        let what = if was_up { "lost the MQTT broker" } else { "cannot reach the MQTT broker" };
        warn!(host, port, part, "{what}: {why}; measuring goes on, status is sent when it is there");
        self.last = Some(why.into());
    }
}

/// The failure in words, with what to do where a person can do something.
fn cause(error: &ConnectionError, stage: Stage) -> String {
    match error {
        ConnectionError::Tls(error) => tls::cause(error),
        ConnectionError::ConnectionRefused(
            ConnectReturnCode::BadUserNamePassword | ConnectReturnCode::NotAuthorized,
        ) => "it does not let this user in; check `user` and `password_file` of [mqtt], and the rights of the user".into(),
        ConnectionError::MqttState(StateError::AwaitPingResp) | ConnectionError::FlushTimeout => {
            let what = match stage {
                Stage::Answers => "it answers no more",
                Stage::LetIn | Stage::Down => "it takes the connection, but answers nothing after that",
            };
            format!("{what}; look at the broker's log, the load of its computer, and the network")
        }
        ConnectionError::NetworkTimeout => {
            "it does not answer; check `host` and `port` of [mqtt], the network, and the broker's log".into()
        }
        ConnectionError::MqttState(StateError::ConnectionAborted) => "it closed the connection".into(),
        ConnectionError::MqttState(StateError::Io(error)) | ConnectionError::Io(error) => error.to_string(),
        other => other.to_string(),
    }
}

/// Without a socket, or without encryption, no CONNECT was sent.
fn may_have_sent_connect(error: &ConnectionError) -> bool {
    !matches!(error, ConnectionError::Io(_) | ConnectionError::Tls(_))
}

fn begin(broker: &Broker, speaker: &mut impl Speaker) -> Result<(AsyncClient, EventLoop), String> {
    let mut options = MqttOptions::new(speaker.client_id(), &broker.host, broker.port);
    options.set_keep_alive(broker.keep_alive);
    options.set_max_packet_size(MOST_BYTES, MOST_BYTES);
    log_in(broker, &mut options)?;
    options.set_last_will(speaker.last_will());
    Ok(AsyncClient::new(options, QUEUE))
}

/// Who we are, as the files say now.
fn log_in(broker: &Broker, options: &mut MqttOptions) -> Result<(), String> {
    if let Some((user, password)) = &broker.login {
        options.set_credentials(user, password.as_ref().map_or(Ok(String::new()), credentials::value)?);
    }
    if let Some(tls) = &broker.tls {
        options.set_transport(tls.transport()?);
    }
    Ok(())
}

async fn farewell(client: &AsyncClient, events: &mut EventLoop, speaker: &mut impl Speaker) {
    let Some(mut under_way) = speaker.farewell(client) else { return };
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
