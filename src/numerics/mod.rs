//! Numerical methods that several folders use: Gauss–Legendre rules, piecewise cubic polynomials, searches on an interval,
//! and the exponential function of several numbers.

mod cubic;
mod exponential;
mod interval;
mod legendre;

pub use cubic::{Cubic, Knot, PiecewiseCubic, Place, monotone_slopes, natural_slopes, periodic_slopes, spline_slopes};
pub use exponential::{INVERSE_FACTORIAL, exponential};
pub use interval::{Sample, bisect, maximum, root};
pub use legendre::{gauss, integrated, integrated_slope, twice_integrated};
