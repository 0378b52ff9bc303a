//! Coefficients of a bearing over the speed of its shaft, the frequency of a vibration or both: monotone cubic interpolation
//! between given values.
//!
//! Each entry of the 2×2 coefficient is interpolated on its own, over the frequency first. Between two knots an entry is
//! monotone, so no stiffness lies outside the values of its neighbours.

use super::description::{self, Coefficient, Outside, TableValue};
use super::rigid::limited;
use super::{EntryPath, SceneError};
use crate::numerics::{PiecewiseCubic, Place, ROUND_OFF, monotone_slopes};

/// A 2×2 coefficient over (y, z): stiffness [N/m] or damping [N s/m].
pub type Matrix2 = [[f64; 2]; 2];

/// A coefficient of a bearing.
#[derive(Clone, Debug, PartialEq)]
pub enum BearingCoefficient {
    /// The same at every speed and frequency.
    Constant(Matrix2),
    /// A function of the magnitude of the speed of the shaft.
    Table(SpeedTable),
    /// A function of the magnitude of the frequency of the vibration, and perhaps of the speed.
    OverFrequency(FrequencyTable),
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

/// Coefficients over the magnitude of a frequency, and perhaps of a speed.
#[derive(Clone, Debug, PartialEq)]
pub struct FrequencyTable {
    /// Coefficient at each speed and frequency.
    values: Vec<Matrix2>,
    /// Speeds, rad/s; none if the speed has no effect.
    speeds: Vec<f64>,
    /// The coefficient over the frequency, rad/s, at each speed; one if the speed has no effect.
    curves: Vec<PiecewiseCubic<nalgebra::Matrix2<f64>>>,
    /// Whether the first and the last value hold outside the speeds and frequencies.
    holds: bool,
}

impl BearingCoefficient {
    /// The coefficient of a plain description, in which messages call it `table`.
    ///
    /// # Errors
    /// [`SceneError`] for an invalid value.
    pub fn of_description(given: &description::BearingCoefficient) -> Result<Self, SceneError> {
        Self::new(Some(given), &EntryPath::root("table"))
    }

    /// The plain description of a coefficient that does not depend on the frequency.
    pub fn description(&self) -> description::BearingCoefficient {
        match self {
            Self::Table(table) => description::BearingCoefficient::Table(description::SpeedTable {
                speeds: Some(table.curve.x.clone()),
                frequencies: None,
                values: table.values.iter().map(|value| TableValue::One(Coefficient::Full(*value))).collect(),
                outside: if table.holds { Outside::Hold } else { Outside::Error },
            }),
            other => Coefficient::Full(other.at(0.0)).into(),
        }
    }

    /// Checks the coefficient `given` at the entry `at`; one that is not given is zero.
    ///
    /// # Errors
    /// [`SceneError`] for a number that is not finite or a negative diagonal, which would push the shaft away from its
    /// centre; for speeds or frequencies that do not ascend from zero or above, and for values that do not fit them.
    pub(super) fn new(given: Option<&description::BearingCoefficient>, at: &EntryPath) -> Result<Self, SceneError> {
        match given {
            None => Ok(Self::Constant([[0.0; 2]; 2])),
            Some(description::BearingCoefficient::Constant(constant)) => checked(*constant, at).map(Self::Constant),
            Some(description::BearingCoefficient::Table(table)) => Self::of_table(table, at),
        }
    }

    fn of_table(given: &description::SpeedTable, at: &EntryPath) -> Result<Self, SceneError> {
        let holds = given.outside == Outside::Hold;
        let axis = |given: &Option<Vec<f64>>, name: &'static str, one: &'static str| match given {
            Some(values) => ascending(values, &at.field(name), one).map(Some),
            None => Ok(None),
        };
        let (speeds, frequencies) =
            (axis(&given.speeds, "speeds", "speed")?, axis(&given.frequencies, "frequencies", "frequency")?);
        let place = at.field("values");
        let single = |count: usize, axis: &str| {
            let values: Vec<_> = given
                .values
                .iter()
                .enumerate()
                .map(|(index, value)| match value {
                    TableValue::One(value) => Ok(*value),
                    TableValue::OverFrequencies(_) => Err(place
                        .index(index)
                        .error("expected a number, a pair [yy, zz] or rows [[yy, yz], [zy, zz]]; a list of these needs speeds and frequencies")),
                })
                .collect::<Result<_, _>>()?;
            matrices(&values, count, axis, &place)
        };
        match (speeds, frequencies) {
            (None, None) => Err(at.error("a table needs speeds, frequencies or both")),
            (Some(speeds), None) => {
                let values = single(speeds.len(), "speeds")?;
                Ok(Self::Table(SpeedTable::new(speeds, values, holds)))
            }
            (None, Some(frequencies)) => {
                let values = single(frequencies.len(), "frequencies")?;
                let curves = vec![curve(frequencies, &values)];
                Ok(Self::OverFrequency(FrequencyTable { values, speeds: Vec::new(), curves, holds }))
            }
            (Some(speeds), Some(frequencies)) => {
                if given.values.len() != speeds.len() {
                    return Err(place.error(count_message(speeds.len(), "speeds", given.values.len())));
                }
                let row = |(index, value): (usize, &TableValue)| {
                    matrices(&value.over_frequencies(), frequencies.len(), "frequencies", &place.index(index))
                };
                let rows = given.values.iter().enumerate().map(row).collect::<Result<Vec<_>, _>>()?;
                let curves = rows.iter().map(|row| curve(frequencies.clone(), row)).collect();
                Ok(Self::OverFrequency(FrequencyTable { values: rows.concat(), speeds, curves, holds }))
            }
        }
    }

    /// The coefficient where it depends neither on speed nor on frequency.
    pub fn constant(&self) -> Option<Matrix2> {
        match self {
            Self::Constant(constant) => Some(*constant),
            Self::Table(_) | Self::OverFrequency(_) => None,
        }
    }

    /// The coefficient at a speed of the shaft, rad/s of either sign; outside a table its first or last value. A table over the
    /// frequency has its value at the first frequency: analyses take it [at a frequency](Self::at_frequency) before.
    #[inline]
    pub fn at(&self, speed: f64) -> Matrix2 {
        match self {
            Self::Constant(constant) => *constant,
            Self::Table(table) => table.at(speed.abs())[0],
            Self::OverFrequency(table) => table.at_frequency(0.0).at(speed),
        }
    }

    /// The derivative of the coefficient over the magnitude of the speed of the shaft.
    pub fn slope(&self, speed: f64) -> Matrix2 {
        match self {
            Self::Constant(_) => [[0.0; 2]; 2],
            Self::Table(table) => table.at(speed.abs())[1],
            Self::OverFrequency(table) => table.at_frequency(0.0).slope(speed),
        }
    }

    /// The coefficient over the speed at a frequency of the vibration, rad/s of either sign; outside a table that of its first or
    /// last frequency.
    #[must_use]
    pub fn at_frequency(&self, frequency: f64) -> Self {
        match self {
            Self::OverFrequency(table) => table.at_frequency(frequency.abs()),
            Self::Constant(_) | Self::Table(_) => self.clone(),
        }
    }

    /// The range of speeds [rad/s] outside which the coefficient is not defined, if `speed` lies outside it.
    pub fn excludes(&self, speed: f64) -> Option<[f64; 2]> {
        match self {
            Self::Table(table) if !table.holds => excluding(table.curve.range(), speed.abs()),
            _ => None,
        }
    }

    /// The range of frequencies [rad/s] outside which the coefficient is not defined, if `frequency` lies outside it.
    pub fn excludes_frequency(&self, frequency: f64) -> Option<[f64; 2]> {
        match self {
            Self::OverFrequency(table) if !table.holds => excluding(table.curves[0].range(), frequency.abs()),
            _ => None,
        }
    }

    /// The speeds of the table, rad/s; none where the coefficient does not depend on the speed.
    pub fn speeds(&self) -> &[f64] {
        match self {
            Self::Constant(_) => &[],
            Self::Table(table) => &table.curve.x,
            Self::OverFrequency(table) => &table.speeds,
        }
    }

    /// The frequencies of the table, rad/s; none where the coefficient does not depend on the frequency.
    pub fn frequencies(&self) -> &[f64] {
        match self {
            Self::Constant(_) | Self::Table(_) => &[],
            Self::OverFrequency(table) => &table.curves[0].x,
        }
    }

    /// The coefficients between which all others lie, entry by entry: one, or those at the knots.
    pub fn extremes(&self) -> &[Matrix2] {
        match self {
            Self::Constant(constant) => std::slice::from_ref(constant),
            Self::Table(SpeedTable { values, .. }) | Self::OverFrequency(FrequencyTable { values, .. }) => values,
        }
    }

    /// Limits the diagonal of every value, see [`limited`].
    pub(super) fn limit(&mut self, largest: f64) {
        let exceeds = |value: &Matrix2| value[0][0] > largest || value[1][1] > largest;
        if !self.extremes().iter().any(exceeds) {
            return;
        }
        let within = |values: &[Matrix2]| values.iter().map(|value| limited(*value, largest)).collect::<Vec<_>>();
        match self {
            Self::Constant(value) => *value = limited(*value, largest),
            Self::Table(table) => *table = SpeedTable::new(table.curve.x.clone(), within(&table.values), table.holds),
            Self::OverFrequency(table) => {
                table.values = within(&table.values);
                let rows = table.values.chunks_exact(table.curves[0].x.len());
                table.curves = table.curves.iter().zip(rows).map(|(old, row)| curve(old.x.clone(), row)).collect();
            }
        }
    }

    /// Whether the first and the last value hold outside the speeds and frequencies of the table; a constant always holds.
    pub fn holds(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Table(SpeedTable { holds, .. }) | Self::OverFrequency(FrequencyTable { holds, .. }) => *holds,
        }
    }
}

impl FrequencyTable {
    /// The coefficient over the speed at a frequency, rad/s, that is not negative.
    fn at_frequency(&self, frequency: f64) -> BearingCoefficient {
        let values: Vec<Matrix2> = self.curves.iter().map(|curve| value_and_slope(curve, frequency)[0]).collect();
        match self.speeds.is_empty() {
            true => BearingCoefficient::Constant(values[0]),
            false => BearingCoefficient::Table(SpeedTable::new(self.speeds.clone(), values, self.holds)),
        }
    }
}

impl SpeedTable {
    fn new(speeds: Vec<f64>, values: Vec<Matrix2>, holds: bool) -> Self {
        Self { curve: curve(speeds, &values), values, holds }
    }

    /// The coefficient and its derivative at a speed that is not negative. At a knot the coefficient is the given value.
    fn at(&self, speed: f64) -> [Matrix2; 2] {
        value_and_slope(&self.curve, speed)
    }
}

/// Value and derivative of a curve; outside its knots the first or the last value. At a knot the value is the given one.
fn value_and_slope(curve: &PiecewiseCubic<nalgebra::Matrix2<f64>>, x: f64) -> [Matrix2; 2] {
    let [value, slope] = match curve.at(x) {
        Place::Within { cubic, fraction, width } => [cubic.value(fraction), cubic.slope(fraction) / width],
        Place::Behind(end) if x == curve.range()[1] => [end.value, end.slope],
        Place::Before(end) | Place::Behind(end) => [end.value, nalgebra::Matrix2::zeros()],
    };
    [value.into(), slope.into()]
}

/// A range, if a value that is not negative lies outside it.
pub fn excluding([first, last]: [f64; 2], value: f64) -> Option<[f64; 2]> {
    // A speed ratio has round-off.
    let slack = ROUND_OFF * last;
    let inside = value >= first - slack && value <= last + slack;
    (!inside).then_some([first, last])
}

/// The axis of a table at the entry `place`: at least two values, ascending from zero or above. `one` is the name of a value.
fn ascending(values: &[f64], place: &EntryPath<'_>, one: &str) -> Result<Vec<f64>, SceneError> {
    if values.len() < 2 {
        let plural = if one == "speed" { "speeds" } else { "frequencies" };
        return Err(place.error(format!("needs at least 2 {plural}, got {}", values.len())));
    }
    for (index, value) in values.iter().enumerate() {
        place.index(index).non_negative(*value)?;
        if index > 0 && *value <= values[index - 1] {
            let message = format!("must be above the {one} before it, {}, got {value}", values[index - 1]);
            return Err(place.index(index).error(message));
        }
    }
    Ok(values.to_vec())
}

fn count_message(count: usize, axis: &str, found: usize) -> String {
    format!("needs one value for each of the {count} {axis}, got {found}")
}

/// The coefficients along an axis with `count` knots, all of the same form.
fn matrices(
    given: &[Coefficient],
    count: usize,
    axis: &str,
    place: &EntryPath<'_>,
) -> Result<Vec<Matrix2>, SceneError> {
    if given.len() != count {
        return Err(place.error(count_message(count, axis, given.len())));
    }
    let form = std::mem::discriminant(&given[0]);
    if let Some(other) = given.iter().position(|value| std::mem::discriminant(value) != form) {
        return Err(place.index(other).error("must have the same form as the value before it"));
    }
    given.iter().enumerate().map(|(index, value)| checked(*value, &place.index(index))).collect()
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
        let values = values.iter().map(|value| [[*value, 0.0], [0.0, *value]]).collect();
        SpeedTable::new(speeds.to_vec(), values, false)
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
        let excludes = |table: &SpeedTable, speed| BearingCoefficient::Table(table.clone()).excludes(speed);
        assert_eq!(excludes(&table, 2.1), Some([1.0, 2.0]));
        assert_eq!(excludes(&table, 2.0 + 1e-13), None);
        table.holds = true;
        assert_eq!(excludes(&table, 2.1), None);
        assert_eq!(table.at(2.1)[0], [[2.0, 0.0], [0.0, 2.0]]);
    }

    fn over_frequency(values: Vec<TableValue>) -> Result<BearingCoefficient, SceneError> {
        let (speeds, frequencies) = (Some(vec![0.0, 10.0]), Some(vec![1.0, 3.0]));
        let table = description::SpeedTable { speeds, frequencies, values, outside: Outside::Error };
        BearingCoefficient::new(Some(&description::BearingCoefficient::Table(table)), &EntryPath::root("table"))
    }

    #[test]
    fn values_over_two_frequencies_have_the_form_of_one_speed() {
        use Coefficient::{Full, Isotropic, Orthotropic};
        let pair = |k: [f64; 2]| TableValue::One(Orthotropic(k));
        let numbers = over_frequency(vec![pair([1.0, 2.0]), pair([3.0, 4.0])]).unwrap();
        let expected = [[[1.0, 0.0], [0.0, 1.0]], [[4.0, 0.0], [0.0, 4.0]]];
        assert_eq!([numbers.at_frequency(1.0).at(0.0), numbers.at_frequency(-3.0).at(-10.0)], expected);
        let pairs = |k: [f64; 2]| TableValue::One(Full(k.map(|k| [k, k])));
        assert_eq!(over_frequency(vec![pairs([1.0, 2.0]), pairs([3.0, 4.0])]).unwrap(), numbers);
        let rows = |k: [f64; 2]| TableValue::OverFrequencies(k.map(|k| Full([[k, 0.0], [0.0, k]])).to_vec());
        assert_eq!(over_frequency(vec![rows([1.0, 2.0]), rows([3.0, 4.0])]).unwrap(), numbers);
        let three = |k: f64| TableValue::OverFrequencies(vec![Isotropic(k); 3]);
        assert!(over_frequency(vec![three(1.0), three(2.0)]).is_err());
        assert!(over_frequency(vec![TableValue::One(Isotropic(1.0)); 2]).is_err());
        assert_eq!(numbers.excludes_frequency(3.1), Some([1.0, 3.0]));
        assert_eq!(numbers.excludes_frequency(-2.0), None);
    }
}
