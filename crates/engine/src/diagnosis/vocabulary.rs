//! The open grammar on one experiment: families of factors at every carrier (docs/design/statistics.md §4.3).
//!
//! A carrier is a unit displacement or rotation at a site; a term multiplies one or more carriers of one site by the factors of a
//! family at one shape.

use crate::Experiment;
use crate::diagnosis::families::{Carriers, Family, families};
use crate::diagnosis::refine::readable;
use crate::evidence::{Group, Library, parallel};
use crate::noise::machine_noise::{Order, ground_joint, modulated, unit_columns};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use trunnion_core::AxisValues;
use trunnion_effects::{Formula, ModelEffect};
use trunnion_machine::Site;

/// Names of the components in formulas.
const COMPONENTS: [&str; 6] = ["dx", "dy", "dz", "ea", "eb", "ec"];
/// Carriers that coincide up to a sign beyond this cosine are one.
const SAME_CARRIER: f64 = 0.9999;
/// Price of each further component of the same site, ln.
pub const SIBLING_LN: f64 = 1.5;

/// The grammar on one experiment.
pub struct Vocabulary {
    /// Columns of all groups, one for each term.
    pub library: Library,
    /// What each group says.
    pub terms: Vec<Term>,
    pub families: Vec<Family>,
    pub carriers: Vec<Carrier>,
    /// ln of the number of terms: what choosing one costs.
    pub price_ln: f64,
}

/// A unit motion at a site.
pub struct Carrier {
    pub site: Site,
    pub component: usize,
    column: DVector<f64>,
    is_ground: bool,
}

/// Where the columns of the grammar go: the carriers of a bundle side by side at each shape, so that one of them and all of
/// them are both a range.
#[derive(Default)]
struct Layout {
    groups: Vec<Group>,
    terms: Vec<Term>,
    /// First column, family, shape, carriers.
    places: Vec<(usize, usize, usize, Vec<usize>)>,
    width: usize,
}

impl Layout {
    fn add(&mut self, f: usize, family: &Family, carriers: &[Carrier], bundle: Vec<usize>) {
        let factors = family.factors();
        let of_shape = bundle.len() * factors;
        let first = self.width;
        self.width += of_shape * family.grid.len();
        let mut group = |of_bundle: Range<usize>| {
            let parts = (0..family.grid.len()).map(|shape| {
                let begin = first + shape * of_shape;
                begin + of_bundle.start * factors..begin + of_bundle.end * factors
            });
            let prior_ln = -family.price_ln - SIBLING_LN * (of_bundle.len() - 1) as f64;
            self.groups.push(Group { parts: parts.collect(), prior_ln, natural: family.natural });
            self.terms.push(Term { family: f, carriers: bundle[of_bundle].to_vec() });
        };
        for k in 0..bundle.len() {
            group(k..k + 1);
        }
        let turning = bundle.iter().position(|&c| carriers[c].component >= 3).unwrap_or(bundle.len());
        let together = [0..turning, turning..bundle.len(), 0..bundle.len()];
        for (i, range) in together.iter().enumerate() {
            // A force both shifts and twists what it pulls at: every component, each with one number.
            let all = i == 2;
            if range.len() > 1 && !together[..i].contains(range) && (!all || factors == 1) {
                group(range.clone());
            }
        }
        for shape in 0..family.grid.len() {
            self.places.push((first + shape * of_shape, f, shape, bundle.clone()));
        }
    }
}

/// Carriers that go together: those of each site, displacements before rotations.
fn bundles(carriers: &[Carrier], wanted: Carriers) -> Vec<Vec<usize>> {
    let mut bundles: Vec<Vec<usize>> = Vec::new();
    for (c, carrier) in carriers.iter().enumerate() {
        if wanted == Carriers::Ground && !carrier.is_ground {
            continue;
        }
        let like = |bundle: &&mut Vec<usize>| carriers[bundle[0]].site == carrier.site;
        match bundles.iter_mut().find(like) {
            Some(bundle) => bundle.push(c),
            None => bundles.push(vec![c]),
        }
    }
    bundles
}

/// Something said in the grammar.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    pub family: usize,
    /// Carriers of one site, each with parameters of its own.
    pub carriers: Vec<usize>,
}

impl Vocabulary {
    /// Builds the grammar for an experiment whose rows count with the roots `root` of their weights.
    pub fn new(experiment: &Experiment, order: &Order, root: &DVector<f64>) -> Self {
        let carriers = carriers(experiment, root);
        let families = families(experiment, order);
        let values = parallel(families.len(), |f| {
            let family = &families[f];
            let grid: &[Vec<f64>] = if family.scanned { &family.grid } else { &[] };
            grid.iter().map(|shape| factors(experiment, family, shape)).collect::<Vec<_>>()
        });
        let mut layout = Layout::default();
        for (f, family) in families.iter().enumerate().filter(|(_, family)| family.scanned) {
            for bundle in bundles(&carriers, family.carriers) {
                layout.add(f, family, &carriers, bundle);
            }
        }
        let price_ln = (layout.terms.len().max(1) as f64).ln();
        for group in &mut layout.groups {
            group.prior_ln -= price_ln;
        }
        let columns = DMatrix::zeros(layout.width, experiment.rows());
        let mut library = Library { columns, groups: layout.groups };
        for (first, family, shape, bundle) in layout.places {
            let factors = &values[family][shape];
            for (k, &carrier) in bundle.iter().enumerate() {
                for (j, of_point) in factors.iter().enumerate() {
                    let column = carriers[carrier].times(experiment, of_point);
                    library.put(first + k * factors.len() + j, column.iter());
                }
            }
        }
        Self { library, terms: layout.terms, families, carriers, price_ln }
    }

    /// Columns of a term (column × row).
    pub fn columns(&self, experiment: &Experiment, term: &Term, shape: &[f64]) -> DMatrix<f64> {
        let factors = factors(experiment, &self.families[term.family], shape);
        let carriers = term.carriers.iter().map(|&c| &self.carriers[c]);
        let columns = carriers.flat_map(|carrier| {
            factors.iter().map(move |of_point| carrier.times(experiment, of_point).transpose())
        });
        DMatrix::from_rows(&columns.collect::<Vec<_>>())
    }

    /// Other families of the same idea.
    pub fn relatives(&self, family: usize) -> Vec<usize> {
        let idea = &self.families[family].idea;
        let others = (0..self.families.len()).filter(|&f| f != family);
        let same = |f: &usize| {
            let other = &self.families[*f];
            other.idea == *idea && (!other.scanned || !other.numbers.is_empty())
        };
        others.filter(same).collect()
    }

    /// Other carriers of the same site.
    pub fn siblings(&self, carrier: usize) -> Vec<usize> {
        let site = self.carriers[carrier].site;
        (0..self.carriers.len()).filter(|&c| c != carrier && self.carriers[c].site == site).collect()
    }

    /// The term as entries of a model file, one for each carrier.
    pub fn entries(&self, term: &Term, shape: &[f64]) -> Vec<ModelEffect> {
        let family = &self.families[term.family];
        let entry = |&c: &usize| {
            let Carrier { site, component, .. } = &self.carriers[c];
            let site = site_text(*site);
            let component = COMPONENTS[*component];
            ModelEffect {
                id: Formula::id_of(&format!("{}-{component}", site.replace(':', "-").to_lowercase())),
                site: Some(site),
                component: Some(component.into()),
                expression: Some(family.expression.clone()),
                shape: readable(shape),
                ..ModelEffect::default()
            }
        };
        term.carriers.iter().map(entry).collect()
    }
}

impl Carrier {
    fn times(&self, experiment: &Experiment, of_point: &[f64]) -> DVector<f64> {
        modulated(experiment, &self.column, |i| of_point[i])
    }
}

/// Values of the factors of a family at every point: one list for each parameter.
fn factors(experiment: &Experiment, family: &Family, shape: &[f64]) -> Vec<Vec<f64>> {
    let count = family.formula.parameters(&experiment.scene).len();
    let mut values = vec![vec![0.0; experiment.points.len()]; count];
    for (i, point) in experiment.points.iter().enumerate() {
        family.formula.motions(&experiment.scene, shape, &point.state, &mut |parameter, _, twist| {
            values[parameter][i] = twist.translation_mm.x;
        });
    }
    values
}

/// Site as written in a formula.
fn site_text(site: Site) -> String {
    match site {
        Site::Joint(letter) => format!("axis:{letter}"),
        Site::TableBall => "ball".into(),
        Site::SpindleBall => "spindle".into(),
        Site::Reading => "reading".into(),
        Site::Instrument(k) => format!("instrument:{k}"),
    }
}

fn carriers(experiment: &Experiment, root: &DVector<f64>) -> Vec<Carrier> {
    let machine = experiment.machine();
    let mut wanted: Vec<(Site, usize)> = Vec::new();
    for axis in machine.rotary() {
        wanted.extend((0..6).map(|k| (Site::Joint(axis.letter), k)));
    }
    wanted.extend((0..3).map(|k| (Site::TableBall, k)));
    // Machine axes; those of the platform where legs carry it.
    let (ground, _) = ground_joint(machine, &AxisValues::default());
    wanted.extend((0..3).map(|k| (ground, k)));
    let ground: Vec<DVector<f64>> = (0..3).map(|k| unit_columns(experiment, ground, k)).collect();
    let mut carriers: Vec<Carrier> = Vec::new();
    for (site, component) in wanted {
        let column = unit_columns(experiment, site, component);
        let same =
            |other: &DVector<f64>| column.dot(other).abs() > SAME_CARRIER * column.norm() * other.norm();
        if column.norm() > 1e-9 && !carriers.iter().any(|carrier| same(&carrier.column)) {
            let is_ground = ground.iter().any(&same);
            carriers.push(Carrier { site, component, column, is_ground });
        }
    }
    for carrier in &mut carriers {
        carrier.column.component_mul_assign(root);
    }
    carriers
}
