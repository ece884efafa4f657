//! Which cycle is measured: by the program that the controller runs, or by what the operator chose.

use crate::analysis::JudgedBy;
use crate::begun_by::BegunBy;
use crate::live::{Plan, PlanError, check};
use crate::nest_file::with_nest;
use crate::page::page_cycle;
use crate::recording::Texts;
use crate::refused::Refused;
use std::collections::BTreeSet;
use std::path::PathBuf;
use trunnion::Model;
use trunnion::results::PageCycle;
use trunnion_core::names::distance;
use trunnion_sync::NestCalibration;

/// A cycle that the service can measure.
#[derive(Clone, Debug)]
pub struct Choice {
    /// What begins it.
    pub begun_by: BegunBy,
    /// Machine, cycle, nest, channels.
    pub plan: Plan,
    /// What is kept word for word.
    pub texts: Texts,
    /// What its runs are judged by.
    pub model: Model,
    /// The file of this model; none for the base model.
    pub model_file: Option<PathBuf>,
}

/// All of them, in the order of the configuration.
#[derive(Clone, Debug)]
pub struct Cycles(Vec<Choice>);

/// Cycles that one service cannot measure.
#[derive(Debug, thiserror::Error)]
pub enum CyclesError {
    /// The devices cannot measure one.
    #[error("the cycle cannot be measured")]
    Plan(#[from] PlanError),
    /// A service has one machine.
    #[error(
        "cycle {cycle} is of machine {machine}, the first of the configuration of {first}; give each machine a service of its own"
    )]
    OtherMachine {
        /// The cycle.
        cycle: String,
        /// Its machine.
        machine: String,
        /// That of the first cycle.
        first: String,
    },
}

impl Choice {
    /// What its runs are judged by.
    pub fn judged_by(&self) -> JudgedBy {
        JudgedBy { model: Some(self.model.clone()), file: self.model_file.clone() }
    }

    /// The same with these directions of the probes, where they were calibrated after the configuration was read.
    pub fn with_nest(&self, directions: Option<[[f64; 3]; 3]>) -> Self {
        let mut choice = self.clone();
        if let Some(directions) = directions
            && let Some(nest) = NestCalibration::along(directions)
            && let Ok(text) = with_nest(&choice.texts.config, directions)
        {
            (choice.plan.nest, choice.texts.config) = (nest, text);
        }
        choice
    }

    /// For the page.
    pub fn shown(&self) -> PageCycle {
        page_cycle(&self.plan.machine, &self.plan.cycle, &self.begun_by.shown())
    }
}

impl Cycles {
    /// Checks that the devices can measure each, and that all are of one machine.
    ///
    /// # Errors
    /// For the first that is not so.
    pub fn new(choices: Vec<Choice>) -> Result<Self, CyclesError> {
        for Choice { plan, .. } in &choices {
            check(plan)?;
            let (machine, first) = (&plan.machine.name, &choices[0].plan.machine.name);
            if machine != first {
                let cycle = plan.cycle.name.clone();
                return Err(CyclesError::OtherMachine {
                    cycle,
                    machine: machine.clone(),
                    first: first.clone(),
                });
            }
        }
        Ok(Self(choices))
    }

    /// One cycle for every program.
    ///
    /// # Errors
    /// When the devices cannot measure it.
    pub fn one(plan: Plan, texts: Texts, model: Model) -> Result<Self, CyclesError> {
        Self::new(vec![Choice { begun_by: BegunBy::Every, plan, texts, model, model_file: None }])
    }

    /// The cycle of the signal's number, else of the program: the first that is named like it, else that of every program. What the
    /// operator chose comes before all.
    ///
    /// # Errors
    /// When there is none, with the nearest names.
    pub fn find(&self, program: &str, signal: Option<u32>, chosen: Option<&str>) -> Result<&Choice, Refused> {
        if let Some(chosen) = chosen {
            let is_it = |choice: &&Choice| choice.plan.cycle.name == chosen;
            return self.0.iter().find(is_it).ok_or_else(|| Refused::no_cycle(chosen, self.names()));
        }
        let of_signal =
            self.0.iter().find(|choice| matches!(choice.begun_by, BegunBy::Signal(of) if Some(of) == signal));
        let is_named =
            |choice: &&Choice| matches!(&choice.begun_by, BegunBy::Program(name) if name.matches(program));
        let of_every = || self.0.iter().find(|choice| choice.begun_by == BegunBy::Every);
        let by_number = self.0.iter().any(|choice| matches!(choice.begun_by, BegunBy::Signal(_)));
        let refused = || match signal.filter(|_| by_number) {
            Some(signal) => Refused::Signal { signal, allowed: self.beginnings(program) },
            None => Refused::Program { program: program.into(), allowed: self.beginnings(program) },
        };
        of_signal.or_else(|| self.0.iter().find(is_named)).or_else(of_every).ok_or_else(refused)
    }

    /// All.
    pub fn all(&self) -> impl Iterator<Item = &Choice> {
        self.0.iter()
    }

    /// What runs of a cycle of this name are judged by.
    pub fn judged_by(&self, cycle: &str) -> Option<JudgedBy> {
        self.0.iter().find(|choice| choice.plan.cycle.name == cycle).map(Choice::judged_by)
    }

    /// The first of the configuration.
    pub fn first(&self) -> Option<&Choice> {
        self.0.first()
    }

    /// Channels that any of them measures with.
    pub fn needed(&self) -> Vec<u16> {
        let of = |choice: &Choice| check(&choice.plan).unwrap_or_default();
        self.0.iter().flat_map(of).collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Name of their machine; empty without a cycle.
    pub fn machine(&self) -> &str {
        self.0.first().map_or("", |choice| choice.plan.machine.name.as_str())
    }

    /// Names of the cycles.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|choice| choice.plan.cycle.name.as_str())
    }

    /// What begins the cycles: numbers of the signal in their order, then programs, the nearest name first.
    fn beginnings(&self, program: &str) -> String {
        let mut all: Vec<&Choice> = self.0.iter().collect();
        all.sort_by_key(|choice| match &choice.begun_by {
            BegunBy::Signal(number) => (0, *number as usize),
            BegunBy::Program(name) => (1, distance(program, &name.as_str().replace('*', ""))),
            BegunBy::Every => (2, 0),
        });
        let shown =
            |choice: &&Choice| format!("{} (cycle {})", choice.begun_by.shown(), choice.plan.cycle.name);
        all.iter().map(shown).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion::cycles::Cycle;
    use trunnion_core::{Channel, Role};
    use trunnion_sync::NestCalibration;
    use trunnion_sync::cycle_bounds::Pattern;

    const STATIC: &str = include_str!("../../../config/cycles/demo-static.toml");
    const SWEEP: &str = include_str!("../../../config/cycles/demo-sweep-c.toml");

    fn choice(program: Option<&str>, text: &str) -> Choice {
        let cycle = Cycle::parse("c.toml", text).unwrap();
        let machine = trunnion::files::machine(&cycle.machine).unwrap();
        let channel = |k: u8| Channel { device: 0, name: format!("probe-{k}"), role: Role::Probe(k) };
        let nest = NestCalibration::orthogonal();
        let model = Model::base(&machine.name);
        let plan = Plan { machine, cycle, nest, channels: (0..3).map(channel).collect() };
        let texts = Texts { machine: String::new(), cycle: text.into(), config: String::new() };
        let begun_by = program.map_or(BegunBy::Every, |name| BegunBy::Program(Pattern::new(name)));
        Choice { begun_by, plan, texts, model, model_file: None }
    }

    #[test]
    fn a_number_finds_its_cycle_and_the_operator_comes_first() {
        let signal = |number, text| Choice { begun_by: BegunBy::Signal(number), ..choice(None, text) };
        let cycles = Cycles::new(vec![signal(1, STATIC), signal(2, SWEEP)]).unwrap();
        let name =
            |signal, chosen| cycles.find("O1", signal, chosen).map(|choice| choice.plan.cycle.name.clone());
        assert_eq!(name(Some(2), None).unwrap(), "demo-sweep-c");
        assert_eq!(name(Some(2), Some("demo-static")).unwrap(), "demo-static");
        let refused = name(Some(3), None).unwrap_err().to_string();
        assert!(
            refused
                .contains("signal = 3; allowed: signal 1 (cycle demo-static), signal 2 (cycle demo-sweep-c)"),
            "{refused}"
        );
        // Begun by hand while the signal is off, or not known.
        for signal in [None, Some(0)] {
            let refused = name(signal, None).unwrap_err().to_string();
            assert!(refused.contains("allowed: signal 1 (cycle demo-static), "), "{refused}");
        }
    }

    #[test]
    fn a_program_finds_its_cycle_and_the_operator_comes_first() {
        let cycles =
            Cycles::new(vec![choice(Some("*RTEST*"), STATIC), choice(Some("*SWEEP*"), SWEEP)]).unwrap();
        let name = |program: &str, chosen: Option<&str>| {
            cycles.find(program, None, chosen).map(|choice| choice.plan.cycle.name.clone())
        };
        assert_eq!(name("//NC/rtest.mpf", None).unwrap(), "demo-static");
        assert_eq!(name("O0002 (SWEEP C)", None).unwrap(), "demo-sweep-c");
        assert_eq!(name("O0002 (SWEEP C)", Some("demo-static")).unwrap(), "demo-static");
        let refused = name("REST", None).unwrap_err().to_string();
        assert!(
            refused.contains("\"REST\"") && refused.contains("allowed: *rtest* (cycle demo-static)"),
            "{refused}"
        );
        let refused = name("RTEST", Some("demo-sweep")).unwrap_err().to_string();
        assert!(refused.contains("did you mean demo-sweep-c?"), "{refused}");
    }

    #[test]
    fn one_cycle_without_a_program_takes_what_no_other_names() {
        let cycles = Cycles::new(vec![choice(None, STATIC), choice(Some("*SWEEP*"), SWEEP)]).unwrap();
        assert_eq!(cycles.find("sweep", None, None).unwrap().plan.cycle.name, "demo-sweep-c");
        assert_eq!(cycles.find("anything", None, None).unwrap().plan.cycle.name, "demo-static");
    }
}
