//! Loads that have no equilibrium, with the shaft, housing or bearing that is the reason.

use nalgebra::{DMatrix, DVector};

use super::{EquilibriumError, MAX_RESIDUAL};
use crate::model::{Dof, DofKind, Model};
use crate::numerics::{EQUALITY_TOLERANCE, ROUND_OFF};
use crate::scene::{EntryPath, SceneError, short};

/// Refuses a load that drives a null motion. The error says whether a bearing or a torque is missing.
pub(super) fn check_balance(
    model: &Model,
    null: &DMatrix<f64>,
    load: &DVector<f64>,
    speed: f64,
) -> Result<(), EquilibriumError> {
    // The null motions may combine rotation and lateral motion in any way. The acceleration under the load does not
    // depend on the combination.
    let mut acceleration = DVector::zeros(model.len());
    for column in null.column_iter() {
        let drive: f64 = column.dot(load);
        let acting: f64 = column.iter().zip(load.iter()).map(|(motion, load)| (motion * load).abs()).sum();
        // Round-off of a null motion that does not move the points where loads act.
        let round_off = ROUND_OFF * column.amax() * load.lp_norm(1);
        if drive.abs() > (EQUALITY_TOLERANCE * acting).max(round_off) {
            acceleration.axpy(drive, &column, 1.0);
        }
    }
    let largest = acceleration.amax();
    if largest == 0.0 {
        return Ok(());
    }
    for (index, housing) in model.housing_nodes().zip(&model.scene.housings) {
        let moves = |dof: &&Dof| dof.node == index && acceleration[dof.index].abs() > MAX_RESIDUAL * largest;
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
        (motion > MAX_RESIDUAL * largest).then_some(shaft)
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
        DofKind::Mode => "stiffness at its feet, gb.Interface(..., stiffness=(x, y, z))",
    };
    SceneError::new("housings", format!("no static equilibrium: the load moves \"{name}\"; give it a {entry}"))
}

/// The error for a load that moves a shaft laterally: its bearings do not constrain it.
fn unsupported(model: &Model, shaft: usize) -> SceneError {
    let name = &model.scene.shafts[shaft].name;
    let has_bearing = model.scene.held_nodes(shaft).next().is_some();
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
pub(super) fn check_constraints(carried: &DVector<f64>, load: &DVector<f64>) -> Result<(), EquilibriumError> {
    if carried.norm() <= MAX_RESIDUAL * load.norm() {
        return Ok(());
    }
    let message = "no static equilibrium: the stiffness of a bearing is singular and not symmetric, so that it leaves a motion unconstrained on which its own force acts";
    Err(SceneError::new("bearings", message).into())
}

/// The error of a search that failed: at a bearing whose pads are made for the other direction of rotation, this is the reason.
pub(super) fn check_rotation(model: &Model, speed: f64, error: EquilibriumError) -> EquilibriumError {
    if matches!(error, EquilibriumError::Overlap { .. }) {
        return error;
    }
    match model.nonlinear_bearings.iter().find(|bearing| bearing.opposes(speed)) {
        Some(bearing) => EntryPath::entry("bearings", bearing.number)
            .error(format!(
                "no static equilibrium at {} rad/s: its film narrows in the other direction of rotation; change the sign of the speed, or give its lobes 1 - offset",
                short(speed)
            ))
            .into(),
        None => error,
    }
}

/// The error for forces that do not balance, on the shaft or housing with the largest residual.
pub(super) fn unconverged(model: &Model, residuals: &[f64]) -> EquilibriumError {
    let worse = |most: (usize, f64), (body, value): (usize, &f64)| {
        if *value > most.1 || value.is_nan() { (body, *value) } else { most }
    };
    let (body, residual) = residuals.iter().enumerate().fold((0, -1.0), worse);
    let (list, index) =
        if body < model.shafts.len() { ("shafts", body) } else { ("housings", body - model.shafts.len()) };
    EquilibriumError::Convergence(format!(
        "{list}[{index}]: no static equilibrium found: {} of the load is unbalanced, more than {}; change the load or the speed in small steps to find where the equilibrium ends",
        short(residual),
        short(MAX_RESIDUAL)
    ))
}
