//! The simulator's nodes on a CAN interface.

use anyhow::Context;
use socketcan::{
    CanErrorFrame, CanSocket, EmbeddedFrame, ExtendedId, Frame, Id, Socket, SocketOptions, StandardId,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};
use trunnion_core::AxisValues;
use trunnion_hil_sim::devices::canopen::{BusConfig, Nodes};
use trunnion_hil_sim::devices::{DeviceClock, SimulatedCell, TimeOrigin};
use trunnion_hil_sim::motion::{Program, Step, Trajectory};
use trunnion_protocol::can::{CanFrame, CanId};
use trunnion_protocol::canopen::NodeId;

/// A stamp that seems older is one from before the wall clock was set, s.
const LONGEST_AGE_S: f64 = 1.0;

/// A thread that lets the nodes hear and speak.
pub struct SimulatedBus {
    interface: String,
    nodes: Arc<Mutex<Nodes>>,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<anyhow::Result<()>>,
}

impl SimulatedBus {
    /// Switches the usual nodes on.
    pub fn start(interface: &str) -> anyhow::Result<Self> {
        Self::start_nodes(interface, nodes(), TimeOrigin(tokio::time::Instant::now()))
    }

    /// Switches nodes on.
    pub fn start_nodes(interface: &str, nodes: Nodes, origin: TimeOrigin) -> anyhow::Result<Self> {
        let socket = CanSocket::open(interface).with_context(|| format!("opening {interface}"))?;
        let (nodes, stop) = (Arc::new(Mutex::new(nodes)), Arc::new(AtomicBool::new(false)));
        let (of_thread, stopped) = (Arc::clone(&nodes), Arc::clone(&stop));
        let thread = std::thread::spawn(move || serve(&socket, origin, &of_thread, &stopped));
        Ok(Self { interface: interface.into(), nodes, stop, thread })
    }

    /// One node loses its supply.
    pub fn switch_off(&self, id: u8) {
        let id = NodeId::new(id).expect("a node number");
        self.nodes.lock().unwrap_or_else(PoisonError::into_inner).switch_off(id);
    }

    /// All nodes are switched on again.
    pub fn restart(&self) {
        *self.nodes.lock().unwrap_or_else(PoisonError::into_inner) = nodes();
    }

    /// What a driver reports when its controller goes bus-off.
    pub fn report_bus_off(&self) -> anyhow::Result<()> {
        let socket = CanSocket::open(&self.interface)?;
        let error = CanErrorFrame::new_error(socketcan::errors::CAN_ERR_BUSOFF, &[0; 8])?;
        socket.write_frame(&error).context("sending an error frame")
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

fn nodes() -> Nodes {
    let program = Program { start: AxisValues::default(), steps: vec![Step::Dwell { duration_s: 1e5 }] };
    let world = SimulatedCell {
        deflection_mm: Box::new(|_| [0.1, 0.0, 0.0]),
        bar_mm: Box::new(|_| 0.5),
        ..SimulatedCell::along(Trajectory::compile(&program).expect("a dwell is possible"))
    };
    let config = BusConfig::ball_bar_and_probes(DeviceClock::default());
    Nodes::new(Arc::new(world), &config).expect("the settings are possible")
}

/// A frame is heard when the interrupt of the nodes' own controller took it, as the kernel stamps it: a node in a program
/// wakes up later than one of hardware.
fn serve(
    socket: &CanSocket,
    origin: TimeOrigin,
    nodes: &Mutex<Nodes>,
    stop: &AtomicBool,
) -> anyhow::Result<()> {
    socket.set_recv_timestamp(true)?;
    while !stop.load(Ordering::Relaxed) {
        let due_s = nodes.lock().unwrap_or_else(PoisonError::into_inner).next_due_s();
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
            let mut nodes = nodes.lock().unwrap_or_else(PoisonError::into_inner);
            let mut frames = heard.map_or_else(Vec::new, |(frame, at_s)| nodes.on_frame(&frame, at_s));
            frames.extend(nodes.frames_due(origin.now_s()));
            frames
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
