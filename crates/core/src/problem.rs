//! What is wrong with a file a person wrote: where, what was found, what is allowed, what to do next.

use std::fmt;

/// One problem in one place of one file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// File as the user named it.
    pub file: String,
    /// Line, from 1; 0 when the problem is the file as a whole.
    pub line: usize,
    /// Column, from 1; 0 when unknown.
    pub column: usize,
    /// What was found, e.g. `probes.silence_ms = 5`.
    pub found: String,
    /// What is allowed, e.g. `20..=10000`.
    pub allowed: String,
    /// What to do next; may be empty.
    pub advice: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        if self.column > 0 {
            write!(f, ":{}", self.column)?;
        }
        write!(f, ": {}", self.found)?;
        if !self.allowed.is_empty() {
            write!(f, "; allowed: {}", self.allowed)?;
        }
        if !self.advice.is_empty() {
            write!(f, "\n  {}", self.advice)?;
        }
        Ok(())
    }
}

/// Every problem of a file at once. Never empty when it is an `Err`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems(pub Vec<Problem>);

impl Problem {
    /// What makes two problems the same one: everything but where, and which value was found.
    fn kind(&self) -> (&str, String, &str, &str) {
        let mut quoted = false;
        let mut shape = String::new();
        for letter in self.found.chars() {
            if letter == '"' {
                quoted = !quoted;
            }
            if !quoted && !letter.is_ascii_digit() && !"+-.,".contains(letter) {
                shape.push(letter);
            }
        }
        (&self.file, shape, &self.allowed, &self.advice)
    }
}

/// The same problem in many lines is said once, where it first occurs, with how often it comes again.
impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut groups: Vec<(_, &Problem, usize, usize)> = Vec::new();
        for problem in &self.0 {
            let kind = problem.kind();
            match groups.iter_mut().find(|(known, ..)| *known == kind) {
                Some((_, _, again, last)) => {
                    *again += 1;
                    *last = problem.line;
                }
                None => groups.push((kind, problem, 0, problem.line)),
            }
        }
        for (i, (_, problem, again, last)) in groups.into_iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{problem}")?;
            match again {
                0 => {}
                1 => write!(f, "\n  The same once more, in line {last}.")?,
                _ => write!(f, "\n  The same {again} more times, the last in line {last}.")?,
            }
        }
        Ok(())
    }
}

impl std::error::Error for Problems {}

impl From<Problem> for Problems {
    fn from(problem: Problem) -> Self {
        Self(vec![problem])
    }
}
