//! Real sparse matrices in compressed rows (CSR).

/// A square sparse matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Sparse {
    /// First entry of each row, and the number of entries; n + 1 values.
    pub starts: Vec<usize>,
    /// Column of each entry, ascending within a row.
    pub columns: Vec<usize>,
    /// Value of each entry.
    pub values: Vec<f64>,
}

impl Sparse {
    /// The sum of entries (row, column, value) of a matrix with `size` rows; entries that are zero are not stored.
    pub fn new(size: usize, mut entries: Vec<(usize, usize, f64)>) -> Self {
        // A stable sort keeps the order of equal places, so that their sums equal those of a dense matrix.
        entries.sort_by_key(|(row, column, _)| (*row, *column));
        let mut sums: Vec<(usize, usize, f64)> = Vec::with_capacity(entries.len());
        for (row, column, value) in entries {
            match sums.last_mut() {
                Some(last) if (last.0, last.1) == (row, column) => last.2 += value,
                _ => sums.push((row, column, value)),
            }
        }
        sums.retain(|(_, _, value)| *value != 0.0);
        let mut starts = vec![0; size + 1];
        for (row, _, _) in &sums {
            starts[row + 1] += 1;
        }
        for row in 0..size {
            starts[row + 1] += starts[row];
        }
        Self {
            starts,
            columns: sums.iter().map(|(_, column, _)| *column).collect(),
            values: sums.iter().map(|(_, _, value)| *value).collect(),
        }
    }

    /// The transposed matrix.
    pub fn transposed(&self) -> Self {
        let mut entries = Vec::with_capacity(self.values.len());
        self.for_each(|row, column, value| entries.push((column, row, value)));
        Self::new(self.starts.len() - 1, entries)
    }

    /// Whether every entry is zero.
    pub fn is_zero(&self) -> bool {
        self.values.is_empty()
    }

    /// `out += factor · self · x`.
    pub fn multiply_add(&self, factor: f64, x: &[f64], out: &mut [f64]) {
        for (row, out) in out.iter_mut().enumerate() {
            let range = self.starts[row]..self.starts[row + 1];
            let terms = self.columns[range.clone()].iter().zip(&self.values[range]);
            *out += factor * terms.map(|(column, value)| value * x[*column]).sum::<f64>();
        }
    }

    /// Diagonal entries.
    pub fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.starts.len() - 1];
        self.for_each(|row, column, value| {
            if row == column {
                diagonal[row] = value;
            }
        });
        diagonal
    }

    /// Largest value of `size(row, column, value)` over all entries; zero without entries.
    pub fn largest(&self, size: impl Fn(usize, usize, f64) -> f64) -> f64 {
        let mut largest = 0.0_f64;
        self.for_each(|row, column, value| largest = largest.max(size(row, column, value)));
        largest
    }

    /// Calls `visit(row, column, value)` for every entry.
    pub fn for_each(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for row in 0..self.starts.len() - 1 {
            for entry in self.starts[row]..self.starts[row + 1] {
                visit(row, self.columns[entry], self.values[entry]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_of_one_place_are_added_and_zeros_are_left_out() {
        let matrix = Sparse::new(3, vec![(2, 0, 5.0), (0, 1, 2.0), (0, 1, -0.5), (1, 1, 1.0), (1, 1, -1.0)]);
        assert_eq!(
            (&*matrix.starts, &*matrix.columns, &*matrix.values),
            (&[0, 1, 1, 2][..], &[1, 0][..], &[1.5, 5.0][..])
        );
        let mut out = [1.0; 3];
        matrix.multiply_add(2.0, &[1.0, 10.0, 0.0], &mut out);
        assert_eq!(out, [31.0, 1.0, 11.0]);
    }
}
