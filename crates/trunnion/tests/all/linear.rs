//! What-if to first order shows the figures of the fits.

use std::path::PathBuf;
use trunnion::results::{Linear, LinearSolution};
use trunnion::{FormulaText, Model};

fn open(folder: &str) -> trunnion::Experiment {
    let data = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    trunnion::open(data.join(folder).join("points.csv")).unwrap()
}

/// Root mean square of the residual of a solution, as a page computes it.
fn rms_um(linear: &Linear, solution: &LinearSolution) -> f64 {
    let mut residual = linear.residual_um.clone();
    residual.iter_mut().zip(&solution.change_um).for_each(|(r, change)| *r -= change);
    let mut row = 0;
    let (mut sum, mut count) = (0.0, 0);
    for (i, point) in linear.points.iter().enumerate() {
        let rows = row..row + linear.setups[point.setup].components.len();
        row = rows.end;
        if !solution.excluded.contains(&i) {
            count += rows.len();
            sum += residual[rows].iter().map(|r| r * r).sum::<f64>();
        }
    }
    (sum / count as f64).sqrt()
}

#[test]
fn effects_on_and_off_give_the_figures_of_the_fits() {
    let run = open("points-backlash-and-drift");
    let first = run.fit(&run.base_model()).unwrap().diagnose().unwrap();
    let step = first.add(&first.best().unwrap()).unwrap().dated("2026-03-01").unwrap();
    for diagnosed in [first, step.diagnose().unwrap()] {
        let linear = diagnosed.linear().unwrap();
        assert!(linear.solutions.len() > 1, "nothing to switch");
        for solution in &linear.solutions {
            // The prediction of a fit is exact, that of a page is linear.
            let (page, fit) = (rms_um(&linear, solution), solution.rms_um);
            assert!((page - fit).abs() < 2e-3 * fit, "{}: {page} {fit}", solution.changed);
        }
    }
}

#[test]
fn an_added_effect_can_be_switched_off_again() {
    let run = open("points-gravity");
    let base = run.fit(&Model::base("table-bc")).unwrap();
    let step = base.add("gravity-sag:B").unwrap().dated("2026-03-01").unwrap().by("Ada").unwrap();
    assert_eq!(step.row().by.as_deref(), Some("Ada"));
    let read = Model::parse("model.toml", step.model().text().into()).unwrap();
    assert_eq!(read.ladder().rows.last().unwrap().ladder.as_ref().unwrap().by.as_deref(), Some("Ada"));
    let linear = step.diagnose().unwrap().linear().unwrap();
    let off = linear.solutions.iter().find(|solution| solution.changed == "gravity-sag:B").unwrap();
    assert!(off.without && (off.rms_um - base.results().rms_um).abs() < 1e-9);
}

#[test]
fn an_expression_is_switched_as_an_effect_of_the_catalogue() {
    let run = open("points-gravity");
    let base = run.fit(&Model::base("table-bc")).unwrap();
    // Written by hand, so that nothing measured its ladder row.
    let of_hand = "\n[[effect]]\nid = \"formula:sag\"\nsite = \"axis:B\"\ncomponent = \"dz\"\nexpression = \"k*(1 - cos(2*B))\"\n";
    let model = Model::parse("model.toml", base.model().text().to_owned() + of_hand).unwrap();
    let fit = run.fit(&model).unwrap();
    let linear = fit.diagnose().unwrap().linear().unwrap();
    let off = linear.solutions.iter().find(|solution| solution.changed == "formula:sag").unwrap();
    assert!(off.without && (off.rms_um - base.results().rms_um).abs() < 1e-9, "{}", off.rms_um);
    let page = rms_um(&linear, off);
    assert!((page - base.results().rms_um).abs() < 2e-3 * page, "{page}");
    // The same as it is typed on a page, next to the model without it.
    let text = |text: &str| Some(text.to_string());
    let [site, component, expression] = [text("axis:B"), text("dz"), text("k*(1 - cos(2*B))")];
    let typed = FormulaText { site, component, expression, grid: Vec::new() };
    let [alone, with] = &base.diagnose().unwrap().linear_with(&typed).unwrap().solutions[..] else {
        panic!("the model, and the model with it")
    };
    assert!((alone.rms_um - off.rms_um).abs() < 1e-6 && (with.rms_um - fit.results().rms_um).abs() < 1e-6);
    assert!(!with.without && with.title == "axis:B dz: k*(1 - cos(2*B))", "{}", with.title);
    // What a diagnosis proposes is offered next to named effects.
    let diagnosed = open("points-unnamed").fit(&Model::base("table-bc")).unwrap().diagnose().unwrap();
    let proposed =
        trunnion::results::sentences::formula_id(&diagnosed.results().formula.expect("an expression"));
    let solutions = diagnosed.linear().unwrap().solutions;
    assert!(solutions.iter().any(|solution| solution.changed == proposed), "{proposed}");
}

#[test]
fn an_expression_is_checked_as_it_is_typed() {
    let run = open("points-gravity");
    let check = |expression: &str| {
        let text = |text: &str| Some(text.to_string());
        run.check_formula(&FormulaText {
            site: text("axis:B"),
            component: text("dz"),
            expression: text(expression),
            grid: Vec::new(),
        })
    };
    let good = check("k*sin(2*B)");
    assert!(good.valid && good.parameters == ["k"] && good.problem.is_empty(), "{good:?}");
    let half = check("k*sin(2*");
    assert!(!half.valid && half.problem.contains("column"), "{half:?}");
    let degrees = check("k*sin(B_deg)");
    assert!(!degrees.valid && degrees.problem.contains("B_deg"), "{degrees:?}");
}
