//! Numerical methods that several folders use: Gauss–Legendre rules (`legendre`), piecewise cubic polynomials (`cubic`),
//! searches on an interval (`interval`), the exponential function of several numbers (`exponential`), and limits of floating-point
//! numbers (`tolerance`).

mod cubic;
mod exponential;
mod interval;
mod legendre;
mod tolerance;

pub use cubic::{Cubic, Knot, PiecewiseCubic, Place, monotone_slopes, natural_slopes, periodic_slopes, spline_slopes};
pub use exponential::{INVERSE_FACTORIAL, exponential};
pub use interval::{Sample, bisect, maximum, root};
pub use legendre::{gauss, integrated, integrated_slope, twice_integrated};
pub use tolerance::{EQUALITY_TOLERANCE, LARGEST_EXACT_INTEGER, ROOT_OF_ROUND_OFF, ROUND_OFF, SUM_ROUND_OFF};
