//! The small linear systems of Newton's method, in place.

/// A system of fixed size; nothing is allocated once it stands.
#[derive(Clone, Debug)]
pub struct Newton {
    size: usize,
    matrix: Vec<f64>,
    slopes: Vec<f64>,
    /// The right-hand side, and after [`Self::solve`] the solution.
    pub right: Vec<f64>,
}

impl Newton {
    /// A system of `size` unknowns.
    pub fn new(size: usize) -> Self {
        Self { size, matrix: vec![0.0; size * size], slopes: Vec::new(), right: vec![0.0; size] }
    }

    /// Sets the matrix to one.
    pub fn begin(&mut self) {
        self.matrix.fill(0.0);
        self.matrix.iter_mut().step_by(self.size + 1).for_each(|diagonal| *diagonal = 1.0);
    }

    /// Room for the slopes of all loads over one scalar.
    pub fn slopes(&mut self, loads: usize) -> &mut [f64] {
        self.slopes.resize(loads, 0.0);
        &mut self.slopes
    }

    /// Takes slopes times the `response` of their scalar to all loads off the rows from `row` on; the first `meshes` of
    /// every `loads` loads are unknown.
    pub fn add(&mut self, row: usize, meshes: usize, loads: usize, response: impl Fn(usize) -> f64) {
        for k in 0..meshes {
            self.add_row(row + k, self.slopes[k], meshes, loads, &response);
        }
    }

    /// Takes `slope` times a response off one row.
    pub fn add_row(&mut self, row: usize, slope: f64, meshes: usize, loads: usize, response: impl Fn(usize) -> f64) {
        if slope != 0.0 {
            let line = &mut self.matrix[row * self.size..(row + 1) * self.size];
            for (node, unknowns) in line.chunks_exact_mut(meshes).enumerate() {
                for (k, entry) in unknowns.iter_mut().enumerate() {
                    *entry -= slope * response(node * loads + k);
                }
            }
        }
    }

    /// Solves the system by elimination with partial pivoting; whether there is a solution.
    pub fn solve(&mut self) -> bool {
        let n = self.size;
        for column in 0..n {
            let size = |row: usize| self.matrix[row * n + column].abs();
            let pivot = (column..n).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(column);
            let value = self.matrix[pivot * n + column];
            if value == 0.0 || !value.is_finite() {
                return false;
            }
            for k in 0..n {
                self.matrix.swap(column * n + k, pivot * n + k);
            }
            self.right.swap(column, pivot);
            for row in column + 1..n {
                let factor = self.matrix[row * n + column] / value;
                if factor != 0.0 {
                    for k in column..n {
                        self.matrix[row * n + k] -= factor * self.matrix[column * n + k];
                    }
                    self.right[row] -= factor * self.right[column];
                }
            }
        }
        for row in (0..n).rev() {
            let known: f64 = (row + 1..n).map(|k| self.matrix[row * n + k] * self.right[k]).sum();
            self.right[row] = (self.right[row] - known) / self.matrix[row * n + row];
        }
        true
    }
}
