//! Named methods, attribution, volumetric accuracy, axis errors and notations of opened runs.

use crate::gaps::Missing;
use crate::{Error, Experiment, Fit, files, open};
use std::path::Path;
use trunnion_core::{AxisValues, Joint, chain, names};
use trunnion_cycles::Cycle;
use trunnion_engine::ExperimentError;
use trunnion_methods::Findings;
use trunnion_methods::attribution::{Attribution, Motion, attribute};
use trunnion_methods::notation::{Layout, Notation};
use trunnion_methods::recipes::{self, Method, MethodOptions};
use trunnion_methods::volumetric::{Datum, Volume, VolumeError, VolumetricMap};
use trunnion_record::Recording;
use trunnion_results as results;

/// Volumetric accuracy of a machine by a fitted model.
pub struct Volumetric {
    answer: results::Volumetric,
    map: results::ErrorMap,
    words: String,
}

/// What the axes' own encoders say of a deviation.
pub struct Attributed {
    /// The answer.
    pub findings: results::Findings,
    /// What is missing from the recording.
    pub missing: Missing,
}

/// The method of the literature with this name.
///
/// # Errors
/// No such method; says which there are.
pub fn method(name: &str) -> Result<&'static Method, Error> {
    Ok(recipes::find(name)?)
}

impl Experiment {
    /// The rotary joint of this name, as the machine file writes it or in another case.
    ///
    /// # Errors
    /// No such joint, or one that is linear; says which there are.
    pub fn rotary_joint(&self, name: &str) -> Result<Joint, Error> {
        let machine = self.machine();
        machine.joint(name).filter(|joint| joint.is_rotary()).ok_or_else(|| Error::NoSuchAxis {
            name: name.into(),
            machine: machine.name.clone(),
            allowed: names::allowed(name, machine.rotary_joints().iter().map(|joint| joint.as_str())),
        })
    }

    /// What a named method of the literature finds in the runs. Of doubted runs that the method cannot use the answer is the doubt, without
    /// values: what is wrong with them may be all that it lacks.
    ///
    /// # Errors
    /// No method of this name, or asked for what it does not have; good runs that lack what it needs.
    pub fn by_method(&self, name: &str, options: &MethodOptions) -> Result<results::Findings, Error> {
        let method = recipes::find(name)?;
        let plausibility = self.plausibility();
        let found = match method.apply(self.runs(), options) {
            Err(refused) if refused.is_of_runs() && !plausibility.is_empty() => {
                not_evaluated(&refused, method.findings(self.runs(), options.convention))
            }
            done => done?,
        };
        Ok(results::Findings { plausibility, ..(&found).into() })
    }

    /// Every named method, with what the runs lack for it.
    pub fn methods(&self) -> results::MethodList {
        let line = |method: &&Method| {
            let done = method.apply(self.runs(), &MethodOptions::default());
            results::MethodLine {
                name: method.name.into(),
                title: method.title.into(),
                source: results::sentences::sources(method.source),
                problem: done.err().map_or_else(String::new, |refused| refused.to_string()),
            }
        };
        let methods = recipes::REGISTRY.iter().map(line).collect();
        results::MethodList { methods, ..results::MethodList::default() }
    }
}

impl Fit {
    /// The location errors in a notation.
    pub fn location_errors(&self, notation: Notation) -> results::LocationErrors {
        let errors = Layout::new(self.experiment().machine()).of_fit(self.identification(), notation);
        results::LocationErrors::new(notation, &errors)
    }

    /// Location and component errors of every axis, for compensation tables.
    ///
    /// # Errors
    /// A model that does not suit the runs.
    pub fn axis_errors(&self) -> Result<results::AxisErrors, Error> {
        let (points, model) = (self.experiment().points(), self.model().entries());
        Ok((&trunnion_methods::AxisErrors::new(points, model, self.identification())?).into())
    }

    /// Deviations of tool against table over a volume, e.g. `X=-200..200,B=-90..90`, at `steps` places along each axis, else at as many as the
    /// model needs; of a point in tool axes (mm).
    ///
    /// # Errors
    /// A volume that the machine does not have.
    pub fn volumetric(
        &self,
        volume: &str,
        steps: Option<usize>,
        point_in_tool_mm: [f64; 3],
        datum: Datum,
    ) -> Result<Volumetric, Error> {
        let experiment = self.experiment();
        let scene = &experiment.points().scene;
        let map_of = |volume: Volume| {
            let volume = Volume { point_in_tool_mm, ..volume };
            let (points, model) = (experiment.points(), self.model().entries());
            let volume = match steps {
                Some(_) => volume,
                None => volume.dense(points, model, self.identification())?,
            };
            VolumetricMap::new(points, model, self.identification(), volume, datum)
        };
        let at_first = steps.unwrap_or(AT_FIRST);
        let asked = Volume::parse(volume, at_first, scene)?;
        let mut words = asked.words(experiment.machine());
        let mut map = map_of(asked)?;
        // An R-test knows nothing of the linear axes: it has a range of the rotary axes, and no volume.
        if volume.is_empty()
            && map.shows_nothing()
            && let Ok(rotary) = Volume::of_rotary_axes(at_first, scene)
        {
            words = format!(
                "{} (the model says nothing of the linear axes, so the rotary axes go over their measured range)",
                rotary.words(experiment.machine())
            );
            map = map_of(rotary)?;
        }
        if map.shows_nothing() {
            return Err(VolumeError::Nothing(words).into());
        }
        let axes = experiment.machine().joints();
        let answer = results::Volumetric::new(&map, &axes);
        Ok(Volumetric { answer, map: results::ErrorMap::new(&map, &axes), words })
    }
}

impl Volumetric {
    /// The answer: `trunnion-volumetric/1`.
    pub fn results(&self) -> results::Volumetric {
        self.answer.clone()
    }

    /// The error map: `trunnion-error-map/1`.
    pub fn error_map(&self) -> &results::ErrorMap {
        &self.map
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        trunnion_report::volumetric_text(&self.answer, &self.words)
    }

    /// The answer as a page of its own.
    pub fn page(&self) -> String {
        trunnion_report::volumetric_html(&self.answer, &self.map, &self.words, &crate::page::label())
    }

    /// The error map as a table.
    pub fn error_map_csv(&self) -> String {
        trunnion_report::error_map_csv(&self.map)
    }
}

/// Places along each axis before the model is asked how many it needs.
const AT_FIRST: usize = 2;

/// Which axis made the deviation of a recording on the fly, from the axes' own encoders. The ideal motion comes from the cycle in
/// the recording, unless `smooth` asks for a smooth path with a knot every `knot_s`. Of a doubted recording that cannot be judged the answer
/// is the doubt, without values.
///
/// # Errors
/// A recording that cannot be read, or a good one that holds no axis positions; knots that do not fit.
pub fn attribute_run(path: &Path, knot_s: f64, smooth: bool) -> Result<Attributed, Error> {
    let recording =
        trunnion_record::read_run(path, &|name| files::machine(name).ok()).map_err(Error::recording(path))?;
    let text = &recording.header.cycle_text;
    let cycle = match text.is_empty() || smooth {
        true => None,
        false => Some(Cycle::parse(&format!("the cycle in {}", path.display()), text)?),
    };
    let run = &recording.run;
    let commanded = if smooth { None } else { commanded(&recording) };
    let attribution = attribute(&Motion {
        run: &run.name,
        machine: &run.machine,
        samples: &recording.axis_samples,
        cycle: cycle.as_ref(),
        commanded: commanded.as_deref(),
        knot_s,
    });
    let doubts = doubts(path);
    let doubted = doubts.as_ref().is_ok_and(|doubts| !doubts.is_empty());
    let found = match (attribution, &recording.damage) {
        (Ok(attribution), _) => attribution.to_findings(),
        (Err(refused), _) if refused.is_of_runs() && doubted => {
            not_evaluated(&refused, Attribution::nothing_found(&run.name, &run.machine.name))
        }
        (Err(_), Some(damage)) => {
            return Err(Error::NothingLeft {
                runs: run.name.clone(),
                losses: format!("{}: {damage}", path.display()),
            });
        }
        (Err(refused), None) => return Err(refused.into()),
    };
    Ok(Attributed {
        findings: results::Findings { plausibility: doubts?, ..(&found).into() },
        missing: Missing::of_samples(path, recording.damage.as_ref())?,
    })
}

/// Where the control asked the axes to be at each of their samples: a table has both in one row. Points that were formed from probes have the positions
/// of the encoders.
fn commanded(recording: &Recording) -> Option<Vec<AxisValues<f64>>> {
    let (samples, points) = (&recording.axis_samples, &recording.run.points);
    let of_a_table = recording.header.probes.is_empty() && points.len() == samples.len();
    let positions = points
        .iter()
        .zip(samples)
        .map(|(point, sample)| (point.state.time_s == Some(sample.time_s)).then_some(point.state.position));
    of_a_table.then(|| positions.collect()).flatten()
}

/// Asked as every command asks it, of points that are formed from the samples again.
fn doubts(path: &Path) -> Result<Vec<results::Plausibility>, Error> {
    match open(path) {
        Ok(experiment) => Ok(experiment.plausibility()),
        // Samples of the axes alone can be attributed too: without points there is nothing that could be doubted.
        Err(Error::Experiment(none)) if matches!(*none, ExperimentError::NoPoints { .. }) => Ok(Vec::new()),
        Err(Error::NothingLeft { .. }) => Ok(Vec::new()),
        Err(failed) => Err(failed),
    }
}

/// Why doubted runs have no values: what is wrong with them may be all that is missing.
fn not_evaluated(refused: &dyn std::error::Error, findings: Findings) -> Findings {
    Findings { notes: vec![format!("Not evaluated: {}.", chain(refused).trim_end_matches('.'))], ..findings }
}
