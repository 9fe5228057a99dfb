//! A parameter: its type, its admissible values, when a change applies.

use super::value::{Kind, Value};

/// One parameter with everything that is known about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Full name, such as `geometry.length_below`; of a parameter that every sensor has, with `<name>` in the place of the
    /// sensor's name.
    pub name: &'static str,
    /// SI unit, of an array that of its elements; empty where there is none.
    pub unit: &'static str,
    /// Value if none is given.
    pub default: DefaultValue,
    /// Admissible values.
    pub admissible: Admissible,
    /// When a change takes effect in the running node.
    pub applies: Applies,
    /// Description, beginning with the symbol in the paper where there is one.
    pub meaning: &'static str,
}

// Rows of the table: name, unit, default, admissible values, when a change applies; meaning.
macro_rules! parameters {
    ($($name:literal, $unit:literal, $default:ident $value:tt, $admissible:expr, $applies:ident, $meaning:literal;)*) => {
        &[$(Parameter {
            name: $name,
            unit: $unit,
            default: DefaultValue::$default $value,
            admissible: $admissible,
            applies: Applies::$applies,
            meaning: $meaning,
        }),*]
    };
}
pub(super) use parameters;

/// Default of a parameter, in a form that a constant can hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DefaultValue {
    /// See [`Value::Bool`].
    Bool(bool),
    /// See [`Value::Integer`].
    Integer(i64),
    /// See [`Value::Double`].
    Double(f64),
    /// See [`Value::String`].
    Text(&'static str),
    /// See [`Value::DoubleArray`].
    Numbers(&'static [f64]),
    /// See [`Value::StringArray`].
    Texts(&'static [&'static str]),
    /// There is none: the parameter must be given. Of this type; 0 or empty where a value is needed nevertheless.
    Required(Kind),
}

/// Admissible values of a parameter; all bounds are inclusive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Admissible {
    /// `true` or `false`.
    Switch,
    /// A whole number.
    Integer {
        /// Smallest.
        min: i64,
        /// Largest.
        max: i64,
    },
    /// 1 or -1.
    Sign,
    /// A finite number.
    Real {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A finite number, or 0 with a special meaning.
    RealOrZero {
        /// Smallest apart from 0.
        min: f64,
        /// Largest.
        max: f64,
        /// Meaning of 0.
        zero: &'static str,
    },
    /// A finite number, or 0 or NaN, which both become 0: left open.
    RealOrOpen {
        /// Smallest apart from 0.
        min: f64,
        /// Largest.
        max: f64,
        /// Meaning of 0.
        open: &'static str,
    },
    /// A duration in seconds that is a whole number of nanoseconds, or 0 with a special meaning.
    WholeNanoseconds {
        /// Shortest apart from 0 \[s\].
        min: f64,
        /// Longest \[s\].
        max: f64,
        /// Meaning of 0.
        zero: &'static str,
    },
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A string without control characters.
    Text {
        /// Minimum number of characters.
        min_chars: usize,
        /// Maximum number of characters.
        max_chars: usize,
    },
    /// A section of the [catalogue](super::catalogue()), or the empty string.
    SectionName,
    /// [`RIGID`](super::RIGID), a vehicle of the [catalogue](super::vehicle_catalogue()), or the empty string.
    VehicleName,
    /// One of the [steel grades](super::STEEL_GRADES), or the empty string.
    SteelGrade,
    /// A [list of processors](super::processors()), or the empty string.
    Processors,
    /// An [allowed sender](super::AllowedSender).
    Sender,
    /// The name of a sensor.
    SensorName,
    /// An array of numbers or of strings.
    List {
        /// Admissible values of every element: numbers or strings.
        of: &'static Admissible,
        /// Minimum number of elements.
        min_len: usize,
        /// Maximum number of elements.
        max_len: usize,
    },
}

pub(super) const fn integer(min: i64, max: i64) -> Admissible {
    Admissible::Integer { min, max }
}

pub(super) const fn real(min: f64, max: f64) -> Admissible {
    Admissible::Real { min, max }
}

pub(super) const fn or_zero(min: f64, max: f64, zero: &'static str) -> Admissible {
    Admissible::RealOrZero { min, max, zero }
}

pub(super) const fn text(min_chars: usize, max_chars: usize) -> Admissible {
    Admissible::Text {
        min_chars,
        max_chars,
    }
}

pub(super) const fn list(of: &'static Admissible, min_len: usize, max_len: usize) -> Admissible {
    Admissible::List {
        of,
        min_len,
        max_len,
    }
}

/// A parameter that a set of parameters has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeclaredParameter<'a> {
    /// Full name, such as `geometry.length_below` or `sensors.top_laser.height`.
    pub name: &'a str,
    /// Its row in the table, which every sensor shares.
    pub row: &'static Parameter,
}

/// When a change takes effect in the running node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Applies {
    /// Immediately: from the next event, sample or picture on.
    AtOnce,
    /// Immediately while the column is at rest, otherwise when the current response is over.
    AfterResponse,
    /// Only when the node starts; the parameter is read-only while it runs.
    Restart,
}

impl Parameter {
    /// Type of its values.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.admissible.kind()
    }

    /// Its default as a value.
    #[must_use]
    pub fn default_value(&self) -> Value {
        match self.default {
            DefaultValue::Bool(value) => Value::Bool(value),
            DefaultValue::Integer(value) => Value::Integer(value),
            DefaultValue::Double(value) => Value::Double(value),
            DefaultValue::Text(text) => Value::from(text),
            DefaultValue::Numbers(numbers) => Value::from(numbers.to_vec()),
            DefaultValue::Texts(texts) => {
                Value::StringArray(texts.iter().map(|it| (*it).to_owned()).collect())
            }
            DefaultValue::Required(kind) => match kind {
                Kind::Bool => Value::Bool(false),
                Kind::Integer => Value::Integer(0),
                Kind::Double => Value::Double(0.0),
                Kind::String => Value::from(""),
                Kind::DoubleArray => Value::DoubleArray(vec![]),
                Kind::StringArray => Value::StringArray(vec![]),
            },
        }
    }

    /// Whether it cannot be changed while the node runs.
    #[must_use]
    pub fn read_only(&self) -> bool {
        self.applies == Applies::Restart
    }
}

impl Admissible {
    /// Type of the values.
    pub(super) const fn kind(&self) -> Kind {
        match self {
            Self::Switch => Kind::Bool,
            Self::Integer { .. } | Self::Sign => Kind::Integer,
            Self::Real { .. }
            | Self::RealOrZero { .. }
            | Self::RealOrOpen { .. }
            | Self::WholeNanoseconds { .. } => Kind::Double,
            Self::Choice(_)
            | Self::Text { .. }
            | Self::SectionName
            | Self::VehicleName
            | Self::SteelGrade
            | Self::Processors
            | Self::Sender
            | Self::SensorName => Kind::String,
            Self::List { of, .. } => match of.kind() {
                Kind::Double => Kind::DoubleArray,
                Kind::String => Kind::StringArray,
                _ => panic!("the elements of an array are numbers or strings"),
            },
        }
    }
}
