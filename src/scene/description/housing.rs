//! Description of what bearings stand on: supports and housings.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::{Coefficient, FilmModel};
use crate::scene::given;

/// A mass on a spring and a damper between a bearing and the ground or a housing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Support {
    /// Name; unique in the system.
    pub name: Option<String>,
    /// The housing on which it stands; the ground without one.
    pub support: Option<Box<Base>>,
    /// Mass, kg.
    pub mass: f64,
    /// Stiffness to the ground or housing over (y, z), N/m.
    pub stiffness: Coefficient,
    /// Damping to the ground or housing over (y, z), N s/m.
    pub damping: Option<Coefficient>,
    /// Diameter of the ring in a squeeze film, m.
    pub diameter: Option<f64>,
    /// Length of a squeeze film, m.
    pub length: Option<f64>,
    /// Radial clearance of a squeeze film, m.
    pub clearance: Option<f64>,
    /// Dynamic viscosity of the oil of a squeeze film, Pa s.
    pub viscosity: Option<f64>,
    /// Model of a squeeze film; short by default.
    pub film: Option<FilmModel>,
    /// Whether a squeeze film ruptures (π film, the default) or not (2π film).
    pub ruptures: Option<bool>,
    /// Stiffness to the ground or housing along the axis, N/m; without it, the support does not move along the axis.
    pub axial_stiffness: Option<f64>,
    /// Damping to the ground or housing along the axis, N s/m.
    pub axial_damping: Option<f64>,
    /// Loss factor η of its stiffness, K(1 + iη sgn ω), which analyses in the frequency domain contain.
    pub loss_factor: Option<f64>,
}

impl Support {
    /// Whether each entry of a squeeze film is given.
    pub fn film_entries(&self) -> [(&'static str, bool); 6] {
        given![self; diameter, length, clearance, viscosity, film, ruptures]
    }
}

/// An elastic body by its vibration modes with unit modal mass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElasticBody {
    /// Natural frequency of each mode, rad/s; zero for a rigid-body motion.
    pub frequencies: Vec<f64>,
    /// Damping ratio of each mode.
    pub damping_ratios: Vec<f64>,
    /// Interfaces and points of measurement by name.
    pub interfaces: BTreeMap<String, Interface>,
    /// Modal coordinates of a translation of the whole body along x, y and z; a body that is clamped has none.
    pub translation: Option<[Vec<f64>; 3]>,
    /// ∫ n nᵀ dA of the displacements n along the normal of the surface per unit of each modal coordinate, m²/kg, for the power that it
    /// radiates; a body without a surface has none.
    pub radiation: Option<Vec<Vec<f64>>>,
}

/// A place of an elastic body: a bearing seat, a foot or a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interface {
    /// Position (x, y, z), m.
    pub position: [f64; 3],
    /// Displacements along x, y and z, 1/√kg, and rotations about them, 1/(m √kg), per unit of each modal coordinate.
    pub rows: [Vec<f64>; 6],
    /// Stiffness to the ground along x, y and z, N/m.
    pub stiffness: Option<[f64; 3]>,
    /// Damping to the ground along x, y and z, N s/m.
    pub damping: Option<[f64; 3]>,
}

/// A rigid body on springs and dampers that carries several bearings, or an elastic one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Housing {
    /// Name; unique in the system.
    pub name: String,
    /// Mass, kg.
    pub mass: f64,
    /// Stiffness to the ground over (y, z) at the centre of mass, N/m.
    pub stiffness: Coefficient,
    /// Damping to the ground over (y, z) at the centre of mass, N s/m.
    pub damping: Option<Coefficient>,
    /// Stiffness to the ground along the axis, N/m; without it, the housing does not move along the axis.
    pub axial_stiffness: Option<f64>,
    /// Damping to the ground along the axis, N s/m.
    pub axial_damping: Option<f64>,
    /// Loss factor η of its stiffness, K(1 + iη sgn ω), which analyses in the frequency domain contain.
    pub loss_factor: Option<f64>,
    /// Moments of inertia about the axes through the centre of mass parallel to x, y and z, kg m²; without them the
    /// housing does not rotate.
    pub inertia: Option<[f64; 3]>,
    /// Centre of mass (x, y, z), m; the origin is the left end of the first shaft.
    pub position: Option<[f64; 3]>,
    /// Stiffness to the ground about x, y and z, N m/rad.
    pub rotational_stiffness: Option<[f64; 3]>,
    /// Damping to the ground about x, y and z, N m s/rad.
    pub rotational_damping: Option<[f64; 3]>,
    /// Points (x, y, z) whose motion can be recorded, m, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub points: BTreeMap<String, [f64; 3]>,
    /// The modes of an elastic body, which has no stiffness, inertia or points of its own.
    pub elastic: Option<ElasticBody>,
}

/// What a bearing stands on: the name of a support or housing, its own support, an interface of an elastic housing, or a place of
/// another shaft.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Base {
    /// Name of a support or housing.
    Named(String),
    /// A support of this bearing alone.
    Own(Support),
    /// Name of an elastic housing and of its interface.
    Interface(String, String),
    /// Name of another shaft and position on it, m.
    Shaft(String, f64),
}

/// The second entry of a pair: a position, m, or the name of an interface.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected a position [m] or the name of an interface")]
enum Within {
    Position(f64),
    Interface(String),
}

/// Not derived: an error inside a support names the field; an untagged enum only says that no variant fits.
impl<'de> Deserialize<'de> for Base {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Reader;

        impl<'de> Visitor<'de> for Reader {
            type Value = Base;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str(
                    "the name of a support or housing, a support, or a pair [shaft, position] or [housing, interface]",
                )
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Base, E> {
                Ok(Base::Named(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Base, A::Error> {
                Support::deserialize(MapAccessDeserializer::new(map)).map(Base::Own)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Base, A::Error> {
                let missing = |length: usize| A::Error::invalid_length(length, &self);
                let part = list.next_element()?.ok_or_else(|| missing(0))?;
                let within = list.next_element()?.ok_or_else(|| missing(1))?;
                if list.next_element::<IgnoredAny>()?.is_some() {
                    return Err(missing(3));
                }
                Ok(match within {
                    Within::Position(position) => Base::Shaft(part, position),
                    Within::Interface(name) => Base::Interface(part, name),
                })
            }
        }

        source.deserialize_any(Reader)
    }
}
