//! Numerical methods that several folders use: Gauss–Legendre rules, piecewise cubic polynomials, and searches on
//! an interval.

mod cubic;
mod interval;
mod legendre;

pub use cubic::{Cubic, Knot, PiecewiseCubic, Place, monotone_slopes, natural_slopes, periodic_slopes, spline_slopes};
pub use interval::{Sample, bisect, maximum, root};
pub use legendre::{gauss, integrated, integrated_slope, twice_integrated};
