//! The ball bar behind its slcan adapter.

use super::client::{bounded, open};
use super::floor::cell;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio_serial::SerialStream;
use trunnion_hil_sim::devices::canopen::BusConfig;
use trunnion_hil_sim::devices::{DeviceClock, Fault, World};
use trunnion_protocol::can::CanFrame;
use trunnion_protocol::canopen::cia404::Quantity;
use trunnion_protocol::canopen::network::sync_frame;
use trunnion_protocol::canopen::{
    Message, NmtCommand, NmtState, NodeDescription, NodeId, NodeStartup, Profile, StartupProgress, Value,
};
use trunnion_protocol::slcan::{AdapterMessage, Bitrate, HostCommand, HostDecoder};

struct Host {
    port: SerialStream,
    decoder: HostDecoder,
    waiting: std::collections::VecDeque<AdapterMessage>,
}

impl Host {
    async fn connect(port: &std::path::Path) -> Self {
        let mut host =
            Self { port: open(port).await, decoder: HostDecoder::default(), waiting: Default::default() };
        for command in
            [HostCommand::SetBitrate(Bitrate::K1000), HostCommand::TimeStamps(true), HostCommand::Open]
        {
            host.say(command).await;
            assert_eq!(host.message().await, AdapterMessage::Done);
        }
        host
    }

    async fn say(&mut self, command: HostCommand) {
        self.port.write_all(&command.encode()).await.unwrap();
    }

    async fn send(&mut self, frame: CanFrame) {
        self.say(HostCommand::Transmit(frame)).await;
    }

    async fn message(&mut self) -> AdapterMessage {
        let mut buffer = [0; 1024];
        while self.waiting.is_empty() {
            let count = bounded("reading", self.port.read(&mut buffer)).await.unwrap();
            assert_ne!(count, 0, "hung up");
            self.waiting.extend(self.decoder.push(&buffer[..count]));
        }
        self.waiting.pop_front().unwrap()
    }

    async fn frame(&mut self) -> CanFrame {
        loop {
            if let AdapterMessage::Frame { frame, stamp_ms } = self.message().await {
                assert!(stamp_ms.is_some());
                return frame;
            }
        }
    }

    async fn describe(&mut self, node: NodeId) -> NodeDescription {
        let (mut startup, request) = NodeStartup::new(node);
        self.send(request).await;
        loop {
            let frame = self.frame().await;
            match startup.on_frame(&frame) {
                StartupProgress::NotMine => {}
                StartupProgress::Send(request) => self.send(request).await,
                StartupProgress::Done(description) => return *description,
                StartupProgress::Failed { error, .. } => panic!("{error}"),
            }
        }
    }

    /// The first value of the next frame of this TPDO.
    async fn value_mm(&mut self, node: &NodeDescription, tpdo: usize) -> f64 {
        loop {
            let frame = self.frame().await;
            if frame.id() == node.tpdos[tpdo].communication.can_id() {
                let readings = node.decode(&frame).unwrap().unwrap();
                let Value::Quantity(Quantity::LengthMm(mm)) = readings[0].value else {
                    panic!("{readings:?}")
                };
                return mm;
            }
        }
    }
}

#[tokio::test]
async fn a_ball_bar_reports_its_mapping_goes_operational_and_answers_sync() {
    let directory = tempfile::tempdir().unwrap();
    let (world, cell) = cell(directory.path(), |_| {}).await;
    let mut host = Host::connect(cell.can.as_ref().unwrap().port().unwrap()).await;
    let id = NodeId::new(5).unwrap();
    let node = host.describe(id).await;
    assert_eq!((node.profile(), node.identity.serial), (Profile::Encoder, Some(4711)));
    assert_eq!(node.tpdos.len(), 2);
    assert_eq!(node.synchronous_tpdos().map(|tpdo| tpdo.number).collect::<Vec<_>>(), [2]);
    host.send(NmtCommand::Start.frame(Some(id))).await;
    loop {
        let frame = host.frame().await;
        if Message::from_frame(&frame) == Some(Message::Heartbeat(id, NmtState::Operational)) {
            break;
        }
    }
    // The bar grows: a value taken between two instants lies between their values.
    for _ in 0..50 {
        let before_s = cell.origin.now_s();
        host.send(sync_frame(None)).await;
        let bar_mm = host.value_mm(&node, 1).await - 10.0;
        let after_s = cell.origin.now_s();
        // One step of 100 nm and five sigma of the noise
        let slack_mm = 0.0001 + 0.0025;
        let (low, high) = (world.true_bar_mm(before_s), world.true_bar_mm(after_s));
        assert!((low - slack_mm..=high + slack_mm).contains(&bar_mm), "{low} {bar_mm} {high}");
    }
    // By its event timer it sends on its own, on instants 10 ms apart.
    let begin_s = cell.origin.now_s();
    for _ in 0..20 {
        let bar_mm = host.value_mm(&node, 0).await - 10.0;
        assert!(bar_mm < world.true_bar_mm(cell.origin.now_s()) + 0.0026);
    }
    assert!(cell.origin.now_s() - begin_s > 0.15, "20 event timers of 10 ms");
    cell.shutdown().await;
}

#[tokio::test]
async fn one_sync_latches_three_probes_and_an_adapter_plugged_in_again_is_closed() {
    let directory = tempfile::tempdir().unwrap();
    let (world, cell) = cell(directory.path(), |config| {
        config.can = Some((BusConfig::ball_bar_and_probes(DeviceClock::steady(9.0, 40.0)), Vec::new()));
    })
    .await;
    let bus = cell.can.as_ref().unwrap();
    let mut host = Host::connect(bus.port().unwrap()).await;
    let mut nodes = Vec::new();
    for id in 1..=3 {
        nodes.push(host.describe(NodeId::new(id).unwrap()).await);
    }
    host.send(NmtCommand::Start.frame(None)).await;
    let before_s = cell.origin.now_s();
    host.send(sync_frame(None)).await;
    let mut readings_mm = [None; 3];
    while readings_mm.contains(&None) {
        let frame = host.frame().await;
        for (reading, node) in readings_mm.iter_mut().zip(&nodes) {
            if let Some(Ok(values)) = node.decode(&frame) {
                let Value::Quantity(Quantity::LengthMm(mm)) = values[0].value else { panic!("{values:?}") };
                *reading = Some(mm);
            }
        }
    }
    let after_s = cell.origin.now_s();
    // The world at the one instant that explains the first probe's noise explains the other two.
    let readings_mm = readings_mm.map(Option::unwrap);
    let fits = |t_s: f64| {
        let world_mm = world.probe_readings_mm(t_s);
        (0..3).all(|k| (world_mm[k] - readings_mm[k]).abs() < 6e-6)
    };
    let instants = ((after_s - before_s) * 1e6) as u32 + 2;
    assert!((0..instants).any(|k| fits(before_s + f64::from(k) * 1e-6)), "{readings_mm:?}");

    bus.inject(Fault::Unplug { duration_s: 0.05 }).unwrap();
    let mut buffer = [0; 1024];
    bounded("the end of the line", async {
        while !matches!(host.port.read(&mut buffer).await, Ok(0) | Err(_)) {}
    })
    .await;
    let mut host = Host::connect(bus.port().unwrap()).await;
    // The nodes kept their supply: they are still operational.
    host.send(sync_frame(None)).await;
    host.value_mm(&nodes[0], 0).await;
    cell.shutdown().await;
}
