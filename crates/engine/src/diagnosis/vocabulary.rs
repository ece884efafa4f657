//! The open grammar on one experiment: families of factors at every carrier (docs/design/statistics.md §4.3).
//!
//! A carrier is a unit displacement or rotation at a site; a term multiplies one or more carriers of one site by the factors of a
//! family at one shape.

use crate::Experiment;
use crate::diagnosis::families::{Carriers, Family, families};
use crate::diagnosis::refine::readable;
use crate::evidence::{evidence_of_gram, parallel};
use crate::noise::learned::Real;
use crate::noise::learned::sigma::Projected;
use crate::noise::machine_noise::{Order, ground_joint, modulated, unit_columns};
use crate::solve::logarithms::log_mean_exp;
use crate::spectrum::Wave;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use trunnion_core::{AxisValues, Joint};
use trunnion_effects::{Formula, ModelEffect};
use trunnion_machine::Site;

/// Names of the components in formulas.
const COMPONENTS: [&str; 6] = ["dx", "dy", "dz", "ea", "eb", "ec"];
/// Carriers that coincide up to a sign beyond this cosine are one.
const SAME_CARRIER: f64 = 0.9999;
/// Eigenvalues of products below this share of the largest are directions that the factors do not have.
const NO_DIRECTION: f64 = 1e-6;
/// Price of each further component of the same site, ln.
pub const SIBLING_LN: f64 = 1.5;

/// The grammar on one experiment.
pub struct Vocabulary {
    pub families: Vec<Family>,
    pub carriers: Vec<Carrier>,
    /// Carriers that go together: those of each site, displacements before rotations.
    sites: Vec<Vec<usize>>,
    /// Factors of all families at all shapes scanned, point × column.
    factors: DMatrix<Real>,
    places: Vec<Place>,
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

/// Where the factors of a family at one shape stand.
struct Place {
    family: usize,
    shape: usize,
    columns: Range<usize>,
}

/// What one term of one carrier scores at one shape of the grid.
#[derive(Clone, Debug)]
pub struct Screened {
    pub term: Term,
    /// Its number in the family's grid.
    pub shape: usize,
    /// ln Bayes factor, shapes averaged.
    pub ln_bf: f64,
}

/// Something said in the grammar.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    pub family: usize,
    /// Carriers of one site, each with parameters of its own.
    pub carriers: Vec<usize>,
}

impl Vocabulary {
    /// Builds the grammar for points whose rows count with the roots `root` of their weights.
    pub fn new(experiment: &Experiment, root: &DVector<f64>, waves: &[(Joint, Wave)]) -> Self {
        let carriers = carriers(experiment, root);
        let families = families(experiment, &Order::new(experiment), waves);
        let mut sites: Vec<Vec<usize>> = Vec::new();
        for (c, carrier) in carriers.iter().enumerate() {
            let like = |site: &&mut Vec<usize>| carriers[site[0]].site == carrier.site;
            match sites.iter_mut().find(like) {
                Some(site) => site.push(c),
                None => sites.push(vec![c]),
            }
        }
        let (mut columns, mut places) = (Vec::new(), Vec::new());
        for (f, family) in families.iter().enumerate().filter(|(_, family)| family.scanned) {
            for (shape, numbers) in family.grid.iter().enumerate() {
                let first = columns.len();
                columns.extend(factors(experiment, family, numbers).into_iter().map(finite));
                places.push(Place { family: f, shape, columns: first..columns.len() });
            }
        }
        let points = experiment.points.len();
        let factors = DMatrix::from_fn(points, columns.len(), |i, j| columns[j][i] as Real);
        let mut vocabulary = Self { families, carriers, sites, factors, places, price_ln: 0.0 };
        let terms = (0..vocabulary.families.len()).filter(|&f| vocabulary.families[f].scanned).map(|f| {
            (0..vocabulary.carriers.len()).filter(|&c| vocabulary.acts(f, c)).count()
                + (0..vocabulary.sites.len()).map(|site| vocabulary.bundles(f, site).len()).sum::<usize>()
        });
        vocabulary.price_ln = (terms.sum::<usize>().max(1) as f64).ln();
        vocabulary
    }

    fn acts(&self, family: usize, carrier: usize) -> bool {
        self.families[family].carriers == Carriers::All || self.carriers[carrier].is_ground
    }

    /// A force both shifts and twists what it pulls at: all displacements, all rotations, and, with one factor, all components of a site.
    fn bundles(&self, family: usize, site: usize) -> Vec<Vec<usize>> {
        let of_site: Vec<usize> =
            self.sites[site].iter().copied().filter(|&c| self.acts(family, c)).collect();
        let turning = of_site.iter().position(|&c| self.carriers[c].component >= 3).unwrap_or(of_site.len());
        let mut bundles = vec![of_site[..turning].to_vec(), of_site[turning..].to_vec()];
        if self.families[family].factors() == 1 {
            bundles.push(of_site);
        }
        bundles.retain(|bundle| bundle.len() > 1);
        bundles.sort();
        bundles.dedup();
        bundles
    }

    /// The terms that may act with this one: its carrier alone, and the bundles of its site.
    pub fn wider(&self, term: &Term) -> Vec<Term> {
        let site = self.sites.iter().position(|site| site.contains(&term.carriers[0]));
        let bundles = site.map_or(Vec::new(), |site| self.bundles(term.family, site));
        bundles.into_iter().map(|carriers| Term { family: term.family, carriers }).collect()
    }

    /// Scores every term of one carrier. fᵀ(c∘P∘c)f: with the carrier taken into P, all factors are one product of the size of
    /// the points, a ninth of the rows squared.
    pub fn screened(&self, experiment: &Experiment, here: &Projected) -> Vec<Screened> {
        let precision = here.precision();
        let of_carriers = parallel(self.carriers.len(), |c| self.of_carrier(experiment, c, here, &precision));
        of_carriers.into_iter().flatten().collect()
    }

    fn of_carrier(
        &self,
        experiment: &Experiment,
        c: usize,
        here: &Projected,
        precision: &DMatrix<Real>,
    ) -> Vec<Screened> {
        let (points, rows) = (experiment.points.len(), experiment.rows());
        let carrier = self.carriers[c].column.map(|x| x as Real);
        let mut pairs: DMatrix<Real> = DMatrix::zeros(points, points);
        let (mut on_readings, mut squares) = (DVector::<Real>::zeros(points), DVector::<Real>::zeros(points));
        for j in 0..points {
            for column in experiment.rows_of(j) {
                on_readings[j] += carrier[column] * here.py[column];
                squares[j] += carrier[column] * carrier[column];
                let of_column = &precision.as_slice()[column * rows..(column + 1) * rows];
                for i in 0..points {
                    let sum: Real = experiment.rows_of(i).map(|row| carrier[row] * of_column[row]).sum();
                    pairs[(i, j)] += carrier[column] * sum;
                }
            }
        }
        let seen = pairs * &self.factors;
        let white = here.sigma.white;
        let mut scores: Vec<(usize, usize, f64)> = Vec::new();
        for place in self.places.iter().filter(|place| self.acts(place.family, c)) {
            let width = place.columns.len();
            if width == 0 {
                continue;
            }
            let factors = self.factors.columns(place.columns.start, width);
            let gram = factors.tr_mul(&seen.columns(place.columns.start, width)).cast::<f64>();
            let z = factors.tr_mul(&on_readings).cast::<f64>();
            let own = DMatrix::from_fn(width, width, |a, b| {
                (0..points).map(|i| f64::from(factors[(i, a)] * squares[i] * factors[(i, b)])).sum()
            });
            let turn = inverse_root(&own) * (rows as f64).sqrt();
            let evidence = evidence_of_gram(&(turn.transpose() * gram * &turn), &turn.tr_mul(&z), white);
            scores.push((place.family, place.shape, evidence.ln_bf));
        }
        let of_family = |family: &[(usize, usize, f64)]| {
            let best = family.iter().max_by(|a, b| a.2.total_cmp(&b.2)).expect("a chunk is not empty");
            let all: Vec<f64> = family.iter().map(|score| score.2).collect();
            let term = Term { family: best.0, carriers: vec![c] };
            Screened { term, shape: best.1, ln_bf: log_mean_exp(&all) }
        };
        scores.chunk_by(|a, b| a.0 == b.0).map(of_family).collect()
    }

    /// Columns of a term at a shape.
    pub fn columns(&self, experiment: &Experiment, term: &Term, shape: &[f64]) -> DMatrix<f64> {
        let factors = factors(experiment, &self.families[term.family], shape);
        let carriers = term.carriers.iter().map(|&c| &self.carriers[c]);
        let columns: Vec<DVector<f64>> = carriers
            .flat_map(|carrier| factors.iter().map(move |of_point| carrier.times(experiment, of_point)))
            .collect();
        DMatrix::from_columns(&columns)
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

/// A factor that is no number anywhere is none.
fn finite(mut factor: Vec<f64>) -> Vec<f64> {
    if factor.iter().any(|x| !x.is_finite()) {
        factor.fill(0.0);
    }
    factor
}

/// R with RᵀSR = 1 on the directions that columns with products S have.
fn inverse_root(products: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = products.clone().symmetric_eigen();
    let least = NO_DIRECTION * eigen.eigenvalues.amax();
    let scale = eigen.eigenvalues.map(|x| if x > least && x > 0.0 { x.sqrt().recip() } else { 0.0 });
    eigen.eigenvectors * DMatrix::from_diagonal(&scale)
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
