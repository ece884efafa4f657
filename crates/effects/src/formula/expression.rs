//! Expressions of formula effects: evaluation, and the structure a fit needs to know.
//!
//! Every node knows its column in the text, so that whatever is wrong with it can be pointed at.

/// A parsed expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// Column of its name, number, function or operator in the text, from 1.
    pub column: usize,
    /// What it is.
    pub node: Node,
}

/// What an expression is.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// A number.
    Number(f64),
    /// A name: a symbol of the state or a parameter.
    Name(String),
    /// Two expressions and an operator or a function of two.
    Pair(Operator, Box<Expression>, Box<Expression>),
    /// A function of one argument.
    Call(Function, Box<Expression>),
}

/// What makes one value of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "their names are their documentation")]
pub enum Operator {
    Sum,
    Difference,
    Product,
    Quotient,
    Power,
    Min,
    Max,
}

/// A function of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "their names are their documentation")]
pub enum Function {
    Sin,
    Cos,
    Tan,
    Exp,
    Log,
    Sqrt,
    Abs,
    Sign,
    /// 0 below zero, 1 from zero on.
    Step,
}

impl Function {
    fn apply(self, x: f64) -> f64 {
        match self {
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Exp => x.exp(),
            Self::Log => x.ln(),
            Self::Sqrt => x.sqrt(),
            Self::Abs => x.abs(),
            Self::Sign if x == 0.0 => 0.0,
            Self::Sign => x.signum(),
            Self::Step => f64::from(u8::from(x >= 0.0)),
        }
    }
}

impl Operator {
    fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Sum => a + b,
            Self::Difference => a - b,
            Self::Product => a * b,
            Self::Quotient => a / b,
            Self::Power => a.powf(b),
            Self::Min => a.min(b),
            Self::Max => a.max(b),
        }
    }
}

impl Expression {
    /// Value with `value_of` the names.
    pub fn value(&self, value_of: &impl Fn(&str) -> f64) -> f64 {
        match &self.node {
            Node::Number(x) => *x,
            Node::Name(name) => value_of(name),
            Node::Pair(operator, a, b) => operator.apply(a.value(value_of), b.value(value_of)),
            Node::Call(function, a) => function.apply(a.value(value_of)),
        }
    }

    /// It and all expressions within it, from left to right of the tree.
    pub fn walk<'a>(&'a self, visit: &mut impl FnMut(&'a Self)) {
        visit(self);
        match &self.node {
            Node::Number(_) | Node::Name(_) => {}
            Node::Call(_, a) => a.walk(visit),
            Node::Pair(_, a, b) => {
                a.walk(visit);
                b.walk(visit);
            }
        }
    }

    /// Names in order of appearance, each once, with the column where it appears first.
    pub fn names(&self) -> Vec<(&str, usize)> {
        let mut names: Vec<(&str, usize)> = Vec::new();
        self.walk(&mut |part| {
            if let Node::Name(name) = &part.node
                && !names.iter().any(|(known, _)| known == name)
            {
                names.push((name, part.column));
            }
        });
        names
    }

    /// Degree as a polynomial in the names that `is_unknown` picks; `None` when it is no polynomial in them.
    pub fn degree(&self, is_unknown: &impl Fn(&str) -> bool) -> Option<u32> {
        let of = |e: &Self| e.degree(is_unknown);
        match &self.node {
            Node::Number(_) => Some(0),
            Node::Name(name) => Some(u32::from(is_unknown(name))),
            Node::Call(_, a) => (of(a)? == 0).then_some(0),
            Node::Pair(operator, a, b) => match operator {
                Operator::Sum | Operator::Difference => Some(of(a)?.max(of(b)?)),
                Operator::Product => Some(of(a)?.saturating_add(of(b)?)),
                Operator::Quotient => (of(b)? == 0).then_some(of(a)?),
                Operator::Min | Operator::Max => (of(a)? == 0 && of(b)? == 0).then_some(0),
                Operator::Power => match (of(a)?, &b.node) {
                    (0, _) => (of(b)? == 0).then_some(0),
                    (degree, Node::Number(n)) if *n >= 1.0 && n.fract() == 0.0 && *n <= 9.0 => {
                        Some(degree.saturating_mul(*n as u32))
                    }
                    _ => None,
                },
            },
        }
    }

    /// The first term that does not vanish, whatever the state, when the names that `is_unknown` picks are zero.
    pub fn term_without(&self, is_unknown: &impl Fn(&str) -> bool) -> Option<&Self> {
        let of = |e: &'_ Self| e.term_without(is_unknown).is_some();
        match &self.node {
            Node::Number(x) => (*x != 0.0).then_some(self),
            Node::Name(name) => (!is_unknown(name)).then_some(self),
            Node::Call(..) | Node::Pair(Operator::Min | Operator::Max, ..) => Some(self),
            Node::Pair(Operator::Sum | Operator::Difference, a, b) => {
                a.term_without(is_unknown).or_else(|| b.term_without(is_unknown))
            }
            Node::Pair(Operator::Product, a, b) => (of(a) && of(b)).then(|| a.leftmost()),
            Node::Pair(Operator::Quotient | Operator::Power, a, _) => of(a).then(|| a.leftmost()),
        }
    }

    fn leftmost(&self) -> &Self {
        match &self.node {
            Node::Pair(operator, a, _) if !matches!(operator, Operator::Min | Operator::Max) => a.leftmost(),
            Node::Pair(..) | Node::Number(_) | Node::Name(_) | Node::Call(..) => self,
        }
    }
}
