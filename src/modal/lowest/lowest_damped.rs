//! The lowest modes with strong damping, in time proportional to n: Galerkin projection, a count, and refinement.
//!
//! The space of [`super::galerkin`] has
//! the undamped modes up to a frequency ω_m, several times the highest wanted frequency ω, and the responses to forces of the
//! dampers. In all other motions the elastic and inertial forces, K + |λ|²M, exceed the damping and gyroscopic forces.
//! These motions therefore have no eigenvalue of low frequency, and they change the eigenvalues of the space by a relative
//! amount of about (ω/ω_m)⁴. To check that the space misses no mode, [`super::contour`] counts the eigenvalues.
//!
//! Each refinement adds the errors of the wanted modes to the space, and multiplies them by about ζω/ω_m.

use nalgebra::DVector;
use num_complex::Complex64;

use super::arnoldi::undamped_modes;
use super::contour::SECTOR;
use super::galerkin::{Approximation, Galerkin};
use super::shift_invert::{Eigenpair, Problem};
use crate::linalg::DecompositionError;

/// Part of all motions up to which a space is faster than dense matrices.
const FEW: f64 = 0.3;
/// Undamped modes of the space beyond 3/2 of the wanted ones.
const FURTHER_MODES: usize = 24;
/// Number of times that the space is extended for missing modes.
const MAX_EXTENSIONS: usize = 3;
/// Smallest ratio of the highest frequency of the undamped modes to the radius of the count.
const MARGIN: f64 = 2.5;
/// Smallest relative distance of two magnitudes between which the radius of the count lies.
const GAP: f64 = 1e-3;
/// Part of an accurate mode shape outside of the space.
const ACCURATE: f64 = 1e-8;
/// Relative change of an eigenvalue in a refinement that ends its refinements, because round-off may limit the shape.
const UNCHANGED: f64 = 1e-9;
/// Relative distance of an accurate eigenvalue from that of a larger space.
const SAME: f64 = 1e-9;
/// Relative distance of close eigenvalues.
const CLOSE: f64 = 0.1;
/// Part of a mode shape outside of the space below which its eigenvalue is on the right side of a
/// contour.
const RECOGNISED: f64 = 1e-4;
/// Cosine of the angle from the real axis up to which approximations may belong to eigenvalues in the sectors, 84°.
const NEAR: f64 = 0.1;
/// Largest difference of a count that is corrected.
const MAX_MISSING: i64 = 40;
/// Largest number of corrections of a count.
const MAX_CORRECTIONS: usize = 4;
/// Largest number of refinements.
const MAX_REFINEMENTS: usize = 8;

/// The `count` modes of lowest |Im λ| of a problem, rigid-body modes first; `None` if dense matrices are needed.
///
/// # Errors
/// [`DecompositionError`] if a linear system has no accurate solution, or an eigenvalue iteration fails.
pub fn lowest_damped(problem: &Problem<'_>, count: usize) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
    let undamped = problem.without_damping();
    let null = problem.null.ncols();
    let elastic = count.saturating_sub(null);
    let mut size = count + elastic / 2 + FURTHER_MODES;
    for _ in 0..=MAX_EXTENSIONS {
        if size as f64 > FEW * problem.model.len() as f64 {
            return Ok(None);
        }
        let Some(modes) = undamped_modes(&undamped, size)? else {
            return Ok(None);
        };
        let top = modes.highest();
        let mut space = Galerkin::new(problem, modes);
        space.add_dampers(problem.rates(top / 8.0))?;
        if let Some(found) = counted(&mut space, elastic, top, problem)? {
            return refined(&mut space, found, count, problem);
        }
        size += size / 2;
    }
    Ok(None)
}

/// Approximations of all modes, if the space misses no eigenvalue of the region of the count, which contains the `elastic`
/// lowest modes; `top` is the highest frequency of the undamped modes, rad/s.
///
/// An approximation in the sectors may belong to an eigenvalue outside of them, and the other way round. Where the count
/// differs, the errors of the inaccurate approximations in and near the region are therefore added to the space.
fn counted(
    space: &mut Galerkin<'_, '_>,
    elastic: usize,
    top: f64,
    problem: &Problem<'_>,
) -> Result<Option<Vec<Approximation>>, DecompositionError> {
    for _ in 0..=MAX_CORRECTIONS {
        let found = space.eigenpairs()?;
        let Some(radius) = radius(&found, elastic).filter(|radius| MARGIN * radius <= top) else {
            return Ok(None);
        };
        let missing = problem.missing_lowest(found.iter().map(|pair| pair.value), radius);
        match missing {
            Some(0) => return Ok(Some(found)),
            Some(missing) if missing.abs() <= MAX_MISSING => {}
            _ => return Ok(None),
        }
        let is_near = |value: Complex64| value.norm() < radius || value.re.abs() > NEAR * value.norm();
        let mut directions = Vec::new();
        for mode in found.iter().filter(|mode| is_near(mode.value)) {
            let (error, size) = space.error(mode)?;
            if size > RECOGNISED {
                directions.extend(parts(mode, &error));
            }
        }
        let grown = (space.size() + directions.len()) as f64;
        if directions.is_empty() || grown > FEW * problem.model.len() as f64 {
            return Ok(None);
        }
        space.add(&directions);
    }
    Ok(None)
}

/// Real and imaginary part of the error of a mode; that of a real eigenvalue is real.
fn parts(mode: &Approximation, error: &DVector<Complex64>) -> impl Iterator<Item = DVector<f64>> {
    let imaginary = (mode.value.im != 0.0).then(|| error.map(|value| value.im));
    std::iter::once(error.map(|value| value.re)).chain(imaginary)
}

/// Radius in a gap of the magnitudes of all approximations, rad/s, so that the `number` wanted modes have lower frequencies
/// than every mode outside of the count.
fn radius(approximations: &[Approximation], number: usize) -> Option<f64> {
    let mut sizes: Vec<f64> = approximations.iter().map(|pair| pair.value.norm()).collect();
    sizes.sort_by(f64::total_cmp);
    let below = |radius: f64| approximations.iter().filter(|pair| pair.value.im < radius * SECTOR.sin()).count();
    let gaps = sizes.windows(2).filter(|pair| pair[1] > (1.0 + GAP) * pair[0]);
    gaps.map(|pair| f64::midpoint(pair[0], pair[1])).find(|radius| below(*radius) >= number)
}

/// The `count` lowest modes of the space, which it extends until they are accurate.
fn refined(
    space: &mut Galerkin<'_, '_>,
    mut found: Vec<Approximation>,
    count: usize,
    problem: &Problem<'_>,
) -> Result<Option<Vec<Eigenpair>>, DecompositionError> {
    let elastic = count.saturating_sub(problem.null.ncols());
    let (mut previous, mut accurate): (Vec<Complex64>, Vec<Complex64>) = (Vec::new(), Vec::new());
    for _ in 0..MAX_REFINEMENTS {
        found.sort_by(|a, b| a.value.im.total_cmp(&b.value.im).then(a.value.norm().total_cmp(&b.value.norm())));
        let (wanted, others) = found.split_at(elastic.min(found.len()));
        let mut known = std::mem::take(&mut accurate);
        let (mut directions, mut inaccurate) = (Vec::new(), Vec::new());
        for mode in wanted {
            if let Some(index) = known.iter().position(|value| is_near(*value, mode.value, SAME)) {
                accurate.push(known.swap_remove(index));
                continue;
            }
            let (error, size) = space.error(mode)?;
            if size <= ACCURATE || previous.iter().any(|value| is_near(*value, mode.value, UNCHANGED)) {
                accurate.push(mode.value);
                continue;
            }
            directions.extend(parts(mode, &error));
            inaccurate.push(mode.value);
        }
        if directions.is_empty() {
            return Ok(Some(eigenpairs(space, wanted, count, problem)));
        }
        // The errors of close modes, such as those of many equal dampers, contain each other.
        for mode in others.iter().filter(|mode| inaccurate.iter().any(|value| is_near(*value, mode.value, CLOSE))) {
            directions.extend(parts(mode, &space.error(mode)?.0));
        }
        previous = wanted.iter().map(|mode| mode.value).collect();
        space.add(&directions);
        found = space.eigenpairs()?;
    }
    Ok(None)
}

/// Whether two eigenvalues differ by less than a part of the second.
fn is_near(value: Complex64, other: Complex64, part: f64) -> bool {
    (value - other).norm() <= part * other.norm()
}

/// Rigid-body modes, and the found ones with φᴴMφ = 1, in ascending order.
fn eigenpairs(
    space: &Galerkin<'_, '_>,
    found: &[Approximation],
    count: usize,
    problem: &Problem<'_>,
) -> Vec<Eigenpair> {
    let elastic = found.iter().map(|mode| {
        let shape = space.shape(mode);
        let size = problem.model.complex_kinetic_form(&shape).sqrt();
        Eigenpair { value: mode.value, shape: shape.unscale(size) }
    });
    Eigenpair::lowest(problem.rigid_body_modes().chain(elastic).collect(), count)
}
