//! The one table of parameters: declaration, validation and documentation follow from it.

use super::value::{Kind, Value};

/// One parameter: all that is to be known of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Full name, such as `geometry.length_below`.
    pub name: &'static str,
    /// SI unit; empty where there is none.
    pub unit: &'static str,
    /// Value where none is given.
    pub default: DefaultValue,
    /// Which values it may have.
    pub admissible: Admissible,
    /// When a change takes effect in the running node.
    pub applies: Applies,
    /// What it is, beginning with its symbol in the paper where it has one.
    pub meaning: &'static str,
}

/// A parameter's default, in a form that a constant can have.
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
}

/// The values that a parameter may have; all bounds are inclusive.
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
    /// A finite number.
    Real {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// A finite number, or 0 with a meaning of its own.
    RealOrZero {
        /// Smallest that is not 0.
        min: f64,
        /// Largest.
        max: f64,
        /// What 0 stands for.
        zero: &'static str,
    },
    /// A duration in seconds that is a whole number of nanoseconds.
    WholeNanoseconds {
        /// Shortest \[s\].
        min: f64,
        /// Longest \[s\].
        max: f64,
    },
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A text without control characters.
    Text {
        /// Fewest characters.
        min_chars: usize,
        /// Most characters.
        max_chars: usize,
    },
    /// A section of the [catalogue](super::catalogue()), or empty.
    SectionName,
    /// One of the [steel grades](super::STEEL_GRADES), or empty.
    SteelGrade,
    /// A [list of processors](super::processors()), or empty.
    Processors,
}

/// When a change takes effect in the running node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Applies {
    /// At once, from the next event, sample or picture on.
    AtOnce,
    /// At once while the column is at rest, else when the present response is over.
    AfterResponse,
    /// Only when the node starts: read-only while it runs.
    Restart,
}

impl Parameter {
    /// The parameter of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::index_of(name).map(|index| &PARAMETERS[index])
    }

    /// Its place in [`PARAMETERS`].
    pub(super) fn index_of(name: &str) -> Option<usize> {
        PARAMETERS
            .iter()
            .position(|parameter| parameter.name == name)
    }

    /// The names that are nearest to a misspelt one, nearest first, at most three.
    ///
    /// A name without its group (`velocity`) is taken for what it most likely is (`impact.velocity`).
    #[must_use]
    pub fn nearest(name: &str) -> Vec<&'static str> {
        if !super::may_be_misspelt(name) {
            return Vec::new();
        }
        let wanted = name.to_ascii_lowercase().replace('/', ".");
        let mut ranked: Vec<_> = PARAMETERS
            .iter()
            .map(|parameter| {
                let whole = strsim::normalized_damerau_levenshtein(&wanted, parameter.name);
                let last = parameter.name.rsplit('.').next().unwrap_or(parameter.name);
                let wanted_last = wanted.rsplit('.').next().unwrap_or(&wanted);
                // A wrong or missing group weighs less than a wrong name within it.
                let within = 0.9 * strsim::normalized_damerau_levenshtein(wanted_last, last);
                (whole.max(within), parameter.name)
            })
            .filter(|(score, _)| *score >= 0.6)
            .collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best = ranked.first().map_or(0.0, |(score, _)| *score);
        ranked
            .into_iter()
            .take_while(|(score, _)| *score >= best - 0.05)
            .map(|(_, name)| name)
            .take(3)
            .collect()
    }

    /// The parameters of the group of this name, such as `impact`; none where there is no such group.
    pub fn in_group(group: &str) -> impl Iterator<Item = &'static Self> {
        PARAMETERS.iter().filter(move |parameter| {
            parameter
                .name
                .strip_prefix(group)
                .is_some_and(|rest| rest.starts_with('.'))
        })
    }

    /// Type of its values.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self.admissible {
            Admissible::Switch => Kind::Bool,
            Admissible::Integer { .. } => Kind::Integer,
            Admissible::Real { .. }
            | Admissible::RealOrZero { .. }
            | Admissible::WholeNanoseconds { .. } => Kind::Double,
            Admissible::Choice(_)
            | Admissible::Text { .. }
            | Admissible::SectionName
            | Admissible::SteelGrade
            | Admissible::Processors => Kind::String,
        }
    }

    /// Its default as a value.
    #[must_use]
    pub fn default_value(&self) -> Value {
        match self.default {
            DefaultValue::Bool(value) => Value::Bool(value),
            DefaultValue::Integer(value) => Value::Integer(value),
            DefaultValue::Double(value) => Value::Double(value),
            DefaultValue::Text(text) => Value::from(text),
        }
    }

    /// Whether a running node refuses to change it.
    #[must_use]
    pub fn read_only(&self) -> bool {
        self.applies == Applies::Restart
    }
}

const LENGTH: Admissible = Admissible::Real {
    min: 0.02,
    max: 100.0,
};
const EXPONENT: Admissible = Admissible::Real {
    min: 1.0,
    max: 50.0,
};
const FROM_SECTION: &str = "from `section.name`";
const FROM_SUPPORTS: &str = "from the supports";
const SUPPORT: Admissible = Admissible::Choice(&["built_in", "pinned", "semi_rigid"]);
const SUPPORT_STIFFNESS: Admissible = Admissible::RealOrZero {
    min: 1.0,
    max: 1e13,
    zero: "not semi-rigid",
};
const HINGE_STIFFNESS: Admissible = Admissible::RealOrZero {
    min: 1.0,
    max: 1e13,
    zero: FROM_SUPPORTS,
};
const DIRECTORY: Admissible = Admissible::Text {
    min_chars: 1,
    max_chars: 4096,
};
const IDENTIFIER: Admissible = Admissible::Text {
    min_chars: 1,
    max_chars: 255,
};

/// Every parameter, in the order in which they are shown.
pub const PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "column_id",
        unit: "",
        default: DefaultValue::Text("column"),
        admissible: IDENTIFIER,
        applies: Applies::Restart,
        meaning: "name of the column in messages; events for another one are not taken",
    },
    Parameter {
        name: "frame_id",
        unit: "",
        default: DefaultValue::Text("column"),
        admissible: IDENTIFIER,
        applies: Applies::Restart,
        meaning: "coordinate frame of the column in messages, its origin at the base",
    },
    Parameter {
        name: "publish_rate",
        unit: "Hz",
        default: DefaultValue::Double(1000.0),
        admissible: Admissible::Real {
            min: 1.0,
            max: 10_000.0,
        },
        applies: Applies::AfterResponse,
        meaning: "how often state and hinge forces are published during a response; at most once per step, the period \
                  rounded to whole steps",
    },
    Parameter {
        name: "use_sim_time",
        unit: "",
        default: DefaultValue::Bool(false),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "take the time from the topic /clock, as in every ROS 2 node",
    },
    Parameter {
        name: "geometry.length_below",
        unit: "m",
        default: DefaultValue::Double(1.0),
        admissible: LENGTH,
        applies: Applies::AfterResponse,
        meaning: "L_a: height of the impact point above the base",
    },
    Parameter {
        name: "geometry.length_above",
        unit: "m",
        default: DefaultValue::Double(3.0),
        admissible: LENGTH,
        applies: Applies::AfterResponse,
        meaning: "L_b: from the impact point to the top",
    },
    Parameter {
        name: "section.name",
        unit: "",
        default: DefaultValue::Text("HEB220"),
        admissible: Admissible::SectionName,
        applies: Applies::AfterResponse,
        meaning: "rolled section, bent about its strong axis; empty = given by numbers. Where files and overrides do not \
                  name one but give one of its numbers, it is empty",
    },
    Parameter {
        name: "section.area",
        unit: "m^2",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-5,
            max: 1.0,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "A: area; a number overrides this one property of a named section",
    },
    Parameter {
        name: "section.second_moment",
        unit: "m^4",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e-10,
            max: 1.0,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "I: second moment of area; a number overrides this one property of a named section",
    },
    Parameter {
        name: "section.mass_per_length",
        unit: "kg/m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 0.01,
            max: 1e5,
            zero: FROM_SECTION,
        },
        applies: Applies::AfterResponse,
        meaning: "m_l: mass per length; a number overrides this one property of a named section",
    },
    Parameter {
        name: "steel.grade",
        unit: "",
        default: DefaultValue::Text("S355"),
        admissible: Admissible::SteelGrade,
        applies: Applies::AfterResponse,
        meaning: "steel grade, nominal values for thicknesses up to 40 mm (EN 1993-1-1, table 3.1); empty = given by \
                  numbers. Where files and overrides do not name one but give one of its numbers, it is empty",
    },
    Parameter {
        name: "steel.young_modulus",
        unit: "Pa",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e9,
            max: 1e12,
            zero: "from `steel.grade`",
        },
        applies: Applies::AfterResponse,
        meaning: "E: Young's modulus; a number overrides this one property of a named grade",
    },
    Parameter {
        name: "steel.yield_strength",
        unit: "Pa",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1e6,
            max: 1e10,
            zero: "from `steel.grade`",
        },
        applies: Applies::AfterResponse,
        meaning: "f_y: yield strength; a number overrides this one property of a named grade",
    },
    Parameter {
        name: "resistance.moment",
        unit: "N m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 1.0,
            max: 1e10,
            zero: "W_pl f_y, which needs `section.name`",
        },
        applies: Applies::AfterResponse,
        meaning: "M^p: plastic moment without normal force",
    },
    Parameter {
        name: "resistance.axial",
        unit: "N",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 100.0,
            max: 1e11,
            zero: "A f_y",
        },
        applies: Applies::AfterResponse,
        meaning: "N^p: squash load",
    },
    Parameter {
        name: "yield_surface.alpha",
        unit: "",
        default: DefaultValue::Double(1.0),
        admissible: EXPONENT,
        applies: Applies::AfterResponse,
        meaning: "alpha: exponent of the moment (Eq 28); 1 with beta = 1.3 is Duan-Chen, 2 with beta = 2 an ellipse",
    },
    Parameter {
        name: "yield_surface.beta",
        unit: "",
        default: DefaultValue::Double(1.3),
        admissible: EXPONENT,
        applies: Applies::AfterResponse,
        meaning: "beta: exponent of the normal force (Eq 28)",
    },
    Parameter {
        name: "yield_surface.gamma",
        unit: "",
        default: DefaultValue::Double(1.0),
        admissible: Admissible::Real {
            min: 0.01,
            max: 100.0,
        },
        applies: Applies::AfterResponse,
        meaning: "gamma: the whole sum has the exponent 1/gamma (Eq 28), which scales the plastic multiplier but not the \
                  surface",
    },
    Parameter {
        name: "hinge.elastic_law",
        unit: "",
        default: DefaultValue::Text("coupled"),
        admissible: Admissible::Choice(&["uncoupled", "coupled"]),
        applies: Applies::AfterResponse,
        meaning: "uncoupled: the paper's independent springs (Eqs 47-48); coupled: the elastic beam, exact for any rotations",
    },
    Parameter {
        name: "hinge.stiffness_1a",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: HINGE_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of hinge 1a, below the impact point; only with the uncoupled law",
    },
    Parameter {
        name: "hinge.stiffness_1b",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: HINGE_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of hinge 1b, above the impact point; only with the uncoupled law",
    },
    Parameter {
        name: "hinge.stiffness_2",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: HINGE_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of hinge 2, at the top; only with the uncoupled law and a built-in top",
    },
    Parameter {
        name: "hinge.stiffness_3",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: HINGE_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of hinge 3, at the base; only with the uncoupled law and a built-in base",
    },
    Parameter {
        name: "support.base",
        unit: "",
        default: DefaultValue::Text("built_in"),
        admissible: SUPPORT,
        applies: Applies::AfterResponse,
        meaning: "rotational support of the base",
    },
    Parameter {
        name: "support.base_stiffness",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: SUPPORT_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of a semi-rigid base",
    },
    Parameter {
        name: "support.top",
        unit: "",
        default: DefaultValue::Text("built_in"),
        admissible: SUPPORT,
        applies: Applies::AfterResponse,
        meaning: "rotational support of the top",
    },
    Parameter {
        name: "support.top_stiffness",
        unit: "N m/rad",
        default: DefaultValue::Double(0.0),
        admissible: SUPPORT_STIFFNESS,
        applies: Applies::AfterResponse,
        meaning: "rotational stiffness of a semi-rigid top",
    },
    Parameter {
        name: "top.spring_stiffness",
        unit: "N/m",
        default: DefaultValue::Double(1e7),
        admissible: Admissible::Real {
            min: 0.0,
            max: 1e13,
        },
        applies: Applies::AfterResponse,
        meaning: "k_s: vertical spring at the top, the rest of the structure",
    },
    Parameter {
        name: "top.mass",
        unit: "kg",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real { min: 0.0, max: 1e7 },
        applies: Applies::AfterResponse,
        meaning: "m_2: mass at the top",
    },
    Parameter {
        name: "top.load",
        unit: "N",
        default: DefaultValue::Double(5e5),
        admissible: Admissible::Real { min: 0.0, max: 1e9 },
        applies: Applies::AfterResponse,
        meaning: "P: constant load on the top, positive in compression",
    },
    Parameter {
        name: "impact.mass",
        unit: "kg",
        default: DefaultValue::Double(1500.0),
        admissible: Admissible::Real {
            min: 1e-3,
            max: 1e6,
        },
        applies: Applies::AtOnce,
        meaning: "m_c: mass of the impactor",
    },
    Parameter {
        name: "impact.velocity",
        unit: "m/s",
        default: DefaultValue::Double(10.0),
        admissible: Admissible::Real {
            min: 1e-6,
            max: 60.0,
        },
        applies: Applies::AtOnce,
        meaning: "v_c: speed of the impactor over the ground, positive towards the column",
    },
    Parameter {
        name: "impact.gap",
        unit: "m",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real {
            min: 0.0,
            max: 100.0,
        },
        applies: Applies::AtOnce,
        meaning: "g_N: initial distance between impactor and column",
    },
    Parameter {
        name: "impact.restitution",
        unit: "",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real { min: 0.0, max: 1.0 },
        applies: Applies::AtOnce,
        meaning: "epsilon: coefficient of restitution of Newton's impact law, 0 = inelastic, 1 = elastic",
    },
    Parameter {
        name: "event.max_age",
        unit: "s",
        default: DefaultValue::Double(5.0),
        admissible: Admissible::Real {
            min: 1e-3,
            max: 3600.0,
        },
        applies: Applies::AtOnce,
        meaning: "how far the stamp of an impact event may lie in the past; an older event is refused, a younger one caught \
                  up",
    },
    Parameter {
        name: "event.max_ahead",
        unit: "s",
        default: DefaultValue::Double(1.0),
        admissible: Admissible::Real {
            min: 0.0,
            max: 60.0,
        },
        applies: Applies::AtOnce,
        meaning: "how far the stamp of an impact event may lie in the future; one further ahead is refused",
    },
    Parameter {
        name: "solver.scheme",
        unit: "",
        default: DefaultValue::Text("energy"),
        admissible: Admissible::Choice(&["midpoint", "energy"]),
        applies: Applies::AfterResponse,
        meaning: "midpoint: the paper's rule as printed; energy: its energy-conserving sibling",
    },
    Parameter {
        name: "solver.dt",
        unit: "s",
        default: DefaultValue::Double(2e-5),
        admissible: Admissible::WholeNanoseconds {
            min: 1e-7,
            max: 1e-3,
        },
        applies: Applies::AfterResponse,
        meaning: "length of a time step",
    },
    Parameter {
        name: "damping.ratio",
        unit: "",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::Real { min: 0.0, max: 1.0 },
        applies: Applies::AfterResponse,
        meaning: "fraction of critical damping of the elastic modes; the paper has none",
    },
    Parameter {
        name: "response.duration",
        unit: "s",
        default: DefaultValue::Double(2.0),
        admissible: Admissible::Real {
            min: 1e-3,
            max: 600.0,
        },
        applies: Applies::AfterResponse,
        meaning: "longest response that is computed, if it is not over before",
    },
    Parameter {
        name: "state.directory",
        unit: "",
        default: DefaultValue::Text("state"),
        admissible: Admissible::Text {
            min_chars: 0,
            max_chars: 4096,
        },
        applies: Applies::Restart,
        meaning: "where the file stands that carries the damage over a restart, named after the column; empty = the damage \
                  ends with the program",
    },
    Parameter {
        name: "real_time.priority",
        unit: "",
        default: DefaultValue::Integer(50),
        admissible: Admissible::Integer { min: 0, max: 99 },
        applies: Applies::Restart,
        meaning: "priority of the solver's thread under SCHED_FIFO, where the system permits it, the publishing thread one below; \
                  0 = as every thread",
    },
    Parameter {
        name: "real_time.processors",
        unit: "",
        default: DefaultValue::Text(""),
        admissible: Admissible::Processors,
        applies: Applies::Restart,
        meaning: "the processors that the solver's thread may run on; empty = all",
    },
    Parameter {
        name: "real_time.lock_memory",
        unit: "",
        default: DefaultValue::Bool(true),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "keep the program's memory from being swapped out, where the system permits it",
    },
    Parameter {
        name: "record.mode",
        unit: "",
        default: DefaultValue::Text("off"),
        admissible: Admissible::Choice(&["off", "events", "always"]),
        applies: Applies::Restart,
        meaning: "what is recorded: nothing, every event with its response, or everything",
    },
    Parameter {
        name: "record.directory",
        unit: "",
        default: DefaultValue::Text("recordings"),
        admissible: DIRECTORY,
        applies: Applies::Restart,
        meaning: "where recordings are written",
    },
    Parameter {
        name: "record.max_file_size",
        unit: "B",
        default: DefaultValue::Integer(1_000_000_000),
        admissible: Admissible::Integer {
            min: 1_000_000,
            max: 1_000_000_000_000,
        },
        applies: Applies::Restart,
        meaning: "size at which a recording goes on in a new one, when the column is at rest; at twice the size in any case",
    },
    Parameter {
        name: "record.max_duration",
        unit: "s",
        default: DefaultValue::Double(3600.0),
        admissible: Admissible::RealOrZero {
            min: 1.0,
            max: 1e9,
            zero: "no limit",
        },
        applies: Applies::Restart,
        meaning: "age at which a recording goes on in a new one, when the column is at rest; at twice the age in any case",
    },
    Parameter {
        name: "record.max_files",
        unit: "",
        default: DefaultValue::Integer(100),
        admissible: Admissible::Integer {
            min: 0,
            max: 1_000_000,
        },
        applies: Applies::Restart,
        meaning: "most recordings that are kept, the oldest are deleted; 0 = no limit",
    },
    Parameter {
        name: "record.max_total_size",
        unit: "B",
        default: DefaultValue::Integer(0),
        admissible: Admissible::Integer {
            min: 0,
            max: 1_000_000_000_000_000,
        },
        applies: Applies::Restart,
        meaning: "most bytes of all recordings together that are kept, the oldest are deleted; 0 = no limit",
    },
    Parameter {
        name: "record.max_age",
        unit: "s",
        default: DefaultValue::Double(0.0),
        admissible: Admissible::RealOrZero {
            min: 60.0,
            max: 1e9,
            zero: "no limit",
        },
        applies: Applies::Restart,
        meaning: "age at which a recording is deleted",
    },
    Parameter {
        name: "record.compression",
        unit: "",
        default: DefaultValue::Text("none"),
        admissible: Admissible::Choice(&["none", "lz4", "zstd"]),
        applies: Applies::Restart,
        meaning: "compression of the chunks of a recording",
    },
    Parameter {
        name: "record.sync",
        unit: "",
        default: DefaultValue::Bool(true),
        admissible: Admissible::Switch,
        applies: Applies::Restart,
        meaning: "whether what was recorded 50 ms ago survives a loss of power, too, and not only the end of the program",
    },
    Parameter {
        name: "viewer.mode",
        unit: "",
        default: DefaultValue::Text("off"),
        admissible: Admissible::Choice(&["off", "save", "serve", "connect", "spawn"]),
        applies: Applies::Restart,
        meaning: "where the pictures go: nowhere, into a file, to viewers that connect here, to a viewer that runs, to one \
                  that is started",
    },
    Parameter {
        name: "viewer.address",
        unit: "",
        default: DefaultValue::Text("127.0.0.1"),
        admissible: IDENTIFIER,
        applies: Applies::Restart,
        meaning: "address to serve on or to connect to",
    },
    Parameter {
        name: "viewer.port",
        unit: "",
        default: DefaultValue::Integer(9876),
        admissible: Admissible::Integer {
            min: 1,
            max: 65_535,
        },
        applies: Applies::Restart,
        meaning: "TCP port to serve on or to connect to",
    },
    Parameter {
        name: "viewer.directory",
        unit: "",
        default: DefaultValue::Text("recordings"),
        admissible: DIRECTORY,
        applies: Applies::Restart,
        meaning: "where `save` writes its files",
    },
    Parameter {
        name: "viewer.memory_limit",
        unit: "B",
        default: DefaultValue::Integer(256_000_000),
        admissible: Admissible::Integer {
            min: 1_000_000,
            max: 64_000_000_000,
        },
        applies: Applies::Restart,
        meaning: "memory for viewers that come late or come back (serve, connect, spawn); the oldest data go first",
    },
    Parameter {
        name: "viewer.magnification",
        unit: "",
        default: DefaultValue::Double(1.0),
        admissible: Admissible::Real {
            min: 1.0,
            max: 1000.0,
        },
        applies: Applies::AtOnce,
        meaning: "factor on the displacements that are drawn; 1 = true to scale",
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_each_entry_is_complete() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            assert_eq!(
                PARAMETERS
                    .iter()
                    .position(|other| other.name == parameter.name),
                Some(index)
            );
            assert_eq!(
                parameter.default_value().kind(),
                parameter.kind(),
                "{}",
                parameter.name
            );
            assert!(
                !parameter.meaning.is_empty() && !parameter.meaning.ends_with('.'),
                "{}",
                parameter.name
            );
        }
    }

    #[test]
    fn nearest_names() {
        for (wrong, right) in [
            ("impact.velocty", "impact.velocity"),
            ("velocity", "impact.velocity"),
            ("impact/mass", "impact.mass"),
            ("Section.Name", "section.name"),
            ("section.nam", "section.name"),
            ("length_above", "geometry.length_above"),
            ("steel.fy", ""),
            ("impact.speed", ""),
            ("solver.time_step", ""),
            ("dt", "solver.dt"),
            ("yield_surface.aplha", "yield_surface.alpha"),
            ("a.a.velocty", "impact.velocity"),
            (&format!("{}velocty", "a.".repeat(40)), ""), // longer than is looked at
            ("support.base_stifness", "support.base_stiffness"),
        ] {
            assert_eq!(
                Parameter::nearest(wrong).first().copied().unwrap_or(""),
                right,
                "{wrong}"
            );
        }
    }
}
