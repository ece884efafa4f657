//! Trials that depend on time, on a computer that may be busy: what failed because it paused is tried again, alone.

use std::future::Future;
use tokio::sync::Semaphore;

/// Attempts at a trial that fails.
const ATTEMPTS: usize = 3;

/// Why an attempt failed.
#[derive(Debug)]
pub enum Failure {
    /// A pause of the computer explains it: it says nothing of what is tried.
    Paused(String),
    /// Other work can also delay without one long pause.
    Doubtful(String),
    /// Nothing but what is tried explains it.
    Wrong(String),
}

/// How a trial went.
#[derive(Debug, PartialEq)]
pub enum Outcome {
    /// At the first attempt.
    Holds,
    /// After attempts in which the computer paused, with these words.
    HoldsAtLast(String),
    /// It failed at first without a pause, with these words, and held then.
    Sporadic(String),
    /// The computer paused in an attempt, and it held in none.
    NotJudged(String),
    /// It does not hold.
    Wrong(String),
}

/// Makes attempts: the first one next to other trials, in one of so many places, every further one alone.
pub async fn judged<A>(name: &str, room: &Semaphore, places: u32, attempt: impl Fn() -> A) -> Outcome
where
    A: Future<Output = Result<(), Failure>>,
{
    let (mut paused, mut doubtful) = (Vec::new(), Vec::new());
    for number in 0..ATTEMPTS {
        let Ok(_places) = room.acquire_many(if number == 0 { 1 } else { places }).await else {
            return Outcome::Wrong(format!("{name}: there is no room for it"));
        };
        match attempt().await {
            Ok(()) if !doubtful.is_empty() => return Outcome::Sporadic(doubtful.join("\n")),
            Ok(()) if !paused.is_empty() => return Outcome::HoldsAtLast(paused.join("\n")),
            Ok(()) => return Outcome::Holds,
            Err(Failure::Wrong(what)) => return Outcome::Wrong(format!("{name}: {what}")),
            Err(Failure::Doubtful(what)) => doubtful.push(format!("{name}: {what}")),
            Err(Failure::Paused(what)) => {
                println!("{name}: not judged, this computer paused: {what}");
                paused.push(format!("{name}: {what}"));
            }
        }
    }
    if paused.is_empty() {
        Outcome::Wrong(doubtful.join("\n"))
    } else {
        Outcome::NotJudged(paused.join("\n"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// How an attempt goes: it holds, or fails so.
    type Attempt = Option<fn(String) -> Failure>;

    async fn outcome(attempts: &[Attempt]) -> Outcome {
        let next = Cell::new(0);
        judged("it", &Semaphore::new(2), 2, || {
            let number = next.replace(next.get() + 1);
            let failure = attempts[number].map(|of| of(number.to_string()));
            async { failure.map_or(Ok(()), Err) }
        })
        .await
    }

    #[tokio::test]
    async fn only_what_the_computer_explains_is_tried_again() {
        use Failure::{Doubtful, Paused, Wrong};
        let words = |words: &str| words.to_owned();
        let cases: [(&[Attempt], Outcome); 7] = [
            (&[None], Outcome::Holds),
            (&[Some(Wrong), None], Outcome::Wrong(words("it: 0"))),
            (&[Some(Paused), None], Outcome::HoldsAtLast(words("it: 0"))),
            (&[Some(Doubtful), None], Outcome::Sporadic(words("it: 0"))),
            (&[Some(Paused), Some(Wrong)], Outcome::Wrong(words("it: 1"))),
            (&[Some(Doubtful), Some(Doubtful), Some(Doubtful)], Outcome::Wrong(words("it: 0\nit: 1\nit: 2"))),
            (&[Some(Doubtful), Some(Paused), Some(Doubtful)], Outcome::NotJudged(words("it: 1"))),
        ];
        for (attempts, expected) in cases {
            assert_eq!(outcome(attempts).await, expected);
        }
    }
}
