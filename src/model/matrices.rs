//! Entries of the matrices of the complete model in the order of the core, and the dense or sparse matrices of them.
//!
//! SI units: translations in m, rotations in rad. A speed Ω is that of the reference shaft, rad/s; its sign selects the
//! loaded tooth flanks.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::shaft::{BendingChain, RodChain};
use super::{Model, StructuralDamping, Support};
use crate::connection::{Connection, Row};
use crate::linalg::{ChainMatrix, Sparse, image_of_parts};

/// Adds a value to the entry (row, column) of a matrix.
pub type Add<'a> = &'a mut dyn FnMut(usize, usize, f64);

impl Model {
    /// Mass matrix M.
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        self.dense(|add| self.visit_mass(add))
    }

    /// Stiffness matrix of the shafts.
    pub fn shaft_stiffness_matrix(&self) -> DMatrix<f64> {
        self.dense(|add| self.visit_shaft_stiffness(add))
    }

    /// Stiffness matrix of the bearings, with the circulatory forces of the shafts.
    pub fn support_stiffness_matrix(&self) -> DMatrix<f64> {
        self.dense(|add| {
            self.visit_supports(|support| support.stiffness, add);
            self.visit_circulation(add);
        })
    }

    /// Bearing stiffness without its symmetric part, with the circulatory forces of the shafts.
    pub fn skew_part_matrix(&self) -> DMatrix<f64> {
        self.dense(|add| {
            self.visit_supports(Support::skew_part, add);
            self.visit_circulation(add);
        })
    }

    /// Stiffness matrix of the connections at a speed of the reference shaft; meshes are linearised at rest.
    pub fn connection_stiffness_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.dense(|add| self.visit_connections(speed, |connection| connection.linear(speed).stiffness, add))
    }

    /// Stiffness matrix K of shafts, bearings and connections.
    pub fn stiffness_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.shaft_stiffness_matrix() + self.support_stiffness_matrix() + self.connection_stiffness_matrix(speed)
    }

    /// Damping matrix of shafts, bearings and connections, without modal damping, which `CachedModel` adds.
    pub fn damping_matrix(&self, speed: f64) -> DMatrix<f64> {
        self.dense(|add| self.visit_connections(speed, |connection| connection.linear(speed).damping, add))
            + self.damping_matrix_without_meshes()
    }

    /// Damping matrix of shafts and bearings, without modal damping.
    pub fn damping_matrix_without_meshes(&self) -> DMatrix<f64> {
        self.dense(|add| self.visit_damping_without_meshes(add))
    }

    /// Matrix of the Rayleigh damping of the shafts.
    pub fn shaft_damping_matrix(&self) -> DMatrix<f64> {
        self.dense(|add| self.visit_shaft_damping(add))
    }

    /// Gyroscopic matrix G per unit speed of the reference shaft: the term −iΩ_s G_s u̇ of each shaft s for the real
    /// and imaginary part of u, with the Coriolis term of a frame that turns.
    pub fn gyroscopic_matrix(&self) -> DMatrix<f64> {
        self.dense(|add| self.visit_gyroscopic(add))
    }

    /// Matrix of the circulatory forces of internal damping per unit speed of the reference shaft: −iβK_s of each shaft s, for
    /// the real and imaginary part of u.
    pub fn sparse_circulation(&self) -> Sparse {
        self.sparse(|add| self.visit_circulation_per_speed(add))
    }

    /// Mass matrix M.
    pub fn sparse_mass(&self) -> Sparse {
        self.sparse(|add| self.visit_mass(add))
    }

    /// Stiffness matrix K of shafts, bearings and connections.
    pub fn sparse_stiffness(&self, speed: f64) -> Sparse {
        self.sparse(|add| self.visit_stiffness(speed, add))
    }

    /// The same with the symmetric part of the bearing stiffness.
    pub fn sparse_symmetric_stiffness(&self, speed: f64) -> Sparse {
        self.sparse(|add| {
            self.visit_shaft_stiffness(add);
            self.visit_supports(|support| support.symmetric_part, add);
            self.visit_connections(speed, |connection| connection.linear(speed).stiffness, add);
        })
    }

    /// Symmetric part of the stiffness of shafts and bearings.
    pub fn sparse_stiffness_without_connections(&self) -> Sparse {
        self.sparse(|add| {
            self.visit_shaft_stiffness(add);
            self.visit_supports(|support| support.symmetric_part, add);
        })
    }

    /// Bearing stiffness without its symmetric part, with the circulatory forces of the shafts.
    pub fn sparse_skew_part(&self) -> Sparse {
        self.sparse(|add| {
            self.visit_supports(Support::skew_part, add);
            self.visit_circulation(add);
        })
    }

    /// Damping matrix of shafts, bearings and connections, without modal damping.
    pub fn sparse_damping(&self, speed: f64) -> Sparse {
        self.sparse(|add| self.visit_damping(speed, add))
    }

    /// Gyroscopic matrix G per unit speed of the reference shaft.
    pub fn sparse_gyroscopic(&self) -> Sparse {
        self.sparse(|add| self.visit_gyroscopic(add))
    }

    /// Entries (row, column, value) of K, H, C, G and M at `speed`, rad/s, in any order, whose sums are the matrices less those of
    /// `base`, a model with the same coordinates, at its speed, rad/s. Elements that both models share give no entries.
    pub fn matrix_changes(&self, base: Option<(&Self, f64)>, speed: f64) -> [Vec<(usize, usize, f64)>; 5] {
        type Visit = fn(&Model, f64, Add<'_>);
        let visits: [Visit; 5] = [
            Self::visit_stiffness,
            Self::visit_structural,
            Self::visit_damping,
            |model, _, add| model.visit_gyroscopic(add),
            |model, _, add| model.visit_mass(add),
        ];
        let entries = |(model, speed): (&Self, f64), visit: Visit| model.entries(|add| visit(model, speed, add));
        visits.map(|visit| {
            let mut own = entries((self, speed), visit);
            let known = base.map_or_else(Vec::new, |base| entries(base, visit));
            let has_same_places = own.len() == known.len()
                && own.iter().zip(&known).all(|(own, known)| (own.0, own.1) == (known.0, known.1));
            if has_same_places {
                let changes = own.iter().zip(&known).filter(|(own, known)| own.2 != known.2);
                return changes.map(|(own, known)| (own.0, own.1, own.2 - known.2)).collect();
            }
            own.extend(known.into_iter().map(|(row, column, value)| (row, column, -value)));
            own
        })
    }

    /// Entries (row, column, value) of the structural damping of shafts.
    pub fn structural_of_shafts(&self, damping: StructuralDamping) -> Vec<(usize, usize, Complex64)> {
        let mut entries = Vec::new();
        for shaft in self.shafts.iter().filter(|shaft| shaft.loss_factor > 0.0) {
            if let (Some(chain), Some(structural)) = (&shaft.bending, &shaft.structural) {
                // With v = (p + m)/2 and w = (p − m)/2i.
                let [forward, backward] = damping.turning(shaft.ratio);
                let same = (forward + backward) / 2.0;
                let cross = (forward - backward) / 2.0 * Complex64::I;
                structural.for_each(|row, column, value| {
                    let (row, column) = (chain.start + 2 * row, chain.start + 2 * column);
                    entries.push((row, column, same * value));
                    entries.push((row + 1, column + 1, same * value));
                    entries.push((row, column + 1, cross * value));
                    entries.push((row + 1, column, -cross * value));
                });
            }
            let standing = damping.standing() * shaft.loss_factor;
            for chain in shaft.rods() {
                visit_rod(chain, Some(&chain.stiffness), &mut |row, column, value| {
                    entries.push((row, column, standing * value));
                });
            }
        }
        entries
    }

    /// Entries (row, column, value) of the structural damping of all elements, with the flanks in contact at `flank_speed`, rad/s.
    pub fn structural_entries(&self, damping: StructuralDamping, flank_speed: f64) -> Vec<(usize, usize, Complex64)> {
        let mut entries = self.structural_of_shafts(damping);
        let standing = damping.standing();
        self.visit_structural(flank_speed, &mut |row, column, value| {
            entries.push((row, column, standing * value));
        });
        entries
    }

    /// `force +=` the structural damping of a mode λ at `speed` of the reference shaft, rad/s, times `shape`; a motion without
    /// oscillation has none.
    pub fn add_structural_force(
        &self,
        eigenvalue: Complex64,
        speed: f64,
        shape: &DVector<Complex64>,
        force: &mut DVector<Complex64>,
    ) {
        if eigenvalue.im != 0.0 && self.has_structural_damping() {
            let damping = StructuralDamping { frequency: eigenvalue.im, speed };
            for (row, column, value) in self.structural_entries(damping, speed) {
                force[row] += value * shape[column];
            }
        }
    }

    fn visit_stiffness(&self, speed: f64, add: Add<'_>) {
        self.visit_shaft_stiffness(add);
        self.visit_supports(|support| support.stiffness, add);
        self.visit_circulation(add);
        self.visit_connections(speed, |connection| connection.linear(speed).stiffness, add);
    }

    fn visit_damping(&self, speed: f64, add: Add<'_>) {
        self.visit_damping_without_meshes(add);
        self.visit_connections(speed, |connection| connection.linear(speed).damping, add);
    }

    fn visit_structural(&self, speed: f64, add: Add<'_>) {
        let lossy = |support: &Support| support.stiffness.map(|row| row.map(|value| support.loss_factor * value));
        self.visit_supports(lossy, add);
        let of = |connection: &Connection<'_>| connection.linear(speed).stiffness * connection.loss_factor();
        self.visit_connections(speed, of, add);
    }

    /// Whether an element has a loss factor.
    pub fn has_structural_damping(&self) -> bool {
        self.has_structural_damping_of_shafts()
            || self.local_elements().any(|element| element.loss_factor != 0.0)
            || self.connections(0.0).any(|connection| connection.loss_factor() != 0.0)
    }

    /// Largest loss factor of all elements.
    pub fn largest_loss_factor(&self) -> f64 {
        let shafts = self.shafts.iter().map(|shaft| shaft.loss_factor);
        let elements = self.local_elements().map(|element| element.loss_factor);
        let connections = self.connections(0.0).map(|connection| connection.loss_factor());
        shafts.chain(elements).fold(0.0, f64::max).max(connections.fold(0.0, f64::max))
    }

    /// Whether a shaft has a loss factor.
    pub fn has_structural_damping_of_shafts(&self) -> bool {
        self.shafts.iter().any(|shaft| shaft.loss_factor != 0.0)
    }

    /// C + ΩG at the speed Ω of the reference shaft, rad/s, without modal damping.
    pub fn sparse_rate(&self, speed: f64) -> Sparse {
        self.sparse(|add| {
            self.visit_damping_without_meshes(add);
            self.visit_connections(speed, |connection| connection.linear(speed).damping, add);
            self.visit_gyroscopic(&mut |row, column, value| add(row, column, speed * value));
        })
    }

    /// `out += K x` of shafts, bearings and connections with the flanks in contact at `speed`, rad/s; `symmetric` selects
    /// the symmetric part of the bearing stiffness. Forces of the shafts come from strains, which leave out the round-off of
    /// rigid motions.
    pub fn multiply_stiffness(&self, speed: f64, symmetric: bool, x: &[f64], out: &mut [f64]) {
        out.iter_mut().for_each(|value| *value = -*value);
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                chain.subtract_elastic::<2>(&x[chain.start..], &mut out[chain.start..]);
            }
            for chain in shaft.rods() {
                chain.subtract_elastic::<1>(&x[chain.start..], &mut out[chain.start..]);
            }
        }
        out.iter_mut().for_each(|value| *value = -*value);
        self.multiply_supports(|support| if symmetric { support.symmetric_part } else { support.stiffness }, x, out);
        if !symmetric {
            self.visit_circulation(&mut |row, column, value| out[row] += value * x[column]);
        }
        self.multiply_connections(speed, |connection| connection.linear(speed).stiffness, x, out);
    }

    /// `out += C x` of shafts, bearings and connections at `speed`, rad/s, without modal damping.
    pub fn multiply_damping(&self, speed: f64, x: &[f64], out: &mut [f64]) {
        self.visit_shaft_damping(&mut |row, column, value| out[row] += value * x[column]);
        self.multiply_supports(|support| support.damping, x, out);
        self.multiply_connections(speed, |connection| connection.linear(speed).damping, x, out);
    }

    /// `out += G x` with G per unit speed of the reference shaft.
    pub fn multiply_gyroscopic(&self, x: &[f64], out: &mut [f64]) {
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                // −iu of u = v + iw is w − iv.
                let own = &x[chain.start..chain.start + 2 * shaft.gyroscopic.len()];
                let turned: Vec<f64> = own.as_chunks::<2>().0.iter().flat_map(|[v, w]| [*w, -v]).collect();
                shaft.gyroscopic.multiply_add::<2>(shaft.ratio, &turned, &mut out[chain.start..]);
            }
            shaft.visit_coriolis(&mut |row, column, value| out[row] += value * x[column]);
        }
    }

    /// Product of a real matrix with a complex vector; `multiply(x, out)` adds the product with a real vector.
    pub fn product(&self, x: &DVector<Complex64>, multiply: impl Fn(&[f64], &mut [f64])) -> DVector<Complex64> {
        image_of_parts(x, |part| {
            let mut image = DVector::zeros(self.len());
            multiply(part.as_slice(), image.as_mut_slice());
            image
        })
    }

    fn dense(&self, visit: impl Fn(Add<'_>)) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.len(), self.len());
        visit(&mut |row, column, value| matrix[(row, column)] += value);
        matrix
    }

    fn sparse(&self, visit: impl Fn(Add<'_>)) -> Sparse {
        Sparse::new(self.len(), self.entries(visit))
    }

    /// Entries (row, column, value) of a matrix, whose sums are its entries. Those between the modes of an elastic housing are
    /// summed.
    fn entries(&self, visit: impl Fn(Add<'_>)) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        // Every bearing has entries between all modes of its elastic housing.
        let modes = &self.housings.modes;
        let mut blocks: Vec<_> = modes.iter().map(|modes| DMatrix::zeros(modes.len(), modes.len())).collect();
        visit(&mut |row, column, value| match modes
            .iter()
            .position(|modes| modes.contains(&row) && modes.contains(&column))
        {
            Some(housing) => {
                let start = modes[housing].start;
                blocks[housing][(row - start, column - start)] += value;
            }
            None => entries.push((row, column, value)),
        });
        for (modes, block) in modes.iter().zip(&blocks) {
            for (column, values) in modes.clone().zip(block.column_iter()) {
                let values = modes.clone().zip(values.iter().copied()).filter(|(_, value)| *value != 0.0);
                entries.extend(values.map(|(row, value)| (row, column, value)));
            }
        }
        entries
    }

    fn visit_mass(&self, add: Add<'_>) {
        for shaft in &self.shafts {
            visit_bending(shaft.bending.as_ref(), |chain| Some(&chain.mass), add);
            shaft.rods().for_each(|chain| visit_rod(chain, Some(&chain.mass), add));
        }
        for (index, inertia) in self.housings.coordinates().zip(&self.housings.inertia) {
            add(index, index, *inertia);
        }
    }

    fn visit_shaft_stiffness(&self, add: Add<'_>) {
        for shaft in &self.shafts {
            visit_bending(shaft.bending.as_ref(), |chain| Some(&chain.stiffness), add);
            shaft.rods().for_each(|chain| visit_rod(chain, Some(&chain.stiffness), add));
        }
    }

    fn visit_damping_without_meshes(&self, add: Add<'_>) {
        self.visit_shaft_damping(add);
        self.visit_supports(|support| support.damping, add);
    }

    fn visit_shaft_damping(&self, add: Add<'_>) {
        for shaft in &self.shafts {
            visit_bending(shaft.bending.as_ref(), |chain| chain.damping.as_ref(), add);
            shaft.rods().for_each(|chain| visit_rod(chain, chain.damping.as_ref(), add));
        }
    }

    /// −iΩ_s βK_s of each shaft with internal damping, and what frames that turn add to the stiffness, at the speed that the model
    /// contains.
    pub fn visit_circulation(&self, add: Add<'_>) {
        if let Some(speed) = self.circulation {
            self.visit_circulation_per_speed(&mut |row, column, value| add(row, column, speed * value));
            self.visit_frames(speed, add);
        }
    }

    /// The same per unit speed of the reference shaft.
    pub fn visit_circulation_per_speed(&self, add: Add<'_>) {
        for shaft in &self.shafts {
            if let (Some(chain), Some(circulatory)) = (&shaft.bending, &shaft.circulatory) {
                circulatory.for_each(|row, column, value| {
                    let (row, column) = (chain.start + 2 * row, chain.start + 2 * column);
                    add(row, column + 1, shaft.ratio * value);
                    add(row + 1, column, -shaft.ratio * value);
                });
            }
        }
    }

    fn visit_gyroscopic(&self, add: Add<'_>) {
        for shaft in &self.shafts {
            if let Some(chain) = &shaft.bending {
                shaft.gyroscopic.for_each(|row, column, value| {
                    let (row, column) = (chain.start + 2 * row, chain.start + 2 * column);
                    add(row, column + 1, shaft.ratio * value);
                    add(row + 1, column, -shaft.ratio * value);
                });
            }
            shaft.visit_coriolis(add);
        }
    }

    /// Adds the 2 × 2 coefficient `select` over (v, w) of every bearing with constant coefficients, and that over the
    /// scalars of every link.
    pub(super) fn visit_supports(&self, select: impl Fn(&Support) -> [[f64; 2]; 2], add: Add<'_>) {
        for support in &self.supports {
            for (i, row) in select(support).iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    add(support.index + i, support.index + j, *value);
                }
            }
        }
        for link in &self.links {
            let coefficient = select(&link.local);
            for (i, left) in link.rows.iter().enumerate() {
                for (j, right) in link.rows.iter().enumerate() {
                    let value = coefficient[i][j];
                    if value != 0.0 {
                        add_product(value, left, right, add);
                    }
                }
            }
        }
    }

    /// `out +=` the product of the matrix of `visit_supports` and `x`.
    fn multiply_supports(&self, select: impl Fn(&Support) -> [[f64; 2]; 2], x: &[f64], out: &mut [f64]) {
        let force = |support: &Support, u: [f64; 2]| select(support).map(|row| row[0] * u[0] + row[1] * u[1]);
        for support in &self.supports {
            let index = support.index;
            let [y, z] = force(support, [x[index], x[index + 1]]);
            out[index] += y;
            out[index + 1] += z;
        }
        for link in &self.links {
            link.subtract(force(&link.local, link.scalars(x)).map(|force| -force), out);
        }
    }

    /// `out +=` the product of the matrix of `visit_connections` and `x`.
    fn multiply_connections(
        &self,
        speed: f64,
        of: impl Fn(&Connection<'_>) -> DMatrix<f64>,
        x: &[f64],
        out: &mut [f64],
    ) {
        for connection in self.connections(speed).filter(Connection::is_local) {
            let rows = connection.rows();
            let scalar = |row: &Row| row.iter().map(|(index, coefficient)| coefficient * x[*index]).sum::<f64>();
            let scalars = DVector::from_iterator(rows.len(), rows.iter().map(scalar));
            for (row, force) in rows.iter().zip(&(of(&connection) * scalars)) {
                row.iter().for_each(|(index, coefficient)| out[*index] += coefficient * force);
            }
        }
    }

    fn visit_connections(&self, speed: f64, of: impl Fn(&Connection<'_>) -> DMatrix<f64>, add: Add<'_>) {
        for connection in self.connections(speed).filter(Connection::is_local) {
            let (rows, coefficients) = (connection.rows(), of(&connection));
            for (i, left) in rows.iter().enumerate() {
                for (j, right) in rows.iter().enumerate() {
                    add_product(coefficients[(i, j)], left, right, add);
                }
            }
        }
    }
}

/// Adds value·left·rightᵀ.
fn add_product(value: f64, left: &Row, right: &Row, add: Add<'_>) {
    for (row, left) in left {
        for (column, right) in right {
            add(*row, *column, value * left * right);
        }
    }
}

/// Adds a matrix of the bending of a shaft to both planes.
fn visit_bending<'a>(
    chain: Option<&'a BendingChain>,
    select: impl Fn(&'a BendingChain) -> Option<&'a ChainMatrix<2>>,
    add: Add<'_>,
) {
    if let Some((chain, part)) = chain.and_then(|chain| Some((chain, select(chain)?))) {
        part.for_each(|row, column, value| {
            for lane in 0..2 {
                add(chain.start + 2 * row + lane, chain.start + 2 * column + lane, value);
            }
        });
    }
}

/// Adds a matrix of the torsion or the axial motion of a shaft.
fn visit_rod(chain: &RodChain, part: Option<&ChainMatrix<1>>, add: Add<'_>) {
    if let Some(part) = part {
        part.for_each(|row, column, value| add(chain.start + row, chain.start + column, value));
    }
}
