//! Whether the dense matrices of an analysis fit into the memory that is available.
//!
//! Rust aborts the process when an allocation fails, and Linux ends a process that uses more than there is. So an
//! analysis is refused before its first matrix.

use std::fs::read_to_string;
use std::path::Path;

use crate::model::Model;
use crate::scene::SceneError;

/// Dense (n, n) matrices of 8-byte numbers that an analysis needs at once, with n degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dense {
    /// Mass, stiffness, damping and gyroscopic matrix.
    Matrices,
    /// Undamped modes, and what follows from them: equilibrium, synchronous response, critical speeds.
    Undamped,
    /// Damped modes: eigenvalues and vectors of a (2n, 2n) matrix.
    Damped,
}

impl Dense {
    /// Number of matrices: a little more than what the resident set of a coupled train with cross-coupled bearings
    /// grows by: 5; 10 (equilibrium) to 18 (critical speeds); 42 (modes) to 52 (Campbell diagram).
    const fn count(self) -> u64 {
        match self {
            Self::Matrices => 6,
            Self::Undamped => 20,
            Self::Damped => 56,
        }
    }

    /// Memory for `n` degrees of freedom, bytes.
    pub const fn bytes(self, n: usize) -> u64 {
        let n = n as u64;
        self.count().saturating_mul(8).saturating_mul(n.saturating_mul(n))
    }

    /// Refuses an analysis whose matrices do not fit into the memory that is available.
    ///
    /// # Errors
    /// [`SceneError`] with the memory that is needed and that is available.
    pub fn require(self, model: &Model) -> Result<(), SceneError> {
        let needed = self.bytes(model.len());
        if needed <= UNCHECKED {
            return Ok(());
        }
        refuse(model.len(), needed, available())
    }
}

/// Every process has this much, bytes: the files that tell what is available are not read for less.
const UNCHECKED: u64 = 64 << 20;
/// Memory that is taken to be available where the system does not say, bytes.
const ASSUMED: u64 = 16 << 30;

fn refuse(n: usize, needed: u64, available: u64) -> Result<(), SceneError> {
    if needed <= available {
        return Ok(());
    }
    let gigabytes = |bytes: u64| bytes as f64 / 1e9;
    let message = format!(
        "{n} degrees of freedom need {:.3} GB of memory for dense matrices, {:.3} GB are available: use fewer elements",
        gigabytes(needed),
        gigabytes(available)
    );
    Err(SceneError::new("shafts", message))
}

/// Memory that this process can still take, bytes: free memory of the machine, the limit of its address space
/// (`ulimit -v`) and those of its control groups, which containers and job schedulers set.
fn available() -> u64 {
    let machine = field(&read("/proc/meminfo"), "MemAvailable:").map_or(ASSUMED, |kibibytes| kibibytes << 10);
    machine.min(address_space().unwrap_or(u64::MAX)).min(control_groups().unwrap_or(u64::MAX))
}

fn read(path: impl AsRef<Path>) -> String {
    read_to_string(path).unwrap_or_default()
}

/// The first number behind a name at the beginning of a line; none where it is not a number ("unlimited").
fn field(text: &str, name: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

fn address_space() -> Option<u64> {
    let limit = field(&read("/proc/self/limits"), "Max address space")?;
    let used = field(&read("/proc/self/status"), "VmSize:")? << 10;
    Some(limit.saturating_sub(used))
}

/// The tightest limit of the control groups (version 2) of this process. Cached files count as free.
fn control_groups() -> Option<u64> {
    let groups = read("/proc/self/cgroup");
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let root = Path::new("/sys/fs/cgroup");
    let left = |group: &Path| {
        let number = |name: &str| read(group.join(name)).trim().parse::<u64>().ok();
        let used = number("memory.current")?.saturating_sub(field(&read(group.join("memory.stat")), "inactive_file")?);
        Some(number("memory.max")?.saturating_sub(used))
    };
    root.join(own).ancestors().take_while(|group| group.starts_with(root)).filter_map(left).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_is_of_all_matrices_and_never_overflows() {
        assert_eq!(Dense::Matrices.bytes(1000), 6 * 8 * 1_000_000);
        assert!(Dense::Damped.bytes(45_005) > 700_000_000_000);
        assert_eq!(Dense::Damped.bytes(usize::MAX), u64::MAX);
    }

    #[test]
    fn the_error_says_what_is_needed_and_what_is_there() {
        assert!(refuse(1000, 8_000_000, 8_000_000).is_ok());
        let text = "shafts: 45005 degrees of freedom need 97.218 GB of memory for dense matrices, 16.000 GB are \
                    available: use fewer elements";
        let refused = refuse(45_005, 97_218_002_400, 16_000_000_000).map_err(|error| error.to_string());
        assert_eq!(refused, Err(text.to_owned()));
    }

    #[test]
    fn a_field_is_a_number_or_none() {
        let limits = "Max stack size  8388608  unlimited  bytes\nMax address space  unlimited  unlimited  bytes\n";
        assert_eq!(field(limits, "Max stack size"), Some(8_388_608));
        assert_eq!(field(limits, "Max address space"), None);
        assert_eq!(field(limits, "Max files"), None);
    }

    #[test]
    fn something_is_available() {
        assert!(available() > UNCHECKED);
    }
}
