//! Static equilibrium under torque, gravity and the mesh forces, by Newton with the exact mesh tangent.
//!
//! Null motions, the rolling of a train among them, are held at zero in the mass sense. They change no force, and a
//! load that drives one has no equilibrium.

use nalgebra::{DMatrix, DVector};

use super::AnalysisError;
use crate::linalg::LuFactors;
use crate::mesh::{Flank, Geometry};
use crate::modal::CachedModel;
use crate::model::Model;
use crate::scene::SceneError;

/// A load on a null motion below this part of what acts there is round-off.
const BALANCED: f64 = 1e-9;
/// The part of the load that the stiffness of null motions may carry, round-off.
const CARRIED: f64 = 1e-6;
/// ExcitationPart of a null motion that is round-off where it should not move.
const ROUND_OFF: f64 = 1e-12;
/// Newton has converged when the energy of its step is below this part of that of the load: displacements to 1e-13.
const CONVERGED: f64 = 1e-26;
/// Round-off of a stiff scene may not allow that: a step that stopped shrinking below this part has converged too.
const STALLED: f64 = 1e-14;
/// A step that leaves more than this part of the energy of the one before asks for a new tangent.
const SLOW: f64 = 1e-4;
/// A smooth problem takes three to five; more mean that there is no equilibrium near.
const ITERATIONS: usize = 60;

/// Displacements q of the equilibrium with the flanks that carry at `speed`; bow and unbalance, which turn, are not
/// part of it.
///
/// # Errors
/// [`AnalysisError`] if the load has no equilibrium, base circles overlap, or the iteration fails.
pub fn equilibrium(cached: &CachedModel, geometry: Geometry, speed: f64) -> Result<DVector<f64>, AnalysisError> {
    let model = &cached.model;
    let real = cached.real_modes(speed)?;
    let load = &model.constant_load;
    let null = real.vectors.columns(0, real.null).into_owned();
    check_balance(model, &null, load)?;
    // Null motions get a stiffness of their own, that of the lowest elastic mode; no load ever meets it.
    let lowest = real.frequencies.iter().copied().find(|frequency| *frequency > 0.0).unwrap_or(1.0);
    let held = model.mass_times(&null) * lowest;
    let mut linear = model.shaft_stiffness_matrix();
    linear += model.support_stiffness_matrix();
    linear.gemm(1.0, &held, &held.transpose(), 1.0);

    let mut flanks = vec![Flank::Drive; model.meshes.len()];
    let mut q = DVector::zeros(model.len());
    let mut previous = f64::INFINITY;
    let mut factors: Option<LuFactors> = None;
    for _ in 0..ITERATIONS {
        let (force, tangent) = mesh_forces(model, geometry, speed, &flanks, &q)?;
        // Summed from strains: rigid motion, large beside them in soft bearings, leaves no round-off.
        let residual = load - model.static_force(&q) - force;
        let known = factors.get_or_insert_with(|| {
            let mut matrix = linear.clone();
            for (row, column, value) in &tangent {
                matrix[(*row, *column)] += value;
            }
            LuFactors::new(&matrix)
        });
        let step = known.solve(&DMatrix::from_column_slice(model.len(), 1, residual.as_slice()));
        let step = step.column(0);
        let energy = step.dot(&residual).abs();
        let scale = load.dot(&q).abs().max(energy);
        let stalled = energy <= STALLED * scale && energy >= previous / 4.0;
        let converged = energy <= CONVERGED * scale || stalled;
        // The tangent of an earlier step serves as long as it leaves little.
        if energy > SLOW * previous {
            factors = None;
        }
        previous = energy;
        let fraction = admissible(model, geometry, speed, &q, &step.into_owned())?;
        q.axpy(fraction, &step, 1.0);
        if !q.iter().all(|value| value.is_finite()) {
            break;
        }
        if converged {
            // A flank that would pull has parted; the other one carries.
            let pulls = pulling(model, geometry, speed, &flanks, &q)?;
            if pulls.is_empty() {
                check_held(&(&held * held.tr_mul(&q)), load)?;
                return Ok(q);
            }
            for mesh in pulls {
                flanks[mesh] = if flanks[mesh] == Flank::Drive { Flank::Back } else { Flank::Drive };
            }
            (previous, factors) = (f64::INFINITY, None);
        }
    }
    Err(AnalysisError::Convergence(format!("no static equilibrium found in {ITERATIONS} Newton iterations")))
}

/// A load that drives a null motion has no equilibrium: says whether a bearing or a torque is missing.
fn check_balance(model: &Model, null: &DMatrix<f64>, load: &DVector<f64>) -> Result<(), AnalysisError> {
    // Null motions may be any mixture of rolling and sideways motion. Their sum is the acceleration under the load, which
    // does not depend on the mixture.
    let mut acceleration = DVector::zeros(model.len());
    for column in null.column_iter() {
        let drive: f64 = column.dot(load);
        let acting: f64 = column.iter().zip(load.iter()).map(|(motion, load)| (motion * load).abs()).sum();
        // Of a motion that does not move at a load, round-off is left there.
        let nothing = ROUND_OFF * column.amax() * load.lp_norm(1);
        if drive.abs() > (BALANCED * acting).max(nothing) {
            acceleration.axpy(drive, &column, 1.0);
        }
    }
    let largest = acceleration.amax();
    if largest == 0.0 {
        return Ok(());
    }
    let lateral = model.numbering.dofs().iter().filter(|dof| dof.kind.is_lateral());
    let (shaft, sideways) = lateral.fold((0, 0.0), |(shaft, most), dof| {
        let motion = acceleration[dof.index].abs();
        if motion > most { (dof.node.shaft, motion) } else { (shaft, most) }
    });
    Err(if sideways > CARRIED * largest { unsupported(model, shaft) } else { unbalanced(model) }.into())
}

/// The load moves a shaft sideways that its bearings do not hold.
fn unsupported(model: &Model, shaft: usize) -> SceneError {
    let name = &model.scene.shafts[shaft].name;
    let has_bearing = model.scene.bearings.iter().any(|bearing| bearing.node.shaft == shaft);
    let cause = if has_bearing {
        format!(
            "the bearings of \"{name}\" let the load move or tilt it; add one at another position, or give those that it has a stiffness in both directions"
        )
    } else {
        format!(
            "no bearing holds \"{name}\" sideways against the load; add gb.Bearing(\"{name}\", position, stiffness=...)"
        )
    };
    SceneError::new(format!("shafts[{shaft}]"), format!("no static equilibrium: {cause}"))
}

/// The torques turn the train.
fn unbalanced(model: &Model) -> SceneError {
    let scene = &model.scene;
    let net: f64 = scene.torques.iter().map(|torque| torque.value * scene.speed_ratios[torque.node.shaft]).sum();
    SceneError::new(
        "torques",
        format!(
            "no static equilibrium: the torques do not balance, {net} N m of them, referred to the reference shaft, speed up the train; add gb.Torque.balance(at) where the load takes its torque"
        ),
    )
}

/// Bearings whose stiffness is neither symmetric nor regular hold what their null motions do not tell: what those got for
/// a stiffness must carry nothing.
fn check_held(carried: &DVector<f64>, load: &DVector<f64>) -> Result<(), AnalysisError> {
    if carried.norm() <= CARRIED * load.norm() {
        return Ok(());
    }
    let message = "the stiffness of a bearing is singular, and pushes where it does not hold: no static equilibrium";
    Err(SceneError::new("bearings", message).into())
}

/// Row, column and value of an entry of a matrix; entries of one place add up.
type Entry = (usize, usize, f64);

/// ΣF ∂δ/∂q and its derivative.
fn mesh_forces(
    model: &Model,
    geometry: Geometry,
    speed: f64,
    flanks: &[Flank],
    q: &DVector<f64>,
) -> Result<(DVector<f64>, Vec<Entry>), AnalysisError> {
    let mut force = DVector::zeros(model.len());
    let mut tangent = Vec::new();
    for (index, (mesh, flank)) in model.meshes.iter().zip(flanks).enumerate() {
        let sigma = model.sigma(index, speed);
        let (pressed, normal) = mesh
            .mean_tangent(geometry, sigma, *flank, q.as_slice(), |row, column, value| {
                tangent.push((row, column, value))
            })
            .map_err(|overlap| overlapped(model, index, overlap))?;
        let sigma = if *flank == Flank::Back { -sigma } else { sigma };
        mesh.gradient(sigma, normal, |row, slope| force[row] += pressed * slope);
    }
    Ok((force, tangent))
}

/// Meshes with backlash whose flank would have to pull.
fn pulling(
    model: &Model,
    geometry: Geometry,
    speed: f64,
    flanks: &[Flank],
    q: &DVector<f64>,
) -> Result<Vec<usize>, AnalysisError> {
    let mut pulling = Vec::new();
    for (index, (mesh, flank)) in model.meshes.iter().zip(flanks).enumerate() {
        let sigma = model.sigma(index, speed);
        let (force, _) = mesh
            .mean_tangent(geometry, sigma, *flank, q.as_slice(), |_, _, _| {})
            .map_err(|overlap| overlapped(model, index, overlap))?;
        // An unloaded mesh rests on its flank with a force of round-off.
        let scale = mesh.stiffness * mesh.involute.base_radius[0] * f64::EPSILON;
        if mesh.backlash.is_some() && force < -scale {
            pulling.push(index);
        }
    }
    Ok(pulling)
}

/// The part of a Newton step that keeps the base circles apart.
fn admissible(
    model: &Model,
    geometry: Geometry,
    speed: f64,
    q: &DVector<f64>,
    step: &DVector<f64>,
) -> Result<f64, AnalysisError> {
    let mut fraction = 1.0;
    for (index, mesh) in model.meshes.iter().enumerate() {
        let sigma = model.sigma(index, speed);
        while let Err(overlap) =
            mesh.mean_tangent(geometry, sigma, Flank::Drive, (q + step * fraction).as_slice(), |_, _, _| {})
        {
            fraction /= 2.0;
            if fraction < 1e-3 {
                return Err(overlapped(model, index, overlap));
            }
        }
    }
    Ok(fraction)
}

fn overlapped(model: &Model, mesh: usize, overlap: crate::mesh::Overlap) -> AnalysisError {
    let [driver, driven] = model.gear_names(mesh);
    AnalysisError::overlap(driver, driven, "in static equilibrium", overlap)
}
