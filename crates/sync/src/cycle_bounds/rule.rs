//! What begins a cycle: the table `[cycle_start]`.

use trunnion_core::input::Table;

/// What begins a cycle.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum StartRule {
    /// The controller runs a program.
    #[default]
    Execution,
    /// The controller runs a program with this name.
    Program(Pattern),
    /// Blocks with these texts begin and end it.
    Block {
        /// First block.
        begin: Pattern,
        /// Last block; without one the end of the program.
        end: Option<Pattern>,
    },
    /// The signal of the controller is on.
    Signal,
    /// Stands of these lengths one after the other, s.
    Dwells {
        /// The stands in order.
        dwells_s: Vec<f64>,
        /// Standing so long ends the cycle, s.
        still_s: f64,
    },
    /// Motion after standing.
    Motion {
        /// Standing so long before, s.
        rest_s: f64,
        /// Standing so long ends the cycle, s.
        still_s: f64,
    },
}

/// A text in which `*` stands for anything; upper and lower case are alike.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern(String);

impl Pattern {
    /// As written.
    pub fn new(text: &str) -> Self {
        Self(text.to_lowercase())
    }

    /// The pattern, in lower case.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// True when the whole of `text` is like the pattern.
    pub fn matches(&self, text: &str) -> bool {
        let text = text.to_lowercase();
        let Some((head, rest)) = self.0.split_once('*') else { return self.0 == text };
        let (middle, tail) = rest.rsplit_once('*').unwrap_or(("", rest));
        let Some(mut left) = text.strip_prefix(head).and_then(|text| text.strip_suffix(tail)) else {
            return false;
        };
        middle.split('*').all(|piece| match left.find(piece) {
            Some(at) => {
                left = &left[at + piece.len()..];
                true
            }
            None => false,
        })
    }
}

impl StartRule {
    const NAMES: [&'static str; 6] = ["execution", "program", "block", "signal", "dwells", "motion"];

    /// Reads `[cycle_start]`; without the table, [`StartRule::Execution`].
    pub fn read(root: &Table<'_>) -> Option<Self> {
        let Some(table) = root.optional_table("cycle_start") else { return Some(Self::default()) };
        let still_s = || table.optional_number("still_s", 1.0..=3600.0).unwrap_or(60.0);
        let pattern = |key: &str| table.string(key).map(|text| Pattern::new(&text));
        let rule = match table.one_of("by", &Self::NAMES)?.as_str() {
            "program" => Self::Program(pattern("program")?),
            "block" => Self::Block {
                begin: pattern("begin")?,
                end: table.optional_string("end").map(|text| Pattern::new(&text)),
            },
            "signal" => Self::Signal,
            "dwells" => Self::Dwells { dwells_s: read_dwells(&table)?, still_s: still_s() },
            "motion" => {
                let rest_s = table.optional_number("rest_s", 0.2..=600.0).unwrap_or(2.0);
                Self::Motion { rest_s, still_s: still_s() }
            }
            _ => Self::Execution,
        };
        table.no_other_keys();
        Some(rule)
    }

    /// What is waited for, for the log.
    pub fn about(&self) -> String {
        match self {
            Self::Execution => "the controller to run a program".into(),
            Self::Program(Pattern(name)) => format!("the controller to run the program {name}"),
            Self::Block { begin: Pattern(text), .. } => format!("the block {text}"),
            Self::Signal => "the controller's signal".into(),
            Self::Dwells { dwells_s, .. } => format!("stands of {dwells_s:?} s"),
            Self::Motion { rest_s, .. } => format!("motion after {rest_s} s of standing"),
        }
    }
}

fn read_dwells(table: &Table<'_>) -> Option<Vec<f64>> {
    let dwells_s = table.optional_numbers("dwells_s");
    match dwells_s {
        Some(dwells_s) if !dwells_s.is_empty() && dwells_s.iter().all(|s| (0.5..=60.0).contains(s)) => {
            Some(dwells_s)
        }
        found => {
            let advice = "Give the stands at the head of the NC program, for example [2.0, 1.0, 2.0].";
            table.problem("dwells_s", format!("= {found:?}"), "one number or more, each 0.5..=60", advice);
            None
        }
    }
}
