//! Golden section: where a function of one number is largest.

/// Where `f` is largest between `low` and `high`, taken as unimodal, after `steps` divisions; two evaluations more than steps.
pub fn golden_section(mut low: f64, mut high: f64, steps: usize, f: &mut dyn FnMut(f64) -> f64) -> f64 {
    let ratio = (5_f64.sqrt() - 1.0) / 2.0;
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..steps {
        if at_a > at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - ratio * (high - low);
            at_a = f(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + ratio * (high - low);
            at_b = f(b);
        }
    }
    (low + high) / 2.0
}
