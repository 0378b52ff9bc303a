//! Tables of pads in files of the user: made once on a machine, read by every later process.
//!
//! A file contains a mark, the dimensionless pad, the coefficients and a check sum. It is written beside its place and then
//! renamed, so that no other process reads a part of it. A file that cannot be read, or that is damaged, is made anew; a folder
//! that cannot be written costs time only.

use std::env;
use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::path::PathBuf;
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

use super::Vector;
use super::table::{PadShape, Splines};
use crate::scene::Rupture;

/// First bytes of a file; the number changes with the grids of solver and table.
const MARK: &[u8; 16] = b"gearbow film 001";

/// Number of the temporary file of this process.
static WRITTEN: AtomicU64 = AtomicU64::new(0);

/// The table of a pad: from its file, or computed and kept there.
pub(super) fn kept(shape: &PadShape) -> Splines {
    let path = folder().map(|folder| folder.join(format!("film-{:016x}.bin", check_sum(&head(shape)))));
    if let Some(found) = path.as_ref().and_then(|path| fs::read(path).ok()).and_then(|bytes| decoded(shape, &bytes)) {
        return found;
    }
    let made = Splines::new(shape);
    if let Some(path) = path {
        // The table is at hand; without its file, the next process computes it again.
        let _ = write(&path, &encoded(shape, &made));
    }
    made
}

/// The folder of the tables: `GEARBOW_CACHE`, or that of the operating system for files that can be made again.
fn folder() -> Option<PathBuf> {
    let variable = |name: &str| env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let home = || variable("HOME");
    variable("GEARBOW_CACHE").or_else(|| {
        let common = if cfg!(windows) {
            variable("LOCALAPPDATA")
        } else if cfg!(target_os = "macos") {
            home().map(|home| home.join("Library").join("Caches"))
        } else {
            variable("XDG_CACHE_HOME").or_else(|| home().map(|home| home.join(".cache")))
        };
        common.map(|folder| folder.join("gearbow"))
    })
}

fn write(path: &std::path::Path, bytes: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let number = WRITTEN.fetch_add(1, Ordering::Relaxed);
    let beside = path.with_extension(format!("{}-{number}.tmp", process::id()));
    fs::write(&beside, bytes).and_then(|()| fs::rename(&beside, path)).inspect_err(|_| drop(fs::remove_file(&beside)))
}

/// Mark and dimensionless pad.
fn head(shape: &PadShape) -> Vec<u8> {
    let rupture = match shape.rupture {
        Rupture::Reynolds => 0.0,
        Rupture::Gumbel => 1.0,
    };
    let numbers = [shape.length_ratio, shape.extent, rupture];
    MARK.iter().copied().chain(numbers.iter().flat_map(|value: &f64| value.to_le_bytes())).collect()
}

fn encoded(shape: &PadShape, splines: &Splines) -> Vec<u8> {
    let mut bytes = head(shape);
    let values = splines.deviation.iter().chain(&splines.centre).flatten();
    bytes.extend(values.flat_map(|value| value.to_le_bytes()));
    bytes.extend(check_sum(&bytes).to_le_bytes());
    bytes
}

/// The coefficients in the bytes of a file; none if it is damaged or that of another pad.
fn decoded(shape: &PadShape, bytes: &[u8]) -> Option<Splines> {
    let (content, sum) = bytes.split_at_checked(bytes.len().checked_sub(size_of::<u64>())?)?;
    let head = head(shape);
    let [deviation, centre] = Splines::lengths(shape);
    let (number_size, vector_size) = (size_of::<f64>(), size_of::<Vector>());
    let is_whole = content.len() == head.len() + vector_size * (deviation + centre) && content.starts_with(&head);
    if !is_whole || check_sum(content).to_le_bytes() != sum {
        return None;
    }
    let number = |bytes: &[u8]| bytes.try_into().map(f64::from_le_bytes).ok();
    let vector = |bytes: &[u8]| Some([number(&bytes[..number_size])?, number(&bytes[number_size..])?]);
    let all = content[head.len()..].chunks_exact(vector_size).map(vector).collect::<Option<Vec<Vector>>>()?;
    let (deviation, centre) = all.split_at(deviation);
    Some(Splines { deviation: deviation.to_vec(), centre: centre.to_vec() })
}

/// Check sum. A release of Rust that changes it makes the tables of this one unknown, and they are computed again.
fn check_sum(bytes: &[u8]) -> u64 {
    let mut sum = DefaultHasher::new();
    sum.write(bytes);
    sum.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_survives_its_file_and_a_damaged_one_is_refused() {
        let shape = PadShape { length_ratio: 0.5, extent: std::f64::consts::TAU, rupture: Rupture::Gumbel };
        let made = Splines::new(&shape);
        let mut bytes = encoded(&shape, &made);
        assert_eq!(decoded(&shape, &bytes), Some(made));
        assert_eq!(decoded(&PadShape { length_ratio: 0.6, ..shape }, &bytes), None);
        assert_eq!(decoded(&shape, &bytes[..bytes.len() - 1]), None);
        assert_eq!(decoded(&shape, &[]), None);
        bytes[1000] ^= 1;
        assert_eq!(decoded(&shape, &bytes), None);
    }
}
