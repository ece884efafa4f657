//! A replay goes through a recording as the live run did.

use crate::joined::World;
use trunnion::Form;
use trunnion::replay::{Happened, Moment, replay};
use trunnion_core::Point;
use trunnion_machine::shipped;

#[test]
fn a_replay_gives_the_points_of_the_live_run_in_order_of_time() {
    let (world, folder) = (World::new(), tempfile::tempdir().unwrap());
    let path = world.record(&folder.path().join("run.mcap"), 0.0..world.ends_s(), 0.0);
    let mut moments: Vec<Moment> = Vec::new();
    replay(&path, &Form::default(), &mut |moment| {
        moments.push(moment);
        true
    })
    .unwrap();
    let recorded = trunnion_record::read_run(&path, &shipped::machine).unwrap().run.points;
    let points: Vec<_> = moments
        .iter()
        .filter_map(|moment| if let Happened::Point(point) = &moment.what { Some(point) } else { None })
        .collect();
    assert_eq!(points.len(), recorded.len());
    // Samples come in batches, so that a window may begin some samples sooner or later than live.
    let differs = |(a, b): &(&&Point, &Point)| {
        let off_mm = (0..3).map(|k| (a.reading_mm[k] - b.reading_mm[k]).abs()).fold(0.0, f64::max);
        off_mm > 1e-9 || a.quality != b.quality || a.state.setup != b.state.setup
    };
    assert_eq!(points.iter().zip(&recorded).position(|pair| differs(&pair)), None);
    // Samples are recorded in batches of at most 40 ms.
    assert!(moments.is_sorted_by(|a, b| b.time_s > a.time_s - 0.05));
    assert_eq!(moments.last().unwrap().progress.done, recorded.len());
    let mut seen = 0;
    replay(&path, &Form::default(), &mut |_| {
        seen += 1;
        seen < 100
    })
    .unwrap();
    assert_eq!(seen, 100, "it ends when nobody looks any more");
}
