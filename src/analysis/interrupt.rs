//! A request to stop a long analysis.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::AnalysisError;

/// A request to stop. One thread sets it; the analysis on another thread checks it between its decompositions.
///
/// All clones share one request.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Requests the analysis to stop.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Returns an error if a stop was requested.
    ///
    /// # Errors
    /// [`AnalysisError::Interrupted`] after [`request`](Self::request).
    pub fn check(&self) -> Result<(), AnalysisError> {
        if self.0.load(Ordering::Relaxed) { Err(AnalysisError::Interrupted) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_clone_sees_the_request() {
        let interrupt = Interrupt::default();
        let seen = interrupt.clone();
        assert_eq!(seen.check(), Ok(()));
        interrupt.request();
        assert_eq!(seen.check(), Err(AnalysisError::Interrupted));
    }
}
