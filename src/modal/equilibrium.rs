//! Static equilibrium under torques, gravity and the forces of meshes and bearings, by Newton's method with the exact tangent.
//!
//! Each step solves one system with the band matrices of the shafts, in time proportional to n. The solution contains no
//! null motion (motion without elastic force, for example the rigid-body rotation), in the inner product of the mass
//! matrix. A load that drives a null motion has no equilibrium.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use thiserror::Error;

use super::clearance::{Entry, check_journals, regularisation, within_clearances};
use super::pins::Pins;
use super::real::null_motions;
use crate::connection::{Connection, Row};
use crate::film::CLOSEST;
use crate::linalg::{CoupledBands, CoupledFactors, DecompositionError};
use crate::mesh::{Flank, Geometry, Overlap};
use crate::model::{Dof, DofKind, Model, Weights};
use crate::scene::{SceneError, short};

/// Work of the load on a null motion, relative to the sum of its absolute terms, below which it is round-off.
const BALANCE_TOLERANCE: f64 = 1e-9;
/// Largest fraction of the load that the springs on the null motions may carry, as round-off.
const UNSUPPORTED_TOLERANCE: f64 = 1e-6;
/// Component of a null motion, relative to its largest one, below which it is round-off.
const ROUND_OFF: f64 = 1e-12;
/// Energy of a Newton step, relative to the energy of the load, below which the iteration has converged; displacements
/// are then accurate to 1e-13.
const CONVERGENCE_TOLERANCE: f64 = 1e-26;
/// The same limit for steps that have stopped to decrease, because of round-off in stiff scenes.
const STALL_TOLERANCE: f64 = 1e-14;
/// Ratio of the energies of successive steps above which the tangent is computed anew.
const TANGENT_REUSE_RATIO: f64 = 1e-4;
/// Largest number of iterations. A smooth problem takes three to five, a loaded journal or rolling bearing up to twenty.
const MAX_ITERATIONS: usize = 60;
/// Eccentricity ratio above which a search that fails means that the journal touches.
const TOUCHING: f64 = 0.9;
/// Eccentricity ratio below which a journal carries no load.
const UNLOADED: f64 = 1e-9;

/// The reason why there is no equilibrium.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EquilibriumError {
    /// The loads have no equilibrium.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The base circles of the mesh with this index overlap.
    #[error("base circles overlap")]
    Overlap(usize, Overlap),
    /// The iteration did not converge.
    #[error("{0}")]
    Convergence(String),
    /// A decomposition fails.
    #[error(transparent)]
    Decomposition(#[from] DecompositionError),
}

/// Speeds of the reference shaft, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquilibriumSpeeds {
    /// The speed of nonlinear bearings.
    pub film: f64,
    /// The speed of torques over the speed, which also determines the flanks in contact.
    pub flanks: f64,
}

impl From<f64> for EquilibriumSpeeds {
    fn from(speed: f64) -> Self {
        Self { film: speed, flanks: speed }
    }
}

/// Displacements q of the equilibrium. `model` belongs to the speed of its nonlinear bearings. Bow and unbalance rotate and are not included.
///
/// # Errors
/// [`EquilibriumError`] if the load has no equilibrium, base circles overlap, a journal touches or carries no load, or the
/// iteration fails.
pub fn equilibrium(
    model: &Model,
    geometry: Geometry,
    speeds: EquilibriumSpeeds,
) -> Result<DVector<f64>, EquilibriumError> {
    let (speed, load) = (speeds.flanks, &model.constant_load);
    model.check_speed(speed)?;
    let with_torques = load + model.speed_torques(speed);
    let null = null_motions(model, speed)?;
    check_balance(model, &null, &with_torques, speed)?;
    let pins = Pins::new(model, &null);
    let mut linear = model.shaft_stiffness(&Weights::stiffness());
    pins.add_to(model, &mut linear);

    let mut flanks = vec![Flank::Drive; model.meshes.len()];
    let mut q = DVector::zeros(model.len());
    // Part of the residual that only the springs on the null motions balance.
    let mut carried = DVector::zeros(model.len());
    let mut previous = f64::INFINITY;
    let mut factors: Option<CoupledFactors> = None;
    for _ in 0..MAX_ITERATIONS {
        let (force, tangent) = connection_forces(model, geometry, speeds, &flanks, &q)?;
        // Forces from strains avoid the round-off of rigid motions, which are much larger in soft bearings.
        let residual = load - model.static_force(&q) - force;
        carried = pins.carried(&residual);
        let known = match factors.take() {
            Some(known) => known,
            None => tangent_factors(model, linear.clone(), &tangent, [&residual, &with_torques])?,
        };
        let step = model.solve_real(&known, 0.0, residual.as_slice()).map_err(DecompositionError::from)?;
        let mut step = DVector::from_vec(step);
        pins.remove_null_motions(&mut step);
        let energy = step.dot(&residual).abs();
        let scale = with_torques.dot(&q).abs().max(energy);
        let stalled = energy <= STALL_TOLERANCE * scale && energy >= previous / 4.0;
        let converged = energy <= CONVERGENCE_TOLERANCE * scale || stalled;
        // An old tangent is used as long as the steps decrease fast.
        if energy <= TANGENT_REUSE_RATIO * previous {
            factors = Some(known);
        }
        previous = energy;
        let fraction = admissible(model, geometry, speed, &q, &step)?;
        q.axpy(fraction, &step, 1.0);
        if !q.iter().all(|value| value.is_finite()) {
            break;
        }
        if converged {
            let pressed = pressed_flanks(model, geometry, speed, &flanks, &q)?;
            if pressed == flanks {
                check_constraints(&carried, &with_torques)?;
                check_journals(model, &q, UNLOADED..CLOSEST)?;
                return Ok(q);
            }
            (flanks, previous, factors) = (pressed, f64::INFINITY, None);
        }
    }
    check_journals(model, &q, 0.0..TOUCHING)?;
    check_constraints(&carried, &with_torques)?;
    Err(EquilibriumError::Convergence(format!("no static equilibrium found in {MAX_ITERATIONS} Newton iterations")))
}

/// Factors of the stiffness of shafts, bearings and pins with the tangent of the connections, where the load leaves a residual.
fn tangent_factors(
    model: &Model,
    mut sum: CoupledBands,
    tangent: &[Entry],
    [residual, load]: [&DVector<f64>; 2],
) -> Result<CoupledFactors, DecompositionError> {
    for (row, column, value) in tangent.iter().chain(&regularisation(model, residual, load)) {
        model.add_entry(&mut sum, *row, *column, Complex64::from(*value));
    }
    Ok(sum.factor(1.0)?)
}

/// Refuses a load that drives a null motion. The error says whether a bearing or a torque is missing.
fn check_balance(model: &Model, null: &DMatrix<f64>, load: &DVector<f64>, speed: f64) -> Result<(), EquilibriumError> {
    // The null motions may combine rotation and lateral motion in any way. The acceleration under the load does not
    // depend on the combination.
    let mut acceleration = DVector::zeros(model.len());
    for column in null.column_iter() {
        let drive: f64 = column.dot(load);
        let acting: f64 = column.iter().zip(load.iter()).map(|(motion, load)| (motion * load).abs()).sum();
        // Round-off of a null motion that does not move the points where loads act.
        let round_off = ROUND_OFF * column.amax() * load.lp_norm(1);
        if drive.abs() > (BALANCE_TOLERANCE * acting).max(round_off) {
            acceleration.axpy(drive, &column, 1.0);
        }
    }
    let largest = acceleration.amax();
    if largest == 0.0 {
        return Ok(());
    }
    for (index, housing) in model.housing_nodes().zip(&model.scene.housings) {
        let moves = |dof: &&Dof| dof.node == index && acceleration[dof.index].abs() > UNSUPPORTED_TOLERANCE * largest;
        if let Some(dof) = model.numbering.dofs().iter().find(moves) {
            return Err(unmounted(&housing.name, dof.kind).into());
        }
    }
    // The shaft that moves most among coordinates of one kind; none if only round-off moves them.
    let moved = |kind: fn(DofKind) -> bool| {
        let dofs = model.numbering.dofs().iter().filter(|dof| kind(dof.kind));
        let (shaft, motion) = dofs.fold((0, 0.0), |(shaft, most), dof| {
            let motion = acceleration[dof.index].abs();
            if motion > most { (dof.node.shaft, motion) } else { (shaft, most) }
        });
        (motion > UNSUPPORTED_TOLERANCE * largest).then_some(shaft)
    };
    let error = match (moved(DofKind::is_lateral), moved(|kind| kind == DofKind::Axial)) {
        (Some(shaft), _) => unsupported(model, shaft),
        (None, Some(shaft)) => loose(model, shaft),
        (None, None) => unbalanced(model, speed),
    };
    Err(error.into())
}

/// The error for a load that moves a housing: its mount does not constrain it.
fn unmounted(name: &str, motion: DofKind) -> SceneError {
    let entry = match motion {
        DofKind::Axial => "positive axial_stiffness",
        DofKind::V | DofKind::W => "stiffness along y and z",
        DofKind::B | DofKind::Gamma | DofKind::Twist => "rotational_stiffness about every axis",
    };
    SceneError::new("housings", format!("no static equilibrium: the load moves \"{name}\"; give it a {entry}"))
}

/// The error for a load that moves a shaft laterally: its bearings do not constrain it.
fn unsupported(model: &Model, shaft: usize) -> SceneError {
    let name = &model.scene.shafts[shaft].name;
    let has_bearing = model.scene.bearings.iter().any(|bearing| bearing.node.shaft == shaft);
    let cause = if has_bearing {
        format!(
            "the load moves or tilts \"{name}\", which its bearings do not constrain; add a bearing at another position, or give its bearings a stiffness in both directions"
        )
    } else {
        format!(
            "\"{name}\" is unconstrained: no bearing holds it laterally against the load; add gb.Bearing(\"{name}\", position, stiffness=...)"
        )
    };
    SceneError::new(format!("shafts[{shaft}]"), format!("no static equilibrium: {cause}"))
}

/// The error for a load that moves a shaft along its axis.
fn loose(model: &Model, shaft: usize) -> SceneError {
    let name = &model.scene.shafts[shaft].name;
    let message = format!(
        "no static equilibrium: \"{name}\" is unconstrained along its axis: no bearing carries the axial force of helical gears or loads; give one of its bearings axial_stiffness, as in gb.Bearing(\"{name}\", position, stiffness=..., axial_stiffness=...)"
    );
    SceneError::new(format!("shafts[{shaft}]"), message)
}

/// The error for torques that do not balance.
fn unbalanced(model: &Model, speed: f64) -> SceneError {
    let scene = &model.scene;
    let net: f64 = scene.torques.iter().map(|torque| torque.value * scene.speed_ratios[torque.node.shaft]).sum();
    let net = model.loads.iter().fold(net, |net, load| net + load.constant(speed) * load.ratio);
    let signs = if scene.torques.len() > 1 && !scene.meshes.is_empty() {
        "; the torques of driver and load of one gear pair have the same sign, because their shafts turn in opposite directions"
    } else {
        ""
    };
    SceneError::new(
        "torques",
        format!(
            "no static equilibrium: the rigid-body rotation is unconstrained, because the torques do not balance: their sum, referred to the reference shaft, is {} N m; add gb.Torque.balance(at) where the load acts, or hold the rotation with gb.Drive(at, stiffness=...){signs}",
            short(net)
        ),
    )
}

/// Refuses a load of which the springs of the null motions carry the part `carried`. This occurs with bearings whose
/// stiffness is singular and not symmetric: its left and right null vectors differ.
fn check_constraints(carried: &DVector<f64>, load: &DVector<f64>) -> Result<(), EquilibriumError> {
    if carried.norm() <= UNSUPPORTED_TOLERANCE * load.norm() {
        return Ok(());
    }
    let message = "no static equilibrium: the stiffness of a bearing is singular and not symmetric, so that it leaves a motion unconstrained on which its own force acts";
    Err(SceneError::new("bearings", message).into())
}

/// Sum of the generalised forces of all connections, on the left side of the equation of motion, and its derivative with
/// respect to q.
fn connection_forces(
    model: &Model,
    geometry: Geometry,
    speeds: EquilibriumSpeeds,
    flanks: &[Flank],
    q: &DVector<f64>,
) -> Result<(DVector<f64>, Vec<Entry>), EquilibriumError> {
    let mut force = DVector::zeros(model.len());
    let mut tangent = Vec::new();
    for connection in model.connections(speeds.flanks) {
        match connection {
            Connection::Mesh(index, mesh, sigma) => {
                let contacts = [(flanks[index].drives(), false), (flanks[index].holds_back(), true)];
                for (_, back) in contacts.into_iter().filter(|(in_contact, _)| *in_contact) {
                    let (pressed, directions) = mesh
                        .mean_tangent(geometry, sigma, back, q.as_slice(), |row, column, value| {
                            tangent.push((row, column, value))
                        })
                        .map_err(|overlap| EquilibriumError::Overlap(index, overlap))?;
                    let sigma = if back { -sigma } else { sigma };
                    mesh.gradient(sigma, &directions, |row, slope| force[row] += pressed * slope);
                }
            }
            Connection::Bearing(bearing) => {
                let known = bearing.static_tangent(speeds.flanks, q.as_slice());
                add_over_scalars(&bearing.rows, &known, &mut force, &mut tangent);
            }
            Connection::Nonlinear(bearing) => {
                let known = bearing.static_tangent(speeds.film, q.as_slice());
                add_over_scalars(&bearing.rows, &known, &mut force, &mut tangent);
            }
            Connection::Load(load) => {
                for (row, factor) in &load.rows[0] {
                    force[*row] -= factor * load.constant(speeds.flanks);
                }
            }
            Connection::Spring(spring) => {
                add_over_scalars(&spring.rows, &spring.static_tangent(q.as_slice()), &mut force, &mut tangent);
            }
        }
    }
    Ok((force, tangent))
}

/// Adds the force over the scalars of a connection, and its derivative with respect to the scalars, as generalised forces.
fn add_over_scalars(
    rows: &[Row],
    (known, derivative): &(DVector<f64>, DMatrix<f64>),
    force: &mut DVector<f64>,
    tangent: &mut Vec<Entry>,
) {
    for (i, left) in rows.iter().enumerate() {
        for (row, factor) in left {
            force[*row] += factor * known[i];
            for (j, right) in rows.iter().enumerate() {
                let stiffness = factor * derivative[(i, j)];
                tangent.extend(right.iter().map(|(column, factor)| (*row, *column, stiffness * factor)));
            }
        }
    }
}

/// The flanks of every mesh that are pressed at `q`, after an iteration with contact on `flanks`. A flank with backlash
/// does not pull. Both flanks are pressed if the centre distance is smaller than the backlash allows. Flanks are never
/// apart, because a mesh in equilibrium carries its torque: where neither is pressed, the opposite flank comes next.
fn pressed_flanks(
    model: &Model,
    geometry: Geometry,
    speed: f64,
    flanks: &[Flank],
    q: &DVector<f64>,
) -> Result<Vec<Flank>, EquilibriumError> {
    let pressed = |(index, flank): (usize, &Flank)| {
        let mesh = &model.meshes[index];
        if mesh.backlash.is_none() {
            return Ok(*flank);
        }
        let force = |back| {
            mesh.mean_tangent(geometry, model.sigma(index, speed), back, q.as_slice(), |_, _, _| {})
                .map(|(force, _)| force)
                .map_err(|overlap| EquilibriumError::Overlap(index, overlap))
        };
        // The force of an unloaded mesh is round-off.
        let scale = mesh.stiffness * mesh.involute.base_radius[0] * f64::EPSILON;
        let presses = |force: f64, in_contact: bool| force > if in_contact { -scale } else { scale };
        let (drive, back) = (force(false)?, force(true)?);
        Ok(match Flank::of(presses(drive, flank.drives()), presses(back, flank.holds_back())) {
            Flank::Separated => Flank::of(!flank.drives(), flank.drives()),
            pressed => pressed,
        })
    };
    flanks.iter().enumerate().map(pressed).collect()
}

/// Fraction of a Newton step that keeps the base circles apart and journals off their bearings.
fn admissible(
    model: &Model,
    geometry: Geometry,
    speed: f64,
    q: &DVector<f64>,
    step: &DVector<f64>,
) -> Result<f64, EquilibriumError> {
    let mut fraction = within_clearances(model, q, step);
    for (index, mesh) in model.meshes.iter().enumerate() {
        let sigma = model.sigma(index, speed);
        while let Err(overlap) =
            mesh.mean_tangent(geometry, sigma, false, (q + step * fraction).as_slice(), |_, _, _| {})
        {
            fraction /= 2.0;
            if fraction < 1e-3 {
                return Err(EquilibriumError::Overlap(index, overlap));
            }
        }
    }
    Ok(fraction)
}
