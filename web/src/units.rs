//! Texts with a unit in a scene, such as "90 mm". The table of units is that of the Python package, as JSON.

use std::collections::HashMap;
use std::f64::consts::PI;

use serde::Deserialize;

/// Unit of a field without a unit.
const DIMENSIONLESS: &str = "1";

/// Exponents of m, kg and s.
type Dimension = [i32; 3];

/// The SI unit of a field, of each entry of a list, or none for a text.
#[derive(Deserialize)]
#[serde(untagged)]
enum FieldUnit {
    Text(()),
    One(String),
    Entries(Vec<Option<String>>),
}

/// A unit: the SI unit times 10^`ten` · `factor` · π^`pi`.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
struct Unit {
    ten: i32,
    factor: f64,
    pi: i32,
    dimension: Dimension,
}

/// The table of units: see `gearbow.units.fields` and `gearbow.units.parse`.
#[derive(Deserialize)]
pub struct Units {
    fields: HashMap<String, FieldUnit>,
    prefixes: HashMap<String, i32>,
    with_prefix: HashMap<String, Unit>,
    others: HashMap<String, Unit>,
    /// Units of a frequency, which are ambiguous for a speed.
    frequencies: HashMap<String, Unit>,
    signs: HashMap<char, String>,
}

impl Units {
    /// Converts the texts with a unit in a scene to SI units.
    pub fn without_texts(&self, value: toml::Value, path: &mut Vec<String>) -> Result<toml::Value, String> {
        self.converted(value, path, None)
    }

    /// The same for entry `index` of a list, or for a value that is in no list.
    fn converted(
        &self,
        value: toml::Value,
        path: &mut Vec<String>,
        index: Option<usize>,
    ) -> Result<toml::Value, String> {
        Ok(match value {
            toml::Value::Table(table) => {
                let mut converted = toml::Table::new();
                for (key, value) in table {
                    path.push(key.clone());
                    converted.insert(key, self.converted(value, path, None)?);
                    path.pop();
                }
                toml::Value::Table(converted)
            }
            toml::Value::Array(entries) => {
                let entries = entries.into_iter().enumerate();
                let one = |(index, value)| self.converted(value, path, Some(index));
                toml::Value::Array(entries.map(one).collect::<Result<_, _>>()?)
            }
            toml::Value::String(text) => match self.unit_of(path, index) {
                Some(unit) if unit != DIMENSIONLESS => toml::Value::Float(self.parsed(&text, unit, path)?),
                _ => toml::Value::String(text),
            },
            other => other,
        })
    }

    /// The SI unit of a field: that of the longest end of the path which the table has. None for a text.
    fn unit_of(&self, path: &[String], index: Option<usize>) -> Option<&str> {
        let ends = (0..path.len()).flat_map(|from| {
            let any = path[from..path.len() - 1].iter().map(String::as_str).chain(["*"]).collect::<Vec<_>>();
            [path[from..].join("."), any.join(".")]
        });
        match ends.filter_map(|end| self.fields.get(&end)).next() {
            None => Some(DIMENSIONLESS),
            Some(FieldUnit::Text(())) => None,
            Some(FieldUnit::One(unit)) => Some(unit),
            Some(FieldUnit::Entries(units)) => units.get(index?)?.as_deref(),
        }
    }

    /// Converts a text to the SI unit `wanted`.
    fn parsed(&self, text: &str, wanted: &str, path: &[String]) -> Result<f64, String> {
        let fail = |what: String| Err(format!("{}: {what}, got \"{text}\"", path.join(".")));
        let text = text.trim();
        let is_number = |end: &usize| text.is_char_boundary(*end) && text[..*end].parse::<f64>().is_ok();
        let Some(end) = (1..=text.len()).rev().find(is_number) else {
            return fail(format!("must be a number or a text with a number and a unit, such as \"2.5 {wanted}\""));
        };
        let (number, unit) = text.split_at(end);
        if unit.trim().is_empty() {
            return fail(format!("the text has no unit; write the number without quotes [{wanted}]"));
        }
        let is_frequency = path.last().is_some_and(|name| name == "frequency" || name == "frequencies");
        let (Some(found), Some(expected)) = (self.product(unit, is_frequency), self.product(wanted, false)) else {
            return fail("the unit is not known".to_owned());
        };
        if found.dimension != expected.dimension {
            return fail(format!("must have a unit that converts to {wanted}"));
        }
        // A power of ten belongs to the decimal number, so that "90 mm" is 0.09 without round-off.
        let decimal = if number.contains(['e', 'E']) {
            number.parse::<f64>().map(|number| number * 10_f64.powi(found.ten))
        } else {
            format!("{number}e{}", found.ten).parse()
        };
        decimal.map(|value| value * found.factor * PI.powi(found.pi)).or_else(|error| fail(error.to_string()))
    }

    /// Reads a product of units, such as "kg mm^2", "N/um" or "N-s/m".
    fn product(&self, text: &str, is_frequency: bool) -> Option<Unit> {
        let mut text = with_hyphens_as_products(text).replace("**", "^");
        for (sign, replacement) in &self.signs {
            text = text.replace(*sign, replacement);
        }
        let text = text.replace('/', " /");
        let mut found = Unit { ten: 0, factor: 1.0, pi: 0, dimension: [0; 3] };
        let mut divides = false;
        for word in text.split_whitespace() {
            let bare = word.trim_start_matches('/');
            divides |= bare.len() < word.len();
            if bare.is_empty() {
                continue;
            }
            let (name, power) = bare.split_once('^').unwrap_or((bare, "1"));
            let power: i32 = power.trim_matches(['(', ')']).parse().ok()?;
            let power = if divides { -power } else { power };
            divides = false;
            let one = self.single(name, is_frequency)?;
            found.ten += power * one.ten;
            found.factor *= one.factor.powi(power);
            found.pi += power * one.pi;
            for (sum, exponent) in found.dimension.iter_mut().zip(one.dimension) {
                *sum += power * exponent;
            }
        }
        Some(found)
    }

    /// Finds one unit, with or without a prefix.
    fn single(&self, name: &str, is_frequency: bool) -> Option<Unit> {
        if let Some(unit) = self.frequencies.get(name).filter(|_| is_frequency) {
            return Some(*unit);
        }
        let with_prefix = || {
            self.with_prefix.iter().find_map(|(unit, one)| {
                let prefix = self.prefixes.get(name.strip_suffix(unit.as_str())?)?;
                Some(Unit { ten: one.ten + prefix, ..*one })
            })
        };
        self.others.get(name).copied().or_else(with_prefix)
    }
}

/// Writes a space for each hyphen between two letters, which stands for a product of units.
fn with_hyphens_as_products(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let is_letter = |at: usize| letters.get(at).is_some_and(char::is_ascii_alphabetic);
    let sign = |(at, letter): (usize, &char)| match letter {
        '-' if at > 0 && is_letter(at - 1) && is_letter(at + 1) => ' ',
        other => *other,
    };
    letters.iter().enumerate().map(sign).collect()
}

#[cfg(test)]
mod tests {
    use super::{Units, with_hyphens_as_products};

    fn unit(factor: f64, pi: i32, dimension: [i32; 3]) -> serde_json::Value {
        serde_json::json!({"ten": 0, "factor": factor, "pi": pi, "dimension": dimension})
    }

    #[test]
    fn hyphens_and_frequencies_are_those_of_the_package() {
        let table = serde_json::json!({
            "fields": {"damping": "N s/m", "frequency": "rad/s", "speed": "rad/s"},
            "prefixes": {"": 0, "k": 3},
            "with_prefix": {
                "N": unit(1.0, 0, [1, 1, -2]), "m": unit(1.0, 0, [1, 0, 0]), "s": unit(1.0, 0, [0, 0, 1]),
                "rad": unit(1.0, 0, [0, 0, 0]),
            },
            "others": {},
            "frequencies": {"Hz": unit(2.0, 1, [0, 0, -1])},
            "signs": {},
        });
        let units: Units = serde_json::from_value(table).unwrap();
        let parsed = |text: &str, field: &str, wanted: &str| units.parsed(text, wanted, &[field.to_owned()]);
        assert_eq!(parsed("2 kN-s/m", "damping", "N s/m"), Ok(2000.0));
        assert_eq!(parsed("2 N s m^-1", "damping", "N s/m"), Ok(2.0));
        assert_eq!(parsed("3 Hz", "frequency", "rad/s"), Ok(6.0 * std::f64::consts::PI));
        assert!(parsed("3 Hz", "speed", "rad/s").is_err());
        assert_eq!(with_hyphens_as_products("lbf-s/in m^-1 -"), "lbf s/in m^-1 -");
    }
}
