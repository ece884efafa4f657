//! A cycle: the poses to visit and the rules for reading there. `config/cycles/*.toml`.

use crate::setup::{Setup, read_setups};
use trunnion_machine::Machine;
use trunnion_units::input::{Document, Table};
use trunnion_units::{AxisLetter, AxisValues, Problems, convert};

/// A cycle file, `format = "trunnion-cycle/1"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Name of the cycle.
    pub name: String,
    /// Machine name or path.
    pub machine: String,
    /// Setups in the order they are measured.
    pub setups: Vec<Setup>,
    /// What is done in each setup.
    pub motion: Motion,
}

/// What a cycle does.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Poses on a grid, read at rest.
    Static {
        /// The axes of the grid, the slowest first.
        grid: Vec<GridAxis>,
        /// +1: grid as written; −1: the whole grid backwards.
        passes: Vec<f64>,
        /// When a point may be read.
        settle: Settle,
    },
    /// One rotary axis turning while sampled, both ways.
    OnTheFly {
        /// The turning axis.
        axis: AxisLetter,
        /// First and last angle, rad.
        from_to_rad: (f64, f64),
        /// Feeds, rad/s; every feed is run forward and back.
        feeds_rad_per_s: Vec<f64>,
        /// Positions of the other rotary axes, rad.
        others: AxisValues<f64>,
    },
}

/// One axis of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridAxis {
    /// Which axis.
    pub letter: AxisLetter,
    /// Its stations in order, mm or rad.
    pub stations: Vec<f64>,
}

/// When a static point may be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settle {
    /// Length of the window that is averaged, s.
    pub window_s: f64,
    /// Largest drift of any channel between the halves of the window, mm.
    pub drift_mm: f64,
    /// Largest robust spread of any channel in the window, mm.
    pub noise_mm: f64,
    /// Largest motion of a linear axis over the window that still counts as standing, mm.
    pub standstill_mm: f64,
    /// Largest motion of a rotary axis over the window that still counts as standing, rad.
    pub standstill_rad: f64,
    /// How long to wait for the point before marking it, s.
    pub timeout_s: f64,
}

/// One pose of a static cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Index of the setup.
    pub setup: usize,
    /// All axes, mm and rad; the linear axes follow the ball.
    pub position: AxisValues<f64>,
    /// Direction of approach of each axis.
    pub direction: AxisValues<f64>,
}

impl Cycle {
    /// Reads a cycle file.
    ///
    /// # Errors
    /// Every problem of the file with its line.
    pub fn parse(file: &str, text: &str) -> Result<Self, Problems> {
        let document = Document::parse(file, text)?;
        let cycle = read(&document);
        document.finish(cycle)
    }

    /// The poses of a static cycle in order; empty for one on the fly. `None` when the machine cannot
    /// follow the ball.
    pub fn poses(&self, machine: &Machine) -> Option<Vec<Pose>> {
        let Motion::Static { grid, passes, .. } = &self.motion else { return Some(Vec::new()) };
        let mut poses = Vec::new();
        for (setup, mounted) in self.setups.iter().enumerate() {
            for &pass in passes {
                let mut stations = grid_positions(grid);
                if pass < 0.0 {
                    stations.reverse();
                }
                for rotary in stations {
                    let position = machine.follow(&rotary, &mounted.ball_in_table_mm)?;
                    let mut direction = AxisValues::default();
                    for axis in grid {
                        direction[axis.letter] = pass;
                    }
                    poses.push(Pose { setup, position, direction });
                }
            }
        }
        Some(poses)
    }
}

fn grid_positions(grid: &[GridAxis]) -> Vec<AxisValues<f64>> {
    grid.iter().fold(vec![AxisValues::default()], |outer, axis| {
        let with = |base: &AxisValues<f64>, station: f64| {
            let mut position = *base;
            position[axis.letter] = station;
            position
        };
        outer.iter().flat_map(|base| axis.stations.iter().map(move |&s| with(base, s))).collect()
    })
}

fn read(document: &Document<'_>) -> Option<Cycle> {
    let root = document.root();
    let format = root.format("trunnion-cycle/1");
    let name = root.string("name");
    let machine = root.string("machine");
    let setups = read_setups(&root);
    let motion = match root.one_of("kind", &["static", "on-the-fly"]).as_deref() {
        Some("static") => read_static(&root),
        Some("on-the-fly") => read_on_the_fly(&root),
        _ => None,
    };
    root.no_other_keys();
    format?;
    Some(Cycle { name: name?, machine: machine?, setups: setups?, motion: motion? })
}

fn read_static(root: &Table<'_>) -> Option<Motion> {
    let tables = root.tables("grid");
    if tables.is_empty() {
        root.problem("grid", "has no entry", "one [[grid]] for each indexed axis, the slowest first", "");
    }
    let grid: Option<Vec<GridAxis>> = tables.iter().map(read_grid_axis).collect();
    let passes = root.strings("passes").and_then(|names| {
        let signs: Option<Vec<f64>> = names
            .iter()
            .map(|name| ["+", "-"].iter().position(|s| s == name).map(|i| [1.0, -1.0][i]))
            .collect();
        if signs.is_none() {
            root.problem("passes", format!("= {names:?}"), "\"+\" (as written) and \"-\" (backwards)", "");
        }
        signs
    });
    let settle = root.table("settle").and_then(|table| {
        let window_s = table.number("window_s", 0.005..=60.0);
        let drift = table.number("drift_um", 0.01..=1000.0);
        let noise = table.number("noise_um", 0.01..=1000.0);
        let standstill_um = table.number("standstill_um", 0.1..=10_000.0);
        let standstill_deg = table.number("standstill_deg", 0.00001..=1.0);
        let timeout_s = table.number("timeout_s", 0.05..=3600.0);
        table.no_other_keys();
        Some(Settle {
            window_s: window_s?,
            drift_mm: convert::mm_from_um(drift?),
            noise_mm: convert::mm_from_um(noise?),
            standstill_mm: convert::mm_from_um(standstill_um?),
            standstill_rad: convert::rad_from_deg(standstill_deg?),
            timeout_s: timeout_s?,
        })
    });
    let grid = grid.filter(|grid| !grid.is_empty())?;
    Some(Motion::Static { grid, passes: passes?, settle: settle? })
}

fn read_grid_axis(table: &Table<'_>) -> Option<GridAxis> {
    let letter = read_letter(table, "axis");
    let from = table.number("from_deg", -36_000.0..=36_000.0);
    let to = table.number("to_deg", -36_000.0..=36_000.0);
    let step = table.number("step_deg", 0.001..=360.0);
    table.no_other_keys();
    let (from, to, step) = (from?, to?, step?);
    let count = ((to - from) / step + 1e-6).floor();
    if !(0.0..=100_000.0).contains(&count) {
        table.problem(
            "step_deg",
            format!("gives {count} steps"),
            "0..=100000 steps from from_deg up to to_deg",
            "",
        );
        return None;
    }
    let stations = (0..=count as usize).map(|i| convert::rad_from_deg(from + step * i as f64)).collect();
    Some(GridAxis { letter: letter?, stations })
}

fn read_on_the_fly(root: &Table<'_>) -> Option<Motion> {
    let table = root.table("sweep")?;
    let axis = read_letter(&table, "axis");
    let from = table.number("from_deg", -36_000.0..=36_000.0);
    let to = table.number("to_deg", -36_000.0..=36_000.0);
    let feeds = table.optional_numbers("feeds_deg_per_min");
    if feeds.as_ref().is_none_or(|feeds| feeds.is_empty() || feeds.iter().any(|&feed| feed <= 0.0)) {
        table.problem("feeds_deg_per_min", "is not a list of feeds", "one or more numbers above 0", "");
    }
    let mut others = AxisValues::default();
    for letter in AxisLetter::ROTARY {
        let key = format!("{}_deg", letter.lower());
        if let Some(deg) = table.optional_number(&key, -36_000.0..=36_000.0) {
            others[letter] = convert::rad_from_deg(deg);
        }
    }
    table.no_other_keys();
    let feeds_rad_per_s = feeds?.into_iter().map(|feed| convert::rad_from_deg(feed) / 60.0).collect();
    let from_to_rad = (convert::rad_from_deg(from?), convert::rad_from_deg(to?));
    Some(Motion::OnTheFly { axis: axis?, from_to_rad, feeds_rad_per_s, others })
}

fn read_letter(table: &Table<'_>, key: &str) -> Option<AxisLetter> {
    AxisLetter::parse(&table.one_of(key, &["A", "B", "C"])?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_machine::shipped;

    #[test]
    fn the_shipped_static_cycle_visits_the_grid_of_oyama_at_two_heights_both_ways() {
        let cycle =
            Cycle::parse("s1.toml", include_str!("../../../config/cycles/r-test-static.toml")).unwrap();
        let poses = cycle.poses(&shipped::machine("table-bc").unwrap()).unwrap();
        assert_eq!(poses.len(), 2 * 2 * 84);
        // first pose of the outside data set: B −90, C 0, ball (150, 0, 60) → X −60, Y 0, Z 150
        let p = poses[0].position;
        assert!((p[AxisLetter::X] + 60.0).abs() < 1e-9 && (p[AxisLetter::Z] - 150.0).abs() < 1e-9);
        assert_eq!(poses[84].direction[AxisLetter::C], -1.0);
    }

    #[test]
    fn a_broken_cycle_names_line_found_and_allowed() {
        let text = include_str!("../../../config/cycles/r-test-static.toml")
            .replace("step_deg = 30", "step_deg = 0");
        let shown = Cycle::parse("c.toml", &text).unwrap_err().to_string();
        assert!(shown.contains("step_deg = 0; allowed: 0.001..=360"), "{shown}");
    }
}
