//! Cubic B-splines on uniform nodes: weights of a point, and coefficients from values at the nodes.

use nalgebra::DMatrix;

/// Weights of the four B-splines at the fraction `t` between two nodes.
#[inline]
pub fn weights(t: f64) -> [f64; 4] {
    let (r, t2, t3) = (1.0 - t, t * t, t * t * t);
    [r * r * r / 6.0, (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0, (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3) / 6.0, t3 / 6.0]
}

/// Derivatives of [`weights`] over `t`.
#[inline]
pub fn slopes(t: f64) -> [f64; 4] {
    let (r, t2) = (1.0 - t, t * t);
    [-r * r / 2.0, (3.0 * t2 - 4.0 * t) / 2.0, (1.0 + 2.0 * t - 3.0 * t2) / 2.0, t2 / 2.0]
}

/// Matrix from the values at `nodes` nodes to the coefficients of a periodic spline.
pub fn periodic(nodes: usize) -> Option<DMatrix<f64>> {
    let mut matrix = DMatrix::zeros(nodes, nodes);
    for i in 0..nodes {
        for (offset, weight) in [(nodes - 1, 1.0 / 6.0), (0, 2.0 / 3.0), (1, 1.0 / 6.0)] {
            matrix[(i, (i + offset) % nodes)] += weight;
        }
    }
    matrix.try_inverse()
}

/// Matrix, shape (nodes + 2, nodes), from the values at the nodes to the coefficients of a spline between the first and the
/// last node. At the second and at the last node but one the third derivative is continuous.
pub fn bounded(nodes: usize) -> Option<DMatrix<f64>> {
    let count = nodes + 2;
    let mut matrix = DMatrix::zeros(count, count);
    for i in 0..nodes {
        for (offset, weight) in [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0].into_iter().enumerate() {
            matrix[(i, i + offset)] = weight;
        }
    }
    for (offset, factor) in [1.0, -4.0, 6.0, -4.0, 1.0].into_iter().enumerate() {
        matrix[(nodes, offset)] = factor;
        matrix[(nodes + 1, count - 1 - offset)] = factor;
    }
    Some(matrix.try_inverse()?.columns(0, nodes).into_owned())
}
