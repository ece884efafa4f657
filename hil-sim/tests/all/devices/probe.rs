//! optoNCDT probes on pseudo-terminals.

use super::client::{bounded, open};
use super::floor::cell;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio_serial::SerialStream;
use trunnion_hil_sim::devices::{DeviceClock, Fault, InjectError, ScheduledFault, World};
use trunnion_hil_sim::pauses::Pauses;
use trunnion_protocol::optoncdt::command::OutputField;
use trunnion_protocol::optoncdt::{
    Block, BlockLength, Command, Decoder, Event, Layout, Reply, SensorInfo, Unwrap, distance_mm,
};

/// A host's end of the line.
struct Host {
    port: SerialStream,
    decoder: Decoder,
}

impl Host {
    async fn connect(port: &std::path::Path) -> Self {
        Self { port: open(port).await, decoder: Decoder::new(BlockLength::UntilNext) }
    }

    async fn events(&mut self) -> Vec<Event> {
        let mut buffer = [0; 4096];
        let count = bounded("reading", self.port.read(&mut buffer)).await.unwrap();
        assert_ne!(count, 0, "hung up");
        self.decoder.push(&buffer[..count])
    }

    async fn ask(&mut self, command: &Command) -> Reply {
        self.decoder.await_reply();
        self.port.write_all(&command.encode()).await.unwrap();
        loop {
            for event in self.events().await {
                if let Event::ReplyText(text) = event {
                    return Reply::parse(&text, command);
                }
            }
        }
    }

    /// Asks for counter and time stamp and starts streaming.
    async fn stream(&mut self) -> Layout {
        assert_eq!(self.ask(&Command::add_counter_and_timestamp()).await, Reply::default());
        let layout = Layout::from_reply(&self.ask(&Command::get_output_info()).await).unwrap();
        self.decoder.set_block_length(BlockLength::Exactly(layout.values_per_block()));
        assert_eq!(self.ask(&Command::output_rs422()).await, Reply::default());
        layout
    }

    async fn blocks(&mut self) -> Vec<Block> {
        let events = self.events().await;
        let block = |event| if let Event::Block(block) = event { Some(block) } else { None };
        events.into_iter().filter_map(block).collect()
    }
}

/// A test that waited longer than this let the line run over: it holds 170 ms of samples, and 50 ms are left for the rest.
const LONGEST_PAUSE: Duration = Duration::from_millis(50);
/// Attempts on a computer that pauses; one must be judged.
const ATTEMPTS: usize = 10;

/// Runs a test until one attempt was made on a computer that kept time. What needs time is judged by what it returns.
async fn on_a_computer_that_keeps_time<R>(mut attempt: impl AsyncFnMut() -> R) -> R {
    for _ in 0..ATTEMPTS {
        let pauses = Pauses::watch();
        let measured = attempt().await;
        if pauses.longest() < LONGEST_PAUSE {
            return measured;
        }
    }
    panic!("this computer paused in each of {ATTEMPTS} attempts: nothing could be judged")
}

#[tokio::test]
async fn a_probe_streams_what_the_world_shows_at_the_instants_of_its_own_clock() {
    let (steps, delays_s) = on_a_computer_that_keeps_time(async || streamed().await).await;
    assert!(steps.iter().all(|step| *step == 1), "none lost: {steps:?}");
    assert!(delays_s.iter().all(|delay_s| (0.0..0.02).contains(delay_s)), "{delays_s:?}");
    // A clock taken for exact would drift by 20 ms from the first third to the last.
    assert!((delays_s[2] - delays_s[0]).abs() < 0.008, "{delays_s:?}");
}

/// Samples from one to the next, and arrival minus sampling, the smallest of each third, s.
async fn streamed() -> (Vec<u64>, [f64; 3]) {
    let directory = tempfile::tempdir().unwrap();
    // 2 % fast, so that its rate is seen within a second and a half
    let clock = DeviceClock::steady(812.25, 20_000.0);
    let (world, cell) = cell(directory.path(), |config| config.probes[1].0.clock = clock).await;
    let mut host = Host::connect(cell.probes[1].port().unwrap()).await;
    let info = SensorInfo::parse(&host.ask(&Command::get_info()).await).unwrap();
    assert_eq!((info.range_mm, info.serial.as_str()), (2.0, "21050002"));
    assert_eq!(host.ask(&Command::new("FLY", &[])).await.error.unwrap().number, 210);
    assert_eq!(host.ask(&Command::measuring_rate_khz(2.0)).await, Reply::default());
    let rate = Command::new("MEASRATE", &[]);
    assert_eq!(host.ask(&rate).await.parameters(&rate), Some(vec!["2"]));
    let layout = host.stream().await;
    assert_eq!(
        layout.fields(),
        [OutputField::Distance, OutputField::Counter, OutputField::TimestampLow, OutputField::TimestampHigh]
    );

    let (mut ticks, mut counter) = (Unwrap::new(32), Unwrap::new(18));
    let mut last: Option<(u64, u64)> = None;
    let mut steps = Vec::new();
    let mut delays_s = [f64::INFINITY; 3];
    let begin_s = cell.origin.now_s();
    loop {
        let blocks = host.blocks().await;
        let arrival_s = cell.origin.now_s();
        let third = ((arrival_s - begin_s) / 0.5) as usize;
        if third > 2 {
            break;
        }
        for block in blocks {
            let measurement = layout.read(&block).unwrap();
            let now = (
                counter.push(measurement.counter.unwrap()),
                ticks.push(measurement.timestamp_ticks.unwrap()),
            );
            if let Some(before) = last {
                let samples = now.0 - before.0;
                assert_eq!(now.1 - before.1, 50 * samples, "a sample every 0.5 ms");
                steps.push(samples);
            }
            last = Some(now);
            let device_s = now.1 as f64 * 1e-5;
            let t_s = clock.cell_s(device_s);
            let reading_mm = distance_mm(measurement.distance.unwrap(), 2.0).unwrap() - 1.0;
            // Half a step of 31 nm, and what the reading moves in a tick
            let error_mm = reading_mm - world.probe_readings_mm(t_s)[1];
            assert!(error_mm.abs() < 18e-6, "{error_mm} mm at {t_s} s");
            delays_s[third] = delays_s[third].min(arrival_s - t_s);
        }
    }
    assert_eq!(host.decoder.counts().dropped_bytes, 0);
    cell.shutdown().await;
    (steps, delays_s)
}

#[tokio::test]
async fn a_pulled_cable_hangs_up_and_the_port_comes_back_under_its_name() {
    let directory = tempfile::tempdir().unwrap();
    let (_, cell) = cell(directory.path(), |_| {}).await;
    let port = cell.probes[0].port().unwrap().to_owned();
    let mut host = Host::connect(&port).await;
    host.stream().await;
    let first = std::fs::read_link(&port).unwrap();
    cell.probes[0].inject(Fault::Unplug { duration_s: 0.3 }).unwrap();
    let mut buffer = [0; 4096];
    bounded("the end of the line", async {
        while !matches!(host.port.read(&mut buffer).await, Ok(0) | Err(_)) {}
    })
    .await;
    assert!(!port.exists() && !port.is_symlink(), "the port is gone while the cable is pulled");
    let mut host = Host::connect(&port).await;
    // The probe kept its supply and its settings: it still streams.
    let stop = host.ask(&Command::output_none()).await;
    assert_eq!(stop.error, None);
    assert!(host.decoder.counts().blocks > 0 || cell.probes[0].lost_bytes() > 0);
    assert!(std::fs::read_link(&port).unwrap().starts_with("/dev/pts") && first.starts_with("/dev/pts"));
    cell.shutdown().await;
    assert!(!port.is_symlink(), "a device switched off leaves no port behind");
}

#[tokio::test]
async fn garbage_and_silence_are_seen_by_the_host_and_end() {
    let gap = on_a_computer_that_keeps_time(async || silenced().await).await;
    // 1 kHz, and the deliveries are 4 ms apart.
    assert!((190..300).contains(&gap), "{gap}");
}

/// Samples missing in a silence of 0.2 s.
async fn silenced() -> u64 {
    let directory = tempfile::tempdir().unwrap();
    let at_once = ScheduledFault { at_s: 0.0, fault: Fault::GarbleBytes { count: 1000 } };
    let (_, cell) = cell(directory.path(), |config| {
        config.probes[2].0.streams_at_start = true;
        config.probes[2].1.push(at_once);
    })
    .await;
    let mut host = Host::connect(cell.probes[2].port().unwrap()).await;
    while host.decoder.counts().blocks < 400 {
        host.blocks().await;
    }
    assert!(host.decoder.counts().dropped_bytes > 0, "{:?}", host.decoder.counts());
    let layout = host.stream().await;
    let mut counter = Unwrap::new(18);
    let mut gaps = Vec::new();
    let mut last = None;
    let mut silenced = false;
    for _ in 0..2000 {
        if !gaps.is_empty() {
            break;
        }
        if last.is_some() && !silenced {
            cell.probes[2].inject(Fault::Silence { duration_s: 0.2 }).unwrap();
            silenced = true;
        }
        for block in host.blocks().await {
            let now = counter.push(layout.read(&block).unwrap().counter.unwrap());
            gaps.extend(last.map(|last| now - last).filter(|step| *step > 1));
            last = Some(now);
        }
    }
    assert!(cell.probes[2].lost_bytes() > 0);
    let impossible = Fault::AgentRestart;
    assert_eq!(cell.probes[2].inject(impossible), Err(InjectError::NotPossible(impossible)));
    cell.shutdown().await;
    gaps[0]
}

#[tokio::test]
async fn a_host_that_comes_late_finds_no_old_samples() {
    let directory = tempfile::tempdir().unwrap();
    let (_, cell) = cell(directory.path(), |config| config.probes[0].0.streams_at_start = true).await;
    let clock = trunnion_hil_sim::devices::cell::CellConfig::new(directory.path(), 0).probes[0].0.clock;
    // Nobody reads until the line has thrown something away.
    bounded("overrun", async {
        while cell.probes[0].lost_bytes() == 0 {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    })
    .await;
    let opened_s = cell.origin.now_s();
    let mut host = Host::connect(cell.probes[0].port().unwrap()).await;
    host.decoder.set_block_length(BlockLength::UntilNext);
    let layout = host.stream().await;
    let measurement = layout.read(&host.blocks_some().await[0]).unwrap();
    let t_s = clock.cell_s(f64::from(measurement.timestamp_ticks.unwrap()) * 1e-5);
    assert!(t_s > opened_s - 1.5, "sample of {t_s} s read by a host that came at {opened_s} s");
    cell.shutdown().await;
}

impl Host {
    async fn blocks_some(&mut self) -> Vec<Block> {
        loop {
            let blocks = self.blocks().await;
            if !blocks.is_empty() {
                return blocks;
            }
        }
    }
}
