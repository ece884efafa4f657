use super::*;
use crate::link::Outlet;
use crate::status::DeviceStatus;
use crate::test_clock::AtZero;
use tokio::sync::{mpsc, watch};
use trunnion_core::reading::SourceGap;
use trunnion_protocol::optoncdt::{Measurement, raw_distance};

const MS: i64 = 1_000_000;

/// Gaps that blocks lead to, each with its number and the moment of its arrival, ms; the sensor measures every millisecond.
fn gaps(blocks: &[(u32, i64)]) -> Vec<SourceGap> {
    let (sender, mut delivered) = mpsc::channel(64);
    let (status, _) = watch::channel(DeviceStatus::default());
    let outlet = Outlet::new(0, "probe-1".into(), sender);
    let mut link =
        Link::new(0, vec!["probe-1".into()], Duration::from_millis(500), Arc::new(AtZero), outlet, status);
    let config = Optoncdt {
        port: String::new(),
        baud: 921_600,
        role: Role::Probe(0),
        bar_zero_mm: None,
        range_mm: 2.0,
        rate_khz: 1.0,
    };
    let layout = Layout::from_names(["DIST1", "COUNTER", "TIMESTAMP"]);
    let mut sensor = Sensor::new(&config, layout.clone(), 0);
    for &(number, arrival_ms) in blocks {
        let block = layout.write(&Measurement {
            distance: Some(raw_distance(1.0, 2.0)),
            counter: Some(number),
            timestamp_ticks: Some((f64::from(number) * 1e-3 / TIMESTAMP_TICK_S) as u32),
            ..Measurement::default()
        });
        sensor.take(&block, HostTime(arrival_ms * MS), &mut link).unwrap();
    }
    let readings = std::iter::from_fn(|| delivered.try_recv().ok()).map(|message| message.reading);
    readings.filter_map(|reading| if let Reading::Gap(gap) = reading { Some(gap) } else { None }).collect()
}

#[test]
fn lost_values_are_missing_where_the_clock_of_the_sensor_jumped() {
    let ms = |time: HostTime| (time.0 as f64 / MS as f64).round() as i64;
    let at = |gap: &SourceGap| (ms(gap.from), ms(gap.to), gap.lost_readings);
    let in_time = gaps(&[(1, 1), (2, 2), (12, 12), (13, 13)]);
    assert_eq!(in_time.iter().map(at).collect::<Vec<_>>(), [(2, 12, Some(9))]);
    // The program paused from 2 ms on, and the line kept the first ten blocks alone.
    let paused = gaps(&[(1, 1), (2, 2), (3, 300), (12, 300), (300, 301), (301, 301)]);
    assert_eq!(paused.iter().map(at).collect::<Vec<_>>(), [(3, 12, Some(8)), (12, 300, Some(287))]);
}
