//! Numerical methods that several folders use: Gauss–Legendre rules (`legendre`), piecewise cubic polynomials (`cubic`),
//! searches on an interval (`interval`), the exponential function of several numbers (`exponential`), and limits of floating-point
//! numbers that mean the same in several folders.

mod cubic;
mod exponential;
mod interval;
mod legendre;

pub use cubic::{Cubic, Knot, PiecewiseCubic, Place, monotone_slopes, natural_slopes, periodic_slopes, spline_slopes};
pub use exponential::{INVERSE_FACTORIAL, exponential};
pub use interval::{Sample, bisect, maximum, root};
pub use legendre::{gauss, integrated, integrated_slope, twice_integrated};

/// Relative difference below which two quantities (positions, angles, ratios, coefficients) count as equal, and fraction of
/// the largest one below which a quantity counts as zero. Sums over a shaft or a loop of meshes have a round-off below 1e-12,
/// and tolerances of machines are above 1e-6.
pub const EQUALITY_TOLERANCE: f64 = 1e-9;
/// Relative size below which the result of a few hundred operations is round-off.
pub const ROUND_OFF: f64 = 1e-12;
/// Largest whole number up to which an `f64` represents every whole number exactly.
pub const LARGEST_EXACT_INTEGER: u64 = 1 << 53;
/// Square root of the round-off of a number: a smaller quantity has a square that is round-off, and two numbers whose squares are equal
/// but for round-off differ by this much.
pub const ROOT_OF_ROUND_OFF: f64 = 1e-8;
/// Relative error of a sum of a few products.
pub const SUM_ROUND_OFF: f64 = 8.0 * f64::EPSILON;
