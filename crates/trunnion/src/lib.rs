//! From recordings to answers: the library that command line, service and page share.
//!
//! ```
//! # fn main() -> Result<(), trunnion::Error> {
//! # let points = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity/points.csv");
//! # let other = trunnion::open(points)?;
//! let run = trunnion::open(points)?;
//! let fit = run.fit(&run.base_model())?;
//! let step = fit.diagnose()?.add("gravity-sag:B")?;
//! println!("{}", step.summary());
//! println!("{:.0} % inside the band", 100.0 * step.predict(&other)?.runs[0].inside_95_fraction);
//! # assert!(step.row().error_after_um < step.row().error_before_um);
//! # Ok(())
//! # }
//! ```
//!
//! Every answer is a value of `trunnion-results` ([`results`]): a serde type with a JSON schema. [`Fit::results`],
//! [`Diagnosed::results`] and [`Step::results`] give it, `summary` gives the same as text.

mod added;
mod analysed;
mod analysis;
mod analysis_error;
mod compared;
mod completeness;
mod conformity;
mod correction;
pub mod cycles;
mod diagnosed;
mod error;
mod experiment;
pub mod files;
mod filing;
mod fit;
mod formed;
pub mod foxglove;
pub mod gaps;
pub mod history;
mod identity;
pub mod join;
mod kept;
mod linear;
mod methods;
mod model;
pub mod moment;
pub mod nest;
pub mod page;
mod prediction;
pub mod recorded;
pub mod recording;
mod reduced;
pub mod replay;
pub mod second_opinion;
mod step;
pub mod tables;
pub mod timing;
mod values;

pub use analysed::Analysed;
pub use analysis::FormulaText;
pub use analysis_error::AnalysisError;
pub use compared::{Compared, Trial};
pub use correction::Corrected;
pub use diagnosed::Diagnosed;
pub use error::Error;
pub use experiment::{Experiment, open, open_all, open_runs, open_with, read, read_points};
pub use filing::Filing;
pub use fit::Fit;
pub use formed::{Form, open_formed};
pub use identity::sha256;
pub use kept::keep_in;
pub use methods::{Attributed, Volumetric, attribute_run, method};
pub use model::Model;
pub use step::Step;
pub use trunnion_core::chain;
pub use trunnion_machine::{Machine, TOLERANCE_UM};
pub use trunnion_methods::notation::Notation;
pub use trunnion_methods::recipes::{Convention, MethodOptions, REGISTRY as EVERY_METHOD};
pub use trunnion_methods::volumetric::Datum;
pub use trunnion_report as report;
pub use trunnion_results as results;
pub use trunnion_sync::blocks::Limits;
