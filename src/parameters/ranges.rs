//! Ranges and texts that several rows of the parameter table share.

use std::ops::RangeInclusive;

use super::parameter::Admissible;
use crate::sensors::MAX_SENSORS;

/// Most columns of a fleet that the viewer always shows in full: each has some thirty views and curves of its own.
pub const MAX_SELECTED_COLUMNS: usize = 8;

/// Lengths that a bar may have \[m\].
pub(super) const LENGTH_RANGE: RangeInclusive<f64> = 0.02..=100.0;
pub(super) const LENGTH: Admissible = Admissible::Real {
    min: *LENGTH_RANGE.start(),
    max: *LENGTH_RANGE.end(),
};
/// A position in a plan: a site, not a country, so that millimetres remain in the pictures.
pub(super) const SITE: Admissible = Admissible::Real {
    min: -100_000.0,
    max: 100_000.0,
};
pub(super) const EXPONENT: Admissible = Admissible::Real {
    min: 1.0,
    max: 50.0,
};
pub(super) const FROM_SECTION: &str = "from `section.name`";
const FROM_SUPPORTS: &str = "from the supports";
pub(super) const SUPPORT: Admissible = Admissible::Choice(&["built_in", "pinned", "semi_rigid"]);
pub(super) const TOP_SUPPORT: Admissible =
    Admissible::Choice(&["built_in", "pinned", "semi_rigid", "free"]);
pub(super) const SUPPORT_STIFFNESS: Admissible = Admissible::RealOrZero {
    min: 1.0,
    max: 1e13,
    zero: "not semi-rigid",
};
pub(super) const HINGE_STIFFNESS: Admissible = Admissible::RealOrZero {
    min: 1.0,
    max: 1e13,
    zero: FROM_SUPPORTS,
};
pub(super) const DIRECTORY: Admissible = Admissible::Text {
    min_chars: 1,
    max_chars: 4096,
};
pub(super) const OPTIONAL_PATH: Admissible = Admissible::Text {
    min_chars: 0,
    max_chars: 4096,
};
pub(super) const IDENTIFIER: Admissible = Admissible::Text {
    min_chars: 1,
    max_chars: 255,
};

/// Most points of a force-crush curve that parameters give: a narrow object adds some to them.
const MAX_POINTS: usize = 16;
pub(super) const CURVE_CRUSH: Admissible = Admissible::List {
    of: &Admissible::Real {
        min: 1e-6,
        max: 20.0,
    },
    min_len: 0,
    max_len: MAX_POINTS,
};
pub(super) const CURVE_FORCE: Admissible = Admissible::List {
    of: &Admissible::Real { min: 0.0, max: 1e9 },
    min_len: 0,
    max_len: MAX_POINTS,
};
pub(super) const SENSOR_NAMES: Admissible = Admissible::List {
    of: &Admissible::SensorName,
    min_len: 0,
    max_len: MAX_SENSORS,
};
pub(super) const UNLOADING_STIFFNESS: Admissible = Admissible::RealOrZero {
    min: 1.0,
    max: 1e12,
    zero: "not given",
};
pub(super) const SELECTED_COLUMNS: Admissible = Admissible::List {
    of: &IDENTIFIER,
    min_len: 0,
    max_len: MAX_SELECTED_COLUMNS,
};
