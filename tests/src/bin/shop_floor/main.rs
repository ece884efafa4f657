//! `shop-floor FOLDER [KHZ]`: simulated devices and the configuration of a service that reads them, for tests of the page. Each probe sends
//! at KHZ, 1 without it.
//!
//! Prints the path of the configuration, then obeys lines on standard input, each answered with `ok`: `run` starts the program, `unplug N`
//! pulls the cable of probe N, which stays out for the seconds that follow (`unplug 2 8`), `turn DEG` turns the nest about its Z as a person
//! mounts it, `step X Y Z` moves the linear axes by so many mm from where they stand before the program. It ends with its input.

use anyhow::{Context, bail};
use std::io::{BufRead, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::time::Instant;
use trunnion_core::convert::rad_from_deg;
use trunnion_core::{AxisValues, Joint};
use trunnion_cycles::Cycle;
use trunnion_hil_sim::devices::cell::{Cell, CellConfig};
use trunnion_hil_sim::devices::{CycleState, Fault, SimulatedCell, World, cell};
use trunnion_hil_sim::scenario::{Pace, Station};
use trunnion_hil_sim::{Truth, VirtualMachine, scenario};
use trunnion_machine::shipped;
use trunnion_tests::{SILENCE_MS, mounted, three_probes};

const CYCLE: &str = include_str!("../../../../config/cycles/demo-static.toml");
const OTHER_CYCLE: &str = include_str!("../../../../config/cycles/demo-sweep-c.toml");
/// Slow enough for a person, or a test, to see poses come.
const PACE: Pace = Pace { move_s: 0.1, dwell_s: 0.2 };

/// The program starts when it is asked for.
struct Waiting {
    world: SimulatedCell,
    /// When, s as bits; infinite before.
    at_s: AtomicU64,
    by_hand: Mutex<ByHand>,
}

/// What a person did before the program.
#[derive(Clone, Copy, Default)]
struct ByHand {
    stepped_mm: [f64; 3],
    turned_rad: f64,
}

impl Waiting {
    fn inside_s(&self, t_s: f64) -> f64 {
        (t_s - f64::from_bits(self.at_s.load(Ordering::Relaxed))).max(-1.0)
    }

    fn by_hand(&self) -> ByHand {
        *self.by_hand.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn stepped(&self, mut position: AxisValues<f64>) -> AxisValues<f64> {
        let ByHand { stepped_mm, .. } = self.by_hand();
        for (axis, by_mm) in [Joint::X, Joint::Y, Joint::Z].into_iter().zip(stepped_mm) {
            position[axis] += by_mm;
        }
        position
    }
}

impl World for Waiting {
    fn axes(&self, t_s: f64) -> AxisValues<f64> {
        self.stepped(self.world.axes(self.inside_s(t_s)))
    }

    fn probe_readings_mm(&self, t_s: f64) -> [f64; 3] {
        let inside_s = self.inside_s(t_s);
        let mut state = self.world.state(inside_s);
        state.position = self.stepped(state.position);
        let [x, y, z] = (self.world.deflection_mm)(&state);
        // Probes that turned one way see the ball turned the other way.
        let (sin, cos) = self.by_hand().turned_rad.sin_cos();
        let seen = [cos * x + sin * y, cos * y - sin * x, z];
        let along = |direction: [f64; 3]| -> f64 { (0..3).map(|k| direction[k] * seen[k]).sum() };
        let quiet_mm = self.world.probe_directions.map(along);
        // Before the start it is one moment for all times, and a probe that does not tremble is stuck.
        if inside_s <= -1.0 { quiet_mm.map(|mm| mm + 2e-4 * (1e3 * t_s).sin()) } else { quiet_mm }
    }

    fn bar_reading_mm(&self, t_s: f64) -> f64 {
        self.world.bar_reading_mm(self.inside_s(t_s))
    }

    fn temperature_degc(&self, t_s: f64) -> f64 {
        self.world.temperature_degc(self.inside_s(t_s))
    }

    fn cycle(&self, t_s: f64) -> CycleState {
        self.world.cycle(self.inside_s(t_s))
    }
}

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().context("shop-floor FOLDER [KHZ]")?;
    let rate_khz: f64 = args.next().map_or(Ok(1.0), |text| text.parse())?;
    let runtime = tokio::runtime::Runtime::new()?;
    let floor = runtime.block_on(Floor::start(Path::new(&folder), rate_khz))?;
    println!("{}", Path::new(&folder).join("trunnion.toml").display());
    for line in std::io::stdin().lock().lines() {
        floor.obey(&line?)?;
        println!("ok");
        std::io::stdout().flush()?;
    }
    Ok(())
}

struct Floor {
    cell: Mutex<Cell>,
    world: Arc<Waiting>,
    began: Instant,
}

impl Floor {
    async fn start(folder: &Path, rate_khz: f64) -> anyhow::Result<Self> {
        let world = Arc::new(Waiting {
            world: world()?,
            at_s: AtomicU64::new(f64::INFINITY.to_bits()),
            by_hand: Mutex::default(),
        });
        let wall_ns = SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos() as i64;
        let mut devices = CellConfig::new(folder, wall_ns);
        devices.can = None;
        for (probe, _) in &mut devices.probes {
            probe.rate_hz = 1e3 * rate_khz;
        }
        if let Some((agent, _)) = &mut devices.controller {
            agent.filters_duplicates = false;
        }
        let began = Instant::now();
        let cell = cell::start(Arc::clone(&world) as Arc<dyn World>, devices, began).await?;
        let url = cell.controller.as_ref().and_then(|agent| agent.url()).context("the cell has an agent")?;
        let tables = "[page]\nlisten = \"127.0.0.1:0\"\n[cycle_start]\nby = \"program\"\nprogram = \"*NOT-THIS-ONE*\"\n\
                      [[program]]\nname = \"*SWEEP*\"\ncycle = \"sweep.toml\"\n";
        let controller = format!("[[device]]\nname = \"cnc\"\ndriver = \"mtconnect\"\nurl = \"{url}\"\n");
        let text = three_probes(folder, SILENCE_MS, tables, &controller)
            .replace("range_mm = 2\n", &format!("range_mm = 2\nrate_khz = {rate_khz}\n"));
        std::fs::write(folder.join("trunnion.toml"), text)?;
        std::fs::write(folder.join("c.toml"), CYCLE)?;
        std::fs::write(folder.join("sweep.toml"), OTHER_CYCLE)?;
        Ok(Self { cell: Mutex::new(cell), world, began })
    }

    fn obey(&self, line: &str) -> anyhow::Result<()> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["run"] => {
                let now_s = self.began.elapsed().as_secs_f64();
                self.world.at_s.store(now_s.to_bits(), Ordering::Relaxed);
            }
            ["unplug", probe, seconds] => {
                let (probe, duration_s): (usize, f64) = (probe.parse()?, seconds.parse()?);
                let cell = self.cell.lock().unwrap_or_else(PoisonError::into_inner);
                let handle = cell.probes.get(probe - 1).context("there are three probes")?;
                handle.inject(Fault::Unplug { duration_s })?;
            }
            ["step", x, y, z] => {
                let stepped_mm = [x.parse()?, y.parse()?, z.parse()?];
                self.world.by_hand.lock().unwrap_or_else(PoisonError::into_inner).stepped_mm = stepped_mm;
            }
            ["turn", deg] => {
                let turned_rad = rad_from_deg(deg.parse()?);
                self.world.by_hand.lock().unwrap_or_else(PoisonError::into_inner).turned_rad = turned_rad;
            }
            _ => bail!("\"{line}\": run, unplug PROBE SECONDS, turn DEG, or step X Y Z"),
        }
        Ok(())
    }
}

/// The static cycle of the demo on a machine with a sagging table.
fn world() -> anyhow::Result<SimulatedCell> {
    let cycle = Cycle::parse("demo-static.toml", CYCLE)?;
    let machine = shipped::machine("table-bc").context("it is shipped")?;
    let poses = cycle.poses(&machine).context("the cycle follows the ball")?;
    let stations: Vec<Station> =
        poses.iter().map(|pose| Station { setup: pose.setup, position: pose.position }).collect();
    let truth = Truth::draw(&machine, &mounted(&cycle), &[], scenario::duration_s(stations.len(), PACE), 3)?;
    let machine = Arc::new(VirtualMachine::new(machine, truth)?);
    Ok(scenario::static_cycle(machine, &cycle.name, &stations, PACE)?)
}
