//! From text to expression.
//!
//! sum = product {("+" | "-") product};  product = power {("*" | "/") power};  power = ["-"] atom ["^" power];
//! atom = number | name | function "(" sum {"," sum} ")" | "(" sum ")".  `-x^2` is −(x²).

use super::FormulaError;
use super::expression::{Expression, Function, Node, Operator};
use trunnion_core::names::nearest;

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
const PAIRS: [(&str, Operator); 2] = [("min", Operator::Min), ("max", Operator::Max)];
const FUNCTION_NAMES: &str = "sin cos tan exp log sqrt abs sign step min max";
/// What other languages call things.
const ELSEWHERE: [(&str, &str); 12] = [
    ("ln", "The natural logarithm is log."),
    ("log10", "log is natural: log10(x) is log(x)/log(10)."),
    ("sgn", "Did you mean sign?"),
    ("heaviside", "Did you mean step?"),
    ("sind", "Angles are in rad: sin(x*pi/180)."),
    ("cosd", "Angles are in rad: cos(x*pi/180)."),
    ("pow", "A power is x^y."),
    ("square", "A power is x^2."),
    ("tanh", "Write it with exp: tanh(x) is 1 - 2/(exp(2*x) + 1)."),
    ("atan", "There is no inverse of tan; a soft step is 1/(1 + exp(-x))."),
    ("if", "A condition is step(x): 0 below zero, 1 from zero on."),
    ("cosh", "Write it with exp: cosh(x) is (exp(x) + exp(-x))/2."),
];
/// Deepest nesting (a pair of parentheses counts twice) and longest text; they keep recursion within any stack.
const DEEPEST: usize = 64;
const LONGEST: usize = 2000;

/// True for the name of a function.
pub(super) fn is_function(name: &str) -> bool {
    FUNCTION_NAMES.split(' ').any(|known| known == name)
}

impl Expression {
    /// Reads an expression.
    ///
    /// # Errors
    /// Where it breaks off, what is allowed there, and what to do next.
    pub fn parse(text: &str) -> Result<Self, FormulaError> {
        if text.chars().count() > LONGEST {
            return Err(FormulaError::Syntax {
                column: LONGEST + 1,
                found: "more text".into(),
                allowed: format!("at most {LONGEST} characters"),
                advice: "Write it as several formula effects.".into(),
            });
        }
        let mut parser = Parser { tokens: tokens(text)?, at: 0, depth: 0 };
        let expression = parser.sum()?;
        match parser.peek() {
            Token::End => Ok(expression),
            Token::Sign(')') => {
                Err(parser.unexpected("an operator + - * / ^ or the end", "No bracket is open here."))
            }
            Token::Name(_) | Token::Number(_) | Token::Sign('(') => {
                Err(parser.unexpected("an operator + - * / ^ or the end", "A product needs its *."))
            }
            Token::Sign(_) => Err(parser.unexpected("an operator + - * / ^ or the end", "")),
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
                        advice: String::new(),
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

    fn column(&self) -> usize {
        self.tokens[self.at].0
    }

    fn next(&mut self) -> Token {
        let token = self.peek().clone();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    /// The column of `sign` when it is next.
    fn accept(&mut self, sign: char) -> Option<usize> {
        let column = self.column();
        if *self.peek() != Token::Sign(sign) {
            return None;
        }
        self.next();
        Some(column)
    }

    fn close(&mut self, opened_at: usize, advice: &str) -> Result<(), FormulaError> {
        if self.accept(')').is_some() {
            return Ok(());
        }
        let advice = if *self.peek() == Token::Sign(',') { advice } else { "" };
        Err(self.unexpected(&format!("an operator, or \")\" for the \"(\" of column {opened_at}"), advice))
    }

    fn unexpected(&self, allowed: &str, advice: &str) -> FormulaError {
        let (column, token) = &self.tokens[self.at];
        let found = match token {
            Token::Number(x) => x.to_string(),
            Token::Name(name) => format!("\"{name}\""),
            Token::Sign(c) => format!("\"{c}\""),
            Token::End => "the end".into(),
        };
        let advice = match token {
            Token::Sign(sign) if advice.is_empty() => self.about_sign(*sign),
            _ => advice,
        };
        FormulaError::Syntax { column: *column, found, allowed: allowed.into(), advice: advice.into() }
    }

    /// What a sign that has no place here was probably meant to be.
    fn about_sign(&self, sign: char) -> &'static str {
        let before = self.at.checked_sub(1).map(|i| &self.tokens[i].1);
        match (sign, before) {
            ('*', Some(Token::Sign('*'))) => "A power is x^y.",
            (',', Some(Token::Number(_))) => "The decimal mark is a point.",
            ('<' | '>', _) => "A condition is step(x): 0 below zero, 1 from zero on.",
            ('=', _) => {
                "Only the right-hand side belongs here; what it acts on is said by site and component."
            }
            ('°', _) => "Angles are in rad: 60° is 60*pi/180.",
            ('·' | '×', _) => "A product is written with *.",
            ('−' | '–', _) => "The minus sign is a plain -.",
            ('π', _) => "Write pi.",
            ('²' | '³', _) => "A power is written x^2.",
            ('[' | ']' | '{' | '}', _) => "Only round brackets.",
            ('µ' | 'μ', _) => "Parameters are fitted in µm or µrad by themselves; leave the unit out.",
            _ => "",
        }
    }

    fn deeper(&mut self) -> Result<(), FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.unexpected("fewer levels of parentheses and powers", ""));
        }
        Ok(())
    }

    fn sum(&mut self) -> Result<Expression, FormulaError> {
        self.deeper()?;
        let mut sum = self.product()?;
        loop {
            if let Some(column) = self.accept('+') {
                sum = pair(column, Operator::Sum, sum, self.product()?);
            } else if let Some(column) = self.accept('-') {
                sum = pair(column, Operator::Difference, sum, self.product()?);
            } else {
                self.depth -= 1;
                return Ok(sum);
            }
        }
    }

    fn product(&mut self) -> Result<Expression, FormulaError> {
        let mut product = self.power()?;
        loop {
            if let Some(column) = self.accept('*') {
                product = pair(column, Operator::Product, product, self.power()?);
            } else if let Some(column) = self.accept('/') {
                product = pair(column, Operator::Quotient, product, self.power()?);
            } else {
                return Ok(product);
            }
        }
    }

    fn power(&mut self) -> Result<Expression, FormulaError> {
        self.deeper()?;
        let result = if let Some(column) = self.accept('-') {
            let minus_one = Expression { column, node: Node::Number(-1.0) };
            pair(column, Operator::Product, minus_one, self.power()?)
        } else {
            let base = self.atom()?;
            match self.accept('^') {
                Some(column) => pair(column, Operator::Power, base, self.power()?),
                None => base,
            }
        };
        self.depth -= 1;
        Ok(result)
    }

    fn atom(&mut self) -> Result<Expression, FormulaError> {
        let column = self.column();
        if matches!(self.peek(), Token::Sign(sign) if *sign != '(') || *self.peek() == Token::End {
            return Err(
                self.unexpected(&format!("a number, a name, a function ({FUNCTION_NAMES}) or \"(\""), "")
            );
        }
        let node = match self.next() {
            Token::Number(x) => Node::Number(x),
            Token::Name(name) if *self.peek() == Token::Sign('(') => return self.call(column, &name),
            Token::Name(name) if name == "pi" => Node::Number(std::f64::consts::PI),
            Token::Name(name) if is_function(&name) => {
                return Err(self
                    .unexpected(&format!("\"(\" after the function {name}"), &format!("Write {name}(…).")));
            }
            Token::Name(name) => Node::Name(name),
            Token::Sign(_) | Token::End => {
                let inside = self.sum()?;
                self.close(column, "")?;
                return Ok(inside);
            }
        };
        Ok(Expression { column, node })
    }

    fn call(&mut self, column: usize, name: &str) -> Result<Expression, FormulaError> {
        let opened_at = self.column();
        self.next();
        if let Some((_, operator)) = PAIRS.iter().find(|(known, _)| *known == name) {
            let first = self.sum()?;
            if self.accept(',').is_none() {
                return Err(self.unexpected("\",\"", &format!("{name} takes two values: {name}(x, y).")));
            }
            let second = self.sum()?;
            self.close(opened_at, &format!("{name} takes two values: {name}(x, y)."))?;
            return Ok(pair(column, *operator, first, second));
        }
        let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) else {
            return Err(unknown_function(column, name));
        };
        let inside = self.sum()?;
        self.close(opened_at, &format!("{name} takes one value."))?;
        Ok(Expression { column, node: Node::Call(*function, inside.into()) })
    }
}

fn pair(column: usize, operator: Operator, first: Expression, second: Expression) -> Expression {
    Expression { column, node: Node::Pair(operator, first.into(), second.into()) }
}

fn unknown_function(column: usize, name: &str) -> FormulaError {
    let elsewhere = ELSEWHERE.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, say)| *say);
    let advice = match (elsewhere, nearest(name, FUNCTION_NAMES.split(' '))) {
        (Some(say), _) => say.into(),
        (None, Some(near)) => format!("Did you mean {near}?"),
        (None, None) => format!("A product needs its *: {name}*(…)."),
    };
    FormulaError::Syntax {
        column,
        found: format!("function \"{name}\""),
        allowed: FUNCTION_NAMES.into(),
        advice,
    }
}
