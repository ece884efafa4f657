use super::*;
use proptest::prelude::*;
use trunnion_machine::shipped;

fn layout(machine: &str) -> Layout {
    Layout::new(&shipped::machine(machine).unwrap())
}

/// Joint twists in a notation.
fn in_notation(layout: &Layout, notation: Notation, joints: &[(&str, f64)], symbol: &str) -> f64 {
    let at = |name: &str| layout.components.iter().position(|c| c.parameter() == name).unwrap();
    let mut values = DVector::zeros(layout.components.len());
    for (name, value) in joints {
        values[at(name)] = *value;
    }
    let found = layout.from_joints(notation) * values;
    found[layout.components.iter().position(|c| c.symbol(notation) == symbol).unwrap()]
}

#[test]
fn the_examples_of_the_review() {
    // S2 fig. 2: C on A, as table-ac. Absolute values given, relative ones asked for.
    let layout = layout("table-ac");
    let at = |notation, symbol: &str| {
        layout
            .components
            .iter()
            .position(|c| c.symbol(notation) == symbol)
            .unwrap_or_else(|| panic!("no {symbol}"))
    };
    let mut absolute = DVector::zeros(layout.components.len());
    for (symbol, value) in
        [("EB0C", 50e-6), ("EB0A", 20e-6), ("EY0A", 7e-3), ("EC0A", 11e-6), ("EC0Y", 30e-6)]
    {
        absolute[at(Notation::Absolute, symbol)] = value;
    }
    let none = DMatrix::zeros(absolute.len(), absolute.len());
    let (relative, _) = layout.convert(Notation::Absolute, Notation::Relative, &absolute, &none);
    let is = |symbol: &str, value: f64| {
        let found = relative[at(Notation::Relative, symbol)];
        assert!((found - value).abs() < 1e-12, "{symbol}: {found} is not {value}");
    };
    // S2 §2.1: β_CA = E_B0C − E_B0A; table 5: δy_CA = −E_Y0A with the origin in C, and the lines of A against X.
    is("β_CA", 30e-6);
    is("δy_CA", -7e-3);
    is("β_AX", 20e-6);
    is("γ_AX", 11e-6);
    is("δy_AX", 7e-3);
    is("γ_YX", 30e-6);
}

#[test]
fn a_rotary_head_is_against_the_line_of_the_axis_it_hangs_on() {
    let layout = layout("head-bc");
    let relative =
        |joints: &[(&str, f64)], symbol: &str| in_notation(&layout, Notation::Relative, joints, symbol);
    let absolute =
        |joints: &[(&str, f64)], symbol: &str| in_notation(&layout, Notation::Absolute, joints, symbol);
    let lowest =
        shipped::machine("head-bc").unwrap().tool.iter().find(|axis| axis.is_rotary()).unwrap().letter;
    let (name, symbol) = (format!("EA0{lowest}"), format!("α_{lowest}Z"));
    let joints = [(name.as_str(), 40e-6), ("EA0Z", 15e-6)];
    assert!((relative(&joints, &symbol) - 25e-6).abs() < 1e-15);
    assert!((absolute(&joints, &name) - 40e-6).abs() < 1e-15);
    // The spindle's axis is carried by the first one, whose lean it shares.
    assert!((absolute(&[("EA0C", 40e-6), ("EA0B", 15e-6)], "EA0B") - 55e-6).abs() < 1e-15);
}

#[test]
fn squarenesses_of_three_axes_are_the_same_in_both() {
    let layout = layout("three-axis");
    let symbols: Vec<String> = layout.components.iter().map(|c| c.symbol(Notation::Relative)).collect();
    assert_eq!(symbols, ["γ_YX", "β_ZX", "α_ZY"]);
    let identity = DMatrix::identity(3, 3);
    assert_eq!(
        (layout.from_joints(Notation::Relative), layout.from_joints(Notation::Absolute)),
        (&identity, &identity)
    );
}

proptest! {
    #[test]
    fn there_and_back_is_the_same_with_the_same_uncertainty(
        machine in prop::sample::select(vec!["table-bc", "table-ac", "head-bc", "head-a-table-c", "three-axis"]),
        seed in prop::collection::vec(-1e-3..1e-3_f64, 30),
    ) {
        let layout = layout(machine);
        let n = layout.components.len();
        let values = DVector::from_fn(n, |i, _| seed[i]);
        let root = DMatrix::from_fn(n, n, |i, j| seed[(7 * i + 3 * j) % 30]);
        let covariance = &root * root.transpose();
        let (relative, of_relative) = layout.convert(Notation::Absolute, Notation::Relative, &values, &covariance);
        let (back, of_back) = layout.convert(Notation::Relative, Notation::Absolute, &relative, &of_relative);
        prop_assert!((back - &values).amax() < 1e-12);
        prop_assert!((of_back - &covariance).amax() < 1e-12);
    }
}
