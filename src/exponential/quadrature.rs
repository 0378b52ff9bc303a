//! Where within a step loads are evaluated, and the polynomials through them.

use super::phi::{Block, COUNT};

/// The largest number of nodes.
pub const MOST: usize = 4;

/// Nodes c_i of a step with the polynomials that carry their loads.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadratureRule {
    /// c_i, ascending.
    pub nodes: Vec<f64>,
    /// Coefficients of l_j, of τ⁰ first: the load within a step is Σ l_j(τ) p_j.
    pub lagrange: Vec<Vec<f64>>,
    /// Coefficients of π(τ) = Π(τ − c_i), scaled to π(1) = 1: the shape of what a polynomial through Gauss nodes misses.
    pub defect: Vec<f64>,
    /// Coefficients of the polynomials of the loads at the beginning, at the nodes and at the end that carry the motion
    /// within a step, where a step of order 2s asks for more than the nodes alone tell.
    pub whole: Vec<Vec<f64>>,
    /// l_j at the beginning and at the end.
    pub at_ends: [Vec<f64>; 2],
    /// Whether each node sees the loads of those before it alone.
    pub explicit: bool,
}

impl QuadratureRule {
    /// The fourth-order exponential Runge–Kutta method of Cox and Matthews (2002), ETDRK4: a step and its half twice,
    /// with the quadratic through beginning, middle and end.
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

    /// One to four Gauss nodes: collocation of order twice that.
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

    /// What each load adds to node `i` of the explicit rule, in parts of c_i h; `half` holds φ at half the step.
    pub fn before(&self, i: usize, half: &[Block; COUNT]) -> Vec<Block> {
        let none = [[0.0; 2]; 2];
        let [exact, first] = [half[0], half[1]];
        match i {
            0 => vec![none; 4],
            1 => vec![first, none, none, none],
            2 => vec![none, first, none, none],
            // The beginning's load over the first half; over the second, twice the middle's less the beginning's.
            _ => {
                let carried = product(&exact, &first);
                let begin = std::array::from_fn(|r| std::array::from_fn(|c| (carried[r][c] - first[r][c]) / 2.0));
                vec![begin, none, first, none]
            }
        }
    }

    /// The longest way from the beginning to a node, from one to the next, or to the end.
    pub fn gap(&self) -> f64 {
        let ends = self.nodes.iter().copied().chain([1.0]);
        ends.scan(0.0, |before, node| Some(node - std::mem::replace(before, node))).fold(0.0, f64::max)
    }

    /// Number of nodes s.
    pub fn stages(&self) -> usize {
        self.nodes.len()
    }

    /// l_j(τ).
    pub fn weight(&self, j: usize, tau: f64) -> f64 {
        evaluate(&self.lagrange[j], tau)
    }

    /// Weights at τ of the values at 0, at the nodes and at 1; the last stands at s + 1.
    pub fn through(&self, tau: f64) -> [f64; MOST + 2] {
        std::array::from_fn(|j| self.whole.get(j).map_or(0.0, |polynomial| evaluate(polynomial, tau)))
    }

    /// Weights, at the nodes of a step that is so many times as long as the one before it, of the loads at that one's end
    /// and at its nodes, node after node: the polynomial through them.
    pub fn extrapolation(&self, longer: f64, weights: &mut [f64]) {
        for (node, weights) in self.nodes.iter().zip(weights.chunks_exact_mut(self.stages() + 1)) {
            let tau = 1.0 + node * longer;
            // l_j(τ)(τ − 1)/(c_j − 1), and π(τ) at the end.
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

/// The polynomial scaled to one at a point.
fn scaled(polynomial: Vec<f64>, at: f64) -> Vec<f64> {
    let value = evaluate(&polynomial, at);
    polynomial.into_iter().map(|coefficient| coefficient / value).collect()
}

/// The polynomial times (τ − root).
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
    fn rules_are_exact_to_twice_their_nodes() {
        for stages in 1..=MOST {
            let rule = QuadratureRule::gauss(stages);
            let weight =
                |j: usize| rule.lagrange[j].iter().enumerate().map(|(power, a)| a / (power + 1) as f64).sum::<f64>();
            for degree in 0..2 * stages {
                let sum: f64 = (0..stages).map(|j| weight(j) * rule.nodes[j].powi(degree as i32)).sum();
                // Round-off of coefficients of some tens that cancel.
                assert!((sum - 1.0 / (degree + 1) as f64).abs() < 1e-14, "{stages} {degree}");
            }
            let defect: f64 = rule.defect.iter().enumerate().map(|(power, a)| a / (power + 1) as f64).sum();
            assert!(defect.abs() < 1e-14 && rule.nodes.is_sorted());
        }
    }
}
