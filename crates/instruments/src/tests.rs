use super::*;
use trunnion_machine::shipped;
use trunnion_measurement::NestSide;

fn setups() -> Vec<Setup> {
    let base = Setup {
        name: "low".into(),
        instrument: InstrumentKind::RTest,
        nest: NestSide::Table,
        ball_in_table_mm: Point3::new(150.0, 20.0, 60.0),
        bar_length_mm: None,
    };
    vec![
        base.clone(),
        Setup { nest: NestSide::Spindle, ..base.clone() },
        Setup { instrument: InstrumentKind::BallBar, bar_length_mm: Some(100.0), ..base },
    ]
}

#[test]
fn every_kind_of_instrument_is_registered_once() {
    for (_, kind) in InstrumentKind::NAMES {
        assert_eq!(REGISTRY.iter().filter(|instrument| instrument.kind == kind).count(), 1);
    }
}

/// Central differences of the exact prediction against the analytic columns: every instrument, every machine,
/// every site.
#[test]
fn columns_are_the_derivatives_of_the_exact_prediction() {
    let step = 1e-4;
    for (name, _) in shipped::FILES {
        let machine = shipped::machine(name).unwrap();
        for setup in setups() {
            let mut q = AxisValues::default();
            (q[AxisLetter::A], q[AxisLetter::B], q[AxisLetter::C]) = (0.5, -0.8, 2.1);
            let mut q = machine.follow(&q, &setup.ball_in_table_mm).unwrap();
            if setup.instrument == InstrumentKind::BallBar {
                q[AxisLetter::X] += 60.0;
                q[AxisLetter::Z] += 80.0;
            }
            let projector = Projector::new(&machine, &setup, &q);
            let sites = [Site::TableBall, Site::SpindleBall, Site::Reading]
                .into_iter()
                .chain(AxisLetter::ALL.into_iter().filter(|&l| machine.axis(l).is_some()).map(Site::Joint));
            for site in sites {
                for k in 0..6 {
                    if k >= 3 && !matches!(site, Site::Joint(_)) {
                        continue;
                    }
                    let mut unit = Twist::default();
                    if k < 3 {
                        unit.translation_mm[k] = 1.0;
                    } else {
                        unit.rotation_rad[k - 3] = 1.0;
                    }
                    let at = |scale: f64| {
                        let mut errors = Errors::default();
                        errors.add(site, unit * scale);
                        predict(&machine, &setup, &q, &errors)
                    };
                    let difference = (at(step) - at(-step)) / (2.0 * step);
                    let column = projector.column(site, &unit);
                    assert!(
                        (difference - column).norm() < 1e-5,
                        "{name} {setup:?} {site:?} {k}: {difference} {column}"
                    );
                }
            }
        }
    }
}
