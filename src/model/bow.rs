//! Residual bow of a shaft: its stress-free shape b(x) at the nodes, in coordinates that rotate with the shaft.
//!
//! u = b(x) and φ = b'(x), complex with the real part in the y direction and the imaginary part in the z direction at
//! shaft angle zero. The force of the bow is K_s b.

use num_complex::Complex64;

use crate::linalg::BlockTridiagonal;
use crate::scene::{Bow, Scene, SceneError};

/// Stiffness of a rigid bearing relative to the largest diagonal entry of the shaft stiffness.
const RIGID_STIFFNESS: f64 = 1e8;

/// u, m, and φ, rad, at the nodes of shaft `index`, two entries per node; `None` for a straight shaft.
///
/// `mass` is the mass matrix of bending, including the bodies on the shaft.
pub(super) fn shape(
    scene: &Scene,
    index: usize,
    mass: &BlockTridiagonal<2>,
    stiffness: &BlockTridiagonal<2>,
) -> Result<Option<Vec<Complex64>>, SceneError> {
    let shaft = &scene.shafts[index];
    let at_nodes = |curve: &dyn Fn(f64) -> (Complex64, Complex64)| {
        let pair = |x: &f64| {
            let (value, slope) = curve(*x);
            [value, slope]
        };
        shaft.nodes.iter().flat_map(pair).collect()
    };
    Ok(match &shaft.bow {
        None => None,
        Some(Bow::Waves { amplitude, wave_number }) => Some(at_nodes(&|x| {
            let (sin, cos) = (wave_number * x).sin_cos();
            (*amplitude * sin, *amplitude * (wave_number * cos))
        })),
        Some(Bow::Points(spline)) => Some(at_nodes(&|x| spline.at(x))),
        Some(Bow::Sag { amplitude }) => {
            let sag = unit_sag(scene, index, mass, stiffness)?;
            Some(sag.iter().map(|value| *amplitude * *value).collect())
        }
    })
}

/// (u, φ) of the sag under the weight of the shaft and its bodies on rigid bearings, scaled to a largest deflection of
/// 1.
///
/// Bearings are rigid because run-out is measured relative to the line through the bearings. The rigid-body part of a
/// bow exerts no force.
fn unit_sag(
    scene: &Scene,
    index: usize,
    mass: &BlockTridiagonal<2>,
    stiffness: &BlockTridiagonal<2>,
) -> Result<Vec<f64>, SceneError> {
    let shaft = &scene.shafts[index];
    let undefined = |message: &str| SceneError::new(format!("shafts[{index}].bow"), message);
    let mut bearings: Vec<usize> =
        scene.bearings.iter().filter(|bearing| bearing.node.shaft == index).map(|bearing| bearing.node.node).collect();
    bearings.sort_unstable();
    bearings.dedup();
    if bearings.len() < 2 {
        return Err(undefined(
            "a sag needs bearings at two positions of the shaft; add a bearing or choose another shape",
        ));
    }
    let mut largest: f64 = 0.0;
    stiffness.for_each(|row, column, value| {
        if row == column && row % 2 == 0 {
            largest = largest.max(value);
        }
    });
    let mut supported = stiffness.clone();
    for node in &bearings {
        supported.add_at_node(*node, 0, 0, RIGID_STIFFNESS * largest);
    }
    let factor =
        supported.factor().map_err(|_| undefined("the sag is lost to round-off; give the bow by points instead"))?;
    let translation: Vec<f64> = (0..shaft.nodes.len()).flat_map(|_| [1.0, 0.0]).collect();
    let mut sag = vec![0.0; translation.len()];
    mass.multiply_add::<1>(1.0, &translation, &mut sag);
    factor.solve::<1>(&mut sag);
    let largest = sag.iter().step_by(2).fold(0.0_f64, |largest, value| largest.max(value.abs()));
    Ok(sag.iter().map(|value| value / largest).collect())
}
