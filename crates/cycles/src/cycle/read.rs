//! Reading a cycle file.

use super::definition::{Bar, BarFrame, GridAxis, Motion, Rounds, Settle};
use super::{Cycle, Line, Path};
use trunnion_core::input::{Document, Table};
use trunnion_core::setup::read_setups;
use trunnion_core::{AxisValues, Joint, Problems, Setup, convert};

/// Largest angle a cycle file may name, degrees.
const FARTHEST_DEG: f64 = 36_000.0;

/// Poses of one cycle: at a second each, eleven days.
const MOST_POSES: f64 = 1e6;

/// Radii of circles, mm: from the smallest that a cross-grid encoder is for to the length of a laser ball bar.
const RADII_MM: std::ops::RangeInclusive<f64> = 0.1..=20_000.0;

/// The cycle of a document; problems are noted in it.
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
}

fn read(document: &Document<'_>) -> Option<Cycle> {
    let root = document.root();
    let format = root.format("trunnion-cycle/1");
    let name = root.string("name");
    let machine = root.string("machine");
    let setups = read_setups(&root);
    let motion = match root.one_of("kind", &["static", "on-the-fly"]).as_deref() {
        Some("static") if root.has("line") => read_line(&root, setups.as_deref()),
        Some("static") => read_static(&root, setups.as_deref()),
        Some("on-the-fly") if root.has("circle") || root.has("cone") => read_path(&root, setups.as_deref()),
        Some("on-the-fly") => read_on_the_fly(&root),
        _ => None,
    };
    let rounds = root.optional_table("rounds").map_or(Some(Rounds::default()), |table| read_rounds(&table));
    let bar = root.optional_table("bar").map_or(Some(Bar::default()), |table| read_bar(&table));
    root.no_other_keys();
    format?;
    let (setups, motion, rounds) = (setups?, motion?, rounds?);
    let (key, of_a_pass, passes) = match &motion {
        Motion::Static { grid, passes, .. } => {
            ("grid", grid.iter().map(|axis| axis.stations.len() as f64).product::<f64>(), passes.len())
        }
        Motion::Line { line, passes, .. } => ("line", line.steps as f64, passes.len()),
        Motion::OnTheFly { .. } | Motion::Path { .. } => ("sweep", 0.0, 0),
    };
    let passes = passes * setups.len() * rounds.count;
    let poses = of_a_pass * passes as f64;
    if poses > MOST_POSES {
        let found = format!("gives {poses} poses in {passes} passes");
        root.problem(key, found, format!("at most {MOST_POSES} in the whole cycle"), "");
        return None;
    }
    Some(Cycle { name: name?, machine: machine?, setups, motion, rounds, bar: bar? })
}

fn read_rounds(table: &Table<'_>) -> Option<Rounds> {
    let once = Rounds::default();
    let count = match table.has("count") {
        true => table.number("count", 1.0..=1000.0).map(|count| count as usize),
        false => Some(once.count),
    };
    let wait_s = if table.has("wait_s") { table.number("wait_s", 0.0..=86_400.0) } else { Some(once.wait_s) };
    let interleave = table.boolean_or("interleave", once.interleave);
    table.no_other_keys();
    Some(Rounds { count: count?, wait_s: wait_s?, interleave: interleave? })
}

fn read_bar(table: &Table<'_>) -> Option<Bar> {
    let direction = table.vector3("direction");
    let frame = match table.optional_one_of("frame", &["machine", "table"]).as_deref() {
        Some("table") => BarFrame::Table,
        _ => BarFrame::Machine,
    };
    table.no_other_keys();
    let direction = direction?;
    if direction.norm() < 1e-6 {
        table.problem("direction", "has no length", "a vector such as [1, 0, 0]", "");
        return None;
    }
    Some(Bar { direction: convert::unit(direction), frame })
}

fn read_passes(root: &Table<'_>) -> Option<Vec<f64>> {
    let names = root.strings("passes")?;
    let signs: Option<Vec<f64>> =
        names.iter().map(|name| ["+", "-"].iter().position(|s| s == name).map(|i| [1.0, -1.0][i])).collect();
    let signs = signs.filter(|signs| !signs.is_empty());
    if signs.is_none() {
        root.problem("passes", format!("= {names:?}"), "\"+\" (as written) and \"-\" (backwards)", "");
    }
    signs
}

fn read_static(root: &Table<'_>, setups: Option<&[Setup]>) -> Option<Motion> {
    let tables = root.tables("grid");
    // An artefact is measured where it stands.
    let needs_grid = setups.is_none_or(|setups| setups.iter().any(|setup| setup.artefact.is_none()));
    if tables.is_empty() && needs_grid {
        root.problem("grid", "has no entry", "one [[grid]] for each indexed axis, the slowest first", "");
    }
    let grid: Option<Vec<GridAxis>> = tables.iter().map(read_grid_axis).collect();
    let passes = read_passes(root);
    let settle = read_settle(root);
    let grid = grid.filter(|grid| !grid.is_empty() || !needs_grid)?;
    Some(Motion::Static { grid, passes: passes?, settle: settle? })
}

fn read_settle(root: &Table<'_>) -> Option<Settle> {
    let table = root.table("settle")?;
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
}

fn read_line(root: &Table<'_>, setups: Option<&[Setup]>) -> Option<Motion> {
    let passes = read_passes(root);
    let settle = read_settle(root);
    let table = root.table("line")?;
    let length_mm = table.number("length_mm", 1.0..=20_000.0);
    let steps = table.number("steps", 1.0..=10_000.0).map(|steps| steps as usize);
    let in_turn = table.boolean_or("in_turn", false);
    table.no_other_keys();
    if setups.is_some_and(|setups| setups.iter().any(|setup| setup.direction.is_none())) {
        root.problem("line", "has no direction", "direction in every setup, e.g. [1, 1, 1]", "");
        return None;
    }
    let line = Line { length_mm: length_mm?, steps: steps?, in_turn: in_turn? };
    Some(Motion::Line { line, passes: passes?, settle: settle? })
}

fn read_path(root: &Table<'_>, setups: Option<&[Setup]>) -> Option<Motion> {
    let passes = if root.has("passes") { read_passes(root) } else { Some(vec![1.0, -1.0]) };
    let key = if root.has("circle") { "circle" } else { "cone" };
    let table = root.table(key)?;
    let path = if key == "circle" {
        let planes = ["XY", "YZ", "ZX", "YX", "ZY", "XZ"];
        table.one_of("plane", &planes).and_then(|plane| {
            let plane = [Joint::parse(&plane[..1])?, Joint::parse(&plane[1..])?];
            Some(Path::Circle { plane, radius_mm: table.optional_number("radius_mm", RADII_MM) })
        })
    } else {
        let half_angle = table.number("half_angle_deg", 0.0..=80.0);
        let tilt = table.number("tilt_deg", 0.0..=90.0);
        half_angle.zip(tilt).map(|(half_angle, tilt)| Path::Cone {
            half_angle_rad: convert::rad_from_deg(half_angle),
            tilt_rad: convert::rad_from_deg(tilt),
        })
    };
    let from = table.number("from_deg", -FARTHEST_DEG..=FARTHEST_DEG);
    let to = table.number("to_deg", -FARTHEST_DEG..=FARTHEST_DEG);
    let feeds = read_feeds(&table, "feeds_mm_per_min");
    table.no_other_keys();
    let has_radius = matches!(path, Some(Path::Circle { radius_mm: Some(_), .. }));
    let gives_radius = |setup: &Setup| setup.bar_length_mm.is_some() || setup.artefact.is_some();
    if !has_radius && setups.is_some_and(|setups| !setups.iter().all(gives_radius)) {
        let allowed = "bar_length_mm or targets in every setup, which give the radius of the curve; or radius_mm of a circle";
        root.problem(key, "has no radius", allowed, "");
        return None;
    }
    Some(Motion::Path {
        path: path?,
        from_to_rad: (convert::rad_from_deg(from?), convert::rad_from_deg(to?)),
        feeds_mm_per_s: feeds?.into_iter().map(|feed| feed / 60.0).collect(),
        passes: passes?,
    })
}

fn read_feeds(table: &Table<'_>, key: &str) -> Option<Vec<f64>> {
    let feeds = table.optional_numbers(key);
    let usable = feeds.filter(|feeds| !feeds.is_empty() && feeds.iter().all(|&feed| feed > 0.0));
    if usable.is_none() {
        table.problem(key, "is not a list of feeds", "one or more numbers above 0", "");
    }
    usable
}

fn read_grid_axis(table: &Table<'_>) -> Option<GridAxis> {
    let letter = read_grid_joint(table)?;
    // Keys carry the unit of the axis.
    let unit = if letter.is_rotary() { "deg" } else { "mm" };
    let list = format!("stations_{unit}");
    let stations = if table.has(&list) { read_stations(table, &list) } else { read_steps(table, unit) };
    table.no_other_keys();
    let inside = |value: f64| if letter.is_rotary() { convert::rad_from_deg(value) } else { value };
    Some(GridAxis { letter, stations: stations?.into_iter().map(inside).collect() })
}

/// An axis, or a joint of another name, which is rotary (a spindle): stations of it are angles.
fn read_grid_joint(table: &Table<'_>) -> Option<Joint> {
    let name = table.string("axis")?;
    if Joint::parse(&name).is_some() {
        return read_axis(table, "axis", &Joint::ALL);
    }
    match Joint::chain(&[(&name, true)]) {
        Ok(joints) => joints.first().copied(),
        Err(error) => {
            table.problem(
                "axis",
                format!("= \"{name}\": {error}"),
                "X, Y, Z, A, B, C or the name of a spindle",
                "",
            );
            None
        }
    }
}

fn read_stations(table: &Table<'_>, key: &str) -> Option<Vec<f64>> {
    let stations = table.optional_numbers(key)?;
    if stations.is_empty() || stations.iter().any(|station| station.abs() > FARTHEST_DEG) {
        table.problem(key, "is no list of positions", "one or more numbers in -36000..=36000", "");
        return None;
    }
    Some(stations)
}

fn read_steps(table: &Table<'_>, unit: &str) -> Option<Vec<f64>> {
    let (from_key, to_key, step_key) = (format!("from_{unit}"), format!("to_{unit}"), format!("step_{unit}"));
    let from = table.number(&from_key, -FARTHEST_DEG..=FARTHEST_DEG);
    let to = table.number(&to_key, -FARTHEST_DEG..=FARTHEST_DEG);
    let step = table.number(&step_key, 0.001..=1000.0);
    let (from, to, step) = (from?, to?, step?);
    let count = ((to - from) / step + 1e-6).floor();
    if !(0.0..=100_000.0).contains(&count) {
        let allowed = format!("0..=100000 steps from {from_key} up to {to_key}");
        table.problem(&step_key, format!("gives {count} steps"), allowed, "");
        return None;
    }
    Some((0..=count as usize).map(|i| from + step * i as f64).collect())
}

fn read_on_the_fly(root: &Table<'_>) -> Option<Motion> {
    // Forward and back unless the file says otherwise.
    let passes = if root.has("passes") { read_passes(root) } else { Some(vec![1.0, -1.0]) };
    let table = root.table("sweep")?;
    let axis = read_letter(&table, "axis");
    let from = table.number("from_deg", -FARTHEST_DEG..=FARTHEST_DEG);
    let to = table.number("to_deg", -FARTHEST_DEG..=FARTHEST_DEG);
    let feeds = read_feeds(&table, "feeds_deg_per_min");
    let mut others = AxisValues::default();
    for letter in Joint::ROTARY {
        if let Some((first, last)) = read_other(&table, &format!("{}_deg", letter.lower())) {
            others[letter] = (convert::rad_from_deg(first), convert::rad_from_deg(last));
        }
    }
    table.no_other_keys();
    let feeds_rad_per_s = feeds?.into_iter().map(|feed| convert::rad_from_deg(feed) / 60.0).collect();
    let from_to_rad = (convert::rad_from_deg(from?), convert::rad_from_deg(to?));
    Some(Motion::OnTheFly { axis: axis?, from_to_rad, feeds_rad_per_s, passes: passes?, others })
}

/// Where another axis stands, or its first and last angle, degrees.
fn read_other(table: &Table<'_>, key: &str) -> Option<(f64, f64)> {
    if !table.is_array(key) {
        return table.optional_number(key, -FARTHEST_DEG..=FARTHEST_DEG).map(|deg| (deg, deg));
    }
    let deg = table.optional_numbers(key)?;
    match deg[..] {
        [first, last] if first.abs() <= FARTHEST_DEG && last.abs() <= FARTHEST_DEG => Some((first, last)),
        _ => {
            let allowed = "one angle, or the first and the last, in -36000..=36000";
            table.problem(key, format!("= {deg:?}"), allowed, "");
            None
        }
    }
}

fn read_letter(table: &Table<'_>, key: &str) -> Option<Joint> {
    read_axis(table, key, &Joint::ROTARY)
}

/// One of the axes that a cycle can move: other joints have no program here.
fn read_axis(table: &Table<'_>, key: &str, allowed: &[Joint]) -> Option<Joint> {
    let name = table.string(key)?;
    let letter = allowed.iter().copied().find(|letter| letter.as_str() == name);
    if letter.is_none() {
        let allowed: Vec<&str> = allowed.iter().map(|letter| letter.as_str()).collect();
        let advice =
            "Cycles and NC programs move no other joint; import what was measured with one as points.";
        table.problem(key, format!("= \"{name}\""), allowed.join(", "), advice);
    }
    letter
}
