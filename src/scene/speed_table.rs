//! Coefficients of a bearing over the speed of its shaft: monotone cubic interpolation between given speeds.
//!
//! Each entry of the 2×2 coefficient is interpolated on its own. Between two knots an entry is monotone, so no stiffness lies
//! outside the values of its neighbours.

use super::description::{self, Coefficient, Outside};
use super::{EntryPath, SceneError};
use crate::numerics::{PiecewiseCubic, Place, ROUND_OFF, monotone_slopes};

/// A 2×2 coefficient over (y, z): stiffness [N/m] or damping [N s/m].
pub type Matrix2 = [[f64; 2]; 2];

/// A coefficient of a bearing.
#[derive(Clone, Debug, PartialEq)]
pub enum BearingCoefficient {
    /// The same at every speed.
    Constant(Matrix2),
    /// A function of the magnitude of the speed of the shaft.
    Table(SpeedTable),
}

/// Coefficients over the magnitude of a speed.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedTable {
    /// Coefficient at each speed.
    values: Vec<Matrix2>,
    /// The coefficient over the speed, rad/s.
    curve: PiecewiseCubic<nalgebra::Matrix2<f64>>,
    /// Whether the first and the last value hold outside the speeds.
    holds: bool,
}

impl BearingCoefficient {
    /// Checks the coefficient `given` at the entry `at`; one that is not given is zero.
    ///
    /// # Errors
    /// [`SceneError`] for a number that is not finite or a negative diagonal, which would push the shaft away from its
    /// centre; for speeds that do not ascend from zero or above, and for values that do not fit them.
    pub(super) fn new(given: Option<&description::BearingCoefficient>, at: &EntryPath) -> Result<Self, SceneError> {
        match given {
            None => Ok(Self::Constant([[0.0; 2]; 2])),
            Some(description::BearingCoefficient::Constant(constant)) => checked(*constant, at).map(Self::Constant),
            Some(description::BearingCoefficient::Table(table)) => SpeedTable::new(table, at).map(Self::Table),
        }
    }

    /// The coefficient where it does not depend on the speed.
    pub fn constant(&self) -> Option<Matrix2> {
        match self {
            Self::Constant(constant) => Some(*constant),
            Self::Table(_) => None,
        }
    }

    /// The coefficient at a speed of the shaft, rad/s of either sign; outside a table its first or last value.
    #[inline]
    pub fn at(&self, speed: f64) -> Matrix2 {
        match self {
            Self::Constant(constant) => *constant,
            Self::Table(table) => table.at(speed.abs())[0],
        }
    }

    /// The derivative of the coefficient over the magnitude of the speed of the shaft.
    pub fn slope(&self, speed: f64) -> Matrix2 {
        match self {
            Self::Constant(_) => [[0.0; 2]; 2],
            Self::Table(table) => table.at(speed.abs())[1],
        }
    }

    /// The range of speeds [rad/s] outside which the coefficient is not defined, if `speed` lies outside it.
    pub fn excludes(&self, speed: f64) -> Option<[f64; 2]> {
        match self {
            Self::Constant(_) => None,
            Self::Table(table) => table.excludes(speed.abs()),
        }
    }

    /// The speeds of the table, rad/s; none where the coefficient is constant.
    pub fn speeds(&self) -> &[f64] {
        match self {
            Self::Constant(_) => &[],
            Self::Table(table) => &table.curve.x,
        }
    }

    /// The coefficients between which all others lie, entry by entry: one, or those at the knots.
    pub fn extremes(&self) -> &[Matrix2] {
        match self {
            Self::Constant(constant) => std::slice::from_ref(constant),
            Self::Table(table) => &table.values,
        }
    }

    /// Whether the first and the last value hold outside the speeds of the table; a constant always holds.
    pub fn holds(&self) -> bool {
        !matches!(self, Self::Table(SpeedTable { holds: false, .. }))
    }
}

impl SpeedTable {
    fn new(given: &description::SpeedTable, at: &EntryPath) -> Result<Self, SceneError> {
        let (speeds, place) = (given.speeds.clone(), at.field("speeds"));
        if speeds.len() < 2 {
            return Err(place.error(format!("needs at least 2 speeds, got {}", speeds.len())));
        }
        for (index, speed) in speeds.iter().enumerate() {
            place.index(index).non_negative(*speed)?;
            if index > 0 && *speed <= speeds[index - 1] {
                let message = format!("must be above the speed before it, {}, got {speed}", speeds[index - 1]);
                return Err(place.index(index).error(message));
            }
        }
        let place = at.field("values");
        if given.values.len() != speeds.len() {
            let message =
                format!("needs one value for each of the {} speeds, got {}", speeds.len(), given.values.len());
            return Err(place.error(message));
        }
        let form = std::mem::discriminant(&given.values[0]);
        if let Some(other) = given.values.iter().position(|value| std::mem::discriminant(value) != form) {
            return Err(place.index(other).error("must have the same form as the value before it"));
        }
        let value = |(index, value): (usize, &Coefficient)| checked(*value, &place.index(index));
        let values = given.values.iter().enumerate().map(value).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { curve: curve(speeds, &values), values, holds: given.outside == Outside::Hold })
    }

    /// The coefficient and its derivative at a speed that is not negative. At a knot the coefficient is the given value.
    fn at(&self, speed: f64) -> [Matrix2; 2] {
        let [value, slope] = match self.curve.at(speed) {
            Place::Within { cubic, fraction, width } => [cubic.value(fraction), cubic.slope(fraction) / width],
            Place::Behind(end) if speed == self.curve.range()[1] => [end.value, end.slope],
            Place::Before(end) | Place::Behind(end) => [end.value, nalgebra::Matrix2::zeros()],
        };
        [value.into(), slope.into()]
    }

    fn excludes(&self, speed: f64) -> Option<[f64; 2]> {
        let [first, last] = self.curve.range();
        // A speed ratio has round-off.
        let slack = ROUND_OFF * last;
        let inside = speed >= first - slack && speed <= last + slack;
        (!self.holds && !inside).then_some([first, last])
    }
}

/// A finite 2×2 coefficient without a negative diagonal.
pub(super) fn checked(given: Coefficient, at: &EntryPath) -> Result<Matrix2, SceneError> {
    let rows = given.rows();
    for (i, row) in rows.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let row = at.index(i);
            let place = match given {
                Coefficient::Full(_) => row.index(j),
                Coefficient::Orthotropic(_) => row,
                Coefficient::Isotropic(_) => *at,
            };
            if i == j {
                place.non_negative(*value)?
            } else {
                place.finite(*value)?
            };
        }
    }
    Ok(rows)
}

/// The monotone interpolation of each entry.
fn curve(speeds: Vec<f64>, values: &[Matrix2]) -> PiecewiseCubic<nalgebra::Matrix2<f64>> {
    let values: Vec<nalgebra::Matrix2<f64>> = values.iter().map(|value| (*value).into()).collect();
    let mut slopes = vec![nalgebra::Matrix2::zeros(); speeds.len()];
    for entry in 0..4 {
        let of_entry: Vec<f64> = values.iter().map(|value| value[entry]).collect();
        for (slopes, slope) in slopes.iter_mut().zip(monotone_slopes(&speeds, &of_entry)) {
            slopes[entry] = slope;
        }
    }
    PiecewiseCubic::new(speeds, values, slopes)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    fn table(speeds: &[f64], values: &[f64]) -> SpeedTable {
        let values = values.iter().map(|value| Coefficient::Isotropic(*value)).collect();
        let given = description::SpeedTable { speeds: speeds.to_vec(), values, outside: Outside::Error };
        SpeedTable::new(&given, &EntryPath::root("table")).unwrap()
    }

    #[test]
    fn values_at_knots_are_the_given_ones_to_the_last_bit() {
        let (speeds, values) = ([0.1, 0.7, 1.3, 9.9], [3.3e7, 1.7e7, 1.9e7, 8.1e8]);
        let table = table(&speeds, &values);
        for (speed, value) in speeds.into_iter().zip(values) {
            assert_eq!(table.at(speed)[0][0][0], value);
        }
    }

    #[test]
    fn interpolation_is_monotone_and_its_derivative_is_that_of_its_values() {
        let table = table(&[0.0, 1.0, 2.0, 5.0], &[1.0, 1.1, 9.0, 9.5]);
        let mut before = 0.0;
        for step in 1..500 {
            let speed = f64::from(step) / 100.0;
            let [value, slope] = table.at(speed).map(|found| found[1][1]);
            assert!(value >= before);
            before = value;
            let h = 1e-6;
            let difference = (table.at(speed + h)[0][1][1] - table.at(speed - h)[0][1][1]) / (2.0 * h);
            // Central differences of cubics, across a knot to first order in h.
            assert!((difference - slope).abs() < 1e-4, "{speed}: {difference} {slope}");
        }
    }

    #[test]
    fn a_table_refuses_speeds_outside_it_unless_it_holds() {
        let mut table = table(&[1.0, 2.0], &[1.0, 2.0]);
        assert_eq!(table.excludes(2.1), Some([1.0, 2.0]));
        assert_eq!(table.excludes(2.0 + 1e-13), None);
        table.holds = true;
        assert_eq!(table.excludes(2.1), None);
        assert_eq!(table.at(2.1)[0], [[2.0, 0.0], [0.0, 2.0]]);
    }
}
