//! Limits of floating-point numbers that mean the same in several folders.

/// Relative difference below which two quantities (positions, angles, ratios, coefficients) count as equal, and fraction of
/// the largest one below which a quantity counts as zero. Sums over a shaft or a loop of meshes have a round-off below 1e-12,
/// and tolerances of machines are above 1e-6.
pub const EQUALITY_TOLERANCE: f64 = 1e-9;
/// Relative size below which the result of a few hundred operations is round-off.
pub const ROUND_OFF: f64 = 1e-12;
/// Largest value up to which every whole number is an `f64`.
pub const LARGEST_EXACT_INTEGER: u64 = 1 << 53;
