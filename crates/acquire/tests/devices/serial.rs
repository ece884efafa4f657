//! Drivers of serial indicators and boxes against virtual ones, through real pseudo-terminals.

use crate::shop::{Bench, MOVING, RESTING, Shop, TRUTH_DEGC, find, is_good, state, until};
use trunnion_acquire::{DeviceState, SessionEnd};
use trunnion_core::reading::{ProbeReading, Reading};
use trunnion_hil_sim::devices::ascii::{IndicatorConfig, Sees};
use trunnion_hil_sim::devices::{DeviceClock, Fault, Handle, ascii, keyence, optoncdt};
use trunnion_hil_sim::replies;
use trunnion_protocol::ascii::{PRESETS, Preset, Unit};

fn probe(reading: &Reading) -> Option<ProbeReading> {
    match reading {
        Reading::Probe(probe) => Some(*probe),
        _ => None,
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn says(reading: &Reading, words: &str) -> bool {
    matches!(reading, Reading::Log(line) if line.warning && line.text.contains(words))
}

const BOX: &str = r#"
[[device]]
name = "gauges"
driver = "keyence-dl-rs1a"
port = "{port}"
baud = 38400
heads = [{ head = 1, role = "probe-1" }, { head = 2, role = "probe-2" }, { head = 3, role = "probe-3" }]
"#;

fn gauges(bench: Bench) -> (Shop, Handle) {
    let shop = Shop::new(bench);
    let config = keyence::BoxConfig::three_gauges();
    let handle = keyence::spawn(shop.world.clone(), config, &shop.port, shop.origin, &[]).unwrap();
    (shop, handle)
}

#[tokio::test(flavor = "multi_thread")]
async fn all_heads_of_a_box_share_the_moment_of_their_reply_and_read_in_mm() {
    let (shop, _box) = gauges(MOVING);
    let mut acquisition = shop.start(BOX);
    let readings = until(&mut acquisition, |reading| probe(reading).is_some_and(|p| p.sequence > 40)).await;
    let readings: Vec<ProbeReading> = readings.iter().filter_map(probe).collect();
    let mut errors_mm = Vec::new();
    for together in readings.chunks_exact(3) {
        assert!(
            together.iter().all(|reading| reading.device_ticks == together[0].device_ticks),
            "{together:?}"
        );
        let truth_mm = MOVING.truth_mm(together[0].arrival.0 as f64 * 1e-9);
        let error = |(reading, truth_mm): (&ProbeReading, f64)| (reading.value_mm - truth_mm).abs();
        errors_mm.extend(together.iter().zip(truth_mm).map(error));
    }
    // A head shows the last of its refreshes: 13 ms and half a reply at 0.4 mm/s; a busy machine delays some more.
    assert!(median(errors_mm) < 0.03);
    let status = state(&acquisition, |status| status.state == DeviceState::Streaming).await;
    assert_eq!(status.identity, "Keyence DL-RS1A with 3 amplifiers GT2-70");
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_box_with_too_few_heads_is_a_wrong_device_and_a_head_without_signal_says_why() {
    let (shop, handle) = gauges(MOVING);
    let mut acquisition = shop.start(BOX);
    until(&mut acquisition, is_good).await;
    handle.inject(Fault::OutOfRange { duration_s: 0.5 }).unwrap();
    until(&mut acquisition, |reading| says(reading, "no position: no signal from the head")).await;
    let state_raw =
        |reading: &Reading| probe(reading).filter(|probe| probe.value_mm.is_nan()).map(|probe| probe.raw);
    assert_eq!(find(&mut acquisition, state_raw).await, 9_999_998);
    until(&mut acquisition, is_good).await;

    handle.inject(Fault::WrongIdentity).unwrap();
    let status = state(&acquisition, |status| status.state == DeviceState::WrongDevice).await;
    let Some(SessionEnd::WrongDevice { found, expected }) = &status.last_end else { panic!("{status:?}") };
    assert!(found.contains("with 1 amplifiers") && expected.contains("head 2 (probe-2)"), "{status:?}");
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn damaged_replies_are_counted_and_become_a_gap() {
    let (shop, handle) = gauges(MOVING);
    let mut acquisition = shop.start(BOX);
    until(&mut acquisition, is_good).await;
    handle.inject(Fault::GarbleBytes { count: 60 }).unwrap();
    let readings = until(&mut acquisition, |reading| matches!(reading, Reading::Gap(_))).await;
    let Some(Reading::Gap(gap)) = readings.last() else { unreachable!() };
    assert!(gap.lost_readings.is_some_and(|lost| lost >= 3) && gap.reason.contains("replies"), "{gap:?}");
    until(
        &mut acquisition,
        |reading| matches!(reading, Reading::Counters(c) if c.damaged > 0 && c.resyncs > 0),
    )
    .await;
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_value_that_sticks_is_a_state_a_warning_and_a_gap_until_it_moves_again() {
    let (shop, handle) = gauges(RESTING);
    let mut acquisition = shop.start(BOX);
    // The noise of the gauges at rest must have been seen for some seconds first.
    until(&mut acquisition, |reading| probe(reading).is_some_and(|probe| probe.sequence > 550)).await;
    handle.inject(Fault::StuckValue { duration_s: 4.0 }).unwrap();
    let readings = until(&mut acquisition, |reading| matches!(reading, Reading::Gap(_))).await;
    assert!(readings.iter().any(|reading| says(reading, "is stuck: it has sent")), "warned");
    assert!(readings.iter().filter_map(probe).any(|probe| probe.value_mm.is_nan()), "no value while stuck");
    let Some(Reading::Gap(gap)) = readings.last() else { unreachable!() };
    assert!(gap.source.starts_with("gauges.head-") && gap.reason.starts_with("stuck at"), "{gap:?}");
    assert!((gap.to - gap.from).as_secs_f64() > 2.0 && gap.lost_readings.is_some_and(|n| n > 20), "{gap:?}");
    state(&acquisition, |status| status.state == DeviceState::Streaming).await;
    acquisition.stop().await;
}

fn indicator(bench: Bench, sees: Sees, preset: Preset) -> (Shop, Handle) {
    let shop = Shop::new(bench);
    let config = IndicatorConfig::new(sees, preset);
    let handle = ascii::spawn(shop.world.clone(), config, &shop.port, shop.origin, &[]).unwrap();
    (shop, handle)
}

fn indicator_text(preset: &str, role: &str) -> String {
    format!(
        "[[device]]\nname = \"gauge\"\ndriver = \"ascii\"\nport = \"{{port}}\"\npreset = \"{preset}\"\nrole = \"{role}\"\n"
    )
}

#[tokio::test(flavor = "multi_thread")]
async fn every_preset_is_read_in_mm_with_the_moment_of_its_value() {
    for preset in PRESETS {
        let (shop, _gauge) = indicator(MOVING, Sees::Probe(1), **preset);
        let mut acquisition = shop.start(&indicator_text(preset.name, "probe-2"));
        let readings = until(&mut acquisition, |r| probe(r).is_some_and(|probe| probe.sequence >= 9)).await;
        let error = |reading: ProbeReading| {
            let truth_mm = MOVING.truth_mm(reading.arrival.0 as f64 * 1e-9)[1];
            (reading.value_mm - truth_mm).abs()
        };
        let digit_mm = 10f64.powi(-(preset.decimals as i32)) * preset.unit.length_mm().unwrap();
        // The stamp is right to some ms at 0.4 mm/s; a busy machine delays some more.
        let error_mm = median(readings.iter().filter_map(probe).map(error).collect());
        assert!(error_mm < 0.02 + digit_mm, "{} {error_mm}", preset.name);
        let status = state(&acquisition, |status| status.state == DeviceState::Streaming).await;
        assert!(status.identity.starts_with(preset.name), "{}", status.identity);
        acquisition.stop().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_thermometer_of_its_own_format_is_a_temperature_channel() {
    let like = *Preset::named("mitutoyo-usb").unwrap();
    let thermometer =
        Preset { name: "custom", pattern: "T={value} {unit}", unit: Unit::Celsius, decimals: 1, ..like };
    let (shop, _gauge) = indicator(MOVING, Sees::Temperature, thermometer);
    let text = indicator_text("custom", "temperature")
        + "baud = 2400\npattern = \"T={value} {unit}\"\nunit = \"degC\"\nerrors = [\"open\"]\n";
    let mut acquisition = shop.start(&text);
    let readings = until(&mut acquisition, |reading| matches!(reading, Reading::Temperature(_))).await;
    let Some(Reading::Temperature(reading)) = readings.last() else { unreachable!() };
    assert_eq!((reading.name.as_str(), reading.degc), ("gauge", TRUTH_DEGC));
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_gauge_out_of_range_says_why_and_leaves_one_gap_and_another_device_is_refused() {
    let (shop, handle) = indicator(MOVING, Sees::Bar, *Preset::named("mahr-c1202").unwrap());
    let mut acquisition = shop.start(&(indicator_text("mahr-c1202", "bar") + "poll_ms = 20\n"));
    until(&mut acquisition, is_good).await;
    handle.inject(Fault::OutOfRange { duration_s: 0.6 }).unwrap();
    let readings = until(&mut acquisition, |reading| matches!(reading, Reading::Gap(_))).await;
    let warnings = readings.iter().filter(|reading| says(reading, "gauge has no value")).count();
    assert_eq!(warnings, 1, "reported once");
    let Some(Reading::Gap(gap)) = readings.last() else { unreachable!() };
    assert!(gap.reason.contains("reports an error") && gap.lost_readings.is_some_and(|n| n > 1), "{gap:?}");
    acquisition.stop().await;

    handle.inject(Fault::WrongIdentity).unwrap();
    let acquisition = shop.start(&indicator_text("mahr-c1202", "bar"));
    let status = state(&acquisition, |status| status.state == DeviceState::WrongDevice).await;
    let Some(SessionEnd::WrongDevice { found, expected }) = &status.last_end else { panic!("{status:?}") };
    assert!(found.contains("HELLO 17") && expected.contains("Mahr"), "{status:?}");
    acquisition.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn bytes_that_make_no_sense_are_reported_as_a_wrong_line_speed() {
    let (shop, handle) = gauges(MOVING);
    handle.inject(Fault::GarbleBytes { count: 1_000_000 }).unwrap();
    let acquisition = shop.start(BOX);
    let status = state(&acquisition, |status| status.state == DeviceState::Silent).await;
    let end = status.last_end.unwrap().to_string();
    assert!(end.contains("make no sense at 38400 baud 8N1") && end.contains("trunnion devices"), "{end}");
    acquisition.stop().await;
}

const PROBE: &str = r#"
[[device]]
name = "probe"
driver = "optoncdt"
port = "{port}"
role = "probe-1"
range_mm = 2
"#;

#[tokio::test(flavor = "multi_thread")]
async fn an_optoncdt_without_target_leaves_a_gap_and_its_clock_and_counter_are_followed_when_they_jump() {
    let shop = Shop::new(MOVING);
    let config = optoncdt::ProbeConfig::new(0, DeviceClock::steady(5.0, 20.0));
    let handle = optoncdt::spawn(shop.world.clone(), config, &shop.port, shop.origin, &[]).unwrap();
    let mut acquisition = shop.start(PROBE);
    let gap = |reading: &Reading| match reading {
        Reading::Gap(gap) => Some(gap.clone()),
        _ => None,
    };
    until(&mut acquisition, is_good).await;
    handle.inject(Fault::OutOfRange { duration_s: 0.3 }).unwrap();
    let readings = until(&mut acquisition, |reading| gap(reading).is_some()).await;
    let found = gap(readings.last().unwrap()).unwrap();
    assert!(found.reason.contains("target behind the measuring range"), "{found:?}");
    assert!(found.lost_readings.is_some_and(|lost| (250..=350).contains(&lost)), "{found:?}");

    handle.inject(Fault::CounterJump { by: 77 }).unwrap();
    let readings = until(&mut acquisition, |reading| gap(reading).is_some()).await;
    assert_eq!(gap(readings.last().unwrap()).unwrap().lost_readings, Some(77));

    // The clock as it was set, forward or back, for the time base to begin a new line.
    for by_s in [3.0, -3.0] {
        let before = until(&mut acquisition, is_good).await.last().and_then(probe).unwrap();
        handle.inject(Fault::ClockJump { by_s }).unwrap();
        let went_s = |now: ProbeReading| (now.device_ticks as f64 - before.device_ticks as f64) * now.tick_s;
        let went_else =
            |now: ProbeReading| (went_s(now) - by_s - now.arrival.seconds_since(before.arrival)).abs() < 0.5;
        until(&mut acquisition, |reading| probe(reading).is_some_and(went_else)).await;
    }

    handle.inject(Fault::WrongIdentity).unwrap();
    let status = state(&acquisition, |status| status.state == DeviceState::WrongDevice).await;
    assert!(status.last_end.unwrap().to_string().contains("ILD1420-50"));
    acquisition.stop().await;
}

/// Reads on through the fault: no session ends, and no value is that of a request before.
async fn reads_through(shop: Shop, text: &str, channel: usize, what: String) {
    let mut acquisition = shop.start(text);
    let readings = until(&mut acquisition, |r| probe(r).is_some_and(|p| p.sequence > 12)).await;
    let status = state(&acquisition, |status| status.state == DeviceState::Streaming).await;
    assert_eq!(status.ends.iter().sum::<u64>(), 0, "{what}: {status:?}");
    for reading in readings.iter().filter_map(probe).filter(|reading| usize::from(reading.channel) == channel)
    {
        let truth_mm = SLOW.truth_mm(reading.arrival.0 as f64 * 1e-9)[channel];
        // 0.2 s of the quickest motion: a busy computer delays by less, the reply before came longer ago.
        assert!((reading.value_mm - truth_mm).abs() < 0.3 * SLOW.0 * 0.2 + 0.002, "{what}: {reading:?}");
    }
    acquisition.stop().await;
}

/// Moves by what a late reply must show, and not by what a pause of the computer does.
const SLOW: Bench = Bench(1.0);

#[tokio::test(flavor = "multi_thread")]
async fn no_reply_of_a_box_that_is_late_doubled_lost_or_merged_disables_it_or_is_taken_for_another() {
    let mut cases = tokio::task::JoinSet::new();
    for fault in replies::KEYENCE.faults() {
        cases.spawn(async move {
            let shop = Shop::new(SLOW);
            let config =
                keyence::BoxConfig { reply_fault: Some(fault), ..keyence::BoxConfig::three_gauges() };
            let _box = keyence::spawn(shop.world.clone(), config, &shop.port, shop.origin, &[]).unwrap();
            reads_through(shop, BOX, 0, format!("{fault:?}")).await;
        });
    }
    cases.join_all().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn no_answer_of_an_indicator_that_is_late_doubled_lost_or_merged_disables_it_or_is_taken_for_another() {
    let mut cases = tokio::task::JoinSet::new();
    for fault in replies::ASCII.faults() {
        cases.spawn(async move {
            let shop = Shop::new(SLOW);
            let preset = *Preset::named("mahr-c1202").unwrap();
            let config =
                IndicatorConfig { reply_fault: Some(fault), ..IndicatorConfig::new(Sees::Probe(0), preset) };
            let _gauge = ascii::spawn(shop.world.clone(), config, &shop.port, shop.origin, &[]).unwrap();
            reads_through(shop, &indicator_text("mahr-c1202", "probe-1"), 0, format!("{fault:?}")).await;
        });
    }
    cases.join_all().await;
}
