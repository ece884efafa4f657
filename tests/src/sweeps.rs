//! Recordings of sweeps of a virtual machine, with the stamps of its devices, faster than real time: probes at 1 kHz, a controller
//! at 125 Hz whose stamps jitter.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trunnion_core::{AxisSample, AxisValues, HostTime, ProbeSample, Role, Stamp, convert};
use trunnion_cycles::Cycle;
use trunnion_cycles::cycle::Motion;
use trunnion_hil_sim::devices::{World, orthogonal_nest};
use trunnion_hil_sim::{SimSetup, Truth, VirtualMachine, scenario};
use trunnion_machine::shipped;
use trunnion_record::{Item, Recorder, RunHeader};

const PROBES_HZ: f64 = 1000.0;
const CONTROLLER_HZ: f64 = 125.0;
/// Resolution of the controller: 0.1 µm and 0.00001°.
const RESOLUTION: (f64, f64) = (1e-4, 1e-5);
/// Ramps lie outside the span, as in the programs that the product writes: 0.4 s of a ramp are 0.2 s at the feed.
const RUN_IN_S: f64 = 0.3;
/// From sample to arrival, s.
const PROBE_LATENCY_S: f64 = 0.5e-3;
const CONTROLLER_LATENCY_S: f64 = 5e-3;

/// A sweep to be recorded.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Feeds of C, °/min.
    pub feeds_deg_per_min: Vec<f64>,
    /// From the axis of C to the ball, mm.
    pub radius_mm: f64,
    /// Of the stamps of the controller (rms), s.
    pub jitter_s: f64,
    /// Of the machine and its noise.
    pub seed: u64,
}

impl Sweep {
    /// Its cycle file: a turn of C both ways at each feed.
    pub fn cycle_text(&self) -> String {
        format!(
            "format = \"trunnion-cycle/1\"\nname = \"sweep\"\nmachine = \"table-bc\"\nkind = \"on-the-fly\"\n\
             [[setup]]\nname = \"low\"\ninstrument = \"r-test\"\nnest = \"table\"\nball_in_table_mm = [{:.1}, 0.0, 60.0]\n\
             [sweep]\naxis = \"C\"\nfrom_deg = 0\nto_deg = 360\nfeeds_deg_per_min = {:?}\nb_deg = 0\n",
            self.radius_mm, self.feeds_deg_per_min
        )
    }

    /// Records it in a folder: a machine with location errors and noise, nothing hidden.
    ///
    /// # Panics
    /// When the virtual machine or the recording refuse.
    pub fn record(&self, folder: &Path) -> PathBuf {
        let cycle_text = self.cycle_text();
        let cycle = Cycle::parse("sweep.toml", &cycle_text).unwrap();
        let machine = shipped::machine("table-bc").unwrap();
        let Motion::OnTheFly { axis, from_to_rad, feeds_rad_per_s, others, .. } = &cycle.motion else {
            panic!("the cycle is on the fly")
        };
        let setups: Vec<SimSetup> = cycle.setups.iter().map(SimSetup::from).collect();
        let seconds: f64 = self.feeds_deg_per_min.iter().map(|feed| 2.0 * 360.0 * 60.0 / feed).sum();
        let truth = Truth::draw(&machine, &setups, &[], seconds, self.seed).unwrap();
        let world = Arc::new(VirtualMachine::new(machine, truth).unwrap());
        let run_in_rad = RUN_IN_S * feeds_rad_per_s.iter().copied().fold(0.0, f64::max);
        let from_to_rad = (from_to_rad.0 - run_in_rad, from_to_rad.1 + run_in_rad);
        let world =
            scenario::sweep_cycle(world, &cycle.name, *axis, from_to_rad, feeds_rad_per_s, others).unwrap();
        let feeds: Vec<String> = self.feeds_deg_per_min.iter().map(|feed| format!("{feed:.0}")).collect();
        let name = format!("sweep-{}-{:.0}", feeds.join("-"), self.radius_mm);
        let mut recorder = Recorder::create(folder, &name, &header(&name, &cycle, &cycle_text)).unwrap();
        let end_s = world.trajectory.duration_s();
        let mut stamps = ChaCha8Rng::seed_from_u64(self.seed);
        let jitter = Normal::new(0.0, self.jitter_s).unwrap();
        let every = (PROBES_HZ / CONTROLLER_HZ) as u64;
        for k in 0..(end_s * PROBES_HZ) as u64 {
            let time_s = k as f64 / PROBES_HZ;
            for (channel, value_mm) in world.probe_readings_mm(time_s).into_iter().enumerate() {
                let arrival_s = time_s + PROBE_LATENCY_S;
                let sample = ProbeSample {
                    channel: channel as u16,
                    time_s: arrival_s,
                    stamp: stamp(time_s, arrival_s),
                    raw: 0,
                    value_mm,
                };
                recorder.append(Item::Probe(sample), host(arrival_s));
            }
            if k % every == 0 {
                let (stamped_s, arrival_s) =
                    (time_s + jitter.sample(&mut stamps), time_s + CONTROLLER_LATENCY_S);
                let sample = AxisSample {
                    time_s: arrival_s,
                    stamp: stamp(stamped_s.max(0.0), arrival_s),
                    position: shown(&world.axes(time_s)),
                    ..AxisSample::default()
                };
                recorder.append(Item::Axes(sample), host(arrival_s));
            }
        }
        let finished = recorder.finish(host(end_s + 1.0)).unwrap();
        finished.files[0].path.clone()
    }
}

fn header(name: &str, cycle: &Cycle, cycle_text: &str) -> RunHeader {
    let rows: Vec<String> =
        orthogonal_nest().iter().enumerate().map(|(k, row)| format!("probe_{} = {row:?}\n", k + 1)).collect();
    let machine_text =
        shipped::FILES.iter().find(|(file, _)| file.contains("table-bc")).map(|(_, text)| *text);
    RunHeader {
        machine_text: machine_text.unwrap_or_default().into(),
        setups: cycle.setups.clone(),
        probes: (1..=3).map(|k| format!("probe-{k}")).collect(),
        probe_roles: (0..3).map(Role::Probe).collect(),
        cycle_text: cycle_text.into(),
        config_text: format!("[nest]\n{}", rows.concat()),
        ..RunHeader::new(name, cycle.run_kind(), &cycle.machine)
    }
}

/// Nanoseconds of a clock that is exact: axes are recorded in them.
fn stamp(device_s: f64, arrival_s: f64) -> Stamp {
    Stamp { epoch: 1, ticks: (device_s * 1e9).round() as u64, tick_s: 1e-9, arrival_s }
}

fn host(run_s: f64) -> HostTime {
    HostTime((run_s * 1e9).round() as i64)
}

/// What the controller shows of positions.
fn shown(position: &AxisValues<f64>) -> AxisValues<f64> {
    AxisValues::from_fn(|slot| {
        if slot.is_rotary() {
            let degrees = convert::deg_from_rad(position[slot]);
            convert::rad_from_deg((degrees / RESOLUTION.1).round() * RESOLUTION.1)
        } else {
            (position[slot] / RESOLUTION.0).round() * RESOLUTION.0
        }
    })
}
