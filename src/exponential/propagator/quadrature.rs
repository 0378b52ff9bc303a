//! Stages of a step, and the polynomials of the loads through them.

use super::phi::{Block, PHI_COUNT};

/// Largest number of stages.
pub const MAX_STAGES: usize = 4;
/// Values, or their weights, at the beginning, at the stages and at the end of a step. Unused entries are zero.
pub type PointValues = [f64; MAX_STAGES + 2];

/// The nodes c_i of a step and its load polynomials over τ, the fraction of the step. Coefficients begin with that of τ⁰.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadratureRule {
    /// Nodes c_i, ascending.
    pub nodes: Vec<f64>,
    /// Coefficients of the Lagrange polynomials l_j: the load within a step is Σ l_j(τ) p_j.
    pub lagrange: Vec<Vec<f64>>,
    /// Coefficients of π(τ) = Π(τ − c_i)/Π(1 − c_i), the shape of the defect of the polynomial through Gauss nodes.
    pub defect: Vec<f64>,
    /// Coefficients of the Lagrange polynomials of the beginning, the nodes and the end. They give the motion within a step,
    /// for which the polynomial through the nodes alone is less accurate than the order 2s of the step.
    pub whole: Vec<Vec<f64>>,
    /// l_j(0) and l_j(1).
    pub at_ends: [Vec<f64>; 2],
    /// Whether each stage uses the loads of earlier stages only.
    pub explicit: bool,
}

impl QuadratureRule {
    /// ETDRK4, the fourth-order exponential Runge–Kutta method of Cox and Matthews (2002). Its stages are the beginning,
    /// twice the middle, and the end.
    pub fn explicit() -> Self {
        let middle = vec![0.0, 2.0, -2.0];
        let lagrange = vec![vec![1.0, -3.0, 2.0], middle.clone(), middle, vec![0.0, -1.0, 2.0]];
        Self {
            nodes: vec![0.0, 0.5, 0.5, 1.0],
            defect: vec![0.0],
            whole: [&[vec![0.0]], &lagrange[..], &[vec![0.0]]].concat(),
            at_ends: at_ends(&lagrange),
            lagrange,
            explicit: true,
        }
    }

    /// Gauss nodes for one to four stages s: collocation of order 2s.
    pub fn gauss(stages: usize) -> Self {
        let nodes: Vec<f64> = match stages {
            1 => vec![0.0],
            2 => symmetric(&[(1.0_f64 / 3.0).sqrt()]),
            3 => {
                let outer = 0.6_f64.sqrt();
                vec![-outer, 0.0, outer]
            }
            _ => {
                let root = (1.2_f64).sqrt();
                symmetric(&[((3.0 + 2.0 * root) / 7.0).sqrt(), ((3.0 - 2.0 * root) / 7.0).sqrt()])
            }
        };
        let nodes: Vec<f64> = nodes.into_iter().map(|x| (1.0 + x) / 2.0).collect();
        let lagrange: Vec<Vec<f64>> = (0..nodes.len()).map(|j| through(&nodes, j)).collect();
        let defect = scaled(product_of_roots(nodes.iter().copied()), 1.0);
        let points: Vec<f64> = [&[0.0], &nodes[..], &[1.0]].concat();
        let whole = (0..points.len()).map(|j| through(&points, j)).collect();
        Self { nodes, at_ends: at_ends(&lagrange), lagrange, defect, whole, explicit: false }
    }

    /// Contribution of each load to stage `i` of the explicit rule, divided by c_i h. `half` holds φ of half the step.
    pub fn before(&self, i: usize, half: &[Block; PHI_COUNT]) -> Vec<Block> {
        let none = [[0.0; 2]; 2];
        let [exact, first] = [half[0], half[1]];
        match i {
            0 => vec![none; 4],
            1 => vec![first, none, none, none],
            2 => vec![none, first, none, none],
            // Over the first half acts the load at the beginning; over the second half, twice that of the second middle
            // stage minus that at the beginning.
            _ => {
                let carried = product(&exact, &first);
                let begin = std::array::from_fn(|r| std::array::from_fn(|c| (carried[r][c] - first[r][c]) / 2.0));
                vec![begin, none, first, none]
            }
        }
    }

    /// Largest distance between neighbours among the beginning, the nodes and the end, as a fraction of the step.
    pub fn gap(&self) -> f64 {
        let ends = self.nodes.iter().copied().chain([1.0]);
        ends.scan(0.0, |before, node| Some(node - std::mem::replace(before, node))).fold(0.0, f64::max)
    }

    /// Number of stages s.
    pub fn stages(&self) -> usize {
        self.nodes.len()
    }

    /// l_j(τ).
    pub fn weight(&self, j: usize, tau: f64) -> f64 {
        evaluate(&self.lagrange[j], tau)
    }

    /// Weights at τ of the values at 0, at the nodes and at 1; the last has the index s + 1.
    pub fn through(&self, tau: f64) -> PointValues {
        std::array::from_fn(|j| self.whole.get(j).map_or(0.0, |polynomial| evaluate(polynomial, tau)))
    }

    /// Weights that extrapolate loads to the nodes of a step that is `ratio` times as long as the previous one: for each
    /// node the weight of the load at the end of the previous step, then those of its stages.
    pub fn extrapolation(&self, ratio: f64, weights: &mut [f64]) {
        for (node, weights) in self.nodes.iter().zip(weights.chunks_exact_mut(self.stages() + 1)) {
            let tau = 1.0 + node * ratio;
            // π(τ) for the end, and l_j(τ)(τ − 1)/(c_j − 1) for the stages.
            weights[0] = evaluate(&self.defect, tau);
            for (j, (weight, at)) in weights[1..].iter_mut().zip(&self.nodes).enumerate() {
                *weight = self.weight(j, tau) * (tau - 1.0) / (at - 1.0);
            }
        }
    }
}

fn at_ends(lagrange: &[Vec<f64>]) -> [Vec<f64>; 2] {
    [0.0, 1.0].map(|end| lagrange.iter().map(|polynomial| evaluate(polynomial, end)).collect())
}

fn product(a: &Block, b: &Block) -> Block {
    std::array::from_fn(|r| std::array::from_fn(|c| a[r][0] * b[0][c] + a[r][1] * b[1][c]))
}

fn symmetric(positive: &[f64]) -> Vec<f64> {
    positive.iter().map(|x| -x).chain(positive.iter().rev().copied()).collect()
}

/// The Lagrange polynomial of point j.
fn through(points: &[f64], j: usize) -> Vec<f64> {
    let others = points.iter().enumerate().filter(|(i, _)| *i != j).map(|(_, point)| *point);
    scaled(product_of_roots(others), points[j])
}

fn product_of_roots(roots: impl Iterator<Item = f64>) -> Vec<f64> {
    roots.fold(vec![1.0], |polynomial, root| times_root(&polynomial, root))
}

/// Scales a polynomial to the value one at a point.
fn scaled(polynomial: Vec<f64>, at: f64) -> Vec<f64> {
    let value = evaluate(&polynomial, at);
    polynomial.into_iter().map(|coefficient| coefficient / value).collect()
}

/// Multiplies a polynomial by (τ − root).
fn times_root(polynomial: &[f64], root: f64) -> Vec<f64> {
    let mut product = vec![0.0; polynomial.len() + 1];
    for (power, coefficient) in polynomial.iter().enumerate() {
        product[power + 1] += coefficient;
        product[power] -= root * coefficient;
    }
    product
}

fn evaluate(polynomial: &[f64], at: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, coefficient| sum * at + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rules_integrate_polynomials_of_degree_below_twice_their_stages() {
        for stages in 1..=MAX_STAGES {
            let rule = QuadratureRule::gauss(stages);
            let weight =
                |j: usize| rule.lagrange[j].iter().enumerate().map(|(power, a)| a / (power + 1) as f64).sum::<f64>();
            for degree in 0..2 * stages {
                let sum: f64 = (0..stages).map(|j| weight(j) * rule.nodes[j].powi(degree as i32)).sum();
                // Coefficients of some tens cancel, which leaves round-off of this size.
                assert!((sum - 1.0 / (degree + 1) as f64).abs() < 1e-14, "{stages} {degree}");
            }
            let defect: f64 = rule.defect.iter().enumerate().map(|(power, a)| a / (power + 1) as f64).sum();
            assert!(defect.abs() < 1e-14 && rule.nodes.is_sorted());
        }
    }
}
