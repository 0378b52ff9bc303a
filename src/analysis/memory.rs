//! Checks whether the matrices of an analysis fit into the available memory.
//!
//! Rust aborts the process when an allocation fails, and Linux kills a process that uses too much memory. Therefore an
//! analysis that needs too much memory is refused before it starts.

use std::fs::read_to_string;
use std::path::Path;

use crate::model::Model;
use crate::scene::SceneError;

/// Matrices that an analysis needs simultaneously, for n degrees of freedom; dense (n, n) ones unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dense {
    /// Sparse factors and vectors of a Krylov space: no dense matrix.
    Bands,
    /// Mass, stiffness, damping and gyroscopic matrix.
    Matrices,
    /// Undamped modes, also for critical speeds.
    Undamped,
    /// Damped modes: eigenvalues and eigenvectors of a (2n, 2n) matrix.
    Damped,
}

impl Dense {
    /// Number of matrices. The values exceed the measured growth of the resident memory for a coupled train with
    /// cross-coupled bearings: 5; 18 (critical speeds); 42 (modes) to 52 (Campbell diagram).
    const fn count(self) -> u64 {
        match self {
            Self::Bands => 0,
            Self::Matrices => 6,
            Self::Undamped => 20,
            Self::Damped => 56,
        }
    }

    /// Memory of the matrices for `n` degrees of freedom, bytes.
    pub const fn bytes(self, n: usize) -> u64 {
        let n = n as u64;
        if matches!(self, Self::Bands) {
            return BYTES_OF_BANDS.saturating_mul(n);
        }
        self.count().saturating_mul(8).saturating_mul(n.saturating_mul(n))
    }

    /// Refuses an analysis whose matrices do not fit into the available memory.
    ///
    /// # Errors
    /// [`SceneError`] with the required and the available memory.
    pub fn require(self, model: &Model) -> Result<(), SceneError> {
        let needed = self.bytes(model.len());
        if needed <= UNCHECKED_BYTES {
            return Ok(());
        }
        check(model.len(), needed, available())
    }

    /// Number of threads, at most `count`, whose matrices fit into the available memory together.
    pub fn threads(self, model: &Model, count: usize) -> usize {
        let needed = self.bytes(model.len());
        if needed <= UNCHECKED_BYTES || count <= 1 {
            return count;
        }
        usize::try_from(available() / needed).unwrap_or(count).clamp(1, count)
    }
}

/// What an analysis keeps for its caller.
#[derive(Clone, Debug)]
pub struct Kept<'a> {
    /// Argument that determines the amount.
    pub argument: &'a str,
    /// What is kept, in plural.
    pub what: String,
    /// Memory, bytes.
    pub bytes: u64,
    /// How to need less.
    pub remedy: &'a str,
}

impl Kept<'_> {
    /// Refuses an analysis whose results do not fit into the available memory.
    ///
    /// # Errors
    /// [`SceneError`] with the required and the available memory.
    pub fn require(&self) -> Result<(), SceneError> {
        if self.bytes <= UNCHECKED_BYTES { Ok(()) } else { self.check(available()) }
    }

    fn check(&self, available: u64) -> Result<(), SceneError> {
        let available = available.saturating_sub(UNCHECKED_BYTES);
        if self.bytes <= available { Ok(()) } else { Err(self.refused(available)) }
    }

    fn refused(&self, available: u64) -> SceneError {
        let Kept { argument, what, bytes, remedy } = self;
        let (needed, available) = (gigabytes(*bytes), gigabytes(available));
        let message = format!("{what} need {needed:.3} GB of memory, {available:.3} GB are available; {remedy}");
        SceneError::new(*argument, message)
    }

    /// An empty list with room for `count` values.
    ///
    /// # Errors
    /// [`SceneError`] if the memory cannot be allocated.
    pub fn room<T>(&self, count: usize) -> Result<Vec<T>, SceneError> {
        let mut room = Vec::new();
        room.try_reserve_exact(count).map_err(|_| self.refused(available()))?;
        Ok(room)
    }
}

/// Product of numbers of values; the largest number instead of an overflow.
pub fn product(factors: &[usize]) -> u64 {
    factors.iter().fold(1, |product: u64, factor| product.saturating_mul(*factor as u64))
}

fn gigabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e9
}

/// Memory of sparse matrices, their factors and 300 vectors of 2n entries, for each degree of freedom, bytes.
const BYTES_OF_BANDS: u64 = 8192;
/// Required memory up to which nothing is checked, and memory that is left for the work beside the results, bytes.
const UNCHECKED_BYTES: u64 = 64 << 20;
/// Assumed available memory if the system does not provide it, bytes.
const ASSUMED_BYTES: u64 = 16 << 30;

fn check(n: usize, needed: u64, available: u64) -> Result<(), SceneError> {
    if needed <= available {
        return Ok(());
    }
    let message = format!(
        "{n} degrees of freedom need {:.3} GB of memory for dense matrices, {:.3} GB are available; use fewer elements, or elements of a lower degree",
        gigabytes(needed),
        gigabytes(available)
    );
    Err(SceneError::new("shafts", message))
}

/// Memory that this process can still allocate, bytes: the smallest of the free memory, the limit of the address space
/// (`ulimit -v`) and the limits of its control groups, which containers and job schedulers set.
fn available() -> u64 {
    let machine =
        number_after(&read("/proc/meminfo"), "MemAvailable:").map_or(ASSUMED_BYTES, |kibibytes| kibibytes << 10);
    machine.min(address_space().unwrap_or(u64::MAX)).min(control_groups().unwrap_or(u64::MAX))
}

fn read(path: impl AsRef<Path>) -> String {
    read_to_string(path).unwrap_or_default()
}

/// The first number after `name` at the beginning of a line; None if it is not a number ("unlimited").
fn number_after(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

fn address_space() -> Option<u64> {
    let limit = number_after(&read("/proc/self/limits"), "Max address space")?;
    let used = number_after(&read("/proc/self/status"), "VmSize:")? << 10;
    Some(limit.saturating_sub(used))
}

/// Memory left by the control groups (version 2) of this process, bytes. Cached files count as free.
fn control_groups() -> Option<u64> {
    let groups = read("/proc/self/cgroup");
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let root = Path::new("/sys/fs/cgroup");
    let left = |group: &Path| {
        let number = |name: &str| read(group.join(name)).trim().parse::<u64>().ok();
        let used =
            number("memory.current")?.saturating_sub(number_after(&read(group.join("memory.stat")), "inactive_file")?);
        Some(number("memory.max")?.saturating_sub(used))
    };
    root.join(own).ancestors().take_while(|group| group.starts_with(root)).filter_map(left).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_counts_all_matrices_and_never_overflows() {
        assert_eq!(Dense::Matrices.bytes(1000), 6 * 8 * 1_000_000);
        assert!(Dense::Damped.bytes(45_005) > 700_000_000_000);
        assert_eq!(Dense::Damped.bytes(usize::MAX), u64::MAX);
        assert_eq!(Dense::Bands.bytes(45_005), 45_005 * 8192);
    }

    #[test]
    fn the_error_gives_the_required_and_the_available_memory() {
        assert!(check(1000, 8_000_000, 8_000_000).is_ok());
        let text = "shafts: 45005 degrees of freedom need 97.218 GB of memory for dense matrices, 16.000 GB are \
                    available; use fewer elements, or elements of a lower degree";
        let refused = check(45_005, 97_218_002_400, 16_000_000_000).map_err(|error| error.to_string());
        assert_eq!(refused, Err(text.to_owned()));
    }

    #[test]
    fn results_that_do_not_fit_are_refused_with_the_remedy() {
        let kept =
            |bytes| Kept { argument: "speeds", what: "amplitudes".to_owned(), bytes, remedy: "give fewer speeds" };
        assert!(kept(1_000_000).check(1_000_000 + UNCHECKED_BYTES).is_ok());
        assert!(kept(UNCHECKED_BYTES).require().is_ok());
        let text = "speeds: amplitudes need 12.000 GB of memory, 3.000 GB are available; give fewer speeds";
        let refused = kept(12_000_000_000).check(3_000_000_000 + UNCHECKED_BYTES).map_err(|error| error.to_string());
        assert_eq!(refused, Err(text.to_owned()));
        assert!(kept(u64::MAX).require().is_err());
        assert!(kept(16).room::<u128>(usize::MAX).is_err());
        assert_eq!(product(&[usize::MAX, 2, 3]), u64::MAX);
    }

    #[test]
    fn a_field_is_a_number_or_none() {
        let limits = "Max stack size  8388608  unlimited  bytes\nMax address space  unlimited  unlimited  bytes\n";
        assert_eq!(number_after(limits, "Max stack size"), Some(8_388_608));
        assert_eq!(number_after(limits, "Max address space"), None);
        assert_eq!(number_after(limits, "Max files"), None);
    }

    #[test]
    fn some_memory_is_available() {
        assert!(available() > UNCHECKED_BYTES);
    }
}
