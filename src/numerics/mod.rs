//! Numerical methods that several folders use: Gauss–Legendre rules (`legendre`), piecewise cubic polynomials (`cubic`),
//! searches on an interval (`interval`), and the exponential function of several numbers (`exponential`).

mod cubic;
mod exponential;
mod interval;
mod legendre;

pub use cubic::{Cubic, Knot, PiecewiseCubic, Place, monotone_slopes, natural_slopes, periodic_slopes, spline_slopes};
pub use exponential::{INVERSE_FACTORIAL, exponential};
pub use interval::{Sample, bisect, maximum, root};
pub use legendre::{gauss, integrated, integrated_slope, twice_integrated};
