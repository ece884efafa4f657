//! Expressions of formula effects: grammar, evaluation, and the structure a fit needs to know.
//!
//! sum = product {("+" | "-") product};  product = power {("*" | "/") power};  power = ["-"] atom ["^" power];
//! atom = number | name | function "(" sum {"," sum} ")" | "(" sum ")".  `-x^2` is −(x²).

use super::FormulaError;

/// A parsed expression.
#[derive(Clone, Debug, PartialEq)]
pub enum Expression {
    /// A number.
    Number(f64),
    /// A name: a symbol of the state or a parameter.
    Name(String),
    /// a + b
    Sum(Box<Self>, Box<Self>),
    /// a − b
    Difference(Box<Self>, Box<Self>),
    /// a · b
    Product(Box<Self>, Box<Self>),
    /// a / b
    Quotient(Box<Self>, Box<Self>),
    /// a ^ b
    Power(Box<Self>, Box<Self>),
    /// A function of one argument.
    Call(Function, Box<Self>),
    /// min(a, b)
    Min(Box<Self>, Box<Self>),
    /// max(a, b)
    Max(Box<Self>, Box<Self>),
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

const FUNCTIONS: [(&str, Function); 9] = [
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("exp", Function::Exp),
    ("log", Function::Log),
    ("sqrt", Function::Sqrt),
    ("abs", Function::Abs),
    ("sign", Function::Sign),
    ("step", Function::Step),
];
const FUNCTION_NAMES: &str = "sin cos tan exp log sqrt abs sign step min max";
/// Deepest nesting (a pair of parentheses counts twice) and longest text; they keep recursion within any stack.
const DEEPEST: usize = 64;
const LONGEST: usize = 2000;

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

impl Expression {
    /// Reads `text`.
    ///
    /// # Errors
    /// The first place that does not fit, with its column, what was found and what is allowed.
    pub fn parse(text: &str) -> Result<Self, FormulaError> {
        if text.len() > LONGEST {
            return Err(FormulaError::Syntax {
                column: LONGEST + 1,
                found: format!("{} characters", text.len()),
                allowed: format!("at most {LONGEST}; split it into several formulas"),
            });
        }
        let mut parser = Parser { tokens: tokens(text)?, at: 0, depth: 0 };
        let expression = parser.sum()?;
        match parser.peek() {
            Token::End => Ok(expression),
            _ => Err(parser.unexpected("an operator + - * / ^ or the end")),
        }
    }

    /// Value with `value_of` the names.
    pub fn value(&self, value_of: &impl Fn(&str) -> f64) -> f64 {
        let of = |e: &Self| e.value(value_of);
        match self {
            Self::Number(x) => *x,
            Self::Name(name) => value_of(name),
            Self::Sum(a, b) => of(a) + of(b),
            Self::Difference(a, b) => of(a) - of(b),
            Self::Product(a, b) => of(a) * of(b),
            Self::Quotient(a, b) => of(a) / of(b),
            Self::Power(a, b) => of(a).powf(of(b)),
            Self::Call(function, a) => function.apply(of(a)),
            Self::Min(a, b) => of(a).min(of(b)),
            Self::Max(a, b) => of(a).max(of(b)),
        }
    }

    /// Names in order of appearance, each once.
    pub fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        self.collect_names(&mut names);
        names
    }

    fn collect_names(&self, names: &mut Vec<String>) {
        match self {
            Self::Number(_) => {}
            Self::Name(name) if names.contains(name) => {}
            Self::Name(name) => names.push(name.clone()),
            Self::Call(_, a) => a.collect_names(names),
            Self::Sum(a, b)
            | Self::Difference(a, b)
            | Self::Product(a, b)
            | Self::Quotient(a, b)
            | Self::Power(a, b)
            | Self::Min(a, b)
            | Self::Max(a, b) => {
                a.collect_names(names);
                b.collect_names(names);
            }
        }
    }

    /// Degree as a polynomial in the names that `is_unknown` picks; `None` when it is no polynomial in them.
    pub fn degree(&self, is_unknown: &impl Fn(&str) -> bool) -> Option<u32> {
        let of = |e: &Self| e.degree(is_unknown);
        match self {
            Self::Number(_) => Some(0),
            Self::Name(name) => Some(u32::from(is_unknown(name))),
            Self::Sum(a, b) | Self::Difference(a, b) => Some(of(a)?.max(of(b)?)),
            Self::Product(a, b) => Some(of(a)?.saturating_add(of(b)?)),
            Self::Quotient(a, b) => (of(b)? == 0).then_some(of(a)?),
            Self::Power(a, b) => match (of(a)?, &**b) {
                (0, exponent) => (of(exponent)? == 0).then_some(0),
                (degree, Self::Number(n)) if *n >= 1.0 && n.fract() == 0.0 && *n <= 9.0 => {
                    Some(degree.saturating_mul(*n as u32))
                }
                _ => None,
            },
            Self::Call(_, a) => (of(a)? == 0).then_some(0),
            Self::Min(a, b) | Self::Max(a, b) => (of(a)? == 0 && of(b)? == 0).then_some(0),
        }
    }

    /// True when it is zero, whatever the state, once the names that `is_unknown` picks are zero.
    pub fn vanishes_without(&self, is_unknown: &impl Fn(&str) -> bool) -> bool {
        let of = |e: &Self| e.vanishes_without(is_unknown);
        match self {
            Self::Number(x) => *x == 0.0,
            Self::Name(name) => is_unknown(name),
            Self::Sum(a, b) | Self::Difference(a, b) => of(a) && of(b),
            Self::Product(a, b) => of(a) || of(b),
            Self::Quotient(a, _) | Self::Power(a, _) => of(a),
            Self::Call(..) | Self::Min(..) | Self::Max(..) => false,
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Sign(char),
    End,
}

/// Tokens with their column, from 1; the last is `End`.
fn tokens(text: &str) -> Result<Vec<(usize, Token)>, FormulaError> {
    let characters: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < characters.len() {
        let (start, c) = (i, characters[i]);
        let take = |from: usize, keep: &dyn Fn(usize) -> bool| {
            (from..characters.len()).find(|&k| !keep(k)).unwrap_or(characters.len())
        };
        if c.is_whitespace() {
            i += 1;
            continue;
        }
        let token = if c.is_ascii_digit() || c == '.' {
            // 1e-3: a sign right after the e belongs to the number.
            i = take(start, &|k| {
                let x = characters[k];
                x.is_ascii_digit()
                    || x == '.'
                    || (matches!(x, 'e' | 'E') && characters.get(k + 1).is_some_and(|y| !y.is_alphabetic()))
                    || (matches!(x, '+' | '-') && k > start && matches!(characters[k - 1], 'e' | 'E'))
            });
            let found: String = characters[start..i].iter().collect();
            match found.parse() {
                Ok(number) => Token::Number(number),
                Err(_) => {
                    return Err(FormulaError::Syntax {
                        column: start + 1,
                        found: format!("\"{found}\""),
                        allowed: "a number such as 0.5 or 1e-3".into(),
                    });
                }
            }
        } else if c.is_ascii_alphabetic() || c == '_' {
            i = take(start, &|k| characters[k].is_ascii_alphanumeric() || characters[k] == '_');
            Token::Name(characters[start..i].iter().collect())
        } else {
            i += 1;
            Token::Sign(c)
        };
        tokens.push((start + 1, token));
    }
    tokens.push((characters.len() + 1, Token::End));
    Ok(tokens)
}

struct Parser {
    tokens: Vec<(usize, Token)>,
    at: usize,
    depth: usize,
}

impl Parser {
    fn peek(&self) -> &Token {
        &self.tokens[self.at].1
    }

    fn next(&mut self) -> Token {
        let token = self.peek().clone();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    fn accept(&mut self, sign: char) -> bool {
        let found = *self.peek() == Token::Sign(sign);
        if found {
            self.next();
        }
        found
    }

    fn expect(&mut self, sign: char) -> Result<(), FormulaError> {
        if self.accept(sign) { Ok(()) } else { Err(self.unexpected(&format!("\"{sign}\""))) }
    }

    fn unexpected(&self, allowed: &str) -> FormulaError {
        let (column, token) = &self.tokens[self.at];
        let found = match token {
            Token::Number(x) => x.to_string(),
            Token::Name(name) => format!("\"{name}\""),
            Token::Sign(c) => format!("\"{c}\""),
            Token::End => "the end".into(),
        };
        FormulaError::Syntax { column: *column, found, allowed: allowed.into() }
    }

    fn sum(&mut self) -> Result<Expression, FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.unexpected("fewer levels of parentheses and powers"));
        }
        let mut sum = self.product()?;
        loop {
            if self.accept('+') {
                sum = Expression::Sum(sum.into(), self.product()?.into());
            } else if self.accept('-') {
                sum = Expression::Difference(sum.into(), self.product()?.into());
            } else {
                self.depth -= 1;
                return Ok(sum);
            }
        }
    }

    fn product(&mut self) -> Result<Expression, FormulaError> {
        let mut product = self.power()?;
        loop {
            if self.accept('*') {
                product = Expression::Product(product.into(), self.power()?.into());
            } else if self.accept('/') {
                product = Expression::Quotient(product.into(), self.power()?.into());
            } else {
                return Ok(product);
            }
        }
    }

    fn power(&mut self) -> Result<Expression, FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.unexpected("fewer levels of parentheses and powers"));
        }
        let result = if self.accept('-') {
            Expression::Product(Expression::Number(-1.0).into(), self.power()?.into())
        } else {
            let base = self.atom()?;
            if self.accept('^') { Expression::Power(base.into(), self.power()?.into()) } else { base }
        };
        self.depth -= 1;
        Ok(result)
    }

    fn atom(&mut self) -> Result<Expression, FormulaError> {
        let here = self.unexpected(&format!("a number, a name, a function ({FUNCTION_NAMES}) or \"(\""));
        match self.next() {
            Token::Number(x) => Ok(Expression::Number(x)),
            Token::Sign('(') => {
                let inside = self.sum()?;
                self.expect(')')?;
                Ok(inside)
            }
            Token::Name(name) if *self.peek() == Token::Sign('(') => self.call(&name),
            Token::Name(name) if name == "pi" => Ok(Expression::Number(std::f64::consts::PI)),
            Token::Name(name) => Ok(Expression::Name(name)),
            Token::Sign(_) | Token::End => Err(here),
        }
    }

    fn call(&mut self, name: &str) -> Result<Expression, FormulaError> {
        let column = self.tokens[self.at - 1].0;
        self.expect('(')?;
        let first = self.sum()?;
        let expression = match name {
            "min" | "max" => {
                self.expect(',')?;
                let second = self.sum()?;
                if name == "min" {
                    Expression::Min(first.into(), second.into())
                } else {
                    Expression::Max(first.into(), second.into())
                }
            }
            _ => match FUNCTIONS.iter().find(|(known, _)| *known == name) {
                Some((_, function)) => Expression::Call(*function, first.into()),
                None => {
                    return Err(FormulaError::Syntax {
                        column,
                        found: format!("function \"{name}\""),
                        allowed: FUNCTION_NAMES.into(),
                    });
                }
            },
        };
        self.expect(')')?;
        Ok(expression)
    }
}
