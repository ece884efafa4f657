//! The simulator's nodes on a CAN interface.

use crate::way::Way;
use anyhow::Context;
use socketcan::{
    CanErrorFrame, CanFilter, CanSocket, EmbeddedFrame, ExtendedId, Frame, Id, Socket, SocketOptions,
    StandardId,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};
use trunnion_core::AxisValues;
use trunnion_hil_sim::devices::canopen::{BusConfig, Nodes};
use trunnion_hil_sim::devices::{DeviceClock, SimulatedCell, TimeOrigin};
use trunnion_hil_sim::motion::{Program, Step, Trajectory};
use trunnion_protocol::can::{CanFrame, CanId};
use trunnion_protocol::canopen::{NmtCommand, NodeId};

/// What a controller of a node lets through: NMT, SYNC, SDO requests.
const COMMANDS: [(u32, u32); 3] = [(0x000, 0x7FF), (0x080, 0x7FF), (0x600, 0x780)];
/// A stamp that seems older is one from before the wall clock was set, s.
const LONGEST_AGE_S: f64 = 1.0;

/// A thread that lets the nodes hear and speak.
pub struct SimulatedBus {
    interface: String,
    shared: Arc<Shared>,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<anyhow::Result<()>>,
}

struct Shared {
    nodes: Mutex<Nodes>,
    way: Mutex<Way>,
}

impl Shared {
    fn nodes(&self) -> MutexGuard<'_, Nodes> {
        self.nodes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn way(&self) -> MutexGuard<'_, Way> {
        self.way.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl SimulatedBus {
    /// Switches the usual nodes on.
    pub fn start(interface: &str) -> anyhow::Result<Self> {
        Self::start_nodes(interface, nodes(&usual()), TimeOrigin(tokio::time::Instant::now()))
    }

    /// Switches nodes on.
    pub fn start_nodes(interface: &str, nodes: Nodes, origin: TimeOrigin) -> anyhow::Result<Self> {
        let socket = CanSocket::open(interface).with_context(|| format!("opening {interface}"))?;
        let shared = Arc::new(Shared { nodes: Mutex::new(nodes), way: Mutex::default() });
        let (of_thread, stop) = (Arc::clone(&shared), Arc::new(AtomicBool::new(false)));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || serve(&socket, origin, &of_thread, &stopped));
        Ok(Self { interface: interface.into(), shared, stop, thread })
    }

    /// One node loses its supply.
    pub fn switch_off(&self, id: u8) {
        self.shared.nodes().switch_off(number(id));
    }

    /// All nodes are switched on again.
    pub fn restart(&self) {
        *self.shared.nodes() = nodes(&usual());
    }

    /// A node of another serial number takes the place of one.
    pub fn exchange(&self, id: u8, serial: u32) {
        let mut bus = usual();
        bus.nodes.iter_mut().filter(|node| node.id == number(id)).for_each(|node| node.serial = serial);
        *self.shared.nodes() = nodes(&bus);
        self.reset(id);
    }

    /// One node begins again by itself, and says so.
    pub fn reset(&self, id: u8) {
        let mut nodes = self.shared.nodes();
        let boot_up = nodes.on_frame(&NmtCommand::ResetNode.frame(Some(number(id))), 0.0);
        self.shared.way().owe(boot_up);
    }

    /// What happens to the frames of the nodes from now on.
    pub fn set_way(&self, change: impl FnOnce(&mut Way)) {
        change(&mut self.shared.way());
    }

    /// A driver of a CAN card reports an error of the bus.
    pub fn report(&self, error: u32, data: [u8; 8]) -> anyhow::Result<()> {
        let frame = CanErrorFrame::new_error(error, &data)?;
        self.socket()?.write_frame(&frame).context("sending an error frame")
    }

    /// Somebody else on the bus sends a frame.
    pub fn send(&self, frame: &CanFrame) -> anyhow::Result<()> {
        self.socket()?.write_frame(&to_kernel(frame)).context("sending a frame")
    }

    /// A socket of somebody else.
    pub fn socket(&self) -> anyhow::Result<CanSocket> {
        CanSocket::open(&self.interface).with_context(|| format!("opening {}", self.interface))
    }

    /// Switches off. The thread may have ended with its interface.
    pub fn stop(self) -> anyhow::Result<()> {
        self.stop.store(true, Ordering::Relaxed);
        match self.thread.join() {
            Ok(ended) => {
                if let Err(error) = ended {
                    println!("the simulated bus ended: {error:#}");
                }
                Ok(())
            }
            Err(_) => anyhow::bail!("the simulated bus panicked"),
        }
    }
}

fn number(id: u8) -> NodeId {
    NodeId::new(id).expect("a node number")
}

fn usual() -> BusConfig {
    BusConfig::ball_bar_and_probes(DeviceClock::default())
}

fn nodes(config: &BusConfig) -> Nodes {
    let program = Program { start: AxisValues::default(), steps: vec![Step::Dwell { duration_s: 1e5 }] };
    let world = SimulatedCell {
        deflection_mm: Box::new(|_| [0.1, 0.0, 0.0]),
        bar_mm: Box::new(|_| 0.5),
        ..SimulatedCell::along(Trajectory::compile(&program).expect("a dwell is possible"))
    };
    Nodes::new(Arc::new(world), config).expect("the settings are possible")
}

/// A frame is heard when the interrupt of the nodes' own controller took it, as the kernel stamps it: a node in a program
/// wakes up later than one of hardware.
fn serve(socket: &CanSocket, origin: TimeOrigin, shared: &Shared, stop: &AtomicBool) -> anyhow::Result<()> {
    socket.set_recv_timestamp(true)?;
    socket.set_filters(&COMMANDS.map(|(id, mask)| CanFilter::new(id, mask)))?;
    while !stop.load(Ordering::Relaxed) {
        let due_s = [shared.nodes().next_due_s(), shared.way().next_due_s()];
        let due_s = due_s.into_iter().flatten().min_by(f64::total_cmp);
        let wait_s = due_s.map_or(0.05, |due_s| due_s - origin.now_s()).clamp(0.0002, 0.05);
        socket.set_read_timeout(Duration::from_secs_f64(wait_s))?;
        let heard = match socket.read_frame_with_timestamp() {
            Ok((frame, stamp)) => from_kernel(&frame).map(|frame| (frame, origin.now_s() - age_s(stamp))),
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => None,
            // The interface went down; it may come back.
            Err(error) if error.raw_os_error() == Some(100) => None,
            Err(error) => return Err(error).context("reading"),
        };
        let frames = {
            let mut nodes = shared.nodes();
            let mut frames = heard.map_or_else(Vec::new, |(frame, at_s)| nodes.on_frame(&frame, at_s));
            frames.extend(nodes.frames_due(origin.now_s()));
            shared.way().take(frames, origin.now_s())
        };
        for frame in frames {
            if let Err(error) = socket.write_frame_insist(&to_kernel(&frame)) {
                // Nobody hears nodes on an interface that is down.
                anyhow::ensure!(matches!(error.raw_os_error(), Some(100 | 105)), "writing: {error}");
            }
        }
    }
    Ok(())
}

/// How long ago a stamp was, s; none where the wall clock was set in between.
fn age_s(stamp: SystemTime) -> f64 {
    let age_s = stamp.elapsed().unwrap_or_default().as_secs_f64();
    if age_s < LONGEST_AGE_S { age_s } else { 0.0 }
}

fn from_kernel(frame: &socketcan::CanFrame) -> Option<CanFrame> {
    let socketcan::CanFrame::Data(data) = frame else { return None };
    let id = match u16::try_from(data.raw_id()) {
        Ok(id) if !data.is_extended() => CanId::Standard(id),
        _ => CanId::Extended(data.raw_id()),
    };
    CanFrame::data_frame(id, data.data()).ok()
}

fn to_kernel(frame: &CanFrame) -> socketcan::CanFrame {
    let id: Id = match frame.id() {
        CanId::Standard(id) => StandardId::new(id).expect("11 bits").into(),
        CanId::Extended(id) => ExtendedId::new(id).expect("29 bits").into(),
    };
    socketcan::CanFrame::new(id, frame.data()).expect("at most eight bytes")
}
