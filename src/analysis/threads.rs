//! Independent points of an analysis, such as speeds or frequencies, on several threads.
//!
//! Results come in the order of the points, and are the same to the last bit for any number of threads: each follows from its
//! point alone. What follows from the previous point, such as an equilibrium, is prepared on one thread.
//!
//! Each analysis has its own threads. A process that is forked between two analyses therefore has none that are missing.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::AnalysisError;

/// Stack size of a thread, bytes; the usual size of a main thread.
pub const STACK: usize = 8 << 20;
/// Number of points for each thread that are prepared together: enough to keep all threads busy, and little memory.
const POINTS_PER_THREAD: usize = 16;

/// The threads of one analysis.
#[derive(Debug)]
pub struct Threads(Option<ThreadPool>);

impl Threads {
    /// At most `count` threads for `points` points. Where the system gives no more threads, the calling one does the work.
    pub fn new(count: usize, points: usize) -> Self {
        let count = count.min(points);
        let pool = || ThreadPoolBuilder::new().num_threads(count).stack_size(STACK).build().ok();
        Self(if count > 1 { pool() } else { None })
    }

    /// `compute` of all points in their order.
    ///
    /// # Errors
    /// The error of the first point that has no result.
    pub fn map<P: Sync, R: Send>(
        &self,
        points: &[P],
        compute: impl Fn(&P) -> Result<R, AnalysisError> + Sync,
    ) -> Result<Vec<R>, AnalysisError> {
        let Some(pool) = &self.0 else {
            return points.iter().map(compute).collect();
        };
        // A point after one that has no result is left out.
        let end = AtomicUsize::new(usize::MAX);
        let one = |(index, point): (usize, &P)| {
            if index > end.load(Ordering::Relaxed) {
                return None;
            }
            let found = compute(point);
            if found.is_err() {
                end.fetch_min(index, Ordering::Relaxed);
            }
            Some(found)
        };
        let found: Vec<_> = pool.install(|| points.par_iter().with_max_len(1).enumerate().map(one).collect());
        found.into_iter().flatten().collect()
    }

    /// For all points in their order: `prepare` on the calling thread, then `compute`, then `keep` on the calling thread. The
    /// first point is alone, because it fills the caches that all of them share.
    ///
    /// # Errors
    /// The error of the first point that has no result.
    pub fn in_order<P: Sync, Q: Send + Sync, R: Send>(
        &self,
        points: &[P],
        prepare: impl Fn(&P) -> Result<Q, AnalysisError>,
        compute: impl Fn(&P, &Q) -> Result<R, AnalysisError> + Sync,
        mut keep: impl FnMut(&P, &Q, R),
    ) -> Result<(), AnalysisError> {
        let block = self.0.as_ref().map_or(1, |pool| POINTS_PER_THREAD * pool.current_num_threads());
        let (first, rest) = points.split_at(points.len().min(1));
        for points in std::iter::once(first).chain(rest.chunks(block)) {
            let prepared = points.iter().map(&prepare).collect::<Result<Vec<Q>, _>>()?;
            let pairs: Vec<(&P, &Q)> = points.iter().zip(&prepared).collect();
            let found = self.map(&pairs, |(point, prepared)| compute(point, prepared))?;
            for ((point, prepared), found) in pairs.into_iter().zip(found) {
                keep(point, prepared, found);
            }
        }
        Ok(())
    }
}
