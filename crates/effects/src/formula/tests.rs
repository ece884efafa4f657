//! Formulas as people write them.

use super::*;
use crate::{Instance, Scene, UnknownEffect};
use trunnion_machine::shipped;

fn entry(site: &str, component: &str, expression: &str) -> ModelEffect {
    ModelEffect {
        id: "formula:test".into(),
        site: Some(site.into()),
        component: Some(component.into()),
        expression: Some(expression.into()),
        ..ModelEffect::default()
    }
}

fn read(entry: &ModelEffect) -> Result<Formula, FormulaError> {
    Formula::from_model_effect(entry, &shipped::machine("table-bc").unwrap())
}

fn refused(expression: &str) -> String {
    read(&entry("axis:B", "ea", expression)).unwrap_err().to_string()
}

#[test]
fn arithmetic_binds_as_in_books() {
    let value = |text: &str| Expression::parse(text).unwrap().value(&|_| f64::NAN);
    for (text, expected) in [
        ("1 + 2*3", 7.0),
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("8/2/2", 2.0),
        ("1 - 2 - 3", -4.0),
        ("1.5e-3*2E3", 3.0),
        ("max(1, min(2, 3)) + step(0) - sign(-4) + sign(0)", 4.0),
        ("sin(pi/2) + sqrt(abs(-9)) + exp(log(2))", 6.0),
    ] {
        assert!((value(text) - expected).abs() < 1e-12, "{text} = {}", value(text));
    }
}

#[test]
fn parameters_that_enter_linearly_are_distinguished_from_those_that_do_not() {
    let mut sag = entry("axis:B", "dz", "a*(1 - cos(2*B)) + b*sin(n*B + phase)/(1 + w^2)");
    assert!(read(&sag).unwrap_err().to_string().contains("parameter n enters non-linearly"));
    sag.grid = vec![("n".into(), vec![1.0, 2.0]), ("phase".into(), vec![0.0, 0.5]), ("w".into(), vec![0.0])];
    let formula = read(&sag).unwrap();
    assert_eq!(
        (formula.linear, formula.nonlinear),
        (vec!["a".into(), "b".into()], vec!["n".to_string(), "phase".into(), "w".into()])
    );
    assert_eq!(formula.grid.len(), 4);
    // A product of two unknowns is linear in one of them only.
    let product = read(&ModelEffect { shape: vec![2.0], ..entry("ball", "dx", "a*b*C") }).unwrap();
    assert_eq!((product.linear, product.nonlinear), (vec!["a".into()], vec!["b".to_string()]));
}

#[test]
fn joints_of_other_names_are_symbols_of_their_machine() {
    let robot = include_str!("../../../../config/robots/ur5.toml");
    let robot = Machine::parse("robot", "robot.toml", robot).unwrap();
    let sag = entry("axis:j2", "dz", "a*cos(j2) + b*sin(j2 + j3) + c*dirj6 + d*U");
    let formula = Formula::from_model_effect(&ModelEffect { shape: vec![1.0], ..sag.clone() }, &robot);
    // U is an axis of other machines: a parameter here, which is multiplied by another.
    let formula = formula.unwrap();
    assert_eq!((formula.linear.join(" "), formula.nonlinear.join(" ")), ("a b c d".into(), "U".to_string()));
    let mut state = State::default();
    let [_, j2, j3, _, _, j6] = robot.joints()[..] else { panic!("six joints") };
    (state.position[j2], state.position[j3], state.direction[j6]) = (0.5, 0.25, -1.0);
    let scene = Scene::new(robot.clone(), Vec::new(), Vec::new(), std::iter::once(&state));
    let mut found = Vec::new();
    formula.motions(&scene, &[2.0], &state, &mut |_, site, twist| {
        assert_eq!(site, Site::Joint(j2));
        found.push(twist.translation_mm.z);
    });
    assert_eq!(found, [0.5f64.cos(), 0.75f64.sin(), -1.0, 2.0]);
    let unknown = Formula::from_model_effect(&entry("axis:j9", "dz", "a*B"), &robot).unwrap_err().to_string();
    assert!(unknown.contains("axis:j1, axis:j2"), "{unknown}");
    let missing = Formula::from_model_effect(&entry("axis:j1", "dz", "a*B"), &robot).unwrap_err().to_string();
    assert!(missing.contains("an axis machine robot does not have"), "{missing}");
}

#[test]
fn a_formula_moves_what_its_expression_says() {
    let machine = shipped::machine("table-bc").unwrap();
    let states = [0.0, 10.0].map(|time_s| {
        let mut state =
            State { time_s: Some(time_s), temperature_degc: vec![20.0 + time_s], ..State::default() };
        state.position[Joint::B] = 0.5;
        state.direction[Joint::C] = -1.0;
        state
    });
    let scene = Scene::new(machine.clone(), Vec::new(), vec!["spindle".into()], states.iter());
    let drift =
        ModelEffect { shape: vec![5.0], ..entry("axis:B", "eb", "a*B*dirC*(1-exp(-t/tau)) + b*T_spindle") };
    let instance = Instance::from_model_effect(&drift, &machine).unwrap();
    assert_eq!(instance.id(), "formula:test");
    assert_eq!(instance.parameters(&scene).iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    let mut seen = Vec::new();
    instance.motions(&scene, &[5.0], &states[1], &mut |i, site, twist| seen.push((i, site, twist)));
    let expected = -0.5 * (1.0 - (-2.0f64).exp());
    assert_eq!(seen[0], (0, Site::Joint(Joint::B), Twist::rotation(Vector3::y() * expected)));
    assert_eq!(seen[1], (1, Site::Joint(Joint::B), Twist::rotation(Vector3::y() * 10.0)));
    // Without the channel the effect is out of reach rather than silently zero.
    let bare = Scene::new(machine, Vec::new(), Vec::new(), states.iter());
    assert!(instance.parameters(&bare).is_empty());
}

/// Refused expressions with what is said of them, as a person reads it.
const ERRORS: &str = include_str!("errors.txt");

#[test]
fn a_wrong_formula_is_refused_with_the_place_what_is_allowed_and_what_to_do() {
    let expressions = ERRORS.lines().filter_map(|line| line.strip_prefix("> "));
    let found: String = expressions
        .map(|line| {
            // `expression | name = values, …` gives a grid.
            let (expression, grid) = line.split_once(" | ").unwrap_or((line, ""));
            let number = |value: &str| value.parse::<f64>().unwrap();
            let named = |pair: &str| {
                let (name, values) = pair.split_once(" = ").unwrap();
                (name.to_string(), values.split(' ').map(number).collect())
            };
            let grid = grid.split(", ").filter(|pair| !pair.is_empty()).map(named).collect();
            let said = match read(&ModelEffect { grid, ..entry("axis:B", "ea", expression) }) {
                Ok(_) => "accepted".into(),
                Err(error) => error.to_string(),
            };
            format!("> {line}\n{said}\n\n")
        })
        .collect();
    assert!(found.trim() == ERRORS.trim(), "errors.txt is not what is said now:\n{found}");
}

#[test]
fn what_cannot_be_written_in_a_line_is_refused_too() {
    let deep = format!("a*{}B{}", "(".repeat(500), ")".repeat(500));
    assert!(refused(&deep).contains("levels"));
    assert!(refused(&"a+".repeat(100_000)).contains("at most 2000"));
    assert!(read(&entry("ball", "ea", "a*B")).unwrap_err().to_string().contains("allowed: dx, dy, dz"));
    assert!(read(&entry("axis:A", "dx", "a*B")).unwrap_err().to_string().contains("axis:B"));
    let machine = shipped::machine("table-bc").unwrap();
    let unknown =
        Instance::from_model_effect(&ModelEffect { id: "sag".into(), ..Default::default() }, &machine);
    assert!(matches!(unknown, Err(UnknownEffect::Id { .. })));
}

#[test]
fn travel_since_the_reversal_and_acceleration_are_names_of_the_state() {
    let machine = shipped::machine("table-bc").unwrap();
    let mut state = State::default();
    state.since_reversal[Joint::C] = 0.4;
    state.direction[Joint::C] = -1.0;
    state.acceleration[Joint::X] = 50.0;
    let scene = Scene::new(machine.clone(), Vec::new(), Vec::new(), [state.clone()].iter());
    let entry = ModelEffect { shape: vec![0.2], ..entry("axis:C", "ec", "h*dirC*exp(-sinceC/reach) + k*aX") };
    let instance = Instance::from_model_effect(&entry, &machine).unwrap();
    let mut seen = Vec::new();
    instance.motions(&scene, &[0.2], &state, &mut |_, _, twist| seen.push(twist.rotation_rad.z));
    assert_eq!(seen, [-(-2.0f64).exp(), 50.0]);
}

#[test]
fn a_formula_out_of_reach_says_which_channel_it_misses() {
    let machine = shipped::machine("table-bc").unwrap();
    let states = [State { temperature_degc: vec![20.0], ..State::default() }];
    let scene = Scene::new(machine.clone(), Vec::new(), vec!["spindle".into()], states.iter());
    let why = |expression: &str| {
        let entry = entry("axis:B", "dx", expression);
        Instance::from_model_effect(&entry, &machine).unwrap().out_of_reach(&scene)
    };
    assert_eq!(
        why("a*T_spindel").unwrap(),
        "needs temperature channel \"spindel\" for T_spindel; the runs have T_spindle; did you mean T_spindle?"
    );
    assert_eq!(why("a*t").unwrap(), "needs time stamps, for t");
    assert_eq!(why("a*T_spindle"), None);
}
