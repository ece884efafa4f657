//! An error with the causes behind it.

use std::error::Error;
use std::iter::successors;

/// The error and every cause behind it, in one line.
pub fn chain(error: &dyn Error) -> String {
    let causes = successors(error.source(), |cause| (*cause).source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt;

    #[derive(Debug)]
    struct Failed(&'static str, Option<Box<Failed>>);

    impl fmt::Display for Failed {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(self.0)
        }
    }

    impl Error for Failed {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            self.1.as_deref().map(|cause| cause as &(dyn Error + 'static))
        }
    }

    #[test]
    fn every_cause_is_in_the_line() {
        let cause = |text, behind| Some(Box::new(Failed(text, behind)));
        let error = Failed("cannot read a.toml", cause("it is gone", cause("the disk is full", None)));
        assert_eq!(chain(&error), "cannot read a.toml: it is gone: the disk is full");
        assert_eq!(chain(&Failed("alone", None)), "alone");
    }
}
