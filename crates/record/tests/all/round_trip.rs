//! What is recorded is read back, bit for bit, by our reader and by one we did not write.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::time::Duration;
use trunnion_core::{
    AxisSample, AxisValues, Calibration, Day, Event, Gap, HostTime, Lacks, Point, ProbeSample, Quality,
    Stamp, State,
};
use trunnion_cycles::{Run, RunKind};
use trunnion_machine::{Machine, shipped};
use trunnion_record::{Item, Recorder, RunHeader, Temperature, points_csv, read_run, visit, write_run};

const START: HostTime = HostTime(5_000_000_000);

fn unknown(_: &str) -> Option<Machine> {
    None
}

fn gravity_run() -> Run {
    points_csv::import_files(
        "gravity",
        ("points.csv", include_str!("../../../../tests/data/points-gravity/points.csv")),
        ("setup.toml", include_str!("../../../../tests/data/points-gravity/setup.toml")),
        &shipped::machine,
    )
    .unwrap()
}

fn machine_text(name: &str) -> &'static str {
    shipped::FILES.iter().find(|(shipped, _)| *shipped == name).unwrap().1
}

fn header(run: &Run) -> RunHeader {
    RunHeader {
        probes: vec!["px".into(), "py".into(), "pz".into()],
        probe_roles: Vec::new(),
        calibrations: vec![
            calibrated("px", "2027-05-12"),
            Calibration { sensor: "py".into(), ..Calibration::default() },
        ],
        cycle_text: "format = \"trunnion-cycle/1\"\n".into(),
        config_text: "# µm\n".into(),
        host_start: START,
        ..RunHeader::of_run(run, machine_text("table-bc"), "0.1.0", 1_790_000_000_000_000_000)
    }
}

fn calibrated(sensor: &str, valid_until: &str) -> Calibration {
    Calibration {
        sensor: sensor.into(),
        serial: Some("1702".into()),
        certificate: Some("K-2026-081".into()),
        laboratory: Some("Prüfstelle".into()),
        date: Day::parse("2026-05-12"),
        valid_until: Day::parse(valid_until),
    }
}

fn random_point(rng: &mut ChaCha8Rng) -> Point {
    let mut six = |scale: f64| AxisValues::from_fn(|_| (rng.random::<f64>() - 0.5) * scale);
    let mut state = State {
        position: six(300.0),
        direction: six(2.0),
        velocity: six(10.0),
        acceleration: six(100.0),
        since_reversal: six(300.0),
        ..State::default()
    };
    state.position.0[0] = -0.0;
    state.time_s = rng.random::<bool>().then(|| rng.random::<f64>() * 1000.0);
    state.temperature_degc = vec![20.0 + rng.random::<f64>(), f64::NAN];
    state.setup = 1;
    state.deflection_mm.x = rng.random();
    let lacks = [Lacks::Unsaid, Lacks::Dwell, Lacks::Value, Lacks::End].map(Quality::NoReading);
    let qualities = [[Quality::Good, Quality::Unsettled].as_slice(), &lacks].concat();
    let quality = qualities[rng.random_range(0..qualities.len())];
    Point {
        state,
        reading_mm: [rng.random(), -0.0, rng.random()],
        spread_mm: [1e-4; 3],
        samples: 77,
        quality,
    }
}

/// Debug output shows every bit that matters and is equal for NaN.
fn same(a: &impl std::fmt::Debug, b: &impl std::fmt::Debug) {
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

#[test]
fn everything_recorded_is_read_back_bit_for_bit_in_order_of_time() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let run = gravity_run();
    let header = header(&run);
    let mut recorder = Recorder::create(folder.path(), "all", &header).unwrap();
    let (mut probes, mut axes, mut points) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..20_000_u32 {
        let arrival = START + Duration::from_micros(u64::from(i) * 250);
        let time_s = f64::from(i) * 250e-6 - 0.003 + rng.random::<f64>() * 1e-6;
        let raw = 130_000 + rng.random_range(-30_i64..30);
        let channel = (i % 3) as u16;
        let value_mm = if i == 999 { f64::NAN } else { (raw as f64 * 1.02 / 65520.0 - 0.01) * 2.0 };
        // Two connections: the device's clock restarts.
        let stamp = Stamp {
            epoch: 1 + i / 7000,
            ticks: u64::from(i) * 31 + 4_000_000_000,
            tick_s: 1e-6,
            arrival_s: arrival.seconds_since(START),
        };
        let sample = ProbeSample { channel, time_s, stamp, raw, value_mm };
        probes.push(sample);
        recorder.append(Item::Probe(sample), arrival);
        if i % 8 == 0 {
            let mut position = AxisValues::default();
            position.0[5] = f64::from(i) * 1e-4;
            // A joint beyond X Y Z A B C.
            position.0[11] = f64::from(i) * -3e-4;
            let stamp =
                Stamp { tick_s: 1e-9, ticks: u64::from(i) * 250_000 + 1_700_000_000_000_000_000, ..stamp };
            axes.push(AxisSample {
                time_s,
                stamp,
                held: i % 24 == 0,
                skew_s: f64::from(i % 5) * 1e-3,
                position,
            });
            recorder.append(Item::Axes(axes[axes.len() - 1]), arrival);
        }
        if i % 500 == 0 {
            points.push(random_point(&mut rng));
            recorder.append(Item::Point(points[points.len() - 1].clone()), arrival);
        }
    }
    let event = Event { time_s: 1.0, kind: "cycle-start".into(), text: "µ".into() };
    let gap = Gap {
        source: "px".into(),
        from_s: 0.0,
        to_s: 0.1,
        lost_samples: Some(0),
        reason: "unplugged".into(),
    };
    let temperature = Temperature { time_s: 2.0, channel: 0, value_degc: 19.44 };
    for item in [Item::Event(event.clone()), Item::Gap(gap.clone()), Item::Temperature(temperature)] {
        recorder.append(item, START);
    }
    assert_eq!(recorder.failing(), None);
    let finished = recorder.finish(START).unwrap();
    assert_eq!((finished.files.len(), finished.lost_samples), (1, 0));
    assert!(!folder.path().join("all.mcap.active").exists());

    let path = folder.path().join("all.mcap");
    let read = read_run(&path, &unknown).unwrap();
    assert_eq!(read.damage, None);
    same(&read.header, &header);
    same(&read.run.machine, &run.machine);
    same(&read.run.points, &points);
    let by_channel = |samples: &[ProbeSample]| -> Vec<ProbeSample> {
        let of = |channel| samples.iter().filter(move |sample| sample.channel == channel).copied();
        (0..3).flat_map(of).collect()
    };
    same(&by_channel(&read.probe_samples), &by_channel(&probes));
    same(&read.axis_samples, &axes);
    same(&(read.events, read.gaps, read.temperatures), &(vec![event], vec![gap], vec![temperature]));

    // In order within a channel, and across channels to the length of a batch.
    let (mut last, mut latest) = ([f64::NEG_INFINITY; 3], f64::NEG_INFINITY);
    visit(&path, &mut |item| {
        if let Item::Probe(sample) = item {
            let last = &mut last[usize::from(sample.channel)];
            assert!(sample.time_s >= *last - 1e-9, "{} after {last}", sample.time_s);
            *last = sample.time_s;
            latest = latest.max(sample.time_s);
            assert!(sample.time_s > latest - 0.041, "{} after {latest}", sample.time_s);
        }
        true
    })
    .unwrap();
}

#[test]
fn the_reader_of_the_mcap_crate_finds_index_schema_and_attachments() {
    let folder = tempfile::tempdir().unwrap();
    let run = gravity_run();
    let path = folder.path().join("run.mcap");
    let finished = write_run(&path, &header(&run), &run).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.stats.as_ref().unwrap().message_count, finished.messages);
    assert_eq!(summary.attachment_indexes.len(), 3);
    assert!(!summary.chunk_indexes.is_empty());
    let points = mcap::MessageStream::new(&bytes).unwrap().filter(|message| {
        let channel = &message.as_ref().unwrap().channel;
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(schema.encoding, "protobuf");
        channel.topic == "/point" && schema.name == "trunnion.Point"
    });
    assert_eq!(points.count(), 336);
}

#[test]
fn a_journal_is_readable_while_it_grows_and_belongs_to_its_writer() {
    let folder = tempfile::tempdir().unwrap();
    let run = gravity_run();
    let header = header(&run);
    let mut recorder = Recorder::create(folder.path(), "now", &header).unwrap();
    recorder.append(Item::Point(run.points[3].clone()), START);
    let read = read_run(&folder.path().join("now.mcap.active"), &unknown).unwrap();
    same(&read.run.points, &vec![run.points[3].clone()]);
    assert!(read.damage.unwrap().reason.contains("without its end record"));

    assert!(trunnion_record::recover_orphans(folder.path()).unwrap().is_empty());
    let second = Recorder::create(folder.path(), "now", &header);
    assert!(second.err().unwrap().to_string().contains("exists already"));
    recorder.finish(START).unwrap();
    assert!(Recorder::create(folder.path(), "now", &header).is_err());
}

#[test]
fn importing_twice_gives_the_same_bytes_and_points_of_a_machine_only_named() {
    let folder = tempfile::tempdir().unwrap();
    let (run, again) = (gravity_run(), gravity_run());
    assert_eq!(run.kind, RunKind::Static);
    let write = |name: &str, run: &Run| {
        let path = folder.path().join(name);
        let header = RunHeader::of_run(run, "", "0.1.0", 0);
        write_run(&path, &header, run).unwrap();
        path
    };
    let (a, b) = (write("a.mcap", &run), write("b.mcap", &again));
    assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
    same(&read_run(&a, &shipped::machine).unwrap().run, &run);
    let error = read_run(&a, &unknown).err().unwrap().to_string();
    assert!(error.contains("machine \"table-bc\" is neither in the recording nor known"), "{error}");
    assert!(read_run(Path::new("nowhere.mcap"), &unknown).is_err());
}

/// docs/design/numerics.md §2.2: 6.8–15 bytes a sample with 256 samples a message.
#[test]
fn a_probe_sample_takes_under_fifteen_bytes_in_the_journal_and_under_eight_when_finished() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut recorder = Recorder::create(folder.path(), "big", &header(&gravity_run())).unwrap();
    let samples_each = 30_000_u32;
    for i in 0..samples_each {
        let arrival = START + Duration::from_micros(u64::from(i) * 250);
        for channel in 0..3 {
            let raw = 130_000 + i64::from(rng.next_u32() % 9);
            let sample = ProbeSample {
                channel,
                time_s: (f64::from(i) * 250_013.7).round() * 1e-9,
                stamp: Stamp {
                    epoch: 1,
                    ticks: u64::from(i) * 2500,
                    tick_s: 1e-7,
                    arrival_s: arrival.seconds_since(START),
                },
                raw,
                value_mm: (raw as f64 * 1.02 / 65520.0 - 0.01) * 2.0,
            };
            recorder.append(Item::Probe(sample), arrival);
        }
    }
    let journal = std::fs::metadata(folder.path().join("big.mcap.active")).unwrap().len();
    let finished = recorder.finish(START).unwrap();
    let per_sample = |bytes: u64| bytes as f64 / (3.0 * f64::from(samples_each));
    println!(
        "{:.2} B/sample journal, {:.2} finished",
        per_sample(journal),
        per_sample(finished.files[0].bytes)
    );
    assert!(per_sample(journal) < 15.0 && per_sample(finished.files[0].bytes) < 8.0);
}
