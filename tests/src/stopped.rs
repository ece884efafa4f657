//! Programs that end with what started them.

use std::process::Child;

/// A program that is killed when this is dropped, on whatever way out.
pub struct Stopped(pub Child);

impl Drop for Stopped {
    fn drop(&mut self) {
        if let Err(error) = self.0.kill().and_then(|()| self.0.wait()) {
            eprintln!("a program of this test could not be stopped: {error}");
        }
    }
}
